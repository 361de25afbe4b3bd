//! A calibration as MATLAB's `.mat`.

use std::io;

use super::arrays::arrays;
use super::facts::Fact;
use crate::calibration::Calibration;
use crate::formats::{Entry, mat};

/// Writes all [`arrays`]; lists of texts are matrices of characters, one row each, padded with blanks. Octave reads no character
/// beyond ASCII: the dot of a product becomes a point, any other its code.
pub(super) fn write(
    calibration: &Calibration,
    facts: &[Fact],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let mut arrays = arrays(calibration, facts);
    for array in &mut arrays {
        if let Entry::Texts { texts, .. } = array {
            texts.iter_mut().for_each(|text| *text = in_ascii(text));
        }
    }
    mat::write(&arrays, out)
}

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
