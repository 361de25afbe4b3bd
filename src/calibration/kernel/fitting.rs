//! Fits a kernel regression: selects landmarks, whitens the kernel values, and cross-validates length scale and ridge
//! strength.

use std::borrow::Cow;

use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::{Mat, Par, Side};
use rayon::prelude::*;

use super::model::{Band, GridEdge, Kernel, KernelSettings, Landmarks, standardise};
use crate::{
    calibration::{
        choice::{SHARES, best_share, simplest_good},
        error::CalibrationError,
        linear::{Ridge, Terms, fit, fit_targets},
        normal_equations::NormalEquations,
    },
    dot::dot,
    features::ColumnKind,
    progress::{Cancelled, Progress},
};

/// Term on the diagonal of the landmarks' kernel matrix that keeps it invertible. The entries of the matrix are at most 1.
const JITTER: f64 = 1e-6;
/// Length scales to try, in units of the root mean square distance of a sample from the mean sample.
const LENGTH_SCALES: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];
/// Powers to try: each input column is divided by this power of its standard deviation. With 1, all columns vary alike. With
/// 0.5, a column that varies little counts less, because much of its variation may be noise. If the user gives a length
/// scale, only the power 1 is used.
const POWERS: [f64; 2] = [0.5, 1.0];
/// Ridge strengths to try: ratios of the noise variance to the prior variance of the fitted function.
const STRENGTHS: [f64; 9] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0];
/// Ridge strength that is used if no samples can be held out to choose it.
const UNTUNED_STRENGTH: f64 = 1e-3;
/// Maximum weight of a landmark, in standard deviations of the target. With larger weights, the load is a small difference of
/// large numbers. Drift of a gauge or rounding to single precision would change this difference strongly.
const LARGEST_WEIGHT: f64 = 1e4;
/// Approximate number of samples with which the length scale is chosen.
const TUNING_SAMPLES: usize = 20_000;
/// Number of landmarks with which the length scale is chosen.
const TUNING_LANDMARKS: usize = 150;
/// Approximate number of samples from which the landmarks are selected.
const CANDIDATES: usize = 4_000;

/// Consecutive training samples that belong to the same part of the cross-validation. All matrices are row-major.
#[derive(Clone, Copy, Debug)]
pub struct RowBlock<'a> {
    pub fold: usize,
    /// Inputs of the kernel, `n × n_inputs`.
    pub inputs: &'a [f64],
    /// Columns of the linear fit whose residuals the kernel learns, `n × n_columns`; empty if the kernel learns the targets
    /// directly.
    pub linear: &'a [f64],
    /// Targets, `n × n_targets`.
    pub targets: &'a [f64],
}

