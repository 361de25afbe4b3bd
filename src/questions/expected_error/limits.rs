//! Limits that the user sets for a calibration: the maximum expected error, RMSE and loop width, for all axes or for each axis.
//!
//! Guarantees: a figure that has a limit, but no known value, fails its limit. A misspelt name in the file of limits is an
//! error that lists the valid names.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::{
    calibration::{ExpectedError, Quality},
    questions::metrology::{Metrology, Quantity},
    recording::Axis,
    scoring::numbers::significant,
    small_file::{TomlError, read_toml},
};

/// Error figure of a calibration for which the user can set a maximum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limited {
    /// Load error within which 95 % of the errors on further recordings should lie.
    ExpectedError,
    /// Root mean squared error of cross-validation or of the test recordings, whichever is larger.
    Rmse,
    /// Largest width of the compensated load's loop in the largest load cycle.
    LoopWidth,
}

impl Limited {
    pub fn name(self) -> &'static str {
        match self {
            Self::ExpectedError => "expected error",
            Self::Rmse => "RMSE",
            Self::LoopWidth => "loop width",
        }
    }
}

/// Measured figures of a calibration, which are compared with the limits.
pub struct Measured<'a> {
    /// Axes of the calibration, each with its full scale (N or N·m); 0 if there is none.
    pub axes: &'a [(Axis, f64)],
    pub quality: &'a Quality,
    pub expected_error: &'a Result<ExpectedError, String>,
    pub metrology: Result<&'a Metrology, &'a str>,
}

