//! Descriptions of numeric settings, such as thresholds and time constants. Each [`Setting`] gives the texts for fields and
//! hover texts of the window, `--help`, error messages, exports and tables of the guide.

use std::fmt;

/// Maximum number of values of a list that is shown in full. Of a longer list, only the first and the last value are shown.
const MOST_NAMED: usize = 12;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// Symbol of the unit, shown after a number; empty without unit.
    pub symbol: &'static str,
    pub words: &'static str,
    /// Placeholders in `--help` for one number and for a list of numbers, such as `SECONDS` and `SECONDS,…`.
    pub placeholders: [&'static str; 2],
}

impl Unit {
    pub const NONE: Self = Self::new("", "", ["N", "N,…"]);
    pub const SECONDS: Self = Self::new("s", "seconds", ["SECONDS", "SECONDS,…"]);
    pub const NEWTONS: Self = Self::new("N", "newtons", ["F", "F,…"]);
    /// Unit σ: the standard deviation of each gauge over the training recordings.
    pub const SIGMA: Self =
        Self::new("σ", "standard deviations of the gauge", ["SIGMA", "SIGMA,…"]);

    pub const fn new(
        symbol: &'static str,
        words: &'static str,
        placeholders: [&'static str; 2],
    ) -> Self {
        Self { symbol, words, placeholders }
    }
}

/// Named value of a setting that has only a few values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    pub value: u8,
    pub label: &'static str,
    pub explanation: &'static str,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    Positive,
    NotNegative,
    /// A number that is zero or greater, or a choice by cross-validation.
    NotNegativeOrAuto,
    /// Length of time before the present (s), greater than zero.
    Past,
    /// A number greater than zero and at most this value.
    UpTo(f64),
    /// Whole numbers from the first to the second value, both included.
    Whole(u64, u64),
    /// One of a few named whole numbers. The first of them switches the feature block off.
    OneOf(&'static [Choice]),
    /// On (1) or off (0).
    Switch,
}

impl Range {
    pub(crate) fn contains(self, value: f64) -> bool {
        match self {
            Self::Positive | Self::Past => value > 0.0 && value.is_finite(),
            Self::NotNegative | Self::NotNegativeOrAuto => value >= 0.0 && value.is_finite(),
            Self::UpTo(max) => value > 0.0 && value <= max,
            Self::Whole(min, max) => (min as f64..=max as f64).contains(&value),
            Self::OneOf(choices) => choices.iter().any(|choice| f64::from(choice.value) == value),
            Self::Switch => value == 0.0 || value == 1.0,
        }
    }

    /// Returns the lower and the upper limit of the input field in the window. [`Self::contains`] may refuse a value at a
    /// limit.
    pub fn ends(self) -> (f64, f64) {
        match self {
            Self::Positive | Self::Past | Self::NotNegative | Self::NotNegativeOrAuto => {
                (0.0, f64::INFINITY)
            }
            Self::UpTo(max) => (0.0, max),
            Self::Whole(min, max) => (min as f64, max as f64),
            Self::OneOf(choices) => {
                (choices[0].value.into(), choices[choices.len() - 1].value.into())
            }
            Self::Switch => (0.0, 1.0),
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Positive => write!(f, "a number above zero"),
            Self::Past => write!(f, "a number above zero (future samples are unknown)"),
            Self::NotNegative => write!(f, "zero or a number above zero"),
            Self::NotNegativeOrAuto => write!(f, "zero, a number above zero, auto, or by-block"),
            Self::UpTo(max) => write!(f, "a number above zero and at most {max}"),
            Self::Whole(0, u64::MAX) => write!(f, "zero or a positive whole number"),
            Self::Whole(min, max) => write!(f, "a whole number from {min} to {max}"),
            Self::OneOf(choices) => {
                for (at, Choice { value, label, .. }) in choices.iter().enumerate() {
                    match at {
                        0 => write!(f, "{value} ({label})")?,
                        _ if at + 1 == choices.len() => write!(f, " or {value}")?,
                        _ => write!(f, ", {value}")?,
                    }
                }
                Ok(())
            }
            Self::Switch => write!(f, "on or off"),
        }
    }
}

/// Maximum number of columns of a design matrix. The matrix products over all samples would not fit into memory for more
/// columns.
pub const MAX_COLUMNS: usize = 640;

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FeatureError {
    #[error("{what} is {value}; it must be {allowed}")]
    OutOfRange { what: &'static str, value: f64, allowed: Range },
    #[error(
        "the features of {gauges} gauges have {columns} columns, but at most {MAX_COLUMNS} are possible; use fewer features, \
         thresholds or radii"
    )]
    Columns { columns: usize, gauges: usize },
    #[error("auxiliary channel {name}: {what} is {value}, which is not valid")]
    Channel { name: String, what: &'static str, value: f64 },
}

/// Description of a numeric setting, whose value is one number or a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Key of the setting in calibration files, session files and exports.
    pub key: &'static str,
    /// Name of the option on the command line, without the dashes; empty if there is none.
    pub option: &'static str,
    pub label: &'static str,
    /// Name of the setting in messages.
    pub what: &'static str,
    pub unit: Unit,
    /// Default value of the setting; several values for a list.
    pub default: &'static [f64],
    pub range: Range,
    /// Change of the value for each point (pixel) by which the user drags the field in the window.
    pub step: f64,
    /// Explanation of the setting in hover texts and in `--help`.
    pub explanation: &'static str,
    /// Equation, section or reference in the paper of Koike et al. (2019), or another origin of the setting; empty without
    /// one.
    pub source: &'static str,
}

