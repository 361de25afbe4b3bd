//! What goes up in a plot, and which samples it shows.

use crate::calibration::{AppliedLoads, Calibration};
use crate::questions::loops::error::LookError;
use crate::questions::metrology::Reason;
use crate::recording::{Axis, RecordingSet, Role};

/// Conventional or compensated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Output {
    /// Conv.
    Conventional,
    /// Comp.
    Compensated,
}

impl Output {
    /// Both, in this order everywhere.
    pub const ALL: [Self; 2] = [Self::Conventional, Self::Compensated];

    /// Its loads.
    pub(crate) fn of(self, applied: &AppliedLoads) -> &[f64] {
        match self {
            Self::Conventional => &applied.conventional,
            Self::Compensated => &applied.compensated,
        }
    }
}

/// Which samples are looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Span {
    /// What the trace panes show: their recordings, and the interval of time on screen.
    #[default]
    Visible,
    /// All of this recording.
    One(usize),
    /// All recordings that the table of figures is of.
    Of(TableOf),
    /// All recordings.
    All,
}

/// The place of an axis in the calibration, with its full scale.
pub(crate) fn column_of(calibration: &Calibration, axis: Axis) -> Result<(usize, f64), LookError> {
    let at = calibration.axes.iter().position(|own| *own == axis);
    let at = at.ok_or(Reason::NoReference { axis })?;
    let full_scale = calibration.full_scale.get(at).copied().unwrap_or(0.0);
    Ok((at, full_scale))
}

/// Which recordings the table of figures is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableOf {
    /// The test recordings.
    Test,
    /// The training recordings.
    Train,
    /// Those that nothing is fitted to: the test recordings, and those that are off.
    NotFitted,
    /// All.
    #[default]
    All,
}

impl TableOf {
    /// Whether recordings in this role are among them.
    pub fn includes(self, role: Role) -> bool {
        match self {
            Self::Test => role == Role::Test,
            Self::Train => role == Role::Train,
            Self::NotFitted => role != Role::Train,
            Self::All => true,
        }
    }

    /// What is measured where nobody says: the test recordings, else the training recordings, else all; of the built-in
    /// sensor also its bench recordings, which are off.
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
