//! Recordings that are used in a study of thresholds.

use crate::calibration::{NoCrossValidation, RidgeChoice};
use crate::features::ColumnKind;
use crate::questions::error::AnalysisError;
use crate::recording::{Entry, Role};
use crate::scoring::left_out::too_short;

/// Returns true if a recording is used in fits or scores.
pub(crate) fn takes_part(entry: &Entry) -> bool {
    entry.role != Role::Off && entry.recording.has_reference()
}

/// Checks that enough samples remain without each part. (An automatic ridge may be zero.)
pub(crate) fn check_parts(
    part_samples: &[u64],
    kinds: impl Iterator<Item = ColumnKind>,
    ridge: RidgeChoice,
) -> Result<(), AnalysisError> {
    let strength = match ridge {
        RidgeChoice::Strength(strength) => strength,
        RidgeChoice::Auto | RidgeChoice::ByBlock => 0.0,
    };
    match too_short(part_samples.iter().copied(), kinds, &[strength]) {
        Some((samples, columns)) => {
            Err(NoCrossValidation::FewSamplesFor { samples, columns }.into())
        }
        None => Ok(()),
    }
}
