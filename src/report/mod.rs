//! Results as plain data. A [`Table`] or a [`Figure`](figure::Figure) is defined once, and shown by window, command line,
//! report, clipboard and files.

pub mod figure;
pub(crate) mod table;
pub(crate) mod trace;

pub(crate) use table::{Align, Cell};
pub use table::{Column, Table, Value};
pub(crate) use trace::Shown;
pub use trace::Trace;