/// Function that receives one block of samples after the other.
pub type TakeRows<'a> = &'a mut dyn FnMut(RowBlock<'_>);

/// Linear fit whose residuals a kernel learns. Cross-validation repeats the linear fit and the kernel fit without each part
/// of the samples.
#[derive(Clone, Debug)]
pub struct LinearStage {
    pub kinds: Vec<ColumnKind>,
    /// Coefficients whose contribution was already subtracted from the targets; see [`Terms::known`].
    pub known: Vec<f64>,
    /// Relative ridge penalty of each column, for each target; see [`fit_targets`].
    pub shares: Vec<Vec<f64>>,
}

/// Training samples, divided into runs that can each be read several times.
pub trait Rows: Sync {
    fn n_runs(&self) -> usize;
    fn n_samples(&self, run: usize) -> usize;
    fn widths(&self) -> (usize, usize);
    fn pass(&self, run: usize, take: TakeRows<'_>);
    /// Returns the linear fit whose residuals the kernel learns; `None` if the kernel learns the targets directly.
    fn linear_stage(&self) -> Option<&LinearStage> {
        None
    }
}

#[derive(Clone, Debug)]
pub struct KernelFit {
    pub kernel: Kernel,
    pub edge: Option<GridEdge>,
}

impl Kernel {
    /// Fits a kernel to the training samples. Cross-validation chooses the ridge strength, and the length scale unless it is
    /// given. In a hybrid regressor, it also chooses the factor of the kernel's prediction. The chosen ridge strength is the
    /// strongest whose error is nearly the lowest, among those with all landmark weights up to [`LARGEST_WEIGHT`].
    pub fn fit(
        rows: &impl Rows,
        settings: &KernelSettings,
        progress: &Progress,
    ) -> Result<KernelFit, CalibrationError> {
        settings.validate()?;
        let samples: usize = (0..rows.n_runs()).map(|run| rows.n_samples(run)).sum();
        if settings.landmarks > samples {
            return Err(CalibrationError::FewSamples { landmarks: settings.landmarks, samples });
        }
        let (powers, tries) = match settings.length_scale {
            Some(_) => (&POWERS[POWERS.len() - 1..], 1),
            None => (&POWERS[..], LENGTH_SCALES.len() * POWERS.len()),
        };
        // The progress counts the last pass over all samples as much as the passes for all length scales together.
        progress.add_total(2 * tries as u64 * rows.n_runs() as u64);
        let measured = Standardised::measure(rows, progress)?;
        let step = samples.div_ceil(TUNING_SAMPLES);
        // For each tried power: the scaled columns, the landmarks, the best length scale, and the errors on the held-out
        // parts.
        let mut found = Vec::new();
        for power in powers {
            let standardised = measured.divided_by(*power);
            let landmarks = standardised.landmarks(rows, settings.landmarks, progress)?;
            let few = &landmarks[..landmarks.len().min(TUNING_LANDMARKS)];
            let columns = Columns::new(few.len(), rows);
            let mut best = settings.length_scale.map(|scale| (scale, 0.0, Vec::new()));
            let tried = if best.is_none() { &LENGTH_SCALES[..] } else { &[] };
            for scale in tried {
                let length = scale * standardised.distance;
                let Some(whitened) = Whitened::new(&standardised, few, length) else {
                    continue;
                };
                let parts = whitened.sums(rows, step, progress)?;
                progress.advance(rows.n_runs() as u64);
                let tuned = whitened.tuned(&parts, &columns, progress)?;
                let (error, of_parts) = tuned.map_or((f64::INFINITY, Vec::new()), |tuned| {
                    (tuned.least_error, tuned.of_parts)
                });
                if best.as_ref().is_none_or(|(_, least, _)| error < *least) {
                    best = Some((*scale, error, of_parts));
                }
            }
            found.extend(
                best.map(|(scale, _, of_parts)| (standardised, landmarks, scale, of_parts)),
            );
        }
        let n_parts = found.last().map_or(0, |(.., of_parts)| of_parts.len());
        let chosen = match found.len() {
            0 => return Err(CalibrationError::Singular),
            n if n_parts == 0 => n - 1,
            n => simplest_good(n, n_parts, |at, part| {
                found[at].3.get(part).copied().unwrap_or(f64::INFINITY)
            }),
        };
        let (standardised, landmarks, scale, _) = &found[chosen];
        let columns = Columns::new(landmarks.len(), rows);
        let whitened = Whitened::new(standardised, landmarks, scale * standardised.distance)
            .ok_or(CalibrationError::Singular)?;
        let parts = whitened.sums(rows, 1, progress)?;
        let total = summed(&parts);
        let tuned = whitened.tuned(&parts, &columns, progress)?;
        progress.advance(tries as u64 * rows.n_runs() as u64);
        Ok(KernelFit {
            edge: tuned.as_ref().and_then(|tuned| tuned.edge),
            kernel: whitened.finish(&columns.residuals(&total), &columns, tuned),
        })
    }
}

/// Shift and factor that scale each input column.
struct Standardised {
    shift: Vec<f64>,
    scale: Vec<f64>,
    /// Root mean square distance of a scaled sample from the mean sample.
    distance: f64,
}

impl Standardised {
    fn measure(rows: &impl Rows, progress: &Progress) -> Result<Self, Cancelled> {
        let d = rows.widths().0;
        let moments = (0..rows.n_runs())
            .into_par_iter()
            .map(|run| {
                progress.check()?;
                let mut moments = vec![0.0; 1 + 2 * d];
                rows.pass(run, &mut |block| {
                    for row in block.inputs.chunks_exact(d) {
                        moments[0] += 1.0;
                        for (column, value) in row.iter().enumerate() {
                            moments[1 + column] += value;
                            moments[1 + d + column] += value * value;
                        }
                    }
                });
                Ok(moments)
            })
            .collect::<Result<Vec<_>, Cancelled>>()?;
        let sum = |at: usize| moments.iter().map(|moments| moments[at]).sum::<f64>();
        let n = sum(0).max(1.0);
        let shift: Vec<f64> = (0..d).map(|column| sum(1 + column) / n).collect();
        let factor = |column: usize| {
            let square = sum(1 + d + column) / n;
            let variance = square - shift[column] * shift[column];
            // Input features have a size near one. A much smaller variance is rounding noise, so the column counts as
            // constant.
            if variance > 1e-20 * square.max(1e-10) { 1.0 / variance.sqrt() } else { 0.0 }
        };
        let scale = (0..d).map(factor).collect();
        Ok(Self { shift, scale, distance: 0.0 })
    }

    /// Returns factors that divide each column by this power of its standard deviation.
    fn divided_by(&self, power: f64) -> Self {
        let varying = self.scale.iter().filter(|scale| **scale > 0.0);
        let square: f64 = varying.map(|scale| scale.powf(2.0 * (power - 1.0))).sum();
        let scale = self.scale.iter().map(|scale| scale.powf(power)).collect();
        let distance = if square > 0.0 { square.sqrt() } else { 1.0 };
        Self { shift: self.shift.clone(), scale, distance }
    }

    fn apply(&self, row: &[f64], out: &mut Vec<f64>) {
        standardise(row, &self.shift, &self.scale, out);
    }

    /// Selects up to `m` landmarks: the sample nearest to the mean, then repeatedly the sample farthest from all landmarks.
    fn landmarks(
        &self,
        rows: &impl Rows,
        m: usize,
        progress: &Progress,
    ) -> Result<Vec<Vec<f64>>, Cancelled> {
        let d = rows.widths().0;
        let samples: usize = (0..rows.n_runs()).map(|run| rows.n_samples(run)).sum();
        let step = (samples / CANDIDATES.max(m)).max(1);
        let mut first = 0_usize;
        let mut candidates: Vec<Vec<f64>> = Vec::new();
        for run in 0..rows.n_runs() {
            progress.check()?;
            let mut at = first;
            rows.pass(run, &mut |block| {
                for row in block.inputs.chunks_exact(d) {
                    if at.is_multiple_of(step) {
                        let mut candidate = Vec::new();
                        self.apply(row, &mut candidate);
                        candidates.push(candidate);
                    }
                    at += 1;
                }
            });
            first += rows.n_samples(run);
        }
        let by_input = Landmarks::from(candidates.clone());
        let mut squares = vec![0.0; candidates.len()];
        let mut nearest: Vec<f64> = vec![f64::INFINITY; candidates.len()];
        let size = |at: &usize| dot(&candidates[*at], &candidates[*at]);
        let mut next = (0..candidates.len()).min_by(|a, b| size(a).total_cmp(&size(b)));
        let mut landmarks: Vec<Vec<f64>> = Vec::new();
        while let Some(chosen) = next.filter(|_| landmarks.len() < m) {
            progress.check()?;
            let landmark = candidates[chosen].clone();
            by_input.square_distances(&landmark, &mut squares);
            for (nearest, square) in nearest.iter_mut().zip(&squares) {
                *nearest = nearest.min(*square);
            }
            landmarks.push(landmark);
            next = (0..candidates.len())
                .max_by(|a, b| nearest[*a].total_cmp(&nearest[*b]))
                .filter(|at| nearest[*at] > 0.0); // a sample equal to a landmark adds nothing
        }
        Ok(landmarks)
    }
}

/// Landmarks and a length scale, with the matrix that whitens the kernel values.
struct Whitened<'a> {
    standardised: &'a Standardised,
    landmarks: Landmarks,
    length_scale: f64,
    /// Matrix W in `φ = W k`: the inverse of the Cholesky factor of the landmarks' kernel matrix.
    whitening: Mat<f64>,
}

impl<'a> Whitened<'a> {
    fn new(
        standardised: &'a Standardised,
        landmarks: &'a [Vec<f64>],
        length_scale: f64,
    ) -> Option<Self> {
        let m = landmarks.len();
        let by_input = Landmarks::from(landmarks.to_vec());
        let mut gram = Mat::zeros(m, m);
        for (at, landmark) in landmarks.iter().enumerate() {
            by_input.similarities(length_scale, landmark, gram.col_as_slice_mut(at));
            gram[(at, at)] += JITTER;
        }
        Some(Self {
            standardised,
            landmarks: by_input,
            length_scale,
            whitening: inverse_factor(&gram)?,
        })
    }

    /// Returns the normal equations of each part of the cross-validation, from every `step`-th sample. Their columns are
    /// described at [`Columns`].
    fn sums(
        &self,
        rows: &impl Rows,
        step: usize,
        progress: &Progress,
    ) -> Result<Vec<NormalEquations>, Cancelled> {
        let (d, q) = rows.widths();
        let m = self.landmarks.len();
        let n_linear = rows.linear_stage().map_or(0, |stage| stage.kinds.len());
        let n_columns = m + 1 + n_linear;
        let of_runs = (0..rows.n_runs())
            .into_par_iter()
            .map(|run| {
                let mut parts: Vec<(usize, NormalEquations)> = Vec::new();
                let (mut at, mut x) = (0, Vec::new());
                rows.pass(run, &mut |block| {
                    if progress.is_cancelled() {
                        return;
                    }
                    let first = at;
                    at += block.inputs.len() / d;
                    let taken: Vec<usize> =
                        (first..at).filter(|k| k.is_multiple_of(step)).map(|k| k - first).collect();
                    let mut similarities = Mat::zeros(m, taken.len());
                    for (column, k) in taken.iter().enumerate() {
                        self.standardised.apply(&block.inputs[k * d..][..d], &mut x);
                        let of_row = similarities.col_as_slice_mut(column);
                        self.landmarks.similarities(self.length_scale, &x, of_row);
                    }
                    let phi = &self.whitening * similarities;
                    if parts.last().is_none_or(|(last, _)| *last != block.fold) {
                        parts.push((block.fold, NormalEquations::new(n_columns, q)));
                    }
                    let sums = &mut parts.last_mut().expect("a list was pushed above").1;
                    let stride = sums.stride();
                    let mut padded = vec![0.0; taken.len() * stride];
                    for ((column, k), row) in
                        taken.iter().enumerate().zip(padded.chunks_exact_mut(stride))
                    {
                        for (i, value) in row[..m].iter_mut().enumerate() {
                            *value = phi[(i, column)];
                        }
                        row[m] = 1.0;
                        let linear = &block.linear[k * n_linear..][..n_linear];
                        row[m + 1..n_columns].copy_from_slice(linear);
                        row[n_columns..][..q].copy_from_slice(&block.targets[k * q..][..q]);
                    }
                    sums.add_rows(&padded);
                });
                progress.check()?;
                Ok(parts)
            })
            .collect::<Result<Vec<_>, Cancelled>>()?;
        let mut folds: Vec<NormalEquations> = Vec::new();
        for (fold, sums) in of_runs.into_iter().flatten() {
            while folds.len() <= fold {
                folds.push(NormalEquations::new(n_columns, q));
            }
            folds[fold].add(&sums);
        }
        Ok(folds)
    }

    /// Returns the kernel that is fitted to the sums of all samples. If there is a linear fit, its residuals are the targets
    /// of the sums.
    fn finish(&self, total: &NormalEquations, columns: &Columns, tuned: Option<Tuned>) -> Kernel {
        let (m, q) = (self.landmarks.len(), total.n_targets());
        let strength = tuned.as_ref().map_or(UNTUNED_STRENGTH, |tuned| tuned.strength);
        let beta = columns.kernel(total, strength);
        let on_k = self.weights(&beta, q);
        let posterior = Mat::from_fn(m, m, |i, j| {
            total.feature_product(i, j) + if i == j { strength } else { 0.0 }
        });
        let n = total.n_samples().max(1) as f64;
        let (squares, shares) = match tuned {
            Some(tuned) => (tuned.squares, tuned.shares),
            None => (total.squared_residuals(&beta), vec![1.0; q]),
        };
        let mut kernel = Kernel {
            input_shift: self.standardised.shift.clone(),
            input_scale: self.standardised.scale.clone(),
            length_scale: self.length_scale,
            landmarks: self.landmarks.clone(),
            weights: (0..q).map(|axis| (0..m).map(|i| on_k[(axis, i)]).collect()).collect(),
            offset: (0..q).map(|axis| beta[m * q + axis]).collect(),
            band: Band {
                noise_variance: squares.iter().map(|square| square / n).collect(),
                strength,
                whitening: triangle(&self.whitening),
                // The matrix can be inverted: the ridge on its diagonal makes it positive definite.
                posterior: triangle(
                    &inverse_factor(&posterior).unwrap_or_else(|| Mat::zeros(m, m)),
                ),
            },
        };
        kernel.scale(&shares);
        kernel
    }

    /// Returns the weights of the kernel values, `n_targets × n_landmarks`, from the coefficients of the whitened columns.
    fn weights(&self, beta: &[f64], q: usize) -> Mat<f64> {
        Mat::from_fn(q, self.landmarks.len(), |axis, i| beta[i * q + axis]) * &self.whitening
    }

    /// Returns true if every weight is at most [`LARGEST_WEIGHT`] standard deviations of its target.
    fn has_small_weights(&self, beta: &[f64], total: &NormalEquations) -> bool {
        let q = total.n_targets();
        let weights = self.weights(beta, q);
        (0..q).all(|axis| {
            let deviation = (total.target_square(axis) / total.n_samples().max(1) as f64).sqrt();
            let largest = (0..self.landmarks.len()).map(|i| weights[(axis, i)].abs());
            largest.fold(0.0, f64::max) <= LARGEST_WEIGHT * deviation
        })
    }

    /// Chooses ridge strength and factor of the kernel's prediction by cross-validation; `None` if fewer than two parts have
    /// samples.
    fn tuned(
        &self,
        parts: &[NormalEquations],
        columns: &Columns,
        progress: &Progress,
    ) -> Result<Option<Tuned>, Cancelled> {
        let has_samples = |part: &&NormalEquations| part.n_samples() > 0;
        let parts: Vec<NormalEquations> = parts.iter().filter(has_samples).cloned().collect();
        if parts.len() < 2 {
            return Ok(None);
        }
        let total = summed(&parts);
        let q = total.n_targets();
        let left_over = columns.residuals(&total);
        let is_sane = |strength: &f64| {
            self.has_small_weights(&columns.kernel(&left_over, *strength), &left_over)
        };
        let weakest = STRENGTHS.iter().position(is_sane);
        let strengths = &STRENGTHS[weakest.unwrap_or(STRENGTHS.len() - 1)..];
        // Without a linear fit, the kernel predicts the whole load, so its factor is always 1.
        let shares: &[f64] = if columns.of_linear.is_empty() { &[1.0] } else { &SHARES };
        // Squared errors on each held-out part, ordered by ridge strength, factor and axis.
        let squares = NormalEquations::each_without(
            &parts,
            |_| true,
            |at, rest| {
                let linear = columns.linear(rest);
                let (rest, part) =
                    (less(rest, linear.as_deref()), less(&parts[at], linear.as_deref()));
                let mut squares = Vec::new();
                for &strength in strengths {
                    progress.check()?;
                    let beta = columns.kernel(&rest, strength);
                    for share in shares {
                        let beta: Vec<f64> = beta.iter().map(|beta| share * beta).collect();
                        squares.extend(part.squared_residuals(&beta));
                    }
                }
                Ok(squares)
            },
        );
        let squares = (squares.into_iter().map(|(_, squares)| squares))
            .collect::<Result<Vec<_>, Cancelled>>()?;
        let of = |part: usize, strength: usize, share: usize, axis: usize| {
            squares[part][(strength * shares.len() + share) * q + axis]
        };
        let whole = |strength: usize, part: usize| -> f64 {
            let scale = |axis| left_over.target_square(axis).max(f64::MIN_POSITIVE);
            (0..q).map(|axis| of(part, strength, 0, axis) / scale(axis)).sum()
        };
        let n = parts.len();
        let chosen = simplest_good(strengths.len(), n, whole);
        let of_strength = |at| (0..n).map(|part| whole(at, part)).sum::<f64>();
        let taken: Vec<usize> = (0..q)
            .map(|axis| match shares {
                [_] => 0,
                _ => best_share(n, |share, part| of(part, chosen, share, axis)),
            })
            .collect();
        Ok(Some(Tuned {
            strength: strengths[chosen],
            edge: match chosen {
                0 => Some(GridEdge::Weakest),
                _ if chosen + 1 == strengths.len() => Some(GridEdge::Strongest),
                _ => None,
            },
            least_error: (0..strengths.len()).map(of_strength).fold(f64::INFINITY, f64::min),
            of_parts: (0..n).map(|part| whole(chosen, part)).collect(),
            squares: (0..q)
                .map(|axis| (0..n).map(|part| of(part, chosen, taken[axis], axis)).sum())
                .collect(),
            shares: taken.iter().map(|at| shares[*at]).collect(),
        }))
    }
}

/// Returns the inverse of the lower Cholesky factor, or `None` if the matrix is not positive definite.
fn inverse_factor(matrix: &Mat<f64>) -> Option<Mat<f64>> {
    let factor = matrix.llt(Side::Lower).ok()?;
    let mut inverse = Mat::zeros(matrix.nrows(), matrix.ncols());
    invert_lower_triangular(inverse.as_mut(), factor.L(), Par::Seq);
    Some(inverse)
}

fn triangle(matrix: &Mat<f64>) -> Vec<Vec<f64>> {
    (0..matrix.nrows()).map(|i| (0..=i).map(|j| matrix[(i, j)]).collect()).collect()
}

/// Columns of the normal equations: whitened kernel values φ, a constant, and the columns of the linear fit if there is one.
struct Columns {
    /// Indices of the columns φ and of the constant column.
    of_kernel: Vec<usize>,
    of_linear: Vec<usize>,
    kinds: Vec<ColumnKind>,
    known: Vec<f64>,
    shares: Vec<Vec<f64>>,
}

impl Columns {
    fn new(m: usize, rows: &impl Rows) -> Self {
        let mut kinds = vec![ColumnKind::Appended; m];
        kinds.push(ColumnKind::Offset);
        let mut known = vec![0.0; (m + 1) * rows.widths().1];
        let mut shares = Vec::new();
        if let Some(stage) = rows.linear_stage() {
            kinds.extend(&stage.kinds);
            known.extend(&stage.known);
            let before = vec![0.0; m + 1];
            shares.extend(stage.shares.iter().map(|added| [&before[..], added].concat()));
        }
        Self {
            of_kernel: (0..=m).collect(),
            of_linear: (m + 1..kinds.len()).collect(),
            kinds,
            known,
            shares,
        }
    }

    /// Returns the coefficients of the linear fit to these sums; `None` if the kernel learns the targets directly.
    fn linear(&self, sums: &NormalEquations) -> Option<Vec<f64>> {
        let terms = Terms { used: &self.of_linear, kinds: &self.kinds, known: &self.known };
        let is_there = !self.of_linear.is_empty();
        is_there.then(|| fit_targets(sums, terms, &self.shares).coefficients)
    }

    /// Returns the same sums with the residuals of the linear fit as targets.
    fn residuals<'a>(&self, sums: &'a NormalEquations) -> Cow<'a, NormalEquations> {
        less(sums, self.linear(sums).as_deref())
    }

    /// Returns the coefficients of φ and of the constant column, fitted to the targets. The ridge shrinks only those of φ.
    fn kernel(&self, sums: &NormalEquations, strength: f64) -> Vec<f64> {
        let terms = Terms { used: &self.of_kernel, kinds: &self.kinds, known: &[] };
        fit(sums, terms, Ridge::Absolute(strength)).coefficients
    }
}

