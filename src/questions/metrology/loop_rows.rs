//! Metrology rows from loops: hysteresis, loop area, nonlinearity, combined error, repeatability, and the time lag in the loops.
//! On a staircase, the readings at the ends of the steps take the place of all samples.

use crate::{
    min_max::MinMax,
    questions::metrology::{
        dwell_rows::{FEWEST_LOADS, repeatability, table_noise},
        figures::{Basis, Figure, Found, OUTPUTS, Place, Quantity, Reason, Value},
        measured::{AxisRun, AxisView, Lags},
    },
    recording::Axis,
    scoring::{
        holds::Hold,
        lag::{WORTH_REMOVING, widths},
        loops::{
            Branch, Curve, Cycle, FULL_SHARE, Loop, Loops, TooFew, branches, common_loads, quiet,
        },
        straight_lines::Line,
    },
};

/// Largest difference at which cycles count as repeated: between their reversals, as a share of the largest cycle's span, and
/// between the loads of another axis, as a share of its full scale.
const ALIKE: f64 = 0.05;
/// Two standard deviations of the noise of a smoothed branch, as a share of its largest deviation.
const NOISE: f64 = 0.05;
/// Minimum number of branches of repeated cycles: two cycles with two branches each.
const FEWEST_REPEATS: usize = 4;

pub struct LoopRows<'a> {
    view: &'a AxisView<'a>,
    cycles: Cycles,
    /// Standard deviation of one reading of each output; `None` if the recordings are no tables of readings.
    table_noise: Option<[f64; OUTPUTS]>,
}

impl<'a> LoopRows<'a> {
    pub fn of(view: &'a AxisView<'a>) -> Self {
        let loads = view.runs.iter().map(|run| run.loads);
        let mut cycles = Cycles::of(view.axis, loads, view.reversal_threshold);
        let table_noise = table_noise(view);
        let width = |cycle: &Cycle| {
            let run = &view.runs[cycle.recording];
            Loop::of(cycle, run.loads, |k| run.outputs[0][k]).largest_width()
        };
        // Loads that are set by hand make cycles with equal ranges.
        let equal = if table_noise.is_some() { cycles.loops.largest_cycles() } else { Vec::new() };
        if let Some(widest) = equal.into_iter().max_by(|a, b| width(a).total_cmp(&width(b))) {
            cycles.largest = Ok(widest);
        }
        Self { view, cycles, table_noise }
    }

    pub fn figures(&self, output: usize) -> Vec<(Quantity, Figure)> {
        let largest = self.cycles.largest.as_ref().map(std::slice::from_ref);
        let mean = self.cycles.mean.as_deref().map_err(Clone::clone);
        let terminal = self.nonlinearity(output, |path| Line::through_ends(&path.points));
        let best_fit = self.nonlinearity(output, |path| Line::best_fit(path.averages()));
        vec![
            (Quantity::Hysteresis, self.hysteresis(largest.map_err(Clone::clone), output)),
            (Quantity::MeanLoopHysteresis, self.hysteresis(mean, output)),
            (Quantity::LoopArea, self.area(self.averaged(), output)),
            (Quantity::TerminalNonlinearity, terminal),
            (Quantity::BestFitNonlinearity, best_fit),
            (Quantity::CombinedError, self.combined_error(output)),
            (
                Quantity::Repeatability,
                match self.table_noise {
                    Some(_) => repeatability(self.view, output),
                    None => self.repeatability(output),
                },
            ),
        ]
    }

    /// Returns the span of the largest cycle as a share of the load range; `None` without a cycle.
    pub fn share_of_range(&self) -> Option<f64> {
        let cycle = self.cycles.largest.as_ref().ok()?;
        Some(cycle.loads().share_of(self.cycles.range))
    }

    fn basis(&self, found: Value, n_cycles: usize, loads: MinMax) -> Value {
        let basis = Basis { n_cycles, range_share: loads.share_of(self.cycles.range) };
        Value { basis: Some(basis), ..found }
    }

