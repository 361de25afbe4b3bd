//! Description of one file in a column map: the layout of the text, and the role and unit of each column.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{formats::text::TextLayout, import::map::role::ColumnRole, shown::shown};

/// Description of one file as a table with columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableMap {
    /// Number and names of the columns that a file must have so that the map can be used for it.
    pub shape: Shape,
    /// Layout of the text, such as the delimiter of the cells.
    #[serde(default)]
    pub text: TextLayout,
    /// Sample rate (Hz). It is used if no column gives the time, or if the time column counts samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_rate_hz: Option<f64>,
    /// Treatment of time stamps that are out of order, or that several rows share.
    #[serde(default, skip_serializing_if = "is_default")]
    pub stamps: Stamps,
    /// Role of the columns that are not listed.
    #[serde(default)]
    pub rest: Rest,
    /// Rules of the columns, which give each column its role.
    pub columns: Vec<ColumnRule>,
}

/// Role of the columns that a map does not list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rest {
    /// They are ignored.
    #[default]
    Ignored,
    /// They have the role that their names, units and values propose.
    Proposed,
}

/// Treatment of time stamps that are out of order, or that several rows share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stamps {
    /// Time stamps stay as they are.
    #[default]
    AsWritten,
    /// Rows are sorted by time.
    Sorted,
    /// Rows with the same time stamp are spread evenly up to the next time stamp.
    Spread,
}

impl Stamps {
    /// All treatments of time stamps, each with its label in the window and an explanation.
    pub const ALL: [(Self, &'static str, &'static str); 3] = [
        (
            Self::AsWritten,
            "as written",
            "Time stamps are not changed. Where the time goes back, a new recording starts",
        ),
        (
            Self::Sorted,
            "sort rows by time",
            "For loggers that write some rows too late, so that time stamps are out of order",
        ),
        (
            Self::Spread,
            "spread rows with the same time stamp",
            "For time stamps that several rows share, such as whole seconds. The rows are spread evenly up to the next stamp",
        ),
    ];
}

/// Number and names of the columns, which all files for one column map have in common.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// Number of columns.
    pub columns: usize,
    /// Names of the columns, exactly as written in the header; empty for files without a header.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
}

/// Rule of a column map for one column: its role, name, unit and scale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnRule {
    /// Name or number by which the map lists the column.
    pub column: ColumnKey,
    /// Role of the column.
    pub is: ColumnRole,
    /// Name of the channel, if the column is a gauge or an auxiliary channel. The default is the name in the header, or `S1`,
    /// `S2` and so on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Unit of the values in the column. The default is the unit in the header. If the header has none either, the unit of
    /// times is derived from the values, and loads and positions are taken to be in SI units.
    ///
    /// A gauge or an auxiliary channel may have any unit. The units `degC`, `K`, `degF`, `V`, `mV` and `%` are converted. An
    /// angle is in `rad` or `deg`. A time is in `s`, `ms`, `us`, `ns`, `samples`, `iso8601`, `d.m.y`, `m/d/y`, `d/m/y` or
    /// `h:m:s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Factor by which the values are multiplied; -1 reverses the sign.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f64,
    /// Number of counts of the analogue-to-digital converter for one unit of the quantity. The values are divided by this
    /// number.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub counts_per_unit: f64,
    /// Numbers that stand for a missing value in this column.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dropouts: Vec<f64>,
}

impl ColumnRule {
    /// Creates a rule that gives a column a role. It sets no unit, no name and no marks of missing values, and its factors
    /// are 1.
    pub fn new(column: ColumnKey, is: ColumnRole) -> Self {
        Self {
            column,
            is,
            name: None,
            unit: None,
            scale: 1.0,
            counts_per_unit: 1.0,
            dropouts: Vec::new(),
        }
    }
}

pub fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn one() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_one(value: &f64) -> bool {
    *value == 1.0
}

/// Number of a column, counted from 1, or name of a column. [`Header`](crate::import::map::Header) finds the column in a
/// file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "the names are the documentation")]
pub enum ColumnKey {
    Number(usize),
    Name(String),
}

impl fmt::Display for ColumnKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Name(name) => write!(f, "\"{}\"", shown(name)),
        }
    }
}

impl TableMap {
    /// Returns true if one of the columns has this role.
    pub fn has_role(&self, role: ColumnRole) -> bool {
        self.columns.iter().any(|rule| rule.is == role)
    }
}