fn less<'a>(sums: &'a NormalEquations, linear: Option<&[f64]>) -> Cow<'a, NormalEquations> {
    match linear {
        Some(linear) => Cow::Owned(sums.less(linear)),
        None => Cow::Borrowed(sums),
    }
}

fn summed(parts: &[NormalEquations]) -> NormalEquations {
    let mut total = NormalEquations::new(parts[0].n_features(), parts[0].n_targets());
    parts.iter().for_each(|part| total.add(part));
    total
}

struct Tuned {
    strength: f64,
    edge: Option<GridEdge>,
    /// Lowest cross-validation error over the tried ridge strengths: squared errors divided by the squared targets, summed
    /// over the axes.
    least_error: f64,
    /// Error of the chosen ridge strength on each held-out part: squared errors divided by the squared targets, summed over
    /// the axes.
    of_parts: Vec<f64>,
    /// Factor of the kernel's prediction on each axis.
    shares: Vec<f64>,
    squares: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::kernel::model::KernelScratch;

    /// Runs of one input and one target.
    struct Function {
        runs: Vec<Vec<(f64, f64)>>,
    }

    impl Function {
        /// Creates three runs over −2 to 2, with a gap from `gap` on.
        fn new(target: impl Fn(f64) -> f64, gap: f64) -> Self {
            let run = |phase: f64| {
                (0..200)
                    .map(|k| (f64::from(k) + phase) / 50.0 - 2.0)
                    .filter(|x| *x < gap)
                    .map(|x| (x, target(x)))
                    .collect()
            };
            Self { runs: [0.0, 0.3, 0.6].map(run).to_vec() }
        }
    }

