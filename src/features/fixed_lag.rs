//! The gauges a fixed time ago, `s(t − Δ)`: the plainest history (references 23 and 24 of the paper).
//!
//! Guarantees: between samples the gauges are interpolated, so jitter and rounded times move nothing by a whole sample;
//! before Δ has passed, the present gauges stand in; memory holds no more than the longest lag.

use std::collections::VecDeque;

/// The past of one recording, as long as the longest lag.
#[derive(Clone, Debug)]
pub struct FixedLag {
    lags_secs: Vec<f64>,
    times: VecDeque<f64>,
    gauges: VecDeque<f64>,
    n_gauges: usize,
    /// For each lag, the position of the first kept sample that is younger than it.
    younger: Vec<usize>,
}

impl FixedLag {
    /// Before the first sample.
    #[must_use]
    pub fn new(lags_secs: &[f64], n_gauges: usize) -> Self {
        Self {
            lags_secs: lags_secs.to_vec(),
            times: VecDeque::new(),
            gauges: VecDeque::new(),
            n_gauges,
            younger: vec![0; lags_secs.len()],
        }
    }

    /// Takes the next sample and writes the lagged gauges, one set per lag.
    pub fn step(&mut self, time: f64, gauges: &[f64], out: &mut [f64]) {
        self.times.push_back(time);
        self.gauges.extend(gauges);
        let g = self.n_gauges;
        for (at, (lag, out)) in self
            .lags_secs
            .iter()
            .zip(out.chunks_exact_mut(g))
            .enumerate()
        {
            let wanted = time - lag;
            let younger = &mut self.younger[at];
            while self.times[*younger] <= wanted && *younger + 1 < self.times.len() {
                *younger += 1; // ends at the present sample, which is younger than any lag
            }
            let Some(older) = younger.checked_sub(1) else {
                out.copy_from_slice(gauges);
                continue;
            };
            let (start, end) = (self.times[older], self.times[*younger]);
            let share = if end > start {
                (wanted - start) / (end - start)
            } else {
                1.0
            };
            for (gauge, out) in out.iter_mut().enumerate() {
                let before = self.gauges[older * g + gauge];
                let after = self.gauges[*younger * g + gauge];
                *out = before + share * (after - before);
            }
        }
        // One older sample stays: the next wanted time may still lie right after it.
        let unused = self.younger.iter().copied().min().unwrap_or(0);
        for _ in 1..unused {
            self.times.pop_front();
            self.gauges.drain(..g);
            self.younger.iter_mut().for_each(|younger| *younger -= 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of 1 per second is, half a second ago, less by a half; before that there is no past.
    #[test]
    fn a_ramp_is_interpolated_between_samples() {
        let mut lag = FixedLag::new(&[0.5, 3.0], 1);
        for k in 0..20 {
            let time = 0.3 * f64::from(k);
            let mut out = [0.0; 2];
            lag.step(time, &[time], &mut out);
            for (value, lag) in out.iter().zip([0.5, 3.0]) {
                let expected = if time >= lag { time - lag } else { time };
                assert!((value - expected).abs() < 1e-12, "{time} s: {out:?}");
            }
        }
        assert!(lag.times.len() < 13, "kept {}", lag.times.len());
    }

    #[test]
    fn repeated_times_divide_by_nothing() {
        let mut lag = FixedLag::new(&[0.1], 1);
        let mut out = [0.0];
        for (time, gauge) in [(0.0, 1.0), (0.0, 2.0), (0.0, 3.0), (0.2, 4.0), (0.2, 5.0)] {
            lag.step(time, &[gauge], &mut out);
            assert!(out[0].is_finite());
        }
    }
}
