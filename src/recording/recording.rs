//! One uninterrupted run of a sensor.
//!
//! Guarantees, checked by the constructor: there is at least one sample, numbers are finite, times never go back, and axes are
//! in the order of [`Axis`] without repeats. Gauges, reference load and times may each be missing.

use crate::{
    column::column,
    min_max::MinMax,
    recording::{
        auxiliary::AuxiliaryTable,
        axis::Axis,
        frame::SensorFrame,
        gap::gap_by_steps,
        kinetics::Weight,
        left_out::LeftOut,
        median::median,
        shared::{Ranged, SAMPLES_A_THREAD, Shared, join},
        tare::Tare,
    },
};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

/// Maximum number of rows of a table of readings without times. A longer table is probably a log.
pub(crate) const MOST_READINGS: usize = 2000;

/// Origin of a recording's samples.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// A file.
    File(PathBuf),
    /// The built-in simulated sensor.
    Simulated,
}

impl Source {
    /// Returns the path of the file, if the recording was read from one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Simulated => None,
        }
    }
}

/// What puts the samples of a recording in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// Measured times.
    Times,
    /// Rows of the file. The times only count the rows.
    Rows,
    /// Nothing: all samples were taken under one constant load. The times are numbers of rows of the file.
    Case,
}

/// What a calibration still needs from the recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum Missing {
    /// No recording has a gauge.
    #[error("no gauge yet: which channels are the gauges?")]
    Gauges,
    /// No recording with gauges has a reference load.
    #[error("no load yet: which channel is the reference?")]
    Load,
}

/// One uninterrupted run: times (s), gauge readings in the unit of the logger, and the reference load (N, N·m). Each of the
/// three may be missing.
///
/// In the paper of Koike et al. (2019), the loads of one sample are L in Eq. 1, and its gauge readings are S in Eq. 2.
///
/// **Shapes** gauges and loads have one row for each sample, with `n_gauges` and `n_axes` columns. Without gauges,
/// `n_gauges` is 0, and without a reference, `n_axes` is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    name: String,
    source: Source,
    order: Order,
    times: Shared,
    gauge_names: Vec<String>,
    gauge_units: Vec<String>,
    gauges: Ranged,
    axes: Vec<Axis>,
    pub(super) loads: Ranged,
    /// Frame of the loads; `None` for the frame in which they were measured.
    pub(super) frame: Option<SensorFrame>,
    /// Weight from which the loads were computed, in the gauge frame; `None` if the loads were measured.
    pub(super) tool: Option<Weight>,
    pub(crate) auxiliary: AuxiliaryTable,
    /// Channels that are only shown. No fit uses them, and their values may be NaN.
    others: AuxiliaryTable,
    rate_hz: Option<f64>,
    tare: Option<Tare>,
    /// Whole seconds that were subtracted from the times in the file. [`Self::clock_time`] adds them again.
    pub(crate) zero_secs: f64,
    /// Minimum length of a pause that ends a recording (s), as used when the file was read. `None` to compute the length from
    /// the times.
    pub(crate) gap_secs: Option<f64>,
    /// Mean unloaded reading of each gauge that taring subtracted; empty without a tare.
    offsets: Vec<f64>,
    left_out: Option<LeftOut>,
    /// Number of the run in the file from which pauses or late rows cut this recording; `None` if the recording is no such
    /// piece.
    pub(crate) run: Option<usize>,
    pub(crate) group: Option<String>,
    /// Index of the file's column of each channel: gauges, loads, auxiliary channels, channels that are only shown. Empty if it
    /// is not known.
    pub(crate) columns: Vec<usize>,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordingError {
    #[error("{name}: no samples")]
    NoSamples { name: String },
    #[error("{name}: there are {actual} {what} values, but {expected} are needed")]
    Shape { name: String, what: &'static str, expected: usize, actual: usize },
    #[error(
        "{name}: each load axis may occur once, and the axes must be in the order Fx Fy Fz Mx My Mz"
    )]
    AxisOrder { name: String },
    #[error("{name}: sample {sample} has a {what} that is not a finite number")]
    NotFinite { name: String, what: &'static str, sample: usize },
    #[error("{name}: sample {sample} has an earlier time than the sample before")]
    TimeGoesBack { name: String, sample: usize },
    #[error(
        "{name}: the {what} are {actual}, but {expected} in the other recordings; use recordings of one sensor with the same reference axes"
    )]
    Layout { name: String, what: &'static str, expected: String, actual: String },
    #[error(
        "{name}: the sensor frame adds a part of {missing} to {axis}, but {missing} was not measured; record {missing} too, or change the turn and the shift of the frame"
    )]
    Frame { name: String, axis: Axis, missing: Axis },
    #[error(
        "{name}: taring is not possible, because there is no sample from {from} s to {to} s; the recording is {duration_secs} s long"
    )]
    NothingToTare { name: String, from: f64, to: f64, duration_secs: f64 },
    #[error(
        "{name}: taring is not possible, because the samples have no times; subtract the unloaded readings in the table, or fit a calibration with an offset"
    )]
    NoTimes { name: String },
    #[error(
        "{name}: taring is not possible, because {why}; enter when the sensor was unloaded, in seconds from the start of the recording"
    )]
    NeverUnloaded { name: String, why: &'static str },
}

