//! Loops of one axis: a gauge or the loads plotted against the reference load, with the widths and areas of the loops.

use std::sync::Arc;

use rayon::prelude::*;

use crate::{
    min_max::MinMax,
    progress::{Cancelled, Progress},
    questions::{
        dataset::applied::{OutputLag, Part, Source},
        loops::request::{LookError, LoopQuestion, Up, column_of, rules},
        metrology::{Basis, Cycles, MetrologySettings, Reason, check_numbers},
    },
    recording::Axis,
    report::Trace,
    scoring::loops::{Branch, Cycle, Density, Frame, Loop, Outline, Stroke, common_loads, outline},
};

/// Loops of one axis, ready to be drawn.
#[derive(Debug)]
pub struct LoopPlot {
    pub question: LoopQuestion,
    /// Reversal threshold: the smallest change of load that counts as a reversal, in the unit of the axis.
    pub reversal_threshold: f64,
    /// Full scale of the axis (N or N·m); 0 if there is none.
    pub full_scale: f64,
    pub n_samples: usize,
    /// Plotted samples of each recording, counted after decimation.
    pub parts: Vec<Part>,
    /// Samples of each cycle, counted after decimation. The cycles are in the order of recordings and time.
    pub cycles: Vec<Part>,
    pub n_full_cycles: usize,
    /// Visible range that shows all points.
    pub whole: Frame,
    /// One curve for a gauge, else a curve of the uncompensated load and a curve of the compensated load.
    pub curves: Vec<LoopCurve>,
    /// Time lag of the uncompensated load behind the reference load.
    pub lag: OutputLag,
}

#[derive(Debug)]
pub struct LoopCurve {
    /// Load that the curve shows: uncompensated or compensated; `None` for a gauge.
    pub output: Option<Trace>,
    pub drawn: Drawn,
    pub mean: Result<LoopFigures, Reason>,
    pub largest: Result<LoopFigures, Reason>,
}

#[derive(Clone, Debug)]
pub struct LoopFigures {
    /// Rising and falling branch as points `[load, output]`.
    pub branches: [Vec<[f64; 2]>; 2],
    /// Largest width and mean width (unit of the output), area and dissipated work (unit of the output times unit of the
    /// load).
    pub measures: [f64; 4],
    /// Cycles from which the figures are computed.
    pub basis: Basis,
}

impl LoopFigures {
    /// Computes the width, area and work of a loop. Returns `None` if one of them overflows to infinity.
    fn of(shape: &Loop, basis: Basis) -> Option<Self> {
        let measures = [Loop::largest_width, Loop::mean_width, Loop::area, Loop::work];
        let measures = measures.map(|measure| measure(shape));
        let is_finite = measures.iter().all(|figure| figure.is_finite());
        is_finite.then(|| Self {
            branches: [&shape.rising, &shape.falling].map(|branch| over_load(shape, branch)),
            measures,
            basis,
        })
    }

    pub fn mean_width(&self) -> f64 {
        self.measures[1]
    }
}

fn over_load(shape: &Loop, values: &[f64]) -> Vec<[f64; 2]> {
    let points = shape.loads().zip(values);
    points.map(|(load, value)| [load, *value]).collect()
}

type Columns = Vec<Vec<f64>>;

/// One output (a gauge or a load) and its reference load, each with one column for each plotted part of a recording.
struct Curve {
    output: Option<Trace>,
    loads: Arc<Columns>,
    values: Columns,
}

