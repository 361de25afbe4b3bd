//! Quantiles of a list of numbers.

/// Returns the smallest value that at least a `share` of the values do not exceed; `None` without values. A share of 0.5 gives
/// the lower median, a share of 1 the maximum. The values are reordered.
pub fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let rank = (share * values.len() as f64).ceil() as usize; // NaN and negative numbers become 0
    let at = rank.saturating_sub(1).min(last);
    let (_, value, _) = values.select_nth_unstable_by(at, f64::total_cmp);
    Some(*value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_values_as_the_share_asks_do_not_exceed_it() {
        let twenty = || (1..=20).rev().map(f64::from).collect::<Vec<_>>();
        for (share, expected) in [(0.95, 19.0), (0.951, 20.0), (0.5, 10.0), (0.0, 1.0), (1.0, 20.0)]
        {
            assert_eq!(quantile(&mut twenty(), share), Some(expected), "{share}");
        }
        assert_eq!(quantile(&mut [], 0.5), None);
    }
}
