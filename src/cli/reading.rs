//! Reads the recordings for all command-line jobs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::TypedValueParser;

use super::{
    error::{JobError, failed, usage},
    inputs::Input,
    run::Run,
    values::{named_file, number_in},
};
use crate::{
    engine::Session,
    export::read_with_notes,
    features::Range,
    finding::Finding,
    import::{self, map::ColumnMap, unit_note},
    progress::Progress,
    recording::{
        Axis, Entry, GaugeRange, Recording, RecordingSet, Role, SensorFrame, Tare, ValidRange,
        identity::rate,
    },
    scoring::faults::{Faults, faults, faults_of},
    shown::and_more,
};

/// Maximum number of faulty recordings of one file that are reported one by one. Further ones are only counted.
const LISTED_FAULTY: usize = 8;

/// Rated loads from the command line and from files of the user.
#[derive(Debug, Default)]
pub struct Rated {
    /// Values of `--full-scale`, in axis order.
    pub full_scale: Vec<f64>,
    /// Rated loads from `sensor.toml` or a calibration, for axes without a value in `full_scale`.
    pub by_axis: BTreeMap<Axis, f64>,
    /// Frame into which the reference loads are turned and shifted.
    pub frame: Option<SensorFrame>,
}

impl Rated {
    /// Returns the rated load of each axis. A wrong value or a wrong number of values is ignored here, because the job
    /// reports it.
    fn on(&self, axes: &[Axis]) -> Vec<Option<f64>> {
        let is_of_them = self.full_scale.len() <= axes.len();
        let given = self.full_scale.iter().filter(|_| is_of_them);
        let mut rated = given.map(|load| Some(*load).filter(|load| *load > 0.0)).collect();
        rate(&self.by_axis, axes, &mut rated);
        rated
    }
}

/// Arguments of all jobs that read recordings.
#[derive(Clone, Debug, Args)]
pub struct ReadArgs {
    /// Roles of columns that differ from the proposed roles: COLUMN=ROLE UNIT, separated by commas, such as "Mass_kg=Fz kgf,
    /// Reading=gauge". Or the name of a column map (JSON) that `inspect --write-map` wrote.
    #[arg(long, value_name = "MAP.json|COLUMN=ROLE,…", value_parser = columns())]
    pub columns: Option<Columns>,
    /// Tare each recording by the mean of its gauges in an interval: FROM:TO in seconds from its start, or "auto" for the first
    /// half second without load. A calibration fitted to tared recordings needs tared gauges on the robot, too.
    #[arg(long, value_name = "auto|FROM:TO")]
    pub tare: Option<Tare>,
    /// Smallest and largest value that the logger can write for a gauge. A sample with one of these values counts as clipped. Give one
    /// range for all gauges, or one for each gauge in order, separated by commas; leave an unknown range empty.
    #[arg(long, value_name = "LOW:HIGH,…", value_parser = gauge_range, allow_hyphen_values = true)]
    pub gauge_range: Option<GaugeRange>,
    /// Percent by which a load may exceed the rated load before it counts as overload [default: 2].
    #[arg(long, value_name = "PERCENT", value_parser = number_in(Range::NotNegative))]
    overload_tolerance: Option<f64>,
    /// Leave out samples that look faulty: clipped, stuck, dropped out, spikes, or loads above the rated load. Exported code then
    /// reports clipped gauges.
    #[arg(long)]
    leave_out_faulty: bool,
    /// Skip unusable files, and return exit code 1 at the end. `check` always skips unusable files.
    #[arg(long)]
    pub keep_going: bool,
}

/// Moves to the front the recordings whose gauges and axes occur most often, because only recordings with the columns of the
/// first one can be used. The order is otherwise unchanged.
fn usual_columns_first(all: &mut [Entry]) {
    let has_columns_of = |a: &Entry, b: &Entry| {
        let [a, b] = [a, b].map(|entry| &entry.recording);
        a.gauge_names() == b.gauge_names() && a.axes() == b.axes()
    };
    let mut kinds: Vec<(&Entry, usize)> = Vec::new();
    for entry in &*all {
        match kinds.iter_mut().find(|(kind, _)| has_columns_of(kind, entry)) {
            Some((_, n)) => *n += 1,
            None => kinds.push((entry, 1)),
        }
    }
    // If several combinations of gauges and axes are equally frequent, the first of them is taken.
    let Some((usual, _)) = kinds.into_iter().rev().max_by_key(|(_, n)| *n) else { return };
    let usual = usual.clone();
    all.sort_by_key(|entry| !has_columns_of(entry, &usual));
}

