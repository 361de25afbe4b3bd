//! Studies of a part of the built-in sensor.

use crate::{
    calibration::{FitSettings, NoCrossValidation, RidgeChoice, Scores},
    features::{Blocks, Creep, Distance, FeatureSettings, Play, Polynomial, Thresholds},
    progress::Progress,
    questions::{
        error::AnalysisError,
        errors::query::analyse,
        request::Request,
        thresholds::{
            map::{Measure, ThresholdGrid, ThresholdMap},
            study::*,
        },
    },
    recording::{Entry, Recording, RecordingSet, Role, simulated},
    scoring::score_set::ScoreSet,
};
use std::sync::Arc;
use std::sync::Mutex;

/// Returns every `step`-th recording of the built-in sensor. Recordings of path 6 are test recordings.
fn some(step: usize) -> Arc<RecordingSet> {
    let mut set = RecordingSet::default();
    for entry in simulated::recordings(5).entries().iter().step_by(step) {
        set.push(entry.clone()).unwrap();
    }
    Arc::new(set)
}

fn settings(change: impl FnOnce(&mut FitSettings)) -> FitSettings {
    let mut settings = FitSettings { decimation: 4, ..FitSettings::default() };
    change(&mut settings);
    settings
}

fn prepared(recordings: Arc<RecordingSet>, settings: FitSettings) -> Study {
    Study::prepare(&Request::fit(recordings, settings), &Progress::default()).unwrap()
}

fn map_of(
    recordings: &Arc<RecordingSet>,
    settings: &FitSettings,
    f_ths: &[f64],
    t_ths_secs: &[f64],
) -> ThresholdMap {
    let progress = Progress::default();
    let study = prepared(Arc::clone(recordings), settings.clone());
    let grid = ThresholdGrid::new(f_ths.to_vec(), t_ths_secs.to_vec()).unwrap();
    study.threshold_map(None, &grid, &progress, &|_| {}).unwrap()
}

fn fresh(recordings: &Arc<RecordingSet>, settings: &FitSettings, at: Thresholds) -> [Scores; 2] {
    let mut settings = settings.clone();
    match settings.features.look_backs.first_mut() {
        Some(first) => *first = at,
        None => settings.features.look_backs = vec![at],
    }
    let request = Request::fit(Arc::clone(recordings), settings);
    let analysis = analyse(&request, &Progress::default()).unwrap();
    let quality = analysis.calibration.quality.clone();
    [quality.conventional, quality.compensated]
}

#[track_caller]
fn assert_equal(actual: &Scores, expected: &Scores, what: &str) {
    for set in ScoreSet::ALL {
        let (actual, expected) = (set.rmse(actual), set.rmse(expected));
        assert_eq!(actual.is_some(), expected.is_some(), "{what}, {set:?}");
        for (actual, expected) in actual.into_iter().flatten().zip(expected.into_iter().flatten()) {
            // If the weight hangs in the middle, moments are zero except for rounding.
            let error = (actual - expected).abs();
            assert!(error <= 1e-9 * expected + 1e-14, "{what}, {set:?}: {actual} {expected}");
        }
    }
}

#[track_caller]
fn assert_like_fresh_fits(recordings: &Arc<RecordingSet>, settings: &FitSettings) {
    let f_scale = match settings.features.distance {
        Distance::Force => 1.0,
        Distance::FullScale => 0.1,
    };
    let f_ths = [0.0, 1.5, 3.0, 9.0, 1000.0].map(|f_th| f_scale * f_th);
    let t_ths_secs = [0.0, 0.2, 3.0, 15.0];
    let map = map_of(recordings, settings, &f_ths, &t_ths_secs);
    for f_at in 0..f_ths.len() {
        for t_at in 0..t_ths_secs.len() {
            let at = map.thresholds(f_at, t_at);
            let [conventional, compensated] = fresh(recordings, settings, at);
            assert_equal(&map.conventional.scores, &conventional, "conventional");
            let scores = &map.point(f_at, t_at).unwrap().scores;
            assert_equal(scores, &compensated, &format!("{at:?}"));
        }
    }
}

#[test]
fn every_value_of_the_map_is_that_of_a_fresh_fit() {
    let recordings = some(9);
    assert_like_fresh_fits(&recordings, &settings(|_| {}));
    assert_like_fresh_fits(&recordings, &settings(|s| s.offset = false));
    assert_like_fresh_fits(&recordings, &settings(|s| s.features.distance = Distance::FullScale));
}

