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
            fits::Fit,
            steps::{Row, Steps, step_at},
        },
    },
    shown::joined,
};

/// Width of a cell of the load (full scale), and the distance from its centre, in widths, at which a load leaves it.
const CELL: f64 = 0.1;
const LEAVES: f64 = 0.75;
/// Radii of the play operators (full scale).
const RADII: [f64; 3] = [0.1, 0.3, 0.8];
/// Time constants of creep, as shares of the duration.
const TIME_CONSTANTS: [f64; 5] = [0.01, 0.03, 0.1, 0.3, 1.0];
/// Number of intervals of a recording. All visits to one cell that begin in the same interval count as one.
const INTERVALS: f64 = 256.0;
/// Maximum number of cells. Further cells are not compared.
const MOST_CELLS: usize = 512;
/// Number of samples between two looks at the progress.
const LOOK: usize = 1 << 14;
/// Maximum error of the load that the gauges show (full scale).
const MEASURED: f64 = 0.5;
/// Minimum degrees of freedom.
const FEWEST: usize = 10;
/// Minimum share of the squared differences between visits that the change explains, and its minimum F statistic.
const EXPLAINED: f64 = 0.8;
const CERTAIN: f64 = 100.0;
/// Minimum ratio of the squares that other causes leave to the squares that the change leaves.
const CLEARER: f64 = 1.5;
/// Share of the visits at each end of a recording in which no jump is searched. Hysteresis builds up in the first ones.
const EDGE: f64 = 0.1;
/// Maximum mean square that a reported change alone would give, as a multiple of the mean square error.
const MOST_CHANGE: f64 = 1.5;
/// Smallest change that is reported (full scale).
const SMALLEST: f64 = 0.002;

/// Change of the zero of a load.
struct Change {
    axis: usize,
    /// Change of the load that the gauges show (full scale).
    amount: f64,
    /// Time of a jump (s); `None` for a drift.
    jumped_at: Option<f64>,
    /// F statistic of the change.
    certainty: f64,
    /// RMS error of the load with and without the change (full scale).
    errors: [f64; 2],
}

impl Rig {
    /// Returns findings of zeros that drift or jump within one of these recordings.
    pub fn changes_within(
        &self,
        recordings: &[&Recording],
        progress: &Progress,
    ) -> Result<Vec<Finding>, Cancelled> {
        let fit = Fit::with_drift(&self.total(|_| true), &self.shape);
        let inverse = fit.inverse(&self.shape);
        let mut found = Vec::new();
        for own in recordings.iter().filter(|own| !own.is_static()) {
            let visits = self.visits(own, &inverse, progress)?;
            let changes = (0..self.shape.axes.len()).filter_map(|axis| {
                change(&visits, axis, self.shape.axes.len(), own.duration_secs())
            });
            let mut changes: Vec<Change> = changes.collect();
            changes.sort_by(|a, b| b.certainty.total_cmp(&a.certainty));
            if let Some(first) = changes.first() {
                let is_jump = first.jumped_at.is_some();
                changes.retain(|own| own.jumped_at.is_some() == is_jump);
                found.push(self.changed(own, &changes));
            }
        }
        Ok(found)
    }

    /// Returns the visits to cells that the load of a recording visits several times, in order of time. The group of a visit
    /// is its cell; its values are errors, plays and creep.
    fn visits(
        &self,
        of: &Recording,
        inverse: &Mat<f64>,
        progress: &Progress,
    ) -> Result<Vec<Row>, Cancelled> {
        let (axes, times, duration) = (self.shape.axes_in(of), of.times(), of.duration_secs());
        let n_axes = axes.len();
        let mut cells: HashMap<(Vec<i32>, i32), usize> = HashMap::new();
        let mut places: HashMap<(usize, usize), usize> = HashMap::new();
        let mut visits: Vec<Row> = Vec::new();
        let mut current = None;
        let mut centre = vec![f64::INFINITY; n_axes];
        let mut plays = vec![[0.0_f64; RADII.len()]; n_axes];
        let mut creep = vec![[0.0; TIME_CONSTANTS.len()]; n_axes];
        let (mut loads, mut gauges) = (vec![0.0; n_axes], Vec::new());
        for k in 0..of.n_samples() {
            if k % LOOK == 0 {
                progress.check()?;
            }
            let passed = if k == 0 { f64::INFINITY } else { times[k] - times[k - 1] };
            let decays = TIME_CONSTANTS.map(|share| (-passed / (share * duration)).exp());
            for (axis, load) in loads.iter_mut().enumerate() {
                let recorded = of.loads()[k * of.axes().len() + axes[axis]];
                *load = recorded / self.shape.full_scale[axis];
                for (play, radius) in plays[axis].iter_mut().zip(RADII) {
                    *play = play.clamp(*load - radius, *load + radius);
                }
                for (state, decay) in creep[axis].iter_mut().zip(decays) {
                    *state = *load + decay * (*state - *load);
                }
            }
            let away = |axis: &usize| loads[*axis] / CELL - centre[*axis];
            let farthest = (0..n_axes).max_by(|a, b| away(a).abs().total_cmp(&away(b).abs()));
            if let Some(axis) = farthest.filter(|axis| away(axis).abs() > LEAVES) {
                let side = (axis as i32 + 1) * if away(&axis) > 0.0 { 1 } else { -1 };
                centre = loads.iter().map(|load| (load / CELL).round()).collect();
                let key = (centre.iter().map(|own| *own as i32).collect(), side);
                let next = cells.len();
                let cell = if next < MOST_CELLS {
                    Some(*cells.entry(key).or_insert(next))
                } else {
                    cells.get(&key).copied()
                };
                let interval = ((times[k] - times[0]) / duration * INTERVALS) as usize;
                current = cell.map(|cell| {
                    *places.entry((cell, interval)).or_insert_with(|| {
                        let n_values = n_axes * (1 + RADII.len() + TIME_CONSTANTS.len());
                        visits.push(Row::new(cell, n_values));
                        visits.len() - 1
                    })
                });
            }
            let Some(visit) = current.map(|at: usize| &mut visits[at]) else { continue };
            gauges.clear();
            gauges.extend(self.standard(of.gauges_at(k)));
            let error = |axis: usize| {
                let shown = gauges.iter().enumerate().map(|(at, own)| inverse[(axis, at)] * own);
                shown.sum::<f64>() - loads[axis]
            };
            let history = plays.as_flattened().iter().chain(creep.as_flattened()).copied();
            visit.add(times[k], (0..n_axes).map(error).chain(history));
        }
        let mut counts = vec![0; cells.len()];
        visits.iter().for_each(|visit| counts[visit.group] += 1);
        visits.retain(|visit| counts[visit.group] > 1);
        visits.sort_by(|a, b| a.time.total_cmp(&b.time));
        Ok(visits)
    }

