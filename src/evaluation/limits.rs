//! What a calibration must keep to be handed over: limits on figures, and what came of them.
//!
//! Guarantees: a figure that is not known does not pass; a name that is not known is refused, with those that are.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize, Serializer};

use crate::calibration::Quality;
use crate::evaluation::metrology::{Metrology, Quantity};
use crate::evaluation::numbers::significant;
use crate::evaluation::uncertainty::{StepQuantity, Uncertainty};
use crate::recording::Axis;
use crate::small_file::read_small;

/// No list of limits is longer.
const BYTES_LIMIT: u64 = 1 << 20;
/// Figures beside those of the table.
const OWN: [&str; 7] = [
    "U",
    "coverage",
    "condition",
    "rank",
    "train_rmse",
    "left_out_rmse",
    "test_rmse",
];

fn step_id(quantity: StepQuantity) -> &'static str {
    match quantity {
        StepQuantity::Reproducibility => "b",
        StepQuantity::Repeatability => "b_prime",
        StepQuantity::Interpolation => "fc",
        StepQuantity::Zero => "f0",
        StepQuantity::Reversibility => "v",
        StepQuantity::LowerLimitFactor => "LLF",
    }
}

/// One figure of a calibration, as limits and lists of results know it.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Its name in files.
    pub id: String,
    /// Of which axis; `None` for the whole calibration.
    pub axis: Option<Axis>,
    /// In `unit`, or why it is not known.
    pub value: Result<f64, String>,
    /// Its unit; empty for a number.
    pub unit: &'static str,
    /// Full scale, where it can be told in percent of it.
    pub full_scale: Option<f64>,
}

/// Every figure that can be limited.
pub fn measurements(
    axes: &[(Axis, f64)],
    quality: &Quality,
    metrology: &Result<impl AsRef<Metrology>, String>,
    uncertainty: &Result<Uncertainty, String>,
) -> Vec<Measurement> {
    let full = |at: usize| Some(axes[at].1).filter(|full| *full > 0.0);
    let by_axis = |id: &str, of: &dyn Fn(usize) -> (Result<f64, String>, &'static str, bool)| {
        let one = |at: usize| {
            let (value, unit, is_load) = of(at);
            Measurement {
                id: id.to_owned(),
                axis: Some(axes[at].0),
                value,
                unit,
                full_scale: full(at).filter(|_| is_load),
            }
        };
        (0..axes.len()).map(one).collect::<Vec<_>>()
    };
    let unit = |at: usize| axes[at].0.unit();
    let known = uncertainty.as_ref();
    let of_axis = |at: usize| {
        known
            .map_err(Clone::clone)
            .and_then(|own| own.of_axis(axes[at].0))
    };
    let mut all = by_axis("U", &|at| {
        (of_axis(at).map(|own| own.expanded), unit(at), true)
    });
    all.extend(by_axis("coverage", &|at| {
        let share = of_axis(at).and_then(|own| own.coverage.clone());
        (share.map(|own| 100.0 * own.share), "%", false)
    }));
    let scores = &quality.compensated;
    for (id, rmse, why) in [
        ("train_rmse", &scores.train_rmse, "nothing was fitted"),
        ("left_out_rmse", &scores.cv_rmse, "nothing was left out"),
        (
            "test_rmse",
            &scores.test_rmse,
            "no recording is in the test role",
        ),
    ] {
        let value = |at: usize| {
            rmse.as_ref()
                .map(|own| own[at])
                .ok_or_else(|| why.to_owned())
        };
        all.extend(by_axis(id, &|at| (value(at), unit(at), true)));
    }
    match metrology {
        Ok(table) => {
            for row in &table.as_ref().rows {
                let value = |at: usize| {
                    let found = &row.cells[at].compensated;
                    found
                        .as_ref()
                        .map(|own| own.value)
                        .map_err(ToString::to_string)
                };
                let is_load = !row.quantity.is_time();
                all.extend(by_axis(&row.definition.id, &|at| {
                    (value(at), row.cells[at].unit, is_load)
                }));
            }
        }
        Err(reason) => {
            let axes: Vec<Axis> = axes.iter().map(|(axis, _)| *axis).collect();
            for quantity in Quantity::all(&axes) {
                all.extend(by_axis(&quantity.definition().id, &|at| {
                    (Err(reason.clone()), unit(at), true)
                }));
            }
        }
    }
    for (place, quantity) in StepQuantity::ALL.into_iter().enumerate() {
        let value = |at: usize| {
            known
                .map_err(Clone::clone)
                .and_then(|own| own.steps[at].figures[place].value.clone())
        };
        let is_load = quantity == StepQuantity::LowerLimitFactor;
        all.extend(by_axis(step_id(quantity), &|at| {
            (value(at), if is_load { unit(at) } else { "%" }, is_load)
        }));
    }
    let whole = |id: &str, value: Result<f64, String>| Measurement {
        id: id.to_owned(),
        axis: None,
        value,
        unit: "",
        full_scale: None,
    };
    all.push(whole(
        "condition",
        quality
            .condition
            .ok_or_else(|| "no column is independent".to_owned()),
    ));
    all.push(whole("rank", Ok(quality.rank as f64)));
    all
}

