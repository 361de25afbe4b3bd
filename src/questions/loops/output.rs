//! Outputs on the vertical axis of a plot, and the samples that it shows.

use crate::calibration::{AppliedLoads, Calibration};
use crate::questions::loops::error::LookError;
use crate::questions::metrology::Reason;
use crate::recording::{Axis, RecordingSet, Role};

/// Uncompensated or compensated load.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Output {
    /// Uncompensated load.
    Conventional,
    /// Compensated load.
    Compensated,
}

impl Output {
    /// Both outputs, in the order used everywhere.
    pub const ALL: [Self; 2] = [Self::Conventional, Self::Compensated];

    pub(crate) fn of(self, applied: &AppliedLoads) -> &[f64] {
        match self {
            Self::Conventional => &applied.conventional,
            Self::Compensated => &applied.compensated,
        }
    }
}

/// Samples to plot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Span {
    /// Samples on screen in the trace panes.
    #[default]
    Visible,
    /// All samples of this recording.
    One(usize),
    /// All recordings that the table of figures covers.
    Of(TableOf),
    /// All recordings.
    All,
}

/// Returns the position of an axis in the calibration, with its full scale.
pub(crate) fn column_of(calibration: &Calibration, axis: Axis) -> Result<(usize, f64), LookError> {
    let at = calibration.axes.iter().position(|own| *own == axis);
    let at = at.ok_or(Reason::NoReference { axis })?;
    let full_scale = calibration.full_scale.get(at).copied().unwrap_or(0.0);
    Ok((at, full_scale))
}

/// Recordings that the table of figures covers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableOf {
    /// Test recordings.
    Test,
    /// Training recordings.
    Train,
    /// Recordings that do not enter the fit: test recordings and those that are off.
    NotFitted,
    /// All recordings.
    #[default]
    All,
}

impl TableOf {
    /// Returns true if recordings with this role are covered.
    pub fn includes(self, role: Role) -> bool {
        match self {
            Self::Test => role == Role::Test,
            Self::Train => role == Role::Train,
            Self::NotFitted => role != Role::Train,
            Self::All => true,
        }
    }

    /// Returns the default: the test recordings, else the training recordings, else all. For the built-in sensor, the default
    /// includes its bench recordings, although their role is off.
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