    impl Rows for Function {
        fn n_runs(&self) -> usize {
            self.runs.len()
        }

        fn n_samples(&self, run: usize) -> usize {
            self.runs[run].len()
        }

        fn widths(&self) -> (usize, usize) {
            (1, 1)
        }

        fn pass(&self, run: usize, take: TakeRows<'_>) {
            for samples in self.runs[run].chunks(64) {
                let (x, y): (Vec<f64>, Vec<f64>) = samples.iter().copied().unzip();
                take(RowBlock { fold: run, inputs: &x, linear: &[], targets: &y });
            }
        }
    }

    fn fit(rows: &Function, landmarks: usize) -> Result<Kernel, CalibrationError> {
        let settings = KernelSettings { landmarks, ..KernelSettings::default() };
        Kernel::fit(rows, &settings, &Progress::default()).map(|fit| fit.kernel)
    }

    fn answer(kernel: &Kernel, x: f64) -> (f64, f64) {
        let (mut load, mut deviation) = ([0.0], [0.0]);
        let mut scratch = KernelScratch::default();
        kernel.add(&[x], &mut scratch, &mut load);
        kernel.deviations(&[x], &mut scratch, &mut deviation);
        (load[0], deviation[0])
    }

    /// Function of one input, with a second input that does not affect it.
    struct Beside {
        function: Function,
        second: fn(f64) -> f64,
    }