impl Recording {
    /// Creates a recording. Returns [`RecordingError`] if a guarantee of this module does not hold.
    pub fn new(
        name: impl Into<String>,
        source: Source,
        times: Vec<f64>,
        gauge_names: Vec<String>,
        gauges: Vec<f64>,
        axes: Vec<Axis>,
        loads: Vec<f64>,
    ) -> Result<Self, RecordingError> {
        let name = name.into();
        let n = times.len();
        if n == 0 {
            return Err(RecordingError::NoSamples { name });
        }
        check(&name, "time", [n, 1], &times)?;
        check(&name, "gauge", [n, gauge_names.len()], &gauges)?;
        check(&name, "load", [n, axes.len()], &loads)?;
        if !axes.is_sorted_by(|a, b| a < b) {
            return Err(RecordingError::AxisOrder { name });
        }
        if let Some(at) = times.windows(2).position(|pair| pair[1] < pair[0]) {
            return Err(RecordingError::TimeGoesBack { name, sample: at + 1 });
        }
        Ok(Self {
            rate_hz: rate_hz(&times),
            tare: None,
            frame: None,
            tool: None,
            zero_secs: 0.0,
            gap_secs: None,
            offsets: Vec::new(),
            left_out: None,
            run: None,
            group: None,
            columns: Vec::new(),
            auxiliary: AuxiliaryTable::default(),
            others: AuxiliaryTable::default(),
            name,
            source,
            order: Order::Times,
            times: times.into(),
            gauge_units: vec![String::new(); gauge_names.len()],
            gauges: Ranged::new(gauges, gauge_names.len()),
            gauge_names,
            loads: Ranged::new(loads, axes.len()),
            axes,
        })
    }

    /// Returns the recording with labels for the units of its gauges, such as `mV/V`; an unknown unit is empty. Without
    /// exactly one label for each gauge, the recording is returned unchanged.
    pub fn with_gauge_units(mut self, units: Vec<String>) -> Self {
        if units.len() == self.gauge_names.len() {
            self.gauge_units = units;
        }
        self
    }

    /// Returns the recording with auxiliary channels and their units; an unknown unit is empty. `values` has one row for each
    /// sample. Returns [`RecordingError`] if a number is missing or not finite.
    pub fn with_auxiliary(
        mut self,
        names: Vec<String>,
        units: Vec<String>,
        values: Vec<f64>,
    ) -> Result<Self, RecordingError> {
        check(&self.name, "auxiliary channel", [self.n_samples(), names.len()], &values)?;
        self.auxiliary = AuxiliaryTable::new(names, units, values);
        Ok(self)
    }

    /// Returns the recording with channels that are only shown, such as a displacement, and their units; an unknown unit is
    /// empty. `values` has one row for each sample; a missing value is NaN. Returns [`RecordingError`] if there are fewer or more
    /// values.
    pub fn with_others(
        mut self,
        names: Vec<String>,
        units: Vec<String>,
        values: Vec<f64>,
    ) -> Result<Self, RecordingError> {
        check_shape(&self.name, "other channel", [self.n_samples(), names.len()], &values)?;
        self.others = AuxiliaryTable::new(names, units, values);
        Ok(self)
    }

