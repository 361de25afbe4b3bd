//! Loops of one axis: its load across, an output of the sensor up, and what they measure.

use rayon::prelude::*;

use super::source::{Part, Source};
use super::{LookError, MAX_POINTS, Output, Span, column_of, frame_around};
use crate::evaluation::loops::{
    Branch, Cycle, Frame, Loop, Loops, Stroke, default_dead_band, outline, range,
};
use crate::evaluation::metrology::{Reason, check_numbers, joined};
use crate::progress::{Cancelled, Progress};
use crate::recording::Axis;

/// What goes up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// The conventional and the compensated load.
    Load,
    /// Their errors.
    #[default]
    Error,
    /// A raw gauge channel.
    Gauge(usize),
}

/// What is asked about loops.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopQuestion {
    /// Whose reference load goes across.
    pub axis: Axis,
    /// What goes up.
    pub up: Up,
    /// Which samples.
    pub span: Span,
    /// From where a reversal counts, in the axis' unit; `None` takes it from the noise.
    pub dead_band: Option<f64>,
    /// What is looked at; `None` shows all.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels: nothing is drawn coarser than these.
    pub pixels: [f64; 2],
}

/// Loops, ready to be drawn.
#[derive(Clone, Debug)]
pub struct LoopPlot {
    /// What was asked.
    pub question: LoopQuestion,
    /// The dead band that was used, in the axis' unit.
    pub dead_band: f64,
    /// The one that the noise asks for.
    pub automatic_dead_band: f64,
    /// Full scale of the axis; 0 where there is none.
    pub full_scale: f64,
    /// What outputs are compared with in percent: full scale, or half of what the gauge spans here; 0 where there is none.
    pub output_scale: f64,
    /// How many samples are drawn.
    pub n_samples: usize,
    /// From how many recordings they are.
    pub n_recordings: usize,
    /// How many cycles there are.
    pub n_cycles: usize,
    /// How many of them are full.
    pub n_full_cycles: usize,
    /// What holds everything.
    pub whole: Frame,
    /// One for a gauge, else conventional and compensated.
    pub curves: Vec<LoopCurve>,
}

/// One output over the load.
#[derive(Clone, Debug)]
pub struct LoopCurve {
    /// Which; `None` for a gauge.
    pub output: Option<Output>,
    /// The branches.
    pub strokes: Vec<Stroke>,
    /// The mean loop of the full cycles, or why there is none.
    pub mean: Result<LoopFigures, Reason>,
    /// The loop of the largest cycle, or why there is none.
    pub largest: Result<LoopFigures, Reason>,
}

/// A loop with what it measures.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopFigures {
    /// The loop.
    pub shape: Loop,
    /// Rising and falling branch as points `[load, output]`.
    pub branches: [Vec<[f64; 2]>; 2],
    /// The width as points `[load, falling − rising]`.
    pub widths: Vec<[f64; 2]>,
    /// Its greatest size, in the output's unit.
    pub largest_width: f64,
    /// Its mean size, in the output's unit.
    pub mean_width: f64,
    /// What the loop encloses, in the output's unit times the axis'.
    pub area: f64,
}

impl LoopFigures {
    /// `None` where a figure is too large for a number.
    fn of(shape: Loop) -> Option<Self> {
        let (largest_width, mean_width, area) =
            (shape.largest_width(), shape.mean_width(), shape.area());
        let figures = [largest_width, mean_width, area];
        if !figures.iter().all(|figure| figure.is_finite()) {
            return None;
        }
        let widths: Vec<f64> = shape.widths().collect();
        Some(Self {
            branches: [&shape.rising, &shape.falling].map(|branch| over_load(&shape, branch)),
            widths: over_load(&shape, &widths),
            largest_width,
            mean_width,
            area,
            shape,
        })
    }
}

fn over_load(shape: &Loop, values: &[f64]) -> Vec<[f64; 2]> {
    let points = shape.loads().zip(values);
    points.map(|(load, value)| [load, *value]).collect()
}

/// The columns of one curve, part by part.
type Columns = Vec<Vec<f64>>;

