//! What is shown, as plain data: a [`Table`] or a [`Figure`](figure::Figure) is described once, and window, command line,
//! report, clipboard and files draw from it.
//!
//! Guarantees: knows nothing of windows, command lines or files.

mod errors;
mod expected_error;
pub mod figure;
mod limits;
mod loops;
mod metrology;
mod sufficiency;
mod table;
mod trace;

pub use errors::errors;
pub(crate) use errors::factory_note;
#[cfg(feature = "gui")]
pub(crate) use expected_error::expected_error_column;
pub(crate) use expected_error::expected_error_table;
pub(crate) use limits::limits_table;
pub(crate) use loops::{LoopMeasures, LoopScale, drifts, loop_figures};
pub use metrology::crosstalk;
pub(crate) use metrology::{axis_figures, figure_records, overview};
#[cfg(feature = "gui")]
pub(crate) use sufficiency::pair_figure;
pub(crate) use sufficiency::sufficiency_tables;
pub(crate) use table::{Align, Cell};
pub use table::{Column, Table, Value};
pub(crate) use trace::{Shown, Trace};
