//! Channels of a recording: the time, and each column of its file.

use crate::recording::recording::Recording;

/// Channel of a recording. Gauges, axes of the reference load, auxiliary channels and channels that are only shown are counted
/// from zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(missing_docs, reason = "the names are the documentation")]
pub enum Channel {
    Time,
    Gauge(usize),
    Load(usize),
    Auxiliary(usize),
    Other(usize),
}

impl Channel {
    /// Returns all channels of a recording, the time first.
    pub fn all(recording: &Recording) -> impl Iterator<Item = Self> {
        let gauges = (0..recording.n_gauges()).map(Self::Gauge);
        let loads = (0..recording.axes().len()).map(Self::Load);
        let auxiliary = (0..recording.auxiliary().len()).map(Self::Auxiliary);
        let others = (0..recording.others().len()).map(Self::Other);
        [Self::Time].into_iter().chain(gauges).chain(loads).chain(auxiliary).chain(others)
    }

    /// Returns all channels of a recording, the time first, and then in the order of their columns in the file.
    pub fn in_file_order(recording: &Recording) -> Vec<Self> {
        let mut channels: Vec<_> = Self::all(recording).collect();
        if recording.columns.len() + 1 == channels.len() {
            let mut placed: Vec<_> = recording.columns.iter().zip(channels.drain(1..)).collect();
            placed.sort_by_key(|(column, _)| **column);
            channels.extend(placed.into_iter().map(|(_, channel)| channel));
        }
        channels
    }

    /// Returns rows of values, the number of values in a row, and the place of this channel in a row.
    fn rows(self, recording: &Recording) -> (&[f64], usize, usize) {
        match self {
            Self::Time => (recording.times(), 1, 0),
            Self::Gauge(at) => (recording.gauges(), recording.n_gauges(), at),
            Self::Load(at) => (recording.loads(), recording.axes().len(), at),
            Self::Auxiliary(at) => {
                (recording.auxiliary().values(), recording.auxiliary().len(), at)
            }
            Self::Other(at) => (recording.others().values(), recording.others().len(), at),
        }
    }

    /// Returns true if the recording has this channel.
    pub fn is_in(self, recording: &Recording) -> bool {
        let (_, width, at) = self.rows(recording);
        at < width
    }

    /// Returns the value of sample `k`. Panics if there is no such channel or sample.
    pub fn at(self, recording: &Recording, k: usize) -> f64 {
        let (rows, width, at) = self.rows(recording);
        rows[k * width + at]
    }

    /// Returns the values of all samples. Panics if the recording does not have the channel.
    pub fn values(self, recording: &Recording) -> Vec<f64> {
        let (rows, width, at) = self.rows(recording);
        rows[at..].iter().step_by(width).copied().collect()
    }

    /// Returns the name of the channel. Panics if the recording does not have it.
    pub fn name(self, recording: &Recording) -> &str {
        match self {
            Self::Time if recording.is_static() => "Row",
            Self::Time => "Time",
            Self::Gauge(at) => &recording.gauge_names()[at],
            Self::Load(at) => recording.axes()[at].symbol(),
            Self::Auxiliary(at) => &recording.auxiliary().names()[at],
            Self::Other(at) => &recording.others().names()[at],
        }
    }

    /// Returns the unit of the channel; an unknown unit is empty. Panics if the recording does not have the channel.
    pub fn unit(self, recording: &Recording) -> &str {
        match self {
            Self::Time if recording.is_static() => "",
            Self::Time => "s",
            Self::Gauge(at) => &recording.gauge_units()[at],
            Self::Load(at) => recording.axes()[at].unit(),
            Self::Auxiliary(at) => &recording.auxiliary().units()[at],
            Self::Other(at) => &recording.others().units()[at],
        }
    }

    /// Returns the name with the unit in brackets, as the label of a scale.
    pub fn label(self, recording: &Recording) -> String {
        let (name, unit) = (self.name(recording), self.unit(recording));
        if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
    }
}
