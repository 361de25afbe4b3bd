use crate::calibration::settings::Learner;
use crate::shown::counted;

/// Reason why there are no cross-validation errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoCrossValidation {
    #[error("nothing was left out")]
    NotDone,
    #[error(
        "the network was not cross-validated: cross-validation was off or cancelled, or too few samples remain when a fold is left out"
    )]
    Network,
    #[error(
        "the cross-validation was cancelled, or too few samples remain when a fold is left out"
    )]
    Kernel,
    #[error(
        "there are too few training samples: when one fold is left out, fewer samples remain than there are coefficients"
    )]
    FewSamples,
    #[error(
        "without a fold, {samples} training samples remain for {columns} features; record longer, add recordings in the train \
         role, decimate less, or take fewer features"
    )]
    FewSamplesFor { samples: u64, columns: usize },
    #[error(
        "the training recordings form {}, and {needed} are needed; add recordings in the train role",
        counted(*found, "group")
    )]
    FewGroups { found: usize, needed: usize },
}

impl NoCrossValidation {
    /// Returns the reason why a fit that was made here has no cross-validation errors.
    pub fn of(learner: Option<Learner>) -> Self {
        match learner {
            Some(Learner::Network) => Self::Network,
            Some(Learner::Kernel) => Self::Kernel,
            None => Self::FewSamples,
        }
    }
}
