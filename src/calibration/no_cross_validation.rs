use crate::{calibration::settings::Learner, shown::counted};

/// Reason why a calibration has no cross-validation errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoCrossValidation {
    #[error("no cross-validation was done")]
    NotDone,
    #[error(
        "the network was not cross-validated: cross-validation was off or cancelled, or too few samples remain when a part of the recordings is left out"
    )]
    Network,
    #[error(
        "the cross-validation was cancelled, or too few samples remain when a part of the recordings is left out"
    )]
    Kernel,
    #[error(
        "there are too few training samples: when a part of the recordings is left out, fewer samples than coefficients remain"
    )]
    FewSamples,
    #[error(
        "when a part of the recordings is left out, only {samples} training samples remain for {columns} features; record longer, \
         add recordings in the train role, decimate less, or take fewer features"
    )]
    FewSamplesFor { samples: u64, columns: usize },
    #[error(
        "the training recordings form {}, but cross-validation needs {needed}; add recordings in the train role",
        counted(*found, "group")
    )]
    FewGroups { found: usize, needed: usize },
}

impl NoCrossValidation {
    /// Returns the most likely reason why a fit with this nonlinear part (or none) has no cross-validation errors.
    pub fn of(learner: Option<Learner>) -> Self {
        match learner {
            Some(Learner::Network) => Self::Network,
            Some(Learner::Kernel) => Self::Kernel,
            None => Self::FewSamples,
        }
    }
}
