//! What a pause between two samples is.
//!
//! A step longer than a *gap* ends a recording where files are read, and tells a calibration at work that samples are
//! missing. How long that is, is measured here and nowhere else, and stands in each calibration.

use super::median::median;

/// A step this many times the median is a pause, not a few lost samples.
const PAUSE_IN_STEPS: f64 = 20.0;
/// No pause is shorter (s): nobody takes a load off and puts it back so fast, but computers stamp a sample late.
const SHORTEST_GAP_SECS: f64 = 0.2;
/// What is taken for a pause where no step says how fast samples come (s).
const UNKNOWN_GAP_SECS: f64 = 1.0;

/// A time further after the last than this is off the clock (s).
pub const LEAP_SECS: f64 = 86_400.0;
/// Where counters of 32 bits begin anew, in microseconds and in milliseconds (s).
pub const WRAPS_SECS: [f64; 2] = [4_294.967_296, 4_294_967.296];

/// How long the steps of a pause are at least, by the median step; infinite where there is none.
pub fn steps_of_a_pause(times: &[f64]) -> f64 {
    median_step(times).map_or(f64::INFINITY, pause_by_step)
}

/// The pause of a channel whose numbers come at this step (s).
pub fn pause_by_step(step_secs: f64) -> f64 {
    PAUSE_IN_STEPS * step_secs
}

/// The step above which samples are missing, by the steps themselves (s).
pub fn gap_by_steps(times: &[f64]) -> f64 {
    steps_of_a_pause(times).max(SHORTEST_GAP_SECS)
}

/// The gap of a sensor of which no more is known than its rate.
pub fn gap_by_rate(rate_hz: Option<f64>) -> f64 {
    rate_hz.map_or(UNKNOWN_GAP_SECS, |rate| (PAUSE_IN_STEPS / rate).max(SHORTEST_GAP_SECS))
}

/// The median of the steps forward; `None` if there are none.
pub fn median_step(times: &[f64]) -> Option<f64> {
    let steps = times.windows(2).map(|pair| pair[1] - pair[0]);
    median(steps.filter(|step| *step > 0.0))
}

/// How far a counter that began anew has really come, where `step` back is that of one (s).
pub fn after_wrap(step: f64, gap_secs: f64) -> Option<f64> {
    let wraps = WRAPS_SECS.into_iter();
    let mut wrap = wraps.filter(|wrap| step < 0.0 && (0.0..=gap_secs).contains(&(step + wrap)));
    wrap.next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_of_32_bits_goes_on_where_it_begins_anew() {
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
