//! What a calibration does after it is switched on: errors of its first samples, beside the conventional ones.
//!
//! Guarantees: each start is cold, at a sample of a recording; starts are compared by the one rule of choice.

use crate::calibration::{Calibration, ErrorBlocks, HARM};
use crate::finding::{Finding, Id, Verdict};
use crate::questions::dataset::Dataset;
use crate::questions::travels::{MOST_UNKNOWN, Travels};
use crate::recording::Role;
use crate::scoring::numbers::{percent, significant};

/// Approximate number of starts, spread over the recordings.
const STARTS: usize = 24;
/// Shortest time for which each start is followed (s): states of play depend on no time.
const SHORTEST_SECS: f64 = 5.0;
/// Number of intervals of the time after a start, each twice as long as the one before.
const INTERVALS: usize = 8;

/// Errors of all starts in one interval: of each start the samples, and the squared errors over full scale, summed up.
#[derive(Default)]
struct Interval {
    samples: Vec<f64>,
    conventional: Vec<f64>,
    compensated: Vec<f64>,
}

impl Interval {
    /// Begins the sums of a start.
    fn begin(&mut self) {
        self.samples.push(0.0);
        self.conventional.push(0.0);
        self.compensated.push(0.0);
    }

    /// Adds squared errors of a sample to the sums of the newest start.
    fn add(&mut self, squares: [f64; 2]) {
        let own = [&mut self.samples, &mut self.conventional, &mut self.compensated];
        for (sums, more) in own.into_iter().zip([1.0, squares[0], squares[1]]) {
            if let Some(newest) = sums.last_mut() {
                *newest += more;
            }
        }
    }

    /// Returns the root mean square of these sums over full scale.
    fn rms(&self, squares: &[f64]) -> f64 {
        (squares.iter().sum::<f64>() / self.samples.iter().sum::<f64>()).sqrt()
    }

    /// Whether the compensated error is beyond what a choice allows, with 90 % confidence.
    fn is_harmed(&self) -> bool {
        let blocks =
            ErrorBlocks { groups: vec![0; self.samples.len()], samples: self.samples.clone() };
        blocks.is_below(&self.conventional, &self.compensated, 1.0 / HARM)
    }
}

impl Dataset {
    /// Returns how long the calibration errs more than the conventional one after a cold start, if it does.
    pub(super) fn cold_start(&self, calibration: &Calibration) -> Option<Finding> {
        let features = &calibration.features;
        if !features.has_history() {
            return None;
        }
        let settling = features.settling_secs().max(features.window_secs()).max(SHORTEST_SECS);
        let has_test = self.entries.iter().any(|entry| entry.role == Role::Test);
        let role = if has_test { Role::Test } else { Role::Train };
        let shown = self.entries.iter().filter(|entry| entry.role == role);
        let shown: Vec<_> =
            shown.map(|entry| &entry.recording).filter(|own| own.has_reference()).collect();
        let mut intervals: Vec<Interval> = (0..INTERVALS).map(|_| Interval::default()).collect();
        let n_starts = STARTS.div_ceil(shown.len().max(1));
        for recording in shown {
            let n = recording.n_samples();
            for first in (0..n_starts).map(|at| at * n / n_starts) {
                let since = |k: usize| recording.times()[k] - recording.times()[first];
                let end = (first..n).find(|k| since(*k) > settling).unwrap_or(n);
                let segment = recording.segment(first..end);
                let applied = calibration.apply(&segment).ok()?;
                intervals.iter_mut().for_each(Interval::begin);
                let q = calibration.axes.len();
                for (k, loads) in segment.loads().chunks_exact(q).enumerate() {
                    let square = |of: &[f64]| -> f64 {
                        let errors = of[k * q..].iter().zip(loads).zip(&calibration.full_scale);
                        let scaled = errors.filter(|(_, scale)| **scale > 0.0);
                        scaled.map(|((own, load), scale)| ((own - load) / scale).powi(2)).sum()
                    };
                    let squares =
                        [&applied.conventional, &applied.compensated].map(|own| square(own));
                    let doublings =
                        (since(first + k) / settling).log2().floor().max(-(INTERVALS as f64));
                    let at =
                        (doublings as isize + INTERVALS as isize).clamp(0, INTERVALS as isize - 1);
                    intervals[at as usize].add(squares);
                }
            }
        }
        let harmed = intervals.iter().rposition(Interval::is_harmed)?;
        let secs = settling * 0.5_f64.powi((INTERVALS - 1 - harmed) as i32);
        let own = &intervals[harmed];
        let [before, after] =
            [&own.conventional, &own.compensated].map(|squares| percent(own.rms(squares)));
        let seen = format!(
            "for {} s after a cold start the compensated load errs more than the uncompensated one",
            significant(secs, 2)
        );
        let figures = format!("at the end of that time {after} of full scale against {before}");
        Some(Finding::new(Id::ColdStart, Verdict::Doubtful, seen).with(figures))
    }

