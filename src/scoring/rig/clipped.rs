//! Finds axes whose reference is clipped: the recorded load stays at a limit while the gauges rise further.

use faer::Mat;

use crate::{
    calibration::NormalEquations,
    finding::{Finding, Id, Verdict},
    recording::Recording,
    scoring::{
        faults::are_of_one_table,
        numbers::{percent, significant},
        rig::{BLOCK, Rig, fits::Fit},
    },
    shown::counted,
};

use Verdict::Doubtful;

/// Minimum rise of the load that the gauges predict while the reference stays at its maximum, for a report that it is
/// clipped. The mean rise is multiplied by the root of the number of such stays and divided by the error of the fit. Without
/// clipping, this number has the mean −0.8 and the standard deviation 1.2, so it exceeds 3 once in a thousand cases.
const RISES: f64 = 3.0;
/// Minimum number of other peaks (reversals) of a load, for a judgement on whether its peaks differ.
const FEWEST_PEAKS: usize = 5;
/// Minimum mean excess of the predicted over the recorded load where the recorded load is at its maximum, for a report that
/// it is clipped. It is divided by the RMS error of the other samples. An error that is a cubic of the load is √7 = 2.65
/// times its RMS at the end of the range. Hysteresis causes up to 0.9.
const BEYOND: f64 = 2.65;
/// Maximum probability that an unclipped load returns to exactly its maximum as often as observed. Below it, the load is
/// reported as clipped.
const RECURS_BY_CHANCE: f64 = 1e-4;

impl Rig {
    /// Returns findings of axes whose reference load is clipped. It stays at its maximum while the gauges rise and fall
    /// again, or it returns to exactly its maximum although all its other peaks differ.
    pub fn clipped_reference(&self, recordings: &[&Recording]) -> Vec<Finding> {
        let shape = &self.shape;
        let back = Fit::backward(&self.total(|_| true), shape).map;
        let mut found = Vec::new();
        for (at, axis) in shape.axes.iter().enumerate() {
            // Recorded and predicted loads as shares of full scale.
            let traces = recordings.chunk_by(|a, b| are_of_one_table(a, b)).map(|table| Trace {
                is_static: table[0].is_static(),
                samples: (table.iter().flat_map(|own| self.shown(own, at, back.row(at)))).collect(),
            });
            let traces: Vec<Trace> = traces.collect();
            let all = || traces.iter().flat_map(|own| &own.samples);
            let n = all().count().max(1) as f64;
            let mean = all().map(|(load, shown)| shown - load).sum::<f64>() / n;
            let squares = all().map(|(load, shown)| (shown - load - mean).powi(2)).sum::<f64>();
            let error = (squares / n).sqrt();
            let mut loads: Vec<f64> = all().map(|own| own.0).collect();
            loads.sort_unstable_by(f64::total_cmp);
            let steps = loads.windows(2).map(|own| own[1] - own[0]).filter(|step| *step > 0.0);
            let resolution = steps.fold(f64::INFINITY, f64::min);
            for outward in [-1.0, 1.0] {
                let end = all().map(|own| outward * own.0).fold(f64::NEG_INFINITY, f64::max);
                let peaks: Vec<Vec<Peak>> = traces.iter().map(|own| own.peaks(outward)).collect();
                let visits = || peaks.iter().flatten().filter(|own| own.load == end);
                let rises: Vec<f64> = visits().filter_map(|own| own.rise).collect();
                let rise = rises.iter().sum::<f64>() / rises.len().max(1) as f64;
                let is_risen =
                    rise * (rises.len() as f64).sqrt() > RISES * error && rise > resolution;
                if !is_risen && !recurs(&peaks, end, resolution) {
                    continue;
                }
                let (excess, error) = self.excess(recordings, at, outward * end);
                if outward * excess > BEYOND * error {
                    let load = significant(outward * end * shape.full_scale[at], 4);
                    let seen = format!(
                        "the reference of {} seems clipped: it stays at {load} {} while the gauges rise further",
                        axis.symbol(),
                        axis.unit()
                    );
                    let figures = format!(
                        "this happens {}, and the gauges rise further by {} of full scale on average",
                        counted(visits().count(), "time"),
                        percent(excess.abs())
                    );
                    let found_here = Finding::new(Id::ReferenceClipped, Doubtful, seen);
                    found.push(found_here.with(figures).costing(excess.abs()));
                }
            }
        }
        found
    }

