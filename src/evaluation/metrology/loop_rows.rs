//! The rows that come from loops: hysteresis, nonlinearity, combined error, repeatability.

use super::measured::{AxisRun, AxisView};
use super::reason::Reason;
use super::{Found, Result};
use crate::evaluation::loops::{Branch, Curve, Cycle, Loop, Loops, even_loads};

/// A line through fewer averages than this says nothing about linearity.
const FEWEST_AVERAGES: usize = 3;

/// The loops of one axis, with the curves that several rows need.
pub(super) struct LoopRows<'a> {
    view: &'a AxisView<'a>,
    loops: Loops,
    /// The largest cycle, or why there is none.
    largest: Result<Cycle>,
    full_cycles: Vec<Cycle>,
}

impl<'a> LoopRows<'a> {
    pub(super) fn of(view: &'a AxisView<'a>) -> Self {
        let loops = Loops::of(view.runs.iter().map(|run| run.loads), view.dead_band);
        let largest = loops
            .largest()
            .ok_or_else(|| Reason::no_cycle(view.axis, &loops, view.range(), view.dead_band));
        let full_cycles = loops.full_cycles();
        Self {
            view,
            loops,
            largest,
            full_cycles,
        }
    }

    /// Hysteresis, largest and mean width of the mean loop, terminal and best-fit nonlinearity, combined error,
    /// repeatability of one output.
    pub(super) fn figures(&self, output: usize) -> [Result<Found>; 7] {
        let [largest_width, mean_width] = self.mean_loop(output);
        [
            self.hysteresis(output),
            largest_width,
            mean_width,
            self.nonlinearity(output, Line::through_ends),
            self.nonlinearity(output, Line::best_fit),
            self.combined_error(output),
            self.repeatability(output),
        ]
    }

    /// What the largest cycle spans, as a share of the whole range of the load; `None` without a cycle.
    pub(super) fn share_of_range(&self) -> Option<f64> {
        let cycle = self.largest.as_ref().ok()?;
        let (low, high) = self.view.range();
        Some(cycle.span() / (high - low))
    }

