//! Auxiliary channels: quantities that influence the gauges, such as temperature, supply voltage and humidity. All their values
//! are finite. Channels that are only shown have a table of the same kind, in which values may be NaN. A segment of a recording
//! uses the values of the recording without a copy.

use std::ops::Range;

use crate::{min_max::MinMax, recording::shared::Shared};

/// Intervals (start and end in s) in which the last measured value of an auxiliary channel is outdated: older than the
/// minimum length of a pause in the recording.
pub(crate) type Held = Vec<(f64, f64)>;

/// Auxiliary channels of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AuxiliaryTable {
    names: Vec<String>,
    units: Vec<String>,
    values: Shared,
    /// For each channel, the intervals in which its value is outdated, in order of time. An empty list means that no value is
    /// outdated.
    pub(crate) held: Vec<Held>,
}

impl AuxiliaryTable {
    pub(super) fn new(names: Vec<String>, units: Vec<String>, values: Vec<f64>) -> Self {
        Self { names, units, values: values.into(), held: Vec::new() }
    }

    /// Returns true if, at this time (s), the value of at least one channel is outdated: measured earlier or later by more
    /// than the minimum length of a pause.
    pub fn is_held_at(&self, secs: f64) -> bool {
        self.held.iter().any(|spans| {
            let at = spans.partition_point(|(_, to)| *to < secs);
            spans.get(at).is_some_and(|(from, _)| *from <= secs)
        })
    }

    pub fn len(&self) -> usize {
        self.names.len()
    }

    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the unit of each channel; an unknown unit is empty. Temperatures are in °C, voltages in V, humidities in %.
    pub fn units(&self) -> &[String] {
        &self.units
    }

    /// Returns all values: one row for each sample, one column for each channel.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    #[inline]
    pub fn at(&self, k: usize) -> &[f64] {
        &self.values[k * self.len()..][..self.len()]
    }

    pub fn ranges(&self) -> Vec<MinMax> {
        let channel = |at: usize| self.values.iter().skip(at).step_by(self.len());
        (0..self.len()).map(|at| channel(at).collect()).collect()
    }

    /// Returns a description of each channel, such as `T 20.0 to 25.0 °C`.
    pub fn in_words(&self) -> Vec<String> {
        let channels = self.names.iter().zip(&self.units).zip(self.ranges());
        let words = channels.map(|((name, unit), range)| format!("{name} {}", span(range, unit)));
        words.collect()
    }

    /// Returns the table with only the named channels. The error is the first name that is not a channel.
    pub(super) fn picked<'a>(&self, names: &'a [String]) -> Result<Self, &'a str> {
        let places = places(names, &self.names)?;
        let rows = self.values.chunks_exact(self.len().max(1));
        let values = rows.flat_map(|row| places.iter().map(|at| row[*at]));
        let of = |texts: &[String]| places.iter().map(|at| texts[*at].clone()).collect();
        let held = places.iter().filter_map(|at| self.held.get(*at).cloned()).collect();
        let values = values.collect::<Vec<f64>>().into();
        Ok(Self { names: of(&self.names), units: of(&self.units), values, held })
    }

    /// Returns the table with only the samples in these ranges.
    pub(super) fn rows(&self, ranges: &[Range<usize>]) -> Self {
        self.with_values(self.values.rows(ranges, self.len()))
    }

    pub(super) fn with_values(&self, values: Shared) -> Self {
        Self { values, ..self.clone() }
    }
}

/// Returns the index of each of these names in `among`. The error is the first name that is missing there.
pub(crate) fn places<'a>(names: &'a [String], among: &[String]) -> Result<Vec<usize>, &'a str> {
    let place = |name: &'a String| among.iter().position(|known| known == name).ok_or(&**name);
    names.iter().map(place).collect()
}

/// Returns a range of values with its unit as text, such as `21.5 to 24.0 °C`, or `5 V` for a single value. Enough digits are
/// shown to distinguish the two ends.
pub(crate) fn span(range: MinMax, unit: &str) -> String {
    let MinMax { min: low, max: high } = range;
    if low == high {
        return format!("{} {unit}", (low * 1e6).round() / 1e6).trim_end().to_owned();
    }
    let width = range.span().max(1e-3 * range.magnitude()).max(f64::MIN_POSITIVE);
    let digits = (2.0 - width.log10()).clamp(0.0, 6.0) as usize;
    let numbers = format!("{low:.digits$} to {high:.digits$} {unit}");
    numbers.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use crate::recording::axis::Axis;
    use crate::recording::recording::{Recording, Source};

    fn recording() -> Recording {
        let n = 6;
        let times: Vec<f64> = (0..n).map(f64::from).collect();
        let gauges = times.clone();
        let auxiliary = times.iter().flat_map(|t| [20.0 + t, 5.0]).collect();
        Recording::new(
            "warm",
            Source::Simulated,
            times,
            vec!["S1".into()],
            gauges.clone(),
            vec![Axis::Fz],
            gauges,
        )
        .unwrap()
        .with_auxiliary(vec!["T".into(), "U".into()], vec!["°C".into(), "V".into()], auxiliary)
        .unwrap()
    }

    #[test]
    fn a_split_also_splits_the_channels() {
        let recording = recording();
        let (first, rest) = recording.split(0.5).unwrap();
        assert_eq!(first.auxiliary().at(2), [22.0, 5.0]);
        assert_eq!(rest.auxiliary().at(0), [23.0, 5.0]);
        assert!(std::ptr::eq(rest.auxiliary().at(0), recording.auxiliary().at(3)));
        let every_second = recording.decimated(2);
        assert_eq!(every_second.auxiliary().values(), [20.0, 5.0, 22.0, 5.0, 24.0, 5.0]);
        let of = |min: f64, max: f64| crate::min_max::MinMax { min, max };
        assert_eq!(every_second.auxiliary().ranges(), [of(20.0, 24.0), of(5.0, 5.0)]);
        assert_eq!(recording.auxiliary().in_words(), ["T 20.0 to 25.0 °C", "U 5 V"]);
    }

    #[test]
    fn channels_are_picked_by_name() {
        let (_, rest) = recording().split(0.5).unwrap();
        let names = ["U".to_owned(), "T".to_owned()];
        let picked = rest.with_auxiliary_of(&names).unwrap();
        assert_eq!(picked.auxiliary().at(0), [5.0, 23.0]);
        assert_eq!(rest.with_auxiliary_of(&["p".to_owned()]), Err("p"));
    }

    #[test]
    fn missing_and_non_finite_numbers_are_refused() {
        let given = |values| {
            let bare = recording().with_auxiliary(vec!["T".into()], vec![String::new()], values);
            bare.unwrap_err().to_string()
        };
        assert!(given(vec![1.0]).contains("1 auxiliary channel values, but 6"));
        assert!(given(vec![1.0, 1.0, f64::NAN, 1.0, 1.0, 1.0]).contains("sample 2"));
    }
}
