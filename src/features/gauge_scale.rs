//! Standardisation of gauges: shift, scale and standard deviation of each gauge over the training recordings. If the shift is
//! the mean, a gauge that never changes gets the inverse scale zero, so that its rounding errors are not amplified.

use serde::{Deserialize, Serialize};

use crate::{
    lanes,
    min_max::MinMax,
    recording::{Recording, median},
};

/// Minimum standard deviation of a gauge, as a share of its largest absolute value. A smaller deviation is rounding noise,
/// and the gauge counts as constant.
const CONSTANT_BELOW: f64 = 1e-13;
/// Maximum number of samples of which the median travel is taken.
const MOST_TRAVELS: usize = 200_000;

/// Standardisation of each gauge: `z = (s − shift) · inverse_scale`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GaugeScale {
    /// Mean of each gauge over the training recordings, or zero if the model has no offset.
    pub shift: Vec<f64>,
    /// Inverse of each gauge's standard deviation, or of its root mean square if the model has no offset. Zero for a constant
    /// gauge.
    pub inverse_scale: Vec<f64>,
    /// Standard deviation of each gauge over the training recordings, also if the shift is zero. The radii of play operators
    /// are multiples of this deviation.
    pub deviation: Vec<f64>,
    /// Range that each gauge has covered since the start of its recording in half of the training samples; empty if unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub travel: Vec<f64>,
    /// Time since the start of the recording in half of the training samples (s); `None` if unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run_secs: Option<f64>,
}

impl GaugeScale {
    /// Writes `(value − zero) · inverse_scale` for each gauge to `out`. `zero` holds the shift or, if `values` are past gauge
    /// values, the present gauges.
    #[inline(always)]
    pub(super) fn relative(&self, values: &[f64], zero: &[f64], out: &mut [f64]) {
        lanes::write(out, [values, zero, &self.inverse_scale], |[value, zero, factor]| {
            (value - zero) * factor
        });
    }

    /// Replaces `values` by `(value − zero) · inverse_scale`, as [`Self::relative`] computes it.
    #[inline(always)]
    pub(super) fn make_relative(&self, values: &mut [f64], zero: &[f64]) {
        for ((value, zero), factor) in values.iter_mut().zip(zero).zip(&self.inverse_scale) {
            *value = (*value - zero) * factor;
        }
    }

    /// Determines the scale of the gauges from `recordings`. The shift is the mean of each gauge, or zero if `centred` is
    /// false.
    pub fn measure<'a>(
        recordings: impl Iterator<Item = &'a Recording> + Clone,
        n_gauges: usize,
        centred: bool,
    ) -> Self {
        let n: usize = recordings.clone().map(Recording::n_samples).sum();
        let n = n.max(1) as f64;
        let rows =
            || recordings.clone().flat_map(|recording| recording.gauges().chunks_exact(n_gauges));
        let mut mean = vec![0.0; n_gauges];
        for row in rows() {
            for (sum, value) in mean.iter_mut().zip(row) {
                *sum += value;
            }
        }
        for sum in &mut mean {
            *sum /= n;
        }
        let mut squares = vec![0.0; n_gauges];
        let mut largest = vec![0.0_f64; n_gauges];
        for row in rows() {
            for (gauge, value) in row.iter().enumerate() {
                squares[gauge] += (value - mean[gauge]).powi(2);
                largest[gauge] = largest[gauge].max(value.abs());
            }
        }
        let deviation: Vec<f64> = squares
            .iter()
            .zip(&largest)
            .map(|(square, largest)| {
                let spread = (square / n).sqrt();
                if spread > CONSTANT_BELOW * largest { spread } else { 0.0 }
            })
            .collect();
        let inverse = |size: f64| if size > 0.0 { 1.0 / size } else { 0.0 };
        let (shift, inverse_scale) = if centred {
            let inverse_scale = deviation.iter().map(|size| inverse(*size)).collect();
            (mean, inverse_scale)
        } else {
            let root_mean_squares = deviation.iter().zip(&mean).map(|(d, mean)| d.hypot(*mean));
            (vec![0.0; n_gauges], root_mean_squares.map(inverse).collect())
        };
        let (travel, run_secs) = usual_runs(recordings, n_gauges);
        Self { shift, inverse_scale, deviation, travel, run_secs }
    }

    /// Returns the inverse of a gauge's standard deviation; zero for a constant gauge.
    pub(crate) fn inverse_deviation(&self, gauge: usize) -> f64 {
        let deviation = self.deviation[gauge];
        if deviation > 0.0 { deviation.recip() } else { 0.0 }
    }

    /// Returns the scale that leaves gauges unchanged: shift zero, inverse scale one.
    pub fn identity(n_gauges: usize) -> Self {
        Self {
            shift: vec![0.0; n_gauges],
            inverse_scale: vec![1.0; n_gauges],
            deviation: vec![1.0; n_gauges],
            ..Self::default()
        }
    }

    #[inline(always)]
    pub fn apply(&self, gauges: &[f64], out: &mut [f64]) {
        self.relative(gauges, &self.shift, out);
    }
}