    impl Rows for Beside {
        fn n_runs(&self) -> usize {
            self.function.n_runs()
        }

        fn n_samples(&self, run: usize) -> usize {
            self.function.n_samples(run)
        }

        fn widths(&self) -> (usize, usize) {
            (2, 1)
        }

        fn pass(&self, run: usize, take: TakeRows<'_>) {
            self.function.pass(run, &mut |block| {
                let both = block.inputs.iter().flat_map(|x| [*x, (self.second)(*x)]);
                take(RowBlock { inputs: &both.collect::<Vec<f64>>(), ..block });
            });
        }
    }

    /// The second input is nearly random, and varies by a thirtieth of the first.
    #[test]
    fn a_small_column_counts_less_if_it_is_noise_and_fully_if_it_is_the_target() {
        let second = |x: f64| 0.05 * (12_345.6 * x).sin();
        let powers = |target: &dyn Fn(f64) -> f64| {
            let rows = Beside { function: Function::new(target, 9.0), second };
            let settings = KernelSettings { landmarks: 40, ..KernelSettings::default() };
            let kernel = Kernel::fit(&rows, &settings, &Progress::default()).unwrap().kernel;
            kernel.input_scale[1] / kernel.input_scale[0]
        };
        let of_noise = powers(&|x| (2.0 * x).sin() + 0.3 * x);
        assert!((4.0..8.0).contains(&of_noise), "{of_noise}");
        let of_target = powers(&second);
        assert!((20.0..50.0).contains(&of_target), "{of_target}");
    }

