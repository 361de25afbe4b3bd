//! From gauges to load: sums over recordings, the least-squares solution, what learns beside it, and the calibration
//! that comes of it.

mod aged_sums;
#[expect(
    clippy::module_inception,
    reason = "the room's main thing has the room's name"
)]
mod calibration;
mod conventional;
mod estimator;
mod file_form;
pub mod kernel;
mod learned;
pub mod linear;
mod linear_map;
pub mod network;
mod normal_equations;
mod settings;
mod sums;
mod used_recording;
mod validate;

pub use aged_sums::{AgedSums, ThresholdAges, aged_sums};
pub use calibration::{
    AppliedLoads, Calibration, FORMAT, FactoryScores, Quality, Scores, Undetermined, VERSION,
};
pub(crate) use calibration::{Past, learned_inputs, past_samples};
pub use conventional::Conventional;
pub use estimator::{Estimator, LEAP_SECS, STRAYS, SampleError, Taken};
pub use file_form::{CalibrationFileError, NamedMap};
pub use kernel::{Kernel, KernelSettings, LANDMARKS};
pub use learned::{Learned, LearnedError};
pub use linear::{Fit, Ridge, Terms, condition_number, fit, fit_targets};
pub use linear_map::LinearMap;
pub(crate) use linear_map::loads_from_gauges;
pub use network::{EPOCHS, EpochReport, Network, NetworkSettings, SEED};
pub use normal_equations::NormalEquations;
pub use settings::{
    DECIMATION, FitSettings, Learner, OFFSET, RIDGE, Regressor, RidgeChoice, SettingsError,
};
pub(crate) use sums::sample_row;
pub use sums::{Piece, recording_sums};
pub use used_recording::UsedRecording;
pub use validate::CalibrationError;