pub(super) fn picture(
    source: &Source,
    parts: &[Part],
    question: &LoopQuestion,
    progress: &Progress,
) -> Result<LoopPlot, LookError> {
    let axis = question.axis;
    let (_, full_scale) = column_of(&source.calibration, axis)?;
    let (parts, loads): (Vec<&Part>, Columns) = (parts.iter())
        .filter_map(|part| Some((part, source.loads(part, axis)?)))
        .unzip();
    if parts.is_empty() {
        return Err(Reason::NoReference { axis }.into());
    }
    let curves = columns(source, &parts, &loads, question)?;
    for columns in std::iter::once(&loads).chain(curves.iter().map(|(_, columns)| columns)) {
        check(source, &parts, axis, columns)?;
    }
    let automatic_dead_band = default_dead_band(slices(&loads));
    let dead_band = question.dead_band.unwrap_or(automatic_dead_band);
    let loops = Loops::of(slices(&loads), dead_band);
    let load_range = range_of(&loads);
    let output_range = curves.iter().map(|(_, columns)| range_of(columns));
    let output_range = output_range.reduce(joined).unwrap_or((0.0, 0.0));
    let whole = frame_around(load_range, output_range);
    let full = loops.full_cycles();
    let largest = loops
        .largest()
        .ok_or_else(|| Reason::no_cycle(axis, &loops, load_range, dead_band));
    let canvas = (question.frame.unwrap_or(whole), question.pixels);
    let drawn = (curves.par_iter()).map(|(output, outputs)| {
        Ok(LoopCurve {
            output: *output,
            strokes: strokes(&loads, outputs, loops.branches(), canvas, progress)?,
            mean: largest.clone().and_then(|_| {
                let shapes: Vec<Loop> =
                    full.iter().map(|one| shape(one, &loads, outputs)).collect();
                let mean = Loop::mean(&shapes).and_then(LoopFigures::of);
                mean.ok_or(Reason::Overflow { axis })
            }),
            largest: largest.as_ref().map_err(Clone::clone).and_then(|cycle| {
                let figures = LoopFigures::of(shape(cycle, &loads, outputs));
                figures.ok_or(Reason::Overflow { axis })
            }),
        })
    });
    let drawn = drawn.collect::<Result<_, Cancelled>>()?;
    Ok(LoopPlot {
        question: question.clone(),
        dead_band,
        automatic_dead_band,
        full_scale,
        output_scale: match question.up {
            Up::Gauge(_) => 0.5 * (output_range.1 - output_range.0),
            Up::Load | Up::Error => full_scale,
        },
        n_samples: loads.iter().map(Vec::len).sum(),
        n_recordings: parts.len(),
        n_cycles: loops.cycles().count(),
        n_full_cycles: full.len(),
        whole,
        curves: drawn,
    })
}

/// What goes up, part by part.
fn columns(
    source: &Source,
    parts: &[&Part],
    loads: &Columns,
    question: &LoopQuestion,
) -> Result<Vec<(Option<Output>, Columns)>, LookError> {
    let (column, _) = column_of(&source.calibration, question.axis)?;
    let all = |of: &dyn Fn(&Part) -> Option<Vec<f64>>| -> Result<Columns, LookError> {
        let found: Option<Columns> = parts.iter().map(|part| of(part)).collect();
        found.ok_or(LookError::NoChannel)
    };
    if let Up::Gauge(gauge) = question.up {
        return Ok(vec![(None, all(&|part| source.gauge(part, gauge))?)]);
    }
    let outputs = Output::ALL.into_iter().map(|output| {
        let mut columns = all(&|part| source.output(part, column, output))?;
        if question.up == Up::Error {
            for (values, loads) in columns.iter_mut().zip(loads) {
                values
                    .iter_mut()
                    .zip(loads)
                    .for_each(|(value, load)| *value -= load);
            }
        }
        Ok((Some(output), columns))
    });
    outputs.collect()
}

fn check(source: &Source, parts: &[&Part], axis: Axis, columns: &Columns) -> Result<(), Reason> {
    for (part, values) in parts.iter().zip(columns) {
        let name = source
            .recording(part.recording)
            .map_or("", |own| own.name());
        check_numbers(axis, name, values)?;
    }
    Ok(())
}

fn slices(columns: &Columns) -> impl Iterator<Item = &[f64]> {
    columns.iter().map(Vec::as_slice)
}

fn range_of(columns: &Columns) -> (f64, f64) {
    let ranges = slices(columns).map(range);
    ranges.reduce(joined).unwrap_or((0.0, 0.0))
}

fn shape(cycle: &Cycle, loads: &Columns, outputs: &Columns) -> Loop {
    Loop::of(cycle, &loads[cycle.recording], &outputs[cycle.recording])
}

/// What is drawn of all recordings: rising and falling branches each by themselves; what never turns counts as rising.
pub(super) fn strokes(
    loads: &[Vec<f64>],
    outputs: &[Vec<f64>],
    branches: &[Vec<Branch>],
    (frame, pixels): (Frame, [f64; 2]),
    progress: &Progress,
) -> Result<Vec<Stroke>, Cancelled> {
    let ways = [true, false].into_par_iter().map(|rising| {
        let paths =
            (loads.iter().zip(outputs).zip(branches)).flat_map(|((loads, outputs), own)| {
                let all = (own.is_empty() && rising).then_some(0..loads.len());
                let own = own.iter().filter(move |branch| branch.rising == rising);
                let parts = own.map(|branch| branch.samples.clone()).chain(all);
                parts.map(|part| {
                    let points = loads[part.clone()].iter().zip(&outputs[part]);
                    let points = points.map(|(load, output)| [*load, *output]);
                    points.take_while(|_| !progress.is_cancelled())
                })
            });
        let lines = outline(paths, frame, pixels, MAX_POINTS).into_iter();
        lines
            .map(|points| Stroke { rising, points })
            .collect::<Vec<_>>()
    });
    let strokes = ways.collect::<Vec<_>>().concat();
    progress.check().map(|()| strokes)
}
