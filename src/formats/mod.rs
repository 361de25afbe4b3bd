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
//! | [`text`], [`csv`] | delimited text: read as any logger writes it, written as every spreadsheet reads it |
//! | `npy`, `npz` | NumPy's arrays, alone and in an archive |
//! | `mat` | MATLAB's files of version 5 (`save` without `-v7.3`) |
//! | `parquet` | columns of numbers; feature `parquet` |
//! | `mcap` | topics of a ROS 2 recording; feature `mcap` |
//! | `opened`, `columns` | a file behind one face, whichever of these it is: where its table may be, and its rows |
//! | `arrays`, `column_name` | arrays to columns with the names that headers have, and what such names mean |

mod arrays;
pub(crate) mod column_name;
mod columns;
pub mod csv;
mod error;
pub(crate) mod mat;
mod mcap;
mod npy;
pub(crate) mod npz;
mod opened;
pub(crate) mod parquet;
pub mod text;

use std::fs::File;
use std::io;
use std::path::Path;

pub(crate) use arrays::{Array, Entry};
pub(crate) use columns::{Cell, Column, Columns, Row};
pub use error::FileError;
pub(crate) use opened::{Opened, Part, open};

use crate::progress::Progress;

/// More columns are no table of a sensor.
const COLUMN_LIMIT: usize = 4096;
/// So much may always be unpacked.
const UNPACKED_BYTES: u64 = 1 << 30;
/// Beyond [`UNPACKED_BYTES`], no more than so many times what is stored: measured numbers pack far less.
const UNPACKED_RATIO: u64 = 100;

/// Every format that is read.
pub const FORMATS: [Format; 6] = [
    text::FORMAT,
    npy::FORMAT,
    npz::FORMAT,
    mat::FORMAT,
    parquet::FORMAT,
    mcap::FORMAT,
];

/// One kind of file.
#[derive(Debug)]
pub struct Format {
    /// What people call such a file.
    pub name: &'static str,
    /// What the names of such files end with, without the point.
    pub endings: &'static [&'static str],
    /// What such files start with; what starts like none of them is text.
    signatures: &'static [&'static [u8]],
    /// What such a file holds; `None` if it is something else after all.
    read: fn(&Source<'_>) -> Result<Option<Columns>, FileError>,
}

impl Format {
    /// The format of a file that starts so.
    fn of(head: &[u8]) -> Option<&'static Self> {
        const ALL: &[Format] = &FORMATS;
        let is_it = |format: &&Self| {
            format
                .signatures
                .iter()
                .any(|start| head.starts_with(start))
        };
        ALL.iter().find(is_it)
    }
}

/// A file whose format is known, before it is read.
#[derive(Clone, Copy, Debug)]
struct Source<'a> {
    path: &'a Path,
    /// How it starts.
    head: &'a [u8],
    n_bytes: u64,
    progress: &'a Progress,
}

impl Source<'_> {
    fn open(&self) -> io::Result<File> {
        File::open(self.path)
    }
}

/// What the names of files with recordings end with, without the point.
pub fn endings() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.endings).copied()
}

/// The formats with their endings, as `--help` and the window list them.
#[must_use]
pub fn listed() -> String {
    let of_format = |format: &Format| {
        let endings = format.endings.iter().map(|ending| format!(".{ending}"));
        let endings: Vec<String> = endings.collect();
        format!("{} ({})", format.name, endings.join(", "))
    };
    FORMATS.iter().map(of_format).collect::<Vec<_>>().join(", ")
}

/// How many bytes may come out of so many packed ones.
fn unpacked_limit(packed_bytes: u64) -> u64 {
    packed_bytes
        .saturating_mul(UNPACKED_RATIO)
        .max(UNPACKED_BYTES)
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
        for format in &FORMATS {
            assert!(
                format
                    .endings
                    .iter()
                    .all(|ending| listed().contains(ending))
            );
            for start in format.signatures {
                assert_eq!(Format::of(start).map(|found| found.name), Some(format.name));
            }
        }
    }
}