fn gauge_range(text: &str) -> Result<GaugeRange, String> {
    let ends = |text: &str| {
        let ends = text.split_once(':').and_then(|(low, high)| {
            let (low, high): (f64, f64) = (low.trim().parse().ok()?, high.trim().parse().ok()?);
            (low.is_finite() && high.is_finite() && low < high).then_some((low, high))
        });
        ends.ok_or_else(|| {
            format!("{text:?} is not a range such as -32768:32767, with the smaller number first")
        })
    };
    if !text.contains(',') {
        return ends(text).map(GaugeRange::All);
    }
    let parsed = |text: &str| match text.trim() {
        "" => Ok(None),
        text => ends(text).map(Some),
    };
    let all: Result<_, String> = text.split(',').map(parsed).collect();
    all.map(GaugeRange::Each)
}

/// Roles of columns as given by `--columns`.
#[derive(Clone, Debug)]
pub enum Columns {
    File(PathBuf),
    Typed(Box<ColumnMap>),
}

fn columns() -> impl TypedValueParser<Value = Columns> {
    named_file().try_map(|path| match path.to_str() {
        Some(text) if text.contains('=') && !path.exists() => {
            ColumnMap::typed(text).map(|map| Columns::Typed(Box::new(map)))
        }
        _ => Ok(Columns::File(path)),
    })
}

impl ReadArgs {
    /// Returns the path of the column map if `--columns` names a file, and not roles.
    pub fn columns_file(&self) -> Option<&PathBuf> {
        match &self.columns {
            Some(Columns::File(path)) => Some(path),
            _ => None,
        }
    }

    /// Returns the limits beyond which a sample counts as faulty, with these rated loads.
    pub fn range(&self, rated: Vec<Option<f64>>) -> ValidRange {
        ValidRange {
            gauges: self.gauge_range.clone(),
            rated,
            overload_tolerance: self.overload_tolerance.map(|percent| percent / 100.0),
        }
    }

    pub fn map(&self) -> Result<Option<ColumnMap>, JobError> {
        Ok(match &self.columns {
            Some(Columns::File(path)) => Some(ColumnMap::read(path)?),
            Some(Columns::Typed(map)) => Some((**map).clone()),
            None => None,
        })
    }

    /// Returns the error for a file that cannot be read. If it is a calibration or a session, the error says so.
    pub fn unread(&self, input: &Input, error: impl Into<JobError>) -> JobError {
        not_recording(&input.path).unwrap_or_else(|| self.refused(input, error.into()))
    }

    /// Returns the error for an unusable file. If the file is one of several in a folder, the error names `--keep-going`.
    fn refused(&self, input: &Input, error: JobError) -> JobError {
        if self.keep_going { error } else { input.refused(error) }
    }

    /// Returns the result of reading a file. With `--keep-going`, an error is printed, and an empty result is returned instead.
    pub fn or_left_out<T: Default>(
        &self,
        run: &Run,
        done: Result<T, JobError>,
    ) -> Result<T, JobError> {
        match done {
            Err(error) if self.keep_going => {
                run.say.left_out(&error);
                Ok(T::default())
            }
            done => done,
        }
    }

    /// Reads training and test recordings, which must have a reference load. `entry` completes each entry, for example with
    /// its group.
    pub fn read_set(
        &self,
        run: &Run,
        rated: &Rated,
        entry: impl Fn(Entry) -> Result<Entry, JobError>,
    ) -> Result<RecordingSet, JobError> {
        let mut all = Vec::new();
        for (inputs, role) in
            [(&run.inputs.recordings, Role::Train), (&run.inputs.test, Role::Test)]
        {
            let read = self.read(run, inputs, rated, Needs::GaugesAndLoad)?;
            all.extend(read.into_iter().map(|recording| Entry::new(recording, role)));
        }
        if self.keep_going {
            usual_columns_first(&mut all);
        }
        let mut set = RecordingSet::default();
        for read in all {
            let pushed = entry(read).and_then(|entry| Ok(set.push(entry)?));
            self.or_left_out(run, pushed)?;
        }
        let is_trained_on = set.entries().iter().any(|entry| entry.role == Role::Train);
        if is_trained_on || run.inputs.recordings.is_empty() {
            Ok(set)
        } else {
            failed("no recording to train on could be read")
        }
    }

    /// Reads recordings, and prints warnings on standard error. Equal warnings about several files are joined. If a file lacks
    /// what the job needs, or leaves a question about it open, the error names the shortest answer.
    pub fn read(
        &self,
        run: &Run,
        inputs: &[Input],
        rated: &Rated,
        needs: Needs,
    ) -> Result<Vec<Recording>, JobError> {
        let map = self.map()?;
        let (mut all, mut warnings) = (Vec::new(), Vec::new());
        let mut without_unit: Vec<String> = Vec::new();
        let read = inputs.iter().try_for_each(|input| {
            let path = &input.path;
            let mut read = || {
                let loaded = import::read(path, map.as_ref(), &[], &Progress::default());
                let loaded = loaded.map_err(|error| self.unread(input, error))?;
                if needs == Needs::GaugesAndLoad {
                    if let Some((asked, answer)) = loaded.asked() {
                        let mut why = format!("{}: {asked}", path.display());
                        if let Some(answer) = answer {
                            why += &format!(" Answer with --columns \"{answer}\"");
                        }
                        return Err(self.refused(input, JobError::Usage(why)));
                    }
                    let is_new = |name: &String| !without_unit.contains(name);
                    let new = loaded.mapped.without_unit.iter().filter(|name| is_new(name));
                    let new: Vec<String> = new.cloned().collect();
                    without_unit.extend(new);
                }
                warnings.extend(loaded.warnings);
                self.prepared(run, loaded.recordings, rated)
            };
            all.extend(self.or_left_out(run, read())?);
            Ok(())
        });
        Finding::by_file(warnings).into_iter().for_each(|found| run.say.finding(found));
        if let Some(note) = unit_note(&without_unit) {
            run.say.note(format_args!("{note}"));
        }
        read.map(|()| all)
    }

