//! What a pause between two samples is.
//!
//! A step longer than a *gap* ends a recording where files are read, and tells a calibration at work that samples are
//! missing. How long that is, is measured here and nowhere else, and stands in each calibration.

use std::sync::Arc;

use super::auxiliary::AuxiliaryTable;
use super::median::median;
use super::shared::Shared;

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

/// The gauges of a recording, and of those before it in its file.
#[derive(Debug)]
struct Run {
    times: Shared,
    gauges: Shared,
    auxiliary: AuxiliaryTable,
    before: Option<Arc<Run>>,
}

/// What a sensor showed before the gap that a recording follows.
#[derive(Clone, Debug)]
pub struct Earlier {
    run: Arc<Run>,
    /// Taken off the gauges by a tare.
    less: Vec<f64>,
    /// Which of the auxiliary channels count.
    auxiliary: Vec<usize>,
    /// Every how many-th sample counts.
    every: usize,
}

/// Number of samples that say where every block stands at the end of a gap; what came before them is left aside.
const SAMPLES_BEFORE: usize = 200_000;

impl Earlier {
    /// A recording and what was before that.
    pub(super) fn new(
        times: &Shared,
        gauges: &Shared,
        auxiliary: &AuxiliaryTable,
        before: Option<&Self>,
        n_gauges: usize,
    ) -> Self {
        Self {
            run: Arc::new(Run {
                times: times.clone(),
                gauges: gauges.clone(),
                auxiliary: auxiliary.clone(),
                before: before.map(|before| Arc::clone(&before.run)),
            }),
            less: vec![0.0; n_gauges],
            auxiliary: (0..auxiliary.len()).collect(),
            every: 1,
        }
    }

    pub(super) fn tared(&mut self, offsets: &[f64]) {
        let less = self.less.iter_mut().zip(offsets);
        less.for_each(|(less, offset)| *less += offset);
    }

    /// From now on these of the auxiliary channels count.
    pub(super) fn pick_auxiliary(&mut self, places: &[usize]) {
        self.auxiliary = places.iter().map(|at| self.auxiliary[*at]).collect();
    }

    pub(super) fn decimated(&self, step: usize) -> Self {
        Self { every: self.every * step, ..self.clone() }
    }

    /// Gives each sample's time, gauges and auxiliary channels to `take`, and calls `gap` after each recording.
    pub fn replay<T>(
        &self,
        state: &mut T,
        take: impl Fn(&mut T, f64, &[f64], &[f64]),
        gap: impl Fn(&mut T),
    ) {
        let (mut runs, mut n, mut next) = (Vec::new(), 0, Some(&self.run));
        while let Some(run) = next
            && n < SAMPLES_BEFORE
        {
            runs.push(run);
            n += run.times.len() / self.every;
            next = run.before.as_ref();
        }
        let mut tared = self.less.clone();
        let mut auxiliary = vec![0.0; self.auxiliary.len()];
        for run in runs.into_iter().rev() {
            let rows = run.times.iter().zip(run.gauges.chunks_exact(self.less.len()));
            for (k, (time, gauges)) in rows.enumerate().step_by(self.every) {
                for ((tared, gauge), less) in tared.iter_mut().zip(gauges).zip(&self.less) {
                    *tared = gauge - less;
                }
                for (value, at) in auxiliary.iter_mut().zip(&self.auxiliary) {
                    *value = run.auxiliary.at(k)[*at];
                }
                take(state, *time, &tared, &auxiliary);
            }
            gap(state);
        }
    }
}

/// Two are the same if they are of the same samples.
impl PartialEq for Earlier {
    fn eq(&self, other: &Self) -> bool {
        let is_same = Arc::ptr_eq(&self.run, &other.run) && self.auxiliary == other.auxiliary;
        is_same && self.less == other.less && self.every == other.every
    }
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
