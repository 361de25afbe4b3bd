//! State of the import page, in which the user chooses the columns of a file.

use std::path::PathBuf;
use std::sync::Arc;

use crate::{
    formats::text::TextLayout,
    import::{
        ReadError,
        inspect::{Inspection, Known, Question, inspect},
        map::{ColumnMap, ColumnRole, TableMap},
        pose::WeightEstimate,
    },
    questions::question::{Answered, Query, Unanswered, Work},
    shown::{counted, file_name, first},
};

const MAX_NAMED: usize = 8;

#[derive(Clone, Debug, PartialEq)]
pub struct Preview {
    pub path: PathBuf,
    pub known: Known,
}

impl Query for Preview {
    type Answer = Arc<Inspection>;
    type Cache = ();

    fn title(&self) -> String {
        "Inspecting a file".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let found = inspect(&self.path, self.known.clone(), work.progress);
        found.map(Arc::new).map_err(|error| match error {
            ReadError::Cancelled => Unanswered::Cancelled,
            error => Unanswered::Because(error.to_string()),
        })
    }
}

/// Command that the user gives in the import page.
#[derive(Clone, Debug)]
pub enum ImportCommand {
    /// Open the import page to choose the columns of this file.
    Open(PathBuf),
    /// Use this text layout (separators and header rows), and detect the columns again.
    SetLayout(TextLayout),
    /// Use this column map for the file.
    SetMap(Box<ColumnMap>),
    /// Estimate the weight and centre of mass that the sensor carries, from the pose and the measured load.
    FindWeight,
    /// Detect text layout and columns of the file again, as if it had just been opened.
    Begin,
    /// Load the file by the column map, and remember the map for similar files.
    Load,
    /// Cancel the import of this file, and continue with the next waiting file.
    Cancel,
    /// Cancel the import of this file and of all waiting files.
    CancelAll,
}

#[derive(Clone, Debug, Default)]
pub struct Importing {
    pub path: PathBuf,
    /// Description of the file, and of the recordings that the present column map would load from it.
    pub inspection: Option<Arc<Inspection>>,
    pub map: ColumnMap,
    pub problem: Option<String>,
    pub is_detecting: bool,
    /// Questions that the proposed column map leaves open, such as a unit.
    pub questions: Vec<Question>,
    /// True if the running inspection proposes a column map; false if it tries the map that the user has chosen.
    pub proposes: bool,
    /// Files that are imported after this one. Files with the same columns are read by the column map of this file.
    pub waiting: Vec<PathBuf>,
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
    others.chain([counted(n_gauges, "gauge")]).collect::<Vec<_>>().join(", ")
}

impl Importing {
    /// Returns a message that this file and all waiting files were not read.
    pub(super) fn not_read(&self) -> String {
        let names = [&self.path].into_iter().chain(&self.waiting).map(|path| file_name(path));
        format!("Not read, because no columns were chosen: {}", first(MAX_NAMED, names))
    }

    pub(super) fn look(&mut self, known: Known) -> Preview {
        self.is_detecting = true;
        self.proposes = !matches!(known, Known::Map(_));
        Preview { path: self.path.clone(), known }
    }

    /// Uses this text layout, and returns the request for an inspection that detects the columns again.
    pub(super) fn take_layout(&mut self, text: TextLayout) -> Preview {
        self.map.table.text = text.clone();
        self.look(Known::Layout(text))
    }

    /// Uses this column map, and returns the request for an inspection that reads the file by it.
    pub(super) fn try_map(&mut self, map: ColumnMap) -> Preview {
        self.map = map;
        self.look(Known::Map(Box::new(self.map.clone())))
    }

    /// Writes the estimated weight into the column map. If the estimate has no centre of mass, the entered one stays.
    pub(super) fn take_weight(&mut self, estimate: &WeightEstimate) -> Preview {
        let mut map = self.map.clone();
        let weight = map.weight.get_or_insert_default();
        weight.mass_kg = Some(estimate.mass_kg);
        weight.centre_m = estimate.centre_m.or(weight.centre_m);
        self.try_map(map)
    }

    /// Uses a complete column map, which leaves no question open.
    pub(super) fn take_map(&mut self, map: ColumnMap) -> Preview {
        self.questions.clear();
        self.try_map(map)
    }

    pub(super) fn take_inspection(&mut self, inspection: &Arc<Inspection>) {
        if self.proposes {
            self.questions = inspection.questions.clone();
        }
        self.map = inspection.map.clone();
        self.inspection = Some(Arc::clone(inspection));
        self.problem = None;
    }
}
