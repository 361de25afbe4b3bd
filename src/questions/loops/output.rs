//! Samples that a plot shows, and the position of an axis in the calibration.

use crate::calibration::Calibration;
use crate::questions::loops::error::LookError;
use crate::questions::metrology::Reason;
use crate::recording::{Axis, RecordingSet, Role};

/// Choice of the samples to plot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Span {
    /// Samples that the trace panes show at present.
    #[default]
    Visible,
    /// All samples of the recording with this index in the recording set.
    One(usize),
    /// All samples of the recordings that the metrology table covers.
    Of(TableOf),
    /// All recordings.
    All,
}

/// Returns the position of an axis in the calibration, and the full scale of the axis.
pub(crate) fn column_of(calibration: &Calibration, axis: Axis) -> Result<(usize, f64), LookError> {
    let at = calibration.axes.iter().position(|own| *own == axis);
    let at = at.ok_or(Reason::NoReference { axis })?;
    Ok((at, calibration.full_scale[at]))
}

/// Choice of the recordings that the metrology table covers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableOf {
    /// Test recordings.
    Test,
    /// Training recordings.
    Train,
    /// Recordings that the fit does not use: those with the role Test or Off.
    NotFitted,
    /// All recordings.
    #[default]
    All,
}

impl TableOf {
    /// Returns true if the metrology table covers recordings with this role.
    pub fn includes(self, role: Role) -> bool {
        match self {
            Self::Test => role == Role::Test,
            Self::Train => role == Role::Train,
            Self::NotFitted => role != Role::Train,
            Self::All => true,
        }
    }

    /// Returns the default choice: the test recordings, else the training recordings, else all recordings. For the built-in
    /// simulated sensor, the default includes its bench recordings, although their role is off.
    pub fn usual(set: &RecordingSet) -> Self {
        let has = |role| set.entries().iter().any(|entry| entry.role == role);
        match () {
            () if set.is_simulated() && has(Role::Test) => Self::NotFitted,
            () if has(Role::Test) => Self::Test,
            () if has(Role::Train) => Self::Train,
            () => Self::All,
        }
    }
}
