//! What is shown, as plain data: a [`Table`] or a [`Figure`](figure::Figure) is described once, and window, command line,
//! report, clipboard and files draw from it.
//!
//! Guarantees: knows nothing of windows, command lines or files.

mod errors;
pub mod figure;
mod loops;
mod metrology;
mod table;
mod trace;

pub use errors::{errors, factory_note};
pub use loops::{LoopScale, drifts, loop_figures};
pub use metrology::{axis_figures, crosstalk, figure_records, overview};
pub use table::{Align, Cell, Column, Table, Value};
pub use trace::{Shown, Trace};
