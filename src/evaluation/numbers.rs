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
}