    /// Returns the recording with only the named auxiliary channels, in this order. The error is the first name that is not a
    /// channel.
    pub(crate) fn with_auxiliary_of<'a>(&self, names: &'a [String]) -> Result<Self, &'a str> {
        let mut picked = self.clone();
        if names != self.auxiliary.names() {
            picked.auxiliary = self.auxiliary.picked(names)?;
        }
        Ok(picked)
    }

    /// Returns the auxiliary channels.
    pub fn auxiliary(&self) -> &AuxiliaryTable {
        &self.auxiliary
    }

    /// Returns the channels that are only shown. No fit uses them, and their values may be NaN.
    pub fn others(&self) -> &AuxiliaryTable {
        &self.others
    }

    pub(crate) fn less_offsets(mut self, offsets: &[f64], tare: Tare) -> Self {
        self.gauges.subtract(offsets);
        self.tare = Some(tare);
        self.offsets.resize(offsets.len(), 0.0);
        let all = self.offsets.iter_mut().zip(offsets);
        all.for_each(|(all, offset)| *all += offset);
        self
    }

    /// Returns the recording as samples without times that were all taken under one load. Its times must be the numbers of
    /// the rows in the file.
    pub fn without_times(self) -> Self {
        Self { order: Order::Case, rate_hz: None, ..self }
    }

    /// Returns the recording as samples without times, in the order of the rows of a file. Its times must count the rows.
    pub fn in_row_order(self) -> Self {
        Self { order: Order::Rows, rate_hz: None, ..self }
    }

    /// Joins several recordings without times to one recording. Panics if there is no recording.
    pub(crate) fn table_of(cases: &[&Self]) -> Self {
        let all = |values: fn(&Self) -> &[f64]| -> Vec<f64> {
            let values = cases.iter().flat_map(|case| values(case));
            values.copied().collect()
        };
        let first = cases[0];
        let gauges = Ranged::new(all(Self::gauges), first.n_gauges());
        let loads = Ranged::new(all(Self::loads), first.axes.len());
        let auxiliary = all(|case| case.auxiliary.values()).into();
        let others = all(|case| case.others.values()).into();
        let n: usize = cases.iter().map(|case| case.n_samples()).sum();
        let times: Vec<f64> = (0..n).map(|row| row as f64).collect();
        let stem = first.source.path().and_then(Path::file_stem);
        let name = stem.map_or(first.name.clone(), |stem| stem.to_string_lossy().into_owned());
        let tables = [first.auxiliary.with_values(auxiliary), first.others.with_values(others)];
        first.with_samples(name, times.into(), gauges, loads, tables)
    }

    /// Joins load cases of one table to one recording with the rows in the order of the file. Panics if there is no recording.
    pub(crate) fn in_file_order(cases: &[&Self]) -> Self {
        let table = Self::table_of(cases);
        let rows: Vec<f64> = cases.iter().flat_map(|case| case.times()).copied().collect();
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by(|a, b| rows[*a].total_cmp(&rows[*b]));
        let order: Vec<_> = order.into_iter().map(|row| row..row + 1).collect();
        let sorted = table.of_ranges(&order, table.name.clone());
        Self { times: table.times, ..sorted.in_row_order() }
    }

    /// Returns true if the samples have no times. The recording then has no dwells, and no earlier samples for a look-back.
    pub fn is_static(&self) -> bool {
        self.order != Order::Times
    }

    /// Returns true if all samples were taken under one load, and have no order. The recording then has no loops either.
    pub fn is_load_case(&self) -> bool {
        self.order == Order::Case
    }

    /// Returns true if the samples are readings of a table without times. A longer recording without times is a log.
    pub fn is_table(&self) -> bool {
        self.is_static() && self.n_samples() <= MOST_READINGS
    }

    /// Returns what a calibration needs and this recording does not have.
    pub fn missing(&self) -> Option<Missing> {
        match (self.n_gauges(), self.has_reference()) {
            (0, _) => Some(Missing::Gauges),
            (_, false) => Some(Missing::Load),
            _ => None,
        }
    }

    pub(crate) fn tared_by(&self, gauge: usize) -> f64 {
        self.offsets.get(gauge).copied().unwrap_or(0.0)
    }

    /// Returns the description of the samples that were left out, if any were.
    pub fn left_out(&self) -> Option<&LeftOut> {
        self.left_out.as_ref()
    }

    /// Returns the time (s) of a sample on the clock of the file.
    pub fn clock_time(&self, sample: usize) -> f64 {
        self.zero_secs + self.times[sample]
    }

    /// Returns the minimum length of a pause that ends a recording (s): the value used when the file was read, else a
    /// multiple of the median time step.
    pub fn gap_secs(&self) -> f64 {
        self.gap_secs.unwrap_or_else(|| gap_by_steps(&self.times))
    }

    /// Returns the interval by which the gauges were tared, or `None` if the readings are as measured.
    pub fn tare(&self) -> Option<Tare> {
        self.tare
    }

    /// Returns the name: the file name without extension, with a number if the file holds several recordings.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the origin of the samples: a file, or the built-in simulated sensor.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Returns the number of samples, at least one.
    pub fn n_samples(&self) -> usize {
        self.times.len()
    }

    /// Returns the sample times (s). They never go back. [`Self::clock_time`] returns times on the clock of the file.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    pub(crate) fn shared_times(&self) -> Arc<Vec<f64>> {
        self.times.whole()
    }

    /// Returns the time (s) from the first to the last sample; zero for samples without times.
    pub fn duration_secs(&self) -> f64 {
        if self.is_static() {
            return 0.0;
        }
        self.times[self.times.len() - 1] - self.times[0]
    }

    /// Returns the sample rate (Hz), the inverse of the median time step. `None` for one sample, or if most steps are zero.
    pub fn rate_hz(&self) -> Option<f64> {
        self.rate_hz
    }

    /// Returns the names of the gauges, in the order of columns.
    pub fn gauge_names(&self) -> &[String] {
        &self.gauge_names
    }

    /// Returns the labels of the gauges' units; an unknown unit is empty. Gauge readings are never converted.
    pub fn gauge_units(&self) -> &[String] {
        &self.gauge_units
    }

    /// Returns the number of gauge channels, which may be zero.
    pub fn n_gauges(&self) -> usize {
        self.gauge_names.len()
    }

    /// Returns all gauge readings, one row of `n_gauges` readings for each sample.
    pub fn gauges(&self) -> &[f64] {
        &self.gauges
    }

    /// Returns the gauge readings of sample `k`. Panics if there is no such sample.
    pub fn gauges_at(&self, k: usize) -> &[f64] {
        &self.gauges[k * self.n_gauges()..(k + 1) * self.n_gauges()]
    }

    /// Returns the axes of the reference load; empty without a reference.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Returns the load of each sample on one axis; `None` without a reference for this axis.
    pub(crate) fn load(
        &self,
        axis: Axis,
    ) -> Option<impl ExactSizeIterator<Item = f64> + Clone + '_> {
        let at = self.axes.iter().position(|known| *known == axis)?;
        Some(column(&self.loads, self.axes.len(), at))
    }

    /// Returns the start of the recording (s since 1970). `None` if the file's clock does not count from 1970.
    pub fn started(&self) -> Option<f64> {
        let first = self.clock_time(0);
        (1e9..1e10).contains(&first).then_some(first)
    }

    /// Returns the name of the recording's group, if the file has a group column.
    pub fn group(&self) -> Option<&str> {
        self.group.as_deref()
    }

    /// Returns true if the reference load is known.
    pub fn has_reference(&self) -> bool {
        !self.axes.is_empty()
    }

    /// Returns the reference load, one row of `n_axes` loads (N, N·m) for each sample.
    pub fn loads(&self) -> &[f64] {
        &self.loads
    }

    pub(crate) fn gauge_ranges(&self) -> &[MinMax] {
        self.gauges.ranges()
    }

    /// Returns the range of the reference load of each axis.
    pub fn load_ranges(&self) -> &[MinMax] {
        self.loads.ranges()
    }

    /// Returns every `step`-th sample from the first, as in pattern B of Koike et al. (2019, section 4.2.2). With a step of 0
    /// or 1, or for samples under one load without times, all samples are returned.
    pub fn decimated(&self, step: usize) -> Self {
        if self.is_load_case() || step <= 1 {
            return self.clone();
        }
        let kept: Vec<_> = (0..self.n_samples()).step_by(step).map(|k| k..k + 1).collect();
        let mut kept = self.of_ranges(&kept, self.name.clone());
        kept.gap_secs = self.gap_secs.map(|gap_secs| gap_secs * step as f64);
        kept
    }

    /// Splits the recording in time. The first part has `⌊fraction · n⌋` of the `n` samples. `None` for samples under one
    /// load without times, or if a part would be empty. A look-back never takes earlier samples from beyond the cut.
    pub fn split(&self, fraction: f64) -> Option<(Self, Self)> {
        if self.is_load_case() {
            return None;
        }
        let n = self.n_samples();
        let cut = (fraction * n as f64) as usize; // floors, and NaN becomes 0
        (0 < cut && cut < n).then(|| {
            (
                self.picked(0..cut, format!("{} (first part)", self.name)),
                self.picked(cut..n, format!("{} (rest)", self.name)),
            )
        })
    }

    /// Returns a range of samples as a separate recording. A look-back cannot use the samples before the range.
    pub(crate) fn segment(&self, samples: Range<usize>) -> Self {
        self.picked(samples, self.name.clone())
    }

    /// Splits the recording in time into `count` segments of nearly equal length, or fewer if there are fewer samples. A
    /// look-back never takes earlier samples from beyond a cut.
    pub fn segments(&self, count: usize) -> Vec<Self> {
        let n = self.n_samples();
        let at = |segment: usize| segment * n / count;
        let ranges = (0..count).map(|segment| at(segment)..at(segment + 1));
        let ranges = ranges.filter(|range| !range.is_empty()).enumerate();
        let named = |at: usize| format!("{} (segment {})", self.name, at + 1);
        ranges.map(|(at, range)| self.picked(range, named(at))).collect()
    }

    fn picked(&self, samples: Range<usize>, name: String) -> Self {
        self.of_ranges(std::slice::from_ref(&samples), name)
    }

    /// Returns the recording without the samples in these ranges, which must be in order. Where a long pause separates the
    /// remaining samples, a new recording starts.
    pub(crate) fn without(&self, samples: &[Range<usize>], left_out: &LeftOut) -> Vec<Self> {
        let (times, gap_secs) = (self.times(), self.gap_secs());
        let mut parts: Vec<Vec<Range<usize>>> = Vec::new();
        let mut next = 0;
        for range in samples.iter().chain([&(self.n_samples()..self.n_samples())]) {
            let follows = |part: &Vec<Range<usize>>| {
                let before = part[part.len() - 1].end - 1;
                self.is_static() || times[next] - times[before] <= gap_secs
            };
            let kept = next..range.start;
            if !kept.is_empty() {
                match parts.last_mut().filter(|part| follows(part)) {
                    Some(part) => part.push(kept),
                    None => parts.push(vec![kept]),
                }
            }
            next = next.max(range.end);
        }
        let n_parts = parts.len();
        let part = |(at, ranges): (usize, Vec<Range<usize>>)| {
            let name = match n_parts {
                1 => self.name.clone(),
                _ => format!("{} (part {})", self.name, at + 1),
            };
            let mut part = self.of_ranges(&ranges, name);
            (part.gap_secs, part.left_out) = (Some(gap_secs), Some(left_out.clone()));
            part
        };
        parts.into_iter().enumerate().map(part).collect()
    }

    fn of_ranges(&self, ranges: &[Range<usize>], name: String) -> Self {
        let times = self.times.rows(ranges, 1);
        let (gauges, loads) = (self.gauges.rows(ranges), self.loads.rows(ranges));
        let tables = [&self.auxiliary, &self.others].map(|table| table.rows(ranges));
        self.with_samples(name, times, gauges, loads, tables)
    }

    fn with_samples(
        &self,
        name: String,
        times: Shared,
        gauges: Ranged,
        loads: Ranged,
        [auxiliary, others]: [AuxiliaryTable; 2],
    ) -> Self {
        Self {
            name,
            rate_hz: rate_hz(&times).filter(|_| !self.is_static()),
            times,
            gauges,
            loads,
            auxiliary,
            others,
            ..self.clone()
        }
    }
}

