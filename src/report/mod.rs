//! What is shown, as plain data: a [`Table`] or a [`Figure`](figure::Figure) is described once, and window, command line,
//! report, clipboard and files draw from it.
//!
//! Guarantees: knows nothing of windows, command lines or files.

pub mod figure;
pub(crate) mod table;

pub(crate) use table::{Align, Cell};
pub use table::{Column, Table, Value};
