//! Gauges that stand at an end of their range while the load goes on.

use crate::evaluation::coverage::largest;
use crate::recording::{Axis, Recording};

/// So many samples in a hundred stand at an end before it is one.
const SHARE_AT_END: f64 = 0.01;
/// And so many times as many as at the value next to it: a converter with few steps has many at each.
const PILE: usize = 5;
/// And the load moves by this share of the range of its unit meanwhile: what is not loaded stands still, too.
const LOAD_MOVES: f64 = 0.1;

/// A gauge at an end of its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Saturated {
    /// Which.
    pub gauge: usize,
    /// The value that it does not leave.
    pub value: f64,
    /// Whether it is the greatest.
    pub at_top: bool,
    /// The share of the samples.
    pub share: f64,
}

/// The gauges that stand at an end, and the share of the samples in which any does.
///
/// **Shapes** `spans` says how far the load of each axis moves.
pub fn saturated(recordings: &[&Recording], axes: &[Axis], spans: &[f64]) -> (Vec<Saturated>, f64) {
    let n: usize = recordings.iter().map(|own| own.n_samples()).sum();
    let n_gauges = recordings.first().map_or(0, |own| own.n_gauges());
    let mut found = Vec::new();
    for gauge in 0..n_gauges {
        // From the top, then from the bottom: the end, the value next to it, and how many there are of each.
        for sign in [1.0, -1.0] {
            let (mut end, mut next) = ((f64::NEG_INFINITY, 0), (f64::NEG_INFINITY, 0));
            for own in recordings {
                let values = own.gauges()[gauge..].iter().step_by(n_gauges);
                for value in values.map(|value| sign * value) {
                    if value > end.0 {
                        (end, next) = ((value, 1), end);
                    } else if value == end.0 {
                        end.1 += 1;
                    } else if value > next.0 {
                        next = (value, 1);
                    } else if value == next.0 {
                        next.1 += 1;
                    }
                }
            }
            let share = end.1 as f64 / n.max(1) as f64;
            let piles = next.1 > 0 && end.1 > PILE * next.1 && end.1 > PILE;
            if !piles || share < SHARE_AT_END {
                continue;
            }
            let one = Saturated {
                gauge,
                value: sign * end.0,
                at_top: sign > 0.0,
                share,
            };
            if load_moves(recordings, axes, spans, &one) {
                found.push(one);
            }
        }
    }
    let is_at_end = |gauges: &[f64]| found.iter().any(|one| gauges[one.gauge] == one.value);
    let rows = recordings
        .iter()
        .flat_map(|own| own.gauges().chunks_exact(n_gauges.max(1)));
    let n_rows = if found.is_empty() {
        0
    } else {
        rows.filter(|row| is_at_end(row)).count()
    };
    (found, n_rows as f64 / n.max(1) as f64)
}

/// Whether the load moves while the gauge stands at its end.
fn load_moves(recordings: &[&Recording], axes: &[Axis], spans: &[f64], one: &Saturated) -> bool {
    let mut reached = vec![(f64::INFINITY, f64::NEG_INFINITY); axes.len()];
    for own in recordings {
        let loads = own.loads().chunks_exact(axes.len().max(1));
        for (load, gauges) in loads.zip(own.gauges().chunks_exact(own.n_gauges())) {
            if gauges[one.gauge] == one.value {
                for (range, load) in reached.iter_mut().zip(load) {
                    *range = (range.0.min(*load), range.1.max(*load));
                }
            }
        }
    }
    let moves = |((low, high), axis): (&(f64, f64), &Axis)| {
        high - low > LOAD_MOVES * largest(axes, spans, *axis)
    };
    reached.iter().zip(axes).any(moves)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Source;

    fn found(gauge: impl Fn(f64) -> f64) -> (Vec<Saturated>, f64) {
        let loads: Vec<f64> = (0..1000)
            .map(|k| (10.0 * (0.05 * f64::from(k)).sin()).max(0.0))
            .collect();
        let recording = Recording::new(
            "r",
            Source::Simulated,
            (0..1000).map(f64::from).collect(),
            vec!["S1".to_owned()],
            loads.iter().map(|load| gauge(*load)).collect(),
            vec![Axis::Fz],
            loads.clone(),
        );
        saturated(&[&recording.unwrap()], &[Axis::Fz], &[10.0])
    }

    #[test]
    fn a_gauge_that_is_clipped_is_found_and_one_that_rests_or_has_few_steps_is_not() {
        let (clipped, share) = found(|load| load.min(8.0));
        assert_eq!(
            (clipped[0].value, clipped[0].at_top, clipped.len()),
            (8.0, true, 1)
        );
        assert!((share - 0.2).abs() < 0.02, "{share}");
        assert_eq!(
            found(|load| load).0,
            [],
            "half of the time nothing is loaded"
        );
        assert_eq!(found(|load| load.round()).0, []);
        assert_eq!(found(|_| 3.0).0, [], "a dead gauge is another matter");
        let (deaf, _) = found(|load| (load - 4.0).max(0.0));
        assert!(!deaf[0].at_top);
    }
}
