//! Numbers that several recordings share: a segment has those of the recording that it was cut of.

use std::ops::{Deref, Range};
use std::sync::Arc;

/// Some of the numbers of a list that is kept once.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    all: Arc<Vec<f64>>,
    own: Range<usize>,
}

impl Shared {
    /// These of them, counted in its own.
    pub fn part(&self, range: Range<usize>) -> Self {
        assert!(range.start <= range.end && range.end <= self.own.len());
        Self {
            all: Arc::clone(&self.all),
            own: self.own.start + range.start..self.own.start + range.end,
        }
    }

    /// As a list of their own: the same one where they are all of it.
    pub fn whole(&self) -> Arc<Vec<f64>> {
        match self.own.len() == self.all.len() {
            true => Arc::clone(&self.all),
            false => Arc::new(self.to_vec()),
        }
    }

    /// To be changed; copied where somebody else has them too.
    pub fn make_mut(&mut self) -> &mut Vec<f64> {
        if self.own.len() < self.all.len() {
            *self = self.to_vec().into();
        }
        Arc::make_mut(&mut self.all)
    }
}

impl From<Vec<f64>> for Shared {
    fn from(values: Vec<f64>) -> Self {
        Self {
            own: 0..values.len(),
            all: Arc::new(values),
        }
    }
}

impl Deref for Shared {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.all[self.own.clone()]
    }
}

impl PartialEq for Shared {
    fn eq(&self, other: &Self) -> bool {
        let same = Arc::ptr_eq(&self.all, &other.all) && self.own == other.own;
        same || **self == **other
    }
}
