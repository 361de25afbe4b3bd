//! Settings of a network.

use serde::{Deserialize, Serialize};

use crate::features::{FeatureError, Range, Setting, Unit};

/// Setting for the number of hidden layers. A number above the maximum is most likely a typing error.
const LAYERS: Setting =
    Setting { what: "the number of hidden layers", range: Range::Whole(0, 16), ..UNITS };

/// Number of hidden layers in the paper of Koike et al. (2019).
const N_HIDDEN: usize = 3;

/// Setting for the number of units per hidden layer. Beyond its maximum, cancellation would be delayed too long.
pub const UNITS: Setting = Setting {
    key: "hidden",
    option: "units",
    label: "Units of each hidden layer",
    what: "the number of units of a hidden layer",
    default: &[100.0],
    range: Range::Whole(1, 2048),
    explanation: "More units describe stronger nonlinearity, but are slower and need more recordings",
    ..EPOCHS
};

/// Setting for the number of samples per optimiser step. Beyond its maximum, an epoch has too few steps.
const BATCH: Setting = Setting {
    key: "batch",
    option: "",
    label: "Batch",
    what: "the batch",
    default: &[100.0],
    range: Range::Whole(1, 8192),
    explanation: "Number of samples per optimiser step",
    ..EPOCHS
};

/// Setting for the number of passes over the samples. Beyond its maximum, a training would take days without improvement.
pub const EPOCHS: Setting = Setting {
    key: "epochs",
    option: "epochs",
    label: "Epochs",
    what: "the number of epochs",
    unit: Unit::NONE,
    default: &[1000.0],
    range: Range::Whole(1, 100_000),
    step: 0.25,
    explanation: "Number of passes over the training samples",
    source: "section 4.2.1",
};

/// Setting for the learning rate of the first step. Adam changes each weight by about this rate per step, which is enough for
/// standardised data.
const LEARNING_RATE: Setting = Setting {
    key: "learning_rate",
    option: "",
    label: "Learning rate",
    what: "the learning rate",
    default: &[0.003],
    range: Range::UpTo(1.0),
    step: 0.001,
    explanation: "Learning rate of the first step. It falls to zero along half a cosine",
    source: "",
    ..EPOCHS
};

/// Switch for a constant learning rate. The paper of Koike et al. (2019) does not mention a falling rate.
pub const CONSTANT_RATE: Setting = Setting {
    key: "constant_rate",
    option: "constant-rate",
    label: "Constant rate",
    what: "the constant rate",
    default: &[0.0],
    range: Range::Switch,
    explanation: "Keeps the learning rate constant. Otherwise it falls to zero along half a cosine, which \
                  needs fewer epochs",
    source: "",
    ..EPOCHS
};

/// Switch for early stopping. In the paper of Koike et al. (2019), the training has a fixed number of epochs.
pub const EARLY_STOPPING: Setting = Setting {
    key: "early_stopping",
    option: "no-early-stopping",
    label: "Early stopping",
    what: "early stopping",
    default: &[1.0],
    range: Range::Switch,
    explanation: "Holds out some training recordings and keeps the network of the epoch that predicts them best. Otherwise the \
                  network learns from all training recordings, and the network of the last epoch is kept, \
                  as in the paper of Koike et al. (2019)",
    source: "",
    ..EPOCHS
};

/// Switch for cross-validation, which takes longer than the training itself.
pub const CROSS_VALIDATE: Setting = Setting {
    key: "cross_validate",
    option: "cross-validate",
    label: "Cross-validate",
    what: "cross-validation",
    default: &[0.0],
    range: Range::Switch,
    explanation: "Trains one network without each fifth of the recordings and scores it on this fifth, so that networks can be \
                  compared with other models. This takes two to four times as long as the training alone",
    source: "",
    ..EPOCHS
};

/// Seed of the initial weights and of the order of samples.
pub const SEED: Setting = Setting {
    key: "seed",
    option: "seed",
    label: "seed",
    what: "the seed",
    default: &[0.0],
    range: Range::Whole(0, u64::MAX),
    explanation: "Start of the random numbers that set the first weights and the order of the samples; \
                  the same seed gives the same network",
    source: "",
    ..EPOCHS
};

/// Settings of a network. The default layers, batch and epochs are those of the paper of Koike et al. (2019), section 4.2.1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct NetworkSettings {
    /// Number of units of each hidden layer, in order from the inputs to the outputs.
    pub hidden: Vec<usize>,
    /// Number of samples per optimiser step.
    pub batch: usize,
    /// Number of passes over the training samples.
    pub epochs: usize,
    /// Learning rate of the first optimiser step.
    pub learning_rate: f64,
    /// Seed of the initial weights and of the order of samples.
    pub seed: u64,
    /// True for a constant learning rate; see [`CONSTANT_RATE`].
    pub constant_rate: bool,
    /// True for early stopping; see [`EARLY_STOPPING`].
    pub early_stopping: bool,
    /// True if the network is cross-validated; see [`CROSS_VALIDATE`].
    pub cross_validate: bool,
}

impl Default for NetworkSettings {
    fn default() -> Self {
        Self {
            hidden: vec![UNITS.number() as usize; N_HIDDEN],
            batch: BATCH.number() as usize,
            epochs: EPOCHS.number() as usize,
            learning_rate: LEARNING_RATE.number(),
            seed: SEED.number() as u64,
            constant_rate: CONSTANT_RATE.number() > 0.0,
            early_stopping: EARLY_STOPPING.number() > 0.0,
            cross_validate: CROSS_VALIDATE.number() > 0.0,
        }
    }
}

impl NetworkSettings {
    /// Checks every setting. The error describes the first invalid one.
    pub(crate) fn validate(&self) -> Result<(), FeatureError> {
        LAYERS.check(self.hidden.len() as f64)?;
        for &units in &self.hidden {
            UNITS.check(units as f64)?;
        }
        BATCH.check(self.batch as f64)?;
        EPOCHS.check(self.epochs as f64)?;
        LEARNING_RATE.check(self.learning_rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_out_of_range_are_refused() {
        let with = |change: fn(&mut NetworkSettings)| {
            let mut settings = NetworkSettings::default();
            change(&mut settings);
            settings.validate().is_ok()
        };
        assert!(with(|_| {}));
        assert!(with(|s| s.hidden.clear()));
        assert!(!with(|s| s.hidden[1] = 0));
        assert!(!with(|s| s.hidden = vec![1; 17]));
        assert!(!with(|s| s.hidden[0] = 1_000_000));
        assert!(!with(|s| s.batch = 0));
        assert!(!with(|s| s.batch = usize::MAX));
        assert!(!with(|s| s.epochs = 0));
        assert!(!with(|s| s.epochs = 1_000_000_000));
        for rate in [0.0, -0.1, f64::NAN, f64::INFINITY] {
            let settings = NetworkSettings { learning_rate: rate, ..NetworkSettings::default() };
            assert!(settings.validate().is_err(), "{rate}");
        }
    }

    #[test]
    fn missing_fields_take_their_defaults() {
        let settings: NetworkSettings = serde_json::from_str(r#"{"epochs": 7}"#).unwrap();
        let expected = NetworkSettings { epochs: 7, ..NetworkSettings::default() };
        assert_eq!(settings, expected);
    }
}
