//! One uninterrupted run of a sensor.
//!
//! Guarantees, checked at construction: at least one sample and one gauge, every number finite, times that never go
//! back, axes in [`Axis`] order without repeats.

use crate::min_max::MinMax;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use crate::recording::auxiliary::AuxiliaryTable;
use crate::recording::auxiliary::Held;
use crate::recording::axis::Axis;
use crate::recording::date::{DateSource, Dated, Day};
use crate::recording::gap::gap_by_steps;
use crate::recording::left_out::LeftOut;
use crate::recording::median::median;
use crate::recording::shared::{Ranged, SAMPLES_A_THREAD, Shared, join};
use crate::recording::tare::Tare;

/// Where a recording comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// Read from this file.
    File(PathBuf),
    /// Made by the built-in simulated sensor.
    Simulated,
}

impl Source {
    /// The file, if it is one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Simulated => None,
        }
    }
}

/// Whether the samples of a recording follow one another in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// They do.
    #[default]
    Timed,
    /// They do not: they are the rows of one load case, and their times only count them.
    Static,
}

/// One uninterrupted run: times, gauge channels, and the reference load where it is known.
///
/// **Source** a row of loads is L (Eq. 1), a row of gauges S (Eq. 2).
///
/// **Shapes** times `n`, gauges `n × n_gauges` row-major, loads `n × n_axes` row-major (`n_axes` is 0 without a
/// reference).
///
/// **Units** times (s), loads (N) and (N·m); gauges in whatever unit the logger wrote.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    name: String,
    source: Source,
    sampling: Sampling,
    times: Shared,
    gauge_names: Vec<String>,
    gauge_units: Vec<String>,
    gauges: Ranged,
    axes: Vec<Axis>,
    loads: Ranged,
    auxiliary: AuxiliaryTable,
    rate_hz: Option<f64>,
    tare: Option<Tare>,
    /// What the times are counted from (s since 1970); zero where that is what the file does.
    zero_secs: f64,
    /// Step above which samples are missing (s), where its file says more than its own steps.
    gap_secs: Option<f64>,
    /// What a tare took off the gauges; empty where there was none.
    offsets: Vec<f64>,
    pub(super) left_out: Option<LeftOut>,
    /// The day that its file says.
    file_day: Option<Day>,
    /// The day that the user entered.
    entered_day: Option<Day>,
}

