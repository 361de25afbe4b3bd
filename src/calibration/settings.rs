//! What a person chooses about a fit.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::calibration::kernel::{KernelError, KernelSettings};
use crate::calibration::network::{NetworkError, NetworkSettings};
use crate::features::{
    FeatureError, FeatureSettings, HISTORY_RATE, OutOfRange, Range, Setting, Unit,
};

/// How strong the ridge is.
pub const RIDGE: Setting = Setting {
    key: "ridge",
    option: "ridge",
    label: "ridge",
    what: "the ridge",
    unit: Unit::new("", "", ["STRENGTH"; 2]),
    default: &[0.0],
    range: Range::NotNegativeOrAuto,
    step: 0.001,
    explanation: "How much the linear fit shrinks what the blocks append: 0 is plain least squares, ever more leaves only \
                  the conventional calibration. \"auto\": per axis the strength with which left-out recordings are \
                  predicted best; blocks that only memorise are then shrunk away. \"by-block\": a strength for each block and axis; \
                  a block that does not help is left away",
    source: "",
};

/// Whether the model has an offset term.
pub const OFFSET: Setting = Setting {
    key: "offset",
    option: "no-offset",
    label: "Offset term",
    what: "the offset",
    unit: Unit::NONE,
    default: &[1.0],
    range: Range::Switch,
    step: 1.0,
    explanation: "A constant added to each axis. The paper has none; real gauges have a zero point",
    source: "Eq. 3",
};

/// Every how many-th sample is used. With the largest no more than a handful is left of the longest recordings.
pub const DECIMATION: Setting = Setting {
    key: "decimation",
    option: "decimate",
    label: "Decimation",
    what: "the decimation",
    unit: Unit::NONE,
    default: &[1.0],
    range: Range::Whole(1, 100_000),
    step: 0.05,
    explanation: "Of each recording the first sample, and then every so many; the search for the past sees only these. 1 is \
                  the paper's pattern A, 10 its pattern B",
    source: "section 4.3",
};

/// The choices of one fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FitSettings {
    /// What is appended to the gauges.
    pub features: FeatureSettings,
    /// How the load is made of the features.
    pub regressor: Regressor,
    /// [`RIDGE`].
    pub ridge: RidgeChoice,
    /// The network's choices.
    pub network: NetworkSettings,
    /// The kernel's choices.
    pub kernel: KernelSettings,
    /// [`OFFSET`].
    pub offset: bool,
    /// [`DECIMATION`].
    pub decimation: usize,
    /// [`HISTORY_RATE`](crate::features::HISTORY_RATE).
    pub history_rate_hz: f64,
    /// Full scale per axis, in axis order; missing or `None` entries are measured.
    pub full_scale: Vec<Option<f64>>,
    /// What the effect of an auxiliary channel counts from, by the channel's name; of others, and by default, its mean over the
    /// training recordings. Gauge matrix and offset are those at this value.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub auxiliary_references: BTreeMap<String, f64>,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            features: FeatureSettings::default(),
            regressor: Regressor::default(),
            ridge: RidgeChoice::default(),
            network: NetworkSettings::default(),
            kernel: KernelSettings::default(),
            offset: OFFSET.number() > 0.0,
            decimation: DECIMATION.number() as usize,
            history_rate_hz: HISTORY_RATE.number(),
            full_scale: Vec::new(),
            auxiliary_references: BTreeMap::new(),
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
    pub const ALL: [Self; 5] =
        [Self::Linear, Self::Network, Self::Kernel, Self::HybridNetwork, Self::HybridKernel];

    /// What learns; `None` for the linear regressor.
    pub fn learner(self) -> Option<Learner> {
        match self {
            Self::Linear => None,
            Self::Network | Self::HybridNetwork => Some(Learner::Network),
            Self::Kernel | Self::HybridKernel => Some(Learner::Kernel),
        }
    }

    /// Whether least squares come first.
    pub fn is_hybrid(self) -> bool {
        matches!(self, Self::HybridNetwork | Self::HybridKernel)
    }

    /// What people call it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Linear => "Linear",
            Self::Network => "Network",
            Self::Kernel => "Kernel",
            Self::HybridNetwork => "Linear + network",
            Self::HybridKernel => "Linear + kernel",
        }
    }

    /// Its name in files and on the command line.
    pub fn key(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Network => "network",
            Self::Kernel => "kernel",
            Self::HybridNetwork => "hybrid-network",
            Self::HybridKernel => "hybrid-kernel",
        }
    }

    /// What it is.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Linear => "Least squares (Eq. 8): a matrix that any controller can run",
            Self::Network => {
                "The paper's network: three hidden layers of 100 units, trained on the summed squared error"
            }
            Self::Kernel => {
                "Kernel ridge regression on landmark samples (the mean of a Gaussian process), with a band that says how \
                 sure it is"
            }
            Self::HybridNetwork => {
                "Least squares first, then a network on what they leave over (section 3.2)"
            }
            Self::HybridKernel => "Least squares first, then a kernel on what they leave over",
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
    /// For each axis and each block the ones that left-out recordings are predicted best with; a block that does not help
    /// is left away.
    ByBlock,
}

impl Default for RidgeChoice {
    fn default() -> Self {
        Self::Strength(RIDGE.number())
    }
}

/// A choice that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    #[error(transparent)]
    Features(#[from] FeatureError),
    #[error(transparent)]
    Network(#[from] NetworkError),
    #[error(transparent)]
    Kernel(#[from] KernelError),
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    #[error("the full scale of axis {position} is {value}; it must be a number above zero")]
    FullScale { position: usize, value: f64 },
    #[error("the effect of {name} counts from {value}; it must be a number")]
    AuxiliaryReference { name: String, value: f64 },
}

impl FitSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`SettingsError`] with the first choice that is out of range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.features.validate()?;
        self.network.validate()?;
        self.kernel.validate()?;
        if let RidgeChoice::Strength(strength) = self.ridge {
            RIDGE.check(strength)?;
        }
        DECIMATION.check(self.decimation as f64)?;
        HISTORY_RATE.check(self.history_rate_hz)?;
        for (at, value) in self.full_scale.iter().enumerate() {
            if let Some(value) = *value
                && !(value > 0.0 && value.is_finite())
            {
                let position = at + 1;
                return Err(SettingsError::FullScale { position, value });
            }
        }
        let mut references = self.auxiliary_references.iter();
        if let Some((name, value)) = references.find(|(_, value)| !value.is_finite()) {
            let (name, value) = (name.clone(), *value);
            return Err(SettingsError::AuxiliaryReference { name, value });
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

    #[test]
    fn regressors_have_the_same_names_in_files_and_options() {
        for regressor in Regressor::ALL {
            let stored = serde_json::to_value(regressor).unwrap();
            assert_eq!(stored, regressor.key());
        }
    }
}
