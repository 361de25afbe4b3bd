//! Column maps: the roles of a table's columns (time, gauge, axis of the reference load and so on). The user chooses them
//! once for all files with the same columns.
//!
//! Guarantees: a [`ColumnMap`] holds everything that is needed to read a file, and nothing about a single file. So one map
//! can be used for all files of the same [`Shape`]. Every file is read by a map. If the user gives none, a map is proposed
//! from names, units and values of the columns.

mod column_map;
mod error;
mod file;
mod header;
mod role;
mod table;
mod typed;
mod weight;

pub use column_map::{ColumnMap, Join, JoinMethod, ReferenceFile};
pub(crate) use error::{MapError, MapFileError};
pub(crate) use header::{Header, KeyError};
pub use role::ColumnRole;
pub(crate) use role::{Attitude, PosePart};
pub use table::{ColumnKey, ColumnRule, Rest, Shape, Stamps, TableMap};
pub(crate) use weight::{Angles, WeightMap};
