//! What was measured: recordings, the roles they play, and where they come from.
//!
//! Everything in here is SI (s, N, N·m); units are converted where files are read or written.

mod arrays;
mod axis;
pub mod clock_offset;
mod column_name;
pub mod columns;
pub mod delimited;
pub mod join;
pub mod kinetics;
pub mod pose;
#[expect(
    clippy::module_inception,
    reason = "the room's main thing has the room's name"
)]
mod recording;
pub mod set;
pub mod simulated;
mod tare;
pub mod units;
pub mod write_csv;

pub use arrays::ArraysError;
pub use axis::Axis;
pub use recording::{Recording, RecordingError, Source};
pub use set::{Entry, Layout, LayoutError, RecordingSet, Role};
pub use tare::{Tare, TareError};
