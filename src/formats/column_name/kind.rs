//! What a name is by itself, without a path before it or a unit behind it.

use super::words;
use crate::recording::Axis;

/// No name that is understood is longer (bytes).
pub(super) const LONGEST: usize = 64;

/// What a column is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Time,
    Gauge,
    Load(Axis),
}

/// In small letters without separators.
pub(super) fn plain(name: &str) -> String {
    name.to_lowercase().replace(['_', ' '], "")
}

/// What a name is by itself.
pub(super) fn plain_kind(name: &str) -> Option<Kind> {
    if name.len() > LONGEST {
        return None;
    }
    let plain = plain(name);
    if words::is_time(&plain) {
        Some(Kind::Time)
    } else if words::gauge_stem(name).is_some() {
        Some(Kind::Gauge)
    } else {
        words::axis_of(&plain.replace('-', "")).map(Kind::Load)
    }
}
