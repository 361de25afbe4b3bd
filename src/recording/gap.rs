//! Gaps: pauses between two samples of a recording that are so long that the samples before them (the history) are not used
//! any more.
//!
//! When a file is read, a gap ends a recording. When a calibration runs on a robot, a gap means that samples are missing. All
//! rules for the minimum length of a gap are in this file. Each calibration stores the minimum length that it uses.

use super::median::median;

/// Minimum length of a pause, in median time steps. A shorter interruption counts as a few lost samples.
const PAUSE_IN_STEPS: f64 = 20.0;
/// Minimum length of a gap (s) at any sample rate. A shorter interruption may be a single time stamp that a computer wrote
/// late, and a load cannot be removed and restored in so short a time.
const SHORTEST_GAP_SECS: f64 = 0.2;
const UNKNOWN_GAP_SECS: f64 = 1.0;

/// Time step (s) from which the clock of a file counts as faulty.
pub const LEAP_SECS: f64 = 86_400.0;
/// Periods (s) after which a 32-bit counter of microseconds or of milliseconds overflows and starts again from zero.
pub const WRAPS_SECS: [f64; 2] = [4_294.967_296, 4_294_967.296];

/// Returns the time step (s) from which an interruption between these sample times (s) counts as a pause; infinite if the
/// times do not increase.
pub fn steps_of_a_pause(times: &[f64]) -> f64 {
    median_step(times).map_or(f64::INFINITY, pause_by_step)
}

/// Returns the minimum length of a pause (s) for a channel with this sampling interval (s).
pub fn pause_by_step(step_secs: f64) -> f64 {
    PAUSE_IN_STEPS * step_secs
}

/// Returns the minimum length of a gap (s) in a recording with these sample times (s).
pub fn gap_by_steps(times: &[f64]) -> f64 {
    steps_of_a_pause(times).max(SHORTEST_GAP_SECS)
}

pub fn gap_by_rate(rate_hz: Option<f64>) -> f64 {
    rate_hz.map_or(UNKNOWN_GAP_SECS, |rate| (PAUSE_IN_STEPS / rate).max(SHORTEST_GAP_SECS))
}

pub fn median_step(times: &[f64]) -> Option<f64> {
    let steps = times.windows(2).map(|pair| pair[1] - pair[0]);
    median(steps.filter(|step| *step > 0.0))
}

/// Returns the period (s) of the 32-bit counter that overflowed within this time step (s); `None` if no counter did.
pub fn after_wrap(step: f64, gap_secs: f64) -> Option<f64> {
    let wraps = WRAPS_SECS.into_iter();
    let mut wrap = wraps.filter(|wrap| step < 0.0 && (0.0..=gap_secs).contains(&(step + wrap)));
    wrap.next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_32_bit_counter_that_wraps_is_continued() {
        assert_eq!(after_wrap(0.01 - WRAPS_SECS[0], 0.2), Some(WRAPS_SECS[0]));
        assert_eq!(after_wrap(0.0 - WRAPS_SECS[1], 0.2), Some(WRAPS_SECS[1]));
        for step in [0.01, -0.01, -4000.0, 0.3 - WRAPS_SECS[0]] {
            assert_eq!(after_wrap(step, 0.2), None, "{step}");
        }
    }

    #[test]
    fn a_gap_is_twenty_steps_and_never_less_than_a_late_stamp() {
        let times = |step: f64| -> Vec<f64> { (0..9).map(|k| f64::from(k) * step).collect() };
        assert_eq!(gap_by_steps(&times(0.5)), 10.0);
        assert_eq!(gap_by_steps(&times(0.001)), 0.2);
        assert_eq!(gap_by_rate(Some(2.0)), 10.0);
        assert_eq!(gap_by_rate(Some(1000.0)), 0.2);
        assert_eq!(gap_by_rate(None), 1.0);
    }
}
