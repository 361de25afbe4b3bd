//! Numbers that several recordings share without a copy: a segment uses the numbers of the recording from which it was cut.

use std::ops::{Deref, Range};
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use crate::min_max::MinMax;

/// Number of samples that one thread processes at a time.
pub(super) const SAMPLES_A_THREAD: usize = 1 << 16;

/// A part of a list of numbers that several recordings share.
#[derive(Clone, Debug, Default)]
pub(super) struct Shared {
    all: Arc<Vec<f64>>,
    part: Range<usize>,
}

impl Shared {
    pub fn part(&self, range: Range<usize>) -> Self {
        assert!(range.start <= range.end && range.end <= self.part.len());
        Self {
            all: Arc::clone(&self.all),
            part: self.part.start + range.start..self.part.start + range.end,
        }
    }

    /// Returns the rows in these ranges; a row has `width` numbers. A single range is shared without a copy, several ranges
    /// are copied.
    pub fn rows(&self, ranges: &[Range<usize>], width: usize) -> Self {
        let numbers = |range: &Range<usize>| range.start * width..range.end * width;
        match ranges {
            [one] => self.part(numbers(one)),
            _ => {
                let rows = ranges.iter().flat_map(|range| &self[numbers(range)]);
                rows.copied().collect::<Vec<f64>>().into()
            }
        }
    }

    /// Returns the numbers as a list of their own. A part of a longer list is copied.
    pub fn whole(&self) -> Arc<Vec<f64>> {
        if self.part.len() == self.all.len() {
            Arc::clone(&self.all)
        } else {
            Arc::new(self.to_vec())
        }
    }

    /// Returns the numbers for changing them. Numbers that other recordings share are copied first.
    pub fn make_mut(&mut self) -> &mut Vec<f64> {
        if self.part.len() < self.all.len() {
            *self = self.to_vec().into();
        }
        Arc::make_mut(&mut self.all)
    }
}

impl From<Vec<f64>> for Shared {
    fn from(values: Vec<f64>) -> Self {
        Self { part: 0..values.len(), all: Arc::new(values) }
    }
}

impl Deref for Shared {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.all[self.part.clone()]
    }
}

impl PartialEq for Shared {
    fn eq(&self, other: &Self) -> bool {
        let same = Arc::ptr_eq(&self.all, &other.all) && self.part == other.part;
        same || **self == **other
    }
}

/// Rows of numbers with the range (minimum and maximum) of each column. The ranges are computed when they are first needed.
#[derive(Clone, Debug)]
pub(super) struct Ranged {
    values: Shared,
    width: usize,
    ranges: OnceLock<Vec<MinMax>>,
}

impl Ranged {
    pub fn new(values: Vec<f64>, width: usize) -> Self {
        Self { ranges: OnceLock::from(ranges(&values, width)), values: values.into(), width }
    }

    pub fn subtract(&mut self, offsets: &[f64]) {
        for row in self.values.make_mut().chunks_exact_mut(offsets.len().max(1)) {
            let values = row.iter_mut().zip(offsets);
            values.for_each(|(value, offset)| *value -= offset);
        }
        self.ranges = OnceLock::new();
    }

    pub fn ranges(&self) -> &[MinMax] {
        self.ranges.get_or_init(|| ranges(&self.values, self.width))
    }

    pub fn rows(&self, picked: &[Range<usize>]) -> Self {
        let values = self.values.rows(picked, self.width);
        Self { values, width: self.width, ranges: OnceLock::new() }
    }
}

impl Deref for Ranged {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.values
    }
}

impl PartialEq for Ranged {
    fn eq(&self, other: &Self) -> bool {
        (self.width, &self.values) == (other.width, &other.values)
    }
}

/// Extends the range of each column in `all` by the range of the same column in `own`.
pub(super) fn join(all: &mut [MinMax], more: &[MinMax]) {
    all.iter_mut().zip(more).for_each(|(all, more)| *all = all.joined(*more));
}

fn ranges(rows: &[f64], width: usize) -> Vec<MinMax> {
    let none = || vec![MinMax::NONE; width];
    let with = |mut ranges: Vec<MinMax>, rows: &[f64]| {
        for row in rows.chunks_exact(width.max(1)) {
            for (range, value) in ranges.iter_mut().zip(row) {
                *range = range.with(*value);
            }
        }
        ranges
    };
    let joined = |mut all: Vec<MinMax>, more: Vec<MinMax>| {
        join(&mut all, &more);
        all
    };
    rows.par_chunks(width.max(1) * SAMPLES_A_THREAD).fold(none, with).reduce(none, joined)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_part_has_the_ranges_of_its_rows() {
        let n = 5 * SAMPLES_A_THREAD / 2;
        let values = (0..2 * n).map(|k| (0.37 * k as f64).sin() + 1e-6 * k as f64);
        let all = Ranged::new(values.collect(), 2);
        assert_eq!(all.ranges(), ranges(&all, 2));
        let inner = all.rows(std::slice::from_ref(&(7..n - 9)));
        for range in
            [0..n - 16, 3..9, SAMPLES_A_THREAD - 7..2 * SAMPLES_A_THREAD - 7, 100..n - 50, 5..5]
        {
            let part = inner.rows(std::slice::from_ref(&range));
            assert_eq!(&*part, &inner[2 * range.start..2 * range.end]);
            let columns = |at| part.iter().skip(at).step_by(2).collect();
            assert_eq!(part.ranges(), [columns(0), columns(1)], "{range:?}");
        }
        let both = inner.rows(&[3..9, 70_000..70_010]);
        assert_eq!((both.len(), both.ranges()), (32, &ranges(&both, 2)[..]));
        let none = Ranged::new(Vec::new(), 0);
        let picked = std::slice::from_ref(&(10..3 * SAMPLES_A_THREAD));
        assert_eq!(none.rows(picked).ranges(), []);
    }
}
