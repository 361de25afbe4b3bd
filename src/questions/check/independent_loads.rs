//! Result of a check of the training recordings. A figure is `None` if the data do not determine it.

use serde::{Serialize, Serializer, ser::SerializeMap as _};

use crate::{
    finding::{Face, Finding, Id, Verdict},
    questions::{
        budget::{ErrorBudget, Remedy},
        errors::findings::LoadCount,
    },
    recording::Axis,
    scoring::{numbers::significant, rig::RigReport},
};

#[derive(Debug, Serialize)]
pub struct Sufficiency {
    /// Verdict on the recordings: the gravest severity in `findings`.
    pub verdict: Verdict,
    /// Where the held-out error comes from, or the reason why this is unknown.
    #[serde(flatten, serialize_with = "as_budget")]
    pub budget: Result<ErrorBudget, String>,
    /// What lowers the error that is left, for the largest causes first.
    pub remedies: Vec<Remedy>,
    /// Text with the numbers of coefficients, load cases and samples.
    pub summary: String,
    /// Findings: faults of recordings first, then by severity, then by the error that they cause.
    pub findings: Vec<Finding>,
    pub n_samples: u64,
    #[serde(flatten)]
    pub count: LoadCount,
    pub rank: usize,
    /// Condition number of the matrix of features that is used in the fit.
    pub condition: Option<f64>,
    pub axes: Vec<AxisReach>,
    /// Faulty channels of each training recording that has some, in words.
    pub faults: Vec<String>,
    /// Zeros and sensitivities of the gauges in each recording, and the faults of the test rig that follow from them.
    pub rig: RigReport,
    /// Text about the loads with which the calibration was tested, and about conditions that the recordings do not cover.
    pub holds_for: String,
}

#[derive(Debug, Serialize)]
pub struct AxisReach {
    pub axis: Axis,
    /// Smallest training load (N, N·m).
    pub low: f64,
    /// Largest training load (N, N·m).
    pub high: f64,
    /// Full scale of the axis (N, N·m); 0 if the load does not move.
    pub full_scale: f64,
    /// True if the full scale is a rated load that the user entered.
    pub rated: bool,
    /// Range of loads (N, N·m) for which the calibration is meant: the rated range, or the recorded range if the user entered
    /// no rated load.
    pub region: (f64, f64),
    pub deviation: f64,
    /// Variance inflation factor: variance of the load divided by the variance of its part that does not follow from the
    /// loads on other axes. It is 1 if the axis moves independently.
    pub inflation: Option<f64>,
    pub train_rmse: Option<f64>,
    pub left_out_rmse: Option<f64>,
    /// Other axis whose training loads correlate most with those of this axis, and the correlation.
    pub moves_with: Option<(Axis, f64)>,
}

fn as_budget<S: Serializer>(
    budget: &Result<ErrorBudget, String>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(None)?;
    match budget {
        Ok(budget) => {
            map.serialize_entry("budget", budget)?;
            map.serialize_entry("budget_in_words", &budget.sentences())?;
        }
        Err(reason) => map.serialize_entry("no_budget", reason)?,
    }
    map.end()
}

impl Sufficiency {
    /// Returns the findings as sentences. If no finding gives the number of load cases, a sentence with this number is added.
    pub fn sentences(&self, face: Face) -> impl Iterator<Item = String> {
        let is_count = |own: &Finding| own.id == Id::FewLoads;
        let summary = (!self.findings.iter().any(is_count)).then(|| self.summary.clone());
        self.findings.iter().map(move |own| own.text(face)).chain(summary)
    }

    /// Returns the remedies in words, for readers without a command line.
    pub fn remedies_in_words(&self) -> Vec<String> {
        let budget = self.budget.iter();
        let of =
            |budget| self.remedies.iter().map(move |own| own.text(&own.action.words(), budget));
        budget.flat_map(of).collect()
    }

    pub fn rank_in_words(&self) -> String {
        let n = self.count.coefficients;
        let mut rank = format!("Rank {} of the matrix with {n} features", self.rank);
        if self.rank < n {
            rank += ": the remaining features follow from the others or never change";
        }
        match self.condition.filter(|_| self.rank > 1) {
            Some(condition) => format!("{rank}, condition number {}.", significant(condition, 3)),
            None => format!("{rank}."),
        }
    }
}
