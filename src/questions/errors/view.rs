//! Choice of the recordings on screen.

use std::ops::Range;

/// Recordings on screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// The recording with this index.
    One(usize),
    /// All recordings, one after another.
    #[default]
    All,
}

impl View {
    /// Returns this view, or the last recording if this view's recording does not exist.
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
