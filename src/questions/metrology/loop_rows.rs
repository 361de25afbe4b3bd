//! Metrology rows from loops: hysteresis, nonlinearity, combined error, repeatability, and the time lag in the loops.

use crate::{
    min_max::MinMax,
    questions::metrology::{
        figures::{Basis, Figure, Place, Result, Value},
        measured::{AxisRun, AxisView, Lags},
        quantity::Quantity,
        reason::Reason,
    },
    recording::Axis,
    scoring::{
        lag::{WORTH_REMOVING, widths},
        loops::{
            Branch, Curve, Cycle, FULL_SHARE, Loop, Loops, TooFew, branches, common_loads,
            even_loads,
        },
    },
};

/// Minimum number of different loads on a branch, for a line that shows nonlinearity.
pub(crate) const FEWEST_LOADS: usize = 3;
/// Largest difference at which cycles count as repeated: between their reversals, as a share of the largest cycle's span, and
/// between the loads of another axis, as a share of its full scale.
const ALIKE: f64 = 0.05;
/// Minimum number of branches of repeated cycles: two cycles with two branches each.
const FEWEST_REPEATS: usize = 4;

pub(crate) struct LoopRows<'a> {
    view: &'a AxisView<'a>,
    cycles: Cycles,
}

impl<'a> LoopRows<'a> {
    pub(crate) fn of(view: &'a AxisView<'a>) -> Self {
        let loads = view.runs.iter().map(|run| run.loads);
        Self { view, cycles: Cycles::of(view.axis, loads, view.reversal_threshold) }
    }

    pub(crate) fn figures(&self, output: usize) -> Vec<(Quantity, Figure)> {
        let [largest_width, mean_width] = self.mean_loop(output);
        let [terminal, best_fit] =
            [Line::through_ends, |curve: &Curve| Line::best_fit(curve.averages())]
                .map(|line| self.nonlinearity(output, line));
        vec![
            (Quantity::Hysteresis, self.hysteresis(output)),
            (Quantity::MeanLoopHysteresis, largest_width),
            (Quantity::MeanWidth, mean_width),
            (Quantity::TerminalNonlinearity, terminal),
            (Quantity::BestFitNonlinearity, best_fit),
            (Quantity::CombinedError, self.combined_error(output)),
            (Quantity::Repeatability, self.repeatability(output)),
        ]
    }

    /// Returns the span of the largest cycle as a share of the load range; `None` without a cycle.
    pub(crate) fn share_of_range(&self) -> Option<f64> {
        let cycle = self.cycles.largest.as_ref().ok()?;
        Some(cycle.loads().share_of(self.cycles.range))
    }

    fn found(&self, size: f64, place: Option<Place>, n_cycles: usize, loads: MinMax) -> Value {
        let basis = Basis { n_cycles, range_share: loads.share_of(self.cycles.range) };
        Value { basis: Some(basis), ..Value::at(size, place) }
    }

    fn curve(&self, recording: usize, branch: &Branch, output: usize) -> Curve {
        let run = &self.view.runs[recording];
        Curve::of(branch, run.loads, |k| run.outputs[output][k])
    }

    fn cycle_loop(&self, cycle: &Cycle, output: usize) -> Loop {
        let run = &self.view.runs[cycle.recording];
        Loop::of(cycle, run.loads, |k| run.outputs[output][k])
    }

    fn largest(&self) -> Result<&Cycle> {
        self.cycles.largest.as_ref().map_err(Clone::clone)
    }

    fn hysteresis(&self, output: usize) -> Figure {
        let cycle = self.largest()?;
        let width = self.cycle_loop(cycle, output).largest_width();
        Ok(self.of_cycle(width, cycle))
    }

    fn of_cycle(&self, size: f64, cycle: &Cycle) -> Value {
        let samples = cycle.first.samples.start..cycle.second.samples.end;
        let place = self.view.runs[cycle.recording].place(samples);
        self.found(size, Some(place), 1, cycle.loads())
    }

