//! Loops with known figures, and properties of all questions.

use std::sync::Arc;

use crate::{
    calibration::{Calibration, FitSettings},
    progress::{Cancelled, Progress},
    questions::{
        OnScreen,
        dataset::{Datasets, applied::Source},
        errors::query::{Analysis, analyse},
        loops::*,
        metrology::{MetrologySettings, Reason},
        request::{Request, View},
    },
    recording::{
        Axis, Entry, Recording, RecordingSet, Role, Source as Origin,
        simulated::{self, Late, PLAY_NEWTONS},
    },
    report::{Trace, figure::DOTTED},
    scoring::loops::{Frame, Stroke},
};

/// Half-width of the play in the gauge.
const RADIUS: f64 = 0.5;

/// Returns a recording whose load moves between ±10 at 20 Hz, with one gauge that follows with play and another gauge without play.
fn with_play(name: &str, axes: Vec<Axis>) -> Recording {
    let loads: Vec<f64> =
        (0..2000).map(|k| 10.0 * (f64::from(k) * std::f64::consts::TAU / 400.0).sin()).collect();
    let mut play = 0.0_f64;
    let gauges = loads.iter().flat_map(|load| {
        play = play.clamp(load - RADIUS, load + RADIUS);
        [play, 0.5 * load]
    });
    Recording::new(
        name,
        Origin::File(name.into()),
        (0..2000).map(|k| 0.05 * f64::from(k)).collect(),
        vec!["S1".to_owned(), "S2".to_owned()],
        gauges.collect(),
        axes.clone(),
        if axes.is_empty() { Vec::new() } else { loads },
    )
    .unwrap()
}

fn set(recordings: Vec<Recording>) -> Arc<RecordingSet> {
    let mut set = RecordingSet::default();
    for recording in recordings {
        set.push(Entry::new(recording, Role::Train)).unwrap();
    }
    Arc::new(set)
}

fn analysed(recordings: &Arc<RecordingSet>) -> Analysis {
    let request =
        Request { view: View::All, ..Request::fit(Arc::clone(recordings), FitSettings::default()) };
    analyse(&request, &Progress::default()).unwrap()
}

fn request(recordings: &Arc<RecordingSet>, question: Question) -> LookRequest {
    let Analysis { calibration, traces, .. } = analysed(recordings);
    let recordings = Arc::clone(recordings);
    LookRequest {
        loads: OnScreen {
            calibration,
            recordings,
            decimation: 1,
            traces,
            visible: None,
            datasets: Datasets::default(),
        },
        measuring: MetrologySettings::default(),
        question,
    }
}

fn behind(reversal_threshold: f64, request: LookRequest) -> LookRequest {
    let reversal_thresholds = vec![Some(reversal_threshold)];
    LookRequest {
        measuring: MetrologySettings { reversal_thresholds, ..MetrologySettings::default() },
        ..request
    }
}

fn loops(up: Up, span: Span) -> LoopQuestion {
    LoopQuestion {
        axis: Axis::Fz,
        up,
        span,
        lag_removed: false,
        frame: None,
        pixels: [400.0, 300.0],
    }
}

fn look(request: &LookRequest) -> Result<Look, LookError> {
    super::look(request, &Progress::default())
}

#[track_caller]
fn picture(request: &LookRequest) -> LoopPlot {
    match look(request).unwrap() {
        Look::Loops(picture) => picture,
        other => panic!("not loops: {other:?}"),
    }
}

fn points(strokes: &[Stroke]) -> usize {
    strokes.iter().map(|stroke| stroke.points.len()).sum()
}

fn n_drawn(drawn: &picture::Drawn) -> usize {
    let touched = drawn.clouds.iter().map(|cloud| cloud.density.touched().count());
    points(&drawn.strokes) + touched.sum::<usize>()
}

/// The play gauge reads load + r while the load falls and load − r while the load rises, so the width is 2 r. At each end, the
/// gauge stays while the load changes by 2 r. Five periods from zero have 10 reversals: 4 full cycles, and two half cycles.
#[test]
fn a_play_gauge_has_a_loop_twice_its_radius_wide() {
    let recordings = set(vec![with_play("a", vec![Axis::Fz])]);
    let picture = picture(&request(&recordings, Question::Loops(loops(Up::Gauge(0), Span::All))));
    let [curve] = &picture.curves[..] else { panic!("one gauge is one curve") };
    for figures in [&curve.mean, &curve.largest] {
        let figures = figures.as_ref().unwrap();
        assert!((figures.measures[0] - 2.0 * RADIUS).abs() < 0.01);
        // The area of the parallelogram is 4 r (A − r).
        assert!((figures.measures[2] - 4.0 * RADIUS * (10.0 - RADIUS)).abs() < 0.2);
    }
    assert_eq!((picture.cycles.len(), picture.n_full_cycles), (5, 4));
    assert!(points(&curve.drawn.strokes) <= 2000 + 2 * curve.drawn.strokes.len());
}

