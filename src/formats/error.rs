use std::io;
use std::path::PathBuf;

use crate::{
    panicked::Panicked,
    progress::Cancelled,
    shown::{listed, message, shown},
};

/// Reason why a file of numbers cannot be read.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each variant describes its fields")]
pub enum FileError {
    #[error("this is a folder; name the recordings in it ({}), or several by a pattern such as {}", listed(files), pattern.display())]
    Folder { files: Vec<String>, pattern: PathBuf },
    #[error("this is a pipe or a device; save its output to a file and choose that file")]
    NotAFile,
    #[error("the file cannot be read: {0}")]
    Io(io::Error),
    #[error("the file is empty; choose another file, or record the data again")]
    Empty,
    #[error("the file is not text but {what}; {instead}")]
    NotText { what: &'static str, instead: &'static str },
    #[error(
        "a line is longer than {limit_bytes} bytes, so this is not a table with one row per line; choose a text file with one row per sample"
    )]
    LineTooLong { limit_bytes: usize },
    #[error("the file ends inside {}; it was cut short, so copy or save it again", shown(what))]
    CutShort { what: String },
    #[error("{} is damaged: {}; save it again", shown(what), message(why))]
    Damaged { what: String, why: String },
    #[error(
        "{} holds {} instead of numbers; save it as an array of plain numbers",
        shown(what),
        shown(kind)
    )]
    NotNumbers { what: String, kind: String },
    #[error(
        "{} has the shape {}; save it with one row per sample and one column per channel",
        shown(what),
        shown(shape)
    )]
    NotATable { what: String, shape: String },
    #[error(
        "this file holds no table of numbers{}; save the samples as arrays with one row per sample",
        others(left_out)
    )]
    NoNumbers { left_out: Vec<String> },
    #[error(
        "{} would unpack to more than {limit_bytes} bytes, the limit for a file of this size; save the samples alone, without compression",
        shown(what)
    )]
    UnpacksTooLarge { what: String, limit_bytes: u64 },
    #[error(
        "the file is a MATLAB 7.3 file that cannot be read ({}); save it with `save FILE -v7`, or export it as CSV",
        shown(why)
    )]
    Mat73 { why: String },
    #[error(
        "the file is an HDF5 file that is damaged or uses a feature that is not supported, such as soft links between groups, or the file version that HDF5 2 writes with libver=\"latest\" ({}); convert it in Python: `import h5py, numpy; f = h5py.File(\"FILE\")`, then `numpy.savez(\"FILE.npz\", t=f[\"t\"], S=f[\"S\"], F=f[\"F\"])` with the names of its datasets",
        message(why)
    )]
    Hdf5 { why: String },
    #[error(
        "there is no table {} in this file, whose tables are {}; name one of these tables under \"parts\" in the column map, or remove \"parts\"",
        shown(part),
        listed(parts)
    )]
    NoSuchPart { part: String, parts: Vec<String> },
    #[error(
        "the columns of {} and {} have different names, so they cannot be joined to one table; choose one of the two",
        shown(first),
        shown(second)
    )]
    PartsDiffer { first: String, second: String },
    #[error(
            "{} topics are chosen, but at most two are read together; choose one topic of gauges and one of the reference",
        topics.len()
    )]
    TooManyTopics { topics: Vec<String> },
    #[error(
        "{} is compressed by {}, which is not supported; save it with {instead}",
        shown(what),
        shown(codec)
    )]
    Compression { what: String, codec: String, instead: &'static str },
    #[error(
        "the file is {what}, but this program was built without the feature `{feature}` that reads it; use a build of the program with all features, or export the recording as CSV"
    )]
    NotBuilt { what: &'static str, feature: &'static str },
    #[error("the file is damaged, and its reader failed: {}; save it again", shown(&.0.message))]
    ReaderFailed(Panicked),
    #[error("cancelled")]
    Cancelled,
}

impl FileError {
    /// Returns the error for a part of a file that ends before the length that it declares.
    pub(crate) fn cut_short(what: &str) -> Self {
        Self::CutShort { what: what.to_owned() }
    }

    pub(crate) fn damaged(what: &str, why: impl Into<String>) -> Self {
        Self::Damaged { what: what.to_owned(), why: why.into() }
    }
}

fn others(left_out: &[String]) -> String {
    if left_out.is_empty() { String::new() } else { format!(", only {}", listed(left_out)) }
}

impl From<Cancelled> for FileError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<io::Error> for FileError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Returns a function that turns an I/O error into a file error. `what` names the part of the file; an unexpected end of the
/// file becomes [`FileError::CutShort`].
pub fn reading(what: &str) -> impl Fn(io::Error) -> FileError {
    move |error| match error.kind() {
        io::ErrorKind::UnexpectedEof => FileError::cut_short(what),
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => {
            FileError::damaged(what, error.to_string())
        }
        _ => FileError::Io(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_very_long_shape_is_shortened_in_the_message() {
        let error = FileError::NotATable { what: "a".repeat(9000), shape: "(1, ".repeat(20_000) };
        assert!(error.to_string().chars().count() < 250, "{error}");
    }
}
