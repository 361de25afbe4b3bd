//! Cross-plots of one channel (time, gauge or load) against another, and dwells (intervals of constant load) with the drift
//! of the uncompensated and the compensated load.

use crate::{
    progress::Progress,
    questions::{
        dataset::applied::{Part, Source},
        loops::{
            picture::{Drawn, drawn, frame_around},
            request::{Channel, CrossQuestion, DwellQuestion, LookError, column_of, rules, run},
        },
        metrology::{Dwell, MetrologySettings, Reason, check_numbers, dwells},
    },
    report::Trace,
    scoring::{Series, holds::Drift, loops::Frame, straight_lines::Line},
};

/// A cross-plot, ready to be drawn.
#[derive(Debug)]
pub struct CrossPlot {
    /// Request that the plot answers.
    pub question: CrossQuestion,
    /// Number of plotted samples.
    pub n_samples: usize,
    /// Slope of the least-squares line through all points, and their correlation; `None` if all points lie above each other.
    pub trend: Option<[f64; 2]>,
    /// Visible range that shows all points.
    pub whole: Frame,
    /// Curves, one or more for each recording.
    pub drawn: Drawn,
}

pub fn cross_plot(
    source: &Source,
    parts: &[Part],
    question: &CrossQuestion,
    progress: &Progress,
) -> Result<CrossPlot, LookError> {
    let across = columns(source, parts, question.across)?;
    let up = columns(source, parts, question.up)?;
    let whole = frame_around(across.iter().flatten().collect(), up.iter().flatten().collect());
    let none = vec![Vec::new(); parts.len()];
    let canvas = (question.frame.unwrap_or(whole), question.pixels);
    let points = across.iter().flatten().copied().zip(up.iter().flatten().copied());
    let points: Vec<(f64, f64)> = points.collect();
    let line = Line::best_fit(&points);
    Ok(CrossPlot {
        trend: line.map(|line| [line.slope, line.correlation(&points)]),
        question: question.clone(),
        n_samples: across.iter().map(Vec::len).sum(),
        drawn: drawn(&across, &up, &none, canvas, progress)?,
        whole,
    })
}

fn columns(source: &Source, parts: &[Part], channel: Channel) -> Result<Vec<Vec<f64>>, LookError> {
    let column = |part: &Part| -> Result<Vec<f64>, LookError> {
        let recording = &source.recordings[part.recording];
        let found = match channel {
            Channel::Time => Some(recording.times()[part.samples.clone()].to_vec()),
            Channel::Gauge(gauge) => source.gauge(part, gauge),
            Channel::Load(Trace::Calculated, axis) => source.loads(part, axis),
            Channel::Load(Trace::Factory, _) => None,
            Channel::Load(output, axis) => {
                let (at, _) = column_of(&source.calibration, axis)?;
                Some(source.output(part, at, output))
            }
        };
        let values = found.ok_or(LookError::NoChannel)?;
        if let Channel::Load(_, axis) = channel {
            check_numbers(axis, recording.name(), &values)?;
        }
        Ok(values)
    };
    parts.iter().map(column).collect()
}

const FIT_POINTS: usize = 200;

/// List of all dwells, and the drift in one dwell, ready to be drawn.
#[derive(Debug)]
pub struct DwellPlot {
    pub question: DwellQuestion,
    pub hold_secs: f64,
    pub dwells: Vec<Dwell>,
    /// Index in the list of the dwell whose drift is drawn.
    pub chosen: usize,
    pub curve: Result<DwellCurve, Reason>,
}

#[derive(Debug)]
pub struct DwellCurve {
    /// Visible range that shows all points: time since the start of the dwell (s), and error.
    pub whole: Frame,
    pub outputs: [DwellOutput; 2],
}

#[derive(Debug)]
pub struct DwellOutput {
    /// Measured points `[seconds, error]`.
    pub points: Vec<[f64; 2]>,
    /// Exponential that is fitted to the errors; `None` if all times are equal.
    pub drift: Option<Drift>,
    /// Points `[seconds, error]` of the fitted exponential.
    pub fit: Vec<[f64; 2]>,
}

