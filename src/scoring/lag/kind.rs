//! Delays a signal by a fixed time, or filters it by a first-order low-pass.
//!
//! Guarantees: the result is finite for finite samples whose times do not decrease. A signal that is a straight line stays a
//! straight line, except shortly after its start.

use serde::Serialize;

use crate::dot::dot;

/// Kind of the lag of a signal behind the reference load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LagKind {
    /// Delay of the whole signal, such as a clock offset, a late time stamp or a transport delay.
    Delay,
    /// First-order low-pass, such as an amplifier or a filter.
    FirstOrder,
}

impl LagKind {
    /// Returns the name of this kind of lag, as reports show it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::FirstOrder => "first-order time constant",
        }
    }

    /// Returns the signal after a delay of `seconds`, or after a low-pass with this time constant. A delay may be negative.
    ///
    /// A delayed signal is interpolated by cubic polynomials through four samples. The low-pass treats the signal as a
    /// straight line between two samples. Before its first sample, a signal counts as constant.
    pub fn late(self, times: &[f64], values: &[f64], seconds: f64) -> Vec<f64> {
        match self {
            _ if seconds == 0.0 => values.to_vec(),
            Self::Delay => {
                delay(times, seconds).map(|weights| interpolated(&weights, values)).collect()
            }
            Self::FirstOrder => {
                let weights = low_pass(times[0], times, seconds);
                filtered(&mut (values[0], values[0]), weights, values)
            }
        }
    }
}

/// Appends rows of several signals, late by `seconds`, to `late`. `rows` is row-major with one row for each time. Only the
/// first `n` signals, and only the rows with `used`, are appended.
pub fn add_late_rows(
    kind: LagKind,
    seconds: f64,
    (times, used): (&[f64], &[bool]),
    (rows, n): (&[f64], usize),
    late: &mut Vec<f64>,
) {
    let width = rows.len() / times.len();
    let row = |k: usize| &rows[k * width..k * width + n];
    let used = || used.iter().copied();
    if seconds == 0.0 {
        let all = used().enumerate().filter(|(_, used)| *used);
        return all.for_each(|(k, _)| late.extend_from_slice(row(k)));
    }
    match kind {
        LagKind::Delay => {
            for ((first, weights), used) in delay(times, seconds).zip(used()) {
                if used && first + 4 <= times.len() {
                    let near = &rows[first * width..(first + 4) * width];
                    let [a, b, c, d] = [0, 1, 2, 3].map(|at| &near[at * width..at * width + n]);
                    let signals = a.iter().zip(b).zip(c).zip(d);
                    late.extend(signals.map(|(((a, b), c), d)| {
                        weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d
                    }));
                } else if used {
                    let near = || weights.iter().zip(first..times.len());
                    late.extend(
                        (0..n).map(|at| -> f64 {
                            near().map(|(weight, k)| weight * row(k)[at]).sum()
                        }),
                    );
                }
            }
        }
        LagKind::FirstOrder => {
            let (mut states, mut before) = (row(0).to_vec(), row(0));
            let weights = low_pass(times[0], times, seconds);
            for ((k, [kept, start, end]), used) in weights.enumerate().zip(used()) {
                let values = row(k);
                for ((state, before), value) in states.iter_mut().zip(before).zip(values) {
                    *state = kept * *state + start * before + end * value;
                }
                before = values;
                if used {
                    late.extend_from_slice(&states);
                }
            }
        }
    }
}

fn interpolated((first, weights): &(usize, [f64; 4]), values: &[f64]) -> f64 {
    match values.get(*first..first + 4) {
        Some([a, b, c, d]) => weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d,
        _ => dot(weights, &values[*first..]),
    }
}

/// Filters values by a low-pass with these weights: of the filter's previous result, of the previous value and of the present
/// value. The state is the previous result and the previous value.
pub fn filtered(
    (state, before): &mut (f64, f64),
    weights: impl Iterator<Item = [f64; 3]>,
    values: &[f64],
) -> Vec<f64> {
    let step = |([kept, start, end], value): ([f64; 3], &f64)| {
        *state = kept * *state + start * *before + end * value;
        *before = *value;
        *state
    };
    weights.zip(values).map(step).collect()
}