/// Noise turns at every sample. A plot of 400 × 300 pixels draws all branches with fewer points than branches, zoomed in or not.
#[test]
fn very_many_branches_are_all_drawn_in_few_points() {
    let n = 60_000;
    let noise = |k: usize| ((k * 7919) % 104_729) as f64 / 104_729.0;
    let recording = Recording::new(
        "noise",
        Origin::Simulated,
        (0..n).map(|k| k as f64 * 0.001).collect(),
        vec!["S1".to_owned()],
        (0..n).map(noise).collect(),
        vec![Axis::Fz],
        (0..n).map(|k| 10.0 * noise(k * k)).collect(),
    );
    let recordings = set(vec![recording.unwrap()]);
    let mut question = loops(Up::Gauge(0), Span::All);
    for zoomed in [false, true] {
        let frame = Frame { loads: (4.0, 4.1), outputs: (0.5, 0.6) };
        question.frame = zoomed.then_some(frame);
        let asked = request(&recordings, Question::Loops(question.clone()));
        let picture = picture(&behind(0.0, asked));
        let [curve] = &picture.curves[..] else { panic!("one gauge is one curve") };
        assert!(picture.cycles.len() > 15_000, "{}", picture.cycles.len());
        if zoomed {
            // A hundredth of the plot has so few branches that lines are drawn.
            assert!((100..20_000).contains(&points(&curve.drawn.strokes)));
            continue;
        }
        assert!(curve.drawn.strokes.is_empty());
        assert_eq!(curve.drawn.clouds.len(), 2);
        for cloud in &curve.drawn.clouds {
            let density = &cloud.density;
            assert_eq!((density.cells, density.frame), ([800, 600], picture.whole));
            let touched = density.touched().count();
            assert!(touched > 200_000, "{touched}");
        }
    }
}

#[test]
fn loads_have_two_curves_and_errors_are_relative_to_the_load() {
    let recordings = set(vec![with_play("a", vec![Axis::Fz])]);
    let mut request = request(&recordings, Question::Loops(loops(Up::Load, Span::All)));
    let load = picture(&request);
    request.question = Question::Loops(loops(Up::Error, Span::All));
    let error = picture(&request);
    for (at, output) in Trace::OUTPUTS.into_iter().enumerate() {
        assert_eq!(load.curves[at].output, Some(output));
        let widths = [&load, &error].map(|one| one.curves[at].mean.as_ref().unwrap().mean_width());
        assert!((widths[0] - widths[1]).abs() < 1e-9, "{widths:?}");
    }
    assert_eq!(load.full_scale, 10.0);
}

#[test]
fn only_visible_samples_are_plotted() {
    let recordings = set(vec![with_play("a", vec![Axis::Fz]), with_play("b", vec![Axis::Fz])]);
    let mut request = request(&recordings, Question::Loops(loops(Up::Error, Span::Visible)));
    assert_eq!(picture(&request).n_samples, 4000);
    request.loads.visible = Some((50.0, 110.0));
    let part = picture(&request);
    assert_eq!((part.parts.len(), part.n_samples), (2, 1201));
    request.loads.visible = Some((1e4, 2e4));
    assert_eq!(look(&request).unwrap_err(), LookError::NoSamples);
    request.question = Question::Loops(loops(Up::Error, Span::One(1)));
    assert_eq!(picture(&request).n_samples, 2000);
    request.question = Question::Loops(loops(Up::Error, Span::One(7)));
    assert_eq!(look(&request).unwrap_err(), LookError::NoSamples);
}

#[test]
fn a_reversal_threshold_above_the_load_leaves_a_sentence_and_a_line_to_see() {
    let recordings = set(vec![with_play("a", vec![Axis::Fz])]);
    let question = Question::Loops(loops(Up::Error, Span::All));
    let picture = picture(&behind(50.0, request(&recordings, question)));
    let reason = picture.curves[0].mean.clone().unwrap_err();
    assert!(matches!(reason, Reason::ConstantLoad { .. }), "{reason}");
    assert!(n_drawn(&picture.curves[0].drawn) > 100);
}