    fn changed(&self, of: &Recording, changes: &[Change]) -> Finding {
        let duration = of.duration_secs();
        let change = |own: &Change| own.amount * self.shape.full_scale[own.axis];
        let text = |own: &Change| {
            let axis = self.shape.axes[own.axis];
            format!(
                "the zero of {} {} by {} {} ({} of full scale)",
                axis.symbol(),
                if own.amount > 0.0 { "rises" } else { "falls" },
                significant(change(own).abs(), 3),
                axis.unit(),
                percent(own.amount.abs())
            )
        };
        let fact = |own: &Change| {
            json!({
                "recording": of.name(),
                "axis": self.shape.axes[own.axis].symbol(),
                "unit": self.shape.axes[own.axis].unit(),
                "change": change(own),
                "percent_of_full_scale": 100.0 * own.amount,
                "at_secs": own.jumped_at,
                "during_secs": own.jumped_at.is_none().then_some(duration),
            })
        };
        let (id, place) = match changes[0].jumped_at {
            Some(secs) => (Id::ZeroJumped, format!("at once at {} s", significant(secs, 4))),
            None => {
                let (time, unit) =
                    if duration < 120.0 { (duration, "s") } else { (duration / 60.0, "min") };
                (Id::DriftWithin, format!("steadily in {} {unit}", significant(time, 2)))
            }
        };
        let [with, without] = changes[0].errors;
        let texts = joined(", and ", changes.iter().map(text));
        let found =
            Finding::new(id, Verdict::Doubtful, format!("in {}, {place}, {texts}", of.name()));
        found.costing(with - without).facts(changes.iter().map(fact).collect())
    }
}

/// Returns the change of the zero of an axis, if the visits show one.
fn change(visits: &[Row], axis: usize, n_axes: usize, duration: f64) -> Option<Change> {
    let n = visits.len();
    let column = |at: usize| -> Vec<f64> { visits.iter().map(|own| own.values[at]).collect() };
    let errors = column(axis);
    let mean = errors.iter().sum::<f64>() / n as f64;
    let square = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / n as f64;
    let times: Vec<f64> = visits.iter().map(|own| own.time).collect();
    let mut known = Steps::new(visits.iter().map(|own| own.group).collect(), &[errors]);
    let first_creep = (1 + RADII.len()) * n_axes;
    for at in n_axes..first_creep {
        known.explain(&column(at));
    }
    let freedom = known.freedom();
    if freedom <= FEWEST || square.sqrt() > MEASURED {
        return None;
    }
    let all = known.squares()[0];
    let first_creep = first_creep + axis * TIME_CONSTANTS.len();
    let creep = (first_creep..first_creep + TIME_CONSTANTS.len())
        .map(|at| all - known.gain(&column(at)))
        .fold(all, f64::min);
    let drift = all - known.gain(&times);
    let (mut row, mut jump) = (0, all);
    known.steps(0.5, |at, gains| {
        if all - gains[0] < jump {
            (row, jump) = (at, all - gains[0]);
        }
    });
    let certainty = |left: f64| (all - left) / left * (freedom - 1) as f64;
    let explains = |left: f64| {
        all - left > EXPLAINED * all && certainty(left) > CERTAIN && creep > CLEARER * left
    };
    let share = row as f64 / n as f64;
    let is_inside = (EDGE..1.0 - EDGE).contains(&share);
    let (amount, jumped_at, left, part) = if jump > drift && explains(drift) {
        (known.size(&times)? * duration, None, drift, 1.0 / 12.0)
    } else if is_inside && drift > CLEARER * jump && explains(jump) {
        let secs = 0.5 * (times[row - 1] + times[row]);
        (known.size(&step_at(row, n))?, Some(secs), jump, share * (1.0 - share))
    } else {
        return None;
    };
    // A change that is found in a small part of the recording must not exceed the errors of the whole.
    if part * amount * amount > MOST_CHANGE * square {
        return None;
    }
    let without = (square - part * amount * amount).max(0.0).sqrt();
    let (certainty, errors) = (certainty(left), [square.sqrt(), without]);
    // Among many recordings, hysteresis alone resembles a small change in one of them.
    let is_reported = amount.abs() > SMALLEST && matters(errors[0], errors[1]);
    is_reported.then_some(Change { axis, amount, jumped_at, certainty, errors })
}
