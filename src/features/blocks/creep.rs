//! Feature block of creep: first-order low-passes of each gauge (reference 22 in Koike et al. (2019)).
//!
//! `y ← y + (1 − e^(−Δt/τ)) (s − y)`, with the gauge s, the output y of the low-pass, and y = s at the first sample. The
//! equation is exact for a gauge that is constant between samples, so the sample rate may change.
//!
//! The influence of the unknown signal before the first sample fades as e^(−t/τ), with the time t since the first sample. So
//! the column is `s + w (y − s)` with the weight `w = 1 − e^(−t/τ)`. At first, this is the present gauge s; after some time
//! constants, it is y. The signal in a pause of the duration P is unknown too: y is kept, and w is multiplied by `e^(−P/τ)`.

use crate::features::{
    block::{Appends, Block, Inputs, Lists, Search, Stream},
    gauge_scale::GaugeScale,
    setting::{Range, Setting, Unit},
    source::{Constant, Memory, Rows, Source},
};

/// Feature block of creep. Its values are time constants (s).
#[derive(Clone, Copy, Debug)]
pub struct Creep;

const TAUS: Setting = Setting {
    key: "creep_secs",
    option: "creep",
    label: "Creep time constants",
    what: "a creep time constant",
    unit: Unit::SECONDS,
    default: &[1.0, 6.0, 40.0],
    range: Range::Positive,
    step: 0.1,
    explanation: "Appends low-passes of each gauge with these time constants: the part of the signal that follows a load slowly",
    source: "reference 22 of the paper",
};

/// Weight `1 − e^(−t/τ)` of a low-pass after three time constants.
const DETERMINED: f64 = 0.95;

/// Time constants that cross-validation tries (s), as far as the recordings can resolve them.
const CANDIDATES: [f64; 18] = [
    0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0,
    200.0, 500.0,
];

impl Block for Creep {
    fn name(&self) -> &'static str {
        "Creep"
    }

    fn setting(&self) -> &'static Setting {
        &TAUS
    }

    fn formula(&self) -> &'static str {
        "y ← y + (1 − e^{−Δt/τ}) (s − y)"
    }

    fn appends(&self) -> Appends {
        Appends::Past(|tau_secs| format!("creep_{tau_secs}s"))
    }

    fn stream(&self, taus_secs: &[f64], _: &Inputs<'_>) -> Box<dyn Stream> {
        Box::new(LowPasses::new(taus_secs))
    }

    fn settling_secs(&self, taus_secs: &[f64]) -> f64 {
        let longest = taus_secs.iter().copied().fold(0.0, f64::max);
        -longest * (1.0 - DETERMINED).ln()
    }

    /// Returns one effect for each time constant. What is missing of the output at the weight w is 1 − w of a value that scatters
    /// like the gauge.
    fn effects(&self, taus_secs: &[f64], columns: &[f64], scale: &GaugeScale) -> Vec<f64> {
        let of_tau = |squares: &[f64]| {
            let each = squares.iter().zip(&scale.deviation);
            each.map(|(square, deviation)| square * deviation * deviation).sum()
        };
        let by_tau = columns.chunks(scale.deviation.len().max(1));
        by_tau.take(taus_secs.len()).map(of_tau).collect()
    }

    fn usually_missing(&self, taus_secs: &[f64], effects: &[f64], scale: &GaugeScale) -> f64 {
        let rest = |tau: &f64| scale.run_secs.map_or(1.0 - DETERMINED, |secs| (-secs / tau).exp());
        taus_secs.iter().zip(effects).map(|(tau, effect)| effect * rest(tau).powi(2)).sum()
    }

    fn source(&self, taus_secs: &[f64], rows: &Rows<'_>) -> Source {
        let sets = taus_secs.len();
        Source::new(
            [("tau_secs", taus_secs), ("creep_effect", rows.effects), ("creep_fade", rows.fade)]
                .into_iter()
                .filter(|(_, numbers)| !numbers.is_empty())
                .map(|(name, numbers)| Constant::reals(name, numbers.iter().copied()))
                .collect(),
            vec![
                Memory::of_gauges("creep", sets),
                Memory::of_gauges("creep_rest", sets)
                    .about("rounding error of the last update, in single precision"),
                Memory::single("creep_share", sets)
                    .about("computed for the time step `creep_step` (s)"),
                Memory::single("creep_step", sets),
                Memory::single("creep_weight", sets).about("from 0 at the start to 1"),
            ],
            [C, RUST, PYTHON, MATLAB],
        )
    }

    fn search(&self) -> Option<Search> {
        Some(Search { candidates: &CANDIDATES, lists: Lists::OneByOne(3) })
    }
}