    #[test]
    fn a_smooth_function_is_learned_to_a_thousandth() {
        let kernel = fit(&Function::new(|x| (2.0 * x).sin() + 0.3 * x, 9.0), 30).unwrap();
        for at in -18..=18 {
            let x = 0.1 * f64::from(at);
            assert!((answer(&kernel, x).0 - ((2.0 * x).sin() + 0.3 * x)).abs() < 1e-3, "{x}");
        }
    }

    /// Every sample is a landmark. By the textbook, the mean is `k(x)ᵀ (K + λI)⁻¹ y`, and the variance divided by the noise
    /// variance is `1 + (1 − k(x)ᵀ (K + λI)⁻¹ k(x)) / λ`.
    #[test]
    fn with_every_sample_a_landmark_the_kernel_is_the_gaussian_process() {
        let rows = Function {
            runs: vec![
                (0..12).map(|k| f64::from(k * k % 12) - 5.5).map(|x| (x, x.cos())).collect(),
            ],
        };
        let settings = KernelSettings { landmarks: 12, length_scale: Some(0.5) };
        let kernel = Kernel::fit(&rows, &settings, &Progress::default()).unwrap().kernel;
        let lambda = kernel.band.strength;
        let samples: Vec<(f64, f64)> = rows.runs[0]
            .iter()
            .map(|(x, y)| {
                ((x - kernel.input_shift[0]) * kernel.input_scale[0], y - kernel.offset[0])
            })
            .collect();
        let k = |a: f64, b: f64| (-0.5 * ((a - b) / kernel.length_scale).powi(2)).exp();
        let gram = Mat::from_fn(12, 12, |i, j| {
            k(samples[i].0, samples[j].0) + if i == j { lambda } else { 0.0 }
        });
        let inverse = {
            let whitening = inverse_factor(&gram).unwrap();
            whitening.transpose() * &whitening
        };
        for x in [-4.0, 0.2, 3.3] {
            let standardised = (x - kernel.input_shift[0]) * kernel.input_scale[0];
            let similar: Vec<f64> = samples.iter().map(|(x, _)| k(standardised, *x)).collect();
            let weights: Vec<f64> =
                (0..12).map(|i| (0..12).map(|j| similar[j] * inverse[(j, i)]).sum()).collect();
            let mean: f64 = weights.iter().zip(&samples).map(|(w, (_, y))| w * y).sum();
            let explained: f64 = dot(&weights, &similar);
            let variance = kernel.band.noise_variance[0] * (1.0 + (1.0 - explained) / lambda);
            let (load, deviation) = answer(&kernel, x);
            assert!((load - kernel.offset[0] - mean).abs() < 1e-4, "{x}: {load}");
            assert!((deviation / variance.sqrt() - 1.0).abs() < 1e-3, "{x}: {deviation}");
        }
    }