#[test]
fn without_a_reference_there_is_a_sentence_but_gauges_can_be_crossed() {
    let recordings = set(vec![with_play("a", vec![Axis::Fz]), with_play("bare", Vec::new())]);
    let mut request = request(&recordings, Question::Loops(loops(Up::Error, Span::One(1))));
    let axis = Axis::Fz;
    let missing = LookError::Reason(Reason::NoReference { axis });
    assert_eq!(look(&request).unwrap_err(), missing);
    let cross = |up| CrossQuestion {
        across: Channel::Gauge(1),
        up,
        span: Span::One(1),
        frame: None,
        pixels: [400.0, 300.0],
    };
    request.question = Question::Cross(cross(Channel::Load(Trace::Calculated, axis)));
    assert_eq!(look(&request).unwrap_err(), LookError::NoChannel);
    for up in [Channel::Time, Channel::Gauge(0), Channel::Load(Trace::Compensated, axis)] {
        request.question = Question::Cross(cross(up));
        let Ok(Look::Cross(found)) = look(&request) else { panic!("no plot of {up:?}") };
        assert_eq!(found.n_samples, 2000);
        assert!(n_drawn(&found.drawn) > 100);
    }
    request.question = Question::Cross(cross(Channel::Gauge(2)));
    assert_eq!(look(&request).unwrap_err(), LookError::NoChannel);
}

/// The load stays at 4 N for half a minute, while the gauge creeps by 0.5 with τ = 5 s.
#[test]
fn a_dwell_shows_its_drift_and_time_constant() {
    let n = 1200;
    let times: Vec<f64> = (0..n).map(|k| 0.05 * f64::from(k)).collect();
    let loads: Vec<f64> =
        times.iter().map(|t| if *t < 30.0 { (t * 0.7).sin() * 4.0 } else { 4.0 }).collect();
    let gauges = times.iter().zip(&loads).map(|(t, load)| {
        let since = (t - 30.0).max(0.0);
        load + 0.5 * (1.0 - (-since / 5.0).exp())
    });
    let recording = Recording::new(
        "rest",
        Origin::Simulated,
        times.clone(),
        vec!["S1".to_owned()],
        gauges.collect(),
        vec![Axis::Fz],
        loads.clone(),
    );
    let recordings = set(vec![recording.unwrap()]);
    let question = Question::Dwells(DwellQuestion {
        axis: Axis::Fz,
        rest: None,
        frame: None,
        pixels: [400.0, 300.0],
    });
    let mut request = request(&recordings, question);
    let Ok(Look::Dwells(found)) = look(&request) else { panic!("no rest") };
    assert_eq!((found.dwells.len(), found.chosen), (1, 0));
    assert_eq!(found.dwells[0].level, Some(4.0));
    let curve = found.curve.unwrap();
    let tau = curve.outputs[0].drift.as_ref().unwrap().tau_secs().unwrap();
    assert!((tau - 5.0).abs() < 0.3, "{tau}");
    assert_eq!(curve.outputs[0].fit.len(), 200);
    request.measuring.hold_secs = 100.0;
    assert_eq!(look(&request).unwrap_err(), LookError::NoDwell { secs: 100.0 });
}

#[test]
fn the_table_is_of_the_recordings_with_the_chosen_role() {
    let recordings = set(vec![with_play("a", vec![Axis::Fz])]);
    let question = |of| Question::Table(of);
    let mut request = request(&recordings, question(TableOf::Train));
    let Ok(Look::Table(table)) = look(&request) else { panic!("no table") };
    assert_eq!((table.n_recordings, table.n_samples), (1, 2000));
    request.question = question(TableOf::Test);
    assert_eq!(look(&request).unwrap_err(), LookError::NoRecordings);
}

