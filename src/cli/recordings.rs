//! Which recordings, of which sensor, kept within which limits: arguments that several jobs share.

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

/// Which recordings, in which role.
#[derive(Debug, Args)]
pub struct RecordingArgs {
    #[command(flatten)]
    pub read: ReadArgs,
    /// Recordings to fit, or folders of them; without any, those of the built-in simulated sensor. Files of a folder that are
    /// called test… are for --test, unless it or --split is given.
    #[arg(long, num_args = 1.., value_name = "FILE", value_parser = named_file())]
    train: Vec<PathBuf>,
    /// Recordings to score the fit on, or folders of them.
    #[arg(long, num_args = 1.., value_name = "FILE", requires = "train", value_parser = named_file())]
    test: Vec<PathBuf>,
    /// Instead of test files: train on this first part of each recording, test on the rest.
    #[arg(long, value_name = "FRACTION", conflicts_with = "test", allow_negative_numbers = true)]
    split: Option<f64>,
    /// Cross-validation leaves recordings of one group out together. A name with {file}, {folder}, {recording}, or a {word}
    /// for the number or letter after it in the names, as in {mount} [default: found from names, folders and files].
    #[arg(long, value_name = "PATTERN")]
    group: Option<GroupPattern>,
}

impl RecordingArgs {
    /// Returns the files that are read.
    pub fn files(&self) -> Files<'_> {
        Files {
            recordings: &self.train,
            test: Some(&self.test),
            is_split: self.split.is_some(),
            ..Files::default()
        }
        .reading(&self.read.columns)
    }

    /// Reads them; warnings go to standard error.
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
                "--full-scale has {given} where there are {axes}; write one for each"
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
                "the split is {fraction}; it must lie between 0 and 1, and leave both sides a sample"
            )),
        }
    }

    /// Returns the entry in the group that `--group` or its column map gives it. Only what is trained on must have one: nothing
    /// else is left out.
    fn grouped(&self, entry: Entry, by_map: Option<&GroupPattern>) -> Result<Entry, JobError> {
        let recording = &entry.recording;
        let group = match self.group.as_ref().or(by_map) {
            Some(pattern) => pattern.group_of(recording),
            None => None,
        };
        match (&self.group, &group) {
            (Some(pattern), None) if entry.role == Role::Train => {
                let (name, pattern) = (recording.name(), String::from(pattern.clone()));
                Err(JobError::Usage(format!(
                    "{name}: neither its name nor that of its folder holds what {pattern:?} stands for"
                )))
            }
            _ => Ok(Entry { group, ..entry }),
        }
    }
}

/// Limits that the calibration must keep.
#[derive(Debug, Args)]
pub struct LimitsArgs {
    /// Check the calibration against limits: a TOML file like `expected_error = 1.0` (percent of full scale), `rmse = "0.2 N"`,
    /// `loop_width = { Fx = 0.5 }`. A figure that is not known does not pass; the exit code is 3 then.
    #[arg(long, value_name = "LIMITS.toml", value_parser = named_file())]
    pub limits: Option<PathBuf>,
}

impl LimitsArgs {
    /// Reads the limits; there are none without a file.
    pub fn read(&self) -> Result<Limits, JobError> {
        let read = self.limits.as_deref().map(Limits::read);
        Ok(read.transpose()?.unwrap_or_default())
    }
}

/// Fails where a figure exceeds its limit or is not known.
pub fn keep_limits(limits: &[Checked]) -> Result<(), JobError> {
    let failed = limits.iter().filter(|own| !own.pass);
    let failed: Vec<String> = failed.map(Checked::in_words).collect();
    match failed.is_empty() {
        true => Ok(()),
        false => not_met(format!("out of limits: {}", failed.join("; "))),
    }
}

/// Which sensor it is.
#[derive(Debug, Args)]
pub struct SensorArgs {
    /// Which sensor it is, who calibrates it, when, and against what, and its rated loads: a TOML file whose items go into every
    /// export and the report; `loopscope sensor` prints one to fill in.
    #[arg(long, value_name = "SENSOR.toml", value_parser = named_file())]
    pub sensor: Option<PathBuf>,
}

impl SensorArgs {
    /// Reads it; nothing is said without one.
    pub fn read(&self) -> Result<SensorFile, JobError> {
        let read = self.sensor.as_deref().map(SensorFile::read);
        Ok(read.transpose()?.unwrap_or_default())
    }
}

/// How loops and figures are measured.
#[derive(Debug, Args)]
pub struct MeasuringArgs {
    /// How far the load of each axis must come back for a reversal, in N and N·m, in axis order; by default ten times the
    /// noise, and at least 5 % of the range.
    #[arg(long, value_delimiter = ',', value_name = "BAND,…", allow_negative_numbers = true)]
    dead_band: Vec<f64>,
    /// For how long a load must stand still to show creep or a zero.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = MetrologySettings::default().hold_secs,
        allow_negative_numbers = true
    )]
    hold: f64,
}

impl MeasuringArgs {
    /// The choices that these arguments mean.
    pub fn settings(&self) -> MetrologySettings {
        MetrologySettings {
            dead_bands: self.dead_band.iter().copied().map(Some).collect(),
            hold_secs: self.hold,
            ..MetrologySettings::default()
        }
    }
}