const C: &str = "
        int at;
        for (at = 0; at < {{ sets }}; at++) {
            {{ prefix }}_real share = 0;
            if (dt < s->creep_step[at] || dt > s->creep_step[at]) {
                s->creep_step[at] = dt;
                s->creep_share[at] = -{{ prefix }}_expm1(-dt / c->tau_secs[at]);
            }
            if (!started) {
                s->creep_weight[at] = 0;
            } else if (dt > c->gap_secs) {
                s->creep_weight[at] -= s->creep_share[at] * s->creep_weight[at];
            } else {
                share = s->creep_share[at];
                s->creep_weight[at] += share * (1 - s->creep_weight[at]);
            }
            s->missing += c->creep_effect[at] * (1 - s->creep_weight[at]) * (1 - s->creep_weight[at]);
{% if fades %}
            s->unknown += c->creep_fade[at] * (1 - s->creep_weight[at]) * (1 - s->creep_weight[at]);
{% endif %}
            for (g = 0; g < {{ n_gauges }}; g++) {
                {{ prefix }}_real state = started ? s->creep[at][g] : row[g];
                {{ prefix }}_real by = started ? share * (row[g] - state) - s->creep_rest[at][g] : 0;
                {{ prefix }}_real moved = state + by;
                s->creep_rest[at][g] = (moved - state) - by;
                s->creep[at][g] = moved;
                *next++ = s->creep_weight[at] * (moved - row[g]);
            }
        }
";

const RUST: &str = "
        let mut next_values = [0.0; GAUGES];
        for (at, tau_secs) in TAU_SECS.iter().enumerate() {
            if dt != self.creep_step[at] {
                self.creep_step[at] = dt;
                self.creep_share[at] = -exp_m1(-dt / tau_secs);
            }
            let mut share = 0.0;
            if !started {
                self.creep_weight[at] = 0.0;
            } else if is_gap {
                self.creep_weight[at] -= self.creep_share[at] * self.creep_weight[at];
            } else {
                share = self.creep_share[at];
                self.creep_weight[at] += share * (1.0 - self.creep_weight[at]);
            }
            self.missing += CREEP_EFFECT[at] * (1.0 - self.creep_weight[at]) * (1.0 - self.creep_weight[at]);
{% if fades %}
            self.unknown += CREEP_FADE[at] * (1.0 - self.creep_weight[at]) * (1.0 - self.creep_weight[at]);
{% endif %}
            for (g, present) in row[..GAUGES].iter().enumerate() {
                let state = if started { self.creep[at][g] } else { *present };
                let by = if started { share * (present - state) - self.creep_rest[at][g] } else { 0.0 };
                let moved = state + by;
                self.creep_rest[at][g] = (moved - state) - by;
                self.creep[at][g] = moved;
                next_values[g] = self.creep_weight[at] * (moved - present);
            }
            row[next..next + GAUGES].copy_from_slice(&next_values);
            next += GAUGES;
        }
";

const PYTHON: &str = "
        if not started:
            self.creep = np.tile(present, (len(TAU_SECS), 1))
            self.creep_weight = np.zeros(len(TAU_SECS))
        for at, (state, tau_secs) in enumerate(zip(self.creep, TAU_SECS)):
            if started and dt > GAP_SECS:
                self.creep_weight[at] *= np.exp(-dt / tau_secs)
            elif started:
                share = -np.expm1(-dt / tau_secs)
                state += share * (present - state)
                self.creep_weight[at] += share * (1 - self.creep_weight[at])
            row.append(self.creep_weight[at] * (state - present))
        self.missing += np.sum(CREEP_EFFECT * (1 - self.creep_weight) ** 2)
{% if fades %}
        self.unknown += np.sum(CREEP_FADE * (1 - self.creep_weight) ** 2)
{% endif %}
";

