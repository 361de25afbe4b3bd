//! Loops of one axis: its load across, an output of the sensor up, and what they measure.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::progress::{Cancelled, Progress};
use crate::questions::loops::error::LookError;
use crate::questions::loops::frame::{MAX_POINTS, frame_around};
use crate::questions::loops::output::column_of;
use crate::questions::loops::output::{Output, Span};
use crate::questions::loops::source::{Part, Source};
use crate::questions::metrology::{Basis, MetrologySettings, Reason, check_numbers, joined};
use crate::recording::Axis;
use crate::scoring::loops::{
    Branch, Cycle, Density, Frame, Loop, Loops, Outline, Stroke, common_loads, outline, range,
};

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
    /// Full scale of the axis; 0 where there is none.
    pub full_scale: f64,
    /// What outputs are compared with in percent: full scale, or half of what the gauge spans here; 0 where there is none.
    pub output_scale: f64,
    /// How many samples are drawn.
    pub n_samples: usize,
    /// Whose they are: recordings with their samples after decimation.
    pub parts: Vec<(usize, Range<usize>)>,
    /// How many cycles there are.
    pub n_cycles: usize,
    /// Where they are: the recording, and its samples after decimation, in the order of their beginnings.
    pub cycles: Vec<(usize, Range<usize>)>,
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
    pub drawn: Drawn,
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
    /// The area between its branches, in the output's unit times the axis'.
    pub area: f64,
    /// That area with the sign of the width, in the same unit.
    pub work: f64,
    /// What each of the four rests on, in this order.
    pub basis: [Basis; 4],
}

