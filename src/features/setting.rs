//! A number that a person chooses, described once.
//!
//! Guarantees: the window's fields and hover texts, `--help`, the messages of what is out of range, the names in exports and
//! the tables of the guide are printed from a [`Setting`]; none of them says a default, a unit or a range of its own.

use std::fmt;

/// More values than this are shown as the first and the last.
const MOST_NAMED: usize = 12;

/// What a number is counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// As it stands behind a number; empty for a mere number.
    pub symbol: &'static str,
    /// In words.
    pub words: &'static str,
    /// What stands for a number in `--help`, and for a list of them.
    pub placeholders: [&'static str; 2],
}

impl Unit {
    /// A mere number.
    pub const NONE: Self = Self::new("", "", ["N", "N,…"]);
    /// Seconds.
    pub const SECONDS: Self = Self::new("s", "seconds", ["SECONDS", "SECONDS,…"]);
    /// Newtons.
    pub const NEWTONS: Self = Self::new("N", "newtons", ["F", "F,…"]);
    /// Standard deviations of each gauge over the training recordings.
    pub const SIGMA: Self =
        Self::new("σ", "standard deviations of the gauge", ["SIGMA", "SIGMA,…"]);

    /// A unit.
    pub const fn new(
        symbol: &'static str,
        words: &'static str,
        placeholders: [&'static str; 2],
    ) -> Self {
        Self { symbol, words, placeholders }
    }
}

/// One of a few values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// As files have it.
    pub value: u8,
    /// What people call it.
    pub label: &'static str,
    /// What it does.
    pub explanation: &'static str,
}

/// Which values are allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Above zero.
    Positive,
    /// From zero up.
    NotNegative,
    /// From zero up, or found by cross-validation.
    NotNegativeOrAuto,
    /// Above zero, being a time ago.
    Past,
    /// Above zero, and at most this.
    UpTo(f64),
    /// Whole numbers between two, both included.
    Whole(u64, u64),
    /// A few whole numbers; the first stands for none.
    OneOf(&'static [Choice]),
    /// On (1) or off (0).
    Switch,
}

impl Range {
    /// Returns true if the value is allowed.
    pub(crate) fn contains(self, value: f64) -> bool {
        match self {
            Self::Positive | Self::Past => value > 0.0 && value.is_finite(),
            Self::NotNegative | Self::NotNegativeOrAuto => value >= 0.0 && value.is_finite(),
            Self::UpTo(max) => value > 0.0 && value <= max,
            Self::Whole(min, max) => (min as f64..=max as f64).contains(&value),
            Self::OneOf(choices) => choices.iter().any(|own| f64::from(own.value) == value),
            Self::Switch => value == 0.0 || value == 1.0,
        }
    }
}

