//! Layout of a text table, as far as a user may have to give it in a column map.

use serde::{Deserialize, Serialize};

/// Rules by which the text of a table is divided into cells and numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TextLayout {
    pub delimiter: Delimiter,
    pub decimal: Decimal,
    /// Separator of thousands in numbers. If absent, separators are accepted only in numbers that can be read in one way,
    /// such as `1,234.5` and `1'234`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thousands: Option<Thousands>,
    /// Number of lines before the table, not counting blank lines and comments (`#`).
    pub skip_rows: usize,
    /// True if the first line of the table names the columns.
    pub header: bool,
    /// True if the line after the header holds units.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub units_row: bool,
    /// Kind of the lines before the table, if the program uses their values. If given, `skip_rows` is not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preamble: Option<Preamble>,
    /// Names of the tables to read from a file with several tables: topics, sheets, groups, structs. If empty, the program
    /// chooses, and reports its choice.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<String>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, strum::IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Delimiter {
    #[default]
    Comma,
    Semicolon,
    Tab,
    /// Any run of blanks and tabs between cells.
    Spaces,
}

impl Delimiter {
    pub const ALL: [Self; 4] = [Self::Tab, Self::Semicolon, Self::Comma, Self::Spaces];

    pub fn name(self) -> &'static str {
        self.into()
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Decimal {
    /// Decimal point. A single comma is read as a decimal mark too, and reported, unless commas separate cells.
    #[default]
    Point,
    /// Decimal comma only. `1.5` is then no number, because the point may separate thousands.
    Comma,
}

/// Kind of header lines before a table. Units, counts per unit and sample rate are read from the header of each file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preamble {
    /// Preamble that the demonstration program of ATI's Net F/T writes.
    AtiNetFt,
}

/// Separator of thousands in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, strum::IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Thousands {
    /// Comma, as in `1,234.5`.
    Comma,
    /// Point, as in `1.234,5`.
    Point,
    /// Apostrophe, straight or typographic, as in `1'234.5`.
    Apostrophe,
    /// Blank, also a non-breaking or narrow one, as in `1 234,5`.
    Space,
}

impl Thousands {
    pub const ALL: [Self; 4] = [Self::Comma, Self::Point, Self::Apostrophe, Self::Space];

    pub fn name(self) -> &'static str {
        self.into()
    }

    pub fn is(self, letter: char) -> bool {
        match self {
            Self::Comma => letter == ',',
            Self::Point => letter == '.',
            Self::Apostrophe => matches!(letter, '\'' | '’'),
            Self::Space => matches!(letter, ' ' | '\u{a0}' | '\u{2009}' | '\u{202f}'),
        }
    }
}
