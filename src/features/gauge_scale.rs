//! Shift and scale of each gauge over the training recordings.
//!
//! Guarantees: a gauge that never changes gets inverse scale zero when it is shifted, so its column vanishes instead
//! of blowing up rounding errors.

use crate::recording::Recording;

/// A spread below this share of the largest value is rounding, not signal.
const CONSTANT_BELOW: f64 = 1e-13;

/// How gauges are standardised: `z = (s − shift) · inverse_scale`.
///
/// **Shapes** `n_gauges` each.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugeScale {
    /// Mean of each gauge, or zero where the model has no offset to take the mean up.
    pub shift: Vec<f64>,
    /// One over the standard deviation (without offset: over the root mean square); zero for a constant gauge.
    pub inverse_scale: Vec<f64>,
}

impl GaugeScale {
    /// Measures the gauges of `recordings`; with `centred` false the shift stays zero.
    #[must_use]
    pub fn measure<'a>(
        recordings: impl Iterator<Item = &'a Recording> + Clone,
        n_gauges: usize,
        centred: bool,
    ) -> Self {
        let n: usize = recordings.clone().map(Recording::n_samples).sum();
        let n = n.max(1) as f64;
        let rows = || {
            recordings
                .clone()
                .flat_map(|recording| recording.gauges().chunks_exact(n_gauges))
        };
        let mut shift = vec![0.0; n_gauges];
        if centred {
            for row in rows() {
                for (sum, value) in shift.iter_mut().zip(row) {
                    *sum += value;
                }
            }
            for sum in &mut shift {
                *sum /= n;
            }
        }
        let mut squares = vec![0.0; n_gauges];
        let mut largest = vec![0.0_f64; n_gauges];
        for row in rows() {
            for (gauge, value) in row.iter().enumerate() {
                squares[gauge] += (value - shift[gauge]).powi(2);
                largest[gauge] = largest[gauge].max(value.abs());
            }
        }
        let inverse_scale = squares
            .iter()
            .zip(&largest)
            .map(|(square, largest)| {
                let spread = (square / n).sqrt();
                if spread > CONSTANT_BELOW * largest {
                    1.0 / spread
                } else {
                    0.0
                }
            })
            .collect();
        Self {
            shift,
            inverse_scale,
        }
    }

    /// Writes the standardised gauges of one sample.
    #[inline(always)]
    pub fn apply(&self, gauges: &[f64], out: &mut [f64]) {
        for (((out, gauge), shift), inverse_scale) in out
            .iter_mut()
            .zip(gauges)
            .zip(&self.shift)
            .zip(&self.inverse_scale)
        {
            *out = (gauge - shift) * inverse_scale;
        }
    }
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
