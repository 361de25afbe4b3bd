//! Feature block of auxiliary channels: the present or low-passed value of each channel, and its product with each gauge.
//!
//! `u ← u + (1 − e^(−Δt/τ)) ((a − a₀)/σ − u)`. Here a is the channel, a₀ its reference value, σ its standard deviation, and u
//! the output of the low-pass. At the first sample, u is the present value `(a − a₀)/σ`; with τ = 0 it always is. For each τ
//! and channel the columns are u (drift of the zero) and u zᵢ with the standardised gauge zᵢ (drift of the sensitivity).

use crate::features::{
    block::{Appends, Block, Inputs, Stream},
    channel::AuxiliaryChannel,
    gauge_scale::GaugeScale,
    setting::{Range, Setting, Unit},
    source::{Constant, Memory, Rows, Source},
};

/// Feature block of auxiliary channels. Its values are time constants (s); zero means the present value of the channel.
#[derive(Clone, Copy, Debug)]
pub struct Auxiliary;

const TAUS: Setting = Setting {
    key: "auxiliary_secs",
    option: "auxiliary",
    label: "Auxiliary channels",
    what: "a time constant of the auxiliary channels",
    unit: Unit::SECONDS,
    default: &[0.0],
    range: Range::NotNegative,
    step: 1.0,
    explanation: "Appends auxiliary channels (such as temperature, supply voltage, humidity) and their products with each gauge, to \
                  correct drift of zero and sensitivity. The channels pass through low-passes with these time constants; 0 is the present \
                  value",
    source: "",
};

impl Block for Auxiliary {
    fn name(&self) -> &'static str {
        "Auxiliary"
    }

    fn setting(&self) -> &'static Setting {
        &TAUS
    }

    fn formula(&self) -> &'static str {
        "u, u z_i; u ← u + (1 − e^{−Δt/τ}) ((a − a_0)/σ − u)"
    }

    fn appends(&self) -> Appends {
        Appends::Auxiliary
    }

    fn stream(&self, taus_secs: &[f64], inputs: &Inputs<'_>) -> Box<dyn Stream> {
        Box::new(Effects {
            taus_secs: taus_secs.to_vec(),
            channels: inputs.channels.to_vec(),
            z: vec![0.0; inputs.scale.shift.len()],
            scale: inputs.scale.clone(),
            states: Vec::new(),
            last_secs: 0.0,
        })
    }

    fn source(&self, taus_secs: &[f64], rows: &Rows<'_>) -> Source {
        let of = |name, pick: fn(&AuxiliaryChannel) -> f64| {
            Constant::reals(name, rows.channels.iter().map(pick))
        };
        let mut constants = vec![
            Constant::reals("auxiliary_tau_secs", taus_secs.iter().copied()),
            of("auxiliary_reference", |channel| channel.reference),
            of("auxiliary_factor", |channel| channel.inverse_scale),
            of("auxiliary_low", |channel| channel.limits().0),
            of("auxiliary_high", |channel| channel.limits().1),
        ];
        let names = ["auxiliary_gauge_factor", "auxiliary_gauge_constant"];
        constants.extend(rows.standard(names));
        let sets = taus_secs.len() * rows.channels.len();
        Source::new(
            constants,
            vec![
                Memory::single("auxiliary_state", sets),
                Memory::single("auxiliary_rest", sets)
                    .about("rounding error of the last step, in single precision"),
            ],
            [C, RUST, PYTHON, MATLAB],
        )
    }
}

const C: &str = "
        int at, channel;
        for (at = 0; at < {{ sets }}; at++) {
            {{ prefix }}_real tau = c->auxiliary_tau_secs[at];
            {{ prefix }}_real share = tau > 0 ? -{{ prefix }}_expm1(-dt / tau) : 1;
            for (channel = 0; channel < {{ n_auxiliary }}; channel++) {
                int own = at * {{ n_auxiliary }} + channel;
                {{ prefix }}_real now = (auxiliary[channel] - c->auxiliary_reference[channel]) * c->auxiliary_factor[channel];
                {{ prefix }}_real moved = now;
                if (!started)
                    s->auxiliary_rest[own] = 0;
                if (started && tau > 0) {
                    {{ prefix }}_real state = s->auxiliary_state[own];
                    {{ prefix }}_real by = share * (now - state) - s->auxiliary_rest[own];
                    moved = state + by;
                    s->auxiliary_rest[own] = (moved - state) - by;
                }
                s->auxiliary_state[own] = moved;
                *next++ = moved;
                for (g = 0; g < {{ n_gauges }}; g++)
                    *next++ = moved * (row[g] * c->auxiliary_gauge_factor[g] + c->auxiliary_gauge_constant[g]);
            }
        }
";

const RUST: &str = "
        for (at, tau_secs) in AUXILIARY_TAU_SECS.iter().enumerate() {
            let share = if *tau_secs > 0.0 { -exp_m1(-dt / tau_secs) } else { 1.0 };
            for channel in 0..AUXILIARY {
                let own = at * AUXILIARY + channel;
                let now = (auxiliary[channel] - AUXILIARY_REFERENCE[channel]) * AUXILIARY_FACTOR[channel];
                let mut moved = now;
                if !started {
                    self.auxiliary_rest[own] = 0.0;
                }
                if started && *tau_secs > 0.0 {
                    let state = self.auxiliary_state[own];
                    let by = share * (now - state) - self.auxiliary_rest[own];
                    moved = state + by;
                    self.auxiliary_rest[own] = (moved - state) - by;
                }
                self.auxiliary_state[own] = moved;
                row[next] = moved;
                for g in 0..GAUGES {
                    row[next + 1 + g] = moved * (row[g] * AUXILIARY_GAUGE_FACTOR[g] + AUXILIARY_GAUGE_CONSTANT[g]);
                }
                next += 1 + GAUGES;
            }
        }
