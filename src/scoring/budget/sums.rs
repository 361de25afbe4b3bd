//! One pass over the samples: products of the columns, summed over the blocks of each unit.

use std::ops::Range;

use faer::Mat;
use rayon::prelude::*;

use crate::{
    calibration::NormalEquations,
    progress::{Cancelled, Progress},
    scoring::{
        budget::{
            cause::Cause,
            columns::{Columns, Rows},
            held_out::{picked, solve},
            noise::{CHUNK, Noise},
            run::{Model, Run, Unit},
        },
        inverse::inverse_above,
    },
};

/// Number of samples whose rows are in memory at the same time. It contains whole chunks.
const WINDOW: usize = 40 * CHUNK;
/// Approximate maximum number of samples whose products are summed. Of more samples, every n-th is used; the columns still see
/// every sample.
const MOST_SAMPLES: usize = 1 << 19;
/// Standard deviation below which a column is left out, absolute and as a share of its mean.
const CONSTANT: f64 = 1e-9;
const CONSTANT_SHARE: f64 = 1e-7;
/// Share of the gauges' mean noise that is added to each, so that gauges without noise can be inverted.
const LEAST_NOISE: f64 = 1e-9;
const UNDETERMINED: f64 = 1e-9;

/// Sums of products of the standardised columns.
#[derive(Debug)]
pub struct Sums {
    /// Products of all columns with each other, one matrix for each block.
    pub blocks: Vec<Mat<f64>>,
    /// Number of samples of each block.
    pub n_samples: Vec<f64>,
    /// Columns of the compensation that vary.
    pub model: Vec<usize>,
    /// Columns of each cause that vary.
    pub of_causes: Vec<(Cause, Vec<usize>)>,
    pub noise: Option<NoiseSums>,
}

/// Noise that any coefficients pass on to their residuals.
#[derive(Debug)]
pub struct NoiseSums {
    /// Mean products of the differences of all columns.
    pub differences: Mat<f64>,
    /// Factor of each axis by which the differences of the conventional residuals become their noise.
    pub scales: Vec<f64>,
    /// Noise of the unbiased calibration that passes on least noise.
    pub floor: Vec<f64>,
}

