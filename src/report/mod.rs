//! Results as plain data without a window. A [`Table`] or a [`Figure`](figure::Figure) is defined once, and shown by the
//! window, the command line, the report, the clipboard and files.

pub mod figure;
pub(crate) mod table;
pub(crate) mod trace;

pub(crate) use table::{Align, Cell};
pub use table::{Column, Table, Value};
pub(crate) use trace::Shown;
pub use trace::Trace;