    /// Returns the output along a branch, and on a staircase the noise of one reading.
    fn curve(&self, run: &AxisRun<'_>, branch: &Branch, output: usize) -> (Curve, Option<f64>) {
        let outputs = &run.outputs[output];
        match readings(self.view, run, branch, outputs) {
            Some((readings, noise)) => {
                let noise = self.table_noise.map_or(noise, |noise| noise[output]);
                (Curve::through(readings), Some(noise))
            }
            None => (Curve::of(branch, run.loads, |k| outputs[k]), None),
        }
    }

    /// Returns the cycles that are averaged: those of the mean loop, or without a mean loop the largest cycle.
    fn averaged(&self) -> Found<&[Cycle]> {
        let largest = self.cycles.largest.as_ref().map_err(Clone::clone)?;
        Ok(self.cycles.mean.as_ref().map_or(std::slice::from_ref(largest), |cycles| cycles))
    }

    /// Returns the interval of the only cycle; `None` if several cycles are averaged.
    fn place(&self, cycles: &[Cycle]) -> Option<Place> {
        let [cycle] = cycles else { return None };
        let samples = cycle.first.samples.start..cycle.second.samples.end;
        Some(self.view.runs[cycle.recording].place(samples))
    }

    /// Returns the mean loop of cycles.
    fn mean_loop(&self, cycles: &[Cycle], output: usize) -> Found<Loop> {
        let loops = cycles.iter().map(|cycle| {
            let run = &self.view.runs[cycle.recording];
            Loop::of(cycle, run.loads, |k| run.outputs[output][k])
        });
        let axis = self.view.axis;
        Loop::mean(&loops.collect::<Vec<_>>()).ok_or(Reason::Overflow { axis })
    }

    fn area(&self, cycles: Found<&[Cycle]>, output: usize) -> Figure {
        let cycles = cycles?;
        let found = Value::at(self.mean_loop(cycles, output)?.area(), self.place(cycles));
        Ok(self.basis(found, cycles.len(), common_loads(cycles)))
    }

    /// Returns the largest width of the mean of these cycles. On staircases, the readings at the ends of the steps are compared.
    fn hysteresis(&self, cycles: Found<&[Cycle]>, output: usize) -> Figure {
        let cycles = cycles?;
        let (size, noise) = match self.width_of_steps(cycles, output) {
            Some(of_steps) => of_steps,
            None => {
                let mean = self.mean_loop(cycles, output)?;
                (mean.largest_width(), mean.width_noise())
            }
        };
        self.view.above_noise(size, noise, None)?;
        let found = Value { uncertainty: Some(noise), ..Value::at(size, self.place(cycles)) };
        Ok(self.basis(found, cycles.len(), common_loads(cycles)))
    }

    /// Returns the largest difference between the readings of the falling and the rising branches of staircases, and its noise;
    /// `None` if a branch is no staircase, or in a table.
    fn width_of_steps(&self, cycles: &[Cycle], output: usize) -> Option<(f64, f64)> {
        let on = |branch: fn(&Cycle) -> &Branch| -> Option<Path> {
            let branches: Vec<(usize, &Branch)> =
                cycles.iter().map(|cycle| (cycle.recording, branch(cycle))).collect();
            let are_steps = branches.iter().all(|(recording, branch)| {
                let run = &self.view.runs[*recording];
                readings(self.view, run, branch, &run.outputs[output]).is_some()
            });
            if are_steps { self.path(&branches, output).ok() } else { None }
        };
        if self.table_noise.is_some() {
            return None;
        }
        let (rising, falling) = (on(Cycle::rising)?, on(Cycle::falling)?);
        let along = Curve::through(falling.points.clone());
        let ends: MinMax = falling.points.iter().map(|(load, _)| *load).collect();
        let shared = rising.points.iter().filter(|(load, _)| ends.contains(*load));
        let widths = shared.map(|(load, rising)| (along.at(*load) - rising).abs());
        Some((widths.fold(0.0, f64::max), rising.noise.hypot(falling.noise)))
    }