impl Sums {
    pub fn collect(
        runs: &[Run<'_>],
        columns: &Columns,
        model: Option<Model<'_>>,
        (units, noise): (&[Unit], Option<Noise>),
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let n: usize = runs.iter().map(|run| run.n_samples).sum();
        let step = n.div_ceil(MOST_SAMPLES).max(1);
        let of_run = |at: usize| {
            progress.check()?;
            let mut rows = Rows::new(columns, runs, at, model);
            let mut of_differences = NormalEquations::new(columns.width, 0);
            let mut blocks = Vec::new();
            for (number, unit) in units.iter().enumerate().filter(|(_, unit)| unit.run == at) {
                let noise = noise.as_ref().map(|own| (own, number));
                blocks.extend(unit_sums(
                    (&mut rows, step),
                    unit,
                    columns,
                    noise,
                    &mut of_differences,
                ));
            }
            Ok((blocks, of_differences))
        };
        let all: Result<Vec<_>, Cancelled> = (0..runs.len()).into_par_iter().map(of_run).collect();
        let mut of_differences = NormalEquations::new(columns.width, 0);
        let mut raw = Vec::new();
        for (blocks, differences) in all? {
            raw.extend(blocks);
            of_differences.add(&differences);
        }
        let standard = Standard::of(&raw, columns);
        let n_samples = raw.iter().map(|own| own.n_samples() as f64).collect();
        let blocks = raw.into_par_iter().map(|own| standard.apply(&own)).collect();
        let varying = |own: Range<usize>| -> Vec<usize> {
            own.filter(|column| standard.deviation[*column] > 0.0).collect()
        };
        let of_causes = columns.of_causes.iter().map(|(cause, own)| (*cause, varying(own.clone())));
        let noise = noise.map(|noise| {
            let n = (of_differences.n_samples() as f64).max(1.0);
            let scale = faer::Scale(1.0 / (binomial(noise.order) * n));
            let differences = standard.apply(&of_differences) * scale;
            NoiseSums::of(noise.variances, columns, differences)
        });
        Ok(Self {
            blocks,
            n_samples,
            model: varying(columns.model()),
            of_causes: of_causes.collect(),
            noise,
        })
    }

    /// Returns the sum over all blocks.
    pub fn total(&self) -> Mat<f64> {
        let width = self.blocks.first().map_or(0, Mat::ncols);
        self.blocks.iter().fold(Mat::zeros(width, width), |sum: Mat<f64>, own| sum + own)
    }

    /// Returns the causes whose columns these columns explain up to the share `explained` of their variance.
    pub fn causes_in(&self, base: &[usize], explained: f64) -> Vec<Cause> {
        let total = self.total();
        let mut among = picked(&total, base, base);
        (0..base.len()).for_each(|at| among[(at, at)] += 1e-7 * total[(0, 0)]);
        let is_in_base = |own: &Vec<usize>| {
            let with = picked(&total, base, own);
            let by_base = solve(&among, &with);
            let of_column = |at: usize| with.col(at).transpose() * by_base.col(at);
            let squares = own.iter().map(|column| total[(*column, *column)]).sum::<f64>();
            (0..own.len()).map(of_column).sum::<f64>() >= explained * squares
        };
        let causes = self.of_causes.iter().filter(|(_, own)| !own.is_empty() && is_in_base(own));
        causes.map(|own| own.0).collect()
    }
}

impl NoiseSums {
    /// Computes the noise from mean products of differences. `variances` is the noise of the conventional residuals.
    fn of(variances: Vec<f64>, columns: &Columns, differences: Mat<f64>) -> Self {
        let passed_on = |weights: &Mat<f64>| -> Vec<f64> {
            let products = &differences * weights;
            let of_axis = |axis: usize| weights.col(axis).transpose() * products.col(axis);
            (0..columns.n_axes()).map(of_axis).collect()
        };
        let scales =
            variances.iter().zip(passed_on(&weights_of(columns, &columns.inputs.conventional)));
        let scales: Vec<f64> = scales.map(|(own, of)| own / of.max(1e-300)).collect();
        let floor = match best_weights(columns, &differences) {
            Some(best) => {
                let floor = passed_on(&best).into_iter().zip(&scales).zip(&variances);
                floor.map(|((own, scale), most)| (own * scale).min(*most)).collect()
            }
            None => variances,
        };
        Self { differences, scales, floor }
    }
}

/// Returns the coefficients of the unbiased calibration that passes on least noise, by generalised least squares.
fn best_weights(columns: &Columns, differences: &Mat<f64>) -> Option<Mat<f64>> {
    let g = columns.n_gauges();
    let noise = differences.submatrix(1, 1, g, g);
    let trace: f64 = (0..g).map(|gauge| noise[(gauge, gauge)]).sum();
    let least = LEAST_NOISE * trace / g as f64;
    let noise = Mat::from_fn(g, g, |i, j| noise[(i, j)] + if i == j { least } else { 0.0 });
    let from_loads = &columns.inputs.gauges_from_loads;
    let weighted = inverse_above(&noise, 1e-15)? * from_loads.transpose();
    let best = &weighted * inverse_above(&(from_loads * &weighted), UNDETERMINED)?;
    Some(weights_of(columns, &best))
}

/// Returns the weights of the columns whose sum on each axis is the load minus what these coefficients of the gauges explain.
fn weights_of(columns: &Columns, gauges: &Mat<f64>) -> Mat<f64> {
    let weight = |column: usize, axis: usize| match column.checked_sub(1) {
        Some(gauge) if gauge < gauges.nrows() => -gauges[(gauge, axis)],
        _ => f64::from(u8::from(column == columns.loads + axis)),
    };
    Mat::from_fn(columns.width, columns.n_axes(), weight)
}

/// Returns the sums of every `step`-th row over each block of a unit. Adds the differences of every `step`-th chunk that is quiet
/// to `of_differences`.
fn unit_sums(
    (rows, step): (&mut Rows<'_>, usize),
    unit: &Unit,
    columns: &Columns,
    noise: Option<(&Noise, usize)>,
    of_differences: &mut NormalEquations,
) -> Vec<NormalEquations> {
    let mut sums = vec![NormalEquations::new(columns.width, 0); unit.blocks.len()];
    let stride = of_differences.stride();
    let order = noise.map_or(0, |(own, _)| own.order);
    let quiet = noise.into_iter().flat_map(|(own, number)| own.quiet[number].iter().copied());
    let mut quiet = quiet.filter(|chunk| chunk % step == 0).peekable();
    let mut buffer: Vec<f64> = Vec::new();
    let (mut changes, mut kept) = (Vec::new(), Vec::new());
    let end = unit.samples.end;
    let mut written = unit.samples.start;
    for start in unit.samples.clone().step_by(WINDOW) {
        let stop = (start + WINDOW).min(end);
        let known = (written - start) * stride;
        buffer.drain(..buffer.len() - known);
        let ahead = (stop + order).min(end);
        buffer.resize((ahead - start) * stride, 0.0);
        for row in buffer[known..].chunks_exact_mut(stride) {
            rows.next(unit, written, row);
            written += 1;
        }
        for (sums, block) in sums.iter_mut().zip(&unit.blocks) {
            let (from, to) = (block.start.max(start), block.end.min(stop));
            kept.clear();
            let first = block.start + from.saturating_sub(block.start).next_multiple_of(step);
            for sample in (first..to).step_by(step) {
                kept.extend_from_slice(&buffer[(sample - start) * stride..][..stride]);
            }
            sums.add_rows(&kept);
        }
        changes.clear();
        let first = unit.samples.start;
        while let Some(chunk) = quiet.next_if(|chunk| first + chunk * CHUNK < stop) {
            for at in chunk * CHUNK..(chunk + 1) * CHUNK {
                let row = &buffer[(first + at - start) * stride..][..(order + 1) * stride];
                push_difference(row, stride, order, &mut changes);
            }
        }
        of_differences.add_rows(&changes);
    }
    sums
}

/// Adds the difference of some order of the rows, which are `order + 1` in number.
fn push_difference(rows: &[f64], stride: usize, order: usize, changes: &mut Vec<f64>) {
    let first = changes.len();
    changes.resize(first + stride, 0.0);
    let mut factor = if order.is_multiple_of(2) { 1.0 } else { -1.0 };
    for (k, row) in rows.chunks_exact(stride).enumerate() {
        for (out, value) in changes[first..].iter_mut().zip(row) {
            *out += factor * value;
        }
        factor *= -((order - k) as f64) / (k + 1) as f64;
    }
}

/// Returns the binomial coefficient of `2 order` over `order`.
fn binomial(order: usize) -> f64 {
    (1..=order).map(|k| (order + k) as f64 / k as f64).product()
}

/// Means and standard deviations by which sums of raw columns become sums of standardised columns. Offset, gauges, products,
/// time and loads stay as they are.
struct Standard {
    mean: Vec<f64>,
    /// Standard deviation; 0 for columns that are left out.
    deviation: Vec<f64>,
}

impl Standard {
    fn of(blocks: &[NormalEquations], columns: &Columns) -> Self {
        let n: f64 = blocks.iter().map(|own| own.n_samples() as f64).sum();
        let (mut mean, mut deviation) = (vec![0.0; columns.width], vec![1.0; columns.width]);
        let causes = columns.of_causes.iter().filter(|(cause, _)| *cause != Cause::Temperature);
        for column in columns.model().chain(causes.flat_map(|(_, own)| own.clone())) {
            let sum = |i, j| blocks.iter().map(|own| own.feature_product(i, j)).sum::<f64>();
            (mean[column], deviation[column]) = moments(n, sum(0, column), sum(column, column));
        }
        Self { mean, deviation }
    }

    fn apply(&self, sums: &NormalEquations) -> Mat<f64> {
        let width = self.mean.len();
        let first: Vec<f64> = (0..width).map(|i| sums.feature_product(0, i)).collect();
        let n = first[0];
        let mut products = Mat::zeros(width, width);
        for j in 0..width {
            for i in 0..=j {
                let centred =
                    sums.feature_product(i, j) - self.mean[i] * first[j] - self.mean[j] * first[i]
                        + self.mean[i] * self.mean[j] * n;
                let scale = self.deviation[i] * self.deviation[j];
                let own = if scale > 0.0 { centred / scale } else { 0.0 };
                (products[(i, j)], products[(j, i)]) = (own, own);
            }
        }
        products
    }
}

/// Returns mean and standard deviation from sums. The deviation is 0 for a column that does not vary.
fn moments(n: f64, sum: f64, square: f64) -> (f64, f64) {
    let mean = sum / n;
    let deviation = (square / n - mean * mean).max(0.0).sqrt();
    let varies = deviation > CONSTANT && deviation > CONSTANT_SHARE * mean.abs();
    (mean, if varies { deviation } else { 0.0 })
}