/// Returns the medians, over the samples of all recordings, of the range that each gauge has covered since the start of its
/// recording, and of the time since then (s).
fn usual_runs<'a>(
    recordings: impl Iterator<Item = &'a Recording> + Clone,
    n_gauges: usize,
) -> (Vec<f64>, Option<f64>) {
    let n: usize = recordings.clone().map(Recording::n_samples).sum();
    let step = n.div_ceil(MOST_TRAVELS).max(1);
    let (mut travels, mut elapsed) = (vec![Vec::new(); n_gauges], Vec::new());
    let mut count = 0;
    for recording in recordings {
        let mut ranges = vec![MinMax::NONE; n_gauges];
        for (row, time) in recording.gauges().chunks_exact(n_gauges).zip(recording.times()) {
            for (range, value) in ranges.iter_mut().zip(row) {
                *range = range.with(*value);
            }
            if count % step == 0 {
                elapsed.push(time - recording.times()[0]);
                for (travels, range) in travels.iter_mut().zip(&ranges) {
                    travels.push(range.span());
                }
            }
            count += 1;
        }
    }
    let travels = travels.into_iter().map(|travels| median(travels.into_iter()).unwrap_or(0.0));
    (travels.collect(), median(elapsed.into_iter()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Source;

    fn two_gauges(values: &[(f64, f64)]) -> Recording {
        Recording::new(
            "two",
            Source::Simulated,
            (0..values.len()).map(|k| k as f64).collect(),
            vec!["S1".into(), "S2".into()],
            values.iter().flat_map(|&(a, b)| [a, b]).collect(),
            vec![],
            vec![],
        )
        .unwrap()
    }

    #[test]
    fn standardised_gauges_have_mean_zero_and_deviation_one() {
        let recording = two_gauges(&[(1.0, 10.0), (3.0, 30.0)]);
        let scale = GaugeScale::measure([&recording].into_iter(), 2, true);
        let mut z = [0.0; 2];
        scale.apply(&[3.0, 10.0], &mut z);
        assert_eq!(z, [1.0, -1.0]);
    }

    #[test]
    fn a_constant_gauge_vanishes_when_centred_and_stays_without_offset() {
        let recording = two_gauges(&[(0.1, 1.0), (0.1, 2.0), (0.1, 4.0)]);
        let centred = GaugeScale::measure([&recording].into_iter(), 2, true);
        assert_eq!(centred.inverse_scale[0], 0.0);
        let raw = GaugeScale::measure([&recording].into_iter(), 2, false);
        assert!((raw.inverse_scale[0] - 10.0).abs() < 1e-12);
        assert_eq!(raw.shift, [0.0, 0.0]);
    }
}