    fn mean_loop(&self, output: usize) -> [Figure; 2] {
        let axis = self.view.axis;
        let mean = self.cycles.mean.as_ref().map_err(Clone::clone);
        let mean = mean.and_then(|cycles| {
            let loops = cycles.iter().map(|cycle| self.cycle_loop(cycle, output));
            let mean = Loop::mean(&loops.collect::<Vec<_>>());
            let mean = mean.ok_or(Reason::Overflow { axis })?;
            Ok((mean, cycles.len(), common_loads(cycles)))
        });
        [Loop::largest_width, Loop::mean_width].map(|width| {
            let (mean, n_cycles, loads) = mean.as_ref().map_err(Clone::clone)?;
            Ok(self.found(width(mean), None, *n_cycles, *loads))
        })
    }

    /// Returns the rising branch of the largest cycle, with the index of its recording. Without a cycle, the widest rising
    /// branch is used.
    fn rising(&self) -> Result<(usize, &Branch)> {
        match &self.cycles.largest {
            Ok(cycle) => Ok((cycle.recording, cycle.rising())),
            Err(no_cycle @ Reason::ConstantLoad { .. }) => Err(no_cycle.clone()),
            Err(_) => {
                let axis = self.view.axis;
                self.cycles.loops.widest_rising().ok_or(Reason::NoRisingBranch { axis })
            }
        }
    }

    fn nonlinearity(&self, output: usize, line: fn(&Curve) -> Option<Line>) -> Figure {
        let (recording, branch) = self.rising()?;
        let curve = self.curve(recording, branch, output);
        let line = self.enough(&curve, line)?;
        let ends = curve.ends();
        let size = line.largest_deviation(curve.averages().iter().chain(ends.iter().flatten()));
        let place = self.view.runs[recording].place(branch.samples.clone());
        Ok(self.found(size, Some(place), 1, branch.loads))
    }

    fn combined_error(&self, output: usize) -> Figure {
        let cycle = self.largest()?;
        let on = |branch| self.curve(cycle.recording, branch, output);
        let (rising, falling) = (on(cycle.rising()), on(cycle.falling()));
        let line = self.enough(&rising, Line::through_ends)?;
        let common = cycle.loads();
        let falling = falling.averages().iter().filter(|(load, _)| common.contains(*load));
        let size = line.largest_deviation(rising.averages().iter().chain(falling));
        Ok(self.of_cycle(size, cycle))
    }

    fn enough(&self, curve: &Curve, line: fn(&Curve) -> Option<Line>) -> Result<Line> {
        let found = curve.averages().len();
        let axis = self.view.axis;
        line(curve).filter(|_| found >= FEWEST_LOADS).ok_or(Reason::TooFewLoads { axis, found })
    }

    /// Returns the repeatability: the largest difference at equal load between branches of the same direction, in repeated
    /// cycles.
    fn repeatability(&self, output: usize) -> Figure {
        let axis = self.view.axis;
        let mut why_not = Reason::TooFewCycles { axis };
        let span = match &self.cycles.largest {
            Ok(cycle) => cycle.span(),
            Err(reason @ Reason::ConstantLoad { .. }) => return Err(reason.clone()),
            Err(_) => return Err(why_not),
        };
        let mut worst: Option<Value> = None;
        for run in &self.view.runs {
            // Branches that cover less than half the load range of the largest cycle belong to smaller cycles.
            let mut large = branches(run.loads, 0.5 * span);
            trim(&mut large, run.loads);
            if large.len() >= FEWEST_REPEATS {
                why_not = Reason::NotRepeated { axis };
            }
            for repeated in repeats(&large, span) {
                let (rising, falling): (Vec<&Branch>, Vec<&Branch>) =
                    repeated.iter().partition(|branch| branch.rising);
                let ways = [rising, falling];
                if let Some(other) = self.differs(run, &ways) {
                    why_not = Reason::OthersDiffer { axis, other };
                    continue;
                }
                let size = spread(&ways, run.loads, &run.outputs[output]);
                let [first, .., last] = repeated else { continue };
                let samples = first.samples.start..last.samples.end;
                let loads = repeated.iter().map(|one| one.loads).collect();
                let found = self.found(size, Some(run.place(samples)), repeated.len() / 2, loads);
                if worst.as_ref().is_none_or(|worst| found.value > worst.value) {
                    worst = Some(found);
                }
            }
        }
        worst.ok_or(why_not)
    }

