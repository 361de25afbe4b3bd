//! Files of numbers, one file a format: what each holds as named columns, and how it is written.
//!
//! Guarantees: a file's first bytes say what it is, never its name; memory grows with what a file really holds, not with
//! what it declares; where a crate that reads a format panics on a damaged file, that is an error of this file.
//!
//! A format is one file with a [`Format`] in it, and a line in [`FORMATS`]: the file dialogs, `--help`, the import window
//! and the messages follow from that list.
//!
//! | room | what |
//! |---|---|
//! | [`text`], [`csv`] | delimited text: read as any logger writes it, LabVIEW's among them; written as every spreadsheet reads it |
//! | `npy`, `npz` | NumPy's arrays and records, alone and in an archive |
//! | `mat` | MATLAB's files of versions 4 and 5 (`save` without `-v7.3`) |
//! | `hdf5` | groups of arrays and tables of records, MATLAB's files of version 7.3 among them; feature `hdf5` |
//! | `parquet` | columns of numbers; feature `parquet` |
//! | `mcap` | topics of a ROS 2 recording; feature `mcap` |
//! | `xlsx` | sheets of a workbook; feature `xlsx` |
//! | `json_lines` | lines of JSON, an object for each sample |
//! | `parts` | which of several tables in a file is read |
//! | `opened`, `columns` | a file behind one face, whichever of these it is: where its table may be, and its rows |
//! | `number` | numbers as binary files store them |
//! | `arrays`, `column_name` | arrays to columns with the names that headers have, and what such names mean |

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
pub mod text;
mod xlsx;

pub(crate) use arrays::{Array, Entry};
pub(crate) use columns::FilePart;
pub(crate) use columns::{Cell, Row, Sample};
pub use error::FileError;
pub(crate) use format::Format;
pub(crate) use json_lines::LineKeys;
pub(crate) use opened::{Opened, Part, open};

/// Every format that is read.
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

/// What the names of files with recordings end with, without the point.
pub fn endings() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.endings).copied()
}

/// The formats with their endings, as `--help` and the window list them.
pub fn listed() -> String {
    let of_format = |format: &Format| {
        let endings = format.endings.iter().map(|ending| format!(".{ending}"));
        let endings: Vec<String> = endings.collect();
        format!("{} ({})", format.name, endings.join(", "))
    };
    FORMATS.iter().map(of_format).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_has_endings_and_starts_of_its_own() {
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
