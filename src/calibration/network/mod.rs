//! Neural network: standardised features → rectified hidden layers → standardised load.
//!
//! Guarantees: the same samples, settings and seed give the same network on the same kind of processor. One network trains on
//! one thread. A cancelled training returns the best network so far. Non-finite samples and losses are errors, so a trained
//! network has only finite numbers.
//!
//! ```
//! use loopscope::calibration::network::{Network, NetworkSettings, Samples};
//! use loopscope::progress::Progress;
//!
//! let mut train = Samples::new(1, 1);
//! for k in 0..400 {
//!     let x = f64::from(k) / 400.0;
//!     train.push_rows(&[x], &[x * x])?;
//! }
//! let settings = NetworkSettings { hidden: vec![16], epochs: 40, ..NetworkSettings::default() };
//! let network = Network::train(&train, None, &settings, &Progress::default(), &mut |_| {})?;
//! let mut load = [0.0];
//! network.predict_rows(&[0.5], &mut load);
//! assert!((load[0] - 0.25).abs() < 0.03);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adam;
mod epochs;
mod fitted;
mod passes;
mod predict;
mod samples;
mod settings;
mod training;

pub use crate::calibration::error::Column;
pub(crate) use fitted::Layer;
pub use fitted::Network;
pub use samples::Samples;
pub use settings::NetworkSettings;
pub(crate) use settings::{CONSTANT_RATE, CROSS_VALIDATE, EARLY_STOPPING, EPOCHS, SEED, UNITS};
pub(crate) use training::EpochReport;
