//! Measured data: recordings, their roles, and the simulated sensor.
//!
//! All values are in SI units (s, N, N·m). Units are converted where files are read or written.

mod auxiliary;
mod axis;
mod date;
mod full_scale;
pub mod gap;
mod groups;
pub mod identity;
pub mod kinetics;
mod left_out;
mod load_cases;
pub(crate) mod median;
#[expect(clippy::module_inception, reason = "the main type has the name of the module")]
mod recording;
pub mod set;
mod shared;
pub mod simulated;
mod tare;
mod taring;
pub mod units;

pub use auxiliary::AuxiliaryTable;
pub(crate) use auxiliary::span;
pub use axis::Axis;
pub use date::{DateSource, Dated, Day};
pub use full_scale::full_scale_of;
pub use groups::{GroupPattern, GroupedBy, Groups, LoneGroup, UnusedGroups};
pub use identity::{Identity, Item};
pub use left_out::{GaugeRange, Judged, LeftOut, ValidRange};
pub(crate) use load_cases::{SAME_LOAD_SHARE, load_cases};
pub(crate) use median::median;
pub(crate) use recording::load_ranges;
pub use recording::{Recording, Sampling, Source};
pub(crate) use set::Layout;
pub(crate) use set::in_role;
pub use set::{Entry, RecordingSet, Role};
pub use tare::Tare;
pub(crate) use taring::TareError;
