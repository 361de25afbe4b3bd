//! Computes the contents of a report: fit, errors against the look-back thresholds, loops, metrology figures, and error
//! traces.

use std::sync::Arc;
use std::time::SystemTime;

use super::{
    data::{ReportCurves, ReportData, ReportErrors, ReportRecording},
    tables::pooled,
};
use crate::{
    calibration::{Calibration, ExpectedError},
    export::used_recordings,
    features::Thresholds,
    finding::{Finding, Id, Verdict},
    progress::{Cancelled, Progress},
    questions::{
        check::query::{CheckData, sufficiency},
        error::AnalysisError,
        errors::{
            intervals::OnScreen,
            query::{Analysis, Analyst, RecordingResult},
            traces::{AxisTraces, TraceSet},
        },
        expected_error::{
            limits::{Checked, Limits, Measured},
            query::{expected_error, handed_over_with},
        },
        loops::{
            LookError, LookRequest, LoopPlot, LoopQuestion, Question, Span, TableOf, Up,
            query::{loops_of, table_of},
        },
        metrology::{Metrology, MetrologySettings},
        models::training::train,
        question::Unanswered,
        request::{Request, View},
        thresholds::{
            Along, Measure, ShownFTh, ThresholdGrid, ThresholdMap, study::Study, threshold_curve,
        },
    },
    recording::{Axis, Identity, RecordingSet, Role, ValidRange},
    report::{
        Trace,
        figure::{DASHED, Figure, Line, Scale, color},
    },
    scoring::Series,
};

/// Numbers of values of the force threshold F_th and of the time threshold t_th, for which error curves are computed. The
/// thresholds of the fit are added.
const CURVE_POINTS: (usize, usize) = (29, 9);
/// Number of columns to which the points of an error trace are reduced. This is more than the width of a plot on the page.
const TRACE_COLUMNS: f64 = 1200.0;
/// Resolution in which loops are drawn: width and height in pixels, more than a plot on the page has.
const LOOP_PIXELS: [f64; 2] = [560.0, 400.0];
/// Margin above and below the error traces, as a share of their range.
const MARGIN: f64 = 0.05;

/// Request for a report.
#[derive(Clone, Debug)]
pub struct ReportRequest {
    /// Request to fit a calibration, or to apply one to the recordings; the report describes its result.
    pub request: Request,
    /// Identity of the sensor, which the report shows.
    pub identity: Identity,
    /// Notes of the user, which the report shows.
    pub notes: String,
    /// Limits that the calibration must not exceed.
    pub limits: Limits,
    /// Settings by which loops and metrology figures are measured.
    pub measuring: MetrologySettings,
    /// Valid range of the gauge values, as entered by the user.
    pub range: ValidRange,
}

impl ReportRequest {
    /// Returns a request for a report on this fit, without notes, limits or identity.
    pub fn of(request: Request) -> Self {
        Self {
            request,
            identity: Identity::default(),
            notes: String::new(),
            limits: Limits::default(),
            measuring: MetrologySettings::default(),
            range: ValidRange::default(),
        }
    }
}

