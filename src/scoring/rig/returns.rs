//! Finds a zero that drifts or jumps within one recording, from repeated returns to the same load.
//!
//! A visit is an interval in which the load stays in one cell. Visits to one cell from the same side are compared. Play
//! operators of the loads explain their differences first, because a load that comes from elsewhere leaves hysteresis. A drift
//! must then explain more than creep does, and a jump more than a drift and creep.
//!
//! Guarantees: one pass over the samples, cancellable, with memory for a limited number of visits.

use std::collections::HashMap;

use faer::Mat;
use serde_json::json;

use crate::{
    finding::{Finding, Id, Verdict},
    progress::{Cancelled, Progress},
    recording::Recording,
    scoring::{
        numbers::{percent, significant},
        rig::{
            Rig,
            cause::matters,
            fits::Forward,
            steps::{Steps, step_at},
        },
    },
};

/// Width of a cell of the load (full scale), and the distance from its centre, in widths, at which a load leaves it.
const CELL: f64 = 0.1;
const LEAVES: f64 = 0.75;
/// Radii of the play operators (full scale).
const RADII: [f64; 3] = [0.1, 0.3, 0.8];
/// Time constants of creep, as shares of the duration.
const TIME_CONSTANTS: [f64; 5] = [0.01, 0.03, 0.1, 0.3, 1.0];
/// Number of intervals of a recording. All visits to one cell in the same interval count as one.
const INTERVALS: f64 = 256.0;
/// Maximum number of visits and of cells that are kept.
const MOST_VISITS: usize = 1 << 15;
const MOST_CELLS: usize = 1 << 17;
/// Number of samples between two looks at the progress.
const LOOK: usize = 1 << 14;
/// Minimum standard deviation of a load that moves, and maximum deviation of the load that the gauges show (full scale).
const MOVES: f64 = 0.02;
const MEASURED: f64 = 0.5;
/// Minimum degrees of freedom.
const FEWEST: usize = 4;
/// Minimum share of the squared differences between visits that the change explains, and its minimum F statistic.
const EXPLAINED: f64 = 0.8;
const CERTAIN: f64 = 100.0;
/// Minimum ratio of the squares that other causes leave to the squares that the change leaves.
const CLEARER: f64 = 1.5;
/// Share of the visits at each end of a recording in which no jump is searched. Hysteresis builds up in the first ones.
const EDGE: f64 = 0.1;
/// Smallest change that is reported (full scale).
const SMALLEST: f64 = 0.002;

/// Sums over the samples of a visit: their number, their times, and their values in the order errors, loads, plays, creep.
#[derive(Clone)]
struct Visit {
    cell: usize,
    n: f64,
    time: f64,
    values: Vec<f64>,
}

/// Change of the zero of a load.
#[derive(Clone, Copy, Debug)]
struct Change {
    axis: usize,
    /// Change of the load without load (full scale).
    amount: f64,
    /// Time of a jump (s); `None` for a drift.
    jumped_at: Option<f64>,
    /// F statistic of the change.
    certainty: f64,
    /// Mean square error of the load, and the part of it that the change causes (full scale).
    square: f64,
    part: f64,
}

impl Rig {
    /// Returns findings of zeros that drift or jump within one of these recordings.
    pub(super) fn changes_within(
        &self,
        recordings: &[&Recording],
        progress: &Progress,
    ) -> Result<Vec<Finding>, Cancelled> {
        let fit = Forward::with_drift(&self.total(|_| true), &self.shape);
        let inverse = fit.inverse(&self.shape);
        let mut found = Vec::new();
        for own in recordings.iter().filter(|own| !own.is_static()) {
            let visits = self.visits(own, &inverse, progress)?;
            let n_axes = self.shape.axes.len();
            let changes = (0..n_axes).filter_map(|axis| change(&visits, axis, n_axes, own));
            let mut changes: Vec<Change> = changes.collect();
            changes.sort_by(|a, b| b.certainty.total_cmp(&a.certainty));
            if let Some(first) = changes.first().copied() {
                changes.retain(|own| own.jumped_at.is_some() == first.jumped_at.is_some());
                found.push(self.changed(own, &changes));
            }
        }
        Ok(found)
    }

