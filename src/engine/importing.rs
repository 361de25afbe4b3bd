//! State of the import window, for files that need a column map.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::engine::preferences::Preferences;
use crate::formats::text::TextLayout;
use crate::import::inspect::{Inspection, Known, Question, inspect};
use crate::import::map::{ColumnMap, ColumnRole, TableMap};
use crate::import::pose::WeightEstimate;
use crate::questions::question::{Answered, Query, Unanswered, Work};
use crate::scoring::numbers::significant;
use crate::shown::file_name;
use crate::shown::first;

const MAX_NAMED: usize = 8;

#[derive(Clone, Debug, PartialEq)]
pub enum KnownOf {
    Nothing,
    Layout(TextLayout),
    /// Complete column map, which is tried.
    Map(Box<ColumnMap>),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Preview {
    pub path: PathBuf,
    pub known: KnownOf,
}

impl Query for Preview {
    type Answer = Arc<Inspection>;
    type Cache = ();

    fn title(&self) -> String {
        "Inspecting a file".to_owned()
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

/// Command of the import window.
#[derive(Clone, Debug)]
pub enum ImportCommand {
    /// Import this file.
    Open(PathBuf),
    /// Use this text layout; the columns are detected again.
    SetLayout(TextLayout),
    /// Use this column map.
    SetMap(Box<ColumnMap>),
    /// Estimate the weight from the pose and the measured load.
    FindWeight,
    /// Detect layout and columns again.
    Begin,
    /// Use this remembered map.
    TakeMap(usize),
    /// Read a map from a file.
    ReadMap(PathBuf),
    /// Write the map to a file.
    WriteMap(PathBuf),
    /// Load the file with the map, and remember the map.
    Load,
    /// Answer to a question: decided or not.
    Decide(usize, bool),
    /// Cancel the import of this file, and continue with the next.
    Cancel,
    /// Cancel the import of this and all waiting files.
    CancelAll,
}

#[derive(Clone, Debug)]
pub struct Importing {
    pub path: PathBuf,
    /// Newest result of the inspection.
    pub inspection: Option<Arc<Inspection>>,
    pub map: ColumnMap,
    pub problem: Option<String>,
    pub is_detecting: bool,
    /// Questions about the last proposal, and whether the user has answered them.
    pub questions: Vec<(Question, bool)>,
    /// True if the running inspection makes a proposal.
    proposes: bool,
    /// Waiting files that need a column map. Files of the same shape use this map.
    pub waiting: Vec<PathBuf>,
}

impl Importing {
    /// Starts the import of an unknown file.
    pub fn of(path: PathBuf, waiting: Vec<PathBuf>) -> Self {
        Self {
            path,
            inspection: None,
            map: ColumnMap::default(),
            problem: None,
            is_detecting: true,
            questions: Vec::new(),
            proposes: true,
            waiting,
        }
    }
}

pub fn by_remembered(mut files: Vec<(PathBuf, ColumnMap)>) -> Vec<String> {
    let mut text = Vec::new();
    while let Some((_, map)) = files.first().cloned() {
        let (by_it, others): (Vec<_>, Vec<_>) =
            files.into_iter().partition(|(_, other)| *other == map);
        files = others;
        let names = by_it.iter().map(|(path, _)| path.file_name().unwrap_or_default().display());
        text.push(format!(
            "{}: read with the column map of an earlier, similar file: {}. If this is wrong, close the recording and choose its columns with File > Import",
            first(1, names),
            roles_in_words(&map.table)
        ));
    }
    text
}

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
    /// Returns a message that this file and all waiting files were not read.
    pub(super) fn not_read(&self) -> String {
        let files = [&self.path].into_iter().chain(&self.waiting);
        let names = files.map(|path| file_name(path));
        format!("Not read, because no columns were chosen: {}", first(MAX_NAMED, names))
    }

    /// Changes the information about the file, and returns the inspection to run.
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

    pub(super) fn look(&mut self, known: KnownOf) -> Preview {
        self.is_detecting = true;
        self.proposes = !matches!(known, KnownOf::Map(_));
        Preview { path: self.path.clone(), known }
    }

    /// Uses this weight for the load. If no centre of mass was found, the entered one stays.
    pub(super) fn take_weight(&mut self, estimate: &WeightEstimate) -> Preview {
        let weight = self.map.weight.get_or_insert_default();
        weight.mass_kg = Some(estimate.mass_kg);
        weight.centre_m = estimate.centre_m.or(weight.centre_m);
        self.look(KnownOf::Map(Box::new(self.map.clone())))
    }

    /// Uses a finished map, which answers all questions.
    pub(super) fn take_map(&mut self, map: ColumnMap) -> Preview {
        for (_, is_decided) in &mut self.questions {
            *is_decided = true;
        }
        self.map = map;
        self.look(KnownOf::Map(Box::new(self.map.clone())))
    }

    /// Takes the result of an inspection, if it is of this file.
    pub(super) fn take_answer(&mut self, path: &Path, answer: Result<&Arc<Inspection>, &str>) {
        if path != self.path {
            return;
        }
        self.is_detecting = false;
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
