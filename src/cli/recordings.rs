//! Arguments that several jobs share: recordings and their roles, the sensor file, limits, and settings of the measured
//! figures.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::{
    choices::ModelArgs,
    error::{JobError, usage},
    inputs::Files,
    reading::{Rated, ReadArgs},
    run::Run,
    values::named_file,
};
use crate::{
    calibration::FitSettings,
    questions::{
        Request,
        expected_error::limits::{Checked, Limits},
        history::coarse_history,
        metrology::MetrologySettings,
    },
    recording::{
        Axis, Entry, GroupPattern, RecordingSet, Role,
        identity::{SensorFile, rate},
        simulated,
    },
};

/// Command-line arguments that name recordings and give them roles (training or test).
#[derive(Clone, Debug, Args)]
pub struct RecordingArgs {
    #[command(flatten)]
    pub read: ReadArgs,
    /// Training recordings, or folders of them [default: those of the built-in simulated sensor]. In a folder, files whose names
    /// begin with "test" are test recordings, unless --test or --split is given.
    #[arg(long, num_args = 1.., value_name = "FILE", value_parser = named_file())]
    train: Vec<PathBuf>,
    /// Test recordings, or folders of them.
    #[arg(long, num_args = 1.., value_name = "FILE", requires = "train", value_parser = named_file())]
    test: Vec<PathBuf>,
    /// Share of each recording, from its start, that is used for training. The remainder is used for the test, in place of
    /// test files.
    #[arg(long, value_name = "FRACTION", conflicts_with = "test", allow_negative_numbers = true)]
    split: Option<f64>,
    /// Pattern that gives the group of each training recording. Cross-validation leaves out whole groups. The pattern can contain
    /// {file}, {folder}, {recording}, and words such as {mount}, which stands for 2 in "mount2_a.csv" [default: the column "group" of
    /// the file, or else detected from the names].
    #[arg(long, value_name = "PATTERN")]
    group: Option<GroupPattern>,
    /// TOML file with the sensor's identity, operator, date, reference, rated loads and frame, for all exports and the report.
    /// `loopscope sensor` prints a template.
    #[arg(long, value_name = "SENSOR.toml", value_parser = named_file())]
    sensor: Option<PathBuf>,
}

/// Recordings, and the content of the sensor file.
pub struct Inputs {
    pub recordings: Arc<RecordingSet>,
    pub sensor: SensorFile,
}

impl Inputs {
    /// Adds the rated loads of the sensor to the settings, for axes whose full scale was not given.
    pub fn rated(&self, mut settings: FitSettings) -> FitSettings {
        let axes = &self.recordings.layout().axes;
        rate(&self.sensor.rated_loads, axes, &mut settings.full_scale);
        settings
    }
}

impl RecordingArgs {
    pub fn files(&self) -> Files<'_> {
        Files {
            recordings: &self.train,
            test: self.split.is_none().then_some(&self.test[..]),
            ..Files::default()
        }
        .reading(self.read.columns_file().into_iter().chain(&self.sensor))
    }

    /// Reads the sensor file, if there is one, and the recordings.
    pub fn read(&self, run: &Run, rated: Rated) -> Result<Inputs, JobError> {
        let sensor = self.sensor.as_deref().map(SensorFile::read).transpose()?.unwrap_or_default();
        let rated = Rated { by_axis: sensor.rated_loads.clone(), frame: sensor.frame, ..rated };
        Ok(Inputs { recordings: Arc::new(self.read_rated(run, &rated)?), sensor })
    }

    fn read_rated(&self, run: &Run, rated: &Rated) -> Result<RecordingSet, JobError> {
        let by_map = self.read.map()?.and_then(|map| map.group);
        let mut set =
            self.read.read_set(run, rated, |entry| self.grouped(entry, by_map.as_ref()))?;
        if run.inputs.recordings.is_empty() {
            let built_in = simulated::recordings(simulated::DEFAULT_SEED);
            for entry in built_in.entries() {
                let recording = (*entry.recording).clone().in_frame(rated.frame)?;
                let recording = self.read.tared(run, recording)?;
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
        if fraction > 0.0 && fraction < 1.0 && tests {
            Ok(split)
        } else {
            usage(format!(
                "--split is {fraction}; it must lie between 0 and 1, so that both parts hold a sample"
            ))
        }
    }

    /// Returns the recording's entry with its group, which `--group` or the column map gives. A recording that is not used
    /// for training needs no group.
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

/// Returns an error that names the figures of the calibration that exceed their limit or are unknown; `Ok` if there are none.
pub fn keep_limits(limits: &[Checked]) -> Result<(), JobError> {
    let failed = limits.iter().filter(|limit| !limit.pass);
    let failed: Vec<String> = failed.map(Checked::in_words).collect();
    if failed.is_empty() {
        Ok(())
    } else {
        Err(JobError::NotMet(format!("out of limits: {}", failed.join("; "))))
    }
}

/// Reads the sensor file, if there is one, and the recordings. Returns the request of the fit, and the content of the file.
pub fn request_of(
    run: &Run,
    recordings: &RecordingArgs,
    model: &ModelArgs,
) -> Result<(Request, SensorFile), JobError> {
    let inputs = recordings.read(run, model.rated())?;
    let settings = inputs.rated(model.settings(&run.say, &inputs.recordings));
    Ok((Request::fit(inputs.recordings, settings), inputs.sensor))
}

/// Command-line arguments of `fit` and `report`: recordings, model, sensor file and limits.
#[derive(Debug, Args)]
pub struct FitArgs {
    #[command(flatten)]
    pub recordings: RecordingArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// TOML file with limits for the calibration, such as `expected_error = 1.0` (percent of full scale), `rmse = "0.2 N"` and
    /// `loop_width = { Fx = 0.5 }`. If a figure exceeds its limit or is unknown, the exit code is 3.
    #[arg(long, value_name = "LIMITS.toml", value_parser = named_file())]
    limits: Option<PathBuf>,
}

/// Request of the fit, and content of the other files that [`FitArgs`] names.
pub struct FitInputs {
    pub request: Request,
    pub sensor: SensorFile,
    pub limits: Limits,
}

impl FitArgs {
    pub fn files(&self) -> Files<'_> {
        self.recordings.files().reading(&self.limits)
    }

    pub fn read(&self, run: &Run) -> Result<FitInputs, JobError> {
        let limits = self.limits.as_deref().map(Limits::read).transpose()?.unwrap_or_default();
        let (request, sensor) = request_of(run, &self.recordings, &self.model)?;
        Ok(FitInputs { request, sensor, limits })
    }
}

/// Prints the rate at which earlier samples are stored, if the fit chooses one; see [`coarse_history`].
pub fn note_history(run: &Run, request: &Request) -> Result<(), JobError> {
    if let Some(coarse) = coarse_history(request, &run.progress)? {
        run.say.note(format_args!("{coarse}; --history-rate 0 stores all samples"));
    }
    Ok(())
}

#[derive(Debug, Args)]
pub struct MeasuringArgs {
    /// Reversal threshold of each axis in N and N·m, in axis order: the load must turn back by this much to count as a
    /// reversal [default: ten times the noise, but at least 5 % of the range of the load].
    #[arg(
        long,
        alias = "dead-band",
        value_delimiter = ',',
        value_name = "THRESHOLD,…",
        allow_negative_numbers = true
    )]
    reversal_threshold: Vec<f64>,
    /// Shortest time in seconds for which the load must rest so that creep, or a zero without load, is measured.
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
