//! Compares the number of load cases with the number of coefficients. The same rule is used in a fit and in a check of the
//! recordings.

use serde::Serialize;

use crate::{
    calibration::Calibration,
    finding::{Finding, Id, Verdict},
    scoring::{coverage::Coverage, numbers::significant},
    shown::counted,
};

/// Number of load cases per free coefficient below which a finding is grave. With so few load cases, the errors on other
/// loads are expected to be five times those of the fit, even if the model is right.
const FEWEST_CASES: f64 = 1.25;
/// Number of load cases per free coefficient below which a finding is reported. With so few load cases, the errors on other
/// loads are expected to be twice those of the fit, even if the model is right.
const FEW_CASES: f64 = 2.0;
/// Largest expected ratio of errors that is shown. A larger ratio tells no more than that there are too few loads.
const TIMES: f64 = 100.0;

#[derive(Clone, Copy, Debug, Serialize)]
pub struct LoadCount {
    /// Number of different loads. If features use earlier gauge values, number of changes of the load.
    pub load_cases: usize,
    /// True if the count of different loads stopped at `load_cases`, because more of them would change no finding.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub more_load_cases: bool,
    pub coefficients: usize,
    /// Effective number of coefficients, which the data determine instead of the ridge, on the axis with the largest such number.
    pub free_coefficients: f64,
}

impl LoadCount {
    pub fn of(calibration: &Calibration, coverage: &Coverage) -> Self {
        let columns = calibration.columns();
        let coefficients = columns.len();
        let free = calibration.quality.free_coefficients;
        let (load_cases, more_load_cases) = coverage.n_cases(&columns);
        Self {
            load_cases,
            more_load_cases,
            coefficients,
            free_coefficients: free.unwrap_or(coefficients as f64),
        }
    }

    pub fn words(&self) -> String {
        let Self { load_cases, more_load_cases, coefficients, free_coefficients } = self;
        let few = free_coefficients.ceil();
        let free = if few < *coefficients as f64 {
            format!(" ({few:.0} of which the data determine)")
        } else {
            String::new()
        };
        let cases = if *more_load_cases {
            "more than 1,000 load cases".to_owned()
        } else {
            counted(*load_cases, "load case")
        };
        format!("{coefficients} coefficients per axis{free} are fitted to {cases}")
    }

    pub fn finding(&self) -> Option<Finding> {
        let (n, p) = (self.load_cases as f64, self.free_coefficients);
        if n > p.ceil() && n >= FEW_CASES * p {
            return None;
        }
        let is_grave = n <= p.ceil() || n < FEWEST_CASES * p;
        let severity = if is_grave { Verdict::Insufficient } else { Verdict::Doubtful };
        // For random loads, p free coefficients and n load cases: `E[test MSE] / E[train MSE] = (1 + p/(n−p−1)) / (1 − p/n)`.
        let times = (n > p + 1.0).then(|| ((n - 1.0) / (n - p - 1.0) * n / (n - p)).sqrt());
        let figures = match times {
            _ if n <= p.ceil() => {
                "the number of load cases must be larger than the number of free coefficients"
                    .to_owned()
            }
            Some(times) if times < TIMES => format!(
                "with so few loads, errors on other loads are expected to be about {} times those of the fit",
                significant(times, 2)
            ),
            _ => String::new(),
        };
        Some(Finding::new(Id::FewLoads, severity, self.words()).with(figures))
    }
}
