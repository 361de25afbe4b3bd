//! Feature block of play operators: a position p follows each gauge s through a clearance of ± r. This is the generalised
//! Prandtl-Ishlinskii model of hysteresis. The inverse of such a model has the same form, so the inverse is fitted directly.
//!
//! `p ← max(s − r, min(s + r, p))`. The radii r are in standard deviations of the gauge, so that one list fits gauges in any
//! unit. The position at the first sample is unknown. Once the gauge has covered a range of 2 r, the position no longer
//! depends on its start. The column is `s + w (p − s)`, where the weight w grows with the travel of the gauge: from 0 up to a
//! travel of r to 1 from 2 r on, by at most [`MOST_RISE`] from one sample to the next. So the column has no jump.

use crate::features::{
    block::{Appends, Block, Inputs, Lists, MOST_RISE, Search, Stream},
    gauge_scale::GaugeScale,
    setting::{Range, Setting, Unit},
    source::{Constant, Memory, Numbers, Precision, Rows, Source},
};

/// Feature block of play operators. Its values are the radii r of the play (in standard deviations of the gauge).
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
    explanation: "Appends play (backlash) operators: a position follows each gauge through a clearance of ± these radii, in \
                  standard deviations of the gauge. Like hysteresis, the position depends on the last reversals of the load",
    source: "Prandtl-Ishlinskii",
};

/// Radii that cross-validation tries (in standard deviations of the gauge), in equal ratios: from almost no play to the whole
/// range of a gauge.
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

    fn stream(&self, radii: &[f64], inputs: &Inputs<'_>) -> Box<dyn Stream> {
        Box::new(Operators::new(radii, &inputs.scale.deviation))
    }

    fn source(&self, radii: &[f64], rows: &Rows<'_>) -> Source {
        let in_units_of_gauges =
            |radius: &f64| rows.scale.deviation.iter().map(|sd| radius * sd).collect();
        let constant = |name, numbers| Constant {
            name,
            precision: Precision::Real,
            numbers: Numbers::Rows(numbers),
        };
        let mut constants =
            vec![constant("radius", radii.iter().map(in_units_of_gauges).collect())];
        for (name, numbers) in [("play_effect", rows.effects), ("play_fade", rows.fade)] {
            let by_radius = numbers.chunks(rows.scale.deviation.len().max(1));
            if !numbers.is_empty() {
                constants.push(constant(name, by_radius.map(<[f64]>::to_vec).collect()));
            }
        }
        Source::new(
            constants,
            vec![
                Memory::of_gauges("play", radii.len()),
                Memory::of_gauges("play_weight", radii.len()).about("from 0 at the start to 1"),
                Memory::of_gauges("play_low", 1).about("minimum and maximum of the gauges so far"),
                Memory::of_gauges("play_high", 1),
            ],
            [C, RUST, PYTHON, MATLAB],
        )
    }

    /// Returns one effect for each radius and gauge. A position whose gauge has travelled by t lies evenly anywhere in a range of
    /// 2 r − t, whose variance is a twelfth of its square. While its weight still rises, it counts as less known.
    fn effects(&self, _: &[f64], columns: &[f64], _: &GaugeScale) -> Vec<f64> {
        columns.iter().map(|square| square / 12.0).collect()
    }

    fn usually_missing(&self, radii: &[f64], effects: &[f64], scale: &GaugeScale) -> f64 {
        let usual = Operators {
            travel: scale.travel.iter().map(|travel| [0.0, *travel]).collect(),
            weights: vec![1.0; effects.len()],
            ..Operators::new(radii, &scale.deviation)
        };
        if usual.travel.is_empty() { 0.0 } else { usual.missing(effects) }
    }

    fn travel(&self, radius: f64) -> f64 {
        2.0 * radius
    }

    fn search(&self) -> Option<Search> {
        Some(Search { candidates: &CANDIDATES, lists: Lists::Even { min: 3, max: 8 } })
    }
}

