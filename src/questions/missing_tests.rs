//! Asks every question about recordings that lack gauges, a load, times or samples.

use std::sync::Arc;
use std::time::Duration;

use crate::{
    calibration::{FitSettings, Regressor},
    features::{BLOCKS, Block, FeatureSettings},
    progress::Progress,
    questions::{
        Analysis,
        AnalysisError::{self, Missing as Lacks},
        Candidates, Datasets, OnScreen, Request, Search, Study, WITHIN, analyse,
        channels::query::ChannelQuestion,
        check::query::{CheckData, sufficiency},
        expected_error, find_best,
        history::coarse_history,
        loops::{
            Channel, CrossQuestion, DwellQuestion, Inks, LookRequest, LoopQuestion, Question, Span,
            TableOf, Up, look,
        },
        metrology::MetrologySettings,
        page::{ReportRequest, report},
        question::Unanswered,
        thresholds::ThresholdGrid,
        train,
    },
    recording::{
        self, Axis, Entry, Missing, Recording, RecordingSet, Role, Source, Tare, ValidRange,
    },
    report::Trace,
    scoring::loops::Frame,
};

/// Order of the samples of a made recording.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    Times,
    Rows,
    Cases,
}

/// Returns recordings with these numbers of gauges, axes, and samples. Each has one other channel, whose values are partly
/// missing.
fn recordings(n_gauges: usize, axes: &[Axis], n: usize, order: Order) -> Arc<RecordingSet> {
    let mut set = RecordingSet::default();
    for at in 0..3 {
        let load = |k: usize| (0.7 * k as f64 + at as f64).sin() * 10.0;
        let gauge = |k: usize, gauge: usize| load(k) * (1.0 + gauge as f64) + 0.1 * (k % 3) as f64;
        let axis = |k: usize, axis: usize| load(k + axis);
        let recording = Recording::new(
            format!("r{at}"),
            Source::File("table.csv".into()),
            (0..n).map(|k| k as f64).collect(),
            (0..n_gauges).map(|gauge| format!("S{gauge}")).collect(),
            (0..n).flat_map(|k| (0..n_gauges).map(move |at| gauge(k, at))).collect(),
            axes.to_vec(),
            (0..n).flat_map(|k| (0..axes.len()).map(move |at| axis(k, at))).collect(),
        );
        let other = (0..n).map(|k| if k % 5 == 4 { f64::NAN } else { k as f64 });
        let other = other.collect();
        let recording = recording.unwrap();
        let recording = recording.with_others(vec!["x".into()], vec!["mm".into()], other).unwrap();
        let recording = match order {
            Order::Times => recording,
            Order::Rows => recording.in_row_order(),
            Order::Cases => recording.without_times(),
        };
        let role = if at == 2 { Role::Test } else { Role::Train };
        set.push(Entry::new(recording, role)).unwrap();
    }
    Arc::new(set)
}

/// Calls `check` for every combination of missing parts.
fn for_all(check: impl Fn(&Arc<RecordingSet>)) {
    for n_gauges in [0, 1, 3] {
        for axes in [&[][..], &[Axis::Fz], &[Axis::Fx, Axis::Mz]] {
            for n in [1, 2, 3, 60] {
                for order in [Order::Times, Order::Rows, Order::Cases] {
                    println!("{n_gauges} gauges, {} axes, {n} samples, {order:?}", axes.len());
                    check(&recordings(n_gauges, axes, n, order));
                }
            }
        }
    }
}

/// Checks that an answer is there if nothing is missing, or an error with another reason. Otherwise it is the missing part.
#[track_caller]
fn assert_says<T>(answer: Result<T, AnalysisError>, missing: Option<Missing>) {
    let said = match answer {
        Err(Lacks(missing)) => Some(missing),
        Err(AnalysisError::Panicked(panicked)) => panic!("{panicked}"),
        _ => None,
    };
    assert_eq!(said, missing);
}

fn settings_of_every_block() -> Vec<FitSettings> {
    let plain = FitSettings { features: FeatureSettings::present(), ..FitSettings::default() };
    let of_block = |block: &&'static dyn Block| {
        let mut settings = plain.clone();
        settings.features.blocks.set(*block, block.setting().default.to_vec());
        settings
    };
    [FitSettings::default(), plain.clone()].into_iter().chain(BLOCKS.iter().map(of_block)).collect()
}

