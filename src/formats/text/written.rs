//! Layout of a text table, as far as a user may have to specify it.

use serde::{Deserialize, Serialize};

/// Division of the text of a table into cells and numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TextLayout {
    pub delimiter: Delimiter,
    pub decimal: Decimal,
    /// Separator of thousands. If absent, only numbers that can be read in one way, such as `1,234.5` and `1'234`, are
    /// grouped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thousands: Option<Thousands>,
    /// Number of lines before the table, not counting blank lines and comments (`#`).
    pub skip_rows: usize,
    /// True if the first line of the table names the columns.
    pub header: bool,
    /// True if the line after the header holds units.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub units_row: bool,
    /// Preamble whose values the program understands. If given, `skip_rows` is not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preamble: Option<Preamble>,
    /// Names of the tables to read: topics, sheets, groups, structs. If empty, the program chooses, and reports its choice.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<String>,
}

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
    pub const ALL: [Self; 4] = [Self::Tab, Self::Semicolon, Self::Comma, Self::Spaces];

    pub fn name(self) -> &'static str {
        self.into()
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Decimal {
    /// Point. A single comma is read as a decimal point too, and reported, unless the comma separates cells.
    #[default]
    Point,
    /// Comma only. `1.5` is then no number, because the point may separate thousands.
    Comma,
}

/// Preamble whose units, counts per unit and sample rate are read anew from each file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preamble {
    /// Preamble that the demonstration program of ATI's Net F/T writes.
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
    /// As in `1 234,5`: a blank, also a non-breaking or narrow one.
    Space,
}

impl Thousands {
    pub const ALL: [Self; 4] = [Self::Comma, Self::Point, Self::Apostrophe, Self::Space];

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