    fn run(&self, recording: usize) -> &AxisRun<'a> {
        &self.view.runs[recording]
    }

    fn curve(&self, recording: usize, branch: &Branch, output: usize) -> Curve {
        let run = self.run(recording);
        Curve::of(branch, run.loads, run.outputs[output])
    }

    fn cycle_loop(&self, cycle: &Cycle, output: usize) -> Loop {
        let run = self.run(cycle.recording);
        Loop::of(cycle, run.loads, run.outputs[output])
    }

    fn largest(&self) -> Result<&Cycle> {
        self.largest.as_ref().map_err(Clone::clone)
    }

    fn hysteresis(&self, output: usize) -> Result<Found> {
        let cycle = self.largest()?;
        Ok(Found {
            size: self.cycle_loop(cycle, output).largest_width(),
            place: Some(self.run(cycle.recording).place(samples_of(cycle))),
        })
    }

    /// The largest and the mean width of the mean loop.
    fn mean_loop(&self, output: usize) -> [Result<Found>; 2] {
        let axis = self.view.axis;
        let mean = self.largest().and_then(|_| {
            let loops = self.full_cycles.iter();
            let loops: Vec<Loop> = loops.map(|cycle| self.cycle_loop(cycle, output)).collect();
            Loop::mean(&loops).ok_or(Reason::Overflow { axis })
        });
        [Loop::largest_width, Loop::mean_width].map(|width| {
            mean.as_ref()
                .map(|mean| Found::everywhere(width(mean)))
                .map_err(Clone::clone)
        })
    }

    /// The rising branch of the largest cycle; without a cycle, the widest rising branch.
    fn rising(&self) -> Result<(usize, &Branch)> {
        match &self.largest {
            Ok(cycle) => Ok((cycle.recording, cycle.rising())),
            Err(no_cycle @ Reason::ConstantLoad { .. }) => Err(no_cycle.clone()),
            Err(_) => {
                let axis = self.view.axis;
                let widest = self.loops.widest_branch(true);
                widest.ok_or(Reason::NoRisingBranch { axis })
            }
        }
    }

    fn nonlinearity(&self, output: usize, line: fn(&Curve) -> Option<Line>) -> Result<Found> {
        let (recording, branch) = self.rising()?;
        let curve = self.curve(recording, branch, output);
        let line = self.enough(&curve, line)?;
        Ok(Found {
            size: line
                .largest_deviation(curve.averages().iter().chain(curve.ends().iter().flatten())),
            place: Some(self.run(recording).place(branch.samples.clone())),
        })
    }

    fn combined_error(&self, output: usize) -> Result<Found> {
        let cycle = self.largest()?;
        let on = |branch| self.curve(cycle.recording, branch, output);
        let (rising, falling) = (on(cycle.rising()), on(cycle.falling()));
        let line = self.enough(&rising, Line::through_ends)?;
        let common = cycle.low()..=cycle.high();
        let falling = falling
            .averages()
            .iter()
            .filter(|(load, _)| common.contains(load));
        Ok(Found {
            size: line.largest_deviation(rising.averages().iter().chain(falling)),
            place: Some(self.run(cycle.recording).place(samples_of(cycle))),
        })
    }

    /// A line through a curve that has loads enough for one.
    fn enough(&self, curve: &Curve, line: fn(&Curve) -> Option<Line>) -> Result<Line> {
        let found = curve.averages().len();
        let axis = self.view.axis;
        line(curve)
            .filter(|_| found >= FEWEST_AVERAGES)
            .ok_or(Reason::TooFewLoads { axis, found })
    }

    fn repeatability(&self, output: usize) -> Result<Found> {
        if let Err(reason @ Reason::ConstantLoad { .. }) = &self.largest {
            return Err(reason.clone());
        }
        let both_ways = [true, false].into_iter().flat_map(|rising| {
            let full: Vec<(usize, &Branch)> = self.loops.full_branches(rising).collect();
            let by_recording = full.chunk_by(|a, b| a.0 == b.0);
            by_recording
                .filter_map(|same| self.spread(same, output))
                .collect::<Vec<_>>()
        });
        let worst = both_ways.max_by(|a, b| a.size.total_cmp(&b.size));
        let axis = self.view.axis;
        worst.ok_or(Reason::TooFewCycles { axis })
    }

    /// The largest difference at equal load between branches of one recording; `None` for one branch alone, or without
    /// a load that all of them have.
    fn spread(&self, branches: &[(usize, &Branch)], output: usize) -> Option<Found> {
        let [(recording, first), .., (_, last)] = branches else {
            return None;
        };
        let low = branches
            .iter()
            .map(|(_, one)| one.low)
            .fold(f64::NEG_INFINITY, f64::max);
        let high = branches
            .iter()
            .map(|(_, one)| one.high)
            .fold(f64::INFINITY, f64::min);
        if low >= high {
            return None;
        }
        let curves: Vec<Curve> = branches
            .iter()
            .map(|(_, branch)| self.curve(*recording, branch, output))
            .collect();
        let size = even_loads(low, high)
            .map(|load| {
                let outputs = curves.iter().map(|curve| curve.at(load));
                let (least, greatest) = outputs.fold(
                    (f64::INFINITY, f64::NEG_INFINITY),
                    |(least, greatest), output| (least.min(output), greatest.max(output)),
                );
                greatest - least
            })
            .fold(0.0, f64::max);
        let samples = first.samples.start..last.samples.end;
        Some(Found {
            size,
            place: Some(self.run(*recording).place(samples)),
        })
    }
}

fn samples_of(cycle: &Cycle) -> std::ops::Range<usize> {
    cycle.first.samples.start..cycle.second.samples.end
}

/// A straight line through outputs over loads.
#[derive(Clone, Copy, Debug)]
struct Line {
    load: f64,
    output: f64,
    slope: f64,
}

impl Line {
    /// From the least load to the greatest.
    fn through_ends(curve: &Curve) -> Option<Self> {
        let [(x0, y0), (x1, y1)] = curve.ends()?;
        Some(Self {
            load: x0,
            output: y0,
            slope: (y1 - y0) / (x1 - x0),
        })
    }

    /// By least squares through the averages, each counting alike.
    fn best_fit(curve: &Curve) -> Option<Self> {
        let points = curve.averages();
        let n = points.len() as f64;
        let load = points.iter().map(|(x, _)| x).sum::<f64>() / n;
        let output = points.iter().map(|(_, y)| y).sum::<f64>() / n;
        let xx: f64 = points.iter().map(|(x, _)| (x - load).powi(2)).sum();
        let xy: f64 = points.iter().map(|(x, y)| (x - load) * (y - output)).sum();
        (xx > 0.0).then(|| Self {
            load,
            output,
            slope: xy / xx,
        })
    }

    fn largest_deviation<'b>(&self, points: impl Iterator<Item = &'b (f64, f64)>) -> f64 {
        points
            .map(|(x, y)| (y - self.output - self.slope * (x - self.load)).abs())
            .fold(0.0, f64::max)
    }
}
