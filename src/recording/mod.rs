//! Measured data in SI units (s, N, N·m): recordings, their roles, and the simulated sensor. Units are converted where files
//! are read or written.

mod auxiliary;
mod axis;
mod channel;
pub(crate) mod frame;
mod framing;
mod full_scale;
pub(crate) mod gap;
pub(crate) mod identity;
pub(crate) mod kinetics;
mod left_out;
mod load_cases;
pub(crate) mod median;
mod programme;
#[expect(clippy::module_inception, reason = "this module defines the type of the same name")]
mod recording;
pub(crate) mod set;
mod shared;
pub mod simulated;
mod tare;
mod taring;
pub(crate) mod units;

pub(crate) use auxiliary::{AuxiliaryTable, places, span};
pub use axis::Axis;
pub use channel::Channel;
pub use frame::SensorFrame;
pub(crate) use full_scale::full_scale_of;
pub(crate) use identity::Identity;
pub use identity::Item;
pub use kinetics::Weight;
pub use left_out::ValidRange;
pub(crate) use left_out::{GaugeRange, Judged, LeftOut};
pub(crate) use load_cases::{SAME_LOAD_SHARE, load_cases};
pub(crate) use median::{median, white_noise};
pub(crate) use recording::{MOST_READINGS, RecordingError, load_ranges};
pub use recording::{Missing, Recording, Source};
pub(crate) use set::Layout;
pub use set::groups::Groups;
pub(crate) use set::groups::{GroupPattern, GroupedBy, LoneGroup, first_pieces};
pub(crate) use set::in_role;
pub use set::{Entry, RecordingSet, Role};
pub use tare::Tare;