pub fn picture(
    source: &mut Source,
    mut parts: Vec<Part>,
    question: &LoopQuestion,
    measuring: &MetrologySettings,
    progress: &Progress,
) -> Result<LoopPlot, LookError> {
    let axis = question.axis;
    let (column, full_scale) = column_of(&source.calibration, axis)?;
    parts.retain(|part| source.recordings[part.recording].axes().contains(&axis));
    if parts.is_empty() {
        return Err(Reason::NoReference { axis }.into());
    }
    if parts.iter().any(|part| source.recordings[part.recording].is_static()) {
        return Err(Reason::NoTimes { axis }.into());
    }
    measuring.validate(source.calibration.axes.len())?;
    let reversal_threshold = rules(source, measuring).reversal_threshold(column);
    let mut curves = curves(source, &parts, question, None)?;
    for columns in curves.iter().flat_map(|curve| [&*curve.loads, &curve.values]) {
        for (part, values) in parts.iter().zip(columns) {
            check_numbers(axis, source.recordings[part.recording].name(), values)?;
        }
    }
    let lag = source.output_lag::<LookError>(
        (column, Trace::Conventional),
        reversal_threshold,
        progress,
    )?;
    if question.lag_removed {
        let compensated = source.output_lag::<LookError>(
            (column, Trace::Compensated),
            reversal_threshold,
            progress,
        )?;
        curves = self::curves(source, &parts, question, Some([&lag, &compensated]))?;
    }
    let cycles = |loads: &Arc<Columns>| {
        Arc::new(Cycles::of(axis, loads.iter().map(Vec::as_slice), reversal_threshold))
    };
    let first = cycles(&curves[0].loads);
    let cycles: Vec<_> = (curves.iter())
        .map(|curve| {
            if Arc::ptr_eq(&curve.loads, &curves[0].loads) {
                Arc::clone(&first)
            } else {
                cycles(&curve.loads)
            }
        })
        .collect();
    let load_range = cycles.iter().map(|cycles| cycles.range).collect();
    let output_range: MinMax =
        curves.iter().flat_map(|curve| curve.values.iter().flatten()).collect();
    let whole = frame_around(load_range, output_range);
    let canvas = (question.frame.unwrap_or(whole), question.pixels);
    let drawn = (curves.par_iter().zip(&cycles))
        .map(|(curve, cycles)| curve.drawn(axis, cycles, canvas, progress))
        .collect::<Result<_, Cancelled>>()?;
    let Cycles { loops, .. } = &*first;
    Ok(LoopPlot {
        question: question.clone(),
        reversal_threshold,
        full_scale,
        n_samples: curves[0].loads.iter().map(Vec::len).sum(),
        cycles: (loops.cycles().iter())
            .map(|cycle| {
                let Part { recording, samples } = &parts[cycle.recording];
                let (from, to) = (cycle.first.samples.start, cycle.second.samples.end);
                Part { recording: *recording, samples: samples.start + from..samples.start + to }
            })
            .collect(),
        parts,
        n_full_cycles: loops.full_cycles().len(),
        whole,
        curves: drawn,
        lag,
    })
}

impl Curve {
    fn drawn(
        &self,
        axis: Axis,
        cycles: &Cycles,
        canvas: (Frame, [f64; 2]),
        progress: &Progress,
    ) -> Result<LoopCurve, Cancelled> {
        let (loads, values) = (&*self.loads, &self.values);
        let figures = |of: fn(&Cycles) -> Result<&[Cycle], &Reason>| {
            let counted = of(cycles).map_err(Clone::clone)?;
            let range_share = common_loads(counted).share_of(cycles.range);
            let basis = Basis { n_cycles: counted.len(), range_share };
            let shapes = counted.iter().map(|one| shape(one, loads, values));
            Loop::mean(&shapes.collect::<Vec<_>>())
                .and_then(|mean| LoopFigures::of(&mean, basis))
                .ok_or(Reason::Overflow { axis })
        };
        Ok(LoopCurve {
            output: self.output,
            drawn: drawn(loads, values, cycles.loops.branches(), canvas, progress)?,
            mean: figures(|cycles| cycles.mean.as_deref()),
            largest: figures(|cycles| cycles.largest.as_ref().map(std::slice::from_ref)),
        })
    }
}