    /// The target has a pole and no noise. Cross-validation alone would choose no ridge and very large weights.
    #[test]
    fn weights_stay_small_and_a_ridge_at_the_end_of_the_candidates_is_reported() {
        let fitted = |target: &dyn Fn(f64) -> f64| {
            let rows = Function::new(target, 9.0);
            let settings = KernelSettings { landmarks: 60, length_scale: Some(8.0) };
            Kernel::fit(&rows, &settings, &Progress::default()).unwrap()
        };
        let steep = fitted(&|x| 1.0 / (2.05 - x));
        assert_eq!(steep.edge, Some(GridEdge::Weakest));
        assert!(steep.kernel.band.strength > STRENGTHS[0]);
        let weights = steep.kernel.weights[0].iter();
        let largest = weights.fold(0.0_f64, |most, weight| most.max(weight.abs()));
        assert!(largest < 4.0 * LARGEST_WEIGHT, "{largest}"); // the targets deviate by 2.6
        let mut random = crate::random::Random::new(1, &[]);
        let noise: Vec<f64> = (0..1000).map(|_| random.normal()).collect();
        let noisy = fitted(&|x| noise[((x + 2.0) * 150.0) as usize]);
        assert_eq!(noisy.edge, Some(GridEdge::Strongest));
    }