    /// Returns the visits of a recording that return to a load, in order of time.
    fn visits(
        &self,
        of: &Recording,
        inverse: &Mat<f64>,
        progress: &Progress,
    ) -> Result<Vec<Visit>, Cancelled> {
        let (axes, times) = (self.shape.axes_in(of), of.times());
        let n_axes = axes.len();
        let duration = of.duration_secs();
        let start = times[0];
        let mut cells: HashMap<(Vec<i32>, i32), usize> = HashMap::new();
        let mut visits: HashMap<(usize, usize), Visit> = HashMap::new();
        // Only cells whose number is a multiple of this are kept.
        let mut kept = 1;
        let mut place: Vec<f64> = Vec::new();
        let mut plays = vec![0.0_f64; RADII.len() * n_axes];
        let mut creep = vec![0.0_f64; TIME_CONSTANTS.len() * n_axes];
        let (mut passed, mut decays) = (0.0, [1.0; TIME_CONSTANTS.len()]);
        let width = 2 * n_axes + plays.len() + creep.len();
        let none = Visit { cell: 0, n: 0.0, time: 0.0, values: vec![0.0; width] };
        let mut visit: Option<Visit> = None;
        let mut loads = vec![0.0; n_axes];
        let mut gauges = vec![0.0; self.shape.n_gauges];
        for k in 0..of.n_samples() {
            if k % LOOK == 0 {
                progress.check()?;
            }
            let row = &of.loads()[k * of.axes().len()..];
            let scaled = axes.iter().zip(&self.shape.full_scale);
            loads.iter_mut().zip(scaled).for_each(|(load, (axis, full))| *load = row[*axis] / full);
            if k == 0 {
                creep = loads.iter().flat_map(|load| [*load; TIME_CONSTANTS.len()]).collect();
            } else if times[k] - times[k - 1] != passed {
                passed = times[k] - times[k - 1];
                decays = TIME_CONSTANTS.map(|share| (-passed / (share * duration)).exp());
            }
            for (axis, load) in loads.iter().enumerate() {
                for (play, radius) in plays[RADII.len() * axis..].iter_mut().zip(RADII) {
                    *play = play.clamp(load - radius, load + radius);
                }
                for (state, decay) in creep[decays.len() * axis..].iter_mut().zip(decays) {
                    *state = load + decay * (*state - load);
                }
            }
            let away =
                |axis: usize| place.get(axis).map_or(1.0, |place| loads[axis] / CELL - place);
            let farthest = (0..n_axes).max_by(|a, b| away(*a).abs().total_cmp(&away(*b).abs()));
            let Some(farthest) = farthest.filter(|axis| away(*axis).abs() > LEAVES || k == 0)
            else {
                if let Some(visit) = &mut visit {
                    self.add(
                        visit,
                        (times[k], of.gauges_at(k)),
                        inverse,
                        &mut gauges,
                        [&loads, &plays, &creep],
                    );
                }
                continue;
            };
            let way = (farthest as i32 + 1) * if away(farthest) > 0.0 { 1 } else { -1 };
            place = loads.iter().map(|load| (load / CELL).round()).collect();
            let key = (place.iter().map(|own| *own as i32).collect(), if k == 0 { 0 } else { way });
            if let Some(visit) = visit.take() {
                store(&mut visits, visit, start, duration);
            }
            while visits.len() > MOST_VISITS {
                kept *= 2;
                visits.retain(|(cell, _), _| cell % kept == 0);
            }
            let next = cells.len();
            let cell = match cells.get(&key) {
                Some(cell) => Some(*cell),
                None => (next < MOST_CELLS).then(|| *cells.entry(key).or_insert(next)),
            };
            visit = cell.filter(|cell| cell % kept == 0).map(|cell| Visit { cell, ..none.clone() });
            if let Some(visit) = &mut visit {
                self.add(
                    visit,
                    (times[k], of.gauges_at(k)),
                    inverse,
                    &mut gauges,
                    [&loads, &plays, &creep],
                );
            }
        }
        if let Some(visit) = visit {
            store(&mut visits, visit, start, duration);
        }
        let mut counts = vec![0; cells.len()];
        visits.keys().for_each(|(cell, _)| counts[*cell] += 1);
        let mut visits: Vec<Visit> =
            visits.into_values().filter(|visit| counts[visit.cell] > 1).collect();
        for visit in &mut visits {
            visit.time /= visit.n;
            visit.values.iter_mut().for_each(|sum| *sum /= visit.n);
        }
        visits.sort_by(|a, b| a.time.total_cmp(&b.time));
        Ok(visits)
    }

    fn add(
        &self,
        visit: &mut Visit,
        (time, row): (f64, &[f64]),
        inverse: &Mat<f64>,
        gauges: &mut [f64],
        values: [&[f64]; 3],
    ) {
        gauges.iter_mut().zip(self.standard(row)).for_each(|(own, value)| *own = value);
        let n_axes = inverse.nrows();
        visit.n += 1.0;
        visit.time += time;
        for (axis, (sum, load)) in visit.values.iter_mut().zip(values[0]).enumerate() {
            let shown = gauges.iter().enumerate().map(|(at, own)| inverse[(axis, at)] * own);
            *sum += shown.sum::<f64>() - load;
        }
        let values = values.into_iter().flatten();
        visit.values[n_axes..].iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
    }

