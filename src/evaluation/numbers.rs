//! Numbers as people read them.

/// `value` with this many significant digits, without an exponent where that stays short.
#[must_use]
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

/// The least of 1, 2, 2.5 and 5 times a power of ten that is not below `step`, which must be above zero.
#[must_use]
pub fn round_step(step: f64) -> f64 {
    let power = step.log10().floor() as i32;
    let candidates = (power..=power + 1).flat_map(|power| {
        [1.0, 2.0, 2.5, 5.0].map(|digit| {
            // Read, not multiplied: 5 · 10⁻² is not the number that 0.05 is.
            format!("{digit}e{power}").parse().unwrap_or(step)
        })
    });
    candidates
        .into_iter()
        .find(|candidate: &f64| *candidate >= step * (1.0 - 1e-9))
        .unwrap_or(step)
}

/// The least of 1, 2 and 5 times a power of ten that is at least this; `None` where there is none.
///
/// What the marks of an axis are apart.
#[must_use]
pub fn mark_step(least: f64) -> Option<f64> {
    let power = 10_f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|step| step * power);
    let found = steps.into_iter().find(|step| *step >= least);
    let step = found.unwrap_or(10.0 * power);
    (step.is_finite() && step > 0.0).then_some(step)
}

/// A multiple of `step` with as many decimals as the step needs.
#[must_use]
pub fn mark_label(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    // Adding zero turns −0 into 0.
    format!("{:.decimals$}", value + 0.0)
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
            (1.0, 1.0),
        ] {
            assert_eq!(round_step(step), expected, "{step}");
        }
    }

    #[test]
    fn marks_stand_at_ones_twos_and_fives() {
        assert_eq!(mark_step(0.03), Some(0.05));
        assert_eq!(mark_step(1.0), Some(1.0));
        assert_eq!(mark_step(6.0), Some(10.0));
        assert_eq!(mark_step(0.0), None);
        assert_eq!(mark_label(-0.0, 0.05), "0.00");
        assert_eq!(mark_label(20.0, 10.0), "20");
    }
}
