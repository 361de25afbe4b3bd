//! Reader of MCAP recordings of ROS 2, built with the feature `mcap`.

#[cfg(feature = "mcap")]
mod cdr;
#[cfg(feature = "mcap")]
mod read;

use super::format::Format;

pub const FORMAT: Format = Format {
    name: "MCAP recording",
    endings: &["mcap"],
    signatures: &[b"\x89MCAP"],
    #[cfg(feature = "mcap")]
    read: read::columns,
    #[cfg(not(feature = "mcap"))]
    read: |_| Err(super::FileError::NotBuilt { what: "an MCAP recording", feature: "mcap" }),
};