const C: &str = "
        int at;
        for (g = 0; g < {{ n_gauges }}; g++) {
            if (!started || row[g] < s->play_low[0][g])
                s->play_low[0][g] = row[g];
            if (!started || row[g] > s->play_high[0][g])
                s->play_high[0][g] = row[g];
        }
        for (at = 0; at < {{ sets }}; at++) {
            for (g = 0; g < {{ n_gauges }}; g++) {
                {{ prefix }}_real low = row[g] - c->radius[at][g], high = row[g] + c->radius[at][g];
                {{ prefix }}_real position = started ? s->play[at][g] : row[g];
                {{ prefix }}_real travel = s->play_high[0][g] - s->play_low[0][g];
                {{ prefix }}_real open = 2 * c->radius[at][g] - travel;
                {{ prefix }}_real weight = open > 0 ? travel / c->radius[at][g] - 1 : 1;
                {{ prefix }}_real most = started ? s->play_weight[at][g] + ({{ prefix }}_real){{ most_rise }} : 0;
                position = position > high ? high : position;
                position = position < low ? low : position;
                s->play[at][g] = position;
                weight = weight > most ? most : weight;
                weight = weight > 0 ? weight : 0;
                s->play_weight[at][g] = weight;
                if (open < c->radius[at][g] * (1 - weight))
                    open = c->radius[at][g] * (1 - weight);
                s->missing += c->play_effect[at][g] * open * open;
{% if fades %}
                s->unknown += c->play_fade[at][g] * open * open;
{% endif %}
                *next++ = weight * (position - row[g]);
            }
        }
";

const RUST: &str = "
        if !started {
            (self.play_low[0], self.play_high[0]) = ([Real::INFINITY; GAUGES], [-Real::INFINITY; GAUGES]);
        }
        for ((low, high), gauge) in self.play_low[0].iter_mut().zip(&mut self.play_high[0]).zip(&row) {
            (*low, *high) = (low.min(*gauge), high.max(*gauge));
        }
        for (at, (position, radius)) in self.play.iter_mut().zip(&RADIUS).enumerate() {
            for g in 0..GAUGES {
                if !started {
                    position[g] = row[g];
                    self.play_weight[at][g] = -{{ most_rise }};
                }
                position[g] = position[g].min(row[g] + radius[g]).max(row[g] - radius[g]);
                let travel = self.play_high[0][g] - self.play_low[0][g];
                let open = 2.0 * radius[g] - travel;
                let weight = if open > 0.0 { (travel / radius[g] - 1.0).max(0.0) } else { 1.0 };
                let weight = weight.min(self.play_weight[at][g] + {{ most_rise }});
                self.play_weight[at][g] = weight;
                let open = open.max(radius[g] * (1.0 - weight));
                self.missing += PLAY_EFFECT[at][g] * open * open;
{% if fades %}
                self.unknown += PLAY_FADE[at][g] * open * open;
{% endif %}
                row[next + g] = weight * (position[g] - row[g]);
            }
            next += GAUGES;
        }
";

const PYTHON: &str = "
        if not started:
            self.play = np.tile(present, (len(RADIUS), 1))
            self.play_low = self.play_high = present
            self.play_weight = -{{ most_rise }}
        self.play_low = np.minimum(self.play_low, present)
        self.play_high = np.maximum(self.play_high, present)
        self.play = np.maximum(np.minimum(self.play, present + RADIUS), present - RADIUS)
        travel = self.play_high - self.play_low
        determined = np.clip(travel / np.maximum(RADIUS, np.finfo(float).tiny) - 1, 0, 1)
        self.play_weight = np.minimum(determined, self.play_weight + {{ most_rise }})
        open_range = np.maximum(2 * RADIUS - travel, RADIUS * (1 - self.play_weight))
        self.missing += np.sum(PLAY_EFFECT * open_range**2)
{% if fades %}
        self.unknown += np.sum(PLAY_FADE * open_range**2)
{% endif %}
        row.extend(self.play_weight * (self.play - present))
";

const MATLAB: &str = "
if ~started
    state.play_low(:, 1) = present;
    state.play_high(:, 1) = present;
