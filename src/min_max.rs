//! The smallest and the largest of some numbers.

/// The smallest and the largest of some numbers (their range). NaN is ignored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MinMax {
    /// Smallest number; +∞ if there are no numbers.
    pub min: f64,
    /// Largest number; −∞ if there are no numbers.
    pub max: f64,
}

impl MinMax {
    /// Range of no numbers. Any other range can be joined to it.
    pub const NONE: Self = Self { min: f64::INFINITY, max: f64::NEG_INFINITY };

    /// Returns the range extended to contain this number.
    #[inline]
    pub fn with(self, value: f64) -> Self {
        Self { min: self.min.min(value), max: self.max.max(value) }
    }

    /// Returns the range that contains both ranges.
    #[inline]
    pub fn joined(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns the range that all these ranges have in common. If there is none, `min` is above `max`.
    pub fn common(all: impl Iterator<Item = Self>) -> Self {
        let part = |a: Self, b: Self| Self { min: a.min.max(b.min), max: a.max.min(b.max) };
        all.reduce(part).unwrap_or(Self::NONE)
    }

    /// Returns the difference between the largest and the smallest number; 0 without numbers.
    pub fn span(self) -> f64 {
        (self.max - self.min).max(0.0)
    }

    /// Returns true if the number is within the range.
    pub fn contains(self, value: f64) -> bool {
        self.min <= value && value <= self.max
    }

    /// Returns the largest magnitude (absolute value) in the range.
    pub fn magnitude(self) -> f64 {
        self.min.abs().max(self.max.abs())
    }

    /// Returns the span of this range as a share of the span of `whole`, at most 1.
    pub fn share_of(self, whole: Self) -> f64 {
        (self.span() / whole.span()).clamp(0.0, 1.0)
    }

    /// Returns the smallest and the largest number; `None` without numbers.
    pub fn ends(self) -> Option<(f64, f64)> {
        (self.min <= self.max).then_some((self.min, self.max))
    }
}

impl FromIterator<f64> for MinMax {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        values.into_iter().fold(Self::NONE, Self::with)
    }
}

impl<'a> FromIterator<&'a f64> for MinMax {
    fn from_iter<I: IntoIterator<Item = &'a f64>>(values: I) -> Self {
        values.into_iter().copied().collect()
    }
}

impl FromIterator<MinMax> for MinMax {
    fn from_iter<I: IntoIterator<Item = MinMax>>(all: I) -> Self {
        all.into_iter().fold(Self::NONE, Self::joined)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_has_no_ends_and_adds_nothing() {
        let none: MinMax = [f64::NAN; 2].into_iter().collect();
        assert_eq!((none, none.ends(), none.span()), (MinMax::NONE, None, 0.0));
        let one = MinMax { min: 3.0, max: 3.0 };
        assert_eq!([none, one, none].into_iter().collect::<MinMax>(), one);
        assert_eq!(MinMax::common([].into_iter()), MinMax::NONE);
    }

    #[test]
    fn one_number_is_both_ends() {
        let one: MinMax = [f64::NAN, -2.0].iter().collect();
        assert_eq!((one.ends(), one.span()), (Some((-2.0, -2.0)), 0.0));
    }

    #[test]
    fn the_common_part_is_in_all_ranges_and_all_are_in_the_joined_one() {
        let parts = [[0.0, 4.0], [-1.0, 3.0], [2.0, 9.0]].map(|ends| ends.iter().collect());
        let common = MinMax::common(parts.into_iter());
        assert_eq!(common.ends(), Some((2.0, 3.0)));
        let all: MinMax = parts.into_iter().collect();
        assert_eq!((all.ends(), all.span()), (Some((-1.0, 9.0)), 10.0));
        let apart = [[0.0, 1.0], [2.0, 3.0]].map(|ends| ends.iter().collect());
        assert_eq!(MinMax::common(apart.into_iter()).ends(), None);
    }
}
