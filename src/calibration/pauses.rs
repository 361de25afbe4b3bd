//! Measures how long a pause may be for the states of feature blocks to be worth keeping.
//!
//! Guarantees: a memory is kept only after pauses for which the load errs less with the kept state than with a new one, with
//! 90 % confidence, on training recordings with artificial pauses. The number of samples is bounded.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::{
    calibration::{calibration::Calibration, choice::Blocks, estimator::Estimator},
    progress::{Cancelled, Progress},
    recording::Recording,
};

/// Durations of the artificial pauses (s). A longer pause is tried only if the state is worth keeping after all shorter ones.
const PAUSES_SECS: [f64; 9] = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
/// Time between two artificial pauses (s), and limits of the number of samples in it.
const BETWEEN_SECS: f64 = 10.0;
const BETWEEN_SAMPLES: (f64, f64) = (50.0, 2000.0);
/// Longer than every artificial pause.
const ALWAYS_SECS: f64 = 1e6;
/// Minimum number of artificial pauses.
const FEWEST: usize = 6;
/// Approximate maximum number of samples for which loads are computed with each pause.
const MOST_SAMPLES: usize = 20_000;

/// Part of a recording with artificial pauses: the first and the last index of the samples between them.
struct Run<'a> {
    recording: &'a Recording,
    between: Vec<(usize, usize)>,
}

/// Returns the longest pause (s) after which each memory of the calibration's features is worth keeping, for the memories that
/// are worth it after pauses that are longer than [`Calibration::gap_secs`].
pub(crate) fn measured_pauses<'a>(
    calibration: &Calibration,
    recordings: impl Iterator<Item = &'a Recording>,
    progress: &Progress,
) -> Result<BTreeMap<String, f64>, Cancelled> {
    let mut kept = calibration.features.memories();
    let mut longest = BTreeMap::new();
    if kept.is_empty() {
        return Ok(longest);
    }
    let usable = recordings
        .filter(|recording| !recording.is_static() && *recording.axes() == calibration.axes);
    let decimated: Vec<Recording> =
        usable.map(|recording| recording.decimated(calibration.decimation)).collect();
    let prepared: Result<Vec<_>, _> =
        decimated.iter().map(|recording| calibration.prepared(recording)).collect();
    let Ok(recordings) = prepared else { return Ok(longest) };
    for pause_secs in PAUSES_SECS.into_iter().filter(|secs| *secs > calibration.gap_secs) {
        let runs: Vec<Run<'_>> =
            recordings.iter().filter_map(|recording| Run::of(recording, pause_secs)).collect();
        let runs = some_of(runs);
        if runs.iter().map(|run| run.between.len() - 1).sum::<usize>() < FEWEST {
            break;
        }
        let with = |memories: &[&str]| squares(calibration, memories, &runs, progress);
        let (blocks, mut best) = with(&kept)?;
        for memory in kept.clone() {
            let others: Vec<&str> = kept.iter().copied().filter(|other| *other != memory).collect();
            let (_, without) = with(&others)?;
            if blocks.is_below(&best, &without, 1.0) {
                longest.insert(memory.to_owned(), pause_secs);
            } else {
                (kept, best) = (others, without);
            }
        }
        if kept.is_empty() {
            break;
        }
    }
    Ok(longest)
}

impl<'a> Run<'a> {
    /// Places pauses of this duration (s) in the recording, with equal times between them. Returns `None` if the recording is
    /// too short.
    fn of(recording: &'a Recording, pause_secs: f64) -> Option<Self> {
        let times = recording.times();
        let step_secs = recording.rate_hz()?.recip();
        let (fewest, most) = BETWEEN_SAMPLES;
        let wanted = BETWEEN_SECS.clamp(fewest * step_secs, most * step_secs);
        let (start, all_secs) = (*times.first()?, recording.duration_secs());
        let n_pauses = (all_secs / (pause_secs + wanted)).floor().max(1.0);
        let between_secs = (all_secs - n_pauses * pause_secs) / (n_pauses + 1.0);
        if between_secs < wanted.min(0.5 * pause_secs).max(fewest * step_secs) {
            return None;
        }
        let between = (0..=n_pauses as usize).map(|at| {
            let from = start + at as f64 * (pause_secs + between_secs);
            let index = |secs: f64| times.partition_point(|time| *time < secs);
            (index(from), index(from + between_secs))
        });
        let between = between.filter(|(first, end)| first < end).collect::<Vec<_>>();
        (between.len() > 1).then_some(Self { recording, between })
    }

    fn n_samples(&self) -> usize {
        self.between.iter().map(|(first, end)| end - first).sum()
    }
}

/// Returns evenly spread runs, and the first pauses of each, with about [`MOST_SAMPLES`] samples in all.
fn some_of(mut runs: Vec<Run<'_>>) -> Vec<Run<'_>> {
    let n_samples: usize = runs.iter().map(Run::n_samples).sum();
    let each = n_samples.div_ceil(MOST_SAMPLES).min(runs.len().div_ceil(FEWEST)).max(1);
    runs = runs.into_iter().step_by(each).collect();
    let share = MOST_SAMPLES / runs.len().max(1);
    for run in &mut runs {
        let one = run.n_samples() / run.between.len();
        run.between.truncate((share / one.max(1)).max(2));
    }
    runs
}

/// Returns the squared errors of the loads after each pause, summed over the axes and divided by the squared full scale, if these
/// memories are kept through all pauses and all others start anew.
fn squares(
    calibration: &Calibration,
    kept: &[&str],
    runs: &[Run<'_>],
    progress: &Progress,
) -> Result<(Blocks, Vec<f64>), Cancelled> {
    let keep_secs = kept.iter().map(|memory| ((*memory).to_owned(), ALWAYS_SECS)).collect();
    let calibration = Calibration { keep_secs, ..calibration.clone() };
    let design = calibration.design();
    let of_run = |(at, run): (usize, &Run<'_>)| {
        if progress.is_cancelled() {
            return None;
        }
        let mut estimator = Estimator::new(&calibration, &design).ok()?;
        let recording = run.recording;
        let uses_auxiliary = !calibration.features.auxiliary.is_empty();
        let mut square = |k: usize| {
            let auxiliary = if uses_auxiliary { recording.auxiliary().at(k) } else { &[] };
            let time = recording.times()[k];
            let Ok((_, loads)) = estimator.update_with(time, recording.gauges_at(k), auxiliary)
            else {
                return 0.0;
            };
            let reference = &recording.loads()[k * loads.len()..][..loads.len()];
            let axes = loads.iter().zip(reference).zip(&calibration.full_scale);
            let axes = axes.filter(|(_, scale)| **scale > 0.0);
            axes.map(|((load, reference), scale)| ((load - reference) / scale).powi(2)).sum()
        };
        let blocks = run.between.iter().map(|(first, end)| {
            ((end - first) as f64, at, (*first..*end).map(&mut square).sum::<f64>())
        });
        let blocks: Vec<(f64, usize, f64)> = blocks.collect();
        Some(blocks)
    };
    let of_runs: Option<Vec<_>> = runs.par_iter().enumerate().map(of_run).collect();
    let (mut blocks, mut squares) = (Blocks::default(), Vec::new());
    // The samples before the first pause do not depend on what is kept.
    for (n, group, square) in
        of_runs.ok_or(Cancelled)?.into_iter().flat_map(|run| run.into_iter().skip(1))
    {
        blocks.samples.push(n);
        blocks.groups.push(group);
        squares.push(square);
    }
    Ok((blocks, squares))
}
