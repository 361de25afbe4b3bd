//! Settings with which a calibration is fitted to recordings.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    calibration::{error::CalibrationError, kernel::KernelSettings, network::NetworkSettings},
    features::{FeatureSettings, HISTORY_RATE, Range, Setting, Unit},
};

/// Setting for the ridge strength of a linear fit.
pub const RIDGE: Setting = Setting {
    key: "ridge",
    option: "ridge",
    label: "ridge",
    what: "the ridge",
    unit: Unit::new("", "", ["STRENGTH"; 2]),
    default: &[0.0],
    range: Range::NotNegativeOrAuto,
    step: 0.001,
    explanation: "Shrinks the coefficients of all features but the gauges: 0 is plain least squares; large values leave only \
                  the conventional calibration. \"auto\": for each axis the strength that predicts held-out recordings \
                  best. \"by-block\": a strength for each feature block and axis; \
                  a block that does not help is removed",
    source: "",
};

/// Switch for the offset term, a constant that the model adds to each axis.
pub const OFFSET: Setting = Setting {
    key: "offset",
    option: "no-offset",
    label: "Offset term",
    what: "the offset",
    unit: Unit::NONE,
    default: &[1.0],
    range: Range::Switch,
    step: 1.0,
    explanation: "Adds a constant to each axis. The paper of Koike et al. (2019) has no such constant, but \
                  real gauges are not zero without load",
    source: "Eq. 3",
};

/// Setting for the decimation of the recordings. At its maximum, a few samples of the longest recordings remain.
pub const DECIMATION: Setting = Setting {
    key: "decimation",
    option: "decimate",
    label: "Decimation",
    what: "the decimation",
    unit: Unit::NONE,
    default: &[1.0],
    range: Range::Whole(1, 100_000),
    step: 0.05,
    explanation: "Uses every n-th sample of each recording, also where the look-back searches earlier samples. 1 is \
                  pattern A of the paper of Koike et al. (2019), 10 its pattern B",
    source: "section 4.3",
};

/// Settings with which a calibration is fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FitSettings {
    /// Features of the compensated calibration in addition to the present gauges.
    pub features: FeatureSettings,
    /// Method that computes the load from the features.
    pub regressor: Regressor,
    /// Method that chooses the ridge strength; see [`RIDGE`].
    pub ridge: RidgeChoice,
    /// Settings of the network, if the regressor contains one.
    pub network: NetworkSettings,
    /// Settings of the kernel, if the regressor contains one.
    pub kernel: KernelSettings,
    /// True if the model adds a constant to each axis; see [`OFFSET`].
    pub offset: bool,
    /// Decimation of the recordings; see [`DECIMATION`].
    pub decimation: usize,
    /// Number of earlier samples per second that are stored for look-backs and lags (Hz), 0 for all; see
    /// [`HISTORY_RATE`](crate::features::HISTORY_RATE). With `None`, the fit chooses the rate.
    pub history_rate_hz: Option<f64>,
    /// Full scale of each axis, in its unit. Missing or `None` entries are derived from the loads in the training recordings.
    pub full_scale: Vec<Option<f64>>,
    /// Reference values of auxiliary channels (such as temperature) by name: the values at which the channels have no effect
    /// on the load. Other channels use their mean over the training recordings.
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
            history_rate_hz: None,
            full_scale: Vec::new(),
            auxiliary_references: BTreeMap::new(),
        }
    }
}

/// Method by which the load is computed from the features.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, strum::IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Regressor {
    /// Least squares (Eq. 8 of the paper of Koike et al., 2019).
    #[default]
    Linear,
    /// Neural network of the paper of Koike et al. (2019).
    Network,
    /// Kernel ridge regression on landmarks.
    Kernel,
    /// Least squares, then a network on the residuals (section 3.2 of the paper of Koike et al., 2019).
    HybridNetwork,
    /// Least squares, then a kernel on the residuals.
    HybridKernel,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learner {
    Network,
    Kernel,
}

impl Regressor {
    /// All regressors.
    pub const ALL: [Self; 5] =
        [Self::Linear, Self::Network, Self::Kernel, Self::HybridNetwork, Self::HybridKernel];

    /// Returns the kind of the regressor's nonlinear part, or `None` for the linear regressor.
    pub fn learner(self) -> Option<Learner> {
        match self {
            Self::Linear => None,
            Self::Network | Self::HybridNetwork => Some(Learner::Network),
            Self::Kernel | Self::HybridKernel => Some(Learner::Kernel),
        }
    }

    /// Returns true if a network or kernel learns the residuals of a linear fit.
    pub fn is_hybrid(self) -> bool {
        matches!(self, Self::HybridNetwork | Self::HybridKernel)
    }

    /// Returns the name of the regressor for the window and for tables.
    pub fn label(self) -> &'static str {
        self.words().0
    }

    /// Returns the key of the regressor in files and on the command line.
    pub fn key(self) -> &'static str {
        self.into()
    }

    /// Returns the explanation of the regressor for hover texts and for `--help`.
    pub fn explanation(self) -> &'static str {
        self.words().1
    }

    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Linear => (
                "Linear",
                "Least squares (Eq. 8 of the paper of Koike et al., 2019): a matrix, which any controller can multiply by the features",
            ),
            Self::Network => (
                "Network",
                "Network of the paper of Koike et al. (2019): three hidden layers of 100 units, trained on the summed squared error",
            ),
            Self::Kernel => (
                "Kernel",
                "Kernel ridge regression on landmark samples (the mean of a Gaussian process), with a band for the uncertainty of \
                 the load",
            ),
            Self::HybridNetwork => (
                "Linear + network",
                "Least squares first, then a network on the residuals (section 3.2 of the paper of Koike et al., 2019)",
            ),
            Self::HybridKernel => {
                ("Linear + kernel", "Least squares first, then a kernel on the residuals")
            }
        }
    }
}

/// Method that chooses the ridge strength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RidgeChoice {
    /// Strength that the user gives; 0 is plain least squares.
    Strength(f64),
    /// For each axis, the strength with the lowest error on held-out recordings.
    Auto,
    /// For each axis and feature block, the strength with the lowest error on held-out recordings, or removal of the block.
    ByBlock,
}

impl Default for RidgeChoice {
    fn default() -> Self {
        Self::Strength(RIDGE.number())
    }
}

impl FitSettings {
    /// Checks every setting. The error describes the first invalid one.
    pub fn validate(&self) -> Result<(), CalibrationError> {
        self.features.validate()?;
        self.network.validate()?;
        self.kernel.validate()?;
        if let RidgeChoice::Strength(strength) = self.ridge {
            RIDGE.check(strength)?;
        }
        DECIMATION.check(self.decimation as f64)?;
        self.history_rate_hz.map_or(Ok(()), |rate_hz| HISTORY_RATE.check(rate_hz))?;
        for (at, value) in self.full_scale.iter().enumerate() {
            if let Some(value) = *value
                && !(value > 0.0 && value.is_finite())
            {
                let position = at + 1;
                return Err(CalibrationError::FullScale { position, value });
            }
        }
        let mut references = self.auxiliary_references.iter();
        if let Some((name, value)) = references.find(|(_, value)| !value.is_finite()) {
            let (name, value) = (name.clone(), *value);
            return Err(CalibrationError::AuxiliaryReference { name, value });
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