/// Returns a report on the calibration that is fitted or applied as requested.
///
/// Loops and metrology figures are measured on the test recordings, or without test recordings, on the training recordings.
/// The choice of recordings on screen does not matter. A result that cannot be computed is replaced by a sentence with the
/// reason.
///
/// # Errors
/// [`AnalysisError`] if the request gives no calibration, or the work was cancelled.
pub fn report(asked: &ReportRequest, progress: &Progress) -> Result<ReportData, AnalysisError> {
    const STAGES: u64 = 6;
    let request = &asked.request;
    progress.add_total(STAGES);
    let calibration = match &request.calibration {
        Some(calibration) => Arc::clone(calibration),
        None => Arc::new(train(request, &progress.part(), &mut |_| {})?),
    };
    progress.check()?;
    progress.advance(1);
    let applied = Request {
        trained: request.calibration.is_none() || request.trained,
        calibration: Some(calibration),
        view: View::One(0),
        ..request.clone()
    };
    let mut analyst = Analyst::default();
    let mut analysis = analyst.analyse(&applied, &progress.part())?;
    let shown = worst(&applied.recordings, &analysis);
    if let Some((at, _)) = shown {
        let view = View::One(at);
        analysis = analyst.analyse(&Request { view, ..applied.clone() }, &progress.part())?;
    }
    drop(analyst);
    progress.advance(1);
    let mut warnings = warnings(&analysis);
    let not_fitted = || "The calibration was not fitted to these recordings.".to_owned();
    let check = if analysis.fitted {
        let data = CheckData::of(request, asked.range.clone());
        or_reason(sufficiency(&data, &progress.part()))?
    } else {
        Err(not_fitted())
    };
    let thresholds = if !analysis.fitted {
        Err(not_fitted())
    } else if request.settings.features.look_backs.is_empty() {
        Err("The calibration has no look-back, so it has no thresholds.".to_owned())
    } else {
        or_reason(thresholds(request, &progress.part(), &mut warnings))?
    };
    progress.advance(1);
    let of = TableOf::usual(&applied.recordings);
    let looked_at = look_request(&analysis, &applied, &asked.measuring, of);
    let loops = (analysis.calibration.axes.iter())
        .map(|axis| or_reason(loops(&looked_at, *axis, of, progress)))
        .collect::<Result<_, _>>()?;
    progress.advance(1);
    let metrology = or_reason(table_of(&looked_at, of, &progress.part()))?;
    progress.advance(1);
    let mut calibration = analysis.calibration.of_sensor(&asked.identity);
    let expected_error = expected_error(request, &calibration, analysis.fitted, progress)?;
    if analysis.fitted {
        calibration =
            handed_over_with(calibration, &expected_error, &request.recordings, progress)?;
    }
    let checked = checked(&asked.limits, &calibration, &expected_error, &metrology);
    progress.advance(1);
    Ok(ReportData {
        made: SystemTime::now(),
        notes: asked.notes.clone(),
        factory: analysis.factory,
        fitted: analysis.fitted,
        recordings: recordings(&applied.recordings, analysis.recordings),
        check,
        thresholds,
        measured: measured_recordings(of),
        loops,
        errors: shown.map(|(at, chosen)| ReportErrors {
            recording: applied.recordings.entries()[at].recording.name().to_owned(),
            chosen,
            figures: error_figures(&analysis.traces),
        }),
        metrology,
        expected_error: expected_error.map_err(|reason| sentence(&reason)),
        limits: checked,
        warnings,
        calibration: Arc::new(calibration),
    })
}

fn checked(
    limits: &Limits,
    calibration: &Calibration,
    expected_error: &Result<ExpectedError, String>,
    metrology: &Result<Arc<Metrology>, String>,
) -> Vec<Checked> {
    let axes = calibration.axes.iter().copied();
    let axes: Vec<(Axis, f64)> = axes.zip(calibration.full_scale.iter().copied()).collect();
    limits.check(&Measured {
        axes: &axes,
        quality: &calibration.quality,
        expected_error,
        metrology: metrology.as_deref().map_err(|reason| &**reason),
    })
}

/// Returns the outcome of each limit for a fitted calibration, as in a [`report`].
///
/// # Errors
/// As [`report`].
pub fn check_limits(
    request: &Request,
    calibration: &Arc<Calibration>,
    limits: &Limits,
    progress: &Progress,
) -> Result<Vec<Checked>, AnalysisError> {
    if limits.is_empty() {
        return Ok(Vec::new());
    }
    let expected_error = expected_error(request, calibration, true, progress)?;
    let metrology = if limits.ask_for_loops() {
        let applied = Request {
            trained: true,
            calibration: Some(Arc::clone(calibration)),
            ..request.clone()
        };
        let analysis = Analyst::default().analyse(&applied, progress)?;
        let of = TableOf::usual(&applied.recordings);
        let looked_at = look_request(&analysis, &applied, &MetrologySettings::default(), of);
        or_reason(table_of(&looked_at, of, &progress.part()))?
    } else {
        Err("not measured".to_owned())
    };
    Ok(checked(limits, calibration, &expected_error, &metrology))
}

fn recordings(set: &RecordingSet, results: Vec<RecordingResult>) -> Vec<ReportRecording> {
    (used_recordings(set).into_iter().zip(set.entries()).zip(results))
        .map(|((used, entry), result)| {
            let recording = Arc::clone(&entry.recording);
            ReportRecording { used, recording, result }
        })
        .collect()
}