pub fn dwell_plot(
    source: &Source,
    question: &DwellQuestion,
    measuring: &MetrologySettings,
) -> Result<DwellPlot, LookError> {
    let calibration = &source.calibration;
    let (column, _) = column_of(calibration, question.axis)?;
    let runs: Vec<_> = (0..source.recordings.len()).map(|at| run(source, at)).collect();
    if runs.iter().any(|run| run.is_static) {
        return Err(Reason::NoTimes { axis: question.axis }.into());
    }
    let found = dwells(&runs, &rules(source, measuring), column)?;
    let longest = longest(&found).ok_or(LookError::NoDwell { secs: measuring.hold_secs })?;
    let chosen = question.rest.map_or(longest, |rest| rest.min(found.len() - 1));
    let curve = curve(source, &found[chosen], question, column);
    Ok(DwellPlot {
        question: question.clone(),
        hold_secs: measuring.hold_secs,
        dwells: found,
        chosen,
        curve,
    })
}

/// Returns the index of the longest dwell under load. Without a dwell under load, the longest dwell at zero is returned.
fn longest(dwells: &[Dwell]) -> Option<usize> {
    let secs = |rest: &Dwell| rest.place.to_secs - rest.place.from_secs;
    let by_length = |a: &(usize, &Dwell), b: &(usize, &Dwell)| {
        let loaded = b.1.at_zero.cmp(&a.1.at_zero);
        loaded.then(secs(a.1).total_cmp(&secs(b.1)))
    };
    dwells.iter().enumerate().max_by(by_length).map(|(at, _)| at)
}

fn curve(
    source: &Source,
    rest: &Dwell,
    question: &DwellQuestion,
    column: usize,
) -> Result<DwellCurve, Reason> {
    let axis = question.axis;
    let part = Part { recording: rest.place.recording, samples: rest.place.samples.clone() };
    let loads = source.loads(&part, axis).ok_or(Reason::NoReference { axis })?;
    let recording = &source.recordings[part.recording];
    let times = &recording.times()[part.samples.clone()];
    let mut errors = Trace::OUTPUTS.map(|output| source.output(&part, column, output));
    for values in &mut errors {
        values.iter_mut().zip(&loads).for_each(|(value, load)| *value -= load);
        check_numbers(axis, recording.name(), values)?;
    }
    let (first, last) = (rest.place.from_secs, rest.place.to_secs);
    Ok(DwellCurve {
        whole: frame_around(
            [0.0, last - first].iter().collect(),
            errors.iter().flatten().collect(),
        ),
        outputs: errors.each_ref().map(|values| output_of(times, values, question)),
    })
}

fn output_of(times: &[f64], errors: &[f64], question: &DwellQuestion) -> DwellOutput {
    let since: Vec<f64> = times.iter().map(|time| time - times[0]).collect();
    let all = (0.0, since[since.len() - 1]);
    let (from, to) = question.frame.map_or(all, |frame| frame.loads);
    // The curve has one sample beyond each visible end, so that its line reaches the edge of the plot.
    let start = since.partition_point(|time| *time < from).saturating_sub(1);
    let end = (since.partition_point(|time| *time <= to) + 1).min(since.len());
    let column_secs = (to - from) / question.pixels[0].max(1.0);
    let mut points = Vec::new();
    let series = Series::new(errors.into());
    series
        .draw(&since, start..end.max(start), column_secs, |time, value| points.push([time, value]));
    let drift = Drift::of(times, errors);
    let fit = drift.iter().flat_map(|drift| {
        let step = drift.duration_secs / (FIT_POINTS - 1) as f64;
        (0..FIT_POINTS).map(move |at| [step * at as f64, drift.at(step * at as f64)])
    });
    DwellOutput { points, fit: fit.collect(), drift }
}
