//! What the columns of a table are: the choice that a person makes once for a kind of file, and keeps.
//!
//! Guarantees: a [`ColumnMap`] says everything that reading needs and nothing about one single file, so that one map
//! serves every file of the same [`Shape`]. Header rules and people's choices both end here: there is one way from a
//! map to recordings.

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
pub(crate) use role::PosePart;
pub use table::{ColumnKey, ColumnRule, Shape, Stamps, TableMap};
pub(crate) use weight::{Angles, Attitude, Mount, WeightMap};
