//! Fits and applies calibrations from gauges to load: sums over recordings, least squares, network, kernel, and calibration
//! file.

mod aged_sums;
#[expect(clippy::module_inception, reason = "the main type has the name of the module")]
mod calibration;
mod choice;
mod coefficient_errors;
mod conventional;
mod cross_validation;
mod entries;
mod error;
mod estimator;
mod expected_error;
mod file_form;
pub(crate) mod kernel;
mod learned;
pub(crate) mod linear;
mod linear_map;
pub mod network;
mod no_cross_validation;
mod normal_equations;
mod pauses;
mod settings;
mod starts;
mod status;
mod sums;
mod used_recording;
mod validate;

pub(crate) use aged_sums::{AgedSums, ThresholdAges, aged_sums, look_back_sums};
pub use calibration::{AppliedLoads, Calibration};
pub(crate) use calibration::{
    BlockRidge, FactoryScores, NEVER_REACHED, Past, Quality, Scores, Undetermined,
    history_step_by_rate, learned_inputs, past_samples,
};
pub(crate) use choice::{
    Blocks as ErrorBlocks, HARM, NEARLY, Refusal, SHARES, best_share, simplest_good, t_beyond,
    weighed,
};
pub(crate) use coefficient_errors::{CoefficientErrors, MOST_FEATURES};
pub(crate) use conventional::Conventional;
pub(crate) use cross_validation::CrossValidation;
pub(crate) use error::{CalibrationError, FORMAT, LARGEST, VERSION};
pub(crate) use estimator::STRAYS;
pub use estimator::{Estimator, SampleError};
pub(crate) use expected_error::{AxisExpectedError, ExpectedError, HeldOut};
pub(crate) use kernel::{GridEdge, LANDMARKS};
pub use kernel::{Kernel, KernelSettings};
pub(crate) use learned::Learned;
pub use linear::{Fit, fit};
pub(crate) use linear::{MANY_COLUMNS, Ridge, Terms, condition_number, fit_targets};
pub(crate) use linear_map::{LinearMap, PresentLoads, loads_from_gauges};
pub(crate) use network::{
    CONSTANT_RATE, CROSS_VALIDATE, EARLY_STOPPING, EPOCHS, EpochReport, SEED, UNITS,
};
pub use network::{Network, NetworkSettings};
pub(crate) use no_cross_validation::NoCrossValidation;
pub(crate) use normal_equations::NormalEquations;
pub(crate) use pauses::{measured_fade, measured_pauses};
pub(crate) use settings::{DECIMATION, Learner, OFFSET, RIDGE};
pub use settings::{FitSettings, Regressor, RidgeChoice};
pub(crate) use starts::scatter_of_starts;
pub use status::Status;
pub(crate) use sums::{Piece, RowsOf, recording_sums};
pub(crate) use used_recording::UsedRecording;
