//! Loops of one axis: its load across, an output of the sensor up, and what they measure.

use crate::min_max::MinMax;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::progress::{Cancelled, Progress};
use crate::questions::loops::error::LookError;
use crate::questions::loops::frame::{MAX_POINTS, frame_around};
use crate::questions::loops::output::column_of;
use crate::questions::loops::output::{Output, Span};
use crate::questions::loops::source::{OutputLag, Part, Source};
use crate::questions::metrology::{Basis, MetrologySettings, Reason, check_numbers};
use crate::recording::Axis;
use crate::scoring::loops::{
    Branch, Cycle, Density, Frame, Loop, Loops, Outline, Stroke, common_loads, outline,
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
    /// Whether gauges and reference are brought to one time first.
    pub lag_removed: bool,
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
    /// The lag of the conventional load behind the reference.
    pub lag: OutputLag,
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
    /// Of each full cycle, by rate: the mean rate of its load (unit of the axis / s), and its mean width.
    pub by_rate: Vec<[f64; 2]>,
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

/// One output over its reference, part by part.
struct Curve {
    output: Option<Output>,
    loads: Arc<Columns>,
    values: Columns,
}

pub(crate) fn picture(
    source: &mut Source,
    parts: &[Part],
    question: &LoopQuestion,
    measuring: &MetrologySettings,
    progress: &Progress,
) -> Result<LoopPlot, LookError> {
    let axis = question.axis;
    let (column, full_scale) = column_of(&source.calibration, axis)?;
    let parts: Vec<&Part> =
        parts.iter().filter(|part| source.loads(part, axis).is_some()).collect();
    if parts.is_empty() {
        return Err(Reason::NoReference { axis }.into());
    }
    let is_static = |part: &&Part| {
        source.recording(part.recording).is_some_and(|recording| recording.is_static())
    };
    if parts.iter().any(is_static) {
        return Err(Reason::NoTimes { axis }.into());
    }
    measuring.validate(source.calibration.axes.len())?;
    let dead_band = source.rules(measuring).dead_band(column);
    let curves = curves(source, &parts, question, None)?;
    for columns in curves.iter().flat_map(|curve| [&*curve.loads, &curve.values]) {
        check(source, &parts, axis, columns)?;
    }
    let lag = source.lag(column, Output::Conventional, dead_band, progress)?;
    let curves = match question.lag_removed {
        true => {
            let compensated = source.lag(column, Output::Compensated, dead_band, progress)?;
            self::curves(source, &parts, question, Some([&lag, &compensated]))?
        }
        false => curves,
    };
    let load_range =
        curves.iter().map(|curve| range_of(&curve.loads)).fold(MinMax::NONE, MinMax::joined);
    let output_range =
        curves.iter().map(|curve| range_of(&curve.values)).fold(MinMax::NONE, MinMax::joined);
    let whole = frame_around(load_range, output_range);
    let canvas = (question.frame.unwrap_or(whole), question.pixels);
    let mut cycles: Vec<Arc<[Cycles; 3]>> = Vec::new();
    for (at, curve) in curves.iter().enumerate() {
        let same = (0..at).find(|other| Arc::ptr_eq(&curves[*other].loads, &curve.loads));
        cycles.push(match same {
            Some(other) => Arc::clone(&cycles[other]),
            None => Arc::new([1.0, 0.5, 2.0].map(|factor| {
                Cycles::of(axis, &curve.loads, factor * dead_band, range_of(&curve.loads))
            })),
        });
    }
    let times = |part: usize| {
        let part = parts[part];
        source.recording(part.recording).map(|own| &own.times()[part.samples.clone()])
    };
    let drawn = (curves.par_iter().zip(&cycles))
        .map(|(curve, cycles)| curve.drawn(axis, cycles, canvas, &times, progress));
    let drawn = drawn.collect::<Result<_, Cancelled>>()?;
    let own = &cycles[0][0];
    Ok(LoopPlot {
        question: question.clone(),
        dead_band,
        full_scale,
        output_scale: match question.up {
            Up::Gauge(_) => 0.5 * output_range.span(),
            Up::Load | Up::Error => full_scale,
        },
        n_samples: curves[0].loads.iter().map(Vec::len).sum(),
        parts: (parts.iter()).map(|part| (part.recording, part.samples.clone())).collect(),
        n_cycles: own.loops.cycles().len(),
        cycles: (own.loops.cycles().iter())
            .map(|cycle| {
                let part = parts[cycle.recording];
                let at = |sample: usize| part.samples.start + sample;
                let (from, to) = (cycle.first.samples.start, cycle.second.samples.end);
                (part.recording, at(from)..at(to))
            })
            .collect(),
        n_full_cycles: own.loops.full_cycles().len(),
        whole,
        curves: drawn,
        lag,
    })
}

impl Curve {
    fn drawn<'a>(
        &self,
        axis: Axis,
        [cycles, halved, doubled]: &[Cycles; 3],
        canvas: (Frame, [f64; 2]),
        times: &(impl Fn(usize) -> Option<&'a [f64]> + Sync),
        progress: &Progress,
    ) -> Result<LoopCurve, Cancelled> {
        let (loads, values) = (&*self.loads, &self.values);
        let load_range = range_of(loads);
        let share = |own: &[Cycle]| common_loads(own).share_of(load_range);
        let figures = |of: fn(&Cycles) -> &Result<Vec<Cycle>, Reason>| {
            let own = of(cycles).as_ref().map_err(Clone::clone)?;
            let mean = |cycles: &Vec<Cycle>| {
                let shapes = cycles.iter().map(|one| shape(one, loads, values));
                Loop::mean(&shapes.collect::<Vec<_>>())
            };
            let others = [halved, doubled].map(|other| of(other).as_ref().ok().and_then(mean));
            mean(own)
                .and_then(|found| LoopFigures::of(found, own.len(), share(own), others))
                .ok_or(Reason::Overflow { axis })
        };
        let by_rate = |cycle: &Cycle| {
            let times = times(cycle.recording)?;
            let (from, to) = (cycle.first.samples.start, cycle.second.samples.end - 1);
            let rate = (cycle.first.span() + cycle.second.span()) / (times[to] - times[from]);
            let width = shape(cycle, loads, values).mean_width();
            (rate.is_finite() && width.is_finite()).then_some([rate, width])
        };
        let mut by_rate: Vec<[f64; 2]> =
            cycles.loops.full_cycles().iter().filter_map(by_rate).collect();
        by_rate.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Ok(LoopCurve {
            output: self.output,
            drawn: drawn(loads, values, cycles.loops.branches(), canvas, progress)?,
            mean: figures(|own| &own.mean),
            largest: figures(|own| &own.largest),
            by_rate,
        })
    }
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
    fn of(axis: Axis, loads: &Columns, dead_band: f64, range: MinMax) -> Self {
        let loops = Loops::of(slices(loads), dead_band);
        let largest = loops.largest().map(|cycle| vec![cycle]);
        let largest = largest.ok_or_else(|| Reason::no_cycle(axis, &loops, range, dead_band));
        let enough = loops.mean_cycles(range);
        let mean = enough.map_err(|few| Reason::few_cycles(axis, few));
        Self { mean: largest.clone().and(mean), largest, loops }
    }
}

/// What goes up over what goes across, part by part; `lags` are those that are removed, of both outputs.
fn curves(
    source: &Source,
    parts: &[&Part],
    question: &LoopQuestion,
    lags: Option<[&OutputLag; 2]>,
) -> Result<Vec<Curve>, LookError> {
    let axis = question.axis;
    let (column, _) = column_of(&source.calibration, axis)?;
    let all = |of: &dyn Fn(&Part) -> Option<Vec<f64>>| -> Result<Columns, LookError> {
        let found: Option<Columns> = parts.iter().map(|part| of(part)).collect();
        found.ok_or(LookError::NoChannel)
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
    let outputs = Output::ALL.into_iter().enumerate().map(|(at, output)| {
        let loads = loads(at)?;
        let mut values = match in_time(at) {
            Some(lag) => all(&|part| source.refitted(part, output, lag))?,
            None => all(&|part| source.output(part, column, output))?,
        };
        if question.up == Up::Error {
            for (values, loads) in values.iter_mut().zip(&*loads) {
                values.iter_mut().zip(loads).for_each(|(value, load)| *value -= load);
            }
        }
        Ok(Curve { output: Some(output), loads, values })
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

fn range_of(columns: &Columns) -> MinMax {
    slices(columns).flatten().collect()
}

fn slices(columns: &Columns) -> impl Iterator<Item = &[f64]> {
    columns.iter().map(Vec::as_slice)
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
