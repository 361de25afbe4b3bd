//! Files whose columns have to be said before they can be read: the import window's state.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::app::{AppState, Effect, Existing, FileContent, Level, Notice};
use crate::evaluation::numbers::significant;
use crate::formats::text::TextLayout;
use crate::import::inspect::{Inspection, Question};
use crate::import::map::{ColumnMap, ColumnRole, TableMap};
use crate::import::pose::WeightEstimate;

/// So many maps are remembered.
const MOST_MAPS: usize = 40;

/// What is known of a file before it is looked at.
#[derive(Clone, Debug, PartialEq)]
pub enum KnownOf {
    /// Nothing.
    Nothing,
    /// How its text is cut.
    Layout(TextLayout),
    /// Everything: the map is tried out.
    Map(Box<ColumnMap>),
}

/// What concerns importing.
#[derive(Clone, Debug)]
pub enum ImportCommand {
    /// Ask which file to import.
    Choose,
    /// Look at this file.
    Open(PathBuf),
    /// It was looked at.
    Inspected(PathBuf, Result<Box<Inspection>, String>),
    /// Cut its text so; what the columns are is found again.
    SetLayout(TextLayout),
    /// The columns are these.
    SetMap(Box<ColumnMap>),
    /// Find the weight that the recording was made with, by its pose and its measured load.
    EstimateWeight,
    /// It was found.
    WeightEstimated(PathBuf, Result<Box<WeightEstimate>, String>),
    /// Take what is found by looking.
    Begin,
    /// Take this remembered map.
    TakeMap(usize),
    /// Read a map from a file.
    ReadMap(PathBuf),
    /// The map was read.
    MapRead(Result<Box<ColumnMap>, String>),
    /// Write the map into a file.
    WriteMap(PathBuf),
    /// Load the file with the map, and remember the map.
    Load,
    /// This question is decided, or not yet.
    Decide(usize, bool),
    /// Leave it, and go on to the next that waits.
    Cancel,
    /// Leave it and all that wait.
    CancelAll,
}

/// A file that is being imported.
#[derive(Clone, Debug)]
pub struct Importing {
    /// The file.
    pub path: PathBuf,
    /// What was found, by the newest answer.
    pub inspection: Option<Arc<Inspection>>,
    /// The map as it stands.
    pub map: ColumnMap,
    /// Why the file cannot be looked at.
    pub problem: Option<String>,
    /// Whether an answer is awaited.
    pub looking: bool,
    /// What a person has to decide about the last proposal, and whether they say that they have.
    pub questions: Vec<(Question, bool)>,
    /// Whether the answer that is awaited is a proposal.
    proposes: bool,
    /// Other files that want a map; those of the same shape take this one.
    pub waiting: Vec<PathBuf>,
}

impl Importing {
    fn of(path: PathBuf, waiting: Vec<PathBuf>) -> Self {
        Self {
            path,
            inspection: None,
            map: ColumnMap::default(),
            problem: None,
            looking: true,
            questions: Vec::new(),
            proposes: true,
            waiting,
        }
    }
}

impl AppState {
    /// Begins to import files, one after another.
    pub(super) fn import(&mut self, mut paths: Vec<PathBuf>) -> Vec<Effect> {
        if paths.is_empty() {
            return Vec::new();
        }
        if let Some(importing) = &mut self.importing {
            importing.waiting.extend(paths);
            return Vec::new();
        }
        let path = paths.remove(0);
        self.importing = Some(Importing::of(path.clone(), paths));
        vec![Effect::Inspect(path, KnownOf::Nothing)]
    }

    pub(super) fn apply_import(&mut self, command: ImportCommand) -> Vec<Effect> {
        match command {
            ImportCommand::Choose => return vec![Effect::AskForImport],
            ImportCommand::Open(path) => return self.import(vec![path]),
            ImportCommand::MapRead(Err(error)) => {
                self.tell(Notice::new(Level::Error, error));
                return Vec::new();
            }
            ImportCommand::Cancel => {
                let waiting = self.importing.take().map(|importing| importing.waiting);
                return self.import(waiting.unwrap_or_default());
            }
            ImportCommand::CancelAll => {
                self.importing = None;
                return Vec::new();
            }
            _ => {}
        }
        let Some(importing) = &mut self.importing else {
            return Vec::new();
        };
        let known = match command {
            ImportCommand::Inspected(path, answer) => {
                importing.take_answer(&path, answer);
                return Vec::new();
            }
            ImportCommand::EstimateWeight => {
                let map = Box::new(importing.map.clone());
                return vec![Effect::EstimateWeight(importing.path.clone(), map)];
            }
            ImportCommand::WeightEstimated(path, estimate) => {
                if path != importing.path {
                    return Vec::new(); // it is another file's
                }
                let said = match estimate {
                    Ok(estimate) => {
                        importing.take_weight(&estimate);
                        Notice::new(Level::Info, in_words(&estimate))
                    }
                    Err(error) => Notice::new(Level::Error, error),
                };
                let known = KnownOf::Map(Box::new(importing.map.clone()));
                importing.looking = true;
                importing.proposes = false;
                let inspect = Effect::Inspect(importing.path.clone(), known);
                self.tell(said);
                return vec![inspect];
            }
            ImportCommand::Begin => KnownOf::Nothing,
            ImportCommand::SetLayout(text) => {
                importing.map.table.text = text.clone();
                KnownOf::Layout(text)
            }
            ImportCommand::Decide(at, is_decided) => {
                if let Some((_, decided)) = importing.questions.get_mut(at) {
                    *decided = is_decided;
                }
                return Vec::new();
            }
            ImportCommand::SetMap(map) => {
                importing.map = *map;
                KnownOf::Map(Box::new(importing.map.clone()))
            }
            ImportCommand::MapRead(Ok(map)) => importing.take_map(*map),
            ImportCommand::TakeMap(at) => match self.preferences.maps.get(at).cloned() {
                Some(map) => importing.take_map(map),
                None => return Vec::new(),
            },
            ImportCommand::ReadMap(path) => return vec![Effect::ReadMap(path)],
            ImportCommand::WriteMap(path) => {
                let mut text = Vec::new();
                if let Err(error) = importing.map.write_json(&mut text) {
                    self.tell(Notice::new(Level::Error, error.to_string()));
                    return Vec::new();
                }
                let content = FileContent::Bytes(text.into());
                return vec![Effect::Write(content, path, Existing::Ask)];
            }
            ImportCommand::Load => return self.load_import(),
            _ => return Vec::new(),
        };
        importing.looking = true;
        importing.proposes = !matches!(known, KnownOf::Map(_));
        vec![Effect::Inspect(importing.path.clone(), known)]
    }

