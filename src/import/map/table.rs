//! What the columns of one file are.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::formats::text::TextLayout;
use crate::import::map::role::ColumnRole;
use crate::shown::shown;

/// One file as a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableMap {
    /// Which files this is for.
    pub shape: Shape,
    /// How the text is cut into cells.
    #[serde(default)]
    pub text: TextLayout,
    /// Samples a second (Hz): times come from it where no column is the time, or where the time counts samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_rate_hz: Option<f64>,
    /// What is done about stamps that are out of order, or shared by several rows.
    #[serde(default, skip_serializing_if = "Stamps::is_as_written")]
    pub stamps: Stamps,
    /// What the columns are; those that are not listed are ignored.
    pub columns: Vec<ColumnRule>,
}

/// What is done about stamps that are out of order, or shared by several rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stamps {
    /// Nothing.
    #[default]
    AsWritten,
    /// Rows are sorted by their time.
    Sorted,
    /// Rows with one stamp are spread evenly until the next.
    Spread,
}

impl Stamps {
    /// Each with its name for people, and what it does.
    pub const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::AsWritten, "as written", "Where time goes back, a new recording starts"),
        (Self::Sorted, "sort rows by time", "For loggers that write some rows late"),
        (
            Self::Spread,
            "spread rows of one stamp evenly",
            "For stamps of whole seconds, or of a clock that is coarser than the samples",
        ),
    ];

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
    fn is_as_written(&self) -> bool {
        *self == Self::AsWritten
    }
}

/// What files must have in common to be read by one map.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// How many columns there are.
    pub columns: usize,
    /// The header's cells as written; none without a header.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
}

/// What one column is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnRule {
    /// Which column.
    pub column: ColumnKey,
    /// What it is.
    pub is: ColumnRole,
    /// What a gauge or an auxiliary channel is called; by default as in the header, or `S1`, `S2` and so on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its unit: of a load one that is understood; of a gauge a label; of an auxiliary channel `degC`, `K`, `degF`, `V`, `mV`, `%` or
    /// any label; of a time `s`, `ms`, `us`, `ns`, `samples`,
    /// `iso8601`, `d.m.y`, `m/d/y`, `d/m/y` or `h:m:s`. By default what the header says, then what the values look
    /// like (times) or SI (loads, positions); of an angle `rad` or `deg`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Values are multiplied with this; -1 turns the sign.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f64,
    /// Values are divided by this before they have their unit.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub counts_per_unit: f64,
    /// Values (as written) that mean that there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dropouts: Vec<f64>,
}

impl ColumnRule {
    /// A column that is this and has no unit, no other scale and no dropouts.
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

fn one() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_one(value: &f64) -> bool {
    *value == 1.0
}

/// Which column of a file: its number from 1 on, or its name as the header writes it. In a file it becomes an index, by
/// [`Header`](crate::import::map::Header).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
    /// Whether a column is this.
    pub fn has_role(&self, role: ColumnRole) -> bool {
        self.columns.iter().any(|rule| rule.is == role)
    }
}
