//! What took long to find, as a session keeps it where it is asked to: the last training, and the list of models.
//!
//! Guarantees: what comes back is of the very samples, roles and groups that it was found on, or it is left away with the
//! reason; what a file says of shapes is checked before anything uses it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::analysis::Model;
use crate::calibration::{Calibration, EpochReport, FitSettings, Scores};
use crate::engine::model_in_file::in_file;
use crate::engine::models::KeptRow;
use crate::export::sha256_of;
use crate::recording::{Entry, RecordingSet, Role};

/// A number of a calibration takes about so many bytes in a session.
const BYTES_A_NUMBER: usize = 20;
/// A row of the list takes about so many besides.
const BYTES_A_ROW: usize = 3000;

/// What tells results from others: the last training, and the rows with what is said of them.
pub type ResultsId = (Option<usize>, Vec<(u64, String, bool)>);

/// What was found.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Results {
    /// The recordings that it was found on; filled when it is written.
    of: Vec<UsedSamples>,
    /// What was trained last.
    pub training: Option<KeptTraining>,
    /// The list of models.
    pub rows: Vec<KeptRow>,
    /// What was said of it.
    pub said: Vec<String>,
}

/// A training that has ended.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KeptTraining {
    /// What it was asked for.
    pub settings: FitSettings,
    /// The network's reports, epoch by epoch.
    #[serde(default)]
    pub epochs: Vec<EpochReport>,
    /// What came of it.
    #[serde(with = "in_file")]
    pub calibration: Arc<Calibration>,
}

/// A recording as it was used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct UsedSamples {
    name: String,
    role: Role,
    group: Option<String>,
    /// Of times, gauges and loads.
    sha256: String,
}

impl Results {
    /// What was found.
    pub fn new(training: Option<KeptTraining>, rows: Vec<KeptRow>, said: Vec<String>) -> Self {
        Self {
            of: Vec::new(),
            training,
            rows,
            said,
        }
    }

    /// About how many bytes it takes in a session.
    pub fn size(&self) -> usize {
        let trained = self.training.iter().map(|own| &own.calibration);
        let models = self
            .rows
            .iter()
            .filter_map(|row| row.model.trained.as_ref());
        let numbers: usize = trained.chain(models).map(|own| own.n_coefficients()).sum();
        numbers * BYTES_A_NUMBER + self.rows.len() * BYTES_A_ROW
    }

    /// Whether there is anything.
    pub fn is_empty(&self) -> bool {
        self.training.is_none() && self.rows.is_empty()
    }

    /// As a session has it, of these recordings.
    pub fn in_file(&self, recordings: &RecordingSet) -> Option<Value> {
        let of = recordings.entries().iter().map(UsedSamples::of).collect();
        serde_json::to_value(Self { of, ..self.clone() }).ok()
    }

    /// What a session has, where it holds for these recordings.
    ///
    /// # Errors
    /// A sentence if it does not, or cannot be understood.
    pub fn proven(file: &Value, recordings: &RecordingSet) -> Result<Self, String> {
        let without = "The session is opened without its trained results";
        let results = Self::deserialize(file).map_err(|error| format!("{without}: {error}"))?;
        let now: Vec<_> = recordings.entries().iter().map(UsedSamples::of).collect();
        let why = difference(&results.of, &now).or_else(|| results.misfit(recordings));
        match why {
            Some(why) => Err(format!("{without}: {why}")),
            None => Ok(results),
        }
    }

    /// Why it cannot be of recordings with these columns.
    fn misfit(&self, recordings: &RecordingSet) -> Option<String> {
        let layout = recordings.layout();
        let has_columns =
            |own: &Arc<Calibration>| own.gauges == layout.gauge_names && own.axes == layout.axes;
        let n_axes = layout.axes.len();
        let is_whole = |model: &Model| {
            let all = |scores: &Scores| {
                let sets = [&scores.train_rmse, &scores.test_rmse, &scores.cv_rmse];
                sets.into_iter().flatten().all(|rmse| rmse.len() == n_axes)
            };
            let spread = model.cv_spread.len();
            model.axes == layout.axes
                && all(&model.scores)
                && all(&model.conventional)
                && (spread == 0 || spread == n_axes)
                && model.trained.iter().all(has_columns)
        };
        let training = self.training.iter().map(|own| &own.calibration);
        let fits = training.into_iter().all(has_columns)
            && self.rows.iter().all(|row| is_whole(&row.model));
        (!fits).then(|| "they are of other gauges or axes".to_owned())
    }
}

impl UsedSamples {
    fn of(entry: &Entry) -> Self {
        let recording = &entry.recording;
        let numbers = [recording.times(), recording.gauges(), recording.loads()];
        Self {
            name: recording.name().to_owned(),
            role: entry.role,
            group: entry.group.clone(),
            sha256: sha256_of(numbers.into_iter().flatten().copied()),
        }
    }
}

/// The first thing in which recordings are others than they were.
fn difference(then: &[UsedSamples], now: &[UsedSamples]) -> Option<String> {
    for own in now {
        let name = &own.name;
        let Some(before) = then.iter().find(|other| other.name == *name) else {
            return Some(format!("{name} was not among the recordings then"));
        };
        if before.sha256 != own.sha256 {
            return Some(format!("{name} holds other samples than then"));
        }
        if before.role != own.role {
            return Some(format!("{name} had another role then"));
        }
        if before.group != own.group {
            return Some(format!("{name} was in another group then"));
        }
    }
    let is_gone = |own: &&UsedSamples| !now.iter().any(|other| other.name == own.name);
    let gone = then.iter().find(is_gone);
    let gone = gone.map(|own| format!("{} is not there any more", own.name));
    gone.or_else(|| (then.len() != now.len()).then(|| "a recording was there twice".to_owned()))
}
