//! Files whose columns have to be said before they can be read: the import window's state.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::engine::preferences::Preferences;
use crate::formats::text::TextLayout;
use crate::import::inspect::{Inspection, Known, Question, inspect};
use crate::import::map::{ColumnMap, ColumnRole, TableMap};
use crate::import::pose::WeightEstimate;
use crate::questions::question::{Answered, Query, Unanswered, Work};
use crate::scoring::numbers::significant;
use crate::shown::first;

/// Of the files that were not read so many are named.
const MAX_NAMED: usize = 8;

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

/// A file to look at for the import window.
#[derive(Clone, Debug, PartialEq)]
pub struct Preview {
    /// The file.
    pub path: PathBuf,
    /// What is known of it.
    pub known: KnownOf,
}

impl Query for Preview {
    type Answer = Arc<Inspection>;
    type Cache = ();

    fn title(&self) -> String {
        "Looking at a file".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { progress, .. } = work;
        let known = match &self.known {
            KnownOf::Nothing => Known::Nothing,
            KnownOf::Layout(text) => Known::Layout(text),
            KnownOf::Map(map) => Known::Map(map),
        };
        let found = inspect(&self.path, known, progress);
        found.map(Arc::new).map_err(|error| Unanswered::Because(error.to_string()))
    }
}

/// What concerns importing.
#[derive(Clone, Debug)]
pub enum ImportCommand {
    /// Look at this file.
    Open(PathBuf),
    /// Cut its text so; what the columns are is found again.
    SetLayout(TextLayout),
    /// The columns are these.
    SetMap(Box<ColumnMap>),
    /// Find the weight that the recording was made with, by its pose and its measured load.
    FindWeight,
    /// Take what is found by looking.
    Begin,
    /// Take this remembered map.
    TakeMap(usize),
    /// Read a map from a file.
    ReadMap(PathBuf),
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
    /// Begins with a file of which nothing is known.
    pub fn of(path: PathBuf, waiting: Vec<PathBuf>) -> Self {
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

/// Says of files that nobody said anything about by which remembered maps they were read.
pub fn by_remembered(mut files: Vec<(PathBuf, ColumnMap)>) -> Vec<String> {
    let mut said = Vec::new();
    while let Some((_, map)) = files.first().cloned() {
        let (by_it, others): (Vec<_>, Vec<_>) =
            files.into_iter().partition(|(_, other)| *other == map);
        files = others;
        let names = by_it.iter().map(|(path, _)| path.file_name().unwrap_or_default().display());
        said.push(format!(
            "{}: read by the column map of an earlier file like it: {}. If that is wrong, close it and say what its columns are with File > Import",
            first(1, names),
            roles_in_words(&map.table)
        ));
    }
    said
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
pub(super) fn in_words(estimate: &WeightEstimate) -> String {
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
    /// Says that this file and all that wait are not read.
    pub(super) fn not_read(&self) -> String {
        let files = [&self.path].into_iter().chain(&self.waiting);
        let names = files.map(|path| path.file_name().unwrap_or(path.as_os_str()).display());
        format!("Not read, for what their columns are was not said: {}", first(MAX_NAMED, names))
    }

    /// Changes what is said about the file; what is to be looked at then.
    pub(super) fn apply(
        &mut self,
        command: ImportCommand,
        preferences: &Preferences,
    ) -> Option<Preview> {
        let known = match command {
            ImportCommand::Begin => KnownOf::Nothing,
            ImportCommand::SetLayout(text) => {
                self.map.table.text = text.clone();
                KnownOf::Layout(text)
            }
            ImportCommand::Decide(at, is_decided) => {
                if let Some((_, decided)) = self.questions.get_mut(at) {
                    *decided = is_decided;
                }
                return None;
            }
            ImportCommand::SetMap(map) => {
                self.map = *map;
                KnownOf::Map(Box::new(self.map.clone()))
            }
            ImportCommand::TakeMap(at) => {
                return preferences.maps.get(at).map(|map| self.take_map(map.clone()));
            }
            _ => return None,
        };
        Some(self.look(known))
    }

    /// What is to be looked at with this known of it.
    pub(super) fn look(&mut self, known: KnownOf) -> Preview {
        self.looking = true;
        self.proposes = !matches!(known, KnownOf::Map(_));
        Preview { path: self.path.clone(), known }
    }

    /// The load is that of this weight from now on; a centre that was not found stays as it was said.
    pub(super) fn take_weight(&mut self, estimate: &WeightEstimate) -> Preview {
        let weight = self.map.weight.get_or_insert_default();
        weight.mass_kg = Some(estimate.mass_kg);
        weight.centre_m = estimate.centre_m.or(weight.centre_m);
        self.look(KnownOf::Map(Box::new(self.map.clone())))
    }

    /// A map that somebody made answers whatever was open.
    pub(super) fn take_map(&mut self, map: ColumnMap) -> Preview {
        for (_, is_decided) in &mut self.questions {
            *is_decided = true;
        }
        self.map = map;
        self.look(KnownOf::Map(Box::new(self.map.clone())))
    }

    /// Takes what was found in a file, if it is this one.
    pub(super) fn take_answer(&mut self, path: &Path, answer: Result<&Arc<Inspection>, &str>) {
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
                self.inspection = Some(Arc::clone(inspection));
                self.problem = None;
            }
            Err(problem) => self.problem = Some(problem.to_owned()),
        }
    }
}
