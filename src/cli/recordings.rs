//! Arguments that several jobs share: recordings and their roles, the sensor, limits, loops and dwells.

use std::path::PathBuf;

use clap::Args;

use super::error::{JobError, not_met, usage};
use super::inputs::Files;
use super::rated::Rated;
use super::reading::ReadArgs;
use super::run::Run;
use super::values::named_file;
use crate::questions::expected_error::limits::{Checked, Limits};
use crate::questions::metrology::MetrologySettings;
use crate::recording::identity::SensorFile;
use crate::recording::{Axis, Entry, GroupPattern, RecordingSet, Role, simulated};

/// Recordings with their roles.
#[derive(Clone, Debug, Args)]
pub struct RecordingArgs {
    #[command(flatten)]
    pub read: ReadArgs,
    /// Training recordings, or folders of them. Without files, those of the built-in simulated sensor are used. Files in a
    /// folder whose names begin with "test" are test recordings, unless --test or --split is given.
    #[arg(long, num_args = 1.., value_name = "FILE", value_parser = named_file())]
    train: Vec<PathBuf>,
    /// Test recordings, or folders of them.
    #[arg(long, num_args = 1.., value_name = "FILE", requires = "train", value_parser = named_file())]
    test: Vec<PathBuf>,
    /// Share of each recording that is used for training; the rest is used as test, instead of test files.
    #[arg(long, value_name = "FRACTION", conflicts_with = "test", allow_negative_numbers = true)]
    split: Option<f64>,
    /// Group of each training recording; cross-validation leaves a group out together. A pattern with {file}, {folder}, {recording},
    /// or a {word} that stands for the number or letter after it, as {mount} in "mount2_a.csv" [default: a column "group" of the file, or found
    /// from names, folders and files].
    #[arg(long, value_name = "PATTERN")]
    group: Option<GroupPattern>,
}

impl RecordingArgs {
    pub fn files(&self) -> Files<'_> {
        Files {
            recordings: &self.train,
            test: Some(&self.test),
            is_split: self.split.is_some(),
            ..Files::default()
        }
        .reading(&self.read.columns)
    }

    pub fn read(&self, run: &Run, rated: &Rated) -> Result<RecordingSet, JobError> {
        let by_map = self.read.map()?.and_then(|map| map.group);
        let mut set =
            self.read.read_set(run, rated, |entry| self.grouped(entry, by_map.as_ref()))?;
        if run.inputs.recordings.is_empty() {
            let built_in = simulated::recordings(simulated::DEFAULT_SEED);
            for entry in built_in.entries() {
                let recording = self.read.tared(run, (*entry.recording).clone())?;
                set.push(self.grouped(Entry::new(recording, entry.role), None)?)?;
            }
        }
        let (given, axes) = (rated.full_scale.len(), &set.layout().axes);
        if (1..axes.len()).contains(&given) {
            let axes = Axis::symbols(axes).join(" ");
            return usage(format!(
                "--full-scale has {given} values, but the axes are {axes}; give one value for each"
            ));
        }
        let Some(fraction) = self.split else {
            return Ok(set);
        };
        let split = set.split(fraction);
        let tests = split.entries().iter().any(|entry| entry.role == Role::Test);
        match fraction > 0.0 && fraction < 1.0 && tests {
            true => Ok(split),
            false => usage(format!(
                "--split is {fraction}; it must lie between 0 and 1, so that both parts hold a sample"
            )),
        }
    }

    /// Returns the entry in the group that `--group` or its column map gives it. Only training recordings need a group: nothing
    /// else is left out.
    fn grouped(&self, entry: Entry, by_map: Option<&GroupPattern>) -> Result<Entry, JobError> {
        let recording = &entry.recording;
        let pattern = self.group.as_ref().or(by_map);
        let group = pattern.and_then(|pattern| pattern.group_of(recording));
        match (&self.group, &group) {
            (Some(pattern), None) if entry.role == Role::Train => {
                let (name, pattern) = (recording.name(), String::from(pattern.clone()));
                Err(JobError::Usage(format!(
                    "{name}: neither its name nor that of its folder matches the pattern {pattern:?}"
                )))
            }
            _ => Ok(Entry { group: group.or(entry.group), ..entry }),
        }
    }
}

/// Limits that the calibration must not exceed.
#[derive(Debug, Args)]
pub struct LimitsArgs {
    /// Check the calibration against limits: a TOML file like `expected_error = 1.0` (percent of full scale), `rmse = "0.2 N"`,
    /// `loop_width = { Fx = 0.5 }`. A figure that is unknown does not pass. The exit code is 3 if a limit is not met.
    #[arg(long, value_name = "LIMITS.toml", value_parser = named_file())]
    pub limits: Option<PathBuf>,
}

impl LimitsArgs {
    /// Reads the limits; without a file there are none.
    pub fn read(&self) -> Result<Limits, JobError> {
        let read = self.limits.as_deref().map(Limits::read);
        Ok(read.transpose()?.unwrap_or_default())
    }
}

/// Returns an error if a figure exceeds its limit or is unknown.
pub fn keep_limits(limits: &[Checked]) -> Result<(), JobError> {
    let failed = limits.iter().filter(|own| !own.pass);
    let failed: Vec<String> = failed.map(Checked::in_words).collect();
    match failed.is_empty() {
        true => Ok(()),
        false => not_met(format!("out of limits: {}", failed.join("; "))),
    }
}

/// Identity of the sensor.
#[derive(Debug, Args)]
pub struct SensorArgs {
    /// TOML file with the sensor's identity, operator, date, reference and rated loads. They go into every export and the report.
    /// `loopscope sensor` prints a template.
    #[arg(long, value_name = "SENSOR.toml", value_parser = named_file())]
    pub sensor: Option<PathBuf>,
}

impl SensorArgs {
    /// Reads the identity; without a file it is empty.
    pub fn read(&self) -> Result<SensorFile, JobError> {
        let read = self.sensor.as_deref().map(SensorFile::read);
        Ok(read.transpose()?.unwrap_or_default())
    }
}

/// Settings of loops and metrology figures.
#[derive(Debug, Args)]
pub struct MeasuringArgs {
    /// Reversal threshold of each axis in N and N·m, in axis order: the load must turn back by more to count as a reversal
    /// [default: ten times the noise, and at least 5 % of the range].
    #[arg(
        long,
        alias = "dead-band",
        value_delimiter = ',',
        value_name = "THRESHOLD,…",
        allow_negative_numbers = true
    )]
    reversal_threshold: Vec<f64>,
    /// Shortest dwell, in seconds, that shows creep or a zero.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = MetrologySettings::default().hold_secs,
        allow_negative_numbers = true
    )]
    hold: f64,
}

impl MeasuringArgs {
    pub fn settings(&self) -> MetrologySettings {
        MetrologySettings {
            reversal_thresholds: self.reversal_threshold.iter().copied().map(Some).collect(),
            hold_secs: self.hold,
            ..MetrologySettings::default()
        }
    }
}
