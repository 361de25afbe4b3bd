//! All arrays of a calibration as a MATLAB file of version 5.

use super::numpy::NUMPY;
use crate::{
    export::{arrays::arrays, target::Target, text::ascii},
    formats::{Entry, mat},
};

/// MATLAB file (`.mat`). A list of texts is a matrix of characters, one row per text, padded with blanks. Texts are in
/// ASCII, because Octave reads no other characters.
pub(super) static MATLAB: Target = Target {
    name: "MATLAB arrays",
    purpose: "MATLAB arrays",
    endings: &["mat"],
    write: |export, out| {
        let mut arrays = arrays(export);
        for array in &mut arrays {
            if let Entry::Texts { texts, .. } = array {
                texts.iter_mut().for_each(|text| *text = ascii(text));
            }
        }
        mat::write(&arrays, out)
    },
    ..NUMPY
};
