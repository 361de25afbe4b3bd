//! Delimited text, as loggers and spreadsheets write it.
//!
//! Guarantees: a file of any size is read in blocks of whole lines, never as a whole. For each value, the number of its line
//! in the file is known.
//!
//! | module | contents |
//! |---|---|
//! | `file` | text file that is inspected and read in several blocks at a time |
//! | `encoding`, `blocks` | conversion to UTF-8, and blocks of whole lines |
//! | `arriving` | lines of a text that is still being written |
//! | `cells`, `times` | cells, numbers, dates |
//! | `written`, `layout` | layout of a table, and its position in the file |
//! | `labels` | lines with a label before each number |
//! | `reshaped` | tables with one row for each channel, or with the channels of a sample in successive rows |
//! | `serial_monitor` | lines that start with the time of day and an arrow |
//! | `ati` | preamble written by ATI's program |
//! | `lvm` | LabVIEW's segments of rows, each with a header |

mod arriving;
pub(crate) mod ati;
mod blocks;
pub(crate) mod cells;
mod encoding;
mod file;
mod labels;
mod layout;
mod lvm;
mod reshaped;
mod serial_monitor;
pub(crate) mod times;
mod written;

pub(crate) use arriving::ArrivingLines;
pub(super) use blocks::Blocks;
pub(crate) use cells::{delimiter_of_header, lines};
pub(crate) use encoding::Encoding;
pub(super) use file::FORMAT;
pub(crate) use file::TextFile;
pub(crate) use labels::{NUMBER, labelled, numbers_in};
pub(crate) use layout::{Head, is_header, is_units_row, words};
#[cfg(test)]
pub(crate) use layout::{detect, locate};
pub(super) use lvm::FORMAT as LABVIEW;
pub(crate) use serial_monitor::stamped;
pub(crate) use written::{Decimal, Delimiter, Preamble, TextLayout, Thousands};
