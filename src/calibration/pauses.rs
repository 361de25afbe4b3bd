//! Measures how long a pause may be for the states of feature blocks to be worth keeping.
//!
//! Guarantees: a memory is kept only after pauses for which the load errs less with the kept state than with a new one, on
//! training recordings with artificial pauses. No single pause decides. The number of samples is bounded.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::{
    calibration::{
        calibration::Calibration, choice::Blocks, estimator::Estimator, linear_map::LinearMap,
        sums::Piece,
    },
    features::next_share,
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
    /// Parts that cross-validation leaves out; may be empty.
    pieces: &'a [Piece],
}

/// Returns for each memory the longest pause (s) after which the load errs less if the memory is kept. Memories that should start
/// anew after every pause above [`Calibration::gap_secs`] are missing.
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
    // A pause of this duration makes a time step that is longer by the time between two samples.
    let step_secs = calibration.step_secs().unwrap_or(0.0) * calibration.decimation as f64;
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
            let compared = blocks.compare(&best, &without);
            if compared.difference < 0.0 && compared.trimmed < 0.0 {
                longest.insert(memory.to_owned(), pause_secs + step_secs);
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
        let (start, all_secs) = (*times.first()?, recording.duration_secs());
        // This is the mean step. The median step would be too short if samples come in bursts.
        let step_secs = all_secs / times.len() as f64;
        let (fewest, most) = BETWEEN_SAMPLES;
        let wanted = BETWEEN_SECS.clamp(fewest * step_secs, most * step_secs);
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
        (between.len() > 1).then_some(Self { recording, between, pieces: &[] })
    }

    /// Returns the squared error of the load of a sample, summed over the axes and divided by the squared full scale.
    fn square(&self, k: usize, loads: impl Iterator<Item = f64>, full_scale: &[f64]) -> f64 {
        let reference = &self.recording.loads()[k * full_scale.len()..];
        let axes = loads.zip(reference).zip(full_scale).filter(|(_, scale)| **scale > 0.0);
        axes.map(|((load, reference), scale)| ((load - reference) / scale).powi(2)).sum()
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

/// Strengths of the fade that [`measured_fade`] tries, in equal ratios. A strength is the unknown part u of the load directly
/// after a start.
const FADES: [f64; 17] = [
    1.0, 1.78, 3.16, 5.62, 10.0, 17.8, 31.6, 56.2, 100.0, 178.0, 316.0, 562.0, 1e3, 1780.0, 3160.0,
    5620.0, 1e4,
];
/// A fade is used if the root mean square error after cold starts falls below this share of that without a fade.
const WORTH_FADING: f64 = 0.99;
/// Largest unknown part u of the load in the middle of the training samples. At least a fifth of the compensation counts there.
const MOST_USUAL: f64 = 2.0;
/// No fade is used if the root mean square error after cold starts is below this share of the conventional one: the
/// compensation then helps from the start.
const GOOD_START: f64 = 0.9;

/// Returns the factors of [`Calibration::fade`] with which the load errs least in the first [`BETWEEN_SECS`] after cold starts,
/// all over the training recordings; empty if the load errs hardly more without a fade, or clearly less than the conventional
/// load. `calibration` must have none.
///
/// Each recording comes with its parts for cross-validation. For each part, `left_out` has the linear map of a fit to the other
/// parts. The loads of the part are computed with this map, because a fit errs less on samples to which it was fitted. If
/// `left_out` is empty, all loads are those of the calibration.
pub(crate) fn measured_fade<'a>(
    calibration: &Calibration,
    recordings: impl Iterator<Item = (&'a Recording, &'a [Piece])>,
    left_out: &[LinearMap],
    progress: &Progress,
) -> Result<Vec<Vec<f64>>, Cancelled> {
    let (mut factors, usual) = calibration.fade_factors();
    let usable = recordings
        .filter(|(recording, _)| !recording.is_static() && *recording.axes() == calibration.axes);
    let prepared: Result<Vec<_>, _> = usable
        .map(|(recording, pieces)| calibration.prepared(recording).map(|found| (found, pieces)))
        .collect();
    let (Ok(recordings), false) = (prepared, factors.is_empty()) else { return Ok(Vec::new()) };
    let runs = recordings
        .iter()
        .filter_map(|(recording, pieces)| Some(Run { pieces, ..Run::of(recording, 0.0)? }));
    let runs = some_of(runs.collect());
    let design = calibration.design();
    let without_part =
        |map: &LinearMap| Calibration { compensated: Some(map.clone()), ..calibration.clone() };
    let without_part: Vec<Calibration> = left_out.iter().map(without_part).collect();
    let of_run = |run: &Run<'_>| {
        let mut squares = [0.0; FADES.len() + 2];
        for (first, end) in run.between.iter().copied() {
            progress.check().ok()?;
            let piece = run.pieces.iter().find(|piece| piece.samples.contains(&first));
            let fitted = piece.and_then(|piece| without_part.get(piece.fold));
            let mut estimator = Estimator::new(fitted.unwrap_or(calibration), &design).ok()?;
            let mut faded = [1.0; FADES.len()];
            for k in first..end {
                let Ok((_, loads)) = estimator.update_at(run.recording, k) else { continue };
                let compensated = loads.to_vec();
                let unknown = estimator.unknown(&factors);
                for (share, fade) in faded.iter_mut().zip(FADES) {
                    *share = next_share(*share, fade * unknown);
                }
                // The compensated and the conventional load come first.
                for (square, share) in squares.iter_mut().zip([1.0, 0.0].iter().chain(&faded)) {
                    let loads = compensated.iter().zip(estimator.conventional());
                    let loads = loads.map(|(load, before)| before + share * (load - before));
                    *square += run.square(k, loads, &calibration.full_scale);
                }
            }
        }
        Some(squares)
    };
    let of_runs: Option<Vec<_>> = runs.par_iter().map(of_run).collect();
    let mut squares = [0.0; FADES.len() + 2];
    for of_run in of_runs.ok_or(Cancelled)? {
        squares.iter_mut().zip(of_run).for_each(|(sum, square)| *sum += square);
    }
    let [without, conventional, with @ ..] = squares;
    if without < GOOD_START * GOOD_START * conventional {
        return Ok(Vec::new());
    }
    let tried = with.into_iter().zip(FADES).filter(|(_, fade)| fade * usual <= MOST_USUAL);
    let tried = tried.min_by(|(a, _), (b, _)| a.total_cmp(b));
    let worth = tried.filter(|(square, _)| *square < WORTH_FADING * WORTH_FADING * without);
    let Some((_, fade)) = worth else { return Ok(Vec::new()) };
    factors.iter_mut().flatten().for_each(|factor| *factor *= fade);
    Ok(factors)
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
        let mut square = |k: usize| match estimator.update_at(run.recording, k) {
            Ok((_, loads)) => run.square(k, loads.iter().copied(), &calibration.full_scale),
            Err(_) => 0.0,
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::{FitSettings, RidgeChoice, Scores, Status};
    use crate::features::{Blocks, Creep, FeatureSettings, MOST_RISE, Play, Thresholds};
    use crate::questions::{Request, train};
    use crate::random::Random;
    use crate::recording::{Axis, Entry, RecordingSet, Role, Source};

    /// Returns recordings of a gauge with a play of ± 0.3 N at 20 Hz, whose load goes to and fro between random turning points at
    /// this speed (N/s).
    fn sensor(speed: f64) -> Vec<Recording> {
        let recording = |at: u64| {
            let mut random = Random::new(3, &[at]);
            let (mut load, mut goal, mut play) = (0.0, 1.0, 0.0);
            let (mut gauges, mut loads) = (Vec::new(), Vec::new());
            for _ in 0..6000 {
                let left: f64 = goal - load;
                load += left.clamp(-speed / 20.0, speed / 20.0);
                if left.abs() < speed / 20.0 {
                    goal = -goal.signum() * random.between(0.8, 1.2);
                }
                play = f64::clamp(play, load - 0.3, load + 0.3);
                gauges.push(2.0 * load + play + 0.01 * random.normal());
                loads.push(load);
            }
            let times = (0..6000).map(|k| f64::from(k) / 20.0).collect();
            let (name, names) = (format!("r{at}"), vec!["S1".to_owned()]);
            Recording::new(name, Source::Simulated, times, names, gauges, vec![Axis::Fz], loads)
        };
        (0..4).map(|at| recording(at).unwrap()).collect()
    }

    fn fitted(recordings: &[Recording], features: FeatureSettings) -> Calibration {
        let mut set = RecordingSet::default();
        for recording in recordings {
            set.push(Entry::new(recording.clone(), Role::Train)).unwrap();
        }
        let settings = FitSettings { features, ridge: RidgeChoice::Auto, ..FitSettings::default() };
        let request = Request::fit(Arc::new(set), settings);
        train(&request, &Progress::default(), &mut |_| {}).unwrap()
    }

    fn play() -> FeatureSettings {
        FeatureSettings {
            blocks: Blocks::default().with(&Play, &[0.1, 0.2, 0.4]),
            ..FeatureSettings::present()
        }
    }

    /// The load turns back every 20 s. So after a pause of 5 s, the play is mostly where it was before.
    #[test]
    fn play_is_kept_through_pauses_in_which_the_load_hardly_turns() {
        let recordings = sensor(0.1);
        let calibration = fitted(&recordings, play());
        assert!((calibration.gap_secs - 1.0).abs() < 1e-9);
        let found = measured_pauses(&calibration, recordings.iter(), &Progress::default());
        assert!(found.unwrap()["play_radii"] >= 5.0);
        let short = recordings[0].segment(0..100);
        let found = measured_pauses(&calibration, [&short].into_iter(), &Progress::default());
        assert_eq!(found, Ok(BTreeMap::new()));
        let progress = Progress::default();
        progress.cancel();
        assert_eq!(measured_pauses(&calibration, recordings.iter(), &progress), Err(Cancelled));
    }

    /// The load turns every second. So after a pause, the past sample of the look-back is on the wrong side in half of the cases.
    #[test]
    fn a_look_back_is_forgotten_where_keeping_it_would_be_worse() {
        let recordings = sensor(2.0);
        let features = FeatureSettings {
            look_backs: vec![Thresholds { f_th: 0.7, t_th_secs: 60.0 }],
            ..FeatureSettings::present()
        };
        let calibration = fitted(&recordings, features);
        let runs: Vec<Run<'_>> =
            recordings.iter().map(|recording| Run::of(recording, 5.0).unwrap()).collect();
        let error = |kept: &[&str]| {
            let (_, squares) = squares(&calibration, kept, &runs, &Progress::default()).unwrap();
            squares.iter().sum::<f64>()
        };
        assert!(error(&["stored_samples"]) > error(&[]));
        let found = measured_pauses(&calibration, recordings.iter(), &Progress::default());
        assert!(found.unwrap().get("stored_samples").is_none_or(|secs| *secs < 5.0));
    }

    /// The load rests in the pause. So the loads with kept states are those without the pause, and those of new states are not.
    #[test]
    fn kept_play_goes_on_as_if_the_load_had_rested() {
        let recordings = sensor(0.1);
        let mut calibration = fitted(&recordings, play());
        let design = calibration.design();
        let run = |calibration: &Calibration, pause_secs: f64| -> Vec<(Status, f64)> {
            let mut estimator = Estimator::new(calibration, &design).unwrap();
            let samples = (0..2000).map(|k| {
                let time = recordings[0].times()[k] + if k < 1000 { 0.0 } else { pause_secs };
                let (status, load) = estimator.update(time, recordings[0].gauges_at(k)).unwrap();
                (status, load[0])
            });
            samples.collect()
        };
        let whole = run(&calibration, 0.0);
        assert_ne!(run(&calibration, 4.0)[1000].1, whole[1000].1);
        calibration.keep_secs.insert("play_radii".to_owned(), 5.0);
        let kept = run(&calibration, 4.0);
        assert!(kept.iter().zip(&whole).all(|(kept, whole)| kept.1 == whole.1));
        assert!(kept[1000].0.has(Status::AFTER_GAP));
        assert_ne!(run(&calibration, 5.0)[1000].1, whole[1000].1);
    }

    /// Returns a recording of a gauge that creeps by half of its load with a time constant of 6 s. The load is a fast motion around
    /// a slow one, so that the present gauge alone tells most of the load, but not its mean.
    fn creeping(seed: u64) -> Recording {
        let mut random = Random::new(seed, &[]);
        let (mut creep, mut slow, mut goal) = (0.0, 0.0, 0.0);
        let (mut gauges, mut loads) = (Vec::new(), Vec::new());
        for k in 0..6000 {
            if k % 400 == 0 {
                goal = random.between(-0.6, 0.6);
            }
            slow += 0.01 * (goal - slow);
            let load = slow + (0.14 * f64::from(k)).sin();
            creep += -(-0.05_f64 / 6.0).exp_m1() * (load - creep);
            gauges.push(load + 0.5 * creep + 0.003 * random.normal());
            loads.push(load);
        }
        let times = (0..6000).map(|k| f64::from(k) / 20.0).collect();
        let (name, names) = (format!("r{seed}"), vec!["S1".to_owned()]);
        Recording::new(name, Source::Simulated, times, names, gauges, vec![Axis::Fz], loads)
            .unwrap()
    }

    /// Cuts a recording into pieces of `piece` samples, each of which starts cold. Returns the RMSE of the uncompensated and of the
    /// compensated load over all samples but the first `from` of each piece.
    fn cold_errors(
        calibration: &Calibration,
        recording: &Recording,
        piece: usize,
        from: usize,
    ) -> [f64; 2] {
        let mut squares = [0.0; 2];
        let mut n = 0;
        for start in (0..recording.n_samples()).step_by(piece) {
            let run = recording.segment(start..start + piece);
            let applied = calibration.apply(&run).unwrap();
            for k in from..piece {
                n += 1;
                let errors = [&applied.conventional, &applied.compensated];
                let errors = errors.map(|loads| loads[k] - run.loads()[k]);
                squares = [0, 1].map(|at| squares[at] + errors[at] * errors[at]);
            }
        }
        squares.map(|square: f64| (square / f64::from(n)).sqrt())
    }

    fn creep() -> FeatureSettings {
        FeatureSettings {
            blocks: Blocks::default().with(&Creep, &[4.0]),
            ..FeatureSettings::present()
        }
    }

    /// With the state of the creep unknown, the coefficient of the gauge is that of a load that has rested for long.
    #[test]
    fn a_load_fades_in_where_unknown_states_would_make_it_worse_than_the_conventional_one() {
        let recordings: Vec<Recording> = (1..4).map(creeping).collect();
        let calibration = fitted(&recordings, creep());
        assert!(!calibration.fade.is_empty());
        let plain = Calibration { fade: BTreeMap::new(), ..calibration.clone() };
        let fresh = creeping(9);
        let [conventional, faded] = cold_errors(&calibration, &fresh, 40, 0);
        let [_, without] = cold_errors(&plain, &fresh, 40, 0);
        assert!(without > 1.1 * conventional, "{without} {conventional}");
        assert!(faded < 0.9 * without, "{faded} {without}");
        let [conventional, faded] = cold_errors(&calibration, &fresh, 200, 0);
        let [_, without] = cold_errors(&plain, &fresh, 200, 0);
        assert!(faded < conventional && faded < without, "{faded} {conventional} {without}");
        let [_, warm] = cold_errors(&calibration, &fresh, 6000, 1200);
        let [_, warm_without] = cold_errors(&plain, &fresh, 6000, 1200);
        assert!((warm / warm_without - 1.0).abs() < 0.01, "{warm} {warm_without}");
        // The share of the difference to the conventional load grows without a jump.
        let [applied, whole] = [&calibration, &plain].map(|model| model.apply(&fresh).unwrap());
        let mut last = (0, 0.0);
        for k in 0..fresh.n_samples() {
            let difference = whole.compensated[k] - whole.conventional[k];
            if difference.abs() > 0.01 {
                let share = (applied.compensated[k] - applied.conventional[k]) / difference;
                let (at, before) = std::mem::replace(&mut last, (k, share));
                let most = if at == 0 { 0.2 } else { before } + MOST_RISE * (k - at) as f64 + 1e-9;
                assert!((before - 1e-9..most).contains(&share), "{k}: {share}");
            }
        }
        assert!(last.1 > 0.999);
    }

    /// If fits to the other recordings err by far, the load of a cold start should stay near the conventional one for longer.
    #[test]
    fn a_fade_is_chosen_by_fits_to_the_other_recordings() {
        let recordings: Vec<Recording> = (1..4).map(creeping).collect();
        let mut calibration = fitted(&recordings, creep());
        calibration.fade.clear();
        let map = calibration.compensated.clone().unwrap();
        let mut other = map.clone();
        other.matrix[0][1] *= 3.0;
        let pieces = [Piece { samples: 0..6000, fold: 0 }];
        let strength = |left_out: &[LinearMap]| {
            let recordings = recordings.iter().map(|recording| (recording, &pieces[..]));
            let progress = Progress::default();
            measured_fade(&calibration, recordings, left_out, &progress).unwrap()[0][0]
        };
        assert_eq!(strength(&[map]), strength(&[]));
        assert!(strength(&[other]) > 3.0 * strength(&[]));
    }

    /// The errors of a fit are those of the loads that the calibration computes, also with a fade.
    #[test]
    fn the_errors_of_a_fit_contain_the_fade() {
        let recordings: Vec<Recording> = (1..5).map(creeping).collect();
        let calibration = fitted(&recordings, creep());
        assert!(!calibration.fade.is_empty());
        let [conventional, compensated] = [0, 1].map(|at| {
            let squares = recordings
                .iter()
                .map(|recording| cold_errors(&calibration, recording, 6000, 0)[at].powi(2));
            (squares.sum::<f64>() / 4.0).sqrt()
        });
        let known = |scores: &Scores| scores.train_rmse.as_ref().unwrap()[0];
        assert!((known(&calibration.quality.conventional) / conventional - 1.0).abs() < 1e-9);
        assert!((known(&calibration.quality.compensated) / compensated - 1.0).abs() < 1e-9);
        let json = serde_json::to_vec(&calibration.in_file()).unwrap();
        assert_eq!(Calibration::from_json(&json).unwrap().fade, calibration.fade);
        let broken = BTreeMap::from([("creep_secs".to_owned(), vec![1.0; 2])]);
        assert!(Calibration { fade: broken, ..calibration }.validate().is_err());
    }

    /// Play operators lower the error from their first reversal on, so a fade hardly changes it.
    #[test]
    fn a_fade_costs_no_accuracy_where_the_compensation_helps_at_once() {
        let recordings = sensor(2.0);
        let calibration = fitted(&recordings[..3], play());
        let plain = Calibration { fade: BTreeMap::new(), ..calibration.clone() };
        let [conventional, faded] = cold_errors(&calibration, &recordings[3], 200, 0);
        let [_, without] = cold_errors(&plain, &recordings[3], 200, 0);
        assert!(faded < 0.5 * conventional && faded < 1.01 * without, "{faded} {without}");
    }
}