    /// Returns the largest radius whose state is unknown in too many of the training samples, if there is one.
    pub(super) fn unknown_state(&self, calibration: &Calibration) -> Option<Finding> {
        let used = calibration.features.blocks.used();
        let travels =
            used.flat_map(|(block, values)| values.iter().map(move |value| (block, *value)));
        let moved: Vec<_> = travels.filter(|(block, value)| block.travel(*value) > 0.0).collect();
        let (block, value) = moved.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let unknown = Travels::of(self, &calibration.gauge_scale).unknown(block.travel(value));
        let (name, unit) = (block.name(), block.setting().unit.symbol);
        let seen = format!("the state of {name} {value} {unit} is unknown at first");
        let figures = format!("in {} of the samples of a group", percent(unknown));
        (unknown > MOST_UNKNOWN)
            .then(|| Finding::new(Id::UnknownState, Verdict::Doubtful, seen).with(figures))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::FitSettings;
    use crate::features::{Block, Blocks, Creep, FeatureSettings, Play};
    use crate::progress::Progress;
    use crate::questions::errors::query::analyse;
    use crate::questions::request::Request;
    use crate::random::Random;
    use crate::recording::{Axis, Entry, Recording, RecordingSet, Source};

    /// Findings of a fit with a block to a gauge that creeps by this share with a time constant of 10 s, in four recordings of 100 s
    /// that begin under load.
    fn of(creeps: f64, block: &'static dyn Block, value: f64) -> Vec<Finding> {
        let mut set = RecordingSet::default();
        for at in 0..4 {
            let mut random = Random::new(3, &[at]);
            let (mut gauges, mut loads, mut slow, mut load) = (Vec::new(), Vec::new(), 0.0, 0.0);
            for k in 0..1200 {
                // A new load every 15 s.
                if k % 150 == 0 {
                    load = 10.0 * random.normal();
                }
                slow += (load - slow) * 0.01;
                if k >= 200 {
                    loads.push(load);
                    gauges.push(load + creeps * slow + 0.02 * random.normal());
                }
            }
            let recording = Recording::new(
                format!("r{at}"),
                Source::Simulated,
                (0..1000).map(|k| 0.1 * f64::from(k)).collect(),
                vec!["S1".to_owned()],
                gauges,
                vec![Axis::Fz],
                loads,
            );
            let role = if at == 3 { Role::Test } else { Role::Train };
            set.push(Entry::new(recording.unwrap(), role)).unwrap();
        }
        let features = FeatureSettings {
            blocks: Blocks::default().with(block, &[value]),
            ..FeatureSettings::present()
        };
        let settings = FitSettings { features, ..FitSettings::default() };
        let request = Request::fit(Arc::new(set), settings);
        analyse(&request, &Progress::default()).unwrap().findings
    }

    /// While the state of creep is not known, half of the load that the gauge shows is missing.
    #[test]
    fn a_cold_start_that_is_worse_than_conventional_is_found() {
        let found = of(1.0, &Creep, 10.0);
        assert!(found.iter().any(|own| own.id == Id::ColdStart), "{found:?}");
        let found = of(0.0, &Creep, 10.0);
        assert!(!found.iter().any(|own| own.id == Id::ColdStart), "{found:?}");
    }

    #[test]
    fn a_radius_whose_state_stays_unknown_is_found() {
        let has = |radius| of(0.0, &Play, radius).iter().any(|own| own.id == Id::UnknownState);
        assert!(has(5.0) && !has(0.05));
    }
}
