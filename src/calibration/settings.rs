//! What a person chooses about a fit.

use serde::{Deserialize, Serialize};

use crate::calibration::kernel::{KernelError, KernelSettings};
use crate::calibration::network::{NetworkError, NetworkSettings};
use crate::features::{FeatureError, FeatureSettings};

/// The choices of one fit.
///
/// | field | default | range | meaning |
/// |---|---|---|---|
/// | `features` | one look-back | | what is appended to the gauges, see [`FeatureSettings`] |
/// | `regressor` | linear | | how the load is made of the features |
/// | `ridge` | 0 | ≥ 0, or auto | how much the linear fit shrinks what the blocks append |
/// | `network` | the paper's | | see [`NetworkSettings`] |
/// | `kernel` | 200 landmarks | | see [`KernelSettings`] |
/// | `offset` | true | | whether the model has a constant term (the paper has none) |
/// | `decimation` | 1 | 1 to 100,000 | every how many-th sample is used (10: the paper's pattern B) |
/// | `full_scale` | none | > 0 | per axis; where `None`, half the peak-to-peak training reference |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FitSettings {
    /// What is appended to the gauges.
    pub features: FeatureSettings,
    /// How the load is made of the features.
    pub regressor: Regressor,
    /// How much the linear fit shrinks what the blocks append.
    pub ridge: RidgeChoice,
    /// The network's choices.
    pub network: NetworkSettings,
    /// The kernel's choices.
    pub kernel: KernelSettings,
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
            features: FeatureSettings::default(),
            regressor: Regressor::default(),
            ridge: RidgeChoice::default(),
            network: NetworkSettings::default(),
            kernel: KernelSettings::default(),
            offset: true,
            decimation: 1,
            full_scale: Vec::new(),
        }
    }
}

/// How the load is made of the features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Regressor {
    /// Least squares (Eq. 8).
    #[default]
    Linear,
    /// The paper's network.
    Network,
    /// Kernel ridge regression on landmarks.
    Kernel,
    /// Least squares first, then a network on what it leaves over (section 3.2).
    HybridNetwork,
    /// Least squares first, then a kernel on what it leaves over.
    HybridKernel,
}

/// What learns, beside least squares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learner {
    /// Layers of units.
    Network,
    /// Similarity to landmarks.
    Kernel,
}

impl Regressor {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Linear,
        Self::Network,
        Self::Kernel,
        Self::HybridNetwork,
        Self::HybridKernel,
    ];

    /// What learns; `None` for the linear regressor.
    #[must_use]
    pub fn learner(self) -> Option<Learner> {
        match self {
            Self::Linear => None,
            Self::Network | Self::HybridNetwork => Some(Learner::Network),
            Self::Kernel | Self::HybridKernel => Some(Learner::Kernel),
        }
    }

    /// Whether least squares come first.
    #[must_use]
    pub fn is_hybrid(self) -> bool {
        matches!(self, Self::HybridNetwork | Self::HybridKernel)
    }

    /// What people call it.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Linear => "Linear",
            Self::Network => "Network",
            Self::Kernel => "Kernel",
            Self::HybridNetwork => "Linear + network",
            Self::HybridKernel => "Linear + kernel",
        }
    }
}

/// How the strength of the ridge is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RidgeChoice {
    /// This one; 0 is plain least squares.
    Strength(f64),
    /// For each axis the one that left-out recordings are predicted best with.
    Auto,
}

impl Default for RidgeChoice {
    fn default() -> Self {
        Self::Strength(0.0)
    }
}

/// A choice that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SettingsError {
    #[error(transparent)]
    Features(#[from] FeatureError),
    #[error(transparent)]
    Network(#[from] NetworkError),
    #[error(transparent)]
    Kernel(#[from] KernelError),
    #[error("the ridge is {0}; it must be a number from zero up, or auto")]
    Ridge(f64),
    #[error(
        "the decimation is {0}; it must be from 1 (every sample) to {most}",
        most = FitSettings::MOST_DECIMATION
    )]
    Decimation(usize),
    #[error("the full scale of axis {position} is {value}; it must be a number above zero")]
    FullScale { position: usize, value: f64 },
}

impl FitSettings {
    /// Of the longest recordings no more than a handful of samples would be left.
    pub const MOST_DECIMATION: usize = 100_000;

    /// Checks every range of the table above.
    ///
    /// # Errors
    /// [`SettingsError`] with the first choice that is out of range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.features.validate()?;
        self.network.validate()?;
        self.kernel.validate()?;
        if let RidgeChoice::Strength(strength) = self.ridge
            && !(strength >= 0.0 && strength.is_finite())
        {
            return Err(SettingsError::Ridge(strength));
        }
        if !(1..=Self::MOST_DECIMATION).contains(&self.decimation) {
            return Err(SettingsError::Decimation(self.decimation));
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
    use crate::features::Play;

    #[test]
    fn values_out_of_range_are_named() {
        let with = |change: fn(&mut FitSettings)| {
            let mut settings = FitSettings::default();
            change(&mut settings);
            settings.validate()
        };
        assert_eq!(with(|_| {}), Ok(()));
        assert!(with(|s| s.features.blocks.set(&Play, vec![-1.0])).is_err());
        assert!(with(|s| s.ridge = RidgeChoice::Strength(f64::NAN)).is_err());
        assert!(with(|s| s.kernel.landmarks = 0).is_err());
        assert!(with(|s| s.network.epochs = 0).is_err());
        assert!(with(|s| s.decimation = 0).is_err());
        assert!(with(|s| s.decimation = usize::MAX).is_err());
        assert!(with(|s| s.full_scale = vec![None, Some(0.0)]).is_err());
    }
}
