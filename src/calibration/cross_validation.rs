use std::fmt;

use serde::{Deserialize, Serialize};

use crate::recording::GroupedBy;

/// Division of the training recordings into parts, which cross-validation leaves out in turn.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CrossValidation {
    pub by: GroupedBy,
    pub groups: usize,
    /// Number of parts; below the number of groups if several groups are left out together.
    pub parts: usize,
}

impl CrossValidation {
    /// Returns true if contiguous blocks are left out, because there are too few recordings.
    pub fn is_by_block(&self) -> bool {
        self.by == GroupedBy::Block
    }
}

impl fmt::Display for CrossValidation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { by, groups, parts } = self;
        if self.is_by_block() {
            return write!(f, "by {parts} contiguous blocks of the training recordings");
        }
        let noun = if *by == GroupedBy::Recording { "recordings" } else { "groups" };
        if parts < groups {
            write!(f, "by {by}: {groups} {noun} left out in {parts} parts")
        } else {
            let one = by.to_string().replace(' ', "-");
            write!(f, "by {by}: leave-one-{one}-out, {groups} {noun}")
        }
    }
}
