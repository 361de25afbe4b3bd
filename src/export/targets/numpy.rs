//! All arrays of a calibration as a NumPy archive.

use crate::{
    export::{arrays::arrays, target::Target},
    formats::npz,
};

/// NumPy archive (`.npz`), in which vectors are one-dimensional arrays.
pub(super) const NUMPY: Target = Target {
    name: "NumPy arrays",
    purpose: "NumPy",
    endings: &["npz"],
    holds: "matrices, settings of the feature blocks, scales, rule for gaps, network or kernel",
    write: |export, out| npz::write(&arrays(export), out),
    ..Target::PLAIN
};