    /// Returns the mean of these branches, which have one direction.
    fn path(&self, branches: &[(usize, &Branch)], output: usize) -> Found<Path> {
        let curves: Vec<(Curve, Option<f64>)> = (branches.iter())
            .map(|(recording, branch)| self.curve(&self.view.runs[*recording], branch, output))
            .collect();
        let common = MinMax::common(branches.iter().map(|(_, branch)| branch.loads));
        let mean = |load: f64| {
            let sum: f64 = curves.iter().map(|(curve, _)| curve.at(load)).sum();
            (load, sum / curves.len() as f64)
        };
        let points: Vec<(f64, f64)> = shared_loads(&curves).map(mean).collect();
        let (axis, found) = (self.view.axis, points.len());
        let line = Line::best_fit(&points).filter(|_| found >= FEWEST_LOADS);
        let line = line.ok_or(Reason::TooFewLoads { axis, found })?;
        if let Some(noise) = curves[0].1 {
            // A line through two points has half the variance of a point between them.
            let noise = noise * (1.5 / curves.len() as f64).sqrt();
            return Ok(Path { points, n_carried: 0, noise, common });
        }
        let off: Vec<f64> = points.iter().map(|point| line.deviation(point)).collect();
        let (off, noise) = quiet(&off, NOISE, f64::INFINITY);
        let smooth = points.iter().zip(off).map(|((load, _), off)| (*load, line.at(*load) + off));
        let mut points: Vec<(f64, f64)> = smooth.collect();
        // The averages of the outermost hundredths are carried on to the ends of the branches.
        let [(first, second), (last, before)] =
            [(points[0], points[1]), (points[found - 1], points[found - 2])];
        points.insert(0, carried(common.min, first, second));
        points.push(carried(common.max, last, before));
        Ok(Path { points, n_carried: 1, noise, common })
    }

    /// Returns the rising branches of the averaged cycles, with the indices of their recordings. Without a cycle, the widest
    /// rising branch is used.
    fn rising(&self) -> Found<Vec<(usize, &Branch)>> {
        match self.averaged() {
            Ok(cycles) => {
                Ok(cycles.iter().map(|cycle| (cycle.recording, cycle.rising())).collect())
            }
            Err(no_cycle @ Reason::ConstantLoad { .. }) => Err(no_cycle),
            Err(_) => {
                let axis = self.view.axis;
                let widest = self.cycles.loops.widest_rising();
                Ok(vec![widest.ok_or(Reason::NoRisingBranch { axis })?])
            }
        }
    }

    fn nonlinearity(&self, output: usize, line: fn(&Path) -> Option<Line>) -> Figure {
        let branches = self.rising()?;
        let path = self.path(&branches, output)?;
        let place = match branches[..] {
            [(recording, branch)] => Some(self.view.runs[recording].place(branch.samples.clone())),
            _ => None,
        };
        let line = line(&path).ok_or(Reason::Overflow { axis: self.view.axis })?;
        let size = line.largest_deviation(path.points.iter());
        let found = self.view.above_noise(size, path.noise, place)?;
        Ok(self.basis(found, branches.len(), path.common))
    }

