//! What a person chooses about a fit.

use serde::{Deserialize, Serialize};

use crate::features::{Distance, Thresholds};

/// The choices of one fit.
///
/// | field | default | range | meaning |
/// |---|---|---|---|
/// | `thresholds` | 3 N, 15 s | ≥ 0 | the look-back's F_th and t_th |
/// | `distance` | force | force, full scale | what F_th is measured in |
/// | `offset` | true | | whether the model has a constant term (the paper has none) |
/// | `decimation` | 1 | ≥ 1 | every how many-th sample is used (10: the paper's pattern B) |
/// | `full_scale` | none | > 0 | per axis; where `None`, half the peak-to-peak training reference |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FitSettings {
    /// F_th and t_th.
    pub thresholds: Thresholds,
    /// What F_th is measured in.
    pub distance: Distance,
    /// Whether the model has an offset term.
    pub offset: bool,
    /// Every how many-th sample is used.
    pub decimation: usize,
    /// Full scale per axis, in axis order; missing or `None` entries are measured.
    pub full_scale: Vec<Option<f64>>,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            thresholds: Thresholds::default(),
            distance: Distance::default(),
            offset: true,
            decimation: 1,
            full_scale: Vec::new(),
        }
    }
}

/// A choice that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SettingsError {
    #[error("{what} is {value}; it must be a number from zero up")]
    Threshold { what: &'static str, value: f64 },
    #[error("the decimation is 0; it must be 1 (every sample) or more")]
    Decimation,
    #[error("the full scale of axis {position} is {value}; it must be a number above zero")]
    FullScale { position: usize, value: f64 },
}

impl FitSettings {
    /// Checks every range of the table above.
    ///
    /// # Errors
    /// [`SettingsError`] with the first choice that is out of range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let Thresholds { f_th, t_th_secs } = self.thresholds;
        for (what, value) in [("F_th", f_th), ("t_th", t_th_secs)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(SettingsError::Threshold { what, value });
            }
        }
        if self.decimation == 0 {
            return Err(SettingsError::Decimation);
        }
        for (at, value) in self.full_scale.iter().enumerate() {
            if let Some(value) = *value
                && !(value > 0.0 && value.is_finite())
            {
                let position = at + 1;
                return Err(SettingsError::FullScale { position, value });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_out_of_range_are_named() {
        let with = |change: fn(&mut FitSettings)| {
            let mut settings = FitSettings::default();
            change(&mut settings);
            settings.validate()
        };
        assert_eq!(with(|_| {}), Ok(()));
        assert!(with(|s| s.thresholds.f_th = -1.0).is_err());
        assert!(with(|s| s.thresholds.t_th_secs = f64::NAN).is_err());
        assert!(with(|s| s.thresholds.t_th_secs = f64::INFINITY).is_err());
        assert!(with(|s| s.decimation = 0).is_err());
        assert!(with(|s| s.full_scale = vec![None, Some(0.0)]).is_err());
    }
}
