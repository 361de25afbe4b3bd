//! Kind of a column by a plain name, without a path before it or a unit behind it.

use super::words;
use crate::recording::Axis;

/// Maximum length of a name that can have a kind (bytes).
pub(super) const LONGEST: usize = 64;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Time,
    Gauge,
    Load(Axis),
}

/// Returns the name in lower case, without separators.
pub(super) fn plain(name: &str) -> String {
    name.to_lowercase().replace(['_', ' '], "")
}

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