    fn combined_error(&self, output: usize) -> Figure {
        let cycles = self.averaged()?;
        let on = |branch: fn(&Cycle) -> &Branch| {
            let branches = cycles.iter().map(|cycle| (cycle.recording, branch(cycle)));
            self.path(&branches.collect::<Vec<_>>(), output)
        };
        let (rising, falling) = (on(Cycle::rising)?, on(Cycle::falling)?);
        let axis = self.view.axis;
        let line = Line::through_ends(&rising.points).ok_or(Reason::Overflow { axis })?;
        let common = common_loads(cycles);
        let falling_points = falling.points.iter().filter(|(load, _)| common.contains(*load));
        let size = line.largest_deviation(rising.points.iter().chain(falling_points));
        let noise = rising.noise.hypot(falling.noise);
        let found = self.view.above_noise(size, noise, self.place(cycles))?;
        Ok(self.basis(found, cycles.len(), common))
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
        let mut worst: Option<Figure> = None;
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
                let (size, noise) = spread(&ways, |branch| self.curve(run, branch, output));
                let [first, .., last] = repeated else { continue };
                let samples = first.samples.start..last.samples.end;
                let loads = repeated.iter().map(|one| one.loads).collect();
                let found = self.view.above_noise(size, noise, Some(run.place(samples)));
                let found = found.map(|found| self.basis(found, repeated.len() / 2, loads));
                let size = |figure: &Figure| figure.as_ref().map_or(0.0, |found| found.value);
                if worst.as_ref().is_none_or(|worst| size(&found) > size(worst)) {
                    worst = Some(found);
                }
            }
        }
        worst.unwrap_or(Err(why_not))
    }

    /// Returns an axis that makes the cycles differ: at equal load of this axis, the load of the other axis differs between
    /// branches of the same direction.
    fn differs(&self, run: &AxisRun<'_>, ways: &[Vec<&Branch>; 2]) -> Option<Axis> {
        let measured = self.view.measured;
        let axes = measured.axes.iter().zip(measured.full_scale).zip(&run.columns.loads);
        axes.filter(|((axis, full_scale), _)| **axis != self.view.axis && **full_scale > 0.0)
            .find_map(|((axis, full_scale), loads)| {
                let loads = loads.as_ref()?;
                let on = |branch: &Branch| (Curve::of(branch, run.loads, |k| loads[k]), Some(0.0));
                let (apart, _) = spread(ways, on);
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

/// Returns the largest difference at equal load between branches of the same direction, and a standard deviation of its noise.
/// A difference needs two branches with a common range of loads.
fn spread(ways: &[Vec<&Branch>; 2], curve: impl Fn(&Branch) -> (Curve, Option<f64>)) -> (f64, f64) {
    let of_way = |branches: &Vec<&Branch>| {
        let common = MinMax::common(branches.iter().map(|one| one.loads));
        if branches.len() < 2 || common.span() == 0.0 {
            return (0.0, 0.0);
        }
        let curves: Vec<_> = branches.iter().map(|branch| curve(branch)).collect();
        let mean = |load: f64| {
            curves.iter().map(|(curve, _)| curve.at(load)).sum::<f64>() / curves.len() as f64
        };
        let off: Vec<(Vec<f64>, f64)> = (curves.iter())
            .map(|(curve, noise)| {
                let off: Vec<f64> =
                    shared_loads(&curves).map(|load| curve.at(load) - mean(load)).collect();
                noise
                    .map_or_else(|| quiet(&off, NOISE, f64::INFINITY), |noise| (off.clone(), noise))
            })
            .collect();
        let n_loads = off[0].0.len();
        let apart = (0..n_loads).map(|at| off.iter().map(|(off, _)| off[at]).collect::<MinMax>());
        let noise = off.iter().map(|(_, noise)| *noise).fold(0.0, f64::max);
        // Of several branches and many loads, the difference with the most noise is taken.
        (apart.map(MinMax::span).fold(0.0, f64::max), 2.0 * noise)
    };
    let [rising, falling] = ways.each_ref().map(of_way);
    if rising.0 > falling.0 { rising } else { falling }
}

/// Returns the loads of the first curve's averages that lie between the outer averages of all curves. The outer steps of
/// staircases may differ a little.
fn shared_loads(curves: &[(Curve, Option<f64>)]) -> impl Iterator<Item = f64> {
    let range = MinMax::common(curves.iter().map(|(curve, _)| {
        let averages = curve.averages();
        MinMax { min: averages[0].0, max: averages[averages.len() - 1].0 }
    }));
    let slack = if curves[0].1.is_some() { ALIKE * range.span() } else { 0.0 };
    let range = MinMax { min: range.min - slack, max: range.max + slack };
    let loads = curves[0].0.averages().iter().map(|(load, _)| *load);
    loads.filter(move |load| range.contains(*load))
}

/// Output as a function of the load along the mean of several branches.
struct Path {
    /// Points `(load, output)` with rising loads.
    points: Vec<(f64, f64)>,
    /// Number of points at each end that are not averages, but carried on from averages.
    n_carried: usize,
    /// Standard deviation of the noise of a point.
    noise: f64,
    /// Range of loads that all branches cover.
    common: MinMax,
}

impl Path {
    fn averages(&self) -> &[(f64, f64)] {
        &self.points[self.n_carried..self.points.len() - self.n_carried]
    }
}

/// Returns the point at this load on the line through two points.
fn carried(load: f64, (x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> (f64, f64) {
    (load, y0 + (y1 - y0) * (load - x0) / (x1 - x0))
}

#[derive(Debug)]
pub struct Cycles {
    /// Minimum and maximum load of the axis in all recordings.
    pub range: MinMax,
    pub loops: Loops,
    pub largest: Found<Cycle>,
    /// Cycles that are averaged to the mean loop.
    pub mean: Found<Vec<Cycle>>,
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
pub fn lag_figures(
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
    if !lag.is_significant() {
        let none = Reason::NoLagFound { axis, uncertainty_secs: 2.0 * lag.standard_error_secs };
        return (rows(Err(none), Err(Reason::LagExplainsLittle { axis, share: 0.0 })), Some(0.0));
    }
    let uncertainty = Some(lag.standard_error_secs);
    let found = Ok(Value { uncertainty, ..Value::everywhere(lag.seconds) });
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

/// Share of a step, at its end, whose samples are averaged to a reading.
const READ: f64 = 1.0 / 3.0;
/// Largest change of the load within a step, as a share of the largest movement in a dwell. A steady ramp changes by two
/// thirds.
const MOVED: f64 = 0.3;
/// Minimum share of a branch's samples that lie in steps, if the branch is a staircase.
const HELD: f64 = 0.5;

/// Returns the readings `(load, output)` at the ends of the steps of a branch, and the noise of one reading; `None` if the branch
/// is no staircase.
pub fn readings(
    view: &AxisView<'_>,
    run: &AxisRun<'_>,
    branch: &Branch,
    outputs: &[f64],
) -> Option<(Vec<(f64, f64)>, f64)> {
    let within = |step: &Hold| {
        let (start, end) = (
            step.samples.start.max(branch.samples.start),
            step.samples.end.min(branch.samples.end),
        );
        let is_nested = branch.nested.iter().any(|inner| inner.start <= start && end <= inner.end);
        if is_nested { 0 } else { end.saturating_sub(start) }
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mut held, mut squares) = (0, 0.0);
    let mut readings: Vec<(f64, f64)> = Vec::new();
    let steps = &view.measured.steps[run.index];
    let first = steps.partition_point(|step| step.samples.end <= branch.samples.start);
    let steps = steps[first..].iter().take_while(|step| step.samples.start < branch.samples.end);
    for step in steps.filter(|step| within(step) > 0) {
        let n = (READ * step.samples.len() as f64).ceil() as usize;
        let (begin, end) = (step.samples.start, step.samples.end);
        let load = mean(&run.loads[end - n..end]);
        let moved = load - mean(&run.loads[begin..begin + n]);
        if moved.abs() > MOVED * view.still {
            continue;
        }
        held += within(step);
        let read = &outputs[end - n..end];
        let output = mean(read);
        // A dwell that a disturbance divides is one step, which ends with its last part.
        if readings.last().is_some_and(|(last, _)| (last - load).abs() <= view.still) {
            readings.pop();
        }
        readings.push((load, output));
        let variance = read.iter().map(|value| (value - output).powi(2)).sum::<f64>();
        squares += variance / (n as f64 * (n as f64 - 1.0).max(1.0));
    }
    let is_staircase =
        readings.len() >= FEWEST_LOADS && held as f64 >= HELD * branch.kept().count() as f64;
    let noise = (squares / readings.len().max(1) as f64).sqrt();
    is_staircase.then_some((readings, noise))
}