fn check(
    name: &str,
    what: &'static str,
    [n, width]: [usize; 2],
    values: &[f64],
) -> Result<(), RecordingError> {
    check_shape(name, what, [n, width], values)?;
    match first_not_finite(values) {
        Some(at) => {
            Err(RecordingError::NotFinite { name: name.to_owned(), what, sample: at / width })
        }
        None => Ok(()),
    }
}

fn check_shape(
    name: &str,
    what: &'static str,
    [n, width]: [usize; 2],
    values: &[f64],
) -> Result<(), RecordingError> {
    let (expected, actual) = (n * width, values.len());
    if actual == expected {
        return Ok(());
    }
    Err(RecordingError::Shape { name: name.to_owned(), what, expected, actual })
}

fn first_not_finite(values: &[f64]) -> Option<usize> {
    let parts = values.par_chunks(SAMPLES_A_THREAD).enumerate();
    parts.find_map_first(|(part, values)| {
        let at = values.iter().position(|value| !value.is_finite())?;
        Some(part * SAMPLES_A_THREAD + at)
    })
}

/// Maximum number of time steps from which the sample rate is computed. In longer recordings, runs of steps are used that are
/// spread evenly over the recording.
const RATE_STEPS: usize = 1 << 20;
/// Number of successive time steps in such a run. It is larger than the number of samples that a logger writes in one burst.
const RATE_RUN: usize = 1 << 12;