#[test]
fn with_two_recordings_an_automatic_ridge_is_that_of_a_fit() {
    let recordings = some(1);
    let mut two = RecordingSet::default();
    for at in [0, 20, 80] {
        two.push(recordings.entries()[at].clone()).unwrap();
    }
    let two = Arc::new(two);
    assert_like_fresh_fits(&two, &settings(|s| s.ridge = RidgeChoice::Auto));
}

#[test]
fn other_blocks_and_further_look_backs_stay_as_they_are() {
    let further = Thresholds { f_th: 6.0, t_th_secs: 4.0 };
    let blocks = settings(|s| {
        s.features.look_backs.push(further);
        let blocks = Blocks::default().with(&Creep, &[6.0]);
        s.features.blocks = blocks.with(&Play, &[0.3]).with(&Polynomial, &[2.0]);
    });
    assert_like_fresh_fits(&some(15), &blocks);
}

#[test]
fn a_ridge_is_that_of_a_fresh_fit_fixed_or_chosen() {
    let recordings = some(15);
    for ridge in [RidgeChoice::Strength(0.02), RidgeChoice::Auto] {
        assert_like_fresh_fits(&recordings, &settings(|s| s.ridge = ridge));
    }
}

#[test]
fn one_or_two_recordings_are_left_out_by_blocks() {
    let first_two = |n| {
        let mut set = RecordingSet::default();
        let all = simulated::recordings(5);
        all.entries()[..n].iter().for_each(|e| set.push(e.clone()).unwrap());
        Arc::new(set)
    };
    for n in [1, 2] {
        assert_like_fresh_fits(&first_two(n), &settings(|_| {}));
    }
    let map = map_of(&first_two(2), &settings(|_| {}), &[3.0], &[15.0]);
    assert!(map.cross_validation.is_by_block());
    assert_eq!(map.part_samples.len(), 5);
}

#[test]
fn without_a_look_back_one_is_added() {
    let none = settings(|s| s.features = FeatureSettings::present());
    let recordings = some(30);
    let map = map_of(&recordings, &none, &[3.0], &[15.0]);
    let added = fresh(&recordings, &settings(|_| {}), Thresholds::default());
    assert_equal(&map.point(0, 0).unwrap().scores, &added[1], "added");
}

#[test]
fn without_past_samples_the_errors_are_exactly_conventional() {
    let map = map_of(&some(30), &settings(|_| {}), &[0.0, 3.0, 1e6], &[0.0, 15.0]);
    for (f_at, t_at) in [(0, 0), (0, 1), (1, 0), (2, 0), (2, 1)] {
        assert_eq!(map.point(f_at, t_at), Some(&map.conventional), "{f_at} {t_at}");
    }
    assert_ne!(map.point(1, 1), Some(&map.conventional));
}

#[test]
fn each_row_is_shown_once_and_the_rows_make_the_map() {
    let shown = Mutex::new(Vec::new());
    let study = prepared(some(30), settings(|_| {}));
    let f_ths = (0..9).map(f64::from).collect();
    let grid = ThresholdGrid::new(f_ths, vec![1.0, 5.0]).unwrap();
    let progress = Progress::default();
    let show = |map: &ThresholdMap| shown.lock().unwrap().push(map.clone());
    let map = study.threshold_map(None, &grid, &progress, &show).unwrap();
    assert!(map.is_complete());
    let shown = shown.into_inner().unwrap();
    assert!(shown.iter().map(ThresholdMap::n_rows_done).eq(0..=9));
    for pair in shown.windows(2) {
        let kept = |at: &usize| {
            pair[0].point(*at, 0).is_none_or(|point| pair[1].point(*at, 0) == Some(point))
        };
        assert!((0..9).all(|at| kept(&at)));
    }
    assert_eq!(shown.last(), Some(&map));
    assert_eq!(progress.fraction(), Some(1.0));
}

#[test]
fn a_cancelled_map_ends_after_its_current_row() {
    let study = prepared(some(30), settings(|_| {}));
    let grid = ThresholdGrid::new((0..200).map(f64::from).collect(), vec![5.0]).unwrap();
    let progress = Progress::default();
    let rows = Mutex::new(0);
    let result = study.threshold_map(None, &grid, &progress, &|map| {
        *rows.lock().unwrap() = map.n_rows_done();
        if map.n_rows_done() > 0 {
            progress.cancel();
        }
    });
    assert!(matches!(result, Err(AnalysisError::Cancelled(_))));
    assert!(rows.into_inner().unwrap() < 50);
}