end
state.play_low(:, 1) = min(state.play_low(:, 1), present);
state.play_high(:, 1) = max(state.play_high(:, 1), present);
for at = 1:{{ sets }}
    if ~started
        state.play(:, at) = present;
        state.play_weight(:, at) = -{{ most_rise }};
    end
    radius = c.radius(at, :)';
    state.play(:, at) = max(min(state.play(:, at), present + radius), present - radius);
    travel = state.play_high(:, 1) - state.play_low(:, 1);
    determined = min(max(travel ./ max(radius, realmin) - 1, 0), 1);
    state.play_weight(:, at) = min(determined, state.play_weight(:, at) + {{ most_rise }});
    open_range = max(2 * radius - travel, radius .* (1 - state.play_weight(:, at)));
    state.missing = state.missing + sum(c.play_effect(at, :)' .* open_range .^ 2);
{% if fades %}
    state.unknown = state.unknown + sum(c.play_fade(at, :)' .* open_range .^ 2);
{% endif %}
    row(next + (1:{{ n_gauges }})) = state.play_weight(:, at) .* (state.play(:, at) - present);
    next = next + {{ n_gauges }};
end
";

/// State of the play operators of all gauges and radii.
#[derive(Clone, Debug)]
struct Operators {
    /// Radii of the play in the unit of the gauge: one radius per gauge for each value of the setting.
    radii: Vec<f64>,
    /// Position of each play operator, in the order of the radii. Empty before the first sample.
    positions: Vec<f64>,
    /// Weight with which each position counts, see [`weight`].
    weights: Vec<f64>,
    /// Minimum and maximum of each gauge since the first sample.
    travel: Vec<[f64; 2]>,
}

impl Operators {
    /// Creates the play operators before the first sample. `deviations` are the standard deviations of the gauges.
    fn new(radii: &[f64], deviations: &[f64]) -> Self {
        Self {
            radii: radii
                .iter()
                .flat_map(|&radius| deviations.iter().map(move |deviation| radius * deviation))
                .collect(),
            positions: Vec::new(),
            weights: vec![-MOST_RISE; radii.len() * deviations.len()],
            travel: Vec::new(),
        }
    }
}

/// Returns the weight with which the position of a play operator may count after its gauge has covered this range: from 0 up to
/// the radius to 1 from twice the radius on.
fn weight([low, high]: [f64; 2], radius: f64) -> f64 {
    let travel = high - low;
    if travel < 2.0 * radius { (travel / radius - 1.0).max(0.0) } else { 1.0 }
}

impl Stream for Operators {
    fn step(&mut self, _time: f64, gauges: &[f64], _: &[f64], out: &mut [f64]) {
        if self.positions.is_empty() {
            self.positions = gauges.repeat(self.radii.len() / gauges.len());
            self.travel = gauges.iter().map(|gauge| [*gauge; 2]).collect();
        }
        for ([low, high], gauge) in self.travel.iter_mut().zip(gauges) {
            (*low, *high) = (low.min(*gauge), high.max(*gauge));
        }
        let n = gauges.len();
        let operators = self.positions.iter_mut().zip(&mut self.weights).zip(&self.radii);
        for (at, ((position, known), radius)) in operators.enumerate() {
            let gauge = gauges[at % n];
            *position = position.min(gauge + radius).max(gauge - radius);
            *known = weight(self.travel[at % n], *radius).min(*known + MOST_RISE);
            out[at] = gauge + *known * (*position - gauge);
        }
    }

    fn missing(&self, effects: &[f64]) -> f64 {
        let n = self.travel.len();
        let each = self.radii.iter().zip(effects).enumerate().map(|(at, (radius, effect))| {
            let [low, high] = if n > 0 { self.travel[at % n] } else { [0.0; 2] };
            let open = (2.0 * radius - (high - low)).max(radius * (1.0 - self.weights[at]));
            effect * open * open
        });
        each.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of samples within which a weight rises from 0 to 1.
    const RISES: usize = 35;

    /// Processes this gauge for as many samples as a weight needs to rise.
    fn rest(play: &mut Operators, gauge: f64) -> f64 {
        let mut out = [0.0];
        (0..RISES).for_each(|_| play.step(0.0, &[gauge], &[], &mut out));
        out[0]
    }

    fn positions(radius: f64, gauges: &[f64]) -> Vec<f64> {
        let mut play = Operators::new(&[radius], &[2.0]);
        gauges.iter().map(|gauge| rest(&mut play, *gauge)).collect()
    }

    /// The gauge jumps from 0 to 9 at the second sample, so its whole range is known at once.
    #[test]
    fn a_column_moves_slowly_to_a_position_that_is_known_at_once() {
        let mut play = Operators::new(&[0.5], &[2.0]);
        let mut out = [0.0];
        play.step(0.0, &[0.0], &[], &mut out);
        let mut last = 9.0;
        for k in 1..RISES {
            play.step(0.0, &[9.0], &[], &mut out);
            assert!((out[0] - (9.0 - (MOST_RISE * k as f64).min(1.0))).abs() < 1e-12, "{k}");
            assert_eq!(play.missing(&[1.0]) > 0.0, out[0] > 8.0);
            assert!(last - out[0] <= MOST_RISE + 1e-12);
            last = out[0];
        }
        assert_eq!(out[0], 8.0);
    }

    /// Radius 0.5 σ with σ = 2 is 1. The column equals the gauge until it has moved by 1, then half of the way to its position
    /// counts, and from a travel of 2 on the whole way. It follows one below the gauge up to 4, then waits until the gauge is one
    /// below.
    #[test]
    fn the_position_is_dragged_and_waits_after_a_reversal() {
        assert_eq!(
            positions(0.5, &[0.0, 0.5, 1.5, 2.0, 4.0, 3.5, 2.0, 1.0, 0.0]),
            [0.0, 0.5, 1.0, 1.0, 3.0, 3.0, 3.0, 2.0, 1.0]
        );
    }

    /// From a travel of 2 r on, a cold operator has the same position as an operator with a longer history. Up to there, its
    /// column moves by at most three times as much as its gauge.
    #[test]
    fn a_determined_position_does_not_depend_on_earlier_samples_and_a_column_never_jumps() {
        let gauge = |k: usize| 3.0 * (0.37 * k as f64).sin() + 2.0 * (0.11 * k as f64).cos();
        let all: Vec<f64> = (0..400).map(gauge).collect();
        for radius in [0.2, 0.8, 1.7, 4.0] {
            let warm = &positions(radius, &all)[200..];
            let cold = positions(radius, &all[200..]);
            let travel = |k: usize| {
                let so_far = all[200..=200 + k].iter().copied();
                so_far.clone().fold(f64::MIN, f64::max) - so_far.fold(f64::MAX, f64::min)
            };
            let first = (0..200).find(|k| travel(*k) >= 4.0 * radius).unwrap_or(200);
            assert_eq!(cold[first..], warm[first..], "{radius}");
            assert_eq!(first < 200, radius < 3.0);
            for (k, pair) in cold.windows(2).enumerate() {
                let moved = (all[201 + k] - all[200 + k]).abs();
                assert!((pair[1] - pair[0]).abs() <= 3.0 * moved + 1e-12, "{radius} {k}");
            }
        }
    }

    /// The position is anywhere in 2 r − t = 0.5, whose variance is 0.25 / 12.
    #[test]
    fn what_is_missing_follows_from_the_range_of_possible_positions() {
        let scale = GaugeScale { deviation: vec![2.0], travel: vec![1.5], ..GaugeScale::default() };
        let effects = Play.effects(&[0.5], &[9.0], &scale);
        let mut play = Operators::new(&[0.5], &scale.deviation);
        rest(&mut play, 0.0);
        assert!((play.missing(&effects) - 9.0 * 4.0 / 12.0).abs() < 1e-15);
        rest(&mut play, 1.5);
        let expected = 9.0 * 0.25 / 12.0;
        assert!((play.missing(&effects) - expected).abs() < 1e-15);
        assert!((Play.usually_missing(&[0.5], &effects, &scale) - expected).abs() < 1e-15);
        rest(&mut play, -0.5);
        assert_eq!(play.missing(&effects), 0.0);
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