/// Returns the recording with the largest compensated error relative to full scale, and a description of the choice.
fn worst(set: &RecordingSet, analysis: &Analysis) -> Option<(usize, &'static str)> {
    let badness = |at: usize| -> Option<f64> {
        let rmse = analysis.recordings[at].compensated_rmse.as_ref()?;
        Some(pooled(rmse, &analysis.calibration.full_scale))
    };
    let in_role = |role: Role| {
        let entries = set.entries().iter().enumerate();
        let rated = entries
            .filter(move |(_, entry)| entry.role == role)
            .filter_map(|(at, _)| Some((at, badness(at)?)));
        rated.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
    };
    let chosen = [
        (Role::Test, "the test recording with the largest errors relative to full scale"),
        (Role::Train, "the training recording with the largest errors relative to full scale"),
        (Role::Off, "the recording with the largest errors relative to full scale"),
    ];
    chosen.into_iter().find_map(|(role, why)| Some((in_role(role)?, why)))
}

fn measured_recordings(of: TableOf) -> &'static str {
    match of {
        TableOf::Test => "the test recordings",
        TableOf::Train => "the training recordings (no recording has the test role)",
        TableOf::NotFitted => "the test recordings and the recordings that are off",
        TableOf::All => "all recordings",
    }
}

fn warnings(analysis: &Analysis) -> Vec<Finding> {
    let seen = "these recordings come from the built-in simulated sensor and are not measured";
    let simulated = Finding::new(Id::Simulated, Verdict::Enough, seen);
    let simulated = analysis.calibration.simulated.then_some(simulated);
    simulated.into_iter().chain(analysis.findings.iter().cloned()).collect()
}

/// Returns curves of the errors against each look-back threshold, at the fit's value of the other threshold.
fn thresholds(
    request: &Request,
    progress: &Progress,
    warnings: &mut Vec<Finding>,
) -> Result<ReportCurves, AnalysisError> {
    let study = Study::prepare(request, progress)?;
    let present = study.present_thresholds();
    let grid = grid_through(present, study.largest_distance())?;
    let map = study.threshold_map(None, &grid, progress, &|_| {})?;
    Ok(curves(request, &map, present, warnings))
}