    /// Returns an axis that makes the cycles differ: at equal load of this axis, the load of the other axis differs between
    /// branches of the same direction.
    fn differs(&self, run: &AxisRun<'_>, ways: &[Vec<&Branch>; 2]) -> Option<Axis> {
        let measured = self.view.measured;
        let axes = measured.axes.iter().zip(measured.full_scale).zip(&run.columns.loads);
        axes.filter(|((axis, full_scale), _)| **axis != self.view.axis && **full_scale > 0.0)
            .find_map(|((axis, full_scale), loads)| {
                let apart = spread(ways, run.loads, loads.as_ref()?);
                (apart > ALIKE * full_scale).then_some(*axis)
            })
    }
}

/// Moves the start of the first branch and the end of the last branch to their extreme loads. A turn there that is smaller
/// than the reversal threshold is no reversal.
fn trim(branches: &mut [Branch], loads: &[f64]) {
    let farthest = |branch: &Branch, highest: bool| {
        let sign = if highest { 1.0 } else { -1.0 };
        let samples = branch.samples.clone();
        samples.max_by(|a, b| (sign * loads[*a]).total_cmp(&(sign * loads[*b])))
    };
    if let Some(first) = branches.first_mut() {
        let start = farthest(first, !first.rising);
        first.samples.start = start.unwrap_or(first.samples.start);
    }
    if let Some(last) = branches.last_mut() {
        let end = farthest(last, last.rising);
        last.samples.end = end.map_or(last.samples.end, |end| end + 1);
    }
}

/// Returns the longest series of consecutive branches that turn at nearly the same loads. Each branch covers most of `span`,
/// the load range of the largest cycle. A series has at least two branches of each direction.
fn repeats(branches: &[Branch], span: f64) -> Vec<&[Branch]> {
    let alike = |a: &Branch, b: &Branch| {
        let turns = [(a.loads.min, b.loads.min), (a.loads.max, b.loads.max)];
        turns.iter().all(|(a, b)| (a - b).abs() <= ALIKE * span) && b.span() >= FULL_SHARE * span
    };
    let mut found = Vec::new();
    let mut start = 0;
    while start < branches.len() {
        let rest = &branches[start..];
        let same = rest.iter().take_while(|other| alike(&rest[0], other));
        let n = same.count();
        if n >= FEWEST_REPEATS {
            found.push(&rest[..n]);
            start += n;
        } else {
            start += 1;
        }
    }
    found
}

/// Returns the largest difference at equal load between branches of the same direction. A difference needs two branches with a
/// common range of loads.
fn spread(ways: &[Vec<&Branch>; 2], loads: &[f64], outputs: &[f64]) -> f64 {
    let of_way = |branches: &Vec<&Branch>| {
        let common = MinMax::common(branches.iter().map(|one| one.loads));
        if branches.len() < 2 || common.span() == 0.0 {
            return 0.0;
        }
        let curves: Vec<Curve> =
            branches.iter().map(|branch| Curve::of(branch, loads, |k| outputs[k])).collect();
        even_loads(common)
            .map(|load| curves.iter().map(|curve| curve.at(load)).collect::<MinMax>().span())
            .fold(0.0, f64::max)
    };
    ways.iter().map(of_way).fold(0.0, f64::max)
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    load: f64,
    output: f64,
    slope: f64,
}

impl Line {
    fn through_ends(curve: &Curve) -> Option<Self> {
        let [(x0, y0), (x1, y1)] = curve.ends()?;
        Some(Self { load: x0, output: y0, slope: (y1 - y0) / (x1 - x0) })
    }