#[test]
fn test_recordings_take_no_part_in_any_suggestion() {
    let all = some(15);
    let mut training = RecordingSet::default();
    let trained = all.entries().iter().filter(|entry| entry.role == Role::Train);
    trained.for_each(|entry| training.push(entry.clone()).unwrap());
    assert!(training.entries().len() < all.entries().len());
    let suggested = |set: Arc<RecordingSet>| {
        let map = map_of(&set, &settings(|_| {}), &[0.0, 1.5, 3.0, 6.0], &[5.0, 15.0]);
        let progress = Progress::default();
        let study = prepared(set, settings(|_| {}));
        let block = |block| study.suggest_block(block, Measure::Forces, &progress).unwrap();
        (
            map.suggestion(Measure::Forces).unwrap(),
            study.mean_hysteresis(),
            study.past_ages(Thresholds::default()),
            [&Play as HistoryBlock, &Creep].map(block),
        )
    };
    assert_eq!(suggested(Arc::new(training)), suggested(all));
}

#[test]
fn recordings_too_short_to_leave_a_part_out_are_refused_with_a_remedy() {
    let all = simulated::recordings(5);
    let short = |n: usize| -> Recording {
        let recording = &all.entries()[0].recording;
        let fraction = n as f64 / recording.n_samples() as f64;
        recording.split(fraction).unwrap().0
    };
    for n in [1, 12] {
        let mut set = RecordingSet::default();
        set.push(Entry::new(short(n), Role::Train)).unwrap();
        let study = prepared(Arc::new(set), FitSettings::default());
        let grid = ThresholdGrid::new(vec![3.0], vec![15.0]).unwrap();
        let result = study.threshold_map(None, &grid, &Progress::default(), &|_| {});
        assert!(
            matches!(
                result,
                Err(AnalysisError::NoCrossValidation(NoCrossValidation::FewSamplesFor { .. }))
            ),
            "{n}"
        );
        let block = study.suggest_block(&Play, Measure::Forces, &Progress::default());
        assert!(
            matches!(
                block,
                Err(AnalysisError::NoCrossValidation(NoCrossValidation::FewSamplesFor { .. }))
            ),
            "{n}"
        );
    }
    let untrained = Request::fit(Arc::default(), FitSettings::default());
    let prepared = Study::prepare(&untrained, &Progress::default());
    assert!(matches!(prepared, Err(AnalysisError::NoRecordings)));
}

#[test]
fn the_error_of_a_suggested_list_is_that_of_its_fit() {
    let recordings = some(12);
    let plain = settings(|s| s.features = FeatureSettings::present());
    let progress = Progress::default();
    let study = prepared(Arc::clone(&recordings), plain.clone());
    for block in [&Play as HistoryBlock, &Creep] {
        let found = study.suggest_block(block, Measure::FullScale, &progress).unwrap();
        assert!(!found.values.is_empty() && found.values.is_sorted());
        let mut with = plain.clone();
        with.features.blocks.set(block, found.values.clone());
        let request = Request::fit(Arc::clone(&recordings), with);
        let quality = analyse(&request, &progress).unwrap().calibration.quality.clone();
        let measure = |scores: &Scores| {
            Measure::FullScale.of_rmse(&study.scale(), scores.cv_rmse.as_ref().unwrap())
        };
        let [with, without] = [&quality.compensated, &quality.conventional].map(measure);
        assert!((found.left_out / with.unwrap() - 1.0).abs() < 1e-9, "{found:?}");
        assert!((found.left_out_without / without.unwrap() - 1.0).abs() < 1e-9);
        assert!(found.left_out < found.left_out_without);
    }
}

/// Applies the paper's rule and cross-validation to the simulated sensor, whose mean hysteresis is 2.64 N.
#[test]
fn the_mean_hysteresis_of_the_built_in_sensor_is_near_its_design() {
    let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
    let study = prepared(recordings, FitSettings::default());
    let found = study.mean_hysteresis();
    assert!((found.value.unwrap() - 2.64).abs() < 0.5, "{found:?}");
    assert!(!found.rests_on_few());
}