    /// Returns the mean excess of the predicted over the recorded load where the recorded load is `end`, and the RMS error
    /// of the other samples. The prediction from the gauges, their squares and cubes is fitted to the other samples.
    fn excess(&self, recordings: &[&Recording], axis: usize, end: f64) -> (f64, f64) {
        // Columns: one, the gauges with their squares and cubes, and the load.
        let output = 1 + 3 * self.shape.n_gauges;
        let mut sums = [(); 2].map(|()| NormalEquations::new(output + 1, 0));
        let stride = sums[0].stride();
        let mut rows = [Vec::new(), Vec::new()];
        for recording in recordings {
            let at = self.shape.axes_in(recording)[axis];
            for k in 0..recording.n_samples() {
                let load = recording.loads()[k * recording.axes().len() + at];
                let load = load / self.shape.full_scale[axis];
                let is_end = usize::from(load == end);
                let rows: &mut Vec<f64> = &mut rows[is_end];
                rows.push(1.0);
                for power in 1..=3 {
                    rows.extend(self.standard(recording.gauges_at(k)).map(|own| own.powi(power)));
                }
                rows.push(load);
                rows.resize(rows.len().next_multiple_of(stride), 0.0);
                if rows.len() >= BLOCK * stride {
                    sums[is_end].add_rows(rows);
                    rows.clear();
                }
            }
        }
        let [others, at_end] = [0, 1].map(|is_end| {
            sums[is_end].add_rows(&rows[is_end]);
            Mat::from_fn(output + 1, output + 1, |i, j| sums[is_end].feature_product(i, j))
        });
        let freedom = others[(0, 0)] - output as f64;
        if freedom < output as f64 {
            return (0.0, f64::INFINITY);
        }
        let inputs: Vec<usize> = (0..output).collect();
        let fit = Fit::of(&others, &inputs, output..output + 1);
        (-fit.means(&at_end)[0], (fit.squares(&others)[0] / freedom).sqrt())
    }

    /// Returns for each sample the load of an axis and its prediction from the gauges, as shares of full scale.
    fn shown(
        &self,
        of: &Recording,
        axis: usize,
        back: faer::RowRef<'_, f64>,
    ) -> impl Iterator<Item = (f64, f64)> {
        let at = self.shape.axes_in(of)[axis];
        let rows = of.gauges().chunks_exact(self.shape.n_gauges);
        let loads = of.loads()[at..].iter().step_by(of.axes().len());
        loads.zip(rows).map(move |(load, row)| {
            let shown = self.standard(row).enumerate().map(|(at, own)| back[1 + at] * own);
            (load / self.shape.full_scale[axis], shown.sum())
        })
    }
}

/// Recorded and predicted loads of one axis, in a recording or a table of load cases.
struct Trace {
    is_static: bool,
    samples: Vec<(f64, f64)>,
}

/// Peak of a load: load at which an axis reverses its direction, or a static load case.
struct Peak {
    load: f64,
    /// Rise of the load that the gauges predict, while the recorded load stays at the peak. `None` if it stays for less than
    /// three samples.
    rise: Option<f64>,
}

impl Trace {
    /// Returns the upper peaks of the load (`outward` = 1) or the lower ones (−1).
    fn peaks(&self, outward: f64) -> Vec<Peak> {
        let stays: Vec<&[(f64, f64)]> = if self.is_static {
            self.samples.chunks(1).collect()
        } else {
            self.samples.chunk_by(|a, b| a.0 == b.0).collect()
        };
        let load = |at: usize| stays.get(at).map(|own| outward * own[0].0);
        let is_peak = |at: &usize| {
            let beside = [load(at + 1), at.checked_sub(1).and_then(load)];
            self.is_static || beside.into_iter().flatten().all(|own| Some(own) < load(*at))
        };
        let peak = |at: usize| Peak {
            load: outward * stays[at][0].0,
            rise: (stays[at].len() > 2)
                .then(|| rise(stays[at].iter().map(|own| outward * own.1).collect())),
        };
        (0..stays.len()).filter(is_peak).map(peak).collect()
    }
}

/// Returns true if a load returns to exactly its maximum more often than chance explains, although its other peaks all
/// differ. Loads that are set to nominal values are excluded, because they also repeat their smaller values.
fn recurs(peaks: &[Vec<Peak>], end: f64, resolution: f64) -> bool {
    let again =
        |own: &Vec<Peak>| own.iter().filter(|own| own.load == end).count().saturating_sub(1);
    let again: usize = peaks.iter().map(again).sum();
    let others = peaks.iter().flatten().map(|own| own.load);
    let mut others: Vec<f64> = others.filter(|load| *load < end).collect();
    let n = others.len();
    others.sort_by(f64::total_cmp);
    let least = others.first().copied().unwrap_or(end);
    others.dedup();
    let expected = n as f64 * resolution / (end - least);
    again > 0
        && n >= FEWEST_PEAKS
        && 10 * others.len() > 9 * n
        && expected.powi(again as i32) < RECURS_BY_CHANCE
}

/// Returns the mean of the middle half of these values in time, minus the larger of the first and the last value. For noise
/// alone, this is negative.
fn rise(values: Vec<f64>) -> f64 {
    let n = values.len();
    let skipped = (n / 4).max(1);
    let inner = &values[skipped..n - skipped];
    inner.iter().sum::<f64>() / inner.len() as f64 - values[0].max(values[n - 1])
}