";

const PYTHON: &str = "
        now = (auxiliary - AUXILIARY_REFERENCE) * AUXILIARY_FACTOR
        if not started:
            self.auxiliary_state = np.tile(now, (len(AUXILIARY_TAU_SECS), 1))
        for state, tau_secs in zip(self.auxiliary_state, AUXILIARY_TAU_SECS):
            state += (-np.expm1(-dt / tau_secs) if tau_secs > 0 else 1.0) * (now - state) if started else 0.0
            for moved in state:
                row.append(moved * np.append(1.0, present * AUXILIARY_GAUGE_FACTOR + AUXILIARY_GAUGE_CONSTANT))
";

const MATLAB: &str = "
for at = 1:{{ sets }}
    for channel = 1:{{ n_auxiliary }}
        own = (at - 1) * {{ n_auxiliary }} + channel;
        now = (auxiliary(channel) - c.auxiliary_reference(channel)) * c.auxiliary_factor(channel);
        if ~started || c.auxiliary_tau_secs(at) == 0
            state.auxiliary_state(own) = now;
        else
            share = -expm1(-dt / c.auxiliary_tau_secs(at));
            state.auxiliary_state(own) = state.auxiliary_state(own) + share * (now - state.auxiliary_state(own));
        end
        row(next + 1) = state.auxiliary_state(own);
        row(next + 1 + (1:{{ n_gauges }})) = state.auxiliary_state(own) * (present .* c.auxiliary_gauge_factor + c.auxiliary_gauge_constant);
        next = next + 1 + {{ n_gauges }};
    end
end
";

/// Output of the low-passes of all auxiliary channels.
#[derive(Clone, Debug)]
struct Effects {
    taus_secs: Vec<f64>,
    channels: Vec<AuxiliaryChannel>,
    scale: GaugeScale,
    z: Vec<f64>,
    /// Output of each low-pass: one value per channel for each time constant. Empty before the first sample.
    states: Vec<f64>,
    last_secs: f64,
}

impl Stream for Effects {
    fn step(&mut self, time: f64, gauges: &[f64], auxiliary: &[f64], out: &mut [f64]) {
        let n = self.channels.len();
        assert_eq!(auxiliary.len(), n, "every sample has every auxiliary channel");
        let now = |at: usize| {
            let AuxiliaryChannel { reference, inverse_scale, .. } = self.channels[at];
            (auxiliary[at] - reference) * inverse_scale
        };
        if self.states.is_empty() {
            self.states = (0..n * self.taus_secs.len()).map(|state| now(state % n)).collect();
            self.last_secs = time;
        }
        let elapsed = time - self.last_secs;
        self.last_secs = time;
        self.scale.apply(gauges, &mut self.z);
        let mut columns = out.chunks_exact_mut(1 + gauges.len());
        for (at, state) in self.states.iter_mut().enumerate() {
            let tau_secs = self.taus_secs[at / n];
            if tau_secs > 0.0 {
                *state += -(-elapsed / tau_secs).exp_m1() * (now(at % n) - *state)
            } else {
                *state = now(at % n)
            }
            let columns = columns.next().expect("columns for each state");
            columns[0] = *state;
            for (product, z) in columns[1..].iter_mut().zip(&self.z) {
                *product = *state * z;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(reference: f64, inverse_scale: f64) -> AuxiliaryChannel {
        AuxiliaryChannel {
            name: "T".to_owned(),
            unit: "°C".to_owned(),
            reference,
            inverse_scale,
            min: 0.0,
            max: 40.0,
        }
    }

    /// A step of two standard deviations appears at once for τ = 0, else as `2 (1 − e^(−t/τ))`, in one step or in many.
    #[test]
    fn a_channel_enters_at_once_and_through_its_low_pass() {
        let scale = GaugeScale {
            shift: vec![1.0],
            inverse_scale: vec![2.0],
            deviation: vec![0.5],
            ..GaugeScale::default()
        };
        let channels = &[channel(20.0, 0.5)];
        let inputs = Inputs { scale: &scale, channels, history_step_secs: 0.0 };
        let mut stream = Auxiliary.stream(&[0.0, 10.0], &inputs);
        let mut out = [0.0; 4];
        stream.step(5.0, &[2.0], &[20.0], &mut out);
        assert_eq!(out, [0.0; 4]);
        for time in [5.0, 6.0, 7.5, 40.0] {
            stream.step(time, &[2.0], &[24.0], &mut out);
            let slow = 2.0 * (1.0 - (-(time - 5.0) / 10.0_f64).exp());
            for (value, expected) in out.iter().zip([2.0, 4.0, slow, 2.0 * slow]) {
                assert!((value - expected).abs() < 1e-12, "{out:?}");
            }
        }
    }

    #[test]
    fn two_channels_have_separate_columns() {
        let channels = &[channel(20.0, 1.0), channel(5.0, 10.0)];
        let scale = &GaugeScale::identity(1);
        let inputs = Inputs { scale, channels, history_step_secs: 0.0 };
        let mut stream = Auxiliary.stream(&[0.0], &inputs);
        let mut out = [0.0; 4];
        stream.step(0.0, &[3.0], &[22.0, 5.2], &mut out);
        for (value, expected) in out.iter().zip([2.0, 6.0, 2.0, 6.0]) {
            assert!((value - expected).abs() < 1e-12, "{out:?}");
        }
    }
}