#[test]
fn a_fit_says_what_is_missing() {
    for_all(|set| {
        for settings in settings_of_every_block() {
            let request = Request::fit(Arc::clone(set), settings);
            assert_says(analyse(&request, &Progress::default()), set.missing());
        }
    });
}

#[test]
fn questions_about_recordings_say_what_is_missing() {
    for_all(|set| {
        let (missing, progress) = (set.missing(), Progress::default());
        let request = Request::fit(Arc::clone(set), FitSettings::default());
        let check = CheckData::of(&request, ValidRange::default());
        assert_says(sufficiency(&check, &progress), missing);
        assert_says(report(&ReportRequest::of(request.clone()), &progress), missing);
        assert_says(study(&request), missing);
        let kernel = FitSettings { regressor: Regressor::Kernel, ..FitSettings::default() };
        let kernel = Request::fit(Arc::clone(set), kernel);
        assert_says(train(&kernel, &progress, &mut |_| {}), missing);
        for candidates in [Candidates::All, Candidates::Paper] {
            let search = Search {
                recordings: Arc::clone(set),
                settings: FitSettings::default(),
                candidates,
                limit: Duration::ZERO,
                within: WITHIN,
            };
            let best = find_best(&search, &progress, &|_| {});
            // A model that cannot be fitted is listed with the reason.
            assert!(missing.is_none() || best.is_err() || best.unwrap().proposed().is_none());
        }
    });
}

fn study(request: &Request) -> Result<(), AnalysisError> {
    let progress = Progress::default();
    let study = Study::prepare(request, &progress)?;
    let grid = ThresholdGrid::covering(study.largest_distance(), 3, 3).unwrap();
    study.threshold_map(None, &grid, &progress, &|_| {}).map(drop)
}

/// The set of groups, faults, splits and taring need neither gauges nor a load.
#[test]
fn recordings_that_lack_something_are_split_and_searched_for_faults() {
    for_all(|set| {
        let n = set.entries().len();
        assert_eq!(set.groups().of.len(), n);
        assert!(set.split(0.5).entries().len() >= n);
        let faults = Datasets::default().faults(set, &ValidRange::default(), &Progress::default());
        assert_eq!(faults.unwrap().len(), n);
        for entry in set.entries() {
            let recording = Recording::clone(&entry.recording);
            let tared = recording.clone().tared(Tare::Interval(0.0, 1.0));
            let is_possible = recording.n_gauges() > 0 && !recording.is_static();
            assert_eq!(tared.is_ok(), is_possible);
            drop(recording.tared(Tare::Auto));
        }
    });
}

/// A calibration of the same gauges can be applied without a load, and every plot of its loads is drawn or says why not.
#[test]
fn a_calibration_is_applied_to_gauges_alone() {
    let fit = Request::fit(
        recordings(3, &[Axis::Fx, Axis::Mz], 60, Order::Times),
        FitSettings::default(),
    );
    let calibration = analyse(&fit, &Progress::default()).unwrap().calibration;
    for_all(|set| {
        let request = Request {
            calibration: Some(Arc::clone(&calibration)),
            ..Request::fit(Arc::clone(set), FitSettings::default())
        };
        let applied = analyse(&request, &Progress::default());
        match (set.layout().gauge_names.len(), &applied) {
            (0, _) => assert_says(applied, Some(Missing::Gauges)),
            (3, Ok(analysis)) => look_everywhere(&request, analysis),
            (3, Err(error)) => panic!("{error}"),
            _ => assert!(applied.is_err()),
        }
    });
}

#[test]
fn plots_of_a_fit_need_no_minimum_of_samples() {
    for_all(|set| {
        let request = Request::fit(Arc::clone(set), FitSettings::default());
        if let Ok(analysis) = analyse(&request, &Progress::default()) {
            look_everywhere(&request, &analysis);
            let (calibration, progress) = (&analysis.calibration, Progress::default());
            drop(expected_error(&request, calibration, true, &progress));
            drop(coarse_history(&request, &progress));
        }
    });
}