/// Each output has an arrow on its rising and on its falling branch. A figure of loads has the line of equal loads.
#[test]
fn a_figure_of_loops_shows_their_direction() {
    let recordings = set(vec![with_play("a", vec![Axis::Fz])]);
    for (up, n_guides) in [(Up::Error, 0), (Up::Load, 1)] {
        let plot = picture(&request(&recordings, Question::Loops(loops(up, Span::All))));
        let view = LoopView::of_all(&plot, ("", ""));
        let figure = view.figure(&Inks::PRINT, None);
        let arrows = figure.arrows.iter();
        let rise: Vec<bool> = arrows.map(|arrow| arrow.way[1][0] > arrow.way[0][0]).collect();
        assert_eq!(rise, [true, false, true, false]);
        let guides = figure.lines.iter().filter(|line| line.dash == Some(DOTTED));
        assert_eq!(guides.count(), n_guides);
        let svg = figure.svg((620.0, 480.0));
        assert_eq!(svg.matches("class=\"arrow\"").count(), 4);
    }
    let cross = |up| CrossQuestion {
        across: Channel::Load(Trace::Calculated, Axis::Fz),
        up,
        span: Span::All,
        frame: None,
        pixels: [400.0, 300.0],
    };
    let output = Channel::Load(Trace::Conventional, Axis::Fz);
    for (up, n_lines) in [(output, 2), (Channel::Gauge(0), 1)] {
        let Ok(Look::Cross(plot)) = look(&request(&recordings, Question::Cross(cross(up)))) else {
            panic!("no cross-plot of {up:?}")
        };
        let figure = plot.figure(["across", "up"].map(str::to_owned), &Inks::PRINT, None);
        assert_eq!(figure.lines.len(), n_lines, "{up:?}");
    }
}

/// One of two recordings has a tenth of the other recording's load. The threshold is 5 % of the range of all loads.
#[test]
fn the_reversal_threshold_is_the_same_in_every_view() {
    let large = with_play("large", vec![Axis::Fz]);
    let loads = large.loads().iter().map(|load| 0.1 * load);
    let small = Recording::new(
        "small",
        Origin::File("small".into()),
        large.times().to_vec(),
        large.gauge_names().to_vec(),
        large.gauges().to_vec(),
        vec![Axis::Fz],
        loads.collect(),
    );
    let recordings = set(vec![large, small.unwrap()]);
    let expected = 0.05 * 20.0;
    let mut request = request(&recordings, Question::Table(TableOf::All));
    request.loads.decimation = 10;
    let Ok(Look::Table(table)) = look(&request) else { panic!("no table") };
    assert_eq!(table.reversal_thresholds, [expected]);
    for span in [Span::All, Span::One(1), Span::Of(TableOf::Train)] {
        request.question = Question::Loops(loops(Up::Error, span));
        assert_eq!(picture(&request).reversal_threshold, expected);
    }
}

#[test]
fn a_cancelled_question_is_an_error() {
    let recordings = set(vec![with_play("a", vec![Axis::Fz])]);
    let progress = Progress::default();
    progress.cancel();
    let request = request(&recordings, Question::Loops(loops(Up::Load, Span::All)));
    let looked = super::look(&request, &progress);
    assert_eq!(looked.unwrap_err(), LookError::Cancelled(Cancelled));
    // The result is the same if the loads are already computed.
    look(&request).unwrap();
    let looked = super::look(&request, &progress);
    assert_eq!(looked.unwrap_err(), LookError::Cancelled(Cancelled));
}

/// Two panes share the loads: the second request computes none. A later request drops those of another calibration.
#[test]
fn requests_about_one_calibration_share_the_loads() {
    let recordings = set(vec![with_play("a", vec![Axis::Fz]), with_play("b", vec![Axis::Fz])]);
    let first = request(&recordings, Question::Loops(loops(Up::Error, Span::One(0))));
    let OnScreen { calibration, datasets, .. } = &first.loads;
    let applied = datasets.applied(&recordings, 1, calibration);
    let loads = || {
        let mut source = Source::new(Arc::clone(&applied));
        source.apply::<LookError>(0..2, &Progress::default()).unwrap();
        source.used.iter().flatten().cloned().collect::<Vec<_>>()
    };
    let before = loads();
    look(&first).unwrap();
    let question = Question::Table(TableOf::All);
    look(&LookRequest { question, ..first.clone() }).unwrap();
    assert!(Arc::ptr_eq(&applied, &datasets.applied(&recordings, 1, calibration)));
    assert!(before.iter().zip(loads()).all(|(before, after)| Arc::ptr_eq(before, &after)));
    let other = Arc::new(Calibration::clone(calibration));
    let replaced = datasets.applied(&recordings, 1, &other);
    assert!(!Arc::ptr_eq(&applied, &replaced));
    assert_eq!(Arc::strong_count(&applied), 1, "only this test has the loads of before");
}