impl Setting {
    /// Returns the explanation, followed by its source in brackets.
    pub fn help(&self) -> String {
        match self.source {
            "" => self.explanation.to_owned(),
            source => format!("{} ({source})", self.explanation),
        }
    }

    pub const fn number(&self) -> f64 {
        self.default[0]
    }

    /// Returns [`FeatureError::OutOfRange`] if the setting does not allow this value.
    pub fn check(&self, value: f64) -> Result<(), FeatureError> {
        if self.range.contains(value) {
            Ok(())
        } else {
            Err(FeatureError::OutOfRange { what: self.what, value, allowed: self.range })
        }
    }

    /// Returns the named values from which the user chooses; `None` if the setting can have any number.
    pub fn choices(&self) -> Option<&'static [Choice]> {
        match self.range {
            Range::OneOf(choices) => Some(choices),
            _ => None,
        }
    }

    /// Returns values of the setting as text with their unit, or "none" for an empty list.
    pub fn in_words(&self, values: &[f64]) -> String {
        if let Some(choices) = self.choices() {
            let of = |choice: &&Choice| values.first() == Some(&f64::from(choice.value));
            return choices.iter().find(of).map_or("none", |choice| choice.label).to_owned();
        }
        match values {
            [] => "none".to_owned(),
            [value] if self.range == Range::Switch => {
                if *value > 0.0 { "on" } else { "off" }.to_owned()
            }
            [first, .., last] if values.len() > MOST_NAMED => {
                let n = values.len();
                format!("{first} … {last} {} ({n} values)", self.unit.symbol).replace("  ", " ")
            }
            _ if self.unit.symbol.is_empty() => listed(values, ", "),
            _ => format!("{} {}", listed(values, ", "), self.unit.symbol),
        }
    }
}

/// Returns numbers as text, joined by `between`.
pub fn listed(values: &[f64], between: &str) -> String {
    let texts: Vec<String> = values.iter().map(f64::to_string).collect();
    texts.join(between)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_contain_the_values_of_their_description() {
        const FEW: &[Choice] = &[
            Choice { value: 1, label: "none", explanation: "" },
            Choice { value: 2, label: "two", explanation: "" },
        ];
        for (range, inside, outside, words) in [
            (Range::Positive, 1e-9, 0.0, "a number above zero"),
            (Range::Past, 0.004, -0.004, "a number above zero (future samples are unknown)"),
            (Range::NotNegative, 0.0, -1e-9, "zero or a number above zero"),
            (Range::UpTo(1.0), 1.0, 1.1, "a number above zero and at most 1"),
            (Range::Whole(1, 9), 9.0, 0.0, "a whole number from 1 to 9"),
            (Range::OneOf(FEW), 2.0, 3.0, "1 (none) or 2"),
            (Range::Switch, 1.0, 0.5, "on or off"),
        ] {
            assert!(range.contains(inside) && !range.contains(outside));
            assert!(!range.contains(f64::NAN) && !range.contains(f64::INFINITY));
            assert_eq!(range.to_string(), words);
        }
    }
}
