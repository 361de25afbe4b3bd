//! Creep: first-order low-passes of each gauge (reference 22 of the paper).
//!
//! `y ← y + (1 − e^(−Δt/τ)) (s − y)`, relaxed at the first sample: y = s. Exact for a gauge that is held between samples,
//! so the rate of sampling may change.

/// The low-passes of one recording.
#[derive(Clone, Debug)]
pub struct Creep {
    taus_secs: Vec<f64>,
    /// One set of gauges per time constant; empty before the first sample.
    states: Vec<f64>,
    last_secs: f64,
}

impl Creep {
    /// Before the first sample.
    #[must_use]
    pub fn new(taus_secs: &[f64]) -> Self {
        Self {
            taus_secs: taus_secs.to_vec(),
            states: Vec::new(),
            last_secs: 0.0,
        }
    }

    /// Takes the next sample and writes the low-passed gauges, one set per time constant.
    #[inline]
    pub fn step(&mut self, time: f64, gauges: &[f64], out: &mut [f64]) {
        if self.states.is_empty() {
            self.states = gauges.repeat(self.taus_secs.len());
            self.last_secs = time;
        }
        let elapsed = time - self.last_secs;
        self.last_secs = time;
        for (tau, states) in self
            .taus_secs
            .iter()
            .zip(self.states.chunks_exact_mut(gauges.len()))
        {
            let share = -(-elapsed / tau).exp_m1();
            for (state, gauge) in states.iter_mut().zip(gauges) {
                *state += share * (gauge - *state);
            }
        }
        out.copy_from_slice(&self.states);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After a step from 0 to 1 the low-pass is `1 − e^(−t/τ)`, however the time is cut into samples.
    #[test]
    fn a_step_is_answered_by_an_exponential() {
        let mut creep = Creep::new(&[2.0, 10.0]);
        let mut out = [0.0; 2];
        creep.step(0.0, &[0.0], &mut out);
        for time in [0.1, 0.15, 1.0, 4.0, 20.0] {
            creep.step(time, &[1.0], &mut out);
            for (value, tau) in out.iter().zip([2.0, 10.0]) {
                assert!((value - (1.0 - (-time / tau).exp())).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn it_starts_relaxed() {
        let mut out = [0.0; 2];
        Creep::new(&[1.0]).step(7.0, &[3.0, 4.0], &mut out);
        assert_eq!(out, [3.0, 4.0]);
    }
}