/// A slow, noisy, drifting triangle of twenty million samples: each measured point is within a pixel of a drawn point, and
/// each drawn point within a pixel of a measured one. A debug build takes half a minute.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation: `cargo test --release` runs it")]
fn twenty_million_samples_are_drawn_to_the_pixel() {
    let n = 20_000_000;
    let noise = |k: usize| ((k.wrapping_mul(2_654_435_761)) % 65_536) as f64 / 65_536.0 - 0.5;
    let load = |k: usize| {
        let phase = (k % 200_000) as f64 / 100_000.0;
        10.0 * (1.0 - 2.0 * (phase - 1.0).abs()) + 0.2 * noise(k)
    };
    let gauge = |k: usize| load(k) + noise(7 * k + 3) + 1e-7 * k as f64;
    let recording = Recording::new(
        "long",
        Origin::Simulated,
        (0..n).map(|k| 1e-3 * k as f64).collect(),
        vec!["S1".to_owned()],
        (0..n).map(gauge).collect(),
        vec![Axis::Fz],
        (0..n).map(load).collect(),
    );
    let recordings = set(vec![recording.unwrap()]);
    let question = Question::Loops(loops(Up::Gauge(0), Span::All));
    let picture = picture(&request(&recordings, question));
    let [curve] = &picture.curves[..] else { panic!("one gauge is one curve") };
    assert_eq!((picture.n_full_cycles, curve.drawn.clouds.len()), (100, 2));
    let Frame { loads, outputs } = picture.whole;
    let [n_across, n_up] = curve.drawn.clouds[0].density.cells;
    let place =
        |value: f64, (low, high): (f64, f64), n: usize| (value - low) / (high - low) * n as f64;
    // Computed independently: points on the steps between samples, a fifth of a pixel apart.
    let mut measured = vec![false; n_across * n_up];
    let mut last = None;
    for k in 0..n {
        let at = [place(load(k), loads, n_across), place(gauge(k), outputs, n_up)];
        let from = last.replace(at).unwrap_or(at);
        let steps = (2.5 * (at[0] - from[0]).hypot(at[1] - from[1])).ceil().max(1.0);
        for step in 0..=steps as usize {
            let share = step as f64 / steps;
            let [column, row] = [0, 1].map(|i| (from[i] + share * (at[i] - from[i])) as usize);
            measured[row.min(n_up - 1) * n_across + column.min(n_across - 1)] = true;
        }
    }
    let densities = || curve.drawn.clouds.iter().map(|cloud| &cloud.density.levels);
    let drawn = |at: usize| densities().any(|levels| levels[at] > 0);
    let sampled = |at: usize| densities().any(|levels| levels[at] > 1);
    let drawn: Vec<bool> = (0..measured.len()).map(drawn).collect();
    // A cell is half a pixel, so neighbouring cells are within a pixel.
    let is_near = |cells: &[bool], at: usize| {
        let (column, row) = (at % n_across, at / n_across);
        let rows = row.saturating_sub(1)..=(row + 1).min(n_up - 1);
        let columns = column.saturating_sub(1)..=(column + 1).min(n_across - 1);
        rows.into_iter().any(|row| columns.clone().any(|column| cells[row * n_across + column]))
    };
    for at in 0..measured.len() {
        assert!(!measured[at] || is_near(&drawn, at), "cell {at} is missing");
        assert!(!drawn[at] || is_near(&measured, at), "no sample is near drawn cell {at}");
    }
    for k in (0..n).step_by(997) {
        let column = place(load(k), loads, n_across) as usize;
        let row = place(gauge(k), outputs, n_up) as usize;
        assert!(sampled(row * n_across + column), "sample {k} is missing");
    }
}

/// With a low-pass and no hysteresis, no loop remains after the lag is removed. With play of radius r, a width of 2 r remains.
#[test]
fn without_its_lag_a_loop_is_as_wide_as_the_hysteresis() {
    for (late, width) in
        [(Late::Lag, 0.0), (Late::Both, 2.0 * PLAY_NEWTONS), (Late::Hysteresis, 2.0 * PLAY_NEWTONS)]
    {
        let recordings = set(simulated::late(7, late));
        let mut request = request(&recordings, Question::Loops(loops(Up::Error, Span::All)));
        let before = picture(&request);
        let lag = before.lag.lag.as_ref().unwrap();
        assert_eq!(before.lag.is_worth_removing(), late != Late::Hysteresis, "{late:?}: {lag:?}");
        for up in [Up::Error, Up::Load] {
            let question = LoopQuestion { lag_removed: true, ..loops(up, Span::All) };
            request.question = Question::Loops(question);
            let after = picture(&request).curves[0].mean.clone().unwrap().mean_width();
            let allowed = (0.1 * width).max(0.03);
            assert!((after - width).abs() < allowed, "{late:?} {up:?}: {after}");
        }
    }
}