impl Range {
    /// The ends of a field in which a value is typed; it may still refuse what lies on one of them.
    pub fn ends(self) -> (f64, f64) {
        match self {
            Self::Positive | Self::Past | Self::NotNegative | Self::NotNegativeOrAuto => {
                (0.0, f64::INFINITY)
            }
            Self::UpTo(max) => (0.0, max),
            Self::Whole(min, max) => (min as f64, max as f64),
            Self::OneOf(choices) => {
                let ends = [choices.first(), choices.last()];
                let [min, max] = ends.map(|end| end.map_or(0.0, |end| f64::from(end.value)));
                (min, max)
            }
            Self::Switch => (0.0, 1.0),
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Positive => write!(f, "a number above zero"),
            Self::Past => write!(f, "a number above zero, as no robot can see ahead"),
            Self::NotNegative => write!(f, "a number from zero up"),
            Self::NotNegativeOrAuto => write!(f, "a number from zero up, auto, or by-block"),
            Self::UpTo(max) => write!(f, "a number above zero and at most {max}"),
            Self::Whole(0, u64::MAX) => write!(f, "a whole number from zero up"),
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

/// A value that is not allowed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{what} is {value}; it must be {allowed}")]
pub struct OutOfRange {
    /// What the value is of.
    pub what: &'static str,
    /// The value.
    pub value: f64,
    /// What it may be.
    pub allowed: Range,
}

/// What there is to say of a number, or of a list of such numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Its key in the files of calibrations and sessions, and in exports.
    pub key: &'static str,
    /// Its option on the command line, without the dashes; empty where it has none.
    pub option: &'static str,
    /// Its title.
    pub label: &'static str,
    /// What messages call a value of it.
    pub what: &'static str,
    /// What it is counted in.
    pub unit: Unit,
    /// What it begins with; several numbers for a list.
    pub default: &'static [f64],
    /// Which values are allowed.
    pub range: Range,
    /// How much it changes when its field in the window is dragged by a point.
    pub step: f64,
    /// What it does.
    pub explanation: &'static str,
    /// Where it comes from: the paper's equation, section or reference; empty where it is the program's own.
    pub source: &'static str,
}

impl Setting {
    /// What it does, and where it comes from.
    pub fn help(&self) -> String {
        match self.source {
            "" => self.explanation.to_owned(),
            source => format!("{} ({source})", self.explanation),
        }
    }

    /// The default of one number.
    pub const fn number(&self) -> f64 {
        self.default[0]
    }

    /// Checks a value.
    ///
    /// # Errors
    /// [`OutOfRange`] if it is not allowed.
    pub fn check(&self, value: f64) -> Result<(), OutOfRange> {
        if self.range.contains(value) {
            Ok(())
        } else {
            Err(OutOfRange { what: self.what, value, allowed: self.range })
        }
    }

    /// The allowed values where there are only a few.
    pub fn choices(&self) -> Option<&'static [Choice]> {
        match self.range {
            Range::OneOf(choices) => Some(choices),
            _ => None,
        }
    }

    /// Values with their unit, in words; "none" without any.
    pub fn in_words(&self, values: &[f64]) -> String {
        if let Some(choices) = self.choices() {
            let of = |choice: &&Choice| values.first() == Some(&f64::from(choice.value));
            return match choices.iter().find(of) {
                Some(choice) => choice.label.to_owned(),
                None => "none".to_owned(),
            };
        }
        match values {
            [] => "none".to_owned(),
            [1.0] if self.range == Range::Switch => "on".to_owned(),
            [_] if self.range == Range::Switch => "off".to_owned(),
            [first, .., last] if values.len() > MOST_NAMED => {
                let n = values.len();
                format!("{first} … {last} {} ({n} values)", self.unit.symbol).replace("  ", " ")
            }
            _ if self.unit.symbol.is_empty() => listed(values, ", "),
            _ => format!("{} {}", listed(values, ", "), self.unit.symbol),
        }
    }
}

/// Numbers in a row.
pub fn listed(values: &[f64], between: &str) -> String {
    let texts: Vec<String> = values.iter().map(f64::to_string).collect();
    texts.join(between)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_what_they_say() {
        const FEW: &[Choice] = &[
            Choice { value: 1, label: "none", explanation: "" },
            Choice { value: 2, label: "two", explanation: "" },
        ];
        for (range, inside, outside, said) in [
            (Range::Positive, 1e-9, 0.0, "a number above zero"),
            (Range::Past, 0.004, -0.004, "a number above zero, as no robot can see ahead"),
            (Range::NotNegative, 0.0, -1e-9, "a number from zero up"),
            (Range::UpTo(1.0), 1.0, 1.1, "a number above zero and at most 1"),
            (Range::Whole(1, 9), 9.0, 0.0, "a whole number from 1 to 9"),
            (Range::OneOf(FEW), 2.0, 3.0, "1 (none) or 2"),
            (Range::Switch, 1.0, 0.5, "on or off"),
        ] {
            assert!(range.contains(inside) && !range.contains(outside));
            assert!(!range.contains(f64::NAN) && !range.contains(f64::INFINITY));
            assert_eq!(range.to_string(), said);
        }
    }
}
