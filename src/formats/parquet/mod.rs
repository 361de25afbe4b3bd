//! Reads and writes numeric columns of Parquet files, if built with the feature `parquet`.

#[cfg(feature = "parquet")]
mod read;
#[cfg(feature = "parquet")]
mod write;

#[cfg(feature = "parquet")]
pub(crate) use write::ParquetTable;

use super::format::Format;

pub(super) const FORMAT: Format = Format {
    name: "Parquet file",
    endings: &["parquet"],
    signatures: &[b"PAR1"],
    #[cfg(feature = "parquet")]
    read: read::columns,
    #[cfg(not(feature = "parquet"))]
    read: |_| Err(super::FileError::NotBuilt { what: "a Parquet file", feature: "parquet" }),
};