    #[test]
    fn the_band_is_wide_far_from_training_samples() {
        let kernel = fit(&Function::new(|x| x + 0.05 * (40.0 * x).sin(), 0.5), 20).unwrap();
        let (inside, outside) = (answer(&kernel, -1.0), answer(&kernel, 8.0));
        assert!(outside.1 > 5.0 * inside.1, "{inside:?} {outside:?}");
        assert!((outside.0 - kernel.offset[0]).abs() < 0.2);
    }

    #[test]
    fn settings_that_do_not_fit_the_samples_are_refused() {
        let rows = Function::new(f64::sin, 9.0);
        assert_eq!(
            fit(&rows, 601),
            Err(CalibrationError::FewSamples { landmarks: 601, samples: 600 })
        );
        assert!(fit(&rows, 0).is_err());
        let cancelled = Progress::default();
        cancelled.cancel();
        assert!(matches!(
            Kernel::fit(&rows, &KernelSettings::default(), &cancelled),
            Err(CalibrationError::Cancelled(_))
        ));
    }

    #[test]
    fn a_constant_column_changes_nothing_and_edited_files_are_refused() {
        let mut constant = Function::new(f64::sin, 9.0);
        constant.runs.iter_mut().flatten().for_each(|(x, _)| *x = 3.0);
        let kernel = fit(&constant, 5).unwrap();
        assert_eq!((kernel.input_scale[0], kernel.landmarks.len()), (0.0, 1));
        assert_eq!(kernel.validate(1, 1), Ok(()));
        assert!(kernel.validate(2, 1).is_err());
        let mut edited = kernel.clone();
        edited.weights[0][0] = f64::NAN;
        assert!(edited.validate(1, 1).unwrap_err().to_string().contains("weights"));
    }
}
