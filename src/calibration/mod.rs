//! From gauges to load: sums over recordings, the least-squares solution, and the calibration that comes of it.

#[expect(
    clippy::module_inception,
    reason = "the room's main thing has the room's name"
)]
mod calibration;
mod conventional;
pub mod linear;
pub mod network;
mod normal_equations;
mod settings;
mod sums;

pub use calibration::{
    AppliedLoads, Calibration, CalibrationError, FORMAT, LinearMap, Quality, Scores, VERSION,
};
pub(crate) use calibration::{loads_from_gauges, loads_from_history};
pub use conventional::Conventional;
pub use linear::{Fit, condition_number, fit};
pub use normal_equations::NormalEquations;
pub use settings::{FitSettings, SettingsError};
pub use sums::{Columns, Piece, recording_sums};