/// How far a figure may go.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bound {
    /// A number: percent of full scale for a load, else in the figure's own unit.
    Number(f64),
    /// In N or N·m.
    Load(f64),
    /// As many as there are.
    Full,
}

/// One limit.
#[derive(Clone, Debug, PartialEq)]
struct Limit {
    id: String,
    axis: Option<Axis>,
    bound: Bound,
}

/// All limits of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits(Vec<Limit>);

/// Why limits cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct LimitsError {
    path: String,
    reason: String,
}

/// What came of one limit on one axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Checked {
    /// The figure.
    pub figure: String,
    /// Of which axis.
    pub axis: Option<Axis>,
    /// What it is, in the limit's unit; `None` where it is not known.
    pub value: Option<f64>,
    /// What it must keep.
    pub limit: f64,
    /// The unit of both.
    pub unit: String,
    /// Whether the figure must be at least that rather than at most.
    pub at_least: bool,
    /// Whether it does.
    pub pass: bool,
    /// Why it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Checked {
    /// In a sentence.
    pub fn told(&self) -> String {
        let axis = self
            .axis
            .map_or_else(String::new, |axis| format!(" of {}", axis.symbol()));
        let space = if self.unit.is_empty() { "" } else { " " };
        let limit = format!("{}{space}{}", significant(self.limit, 4), self.unit);
        let side = if self.at_least { "at least" } else { "at most" };
        match (self.value, &self.reason) {
            (Some(value), _) => format!(
                "{}{axis} is {}{space}{}, {side} {limit}",
                self.figure,
                significant(value, 4),
                self.unit
            ),
            (None, reason) => {
                let reason = reason.as_deref().unwrap_or("not known");
                format!(
                    "{}{axis} is not known ({reason}), {side} {limit}",
                    self.figure
                )
            }
        }
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Number(f64),
    Text(String),
    ByAxis(BTreeMap<Axis, Entry>),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Entry {
    Number(f64),
    Text(String),
}

impl Limits {
    /// Reads a file like
    ///
    /// ```toml
    /// U = 1.0                                   # at most 1 % of full scale, every axis
    /// hysteresis = { Fx = 0.5, Fz = "0.2 N" }   # each axis its own, or in N and N·m
    /// coverage = 90                             # at least 90 %
    /// condition = 1e4
    /// rank = "full"
    /// ```
    ///
    /// # Errors
    /// [`LimitsError`] if it cannot be read, or has a figure that is not known.
    pub fn read(path: &Path) -> Result<Self, LimitsError> {
        let wrong = |reason: String| LimitsError {
            path: path.display().to_string(),
            reason,
        };
        let text = read_small(path, "a list of limits", BYTES_LIMIT)
            .map_err(|error| wrong(error.to_string()))?;
        let text = String::from_utf8(text).map_err(|_| wrong("not in UTF-8".to_owned()))?;
        Self::from_toml(&text).map_err(wrong)
    }

    fn from_toml(text: &str) -> Result<Self, String> {
        let written: BTreeMap<String, Written> =
            toml::from_str(text).map_err(|error| error.to_string().trim().replace('\n', " "))?;
        let mut limits = Vec::new();
        for (id, own) in written {
            if !known_ids().contains(&id) {
                return Err(format!("{id} is not one of {}", known_ids().join(", ")));
            }
            let mut push = |axis, entry: Entry| {
                let bound = match entry {
                    Entry::Number(number) if number.is_finite() => Some(Bound::Number(number)),
                    Entry::Number(_) => None,
                    Entry::Text(text) => bound(&text, &id),
                };
                let bound = bound.ok_or_else(|| {
                    format!("the limit of {id} is neither a number nor one with a unit like \"0.2 N\" or \"1 %\"")
                })?;
                limits.push(Limit {
                    id: id.clone(),
                    axis,
                    bound,
                });
                Ok::<(), String>(())
            };
            match own {
                Written::Number(number) => push(None, Entry::Number(number))?,
                Written::Text(text) => push(None, Entry::Text(text))?,
                Written::ByAxis(axes) => axes
                    .into_iter()
                    .try_for_each(|(axis, entry)| push(Some(axis), entry))?,
            }
        }
        Ok(Self(limits))
    }

    /// Whether nothing is limited.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The names of the figures that are limited, each once.
    pub fn figures(&self) -> Vec<&str> {
        let mut ids: Vec<&str> = self.0.iter().map(|limit| &*limit.id).collect();
        ids.dedup();
        ids
    }

    /// What comes of them; `n_features` is what a full rank is.
    pub fn check(&self, measured: &[Measurement], n_features: usize) -> Vec<Checked> {
        let mut all = Vec::new();
        for limit in &self.0 {
            let of = measured.iter().filter(|own| {
                own.id == limit.id && (limit.axis.is_none() || own.axis == limit.axis)
            });
            let found: Vec<Checked> = of.map(|own| limit.of(own, n_features)).collect();
            if found.is_empty() {
                all.push(Checked {
                    figure: limit.id.clone(),
                    axis: limit.axis,
                    value: None,
                    limit: limit.number(n_features),
                    unit: String::new(),
                    at_least: at_least(&limit.id),
                    pass: false,
                    reason: Some("the calibration does not have it".to_owned()),
                });
            }
            all.extend(found);
        }
        all
    }
}

impl Limit {
    fn number(&self, n_features: usize) -> f64 {
        match self.bound {
            Bound::Number(number) | Bound::Load(number) => number,
            Bound::Full => n_features as f64,
        }
    }

    fn of(&self, own: &Measurement, n_features: usize) -> Checked {
        let (scale, unit): (Result<f64, String>, &str) = match (self.bound, own.full_scale) {
            (Bound::Number(_), Some(full)) => (Ok(100.0 / full), "% FS"),
            (Bound::Number(_), None) if own.unit.starts_with('N') => {
                (Err("no full scale".to_owned()), "% FS")
            }
            _ => (Ok(1.0), own.unit),
        };
        let value = own.value.clone().and_then(|value| Ok(value.abs() * scale?));
        let limit = self.number(n_features);
        let at_least = at_least(&self.id);
        let pass = value.as_ref().is_ok_and(|value| {
            if at_least {
                *value >= limit
            } else {
                *value <= limit
            }
        });
        Checked {
            figure: self.id.clone(),
            axis: own.axis,
            reason: value.as_ref().err().cloned(),
            value: value.ok(),
            limit,
            unit: unit.to_owned(),
            at_least,
            pass,
        }
    }
}

fn at_least(id: &str) -> bool {
    matches!(id, "coverage" | "rank")
}

fn bound(text: &str, id: &str) -> Option<Bound> {
    let text = text.trim();
    if text == "full" && id == "rank" {
        return Some(Bound::Full);
    }
    let (number, unit) = text
        .split_once(|letter: char| letter.is_whitespace() || letter == '%' || letter == 'N')
        .map_or((text, ""), |(number, _)| {
            (number, text[number.len()..].trim())
        });
    let number: f64 = number
        .trim()
        .parse()
        .ok()
        .filter(|own: &f64| own.is_finite())?;
    match unit {
        "" | "%" | "% FS" => Some(Bound::Number(number)),
        "N" | "N·m" | "Nm" | "N-m" => Some(Bound::Load(number)),
        _ => None,
    }
}

fn known_ids() -> Vec<String> {
    let quantities = Quantity::all(&Axis::ALL)
        .into_iter()
        .map(|own| own.definition().id);
    let steps = StepQuantity::ALL
        .into_iter()
        .map(|own| step_id(own).to_owned());
    OWN.into_iter()
        .map(str::to_owned)
        .chain(quantities)
        .chain(steps)
        .collect()
}

/// A verdict: whether everything passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Everything does.
    Pass,
    /// Something does not.
    Fail,
    /// Nothing was limited.
    None,
}

