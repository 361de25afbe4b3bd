//! Settings of the metrology figures, and their defaults.

use serde::{Deserialize, Serialize};

use crate::{
    progress::Cancelled,
    recording::Axis,
    scoring::loops::{LoadExtent, NOISE_FACTOR},
};

/// Settings of the metrology table.
///
/// | field | default | range | meaning |
/// |---|---|---|---|
/// | `reversal_thresholds` | none | ≥ 0 | reversal threshold per axis, in its unit; `None` computes it from noise and range |
/// | `hold_secs` | 5 s | > 0 | shortest dwell |
/// | `still_share` | 0.01 | 0 to 1 | in a dwell each axis stays within this share of its full scale, or ten times its noise |
/// | `zero_share` | 0.01 | 0 to 1 | at zero each axis is within this share of its full scale from zero |
/// | `loaded_share` | 0.5 | 0 to 1 | an axis counts as loaded from this share of its full scale |
/// | `alone_share` | 0.02 | 0 to 1 | an axis is loaded alone if all other axes are within this share of their full scales |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MetrologySettings {
    /// Reversal threshold per axis, in axis order: the smallest change of load that counts as a reversal. Missing entries and
    /// `None` are computed from noise and range of the load ([`LoadExtent`]).
    #[serde(alias = "dead_bands")]
    pub reversal_thresholds: Vec<Option<f64>>,
    /// Shortest dwell (s).
    pub hold_secs: f64,
    /// Largest movement of a load that still counts as a dwell, as a share of full scale.
    pub still_share: f64,
    /// Largest load of an axis that counts as zero, as a share of full scale.
    pub zero_share: f64,
    /// Smallest load at which an axis counts as loaded, as a share of full scale.
    pub loaded_share: f64,
    /// Largest load of an axis that counts as unloaded while another axis is loaded alone, as a share of full scale.
    pub alone_share: f64,
}

impl Default for MetrologySettings {
    fn default() -> Self {
        Self {
            reversal_thresholds: Vec::new(),
            hold_secs: 5.0,
            still_share: 0.01,
            zero_share: 0.01,
            loaded_share: 0.5,
            alone_share: 0.02,
        }
    }
}

/// Rules that define loops, dwells and figures.
///
/// **Shapes** one full scale and one extent (noise and range of the load) per axis.
///
/// **Units** full scales in N and N·m; 0 if there is none.
#[derive(Clone, Copy, Debug)]
pub struct Rules<'a> {
    /// Axes of the calibration.
    pub axes: &'a [Axis],
    /// Full scale of each axis of the calibration.
    pub full_scale: &'a [f64],
    /// Metrology settings that the user chose.
    pub settings: &'a MetrologySettings,
    /// Noise and range of each load, for reversal thresholds that the user did not set; see
    /// [`extents_of_set`](crate::scoring::loops::extents_of_set).
    pub extents: &'a [LoadExtent],
}

impl Rules<'_> {
    /// Returns the reversal threshold of the axis at this position, in its unit.
    pub fn reversal_threshold(&self, at: usize) -> f64 {
        let chosen = self.settings.reversal_thresholds.get(at).copied().flatten();
        chosen.unwrap_or_else(|| self.extents.get(at).map_or(0.0, LoadExtent::reversal_threshold))
    }

    /// Returns the largest movement of the load within a dwell, for the axis at this position, in its unit.
    pub(crate) fn still(&self, at: usize) -> f64 {
        let noise = self.extents.get(at).map_or(0.0, |extent| extent.noise);
        (self.settings.still_share * self.full_scale[at]).max(NOISE_FACTOR * noise)
    }
}

#[derive(Debug, PartialEq, thiserror::Error)]
pub enum MetrologyError {
    #[error("{given} {what}s are given for {axes} axes; give one for each axis, in axis order")]
    Count { what: &'static str, given: usize, axes: usize },
    #[error("the {what} of axis {position} is {value}; enter a number of zero or above")]
    PerAxis { what: &'static str, position: usize, value: f64 },
    #[error("the shortest dwell is {value} s; enter a number above zero")]
    HoldSecs { value: f64 },
    #[error("{what} is {value}; enter a share of full scale, between 0 and 1")]
    Share { what: &'static str, value: f64 },
    #[error("{recording}: the {what} has {actual} numbers, but {expected} are needed")]
    Shape { recording: String, what: &'static str, expected: usize, actual: usize },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl MetrologySettings {
    /// Checks that every setting is in its range.
    ///
    /// # Errors
    /// [`MetrologyError`] for the first setting that is out of range.
    pub fn validate(&self, n_axes: usize) -> Result<(), MetrologyError> {
        if !self.reversal_thresholds.is_empty() {
            let chosen: Vec<f64> =
                self.reversal_thresholds.iter().map(|band| band.unwrap_or(0.0)).collect();
            check_per_axis("reversal threshold", &chosen, n_axes)?;
        }
        if !(self.hold_secs > 0.0 && self.hold_secs.is_finite()) {
            return Err(MetrologyError::HoldSecs { value: self.hold_secs });
        }
        for (what, value) in [
            ("the stability tolerance of a dwell", self.still_share),
            ("the largest load that counts as zero", self.zero_share),
            ("the smallest load at which an axis counts as loaded", self.loaded_share),
            ("the largest load at which an axis counts as unloaded", self.alone_share),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return Err(MetrologyError::Share { what, value });
            }
        }
        Ok(())
    }
}

/// Checks that `values` has one number for each axis, and that no number is below zero.
pub fn check_per_axis(
    what: &'static str,
    values: &[f64],
    n_axes: usize,
) -> Result<(), MetrologyError> {
    if values.len() != n_axes {
        return Err(MetrologyError::Count { what, given: values.len(), axes: n_axes });
    }
    match values.iter().position(|value| !(*value >= 0.0 && value.is_finite())) {
        None => Ok(()),
        Some(at) => Err(MetrologyError::PerAxis { what, position: at + 1, value: values[at] }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_out_of_range_are_named() {
        let with = |change: fn(&mut MetrologySettings)| {
            let mut settings = MetrologySettings::default();
            change(&mut settings);
            settings.validate(2)
        };
        assert_eq!(with(|_| {}), Ok(()));
        assert_eq!(with(|s| s.reversal_thresholds = vec![None, Some(0.0)]), Ok(()));
        assert!(with(|s| s.reversal_thresholds = vec![Some(1.0)]).is_err());
        assert!(with(|s| s.reversal_thresholds = vec![None, Some(-1.0)]).is_err());
        assert!(with(|s| s.reversal_thresholds = vec![None, Some(f64::NAN)]).is_err());
        assert!(with(|s| s.hold_secs = 0.0).is_err());
        assert!(with(|s| s.zero_share = f64::NAN).is_err());
        assert!(with(|s| s.alone_share = 1.1).is_err());
    }
}
