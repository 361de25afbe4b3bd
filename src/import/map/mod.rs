//! Column maps: the roles of a table's columns, chosen once by the user for all files of a kind.
//!
//! Guarantees: a [`ColumnMap`] holds everything that reading needs and nothing about a single file, so one map serves all
//! files of the same [`Shape`]. Names of columns and choices of the user become such a map, and only maps lead to recordings.

mod column_map;
mod error;
mod file;
mod header;
mod line_per_item;
mod role;
mod table;
mod weight;

pub use column_map::{ColumnMap, Join, JoinMethod, ReferenceFile};
pub(crate) use error::{MapError, MapFileError};
pub(crate) use header::{Header, KeyError};
pub use role::ColumnRole;
pub(crate) use role::{Attitude, PosePart};
pub use table::{ColumnKey, ColumnRule, Shape, Stamps, TableMap};
pub(crate) use weight::{Angles, Mount, WeightMap};
