//! Whether recordings carry a model: what they reach, how many loads they hold for its coefficients, which loads move together,
//! and which load to add next.
//!
//! Guarantees: a figure that the data do not carry is missing; a verdict never stands without its reasons.

use serde::Serialize;

use crate::finding::{Face, Finding, Id, Verdict};
use crate::questions::check::rig::RigReport;
use crate::recording::Axis;
use crate::scoring::numbers::significant;

/// What is known of recordings and a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sufficiency {
    /// The worst of its reasons.
    pub verdict: Verdict,
    /// Coefficients and load cases in words.
    pub summary: String,
    /// What is wrong with recordings, then the gravest first.
    pub reasons: Vec<Finding>,
    /// Training samples.
    pub n_samples: u64,
    /// Loads that can be told apart; with a past, how often the load becomes another one.
    pub load_cases: usize,
    /// Coefficients of an axis.
    pub coefficients: usize,
    /// How many of them are free, with the ridge, on the axis with most.
    pub free_coefficients: f64,
    /// How many features are independent.
    pub rank: usize,
    /// The condition number of the design.
    pub condition: Option<f64>,
    /// What each axis reaches.
    pub axes: Vec<AxisReach>,
    /// What is wrong with channels, for each training recording in words.
    pub faults: Vec<String>,
    /// What to record next, the best first.
    pub next: Vec<NextLoad>,
    /// What is to be known of these, or why there are none.
    pub next_note: String,
    /// Zeros and sensitivities of the gauges in each recording.
    pub rig: RigReport,
    /// What the recordings show, and what they cannot show.
    pub holds_for: String,
}

/// What an axis reaches.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisReach {
    /// Which.
    pub axis: Axis,
    /// The least training load.
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// The full scale, 0 where the load does not move.
    pub full_scale: f64,
    /// Whether somebody entered it.
    pub rated: bool,
    /// From where to where loads are to be expected: the rated ones, or those that there are.
    pub region: (f64, f64),
    /// The standard deviation of the training loads.
    pub deviation: f64,
    /// How much smaller the variance is of what the axis does beside the others; 1 where it goes alone.
    pub inflation: Option<f64>,
    /// The error on the training samples.
    pub train_rmse: Option<f64>,
    /// The error where recordings, groups or blocks are left out.
    pub left_out_rmse: Option<f64>,
    /// The axis with whose training load it correlates most, and the correlation.
    pub moves_with: Option<(Axis, f64)>,
}

/// A load that is worth recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextLoad {
    /// One number per axis.
    pub load: Vec<f64>,
    /// How it is made of a hanging mass, in words.
    pub how: Option<String>,
    /// By how much the logarithm of the determinant of the design grows.
    pub gain: f64,
    /// What is left of the variance of predictions, with it and those before it.
    pub variance_left: f64,
}

impl Sufficiency {
    /// The reasons, and the count where it is none of them.
    pub fn sentences(&self, face: Face) -> impl Iterator<Item = String> {
        let is_count = |own: &Finding| own.id == Id::FewLoads;
        let summary = (!self.reasons.iter().any(is_count)).then(|| self.summary.clone());
        self.reasons.iter().map(move |own| own.text(face)).chain(summary)
    }

    /// Rank and condition of the design in words.
    pub fn rank_in_words(&self) -> String {
        let rank = format!("Rank {} of {} features", self.rank, self.coefficients);
        let rank = match self.rank < self.coefficients {
            true => format!("{rank}, the others repeating these or never changing"),
            false => rank,
        };
        match self.condition.filter(|_| self.rank > 1) {
            Some(condition) => format!("{rank}, condition number {}.", significant(condition, 3)),
            None => format!("{rank}."),
        }
    }
}