/// Returns each output with its reference load. `lags` are the time lags to remove from the outputs.
fn curves(
    source: &Source,
    parts: &[Part],
    question: &LoopQuestion,
    lags: Option<[&OutputLag; 2]>,
) -> Result<Vec<Curve>, LookError> {
    let axis = question.axis;
    let (column, _) = column_of(&source.calibration, axis)?;
    let all = |of: &dyn Fn(&Part) -> Option<Vec<f64>>| -> Result<Columns, LookError> {
        parts.iter().map(of).collect::<Option<_>>().ok_or(LookError::NoChannel)
    };
    let in_time = |at: usize| lags.and_then(|lags| lags[at].in_time.as_ref());
    let as_measured = Arc::new(all(&|part| source.loads(part, axis))?);
    let loads = |at: usize| match in_time(at) {
        Some(lag) => all(&|part| source.late_loads(part, axis, lag)).map(Arc::new),
        None => Ok(Arc::clone(&as_measured)),
    };
    if let Up::Gauge(gauge) = question.up {
        let values = all(&|part| source.gauge(part, gauge))?;
        return Ok(vec![Curve { output: None, loads: loads(0)?, values }]);
    }
    let outputs = Trace::OUTPUTS.into_iter().enumerate().map(|(at, output)| {
        let loads = loads(at)?;
        let values = |part: &Part| match in_time(at) {
            Some(lag) => source.refitted(part, output, lag),
            None => source.output(part, column, output),
        };
        let mut values: Columns = parts.iter().map(values).collect();
        if question.up == Up::Error {
            for (value, load) in values.iter_mut().flatten().zip(loads.iter().flatten()) {
                *value -= load;
            }
        }
        Ok(Curve { output: Some(output), loads, values })
    });
    outputs.collect()
}

fn shape(cycle: &Cycle, loads: &Columns, outputs: &Columns) -> Loop {
    Loop::of(cycle, &loads[cycle.recording], |k| outputs[cycle.recording][k])
}

#[derive(Debug, Default)]
pub struct Drawn {
    pub strokes: Vec<Stroke>,
    /// Density maps of the branches that have too many points for lines.
    pub clouds: Vec<Cloud>,
}

#[derive(Debug)]
pub struct Cloud {
    pub rising: bool,
    pub density: Arc<Density>,
}

/// Draws the rising and the falling branches of all recordings separately. A load without reversal counts as rising.
pub fn drawn(
    loads: &[Vec<f64>],
    outputs: &[Vec<f64>],
    branches: &[Vec<Branch>],
    (frame, pixels): (Frame, [f64; 2]),
    progress: &Progress,
) -> Result<Drawn, Cancelled> {
    let ways = [true, false].into_par_iter().map(|rising| {
        let paths =
            (loads.iter().zip(outputs).zip(branches)).flat_map(|((loads, outputs), branches)| {
                let all = (branches.is_empty() && rising).then_some(0..loads.len());
                let branches = branches.iter().filter(move |branch| branch.rising == rising);
                let parts = branches.map(|branch| branch.samples.clone()).chain(all);
                parts.map(|part| {
                    let points = loads[part.clone()].iter().zip(&outputs[part]);
                    let points = points.map(|(load, output)| [*load, *output]);
                    points.take_while(|_| !progress.is_cancelled())
                })
            });
        (rising, outline(paths, frame, pixels, MAX_POINTS))
    });
    let mut drawn = Drawn::default();
    for (rising, outline) in ways.collect::<Vec<_>>() {
        match outline {
            Outline::Lines(lines) => {
                let strokes = lines.into_iter().map(|points| Stroke { rising, points });
                drawn.strokes.extend(strokes);
            }
            Outline::Density(density) => {
                drawn.clouds.push(Cloud { rising, density: Arc::new(density) })
            }
        }
    }
    progress.check().map(|()| drawn)
}

/// Maximum number of points of all rising branches, and of all falling branches, that are drawn as lines. If a plot has more
/// points, the density of the branches is drawn. Two outputs then take no longer to draw than the traces of six axes.
pub const MAX_POINTS: usize = 8000;

/// Margin around the points of a plot, as a share of its width and height.
pub const MARGIN: f64 = 0.04;

/// Returns a visible range with a margin around these loads and outputs. Even a single point gets a margin.
pub fn frame_around(loads: MinMax, outputs: MinMax) -> Frame {
    let wider = |range: MinMax| {
        let (low, high) = range.ends().unwrap_or_default();
        let margin =
            if high > low { MARGIN * (high - low) } else { 0.1 * f64::max(high.abs(), 1e-3) };
        (low - margin, high + margin)
    };
    Frame { loads: wider(loads), outputs: wider(outputs) }
}
