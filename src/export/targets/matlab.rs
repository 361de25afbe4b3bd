//! All arrays of a calibration for MATLAB (version 5).

use super::numpy::NUMPY;
use crate::export::arrays::arrays;
use crate::export::target::Target;
use crate::formats::{Entry, mat};

/// `.mat`. Lists of texts are matrices of characters, one row each, padded with blanks. Octave reads ASCII only: the dot of a
/// product becomes a point, any other character its code.
pub(super) static MATLAB: Target = Target {
    name: "MATLAB arrays",
    endings: &["mat"],
    write: |export, out| {
        let mut arrays = arrays(export);
        for array in &mut arrays {
            if let Entry::Texts { texts, .. } = array {
                texts.iter_mut().for_each(|text| *text = in_ascii(text));
            }
        }
        mat::write(&arrays, out)
    },
    ..NUMPY
};

fn in_ascii(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '·' => out.push('.'),
            c if c.is_ascii() => out.push(c),
            c => out.extend(c.escape_unicode()),
        }
    }
    out
}