    /// Tares the recordings of a file and removes faulty samples, if the user asked for it. Removing a long faulty interval
    /// splits its recording. Prints changes and faults on standard error.
    fn prepared(
        &self,
        run: &Run,
        recordings: Vec<Recording>,
        rated: &Rated,
    ) -> Result<Vec<Recording>, JobError> {
        let framed = recordings.into_iter().map(|recording| recording.in_frame(rated.frame));
        let recordings = framed.collect::<Result<Vec<_>, _>>()?;
        let Some(first) = recordings.first() else { return Ok(recordings) };
        let n_gauges = first.n_gauges();
        if let Some(GaugeRange::Each(ranges)) = &self.gauge_range
            && ranges.len() != n_gauges
        {
            return usage(format!(
                "--gauge-range has {} ranges, but the recordings have {n_gauges} gauges; give one range for all, or one for each",
                ranges.len()
            ));
        }
        let range = self.range(rated.on(first.axes()));
        let all: Vec<&Recording> = recordings.iter().collect();
        let found = faults_of(&all, &range);
        let of_table = all.iter().all(|recording| recording.is_static()).then(|| {
            let table = Recording::table_of(&all);
            let found = faults(&table, &range);
            (table, found)
        });
        let noted: Vec<(&Recording, &Faults)> = match &of_table {
            Some((table, found)) => vec![(table, found)],
            None => all.iter().copied().zip(&found).collect(),
        };
        self.note_faulty(run, &noted);
        if !self.leave_out_faulty {
            return recordings.into_iter().map(|recording| self.tared(run, recording)).collect();
        }
        let name = first.name();
        let parts = recordings.iter().zip(&found);
        let parts = parts.flat_map(|(recording, found)| found.left_out_of(recording, &range));
        let parts: Vec<Recording> = parts.collect();
        match parts.len() {
            0 => {
                let why = "all samples look faulty, so none is left; check the gauge range and the rated loads";
                return failed(format!("{name}: {why}"));
            }
            more if more > recordings.len() => run.say.note(format_args!(
                "{name}: {more} segments remain; look-backs do not reach from one segment into another"
            )),
            _ => {}
        }
        parts.into_iter().map(|part| self.tared(run, part)).collect()
    }

    fn note_faulty(&self, run: &Run, found: &[(&Recording, &Faults)]) {
        let faulty = || found.iter().filter(|(_, found)| found.n_samples() > 0);
        for (recording, found) in faulty().take(LISTED_FAULTY) {
            let (name, words) = (recording.name(), found.in_words(recording).join(", "));
            let (n, of) = (found.n_samples(), recording.n_samples());
            run.say.note(if self.leave_out_faulty {
                format!("{name}: {n} of {of} samples left out: {words}")
            } else {
                format!(
                    "{name}: looks faulty: {words}; --leave-out-faulty leaves these samples out"
                )
            });
        }
        if let Some(more) = and_more(faulty().count(), LISTED_FAULTY) {
            run.say.note(format_args!("{more} recordings of this file"));
        }
    }

    pub fn tared(&self, run: &Run, recording: Recording) -> Result<Recording, JobError> {
        let Some(tare) = self.tare else {
            return Ok(recording);
        };
        let (tared, (from, to)) = recording.tared(tare)?;
        if tare == Tare::Auto {
            let name = tared.name();
            run.say.note(format_args!("{name}: tared over {from:.3} s to {to:.3} s"));
        }
        if let Some(loaded) = tared.loaded_while_tared((from, to)) {
            run.say.finding(loaded);
        }
        Ok(tared)
    }
}

/// What a job needs of each recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Needs {
    Nothing,
    GaugesAndLoad,
}

/// Returns an error if the file is a calibration or a session.
pub fn not_recording(path: &Path) -> Option<JobError> {
    let is_other = Session::is_at(path) || read_with_notes(path).is_ok();
    is_other.then(|| {
        JobError::Usage(format!(
            "{} is a calibration or a session, not a recording; use `loopscope apply` for a calibration, and open a session in the window",
            path.display()
        ))
    })
}