fn grid_through(present: Thresholds, largest: f64) -> Result<ThresholdGrid, AnalysisError> {
    let (n_f, n_t) = CURVE_POINTS;
    let covering = ThresholdGrid::covering(largest, n_f, n_t)?;
    let with = |values: &[f64], value: f64| {
        let mut values = [values, &[value]].concat();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let f_ths = with(&covering.f_ths, present.f_th);
    let t_ths_secs = with(&covering.t_ths_secs, present.t_th_secs);
    Ok(ThresholdGrid::new(f_ths, t_ths_secs)?)
}

fn curves(
    request: &Request,
    map: &ThresholdMap,
    present: Thresholds,
    warnings: &mut Vec<Finding>,
) -> ReportCurves {
    let at = map.nearest(present);
    let shown = ShownFTh::of(map.distance);
    let groups = [Measure::Forces, Measure::Moments].into_iter();
    let groups = groups.filter(|group| group.weights(&map.scale).is_some());
    let marked = |group: Measure, along: Along, value: f64| Figure {
        marked: Some(value),
        ..threshold_curve(map, group, along, at, None, &|_| color::SCORE)
    };
    let plots = groups.flat_map(|group| {
        [
            marked(group, Along::F, present.f_th * shown.factor),
            marked(group, Along::T, present.t_th_secs),
        ]
    });
    let plots = plots.collect();
    let mut about =
        "Root mean squared error against each threshold of the look-back. Vertical lines mark the thresholds of the fit.".to_owned();
    if request.settings.regressor.learner().is_some() {
        about.push_str(
            " The curves show the errors of the linear regressor, because only this regressor is fitted at every threshold.",
        );
    }
    let measure = map.scale.default_measure();
    if let Ok(found) = map.suggestion(measure) {
        about.push_str(&format!(" {}", sentence(&found.in_words(map, measure))));
        if !found.beats_conventional {
            let seen = "none of the tried look-backs is better than the conventional calibration with 90 % confidence";
            warnings.push(Finding::new(Id::NoLookBack, Verdict::Enough, seen));
        }
    }
    ReportCurves { plots, about }
}

/// Returns the request for the metrology table of the report. Its loops use the same loads.
fn look_request(
    analysis: &Analysis,
    request: &Request,
    measuring: &MetrologySettings,
    of: TableOf,
) -> LookRequest {
    LookRequest {
        loads: OnScreen::of(request, analysis, None),
        measuring: measuring.clone(),
        question: Question::Table(of),
    }
}

/// Returns the loops of an axis as measured. If a time lag explains much of their width, adds the loops without the lag.
fn loops(
    request: &LookRequest,
    axis: Axis,
    of: TableOf,
    progress: &Progress,
) -> Result<Vec<LoopPlot>, LookError> {
    let question = LoopQuestion {
        axis,
        up: Up::Error,
        span: Span::Of(of),
        lag_removed: false,
        frame: None,
        pixels: LOOP_PIXELS,
    };
    let mut plots = vec![loops_of(request, &question, &progress.part())?];
    if plots[0].lag.is_worth_removing() {
        let without_lag = LoopQuestion { lag_removed: true, ..question };
        plots.push(loops_of(request, &without_lag, &progress.part())?);
    }
    Ok(plots)
}

/// Returns a part of the report, or the reason why it is missing as a sentence. Only a cancellation ends the report.
fn or_reason<T>(found: Result<T, impl Into<Unanswered>>) -> Result<Result<T, String>, Cancelled> {
    match found.map_err(Into::into) {
        Ok(part) => Ok(Ok(part)),
        Err(Unanswered::Cancelled) => Err(Cancelled),
        Err(Unanswered::Because(reason)) => Ok(Err(sentence(&reason))),
    }
}

/// Returns the text as a sentence: with a capital letter and a full stop.
pub fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(char::to_uppercase);
    let capital: String = first.into_iter().flatten().collect();
    format!("{capital}{}.", letters.as_str().trim_end_matches('.'))
}

fn error_figures(traces: &TraceSet) -> Vec<Figure<'static>> {
    let axes = traces.axes.iter();
    axes.filter_map(|axis| error_figure(traces, axis)).collect()
}

/// Returns a plot of the errors of an axis over time; `None` without a reference.
fn error_figure(traces: &TraceSet, axis: &AxisTraces) -> Option<Figure<'static>> {
    let (symbol, unit) = (axis.axis.symbol(), axis.axis.unit());
    // Only the compensated load has a solid line, so that the lines differ even without colour.
    let lines = [
        (Trace::Factory, color::FACTORY, Some(DASHED), 1.0),
        (Trace::Conventional, color::CONVENTIONAL, Some(DASHED), 1.0),
        (Trace::Compensated, color::COMPENSATED, None, 1.6),
    ];
    let lines = lines.into_iter().filter_map(|(trace, color, dash, width)| {
        let points = points(traces, axis.error(trace)?);
        Some(Line { width, dash, ..Line::new(trace.label(), color, [points]) })
    });
    let lines: Vec<Line<'_>> = lines.collect();
    let errors = lines.iter().flat_map(|line| line.pieces[0].iter());
    let heights = errors.map(|[_, up]| *up).chain([0.0]);
    let end = traces.times.last().copied().unwrap_or(0.0);
    let up = Scale::spanning(format!("{symbol} error [{unit}]"), heights, MARGIN);
    (!lines.is_empty()).then(|| Figure {
        title: symbol.to_owned(),
        across: Scale::new(traces.across(), (0.0, end)),
        up,
        lines,
        ..Figure::default()
    })
}

/// Returns the points of a trace, reduced to [`TRACE_COLUMNS`] columns.
fn points(traces: &TraceSet, series: &Series) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    let (first, last) = (traces.times.first(), traces.times.last());
    let secs = first.zip(last).map_or(0.0, |(first, last)| last - first);
    let column_secs = secs / TRACE_COLUMNS;
    series.draw(&traces.times, 0..series.len(), column_secs, |time, value| {
        points.push([time, value]);
    });
    points
}
