//! One force on two gauges, with a time lag, with hysteresis, or with both: what tells one from the other.
//!
//! The lag is that of an amplifier with a first-order low-pass. The hysteresis is play, the same at every rate of the load. The
//! load is a sine whose rate changes from a tenth of a cycle to a cycle per second.

use std::f64::consts::TAU;

use crate::random::Random;
use crate::recording::axis::Axis;
use crate::recording::recording::{Recording, Source};

/// What the gauges have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Late {
    /// A low-pass of 30 ms, and no hysteresis.
    Lag,
    /// Play of a twentieth of full scale, and no lag.
    Hysteresis,
    /// Both.
    Both,
}

/// Time constant of the low-pass (s).
pub const LAG_SECS: f64 = 0.03;
/// Radius of the play (N).
pub const PLAY_NEWTONS: f64 = 0.5;
/// Full scale (N).
const LARGEST_NEWTONS: f64 = 10.0;
const RATE_HZ: f64 = 100.0;
const DURATION_SECS: f64 = 60.0;
/// Steps of the simulation between two samples.
const FINER: usize = 20;
/// Cycles per second, slowest and fastest.
const CYCLES_HZ: (f64, f64) = (0.1, 1.0);
/// Gain and offset of the gauges (mV/V per N, mV/V), and their noise (mV/V).
const GAUGES: [(f64, f64); 2] = [(0.08, 0.11), (-0.06, -0.05)];
const NOISE: f64 = 0.0004;
const KEY: u64 = 3700;

/// Three recordings of one force.
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
        // Slow and fast by turns, evenly in the logarithm of the rate.
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
    let kind = match late {
        Late::Lag => "lag",
        Late::Hysteresis => "hysteresis",
        Late::Both => "both",
    };
    let names = vec!["S1".to_owned(), "S2".to_owned()];
    Recording::new(
        format!("{kind}_{run}"),
        Source::Simulated,
        times,
        names,
        gauges,
        vec![Axis::Fz],
        loads,
    )
    .expect("simulated numbers make a recording")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::scoring::lag::{LagRun, lags, widths};

    /// Lag and hysteresis are told apart: the lag within 3 %, the hysteresis without it within a tenth of 2 r or 0.3 % of full
    /// scale.
    #[test]
    fn lag_and_hysteresis_are_told_apart() {
        for (late, tau, width) in [
            (Late::Lag, LAG_SECS, 0.0),
            (Late::Hysteresis, 0.0, 2.0 * PLAY_NEWTONS),
            (Late::Both, LAG_SECS, 2.0 * PLAY_NEWTONS),
        ] {
            let recordings = super::late(7, late);
            // The force by the first gauge alone.
            let outputs: Vec<Vec<f64>> = (recordings.iter())
                .map(|own| {
                    own.gauges().iter().step_by(2).map(|gauge| gauge / GAUGES[0].0).collect()
                })
                .collect();
            let runs: Vec<LagRun<'_>> = (recordings.iter().zip(&outputs))
                .map(|(own, outputs)| LagRun {
                    times: own.times(),
                    gauges: own.gauges(),
                    loads: own.loads(),
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