    fn changed(&self, of: &Recording, changes: &[Change]) -> Finding {
        let duration = of.duration_secs();
        let seen = changes.iter().map(|own| {
            let (axis, full_scale) = (self.shape.axes[own.axis], self.shape.full_scale[own.axis]);
            let way = if own.amount > 0.0 { "rises" } else { "falls" };
            let amount = significant((own.amount * full_scale).abs(), 3);
            let place = match own.jumped_at {
                Some(secs) => format!("at once at {} s", significant(secs, 4)),
                None => format!("steadily in {}", in_words(duration)),
            };
            format!(
                "the zero of {} {way} by {amount} {} {place} ({} of full scale)",
                axis.symbol(),
                axis.unit(),
                percent(own.amount.abs())
            )
        });
        let facts = changes.iter().map(|own| {
            let axis = self.shape.axes[own.axis];
            json!({
                "recording": of.name(),
                "axis": axis.symbol(),
                "unit": axis.unit(),
                "change": own.amount * self.shape.full_scale[own.axis],
                "percent_of_full_scale": 100.0 * own.amount,
                "at_secs": own.jumped_at,
                "during_secs": own.jumped_at.is_none().then_some(duration),
            })
        });
        let seen: Vec<String> = seen.collect();
        let sum = |value: fn(&Change) -> f64| changes.iter().map(value).sum::<f64>();
        let [with, square] = [sum(|own| own.square), sum(|own| own.square - own.part)];
        let [with, without] =
            [with, square.max(0.0)].map(|own| (own / changes.len() as f64).sqrt());
        let id = if changes[0].jumped_at.is_some() { Id::ZeroJumped } else { Id::DriftWithin };
        let severity = if matters(with, without) { Verdict::Doubtful } else { Verdict::Enough };
        Finding::new(id, severity, format!("in {}, {}", of.name(), seen.join(", and ")))
            .costing(with - without)
            .facts(facts.collect())
    }
}

fn store(visits: &mut HashMap<(usize, usize), Visit>, own: Visit, start: f64, duration: f64) {
    let interval = (own.time / own.n - start) / duration.max(f64::MIN_POSITIVE) * INTERVALS;
    let Some(known) = visits.get_mut(&(own.cell, interval as usize)) else {
        visits.insert((own.cell, interval as usize), own);
        return;
    };
    known.n += own.n;
    known.time += own.time;
    known.values.iter_mut().zip(own.values).for_each(|(sum, value)| *sum += value);
}

/// Returns the change of the zero of an axis, if the visits show one.
fn change(visits: &[Visit], axis: usize, n_axes: usize, of: &Recording) -> Option<Change> {
    let n = visits.len();
    let column = |at: usize| -> Vec<f64> { visits.iter().map(|own| own.values[at]).collect() };
    let errors = column(axis);
    let square = variance(&errors);
    if variance(&column(n_axes + axis)).sqrt() < MOVES || square.sqrt() > MEASURED {
        return None;
    }
    let times: Vec<f64> = visits.iter().map(|own| own.time).collect();
    let mut known =
        Steps::new(visits.iter().map(|own| own.cell).collect(), std::slice::from_ref(&errors));
    let first = 2 * n_axes;
    let first_creep = first + RADII.len() * n_axes;
    (first..first_creep).for_each(|at| {
        known.explain(&column(at));
    });
    let freedom = known.freedom().checked_sub(1 + FEWEST)? + FEWEST;
    let all = known.squares()[0];
    let creep = TIME_CONSTANTS.len() * axis..TIME_CONSTANTS.len() * (axis + 1);
    let creep = creep.map(|at| all - known.gain(&column(first_creep + at)));
    let creep = creep.fold(all, f64::min);
    let drift = all - known.gain(&times);
    let (mut row, mut jump) = (0, all);
    known.steps(0.5, |at, gains| {
        if all - gains[0] < jump {
            (row, jump) = (at, all - gains[0]);
        }
    });
    let certainty = |left: f64| (all - left) / left * freedom as f64;
    let explains = |left: f64| {
        all - left > EXPLAINED * all && certainty(left) > CERTAIN && creep > CLEARER * left
    };
    let edge = EDGE * n as f64;
    let is_inside = (edge..n as f64 - edge).contains(&(row as f64));
    let (amount, jumped_at, left, part) = if jump > drift && explains(drift) {
        let amount = known.size(&times)? * of.duration_secs();
        (amount, None, drift, amount * amount / 12.0)
    } else if is_inside && drift > CLEARER * jump && explains(jump) {
        let amount = known.size(&step_at(row, n))?;
        let share = row as f64 / n as f64;
        let part = amount * amount * share * (1.0 - share);
        (amount, Some(0.5 * (times[row - 1] + times[row])), jump, part)
    } else {
        return None;
    };
    let certainty = certainty(left);
    let found = Change { axis, amount, jumped_at, certainty, square, part };
    (amount.abs() > SMALLEST).then_some(found)
}

fn variance(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n
}

fn in_words(secs: f64) -> String {
    match secs {
        0.0..120.0 => format!("{} s", significant(secs, 2)),
        120.0..7200.0 => format!("{} min", significant(secs / 60.0, 2)),
        _ => format!("{} h", significant(secs / 3600.0, 2)),
    }
}
