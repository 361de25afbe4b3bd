/// Returns the upper median, or `None` without values.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// Returns the standard deviation of white noise in a smooth signal.
pub(crate) fn white_noise(values: &[f64]) -> f64 {
    let bends = values.windows(3).map(|own| (own[0] - 2.0 * own[1] + own[2]).abs());
    // The median magnitude of a normal distribution is 0.6745 of its deviation. A bend has six times a sample's variance.
    median(bends).unwrap_or(0.0) / (0.6745 * 6.0_f64.sqrt())
}