impl Measured<'_> {
    /// Returns the value of a figure on an axis, in the unit of a limit.
    fn of(&self, bound: Bound, figure: Limited, axis: Axis) -> Result<f64, String> {
        let at = self.axes.iter().position(|known| known.0 == axis);
        let at = at.ok_or("the calibration does not have this axis")?;
        let value = match figure {
            Limited::ExpectedError => {
                self.expected_error.as_ref().map_err(Clone::clone)?.of_axis(axis)?
            }
            Limited::Rmse => {
                let scores = &self.quality.compensated;
                let held_out = [&scores.cv_rmse, &scores.test_rmse].into_iter().flatten();
                let worst = held_out.map(|rmse| rmse[at]).reduce(f64::max);
                worst.ok_or("there is neither cross-validation nor a test recording")?
            }
            Limited::LoopWidth => {
                let rows = &self.metrology?.rows;
                let row = rows.iter().find(|row| row.quantity == Quantity::Hysteresis);
                let cell = row.ok_or("not measured")?.cells[at].compensated.as_ref();
                cell.map_err(ToString::to_string)?.value.abs()
            }
        };
        match (bound, self.axes[at].1) {
            (Bound::Load(_), _) => Ok(value),
            (Bound::Percent(_), full) if full > 0.0 => Ok(100.0 * value / full),
            _ => Err("the axis has no full scale".to_owned()),
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Bound {
    Percent(f64),
    Load(f64),
}

/// All limits of a file: limited figure, axis, and maximum. `None` in place of the axis stands for all axes.
#[derive(Clone, Debug, Default)]
pub struct Limits(Vec<(Limited, Option<Axis>, Bound)>);

#[derive(Debug, Serialize)]
pub struct Checked {
    pub figure: Limited,
    pub axis: Axis,
    /// Value of the limited figure, in `unit`; `None` if unknown.
    pub value: Option<f64>,
    pub limit: f64,
    pub unit: &'static str,
    /// True if the value of the figure is known and not above the limit.
    pub pass: bool,
    /// Reason why the value of the figure is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Checked {
    pub fn in_words(&self) -> String {
        let number = |value: f64| format!("{} {}", significant(value, 4), self.unit);
        let value = match (self.value, &self.reason) {
            (Some(value), _) => number(value),
            (None, reason) => format!("not known ({})", reason.as_deref().unwrap_or_default()),
        };
        let (figure, axis) = (self.figure.name(), self.axis.symbol());
        format!("{figure} of {axis} is {value}; the limit is {}", number(self.limit))
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    One(Entry),
    ByAxis(BTreeMap<Axis, Entry>),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Entry {
    Number(f64),
    Text(String),
}

impl Entry {
    fn bound(&self) -> Option<Bound> {
        let is_maximum = |number: &f64| number.is_finite() && *number >= 0.0;
        match self {
            Self::Number(number) => Some(*number).filter(is_maximum).map(Bound::Percent),
            Self::Text(text) => {
                let at = text.find(|letter: char| "%N".contains(letter))?;
                let number = text[..at].trim().parse().ok().filter(is_maximum)?;
                match text[at..].trim() {
                    "%" | "% FS" => Some(Bound::Percent(number)),
                    "N" | "N·m" | "Nm" | "N-m" => Some(Bound::Load(number)),
                    _ => None,
                }
            }
        }
    }
}

impl Limits {
    /// Reads a file such as
    ///
    /// ```toml
    /// expected_error = 1.0                      # at most 1 % of full scale, every axis
    /// loop_width = { Fx = 0.5, Fz = "0.2 N" }   # one maximum per axis, in % or in N and N·m
    /// ```
    ///
    /// # Errors
    /// [`TomlError`] if the file cannot be read, or names an unknown figure.
    pub fn read(path: &Path) -> Result<Self, TomlError> {
        read_toml(path, "a list of limits", Self::from_toml)
    }

    fn from_toml(text: &str) -> Result<Self, String> {
        let written: BTreeMap<Limited, Written> =
            toml::from_str(text).map_err(|error| error.to_string().trim().replace('\n', " "))?;
        let mut limits = Vec::new();
        for (figure, entries) in written {
            let entries = match entries {
                Written::One(entry) => vec![(None, entry)],
                Written::ByAxis(axes) => {
                    let axes = axes.into_iter();
                    axes.map(|(axis, entry)| (Some(axis), entry)).collect()
                }
            };
            for (axis, entry) in entries {
                let bound = entry.bound().ok_or_else(|| {
                    let name = figure.name();
                    format!("the limit of the {name} is neither a number nor a number with a unit such as \"0.2 N\" or \"1 %\"")
                })?;
                limits.push((figure, axis, bound));
            }
        }
        Ok(Self(limits))
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn ask_for_loops(&self) -> bool {
        self.0.iter().any(|(figure, ..)| *figure == Limited::LoopWidth)
    }

    pub fn check(&self, measured: &Measured<'_>) -> Vec<Checked> {
        let mut checked = Vec::new();
        for (figure, axis, bound) in &self.0 {
            let all = measured.axes.iter().map(|axis| axis.0);
            for axis in axis.map_or_else(|| all.collect(), |axis| vec![axis]) {
                let (limit, unit) = match *bound {
                    Bound::Percent(limit) => (limit, "% FS"),
                    Bound::Load(limit) => (limit, axis.unit()),
                };
                let value = measured.of(*bound, *figure, axis);
                checked.push(Checked {
                    figure: *figure,
                    axis,
                    limit,
                    unit,
                    pass: value.as_ref().is_ok_and(|value| *value <= limit),
                    reason: value.as_ref().err().cloned(),
                    value: value.ok(),
                });
            }
        }
        checked
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::{AxisExpectedError, Scores};

    fn verdicts(text: &str) -> Vec<(String, bool)> {
        let expected = |axis: Axis, value| AxisExpectedError {
            axis,
            unit: axis.unit().to_owned(),
            range: (-1.0, 1.0),
            value,
            percent_fs: None,
            cross_validation: value,
            test: None,
        };
        let quality = Quality {
            compensated: Scores {
                cv_rmse: Some(vec![1.0, 0.2]),
                test_rmse: Some(vec![2.0, 0.1]),
                ..Scores::default()
            },
            ..Quality::default()
        };
        let expected_error = Ok(ExpectedError {
            axes: vec![expected(Axis::Fx, Some(2.0)), expected(Axis::Mz, None)],
            ..ExpectedError::default()
        });
        let measured = Measured {
            axes: &[(Axis::Fx, 200.0), (Axis::Mz, 5.0)],
            quality: &quality,
            expected_error: &expected_error,
            metrology: Err("no cycle"),
        };
        let checked = Limits::from_toml(text).unwrap().check(&measured);
        checked.iter().map(|limit| (limit.in_words(), limit.pass)).collect()
    }

    #[test]
    fn every_axis_keeps_its_limit_in_percent_or_in_its_unit() {
        let outcome = |text: &str, pass: bool| (text.to_owned(), pass);
        assert_eq!(
            verdicts("rmse = 1.0"),
            [
                outcome("RMSE of Fx is 1.000 % FS; the limit is 1.000 % FS", true),
                outcome("RMSE of Mz is 4.000 % FS; the limit is 1.000 % FS", false)
            ],
            "the larger of cross-validation and test"
        );
        assert_eq!(
            verdicts("rmse = { Mz = \"0.2 N·m\" }"),
            [outcome("RMSE of Mz is 0.2000 N·m; the limit is 0.2000 N·m", true)]
        );
        assert_eq!(
            verdicts("expected_error = { Fx = 1 }"),
            [outcome("expected error of Fx is 1.000 % FS; the limit is 1.000 % FS", true)]
        );
    }

    #[test]
    fn a_figure_that_is_not_known_does_not_pass() {
        for text in ["loop_width = 5", "expected_error = { Mz = 100 }", "rmse = { Fz = 100 }"] {
            for (outcome, pass) in verdicts(text) {
                assert!(!pass && outcome.contains("is not known ("), "{outcome}");
            }
        }
    }

    #[test]
    fn a_misspelt_figure_is_refused_with_the_known_ones() {
        let wrong = |text: &str| Limits::from_toml(text).unwrap_err();
        let misspelt = wrong("rms = 1");
        assert!(misspelt.contains("rms") && misspelt.contains("expected_error"), "{misspelt}");
        assert!(wrong("rmse = \"small\"").contains("\"0.2 N\""));
        assert!(wrong("rmse = nan").contains("neither a number"));
        assert!(wrong("rmse = { Fq = 1 }").contains("did not match"));
    }
}
