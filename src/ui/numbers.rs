//! Numbers as people read them.

/// `value` with this many significant digits, without an exponent where that stays short.
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

/// A change in percent, signed; a dash where it says nothing.
pub fn percent(change: Option<f64>) -> String {
    change.map_or_else(|| "–".to_owned(), |change| format!("{change:+.1} %"))
}

/// A span of time, as coarse as one waits for it.
pub fn duration(span: std::time::Duration) -> String {
    let seconds = span.as_secs_f64().ceil() as u64;
    match seconds {
        0..=99 => format!("{seconds} s"),
        100..=5999 => format!("{} min", seconds.div_ceil(60)),
        _ => format!("{:.1} h", seconds as f64 / 3600.0),
    }
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