fn rate_hz(times: &[f64]) -> Option<f64> {
    let n_runs = times.len().div_ceil(RATE_RUN);
    let each = times.len().div_ceil(RATE_STEPS);
    let runs = (0..n_runs).step_by(each).map(|run| {
        let start = run * RATE_RUN;
        &times[start..(start + RATE_RUN + 1).min(times.len())]
    });
    let steps = runs.flat_map(|run| run.windows(2).map(|pair| pair[1] - pair[0]));
    let step = median(steps)?;
    (step > 0.0).then(|| 1.0 / step)
}

pub(crate) fn load_ranges<'a>(
    recordings: impl Iterator<Item = &'a Recording>,
    n_axes: usize,
) -> Vec<MinMax> {
    let mut all = vec![MinMax::NONE; n_axes];
    recordings.for_each(|recording| join(&mut all, recording.load_ranges()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(times: Vec<f64>) -> Result<Recording, RecordingError> {
        let gauges = times.iter().map(|t| 2.0 * t).collect();
        let loads = times.iter().map(|t| 3.0 * t).collect();
        Recording::new(
            "ramp",
            Source::Simulated,
            times,
            vec!["S1".into()],
            gauges,
            vec![Axis::Fz],
            loads,
        )
    }

    #[test]
    fn broken_parts_are_refused() {
        assert!(matches!(ramp(vec![]), Err(RecordingError::NoSamples { .. })));
        assert!(matches!(
            ramp(vec![0.0, f64::NAN]),
            Err(RecordingError::NotFinite { what: "time", sample: 1, .. })
        ));
        assert!(matches!(
            ramp(vec![0.0, 2.0, 1.0]),
            Err(RecordingError::TimeGoesBack { sample: 2, .. })
        ));
        let twice = Recording::new(
            "twice",
            Source::Simulated,
            vec![0.0],
            vec!["S1".into()],
            vec![0.0],
            vec![Axis::Fz, Axis::Fx],
            vec![0.0; 2],
        );
        assert!(matches!(twice, Err(RecordingError::AxisOrder { .. })));
    }

    #[test]
    fn gauges_reference_and_times_may_be_missing() {
        let with = |gauges: &[&str], axes: &[Axis]| {
            let gauges = gauges.iter().map(|&gauge| gauge.to_owned()).collect::<Vec<_>>();
            let (n_gauges, n_axes) = (gauges.len(), axes.len());
            let times = vec![0.0, 1.0, 2.0];
            let (readings, loads) = (vec![1.0; 3 * n_gauges], vec![1.0; 3 * n_axes]);
            Recording::new("a", Source::Simulated, times, gauges, readings, axes.to_vec(), loads)
                .unwrap()
        };
        assert_eq!(with(&[], &[]).missing(), Some(Missing::Gauges));
        assert_eq!(with(&[], &[Axis::Fz]).missing(), Some(Missing::Gauges));
        assert_eq!(with(&["S1"], &[]).missing(), Some(Missing::Load));
        assert_eq!(with(&["S1"], &[Axis::Fz]).missing(), None);
        let others = || (vec!["x".to_owned(), "y".to_owned()], vec![String::new(); 2]);
        let values = vec![0.0, 1.0, 2.0, f64::NAN, 4.0, 5.0];
        let rows = with(&[], &[]).with_others(others().0, others().1, values).unwrap();
        let rows = rows.in_row_order();
        assert!(rows.is_static() && !rows.is_load_case() && rows.rate_hz().is_none());
        let (first, rest) = rows.split(0.4).unwrap();
        assert_eq!(
            (first.others().values(), rest.others().at(1)),
            (&[0.0, 1.0][..], &[4.0, 5.0][..])
        );
        assert_eq!(rows.decimated(2).others().values(), [0.0, 1.0, 4.0, 5.0]);
        assert!(rows.clone().without_times().split(0.4).is_none());
        let short = rows.with_others(others().0, others().1, vec![0.0; 5]);
        assert!(matches!(short, Err(RecordingError::Shape { .. })));
    }

    #[test]
    fn rate_is_the_median_step_and_survives_a_pause() {
        let recording = ramp(vec![0.0, 0.1, 0.2, 0.3, 5.0]).unwrap();
        assert!((recording.rate_hz().unwrap() - 10.0).abs() < 1e-9);
        assert_eq!(ramp(vec![1.0]).unwrap().rate_hz(), None);
        assert_eq!(ramp(vec![1.0, 1.0, 1.0]).unwrap().rate_hz(), None);
    }

    #[test]
    fn a_segment_shares_numbers_and_a_change_stays_in_the_segment() {
        let recording = ramp((0..10).map(f64::from).collect()).unwrap();
        let segment = recording.segment(4..7);
        assert!(std::ptr::eq(&segment.gauges()[0], &recording.gauges()[4]));
        assert_eq!(*segment.shared_times(), [4.0, 5.0, 6.0]);
        let inner = segment.segment(1..3);
        assert_eq!((inner.times(), inner.loads()), (&[5.0, 6.0][..], &[15.0, 18.0][..]));
        assert_eq!(inner.load_ranges(), [MinMax { min: 15.0, max: 18.0 }]);
        let tared = inner.clone().less_offsets(&[1.0], Tare::Auto);
        assert_eq!(tared.gauges(), [9.0, 11.0]);
        assert_eq!(recording.gauges_at(5), [10.0]);
        let alone = ramp(vec![4.0, 5.0, 6.0]).unwrap();
        assert_eq!(alone.times, segment.times);
        assert_ne!(alone.times, inner.times);
    }

    #[test]
    fn a_sample_of_the_steps_gives_the_rate_of_a_long_recording() {
        let n = 3 * RATE_STEPS + 7;
        let times: Vec<f64> = (0..n).map(|k| k as f64 / 64.0).collect();
        assert_eq!(rate_hz(&times), Some(64.0));
    }

    #[test]
    fn decimation_keeps_every_nth_sample_from_the_first() {
        let recording = ramp((0..25).map(f64::from).collect()).unwrap();
        let kept = recording.decimated(10);
        assert_eq!(kept.times(), [0.0, 10.0, 20.0]);
        assert_eq!(kept.loads(), [0.0, 30.0, 60.0]);
        assert_eq!(recording.decimated(0), recording);
    }

    #[test]
    fn split_gives_the_first_part_and_the_rest() {
        let recording = ramp((0..10).map(f64::from).collect()).unwrap();
        let (first, rest) = recording.split(0.65).unwrap();
        assert_eq!((first.n_samples(), rest.n_samples()), (6, 4));
        assert_eq!(rest.times()[0], 6.0);
        for useless in [0.0, 0.05, 1.0, f64::NAN, -1.0] {
            assert!(recording.split(useless).is_none());
        }
    }
}
