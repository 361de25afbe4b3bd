//! Simulated recordings with a time lag, with hysteresis, or with both. They show whether a figure distinguishes lag from
//! hysteresis. One force acts on two gauges. The lag is the first-order low-pass of an amplifier. The hysteresis is play,
//! which does not depend on the load's rate. The load is a sine whose frequency varies between 0.1 Hz and 1 Hz.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};
use strum::{Display, VariantArray};

use crate::{
    random::Random,
    recording::{
        axis::Axis,
        recording::{Recording, Source},
        set::{Entry, RecordingSet, Role},
    },
};

/// Simulated fault of the gauges: a time lag, hysteresis, or both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Display, VariantArray)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum Late {
    /// Time lag of a low-pass with a time constant of 30 ms, without hysteresis.
    Lag,
    /// Hysteresis of a play operator with a radius of a twentieth of full scale, without time lag.
    Hysteresis,
    /// Both the time lag and the hysteresis.
    Both,
}

pub const LAG_SECS: f64 = 0.03;
/// Radius (N) of the play operator that simulates the hysteresis.
pub const PLAY_NEWTONS: f64 = 0.5;
const LARGEST_NEWTONS: f64 = 10.0;
const RATE_HZ: f64 = 100.0;
const DURATION_SECS: f64 = 60.0;
/// Number of simulation steps in one sample interval.
const FINER: usize = 20;
/// Lowest and highest frequency between which the load varies (Hz).
const CYCLES_HZ: (f64, f64) = (0.1, 1.0);
/// Gain (mV/V per N) and offset (mV/V) of each gauge.
const GAUGES: [(f64, f64); 2] = [(0.08, 0.11), (-0.06, -0.05)];
/// Standard deviation of the gauge noise (mV/V).
const NOISE: f64 = 0.0004;
const KEY: u64 = 3700;

impl Late {
    /// Returns the fault that these recordings simulate. `None` if they are not recordings of this module.
    pub fn of(set: &RecordingSet) -> Option<Self> {
        let first = set.is_simulated().then(|| set.entries().first()).flatten()?;
        Self::VARIANTS.iter().copied().find(|late| late.recording_name(1) == first.recording.name())
    }

    fn recording_name(self, run: u64) -> String {
        format!("{self}_{run}")
    }
}

/// Returns the recordings of [`late()`] with their roles: two for training, one for test.
pub fn late_set(seed: u64, late: Late) -> RecordingSet {
    let roles = [Role::Train, Role::Train, Role::Test];
    let recordings = self::late(seed, late).into_iter().zip(roles);
    let entries = recordings.map(|(recording, role)| Entry::new(recording, role)).collect();
    super::with(RecordingSet::default(), entries)
}

/// Returns three simulated recordings of one force with this fault.
pub fn late(seed: u64, late: Late) -> Vec<Recording> {
    (1..=3).map(|run| recording(seed, late, run)).collect()
}

fn recording(seed: u64, late: Late, run: u64) -> Recording {
    let mut random = Random::new(seed, &[KEY, run]);
    let step = 1.0 / (RATE_HZ * FINER as f64);
    let tau = if late == Late::Hysteresis { 0.0 } else { LAG_SECS };
    let radius = if late == Late::Lag { 0.0 } else { PLAY_NEWTONS };
    let wobble = random.between(0.0, TAU);
    let (mut phase, mut played, mut passed) = (random.between(0.0, TAU), 0.0_f64, None);
    let (mut times, mut gauges, mut loads) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..(DURATION_SECS * RATE_HZ) as usize * FINER {
        let time = k as f64 * step;
        // The logarithm of the load's frequency varies as a sine.
        let share = 0.5 + 0.5 * (TAU * time / 25.0 + wobble).sin();
        phase += TAU * step * CYCLES_HZ.0 * (CYCLES_HZ.1 / CYCLES_HZ.0).powf(share);
        let load = LARGEST_NEWTONS * phase.sin();
        played = played.clamp(load - radius, load + radius);
        let before = passed.unwrap_or(played);
        let now =
            if tau > 0.0 { before + (played - before) * -(-step / tau).exp_m1() } else { played };
        passed = Some(now);
        if k % FINER == 0 {
            times.push(k as f64 * step);
            loads.push(load);
            gauges
                .extend(GAUGES.map(|(gain, offset)| offset + gain * now + NOISE * random.normal()));
        }
    }
    let names = vec!["S1".to_owned(), "S2".to_owned()];
    Recording::new(
        late.recording_name(run),
        Source::Simulated,
        times,
        names,
        gauges,
        vec![Axis::Fz],
        loads,
    )
    .expect("simulated values form a valid recording")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::scoring::lag::{LagRun, lags, widths};

    /// The lag is found within 3 %, and the hysteresis without it within 10 % of 2 r, or within 0.3 % of full scale.
    #[test]
    fn lag_and_hysteresis_are_distinguished() {
        for (late, tau, width) in [
            (Late::Lag, LAG_SECS, 0.0),
            (Late::Hysteresis, 0.0, 2.0 * PLAY_NEWTONS),
            (Late::Both, LAG_SECS, 2.0 * PLAY_NEWTONS),
        ] {
            let recordings = super::late(7, late);
            // The force computed from the first gauge alone.
            let outputs: Vec<Vec<f64>> = (recordings.iter())
                .map(|recording| {
                    recording.gauges().iter().step_by(2).map(|gauge| gauge / GAUGES[0].0).collect()
                })
                .collect();
            let runs: Vec<LagRun<'_>> = (recordings.iter().zip(&outputs))
                .map(|(recording, outputs)| LagRun {
                    times: recording.times(),
                    gauges: recording.gauges(),
                    loads: recording.loads(),
                    outputs,
                })
                .collect();
            let lag = lags(&runs, &Progress::default()).unwrap().swap_remove(0).unwrap();
            assert!((lag.seconds - tau).abs() < 0.001, "{late:?}: {lag:?}");
            let found = widths(&lag, 0, &runs, 1.0).unwrap().mean[1];
            assert!((found - width).abs() < (0.1 * width).max(0.03), "{late:?}: {found}");
        }
    }
}
