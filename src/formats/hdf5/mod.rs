//! HDF5 files: groups of arrays and tables of records, read with the feature `hdf5`. MATLAB's `-v7.3` files are HDF5.

#[cfg(feature = "hdf5")]
mod read;

use super::columns::Columns;
use super::error::FileError;
use super::format::{Format, Source};

pub(super) const FORMAT: Format = Format {
    name: "HDF5 file",
    endings: &["h5", "hdf5"],
    signatures: &[b"\x89HDF\r\n\x1a\n"],
    #[cfg(feature = "hdf5")]
    read: read::columns,
    #[cfg(not(feature = "hdf5"))]
    read: |_| Err(FileError::NotBuilt { what: "an HDF5 file", feature: "hdf5" }),
};

#[cfg(feature = "hdf5")]
pub(super) fn matlab(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    match read::columns(source) {
        Err(FileError::Hdf5 { why }) => Err(FileError::Mat73 { why }),
        other => other,
    }
}

#[cfg(not(feature = "hdf5"))]
pub(super) fn matlab(_: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let why = "this program was built without the feature `hdf5`".to_owned();
    Err(FileError::Mat73 { why })
}
