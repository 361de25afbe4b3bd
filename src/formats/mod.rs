//! Reads files of numbers as named columns, and writes them. Each format has one source file.
//!
//! Guarantees: the first bytes of a file, never its name, select its format. Memory grows with the actual contents of a file,
//! not with the size that it declares. If a crate that reads a format panics, the user gets an error about the file.
//!
//! A new format is one source file with a [`Format`] and one line in [`FORMATS`]. File dialogs, `--help`, the import page
//! and the messages are made from this list.
//!
//! | module | contents |
//! |---|---|
//! | [`text`], [`csv`] | delimited text: read as loggers (also LabVIEW) write it, written as spreadsheets read it |
//! | `npy`, `npz` | NumPy arrays and records, alone and in an archive |
//! | `mat` | MATLAB files of versions 4 and 5 (`save` without `-v7.3`) |
//! | `hdf5` | groups of arrays and tables of records, also MATLAB files of version 7.3; feature `hdf5` |
//! | `parquet` | columns of numbers; feature `parquet` |
//! | `mcap` | topics of a ROS 2 recording; feature `mcap` |
//! | `xlsx` | sheets of a workbook (`.xlsx`, `.xls`, `.ods`); feature `xlsx` |
//! | `json_lines` | lines of JSON, one object per sample |
//! | `parts` | choice among several tables of a file |
//! | `opened`, `columns` | common interface to text and columns: layout, header and rows |
//! | `number` | numbers as binary files store them |
//! | `arrays`, `column_name` | arrays as named columns, and the kind of a column by its name |

mod arrays;
pub(crate) mod column_name;
mod columns;
pub mod csv;
mod error;
mod format;
mod hdf5;
mod json_lines;
pub(crate) mod mat;
mod mcap;
mod npy;
pub(crate) mod npz;
mod number;
mod opened;
pub(crate) mod parquet;
mod parts;
pub(crate) mod text;
mod xlsx;

pub(crate) use arrays::{Array, Entry};
pub(crate) use columns::{Cell, FilePart, Row, Sample};
pub use error::FileError;
pub(crate) use format::Format;
pub(crate) use json_lines::LineKeys;
#[cfg(test)]
pub(crate) use opened::stuck;
pub(crate) use opened::{Opened, Part, open};

use crate::shown::joined;

/// All formats that the program can read.
pub const FORMATS: &[Format] = &[
    text::FORMAT,
    npy::FORMAT,
    npz::FORMAT,
    mat::FORMAT,
    hdf5::FORMAT,
    parquet::FORMAT,
    mcap::FORMAT,
    xlsx::FORMAT,
    text::LABVIEW,
    json_lines::FORMAT,
];

/// Returns the extensions of files that may be recordings, without the point.
pub fn endings() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.endings).copied()
}

/// Returns all formats with their extensions, as `--help` and the window list them.
pub fn listed() -> String {
    joined(
        ", ",
        FORMATS.iter().map(|format| format!("{} (.{})", format.name, format.endings.join(", ."))),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_are_unique_and_each_signature_selects_its_format() {
        let mut all: Vec<&str> = endings().collect();
        let n = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), n);
        for format in FORMATS {
            assert!(format.endings.iter().all(|ending| listed().contains(ending)));
            for start in format.signatures {
                let mut found = opened::formats_of(start).map(|found| found.name);
                assert!(found.any(|name| name == format.name));
            }
        }
    }
}
