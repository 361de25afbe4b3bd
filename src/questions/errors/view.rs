//! Choice of the recordings that the trace panes show.

use std::ops::Range;

/// Recordings that the trace panes show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// The recording with this index in the recording set.
    One(usize),
    /// All recordings, one after another.
    #[default]
    All,
}

impl View {
    /// Returns this view. If its recording does not exist, returns a view of the last recording.
    pub fn within(self, n_recordings: usize) -> Self {
        match self {
            Self::One(at) => Self::One(at.min(n_recordings.saturating_sub(1))),
            Self::All => Self::All,
        }
    }

    pub(crate) fn recordings(self, n_recordings: usize) -> Range<usize> {
        match self {
            Self::One(at) => at..(at + 1).min(n_recordings),
            Self::All => 0..n_recordings,
        }
    }
}