    pub(crate) fn best_fit(points: &[(f64, f64)]) -> Option<Self> {
        let n = points.len() as f64;
        let load = points.iter().map(|(x, _)| x).sum::<f64>() / n;
        let output = points.iter().map(|(_, y)| y).sum::<f64>() / n;
        let xx: f64 = points.iter().map(|(x, _)| (x - load).powi(2)).sum();
        let xy: f64 = points.iter().map(|(x, y)| (x - load) * (y - output)).sum();
        (xx > 0.0).then(|| Self { load, output, slope: xy / xx })
    }

    pub(crate) fn largest_deviation<'b>(
        &self,
        points: impl Iterator<Item = &'b (f64, f64)>,
    ) -> f64 {
        points
            .map(|(x, y)| (y - self.output - self.slope * (x - self.load)).abs())
            .fold(0.0, f64::max)
    }
}

#[derive(Debug)]
pub(crate) struct Cycles {
    /// Minimum and maximum load of the axis in all recordings.
    pub range: MinMax,
    pub loops: Loops,
    pub largest: Result<Cycle>,
    /// Cycles that are averaged to the mean loop.
    pub mean: Result<Vec<Cycle>>,
}

impl Cycles {
    pub fn of<'a>(
        axis: Axis,
        recordings: impl Iterator<Item = &'a [f64]> + Clone,
        reversal_threshold: f64,
    ) -> Self {
        let range: MinMax = recordings.clone().flatten().collect();
        let loops = Loops::of(recordings, reversal_threshold);
        let largest =
            loops.largest().ok_or_else(|| no_cycle(axis, &loops, range, reversal_threshold));
        let mean = loops.mean_cycles(range).map_err(|TooFew { count, share }| Reason::FewCycles {
            axis,
            count,
            share,
        });
        Self { mean: largest.clone().and(mean), largest, range, loops }
    }
}

fn no_cycle(axis: Axis, loops: &Loops, range: MinMax, reversal_threshold: f64) -> Reason {
    let mut ways = loops.branches().iter().flatten().map(|branch| branch.rising);
    match ways.next() {
        None => {
            let (low, high) = range.ends().unwrap_or_default();
            Reason::ConstantLoad { axis, low, high, reversal_threshold }
        }
        Some(rises) if ways.all(|other| other == rises) => Reason::OneBranch { axis, rises },
        Some(_) => Reason::NoCycle { axis },
    }
}

type Rows = [(Quantity, Figure); 2];

/// Returns two rows of one output (uncompensated or compensated load): its time lag, and its hysteresis without the lag. Also
/// returns the share of the loop's mean width that the lag explains. `place` is the position of the axis.
pub(crate) fn lag_figures(
    view: &AxisView<'_>,
    lags: &Lags,
    place: usize,
    output: usize,
) -> (Rows, Option<f64>) {
    let axis = view.axis;
    let rows = |lag, without| [(Quantity::TimeLag, lag), (Quantity::HysteresisWithoutLag, without)];
    let lag = match &lags[output][place] {
        Ok(lag) => lag,
        Err(reason) => {
            let none = Err(Reason::NoLag { axis, reason: *reason });
            return (rows(none.clone(), none), None);
        }
    };
    let found = Ok(Value::everywhere(lag.seconds));
    if !lag.is_significant() {
        return (rows(found, Err(Reason::LagExplainsLittle { axis, share: 0.0 })), Some(0.0));
    }
    let runs = view.measured.lag_runs(output);
    let Some(widths) = widths(lag, place, &runs, view.reversal_threshold) else {
        return (rows(found, Err(Reason::NoCycle { axis })), None);
    };
    let share = widths.explained_share();
    let without = match share > WORTH_REMOVING {
        true if widths.is_uncertain(view.full_scale) => {
            Err(Reason::LagTooUncertain { axis, uncertainty: widths.uncertainty })
        }
        true => Ok(Value::everywhere(widths.largest[1])),
        false => Err(Reason::LagExplainsLittle { axis, share }),
    };
    (rows(found, without), Some(share))
}