impl Verdict {
    /// Of what came of all limits.
    pub fn of(checked: &[Checked]) -> Self {
        match checked {
            [] => Self::None,
            all if all.iter().all(|own| own.pass) => Self::Pass,
            _ => Self::Fail,
        }
    }

    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::None => "no limits",
        }
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured() -> Vec<Measurement> {
        let one = |id: &str, axis, value: Result<f64, &str>, unit, full_scale| Measurement {
            id: id.to_owned(),
            axis,
            value: value.map_err(str::to_owned),
            unit,
            full_scale,
        };
        vec![
            one("U", Some(Axis::Fx), Ok(2.0), "N", Some(200.0)),
            one("U", Some(Axis::Mz), Ok(0.1), "N·m", Some(5.0)),
            one(
                "hysteresis",
                Some(Axis::Fx),
                Err("no cycle"),
                "N",
                Some(200.0),
            ),
            one("zero_return", Some(Axis::Fx), Ok(-3.0), "N", Some(200.0)),
            one("coverage", Some(Axis::Fx), Ok(96.0), "%", None),
            one("rank", None, Ok(12.0), "", None),
            one("condition", None, Ok(50.0), "", None),
        ]
    }

    fn verdicts(text: &str) -> Vec<(String, bool)> {
        let limits = Limits::from_toml(text).unwrap();
        limits
            .check(&measured(), 13)
            .iter()
            .map(|own| (own.told(), own.pass))
            .collect()
    }

    #[test]
    fn every_axis_keeps_its_limit_in_percent_or_in_its_unit() {
        let told = |text: &str, pass: bool| (text.to_owned(), pass);
        assert_eq!(
            verdicts("U = 1.0"),
            [
                told("U of Fx is 1.000 % FS, at most 1.000 % FS", true),
                told("U of Mz is 2.000 % FS, at most 1.000 % FS", false)
            ]
        );
        assert_eq!(
            verdicts("U = { Mz = \"0.1 N·m\" }"),
            [told("U of Mz is 0.1000 N·m, at most 0.1000 N·m", true)]
        );
        assert_eq!(
            verdicts("coverage = 97"),
            [told("coverage of Fx is 96.00 %, at least 97.00 %", false)]
        );
        assert!(
            !verdicts("zero_return = \"2.5 N\"")[0].1,
            "with its sign it would be below"
        );
        assert_eq!(
            verdicts("rank = \"full\"\ncondition = 100")
                .iter()
                .map(|own| own.1)
                .collect::<Vec<_>>(),
            [true, false]
        );
    }

    #[test]
    fn what_is_not_known_does_not_pass() {
        let [(told, pass)] = &verdicts("hysteresis = 5")[..] else {
            panic!()
        };
        assert!(!pass && told.contains("not known (no cycle)"), "{told}");
        assert!(!verdicts("v = 5")[0].1);
        assert_eq!(Verdict::of(&[]), Verdict::None);
    }

    #[test]
    fn a_misspelt_figure_is_refused_with_those_that_are_known() {
        let wrong = |text: &str| Limits::from_toml(text).unwrap_err();
        assert!(wrong("hysterese = 1").contains("hysterese is not one of U, coverage, condition"));
        assert!(wrong("U = \"small\"").contains("\"0.2 N\""));
        assert!(wrong("U = nan").contains("neither a number"));
        assert!(
            wrong("U = { Fq = 1 }").contains("data did not match")
                || wrong("U = { Fq = 1 }").contains("Fq")
        );
    }
}
