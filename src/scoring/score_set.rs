//! Sets of samples on which the errors of a calibration are measured.

use crate::calibration::{FactoryScores, NoCrossValidation, Scores};

/// Samples on which the errors of a calibration are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScoreSet {
    Train,
    Test,
    /// Training recordings in cross-validation: each group is predicted by a fit to the other groups.
    LeftOut,
}

impl ScoreSet {
    pub const ALL: [Self; 3] = [Self::Train, Self::Test, Self::LeftOut];

    pub fn label(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Test => "test",
            Self::LeftOut => "cross-validation",
        }
    }

    pub fn title(self) -> &'static str {
        match self {
            Self::Train => "Train",
            Self::Test => "Test",
            Self::LeftOut => "CV",
        }
    }

    /// Returns the reason why there are no errors on these samples. `fit` is the reason why the fit was not cross-validated,
    /// if it was not.
    pub fn missing(self, fit: Option<NoCrossValidation>) -> String {
        match self {
            Self::Train => "no recording is in the train role".to_owned(),
            Self::Test => "no recording is in the test role".to_owned(),
            Self::LeftOut => fit.unwrap_or(NoCrossValidation::NotDone).to_string(),
        }
    }

    pub fn explanation(self) -> &'static str {
        match self {
            Self::Train => {
                "Errors on the training recordings. They are smaller than errors on new recordings, because the calibration was fitted to the training recordings"
            }
            Self::Test => {
                "Errors on the test recordings. If you choose settings by these errors, the recordings no longer test the calibration independently"
            }
            Self::LeftOut => {
                "Errors on each group of training recordings, predicted by a fit to the other groups. With fewer than three recordings, \
                 five contiguous blocks of samples are left out in turn. Choose settings by these errors. The look-back always finds earlier \
                 samples with the conventional calibration of all training recordings"
            }
        }
    }

    pub fn rmse(self, scores: &Scores) -> Option<&[f64]> {
        match self {
            Self::Train => scores.train_rmse.as_deref(),
            Self::Test => scores.test_rmse.as_deref(),
            Self::LeftOut => scores.cv_rmse.as_deref(),
        }
    }

    /// Returns the RMSE of the factory calibration on these samples, per axis. Empty for cross-validation, because the
    /// factory calibration is not fitted here.
    pub fn factory_rmse(self, scores: &FactoryScores) -> &[Option<f64>] {
        match self {
            Self::Train => &scores.train_rmse,
            Self::Test => &scores.test_rmse,
            Self::LeftOut => &[],
        }
    }
}
