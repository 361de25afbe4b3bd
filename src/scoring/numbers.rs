//! Formats numbers for people, and chooses the ticks of plot axes.

/// Minimum number of ticks on a plot axis.
pub const FEWEST_TICKS: usize = 3;

/// Returns a share in percent as text with two significant digits.
pub(crate) fn percent(share: f64) -> String {
    percent_to(share, 2)
}

/// Returns a share in percent as text with this number of significant digits.
pub(crate) fn percent_to(share: f64, digits: usize) -> String {
    format!("{} %", significant(100.0 * share, digits))
}

/// Returns `value` as text with this number of significant digits. Very large and very small values have an exponent.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..7.0).contains(&magnitude) {
        return format!("{value:.*e}", digits.saturating_sub(1));
    }
    let decimals = (digits as f64 - 1.0 - magnitude).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// Returns the length of a file as text, with its unit.
pub fn file_size(bytes: u64) -> String {
    match bytes {
        0..1000 => format!("{bytes} B"),
        1000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

/// Returns the smallest number of at least `value` that is one of the `digits` (ascending, from 1 to below 10) times a power
/// of ten. `value` must be above zero.
pub fn round_above(value: f64, digits: &[f64]) -> f64 {
    let power = value.log10().floor() as i32;
    let candidates = (power..=power + 1).flat_map(|power| {
        // The number is parsed from text, because the product 5 · 10⁻² differs from 0.05 in the last digit.
        digits.iter().map(move |digit| format!("{digit}e{power}").parse().unwrap_or(value))
    });
    let mut candidates = candidates.filter(|candidate: &f64| *candidate >= value * (1.0 - 1e-9));
    candidates.next().unwrap_or(value)
}

/// Returns the smallest number of at least `step` that is 1, 2, 2.5 or 5 times a power of ten. `step` must be above zero.
pub fn round_step(step: f64) -> f64 {
    round_above(step, &[1.0, 2.0, 2.5, 5.0])
}

/// Returns the number of decimals with which a number is written exactly.
pub fn decimals(value: f64) -> usize {
    let text = value.to_string();
    text.split_once('.').map_or(0, |(_, after)| after.len())
}

/// Returns the distance between the ticks of a plot axis, and the ticks within its range. The distance is a [`round_step`] of
/// at least `least`. If `least` is not positive and finite, the distance is zero and there are no ticks.
pub fn ticks((low, high): (f64, f64), least: f64) -> (f64, Vec<f64>) {
    if !(least > 0.0 && least.is_finite()) {
        return (0.0, Vec::new());
    }
    let step = round_step(least);
    (step, multiples((low, high), step))
}

/// Returns the ticks of [`ticks`]. If fewer than three of them are within the range, it returns closer ticks, which are at
/// least `closest` apart.
pub fn three_ticks((low, high): (f64, f64), least: f64, closest: f64) -> (f64, Vec<f64>) {
    let coarse = ticks((low, high), least);
    if coarse.1.len() >= FEWEST_TICKS || !(coarse.0 > 0.0 && closest > 0.0) {
        return coarse;
    }
    let power = coarse.0.log10().floor() as i32;
    let steps = (power - 2..=power).rev().flat_map(|power| {
        let digits = [8.0, 6.0, 5.0, 4.0, 3.0, 2.5, 2.0, 1.5, 1.2, 1.0];
        digits.map(|digit| format!("{digit}e{power}").parse().unwrap_or(coarse.0))
    });
    let mut steps = steps.filter(|step: &f64| *step < coarse.0 && *step >= closest);
    let finer = steps.find_map(|step| {
        let values = multiples((low, high), step);
        (values.len() >= FEWEST_TICKS).then_some((step, values))
    });
    finer.unwrap_or(coarse)
}

fn multiples((low, high): (f64, f64), step: f64) -> Vec<f64> {
    // The range is slightly widened, so that rounding does not drop a tick at its end.
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|at| at as f64 * step).collect()
}

/// Returns a tick as text with as many decimals as `step` has.
pub fn tick_text(tick: f64, step: f64) -> String {
    // A rounding error near zero is written as 0 without a sign.
    let tick = if tick.abs() < step / 2.0 { 0.0 } else { tick };
    if (1e-6..1e7).contains(&step) {
        format!("{tick:.*}", decimals(step))
    } else {
        significant(tick, 3)
    }
}

/// Returns a sample rate in words. `rate_hz` is the inverse of the median time step. If pauses make the mean rate differ from
/// it by 5 % or more, both rates are given.
pub fn rate_in_words(rate_hz: Option<f64>, n_samples: usize, duration_secs: f64) -> Option<String> {
    let rate_hz = rate_hz?;
    let mean_hz = n_samples.saturating_sub(1) as f64 / duration_secs;
    let [rate, mean] = [rate_hz, mean_hz].map(|rate| significant(rate, 3));
    Some(if (mean_hz / rate_hz - 1.0).abs() < 0.05 {
        format!("{rate} Hz")
    } else {
        format!("{rate} Hz in bursts, {mean} Hz on average")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_count_from_the_first_that_is_not_zero() {
        assert_eq!(significant(2.5432, 4), "2.543");
        assert_eq!(significant(-0.012_345, 3), "-0.0123");
        assert_eq!(significant(123_456.0, 3), "123456");
        assert_eq!(significant(1.5e-9, 3), "1.50e-9");
        assert_eq!(significant(0.0, 3), "0");
    }

    #[test]
    fn round_steps_are_those_that_people_count_in() {
        for (step, expected) in [
            (0.3, 0.5),
            (0.5, 0.5),
            (2.1, 2.5),
            (6.0, 10.0),
            (0.026, 0.05),
            (0.03, 0.05),
            (1.0, 1.0),
        ] {
            assert_eq!(round_step(step), expected, "{step}");
        }
    }

    /// On an axis of 50 points, labels are 24 points apart if possible, and at least 11.
    #[test]
    fn a_short_axis_has_three_ticks_too() {
        for at in 0..2000 {
            let low = f64::from(at) * 0.0137 - 3.0;
            for size in [0.011, 0.7, 1.0, 1.9, 3.3, 8.0, 97.0] {
                let point = size / 50.0;
                let range = (low * size, low * size + size);
                let (step, values) = three_ticks(range, 24.0 * point, 11.0 * point);
                assert!(values.len() >= 3, "{range:?}: {values:?}");
                assert!(step >= 11.0 * point);
                let texts: Vec<String> = values.iter().map(|at| tick_text(*at, step)).collect();
                assert!(texts.windows(2).all(|pair| pair[0] != pair[1]), "{texts:?}");
            }
        }
        let roomy = three_ticks((0.0, 14.0), 2.0, 0.5);
        assert_eq!(roomy, ticks((0.0, 14.0), 2.0));
    }

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let texts = |range: (f64, f64), most: f64| -> Vec<String> {
            let (step, ticks) = ticks(range, (range.1 - range.0) / most);
            ticks.iter().map(|tick| tick_text(*tick, step)).collect()
        };
        let expected = ["0.0", "2.5", "5.0", "7.5", "10.0", "12.5"];
        assert_eq!(texts((0.0, 14.0), 6.0), expected);
        assert_eq!(texts((-0.1, 0.1), 6.0).len(), 5);
        assert_eq!(texts((-0.1, 0.1), 6.0)[2], "0.00");
        assert_eq!(texts((0.0, 0.3), 3.0), ["0.0", "0.1", "0.2", "0.3"]);
        assert!(texts((-1e300, 1e300), 6.0).len() > 2);
        assert!(ticks((0.0, 0.0), 0.0).1.is_empty());
        assert_eq!(tick_text(-0.0, 0.05), "0.00");
        assert_eq!(tick_text(20.0, 10.0), "20");
    }

    #[test]
    fn a_length_is_shown_in_few_digits() {
        assert_eq!([999, 1500, 2_500_000].map(file_size), ["999 B", "1.5 kB", "2.5 MB"]);
    }
}