fn delay(times: &[f64], seconds: f64) -> impl Iterator<Item = (usize, [f64; 4])> {
    let last = times.len() - 1;
    let mut next = 0;
    times.iter().map(move |time| {
        let wanted = time - seconds;
        while next <= last && times[next] <= wanted {
            next += 1;
        }
        match next {
            0 => (0, [1.0, 0.0, 0.0, 0.0]),
            _ if next > last => (last, [1.0, 0.0, 0.0, 0.0]),
            _ => between(times, next, wanted),
        }
    })
}

/// Returns weights that interpolate at the time `wanted` between the samples `next - 1` and `next`, after the index of the
/// first weighted sample. The interpolation is cubic if two samples with different times lie on each side, else linear.
fn between(times: &[f64], next: usize, wanted: f64) -> (usize, [f64; 4]) {
    let around = next.checked_sub(2).filter(|_| next + 1 < times.len());
    if let Some(first) = around
        && let Some([a, b, c, d]) = times.get(first..first + 4)
        && a < b
        && b < c
        && c < d
    {
        // Lagrange's polynomials, each with one division.
        let [wa, wb, wc, wd] = [a, b, c, d].map(|time| wanted - time);
        let above = [wb * wc * wd, wa * wc * wd, wa * wb * wd, wa * wb * wc];
        let below = [
            (a - b) * (a - c) * (a - d),
            (b - a) * (b - c) * (b - d),
            (c - a) * (c - b) * (c - d),
            (d - a) * (d - b) * (d - c),
        ];
        return (first, std::array::from_fn(|at| above[at] / below[at]));
    }
    let (before, after) = (times[next - 1], times[next]);
    let share = if after > before { (wanted - before) / (after - before) } else { 1.0 };
    (next - 1, [1.0 - share, share, 0.0, 0.0])
}

/// Returns the weights of a low-pass at these times; see [`filtered`]. `before` is the time of the previous sample.
pub fn low_pass(mut before: f64, times: &[f64], tau: f64) -> impl Iterator<Item = [f64; 3]> {
    times.iter().map(move |time| {
        let steps = (time - std::mem::replace(&mut before, *time)) / tau;
        if steps > 0.0 {
            let kept = (-steps).exp();
            // The weights of the low-pass are exact for a signal that is a straight line between two samples.
            let start = -(-steps).exp_m1() / steps;
            [kept, start - kept, 1.0 - start]
        } else {
            [1.0, 0.0, 0.0]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of 1 per second is late by the lag, with a delay and with a settled low-pass.
    #[test]
    fn a_ramp_is_late_by_the_lag() {
        let times: Vec<f64> =
            (0..400).map(|k| 0.01 * f64::from(k) + 1e-3 * (f64::from(k)).sin()).collect();
        for kind in [LagKind::Delay, LagKind::FirstOrder] {
            for seconds in [0.003, 0.034, 0.05] {
                let late = kind.late(&times, &times, seconds);
                for k in 200..400 {
                    assert!((times[k] - late[k] - seconds).abs() < 1e-9, "{kind:?} {seconds}");
                }
            }
        }
        let early = LagKind::Delay.late(&times, &times, -0.021);
        assert!((early[100] - times[100] - 0.021).abs() < 1e-12);
    }

    /// For a sine of 1 Hz at 100 Hz, the cubic errs by less than 1e-6, and the low-pass has its known gain and phase.
    #[test]
    fn a_sine_has_its_known_phase() {
        let times: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let omega = std::f64::consts::TAU;
        let sine: Vec<f64> = times.iter().map(|t| (omega * t).sin()).collect();
        let delayed = LagKind::Delay.late(&times, &sine, 0.0234);
        let passed = LagKind::FirstOrder.late(&times, &sine, 0.05);
        let phase = (omega * 0.05_f64).atan();
        for k in 500..999 {
            assert!((delayed[k] - (omega * (times[k] - 0.0234)).sin()).abs() < 1e-6);
            let expected = phase.cos() * (omega * times[k] - phase).sin();
            assert!((passed[k] - expected).abs() < 1e-3);
        }
    }

    #[test]
    fn repeated_times_and_single_samples_stay_finite() {
        for kind in [LagKind::Delay, LagKind::FirstOrder] {
            let late = kind.late(&[0.0, 0.0, 0.1, 0.1], &[1.0, 2.0, 3.0, 4.0], 0.05);
            assert!(late.iter().all(|value| value.is_finite()));
            assert_eq!(kind.late(&[3.0], &[7.0], 0.1), [7.0]);
        }
    }
}
