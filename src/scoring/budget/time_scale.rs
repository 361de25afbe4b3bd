//! How fast the load changes, measured in samples.

use crate::scoring::budget::run::Run;

/// Share of the variance by which the load has changed after the change time.
const CHANGED: f64 = 0.1;
/// Maximum number of pairs of samples of a recording whose loads are compared. Of more pairs, every n-th is used.
const MOST_PAIRS: usize = 1 << 16;
/// Longest change time (samples) that is searched, and number of intervals up to it.
const LONGEST: f64 = 4000.0;
const INTERVALS: i32 = 60;
/// Share of the variance by which the load of a table changes from one row to the next. In a recording in time it is near 0,
/// in a table without order near 1.
const TABLE_STEP: f64 = 0.5;
/// Share of the variance within recordings, below which each recording counts as one load case.
const CONSTANT: f64 = 1e-4;
/// Minimum change time (samples) at which noise can be told apart from changes of the load.
const SHORTEST_WITH_NOISE: f64 = 4.0;

/// Part of the change time, and change of the load in it (standard deviations), below which the load rests.
const REST: (f64, f64) = (0.25, 0.02);
/// Share of the samples in which the load rests, above which it rests most of the time.
const RESTING: f64 = 0.45;

#[derive(Clone, Copy, Debug)]
pub struct TimeScale {
    /// Number of samples in which the load changes by a tenth of its variance.
    pub change_samples: f64,
    /// True if the samples are load cases without order in time, so that a sample says nothing about the next one.
    pub is_table: bool,
    /// True if all samples have times.
    pub has_times: bool,
    /// True if the load rests most of the time, as on steps. Creep then shows even if it is faster than the load changes.
    pub rests: bool,
}

impl TimeScale {
    /// Measures the axes for which `moves` is true.
    pub fn of(runs: &[Run<'_>], moves: &[bool]) -> Self {
        let all: Vec<&[f64]> = runs.iter().map(|run| run.loads).collect();
        let within = mean_of_runs(runs, moves, |loads| Some(variances(&[loads], moves.len())));
        let overall = variances(&all, moves.len());
        let moving: Vec<usize> = (0..moves.len()).filter(|axis| moves[*axis]).collect();
        let is_constant = moving.iter().all(|axis| within[*axis] <= CONSTANT * overall[*axis]);
        let has_times = runs.iter().all(|run| run.has_times);
        if moving.is_empty() || is_constant {
            return Self { change_samples: 1.0, is_table: true, has_times, rests: false };
        }
        // Median over the axes of the structure function, as a share of twice the variance.
        let change = |interval: usize, longer: usize| {
            let of_run = |loads: &[f64]| {
                let long_enough = loads.len() / moves.len() > longer;
                long_enough.then(|| squared_changes(loads, moves.len(), interval))
            };
            let changes = mean_of_runs(runs, moves, of_run);
            let shares = moving.iter().map(|axis| changes[*axis] / (2.0 * within[*axis] + 1e-300));
            middle(shares.collect()).filter(|share| share.is_finite())
        };
        let is_table = change(1, 1).is_none_or(|share| share > TABLE_STEP);
        let change_samples = change_samples(|interval| change(interval, 2 * interval));
        let interval = ((REST.0 * change_samples) as usize).max(1);
        let limits: Vec<(usize, f64)> =
            moving.iter().map(|axis| (*axis, REST.1 * within[*axis].sqrt())).collect();
        let shares = runs.iter().map(|run| resting(run.loads, moves.len(), interval, &limits));
        let rests = shares.sum::<f64>() > RESTING * runs.len() as f64;
        Self { change_samples, is_table, has_times, rests }
    }

    pub fn separates_noise(self) -> bool {
        self.change_samples >= SHORTEST_WITH_NOISE
    }
}

/// Returns the number of samples in which the load changes by [`CHANGED`], given its change in each interval.
fn change_samples(change: impl Fn(usize) -> Option<f64>) -> f64 {
    let mut before: Option<(f64, f64)> = None;
    for at in 0..INTERVALS {
        let interval = LONGEST.powf(f64::from(at) / f64::from(INTERVALS - 1)).round();
        if before.is_some_and(|(own, _)| own == interval) {
            continue;
        }
        let Some(share) = change(interval as usize) else { return interval };
        if share >= CHANGED {
            return match before {
                Some((shorter, less)) => {
                    shorter + (interval - shorter) * (CHANGED - less) / (share - less)
                }
                None if share > 4.0 * CHANGED => 1.0,
                None => (CHANGED / share).sqrt().max(1.0),
            };
        }
        before = Some((interval, share));
    }
    LONGEST
}

/// Returns the mean over the runs for which there are values; NaN if there are none.
fn mean_of_runs(
    runs: &[Run<'_>],
    axes: &[bool],
    of_run: impl Fn(&[f64]) -> Option<Vec<f64>>,
) -> Vec<f64> {
    let (mut sums, mut n) = (vec![0.0; axes.len()], 0.0);
    for values in runs.iter().filter_map(|run| of_run(run.loads)) {
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        n += 1.0;
    }
    sums.iter().map(|sum| sum / n).collect()
}

/// Returns the variance of each axis over all these recordings together. Each holds `n_samples × n_axes` loads.
fn variances(loads: &[&[f64]], n_axes: usize) -> Vec<f64> {
    let of_axis = |axis: usize| {
        let values = || loads.iter().flat_map(|own| own.iter().skip(axis).step_by(n_axes));
        let n = values().count() as f64;
        let mean = values().sum::<f64>() / n;
        values().map(|value| (value - mean).powi(2)).sum::<f64>() / n
    };
    (0..n_axes).map(of_axis).collect()
}

fn squared_changes(loads: &[f64], n_axes: usize, interval: usize) -> Vec<f64> {
    let mut sums = vec![0.0; n_axes];
    let later = loads[interval * n_axes..].chunks_exact(n_axes);
    let pairs = later.zip(loads.chunks_exact(n_axes));
    let n = loads.len() / n_axes - interval;
    let step = n.div_ceil(MOST_PAIRS).max(1);
    for (later, earlier) in pairs.step_by(step) {
        for ((sum, later), earlier) in sums.iter_mut().zip(later).zip(earlier) {
            *sum += (later - earlier).powi(2);
        }
    }
    sums.iter().map(|sum| sum / n.div_ceil(step) as f64).collect()
}

/// Returns the share of the samples from which on the load changes by less than these limits of some axes.
fn resting(loads: &[f64], n_axes: usize, interval: usize, limits: &[(usize, f64)]) -> f64 {
    let n = (loads.len() / n_axes).saturating_sub(interval);
    let step = n.div_ceil(MOST_PAIRS).max(1);
    let rests = |k: &usize| {
        let change = |axis: usize| loads[(k + interval) * n_axes + axis] - loads[k * n_axes + axis];
        limits.iter().all(|(axis, limit)| change(*axis).abs() < *limit)
    };
    let all = (0..n).step_by(step);
    all.clone().filter(rests).count() as f64 / all.count().max(1) as f64
}

/// Returns the median, the mean of the two middle values if their number is even.
pub fn middle(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(0.5 * (values[last / 2] + values[last.div_ceil(2)]))
}