    /// Reads the file by its map; the others that wait are tried with the same one.
    fn load_import(&mut self) -> Vec<Effect> {
        let Some(Importing {
            path, map, waiting, ..
        }) = self.importing.take()
        else {
            return Vec::new();
        };
        let maps = &mut self.preferences.maps;
        let is_other = |other: &ColumnMap| {
            let (other, this) = (&other.table, &map.table);
            // Without names, how it is cut is a part of what a file looks like.
            let is_cut_so = !this.shape.names.is_empty() || other.text == this.text;
            other.shape != this.shape || !is_cut_so
        };
        maps.retain(is_other);
        maps.insert(0, map.clone());
        maps.truncate(MOST_MAPS);
        let mut paths = vec![path.clone()];
        paths.extend(waiting);
        self.maps.insert(path, map);
        vec![self.read(paths)]
    }

    /// Says of files that nobody said anything about by which remembered maps they were read.
    pub(super) fn tell_remembered(&mut self, mut files: Vec<(PathBuf, ColumnMap)>) {
        while let Some((_, map)) = files.first().cloned() {
            let (by_it, others): (Vec<_>, Vec<_>) =
                files.into_iter().partition(|(_, other)| *other == map);
            files = others;
            let name = by_it[0].0.file_name().unwrap_or_default().to_string_lossy();
            let more = match by_it.len() - 1 {
                0 => String::new(),
                n_more => format!(" and {n_more} more"),
            };
            let text = format!(
                "{name}{more}: read by the column map of an earlier file like it: {}. If that is wrong, close it and say what its columns are with File > Import",
                roles_in_words(&map.table)
            );
            self.tell(Notice::new(Level::Info, text));
        }
    }

    /// Reads files: by the maps that they were read by before, or by remembered ones where their names do not say enough.
    pub(super) fn read(&self, paths: Vec<PathBuf>) -> Effect {
        let files = paths.into_iter().map(|path| {
            let own = self.maps.get(&path).cloned();
            (path, own)
        });
        Effect::Read(files.collect(), self.preferences.maps.clone())
    }
}

/// Which columns a table takes, in few words.
fn roles_in_words(table: &TableMap) -> String {
    let rules = || table.columns.iter();
    let n_gauges = rules().filter(|rule| rule.is == ColumnRole::Gauge).count();
    let others = rules().filter(|rule| ![ColumnRole::Gauge, ColumnRole::Ignore].contains(&rule.is));
    let others = others.map(|rule| format!("{} is column {}", rule.is, rule.column));
    let mut parts: Vec<String> = others.collect();
    parts.push(match n_gauges {
        1 => "1 gauge".to_owned(),
        n_gauges => format!("{n_gauges} gauges"),
    });
    parts.join(", ")
}

/// What was found, with how well it explains the measured load.
fn in_words(estimate: &WeightEstimate) -> String {
    let list = |values: [f64; 3]| values.map(|value| significant(value, 4)).join(", ");
    let centre = match estimate.centre_m {
        Some(centre) => format!("its centre at {} m", list(centre)),
        None => "its centre not found: it takes Mx, My and Mz, and a sensor turned about two axes"
            .to_owned(),
    };
    format!(
        "{} kg by {} samples, {centre}; the reference is off by {} N, and {} N RMS are left over",
        significant(estimate.mass_kg, 5),
        estimate.n_samples,
        list(estimate.force_offset),
        significant(estimate.force_rms, 3),
    )
}

impl Importing {
    /// The load is that of this weight from now on; a centre that was not found stays as it was said.
    fn take_weight(&mut self, estimate: &WeightEstimate) {
        let weight = self.map.weight.get_or_insert_default();
        weight.mass_kg = Some(estimate.mass_kg);
        weight.centre_m = estimate.centre_m.or(weight.centre_m);
    }

    /// A map that somebody made answers whatever was open.
    fn take_map(&mut self, map: ColumnMap) -> KnownOf {
        for (_, is_decided) in &mut self.questions {
            *is_decided = true;
        }
        self.map = map;
        KnownOf::Map(Box::new(self.map.clone()))
    }

    fn take_answer(&mut self, path: &Path, answer: Result<Box<Inspection>, String>) {
        if path != self.path {
            return;
        }
        self.looking = false;
        match answer {
            Ok(inspection) => {
                if self.proposes {
                    let questions = inspection.questions.iter().cloned();
                    self.questions = questions.map(|question| (question, false)).collect();
                }
                self.map = inspection.map.clone();
                self.inspection = Some(Arc::new(*inspection));
                self.problem = None;
            }
            Err(problem) => self.problem = Some(problem),
        }
    }
}