fn look_everywhere(request: &Request, analysis: &Analysis) {
    let (axis, pixels, frame) = (analysis.calibration.axes[0], [100.0, 100.0], None);
    let span = Span::All;
    let ups = [Up::Load, Up::Error, Up::Gauge(0), Up::Gauge(9)];
    let loops = ups.into_iter().flat_map(|up| {
        [false, true].map(|lag_removed| {
            Question::Loops(LoopQuestion { axis, up, span, lag_removed, frame, pixels })
        })
    });
    let channels = [
        Channel::Time,
        Channel::Gauge(0),
        Channel::Load(Trace::Calculated, axis),
        Channel::Load(Trace::Compensated, axis),
    ];
    let crosses = channels.into_iter().flat_map(|across| {
        channels.map(|up| Question::Cross(CrossQuestion { across, up, span, frame, pixels }))
    });
    let dwells = Question::Dwells(DwellQuestion { axis, rest: None, frame, pixels });
    let tables = [TableOf::All, TableOf::Train, TableOf::Test].map(Question::Table);
    for question in loops.chain(crosses).chain([dwells]).chain(tables) {
        let request = LookRequest {
            loads: OnScreen::of(request, analysis, None),
            measuring: MetrologySettings::default(),
            question,
        };
        // A figure that the samples do not determine is an error, not a panic.
        drop(look(&request, &Progress::default()));
    }
}

#[test]
fn every_channel_is_plotted_over_every_other() {
    for_all(|set| {
        let recording = &set.entries()[0].recording;
        for across in recording::Channel::all(recording) {
            for up in recording::Channel::all(recording) {
                let frame = Some(Frame { loads: (0.5, 7.5), outputs: (-1.0, 1.0) });
                for frame in [None, frame] {
                    let recordings = Arc::clone(set);
                    let pixels = [80.0, 60.0];
                    let asked = ChannelQuestion { recordings, at: 0, across, up, frame, pixels };
                    let found = asked.plot(&Progress::default()).unwrap();
                    assert!(found.figure(&Inks::PRINT, frame).up.range.0.is_finite());
                    assert!(
                        found
                            .spectrum_figure(&Inks::PRINT)
                            .is_none_or(|figure| !figure.lines.is_empty())
                    );
                    drop(found.table().text());
                }
            }
        }
        let gone = ChannelQuestion {
            recordings: Arc::clone(set),
            at: 0,
            across: recording::Channel::Gauge(9),
            up: recording::Channel::Time,
            frame: None,
            pixels: [80.0, 60.0],
        };
        assert!(gone.plot(&Progress::default()).is_err());
        let cancelled = Progress::default();
        cancelled.cancel();
        let asked = ChannelQuestion { across: recording::Channel::Time, ..gone };
        assert!(matches!(asked.plot(&cancelled), Err(Unanswered::Cancelled)));
    });
}

/// Of load cases, the rows are plotted in the order of the file, so that the branches of a table show.
#[test]
fn load_cases_are_plotted_in_the_order_of_the_file() {
    let mut set = RecordingSet::default();
    for (load, rows) in [(0.0, [0, 4]), (5.0, [1, 3]), (9.0, [2, 2])] {
        let rows = &rows[..if rows[0] == rows[1] { 1 } else { 2 }];
        let gauges = rows.iter().map(|row| load + if *row > 2 { 1.0 } else { 0.0 });
        let case = Recording::new(
            format!("case {load}"),
            Source::File("weights.csv".into()),
            rows.iter().map(|row| f64::from(*row)).collect(),
            vec!["S1".into()],
            gauges.collect(),
            vec![Axis::Fz],
            vec![load; rows.len()],
        );
        set.push(Entry::with_default_role(case.unwrap().without_times())).unwrap();
    }
    let asked = ChannelQuestion {
        recordings: Arc::new(set),
        at: 1,
        across: recording::Channel::Load(0),
        up: recording::Channel::Gauge(0),
        frame: None,
        pixels: [400.0, 300.0],
    };
    let found = asked.plot(&Progress::default()).unwrap();
    let width = found.table().rows.into_iter().find(|row| row[0].text == "Loop width").unwrap();
    assert_eq!(width[1].text, "1.000");
}
