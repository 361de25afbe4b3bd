/// Returns the median of the values; `None` if there are none. For an even number of values, it is the larger of the two
/// middle values.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// Maximum number of second differences from which the noise of a signal is computed. Of a longer signal, evenly spread
/// differences are used, which determine the noise to 0.5 %.
const MAX_BENDS: usize = 1 << 17;

/// Returns the standard deviation of the white noise in a signal that is otherwise smooth.
pub(crate) fn white_noise(values: &[f64]) -> f64 {
    white_noise_by(values.len(), |k| &values[k..k + 3])
}

/// Returns the standard deviation of the white noise in a smooth signal of `n` samples. `three` returns the values of three
/// successive samples, from the sample with this index.
pub(crate) fn white_noise_by<V: AsRef<[f64]>>(n: usize, three: impl Fn(usize) -> V) -> f64 {
    let step = n.div_ceil(MAX_BENDS).max(1);
    let bends = (0..n.saturating_sub(2)).step_by(step).map(|k| {
        let three = three(k);
        let three = three.as_ref();
        (three[0] - 2.0 * three[1] + three[2]).abs()
    });
    // In a smooth signal, second differences contain only noise. The median magnitude of normal noise is 0.6745 standard
    // deviations, and the variance of a second difference is six times that of the noise.
    median(bends).unwrap_or(0.0) / (0.6745 * 6.0_f64.sqrt())
}
