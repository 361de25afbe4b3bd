//! How a table of text is written, as far as a person may have to say it.

use serde::{Deserialize, Serialize};

/// How the text of a table is cut into cells and numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TextLayout {
    /// What stands between two cells.
    pub delimiter: Delimiter,
    /// What stands between the whole part of a number and its decimals.
    pub decimal: Decimal,
    /// What stands before each three digits of large numbers. Absent: nothing, but for numbers that can mean nothing else, such as
    /// `1,234.5` and `1'234`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thousands: Option<Thousands>,
    /// How many lines at the start are no part of the table. Blank lines and comments (`#`) need not be counted.
    pub skip_rows: usize,
    /// Whether the next line names the columns.
    pub header: bool,
    /// Whether the line after the header holds units.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub units_row: bool,
    /// A preamble that says more than nothing; `skip_rows` does not matter with one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preamble: Option<Preamble>,
    /// Of a file that holds several tables, which are read: topics, sheets, groups, structs. Without any one is chosen,
    /// and that is told.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<String>,
}

/// What stands between two cells.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, strum::IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Delimiter {
    #[default]
    Comma,
    Semicolon,
    Tab,
    /// Any run of blanks and tabs.
    Spaces,
}

impl Delimiter {
    /// All of them, the ones that say most first.
    pub const ALL: [Self; 4] = [Self::Tab, Self::Semicolon, Self::Comma, Self::Spaces];

    /// As in the file of a map.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// What stands between the whole part of a number and its decimals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Decimal {
    /// A point. Where a comma cannot stand between cells, a single one is read as a decimal point too, and told.
    #[default]
    Point,
    /// A comma only: `1.5` is then no number, since it may mean fifteen hundred.
    Comma,
}

/// A preamble that is understood: units, counts per unit and sample rate are read from it in each file anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preamble {
    /// What the demonstration program of ATI's Net F/T writes.
    AtiNetFt,
}

/// Separator of thousands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, strum::IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Thousands {
    /// As in `1,234.5`.
    Comma,
    /// As in `1.234,5`.
    Point,
    /// As in `1'234.5`, straight or typographic.
    Apostrophe,
    /// As in `1 234,5`: a blank, also one that does not break or is narrow.
    Space,
}

impl Thousands {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Comma, Self::Point, Self::Apostrophe, Self::Space];

    /// Returns the name in the file of a map.
    pub fn name(self) -> &'static str {
        self.into()
    }

    pub(super) fn is(self, letter: char) -> bool {
        match self {
            Self::Comma => letter == ',',
            Self::Point => letter == '.',
            Self::Apostrophe => matches!(letter, '\'' | '’'),
            Self::Space => matches!(letter, ' ' | '\u{a0}' | '\u{2009}' | '\u{202f}'),
        }
    }
}
