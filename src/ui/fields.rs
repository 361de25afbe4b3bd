//! What is typed and chosen in the window and belongs to no setting.

use crate::evaluation::threshold_study::ScoreSet;

/// What stands in the window's text fields.
#[derive(Debug)]
pub struct Fields {
    /// The path to open.
    pub open: String,
    /// The path to export to.
    pub export: String,
    /// The share of a split that trains (%).
    pub split_percent: f64,
    /// The path to save the comparison to.
    pub comparison: String,
    /// Which errors the comparison shows.
    pub errors_on: ScoreSet,
    /// The path to save the map of thresholds to.
    pub study: String,
    /// Which errors the map shows.
    pub study_on: ScoreSet,
    /// Where a file of the session is now.
    pub found: String,
    /// The path that is being typed for what waits to be saved.
    pub name: Option<String>,
}

impl Default for Fields {
    fn default() -> Self {
        Self {
            open: String::new(),
            export: "calibration.json".to_owned(),
            split_percent: 60.0,
            comparison: "comparison.csv".to_owned(),
            errors_on: ScoreSet::Test,
            study: "thresholds.csv".to_owned(),
            study_on: ScoreSet::LeftOut,
            found: String::new(),
            name: None,
        }
    }
}
