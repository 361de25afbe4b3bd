//! Causes of calibration errors, and sets of them.

use serde::Serialize;

/// Cause of a part of the calibration error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, strum::EnumIter)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The gauges do not change in proportion to the load.
    Curvature,
    /// The gauges depend on the direction from which the load came, at any speed.
    Hysteresis,
    /// The gauges go on changing for some time after the load has changed.
    Creep,
    /// The gauges come earlier or later than the reference.
    Lag,
    /// The zeros of the gauges differ between recordings.
    Zeros,
    /// The zeros of the gauges change steadily during a recording.
    Drift,
    /// The sensitivities of the gauges differ between recordings.
    Sensitivity,
    /// The gauges change with an auxiliary channel, such as the temperature.
    Temperature,
}

impl Cause {
    /// Causes that columns of the samples describe.
    pub(crate) const WITH_COLUMNS: [Self; 5] =
        [Self::Curvature, Self::Hysteresis, Self::Creep, Self::Lag, Self::Temperature];
    /// Causes that give each unit a value of its own: an offset, a slope in time, a factor.
    pub(crate) const OF_UNITS: [Self; 3] = [Self::Zeros, Self::Drift, Self::Sensitivity];

    /// Returns the name of the cause, as it is written in a sentence. `are_segments` is true if segments of recordings are
    /// left out.
    pub fn name(self, are_segments: bool) -> &'static str {
        match self {
            Self::Curvature => "curvature",
            Self::Hysteresis => "hysteresis",
            Self::Creep => "creep",
            Self::Lag => "lag",
            Self::Zeros if are_segments => "slow changes (zero, drift, slow creep)",
            Self::Zeros => "zeros between recordings",
            Self::Drift => "drift",
            Self::Sensitivity => "sensitivity",
            Self::Temperature => "auxiliary channels",
        }
    }

    /// True for hysteresis, creep and lag, which one speed of loading tells apart less well than their sum.
    pub fn is_history(self) -> bool {
        matches!(self, Self::Hysteresis | Self::Creep | Self::Lag)
    }
}

/// Set of causes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Causes(usize);

impl Causes {
    /// Number of sets of all causes together.
    pub const N_SETS: usize = 1 << (Cause::Temperature as usize + 1);

    pub fn index(self) -> usize {
        self.0
    }

    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    pub fn contains(self, cause: Cause) -> bool {
        self.0 & (1 << cause as usize) != 0
    }

    pub fn with(self, cause: Cause) -> Self {
        Self(self.0 | (1 << cause as usize))
    }

    pub fn without(self, cause: Cause) -> Self {
        Self(self.0 & !(1 << cause as usize))
    }

    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns all subsets of these causes, the empty one first.
    pub fn subsets(of: &[Cause]) -> Vec<Self> {
        of.iter().fold(vec![Self::default()], |sets, cause| {
            let with = sets.iter().map(|set| set.with(*cause));
            sets.iter().copied().chain(with).collect()
        })
    }
}
