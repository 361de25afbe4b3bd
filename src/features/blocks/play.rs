//! Play operators: a gauge dragged through a clearance of ± r (generalised Prandtl-Ishlinskii model, whose inverse is
//! of the same class and is fitted directly).
//!
//! `p ← max(s − r, min(s + r, p))`, relaxed at the first sample: p = s. Radii are given in standard deviations of the
//! gauge, so that one list fits gauges of any unit.

use crate::features::block::{Appends, Block, Lists, Search, Stream};
use crate::features::channel::AuxiliaryChannel;
use crate::features::gauge_scale::GaugeScale;
use crate::features::setting::{Range, Setting, Unit};
use crate::features::source::{Constant, Memory, Numbers, Precision, Rows, Source};

/// The block; its values are radii.
#[derive(Clone, Copy, Debug)]
pub struct Play;

const RADII: Setting = Setting {
    key: "play_radii",
    option: "play",
    label: "Play radii",
    what: "a play radius",
    unit: Unit::SIGMA,
    default: &[0.1, 0.2, 0.4, 0.7, 1.1, 1.6],
    range: Range::Positive,
    step: 0.01,
    explanation: "Appends play (backlash) operators: each gauge dragged through a clearance of ± these radii, in standard \
                  deviations of the gauge. They remember the last reversals, as hysteresis does",
    source: "Prandtl-Ishlinskii",
};

/// Radii that are tried: each about 1.46 times the one before, from hardly any play to a gauge's whole range.
const CANDIDATES: [f64; 12] = [0.05, 0.073, 0.11, 0.16, 0.23, 0.33, 0.49, 0.71, 1.0, 1.5, 2.2, 3.2];

impl Block for Play {
    fn name(&self) -> &'static str {
        "Play"
    }

    fn setting(&self) -> &'static Setting {
        &RADII
    }

    fn formula(&self) -> &'static str {
        "p ← max(s − r, min(s + r, p))"
    }

    fn appends(&self) -> Appends {
        Appends::Past(|radius| format!("play_{radius}"))
    }

    fn stream(
        &self,
        radii: &[f64],
        scale: &GaugeScale,
        _: &[AuxiliaryChannel],
        _: f64,
    ) -> Box<dyn Stream> {
        Box::new(Operators::new(radii, &scale.deviation))
    }

    fn goes_on(&self) -> bool {
        true
    }

    fn source(&self, radii: &[f64], rows: &Rows<'_>) -> Source {
        let in_units_of_gauges =
            |radius: &f64| rows.scale.deviation.iter().map(|sd| radius * sd).collect();
        Source::new(
            vec![Constant {
                name: "radius",
                precision: Precision::Real,
                numbers: Numbers::Rows(radii.iter().map(in_units_of_gauges).collect()),
            }],
            vec![Memory::of_gauges("play", radii.len())],
            [C, RUST, PYTHON, MATLAB],
        )
    }

    fn search(&self) -> Option<Search> {
        Some(Search { candidates: &CANDIDATES, lists: Lists::Even { min: 3, max: 8 } })
    }
}

const C: &str = "
        int at;
        for (at = 0; at < {{ sets }}; at++) {
            for (g = 0; g < {{ n_gauges }}; g++) {
                {{ prefix }}_real low = row[g] - c->radius[at][g], high = row[g] + c->radius[at][g];
                {{ prefix }}_real position = s->started ? s->play[at][g] : row[g];
                position = position > high ? high : position;
                position = position < low ? low : position;
                s->play[at][g] = position;
                *next++ = position - row[g];
            }
        }
";

const RUST: &str = "
        for (position, radius) in self.play.iter_mut().zip(&RADIUS) {
            for g in 0..GAUGES {
                if !self.started {
                    position[g] = row[g];
                }
                position[g] = position[g].min(row[g] + radius[g]).max(row[g] - radius[g]);
                row[next + g] = position[g] - row[g];
            }
            next += GAUGES;
        }
";

const PYTHON: &str = "
        if not self.started:
            self.play = np.tile(present, (len(RADIUS), 1))
        self.play = np.maximum(np.minimum(self.play, present + RADIUS), present - RADIUS)
        row.extend(self.play - present)
";

const MATLAB: &str = "
for at = 1:{{ sets }}
    if ~state.started
        state.play(:, at) = present;
    end
    radius = c.radius(at, :)';
    state.play(:, at) = max(min(state.play(:, at), present + radius), present - radius);
    row(next + (1:{{ n_gauges }})) = state.play(:, at) - present;
    next = next + {{ n_gauges }};
end
";

/// The operators of one recording.
#[derive(Clone, Debug)]
struct Operators {
    /// One set of radii per entry of the list, in the unit of each gauge.
    radii: Vec<f64>,
    /// Likewise; empty before the first sample.
    positions: Vec<f64>,
}

impl Operators {
    /// Before the first sample; `deviations` are the gauges' standard deviations.
    fn new(radii: &[f64], deviations: &[f64]) -> Self {
        Self {
            radii: radii
                .iter()
                .flat_map(|&radius| deviations.iter().map(move |deviation| radius * deviation))
                .collect(),
            positions: Vec::new(),
        }
    }
}

impl Stream for Operators {
    fn step(&mut self, _time: f64, gauges: &[f64], _: &[f64], out: &mut [f64]) {
        if self.positions.is_empty() {
            self.positions = gauges.repeat(self.radii.len() / gauges.len());
        }
        let sets = self.positions.chunks_exact_mut(gauges.len());
        for (positions, radii) in sets.zip(self.radii.chunks_exact(gauges.len())) {
            for ((position, gauge), radius) in positions.iter_mut().zip(gauges).zip(radii) {
                *position = position.min(gauge + radius).max(gauge - radius);
            }
        }
        out.copy_from_slice(&self.positions);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn positions(radius: f64, gauges: &[f64]) -> Vec<f64> {
        let mut play = Operators::new(&[radius], &[2.0]);
        let mut out = [0.0];
        gauges
            .iter()
            .map(|gauge| {
                play.step(0.0, &[*gauge], &[], &mut out);
                out[0]
            })
            .collect()
    }

    /// Radius 0.5 SD of 2 is 1: up to 4 it follows one below, then waits until the gauge is one below it.
    #[test]
    fn the_position_is_dragged_and_waits_after_a_reversal() {
        assert_eq!(
            positions(0.5, &[0.0, 0.5, 2.0, 4.0, 3.5, 2.0, 1.0, 0.0]),
            [0.0, 0.0, 1.0, 3.0, 3.0, 3.0, 2.0, 1.0]
        );
    }

    #[test]
    fn a_constant_gauge_keeps_its_value() {
        let mut out = [0.0];
        let mut play = Operators::new(&[0.5], &[0.0]);
        play.step(0.0, &[7.0], &[], &mut out);
        play.step(0.0, &[7.0], &[], &mut out);
        assert_eq!(out, [7.0]);
    }
}