/// Why numbers do not make a recording.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordingError {
    #[error("{name}: no samples")]
    NoSamples { name: String },
    #[error("{name}: no gauge channels")]
    NoGauges { name: String },
    #[error("{name}: {what} holds {actual} numbers where {expected} are needed")]
    Shape { name: String, what: &'static str, expected: usize, actual: usize },
    #[error("{name}: the axes must be distinct and in the order Fx Fy Fz Mx My Mz")]
    AxisOrder { name: String },
    #[error("{name}: sample {sample} has a {what} that is not a finite number")]
    NotFinite { name: String, what: &'static str, sample: usize },
    #[error("{name}: time goes back at sample {sample}")]
    TimeGoesBack { name: String, sample: usize },
}

impl Recording {
    /// Checks the parts and puts them together.
    ///
    /// # Errors
    /// [`RecordingError`] where a guarantee of this type does not hold.
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
        if gauge_names.is_empty() {
            return Err(RecordingError::NoGauges { name });
        }
        for (what, width, values) in
            [("gauge table", gauge_names.len(), &gauges), ("load table", axes.len(), &loads)]
        {
            if values.len() != n * width {
                return Err(RecordingError::Shape {
                    name,
                    what,
                    expected: n * width,
                    actual: values.len(),
                });
            }
        }
        if !axes.is_sorted_by(|a, b| a < b) {
            return Err(RecordingError::AxisOrder { name });
        }
        for (what, width, values) in [
            ("time", 1, &times),
            ("gauge", gauge_names.len(), &gauges),
            ("load", axes.len(), &loads),
        ] {
            if let Some(at) = first_not_finite(values) {
                let sample = at / width;
                return Err(RecordingError::NotFinite { name, what, sample });
            }
        }
        if let Some(at) = times.windows(2).position(|pair| pair[1] < pair[0]) {
            return Err(RecordingError::TimeGoesBack { name, sample: at + 1 });
        }
        Ok(Self {
            rate_hz: rate_hz(&times),
            tare: None,
            zero_secs: 0.0,
            gap_secs: None,
            offsets: Vec::new(),
            left_out: None,
            file_day: None,
            entered_day: None,
            auxiliary: AuxiliaryTable::default(),
            name,
            source,
            sampling: Sampling::Timed,
            times: times.into(),
            gauge_units: vec![String::new(); gauge_names.len()],
            gauges: Ranged::new(gauges, gauge_names.len()),
            gauge_names,
            loads: Ranged::new(loads, axes.len()),
            axes,
        })
    }

    /// The same recording with labels for the gauges' units (`mV/V`, `V`, `counts`, `ohm`); empty where none is known.
    /// Labels for another number of gauges change nothing.
    pub fn with_gauge_units(mut self, units: Vec<String>) -> Self {
        if units.len() == self.gauge_names.len() {
            self.gauge_units = units;
        }
        self
    }

    /// The same recording with channels that are no gauges: temperature, supply, humidity.
    ///
    /// **Shapes** `values` is `n × names` row-major; as many units as names, empty where none is known.
    ///
    /// # Errors
    /// [`RecordingError`] where a number is missing or not finite.
    pub fn with_auxiliary(
        mut self,
        names: Vec<String>,
        units: Vec<String>,
        values: Vec<f64>,
    ) -> Result<Self, RecordingError> {
        let what = "auxiliary channel";
        let expected = self.n_samples() * names.len();
        if values.len() != expected || units.len() != names.len() {
            let (name, actual) = (self.name, values.len());
            return Err(RecordingError::Shape { name, what, expected, actual });
        }
        if let Some(at) = first_not_finite(&values) {
            let (name, sample) = (self.name, at / names.len());
            return Err(RecordingError::NotFinite { name, what, sample });
        }
        self.auxiliary = AuxiliaryTable::new(names, units, values);
        Ok(self)
    }

    /// The same, each of whose auxiliary channels holds a value that is too old to be believed then, from when to when (s) in order.
    pub(crate) fn with_held_auxiliary(mut self, held: Vec<Held>) -> Self {
        self.auxiliary = self.auxiliary.with_held(held);
        self
    }

    /// The recording with these of its auxiliary channels alone, in this order; the first name that it has not, if there is one.
    pub(crate) fn with_auxiliary_of<'a>(&self, names: &'a [String]) -> Result<Self, &'a str> {
        let mut picked = self.clone();
        if names != self.auxiliary.names() {
            let places = self.auxiliary.places(names)?;
            picked.auxiliary = self.auxiliary.picked(&places);
        }
        Ok(picked)
    }

    /// The channels that are no gauges.
    pub fn auxiliary(&self) -> &AuxiliaryTable {
        &self.auxiliary
    }

    /// The recording with these numbers taken off its gauges, one each.
    pub(crate) fn less_offsets(mut self, offsets: &[f64], tare: Tare) -> Self {
        self.gauges.take_off(offsets);
        self.tare = Some(tare);
        self.offsets.resize(offsets.len(), 0.0);
        let all = self.offsets.iter_mut().zip(offsets);
        all.for_each(|(all, offset)| *all += offset);
        self
    }

    /// The recording as the rows of one load case, whose times say nothing.
    pub fn without_times(mut self) -> Self {
        self.sampling = Sampling::Static;
        self.rate_hz = None;
        self
    }

    /// Load cases of one table, row after row.
    ///
    /// # Panics
    /// If there is none.
    pub(crate) fn table_of(cases: &[&Self]) -> Self {
        let all = |values: fn(&Self) -> &[f64]| -> Vec<f64> {
            let values = cases.iter().flat_map(|case| values(case));
            values.copied().collect()
        };
        let first = cases[0];
        let gauges = Ranged::new(all(Self::gauges), first.n_gauges());
        let loads = Ranged::new(all(Self::loads), first.axes.len());
        let auxiliary = all(|case| case.auxiliary.values()).into();
        let n: usize = cases.iter().map(|case| case.n_samples()).sum();
        let times: Vec<f64> = (0..n).map(|row| row as f64).collect();
        let stem = first.source.path().and_then(Path::file_stem);
        let name = stem.map_or(first.name.clone(), |stem| stem.to_string_lossy().into_owned());
        let auxiliary = first.auxiliary.with_values(auxiliary);
        first.with_samples(name, times.into(), gauges, loads, auxiliary)
    }

    /// Whether the samples follow one another in time.
    pub fn sampling(&self) -> Sampling {
        self.sampling
    }

    /// Whether the samples have no times: then nothing of the past, no loop and no dwell can be known.
    pub fn is_static(&self) -> bool {
        self.sampling == Sampling::Static
    }

    /// What a tare took off this gauge.
    pub(crate) fn tared_by(&self, gauge: usize) -> f64 {
        self.offsets.get(gauge).copied().unwrap_or(0.0)
    }

    /// What was left out of it.
    pub fn left_out(&self) -> Option<&LeftOut> {
        self.left_out.as_ref()
    }

    /// The recording with what a gap is in its file (s).
    pub(crate) fn with_gap(mut self, gap_secs: f64) -> Self {
        self.gap_secs = Some(gap_secs);
        self
    }

    /// The recording with what its times are counted from (s since 1970).
    pub(crate) fn with_zero(mut self, zero_secs: f64) -> Self {
        self.zero_secs = zero_secs;
        self
    }

    /// A sample's time on the clock of the file (s).
    pub fn clock_time(&self, sample: usize) -> f64 {
        self.zero_secs + self.times[sample]
    }

    /// Above which step samples are missing (s): what its file was cut by, or by its own steps.
    pub fn gap_secs(&self) -> f64 {
        self.gap_secs.unwrap_or_else(|| gap_by_steps(&self.times))
    }

    /// How the gauges were tared; `None` where they are as they were measured.
    pub fn tare(&self) -> Option<Tare> {
        self.tare
    }

    /// The name shown to people: a file's stem, with a part number where one file holds several recordings.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where the numbers come from.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// How many samples there are, at least one.
    pub fn n_samples(&self) -> usize {
        self.times.len()
    }

    /// Sample times (s), never going back, on the clock of the file; stamps of a date less whole seconds that
    /// [`Self::clock_time`] adds.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// They as a list to be kept, copied only where it is a part of a longer one.
    pub(crate) fn shared_times(&self) -> Arc<Vec<f64>> {
        self.times.whole()
    }

    /// From the first sample to the last (s); none of samples without times.
    pub fn duration_secs(&self) -> f64 {
        if self.is_static() {
            return 0.0;
        }
        self.times[self.times.len() - 1] - self.times[0]
    }

    /// One over the median time step (Hz); `None` with one sample or where most steps are zero.
    pub fn rate_hz(&self) -> Option<f64> {
        self.rate_hz
    }

    /// The gauges' names in column order.
    pub fn gauge_names(&self) -> &[String] {
        &self.gauge_names
    }

    /// Labels of the gauges' units in column order; empty where none is known. Values are never converted.
    pub fn gauge_units(&self) -> &[String] {
        &self.gauge_units
    }

    /// How many gauge channels there are, at least one.
    pub fn n_gauges(&self) -> usize {
        self.gauge_names.len()
    }

    /// All gauges, `n × n_gauges` row-major.
    pub fn gauges(&self) -> &[f64] {
        &self.gauges
    }

    /// The gauges of sample `k`.
    ///
    /// # Panics
    /// If there is no sample `k`.
    pub fn gauges_at(&self, k: usize) -> &[f64] {
        &self.gauges[k * self.n_gauges()..(k + 1) * self.n_gauges()]
    }

    /// The axes whose reference load is known; empty without a reference.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// When it began (s since 1970), where its clock tells the day: by times like those of 2001 to 2286.
    pub fn started(&self) -> Option<f64> {
        let first = self.clock_time(0);
        (1e9..1e10).contains(&first).then_some(first)
    }

    /// The recording with the day that its file says.
    pub(crate) fn with_file_day(mut self, day: Option<Day>) -> Self {
        self.file_day = day;
        self
    }

    /// The recording with the day that the user entered, or with none entered.
    pub fn with_entered_day(mut self, day: Option<Day>) -> Self {
        self.entered_day = day;
        self
    }

    /// The day that the user entered.
    pub fn entered_day(&self) -> Option<Day> {
        self.entered_day
    }

    /// The day on which it was recorded: as entered, else as its file says, else by its clock, else by the name of its file or of the
    /// folder.
    pub fn dated(&self) -> Option<Dated> {
        let in_name = || {
            let path = self.source.path()?;
            let day = |name: Option<&std::ffi::OsStr>| Day::in_text(&name?.to_string_lossy());
            day(path.file_stem()).or_else(|| day(path.parent().and_then(Path::file_name)))
        };
        let dated = |day: Option<Day>, from| day.map(|day| Dated { day, from });
        dated(self.entered_day, DateSource::Entered)
            .or_else(|| dated(self.file_day, DateSource::Header))
            .or_else(|| dated(Day::of_clock(self.started()?), DateSource::Clock))
            .or_else(|| dated(in_name(), DateSource::Name))
    }

    /// Whether the load that was really applied is known.
    pub fn has_reference(&self) -> bool {
        !self.axes.is_empty()
    }

    /// The reference load, `n × n_axes` row-major.
    pub fn loads(&self) -> &[f64] {
        &self.loads
    }

    /// The least and greatest value of each gauge.
    pub(crate) fn gauge_ranges(&self) -> &[MinMax] {
        self.gauges.ranges()
    }

    /// The least and greatest reference load of each axis.
    pub fn load_ranges(&self) -> &[MinMax] {
        self.loads.ranges()
    }

    /// The step that a gauge moves by, over and over: what its converter can tell apart. `None` where it moves by any amount, or
    /// where too few samples say so.
    pub fn resolution(&self, gauge: usize) -> Option<f64> {
        const FEWEST: usize = 100;
        const SHARE: f64 = 0.95;
        let values = || self.gauges().iter().skip(gauge).step_by(self.n_gauges());
        let steps = || {
            let steps = values().zip(values().skip(1)).map(|(a, b)| (a - b).abs());
            steps.filter(|step| *step > 0.0)
        };
        let least = steps().reduce(f64::min)?;
        let is_whole = |step: &f64| (step / least - (step / least).round()).abs() < 0.1;
        let (n, whole) = (steps().count(), steps().filter(is_whole).count());
        (n >= FEWEST && whole as f64 >= SHARE * n as f64).then_some(least)
    }

    /// Every `step`-th sample from the first on, as the paper makes its pattern B (section 4.2.2).
    ///
    /// A step of 0 counts as 1. The rows of a load case all stay: they are not samples of one motion.
    pub fn decimated(&self, step: usize) -> Self {
        if self.is_static() {
            return self.clone();
        }
        let step = step.max(1);
        let mut kept = match step {
            1 => self.segment(0..self.n_samples()),
            _ => {
                let every = |values: &[f64], width: usize| -> Vec<f64> {
                    let rows = values.chunks_exact(width.max(1)).step_by(step);
                    rows.flatten().copied().collect()
                };
                let times = every(&self.times, 1).into();
                let gauges = Ranged::new(every(&self.gauges, self.n_gauges()), self.n_gauges());
                let loads = Ranged::new(every(&self.loads, self.axes.len()), self.axes.len());
                let auxiliary = every(self.auxiliary.values(), self.auxiliary.len());
                let auxiliary = self.auxiliary.with_values(auxiliary.into());
                self.with_samples(self.name.clone(), times, gauges, loads, auxiliary)
            }
        };
        kept.gap_secs = self.gap_secs.map(|gap_secs| gap_secs * step as f64);
        kept
    }

    /// Cuts the recording in time: the first `⌊fraction · n⌋` samples, then the rest.
    ///
    /// `None` where a side would be empty, and of a load case. History does not cross the cut: these are two recordings.
    pub fn split(&self, fraction: f64) -> Option<(Self, Self)> {
        if self.is_static() {
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

    /// These samples as a recording of their own; history does not cross its ends.
    pub(crate) fn segment(&self, samples: Range<usize>) -> Self {
        self.picked(samples, self.name.clone())
    }

    /// Cuts the recording in time into `count` segments, as even as whole samples allow; fewer where it is shorter.
    ///
    /// History does not cross the cuts: these are recordings of their own.
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

    /// These samples one after another.
    pub(super) fn of_ranges(&self, ranges: &[Range<usize>], name: String) -> Self {
        let times = self.times.rows(ranges, 1);
        let (gauges, loads) = (self.gauges.rows(ranges), self.loads.rows(ranges));
        self.with_samples(name, times, gauges, loads, self.auxiliary.rows(ranges))
    }

    /// Other samples of the same sensor, with no samples before them.
    fn with_samples(
        &self,
        name: String,
        times: Shared,
        gauges: Ranged,
        loads: Ranged,
        auxiliary: AuxiliaryTable,
    ) -> Self {
        Self {
            name,
            rate_hz: rate_hz(&times).filter(|_| !self.is_static()),
            times,
            gauges,
            loads,
            auxiliary,
            ..self.clone()
        }
    }
}

/// Where the first number that is not finite stands.
fn first_not_finite(values: &[f64]) -> Option<usize> {
    let parts = values.par_chunks(SAMPLES_A_THREAD).enumerate();
    parts.find_map_first(|(part, values)| {
        let at = values.iter().position(|value| !value.is_finite())?;
        Some(part * SAMPLES_A_THREAD + at)
    })
}

/// Of more steps than these some say how fast samples come, in runs that are spread evenly.
const RATE_STEPS: usize = 1 << 20;
/// How long such a run is: longer than any burst.
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

/// Returns the range of the reference load of each of these axes over recordings that have them or no reference.
pub(crate) fn load_ranges<'a>(
    recordings: impl Iterator<Item = &'a Recording>,
    n_axes: usize,
) -> Vec<MinMax> {
    let mut all = vec![MinMax::NONE; n_axes];
    recordings.for_each(|own| join(&mut all, own.load_ranges()));
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
    fn a_gauge_of_counts_has_their_step_and_one_that_moves_by_any_amount_none() {
        let wave = |k: usize| (0.37 * k as f64).sin() + 0.3 * (1.3 * k as f64).cos();
        let of = |value: &dyn Fn(usize) -> f64, n: usize| {
            let times: Vec<f64> = (0..n).map(|k| k as f64).collect();
            let gauges = (0..n).map(value).collect();
            let names = vec!["S1".to_owned()];
            let recording =
                Recording::new("r", Source::Simulated, times, names, gauges, vec![], vec![]);
            recording.unwrap().resolution(0)
        };
        let counts = |k: usize| 0.25 * (wave(k) * 40.0).round();
        assert_eq!(of(&counts, 300), Some(0.25));
        assert_eq!(of(&wave, 300), None);
        assert_eq!(of(&counts, 50), None, "too few to say");
        assert_eq!(of(&|_| 1.0, 300), None);
    }

    #[test]
    fn rate_is_the_median_step_and_survives_a_pause() {
        let recording = ramp(vec![0.0, 0.1, 0.2, 0.3, 5.0]).unwrap();
        assert!((recording.rate_hz().unwrap() - 10.0).abs() < 1e-9);
        assert_eq!(ramp(vec![1.0]).unwrap().rate_hz(), None);
        assert_eq!(ramp(vec![1.0, 1.0, 1.0]).unwrap().rate_hz(), None);
    }

    #[test]
    fn a_segment_has_the_numbers_of_its_recording_and_what_is_changed_in_it_stays_there() {
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
    fn some_steps_say_the_rate_of_many() {
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