impl LoopFigures {
    /// What the loop measures, and what the loops of half and of twice the dead band would; `None` where a figure is too
    /// large for a number.
    fn of(
        shape: Loop,
        n_cycles: usize,
        range_share: f64,
        others: [Option<Loop>; 2],
    ) -> Option<Self> {
        let measures = [Loop::largest_width, Loop::mean_width, Loop::area, Loop::work];
        let figures = measures.map(|measure| measure(&shape));
        if !figures.iter().all(|figure| figure.is_finite()) {
            return None;
        }
        let [largest_width, mean_width, area, work] = figures;
        let basis = measures.map(|measure| {
            let of =
                |other: &Option<Loop>| other.as_ref().map(measure).filter(|own| own.is_finite());
            Basis {
                dead_band_halved: of(&others[0]),
                dead_band_doubled: of(&others[1]),
                ..Basis::new(n_cycles, range_share)
            }
        });
        let widths: Vec<f64> = shape.widths().collect();
        Some(Self {
            branches: [&shape.rising, &shape.falling].map(|branch| over_load(&shape, branch)),
            widths: over_load(&shape, &widths),
            largest_width,
            mean_width,
            area,
            work,
            basis,
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

pub(crate) fn picture(
    source: &Source,
    parts: &[Part],
    question: &LoopQuestion,
    measuring: &MetrologySettings,
    progress: &Progress,
) -> Result<LoopPlot, LookError> {
    let axis = question.axis;
    let (column, full_scale) = column_of(&source.calibration, axis)?;
    let (parts, loads): (Vec<&Part>, Columns) =
        (parts.iter()).filter_map(|part| Some((part, source.loads(part, axis)?))).unzip();
    if parts.is_empty() {
        return Err(Reason::NoReference { axis }.into());
    }
    let is_static = |part: &&Part| {
        source.recording(part.recording).is_some_and(|recording| recording.is_static())
    };
    if parts.iter().any(is_static) {
        return Err(Reason::NoTimes { axis }.into());
    }
    let curves = columns(source, &parts, &loads, question)?;
    for columns in std::iter::once(&loads).chain(curves.iter().map(|(_, columns)| columns)) {
        check(source, &parts, axis, columns)?;
    }
    measuring.validate(source.calibration.axes.len())?;
    let dead_band = source.rules(measuring).dead_band(column);
    let load_range = range_of(&loads);
    let output_range = curves.iter().map(|(_, columns)| range_of(columns));
    let output_range = output_range.reduce(joined).unwrap_or((0.0, 0.0));
    let whole = frame_around(load_range, output_range);
    let behind = |factor: f64| Cycles::of(axis, &loads, factor * dead_band, load_range);
    let [cycles, halved, doubled] = [1.0, 0.5, 2.0].map(behind);
    let share = |own: &[Cycle]| {
        let (low, high) = common_loads(own);
        ((high - low) / (load_range.1 - load_range.0)).clamp(0.0, 1.0)
    };
    let canvas = (question.frame.unwrap_or(whole), question.pixels);
    let curves = (curves.par_iter()).map(|(output, outputs)| {
        let figures = |of: fn(&Cycles) -> &Result<Vec<Cycle>, Reason>| {
            let own = of(&cycles).as_ref().map_err(Clone::clone)?;
            let mean = |cycles: &Vec<Cycle>| {
                let shapes = cycles.iter().map(|one| shape(one, &loads, outputs));
                Loop::mean(&shapes.collect::<Vec<_>>())
            };
            let others = [&halved, &doubled].map(|other| of(other).as_ref().ok().and_then(mean));
            mean(own)
                .and_then(|found| LoopFigures::of(found, own.len(), share(own), others))
                .ok_or(Reason::Overflow { axis })
        };
        Ok(LoopCurve {
            output: *output,
            drawn: drawn(&loads, outputs, cycles.loops.branches(), canvas, progress)?,
            mean: figures(|own| &own.mean),
            largest: figures(|own| &own.largest),
        })
    });
    let curves = curves.collect::<Result<_, Cancelled>>()?;
    Ok(LoopPlot {
        question: question.clone(),
        dead_band,
        full_scale,
        output_scale: match question.up {
            Up::Gauge(_) => 0.5 * (output_range.1 - output_range.0),
            Up::Load | Up::Error => full_scale,
        },
        n_samples: loads.iter().map(Vec::len).sum(),
        parts: (parts.iter()).map(|part| (part.recording, part.samples.clone())).collect(),
        n_cycles: cycles.loops.cycles().len(),
        cycles: (cycles.loops.cycles().iter())
            .map(|cycle| {
                let part = parts[cycle.recording];
                let at = |sample: usize| part.samples.start + sample;
                let (from, to) = (cycle.first.samples.start, cycle.second.samples.end);
                (part.recording, at(from)..at(to))
            })
            .collect(),
        n_full_cycles: cycles.loops.full_cycles().len(),
        whole,
        curves,
    })
}

/// The cycles behind a dead band.
struct Cycles {
    loops: Loops,
    /// Those of the mean loop, or why there is none.
    mean: Result<Vec<Cycle>, Reason>,
    /// The largest, or why there is none.
    largest: Result<Vec<Cycle>, Reason>,
}

impl Cycles {
    fn of(axis: Axis, loads: &Columns, dead_band: f64, range: (f64, f64)) -> Self {
        let loops = Loops::of(slices(loads), dead_band);
        let largest = loops.largest().map(|cycle| vec![cycle]);
        let largest = largest.ok_or_else(|| Reason::no_cycle(axis, &loops, range, dead_band));
        let enough = loops.mean_cycles(range);
        let mean = enough.map_err(|few| Reason::few_cycles(axis, few));
        Self { mean: largest.clone().and(mean), largest, loops }
    }
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
                values.iter_mut().zip(loads).for_each(|(value, load)| *value -= load);
            }
        }
        Ok((Some(output), columns))
    });
    outputs.collect()
}

fn check(source: &Source, parts: &[&Part], axis: Axis, columns: &Columns) -> Result<(), Reason> {
    for (part, values) in parts.iter().zip(columns) {
        let name = source.recording(part.recording).map_or("", |own| own.name());
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

/// The branches as they are drawn.
#[derive(Clone, Debug, Default)]
pub struct Drawn {
    /// Branches as lines.
    pub strokes: Vec<Stroke>,
    /// How densely they lie, where they are more than can be drawn as lines.
    pub clouds: Vec<Cloud>,
}

/// How densely the rising or the falling branches lie.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// Which.
    pub rising: bool,
    /// How densely.
    pub density: Arc<Density>,
}

/// What is drawn of all recordings: rising and falling branches each by themselves; what never turns counts as rising.
pub(crate) fn drawn(
    loads: &[Vec<f64>],
    outputs: &[Vec<f64>],
    branches: &[Vec<Branch>],
    (frame, pixels): (Frame, [f64; 2]),
    progress: &Progress,
) -> Result<Drawn, Cancelled> {
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
