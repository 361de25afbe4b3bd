//! Loops of one axis: an output over the reference load, and the figures of the loops.

use crate::min_max::MinMax;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::progress::{Cancelled, Progress};
use crate::questions::loops::error::LookError;
use crate::questions::loops::frame::{MAX_POINTS, frame_around};
use crate::questions::loops::output::Output;
use crate::questions::loops::output::column_of;
use crate::questions::loops::request::{LoopQuestion, Up};
use crate::questions::loops::source::{OutputLag, Part, Source};
use crate::questions::metrology::{Basis, MetrologySettings, Reason, check_numbers};
use crate::recording::Axis;
use crate::scoring::loops::{
    Branch, Cycle, Density, Frame, Loop, Loops, Outline, Stroke, common_loads, outline,
};

/// Loops, ready to be drawn.
#[derive(Clone, Debug)]
pub struct LoopPlot {
    pub question: LoopQuestion,
    /// Reversal threshold, in the unit of the axis.
    pub reversal_threshold: f64,
    /// Full scale of the axis; 0 if there is none.
    pub full_scale: f64,
    /// Value of the output that is 100 %: full scale, or half the range of the gauge; 0 if there is none.
    pub output_scale: f64,
    pub n_samples: usize,
    /// Plotted recordings, with their samples after decimation.
    pub parts: Vec<(usize, Range<usize>)>,
    pub n_cycles: usize,
    /// Recording and samples (after decimation) of each cycle, sorted by their beginnings.
    pub cycles: Vec<(usize, Range<usize>)>,
    /// Number of full cycles.
    pub n_full_cycles: usize,
    pub whole: Frame,
    /// Curves: one for a gauge, else those of the uncompensated and the compensated load.
    pub curves: Vec<LoopCurve>,
    pub lag: OutputLag,
}

#[derive(Clone, Debug)]
pub struct LoopCurve {
    /// Output; `None` for a gauge.
    pub output: Option<Output>,
    pub drawn: Drawn,
    pub mean: Result<LoopFigures, Reason>,
    pub largest: Result<LoopFigures, Reason>,
    /// Mean rate of the load (unit of the axis / s) and mean width of each full cycle, sorted by rate.
    pub by_rate: Vec<[f64; 2]>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct LoopFigures {
    pub shape: Loop,
    /// Rising and falling branch as points `[load, output]`.
    pub branches: [Vec<[f64; 2]>; 2],
    /// The width as points `[load, falling − rising]`.
    pub widths: Vec<[f64; 2]>,
    /// Largest width, in the unit of the output.
    pub largest_width: f64,
    pub mean_width: f64,
    /// Area between the branches, in the unit of the output times that of the axis.
    pub area: f64,
    /// Area with the sign of the width (dissipated work), in the same unit.
    pub work: f64,
    /// Basis of each of the four figures, in this order.
    pub basis: [Basis; 4],
}

impl LoopFigures {
    /// Computes the figures, also with half and twice the reversal threshold; `None` if a figure is too large for a number.
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
                reversal_threshold_halved: of(&others[0]),
                reversal_threshold_doubled: of(&others[1]),
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

type Columns = Vec<Vec<f64>>;

/// One output over its reference, for each part.
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
    let reversal_threshold = source.rules(measuring).reversal_threshold(column);
    let curves = curves(source, &parts, question, None)?;
    for columns in curves.iter().flat_map(|curve| [&*curve.loads, &curve.values]) {
        check(source, &parts, axis, columns)?;
    }
    let lag = source.lag(column, Output::Conventional, reversal_threshold, progress)?;
    let curves = match question.lag_removed {
        true => {
            let compensated =
                source.lag(column, Output::Compensated, reversal_threshold, progress)?;
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
                Cycles::of(axis, &curve.loads, factor * reversal_threshold, range_of(&curve.loads))
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
        reversal_threshold,
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

struct Cycles {
    loops: Loops,
    mean: Result<Vec<Cycle>, Reason>,
    largest: Result<Vec<Cycle>, Reason>,
}

impl Cycles {
    fn of(axis: Axis, loads: &Columns, reversal_threshold: f64, range: MinMax) -> Self {
        let loops = Loops::of(slices(loads), reversal_threshold);
        let largest = loops.largest().map(|cycle| vec![cycle]);
        let largest =
            largest.ok_or_else(|| Reason::no_cycle(axis, &loops, range, reversal_threshold));
        let enough = loops.mean_cycles(range);
        let mean = enough.map_err(|few| Reason::few_cycles(axis, few));
        Self { mean: largest.clone().and(mean), largest, loops }
    }
}

/// Returns the output over the reference for each part. `lags` are removed from both outputs.
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

#[derive(Clone, Debug, Default)]
pub struct Drawn {
    pub strokes: Vec<Stroke>,
    /// Density of the branches, if there are too many for lines.
    pub clouds: Vec<Cloud>,
}

#[derive(Clone, Debug)]
pub struct Cloud {
    pub rising: bool,
    pub density: Arc<Density>,
}

/// Draws all recordings, with rising and falling branches apart. A load that never turns counts as rising.
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
