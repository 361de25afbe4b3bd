//! Files of numbers, one file a format: NumPy's `.npy` and `.npz`, MATLAB's `.mat`, Parquet, MCAP.
//!
//! Guarantees: a file's first bytes say what it is, never its name; what comes out is one [`Table`] of named columns,
//! which the same rules and maps understand as a table of text; memory grows with what a file really holds, not with
//! what it declares; where a crate that reads a format panics on a damaged file, that is an error of this file.
//!
//! | room | what |
//! |---|---|
//! | `npy`, `npz` | NumPy's arrays, alone and in an archive |
//! | `mat` | MATLAB's files of version 5 (`save` without `-v7.3`) |
//! | `parquet` | columns of numbers; feature `parquet` |
//! | `mcap`, `cdr` | topics of a ROS 2 recording; feature `mcap` |
//! | [`text`], `csv` | delimited text |
//! | `naming` | arrays to columns with the names that headers of text have |

#[cfg(feature = "mcap")]
mod cdr;
pub(crate) mod column_name;
pub(crate) mod csv;
mod error;
mod mat;
#[cfg(feature = "mcap")]
mod mcap;
mod naming;
mod npy;
mod npz;
#[cfg(feature = "parquet")]
mod parquet;
pub mod text;

use std::fs::File;
use std::io::Read;
use std::path::Path;

pub use error::ArraysError;

use crate::panicked;
use crate::progress::Progress;

/// Enough for a signature, and the name of an archive's first member.
const HEAD_BYTES: usize = 512;
/// More columns are no table of a sensor.
const COLUMN_LIMIT: usize = 4096;
/// So much may always be unpacked.
const UNPACKED_BYTES: u64 = 1 << 30;
/// Beyond [`UNPACKED_BYTES`], no more than so many times what is stored: measured numbers pack far less.
const UNPACKED_RATIO: u64 = 100;

/// Columns of numbers, as a file of arrays holds them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Table {
    /// What the file is called, e.g. `NumPy archive`.
    pub(crate) kind: &'static str,
    /// Whether the columns have names.
    pub(crate) is_named: bool,
    pub(crate) columns: Vec<Column>,
    /// Which column is the clock of the reference, where that is another than the gauges'.
    pub(crate) reference_time: Option<usize>,
    /// What else the file holds, and what it is.
    pub(crate) left_out: Vec<String>,
    /// Whether the file ends before it should.
    pub(crate) ends_early: bool,
}

/// One column; another clock's columns may have another length.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Column {
    /// As a header of text would have it; empty without names.
    pub(crate) name: String,
    /// Where the file itself says it; empty otherwise.
    pub(crate) unit: String,
    pub(crate) values: Vec<f64>,
}

impl Table {
    /// How long the longest column is.
    pub(crate) fn n_rows(&self) -> usize {
        let lengths = self.columns.iter().map(|column| column.values.len());
        lengths.max().unwrap_or(0)
    }
}

/// An array as its file holds it.
#[derive(Clone, Debug, Default, PartialEq)]
struct Array {
    name: String,
    /// Where the file itself says it; empty otherwise.
    unit: &'static str,
    shape: Vec<usize>,
    /// Whether the first index runs fastest.
    is_by_column: bool,
    values: Vec<f64>,
}

/// What a file is, by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Npy,
    Zip,
    EmptyZip,
    Mat,
    Mat73,
    Parquet,
    Mcap,
}

impl Kind {
    fn of(head: &[u8]) -> Option<Self> {
        const SIGNATURES: [(&[u8], Kind); 7] = [
            (b"\x93NUMPY", Kind::Npy),
            (b"PK\x03\x04", Kind::Zip),
            (b"PK\x05\x06", Kind::EmptyZip),
            (b"MATLAB 5.0", Kind::Mat),
            (b"MATLAB 7.3", Kind::Mat73),
            (b"PAR1", Kind::Parquet),
            (b"\x89MCAP", Kind::Mcap),
        ];
        let is_it = |(start, _): &&(&[u8], Self)| head.starts_with(start);
        SIGNATURES.iter().find(is_it).map(|&(_, kind)| kind)
    }
}

/// Reads a file of arrays; `None` if it is another kind of file, or none at all.
///
/// # Errors
/// [`ArraysError`] if the file is damaged, or holds no numbers in rows.
pub(crate) fn read(path: &Path, progress: &Progress) -> Result<Option<Table>, ArraysError> {
    // Asked before opening: opening a named pipe would wait for its other end.
    let Ok(metadata) = std::fs::metadata(path) else {
        return Ok(None);
    };
    if !metadata.is_file() {
        return Ok(None);
    }
    let Ok(mut file) = File::open(path) else {
        return Ok(None);
    };
    let mut head = [0; HEAD_BYTES];
    let mut n_read = 0;
    while n_read < head.len() {
        match file.read(&mut head[n_read..])? {
            0 => break,
            more => n_read += more,
        }
    }
    let Some(kind) = Kind::of(&head[..n_read]) else {
        return Ok(None);
    };
    drop(file);
    // Not all crates that read these formats hold what this one does.
    let decoded = panicked::caught_quietly(|| decoded(kind, path, &head, progress));
    match decoded.map_err(ArraysError::ReaderFailed)?? {
        Some(table) if table.n_rows() == 0 => Err(ArraysError::NoArrays {
            left_out: table.left_out,
        }),
        table => Ok(table),
    }
}

/// What a file of this kind holds; `None` if it is an archive of something else.
fn decoded(
    kind: Kind,
    path: &Path,
    head: &[u8],
    progress: &Progress,
) -> Result<Option<Table>, ArraysError> {
    let file = File::open(path)?;
    let file_bytes = file.metadata()?.len();
    let table = match kind {
        Kind::Npy => npy::table(file, file_bytes, progress),
        Kind::Zip => {
            let starts_with_array = memchr::memmem::find(head, b".npy").is_some();
            return npz::table(file, starts_with_array, progress);
        }
        Kind::EmptyZip => Err(ArraysError::NoArrays {
            left_out: Vec::new(),
        }),
        Kind::Mat => mat::table(&std::fs::read(path)?, progress),
        Kind::Mat73 => Err(ArraysError::Mat73),
        #[cfg(feature = "parquet")]
        Kind::Parquet => parquet::table(file, progress),
        #[cfg(not(feature = "parquet"))]
        Kind::Parquet => Err(ArraysError::NotBuilt {
            what: "a Parquet file",
            feature: "parquet",
        }),
        #[cfg(feature = "mcap")]
        Kind::Mcap => mcap::table(file, file_bytes, progress),
        #[cfg(not(feature = "mcap"))]
        Kind::Mcap => Err(ArraysError::NotBuilt {
            what: "an MCAP recording",
            feature: "mcap",
        }),
    };
    table.map(Some)
}

/// How many bytes may come out of so many packed ones.
fn unpacked_limit(packed_bytes: u64) -> u64 {
    packed_bytes
        .saturating_mul(UNPACKED_RATIO)
        .max(UNPACKED_BYTES)
}
