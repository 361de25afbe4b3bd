//! Reader of HDF5 files (groups of arrays and tables of records), built with the feature `hdf5`. MATLAB's `-v7.3` files are
//! HDF5.

#[cfg(feature = "hdf5")]
mod read;

use super::format::Format;

pub const FORMAT: Format = Format {
    name: "HDF5 file",
    endings: &["h5", "hdf5"],
    signatures: &[b"\x89HDF\r\n\x1a\n"],
    #[cfg(feature = "hdf5")]
    read: read::columns,
    #[cfg(not(feature = "hdf5"))]
    read: |_| Err(super::FileError::NotBuilt { what: "an HDF5 file", feature: "hdf5" }),
};