const MATLAB: &str = "
for at = 1:{{ sets }}
    if ~started
        state.creep(:, at) = present;
        state.creep_weight(:, at) = 0;
    elseif is_gap
        state.creep_weight(:, at) = state.creep_weight(:, at) * exp(-dt / c.tau_secs(at));
    else
        share = -expm1(-dt / c.tau_secs(at));
        state.creep(:, at) = state.creep(:, at) + share * (present - state.creep(:, at));
        state.creep_weight(:, at) = state.creep_weight(:, at) + share * (1 - state.creep_weight(:, at));
    end
    state.missing = state.missing + c.creep_effect(at) * (1 - state.creep_weight(:, at)) ^ 2;
{% if fades %}
    state.unknown = state.unknown + c.creep_fade(at) * (1 - state.creep_weight(:, at)) ^ 2;
{% endif %}
    row(next + (1:{{ n_gauges }})) = state.creep_weight(:, at) * (state.creep(:, at) - present);
    next = next + {{ n_gauges }};
end
";

/// Outputs of the low-passes of all gauges.
#[derive(Clone, Debug)]
struct LowPasses {
    /// Each time constant τ (s) with the weight `1 − e^(−t/τ)` of its low-passes.
    taus: Vec<(f64, f64)>,
    /// Output of each low-pass: one value per gauge for each time constant. Empty before the first sample.
    states: Vec<f64>,
    last_secs: f64,
}

impl LowPasses {
    fn new(taus_secs: &[f64]) -> Self {
        let taus = taus_secs.iter().map(|tau| (*tau, 0.0)).collect();
        Self { taus, states: Vec::new(), last_secs: 0.0 }
    }
}

impl Stream for LowPasses {
    fn step(&mut self, time: f64, gauges: &[f64], _: &[f64], out: &mut [f64]) {
        let n = gauges.len();
        if self.states.is_empty() {
            self.states = gauges.repeat(self.taus.len());
            self.last_secs = time;
        }
        let elapsed = time - self.last_secs;
        self.last_secs = time;
        let sets = self.states.chunks_exact_mut(n).zip(out.chunks_exact_mut(n));
        for ((tau, weight), (states, out)) in self.taus.iter_mut().zip(sets) {
            let share = -(-elapsed / *tau).exp_m1();
            *weight += share * (1.0 - *weight);
            for ((state, gauge), out) in states.iter_mut().zip(gauges).zip(out) {
                *state += share * (gauge - *state);
                *out = gauge + *weight * (*state - gauge);
            }
        }
    }

    fn resume(&mut self, time: f64) {
        for (tau, weight) in &mut self.taus {
            *weight *= ((self.last_secs - time) / *tau).exp();
        }
        self.last_secs = time;
    }

    fn missing(&self, effects: &[f64]) -> f64 {
        let each = self.taus.iter().zip(effects);
        each.map(|((_, weight), effect)| effect * (1.0 - weight) * (1.0 - weight)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After a step from 0 to 1, the low-pass and its weight are `1 − e^(−t/τ)`, for any sample times.
    #[test]
    fn the_step_response_is_an_exponential() {
        let mut creep = LowPasses::new(&[2.0, 10.0]);
        let mut out = [0.0; 2];
        creep.step(0.0, &[0.0], &[], &mut out);
        for time in [0.1, 0.15, 1.0, 4.0, 20.0, 31.0] {
            creep.step(time, &[1.0], &[], &mut out);
            for (value, tau) in out.iter().zip([2.0, 10.0]) {
                let [fading, weight] = [(-time / tau).exp(), 1.0 - (-time / tau).exp()];
                assert!((value - (1.0 - weight * fading)).abs() < 1e-12);
            }
            let missing = 3.0 * (-time / 2.0).exp().powi(2) + 5.0 * (-time / 10.0).exp().powi(2);
            assert!((creep.missing(&[3.0, 5.0]) - missing).abs() < 1e-12);
        }
    }

    #[test]
    fn the_effect_of_a_time_constant_is_that_of_all_gauges() {
        let scale =
            GaugeScale { deviation: vec![2.0, 1.0], run_secs: Some(9.0), ..GaugeScale::default() };
        let effects = Creep.effects(&[1.0, 9.0], &[0.5, 3.0, 0.25, 0.0], &scale);
        assert_eq!(effects, [5.0, 1.0]);
        let usual = Creep.usually_missing(&[1.0, 9.0], &effects, &scale);
        assert!((usual - 5.0 * (-18.0_f64).exp() - (-2.0_f64).exp()).abs() < 1e-12);
    }

    #[test]
    fn it_starts_relaxed() {
        let mut out = [0.0; 2];
        LowPasses::new(&[1.0]).step(7.0, &[3.0, 4.0], &[], &mut out);
        assert_eq!(out, [3.0, 4.0]);
    }
}
