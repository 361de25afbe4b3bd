//! What a person chooses about a network.

use serde::{Deserialize, Serialize};

use super::NetworkError;

/// More layers than this are a slip of the keyboard.
const MOST_LAYERS: usize = 16;
/// A wider layer would keep a cancelled training busy for longer than a person waits.
const MOST_UNITS: usize = 2048;
/// A larger batch likewise; and it would leave too few steps to learn anything.
const MOST_SAMPLES_PER_BATCH: usize = 8192;
/// Adam moves every weight by about the rate at each step; standardised data need no more.
const FASTEST_RATE: f64 = 1.0;

/// The choices of one network.
///
/// | field | default | range | meaning |
/// |---|---|---|---|
/// | `hidden` | 100, 100, 100 | up to 16 layers of 1 to 2048 | units of each hidden layer; none: a linear map |
/// | `batch` | 100 | 1 to 8192 | samples per step |
/// | `epochs` | 1000 | 1 to 100,000 | how often every sample is seen |
/// | `learning_rate` | 0.003 | > 0, ≤ 1 | the first step's rate; it falls to zero along half a cosine |
/// | `seed` | 0 | | first weights and the order of samples |
///
/// **Source** section 4.2.1 for layers, batch and epochs; it does not name the optimiser.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct NetworkSettings {
    /// Units of each hidden layer, from the inputs to the outputs.
    pub hidden: Vec<usize>,
    /// Samples per step.
    pub batch: usize,
    /// How often every sample is seen.
    pub epochs: usize,
    /// The first step's learning rate.
    pub learning_rate: f64,
    /// Decides the first weights and the order of samples.
    pub seed: u64,
}

impl Default for NetworkSettings {
    fn default() -> Self {
        Self {
            hidden: vec![100; 3],
            batch: 100,
            epochs: 1000,
            learning_rate: 0.003,
            seed: 0,
        }
    }
}

impl NetworkSettings {
    /// More epochs than this would take days, and the network of the best epoch is long found.
    pub const MOST_EPOCHS: usize = 100_000;

    /// Checks every range of the table above.
    ///
    /// # Errors
    /// [`NetworkError::Setting`] with the first choice that is out of range.
    pub fn validate(&self) -> Result<(), NetworkError> {
        let wrong = |what: &'static str, value: String, allowed: String| {
            Err(NetworkError::Setting {
                what,
                value,
                allowed,
            })
        };
        let within = |what, value: usize, most: usize| {
            if (1..=most).contains(&value) {
                Ok(())
            } else {
                wrong(what, value.to_string(), format!("1 to {most}"))
            }
        };
        if self.hidden.len() > MOST_LAYERS {
            let allowed = format!("0 to {MOST_LAYERS}");
            let layers = self.hidden.len().to_string();
            return wrong("the number of hidden layers", layers, allowed);
        }
        for &units in &self.hidden {
            within("the number of units of a hidden layer", units, MOST_UNITS)?;
        }
        within("the batch", self.batch, MOST_SAMPLES_PER_BATCH)?;
        within("the number of epochs", self.epochs, Self::MOST_EPOCHS)?;
        if !(self.learning_rate > 0.0 && self.learning_rate <= FASTEST_RATE) {
            let allowed = format!("above 0 and at most {FASTEST_RATE}");
            return wrong("the learning rate", self.learning_rate.to_string(), allowed);
        }
        Ok(())
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
            let settings = NetworkSettings {
                learning_rate: rate,
                ..NetworkSettings::default()
            };
            assert!(settings.validate().is_err(), "{rate}");
        }
    }

    #[test]
    fn missing_fields_take_their_defaults() {
        let settings: NetworkSettings = serde_json::from_str(r#"{"epochs": 7}"#).unwrap();
        let expected = NetworkSettings {
            epochs: 7,
            ..NetworkSettings::default()
        };
        assert_eq!(settings, expected);
    }
}
