//! A calibration as MATLAB's `.mat`.

use std::io;

use super::arrays::arrays;
use super::facts::Fact;
use crate::calibration::Calibration;
use crate::formats::mat;

/// Writes all [`arrays`]; lists of texts are matrices of characters, one row each, padded with blanks.
pub(super) fn write(
    calibration: &Calibration,
    facts: &[Fact],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    // Octave reads no character beyond ASCII.
    let units = calibration.units.iter().map(|unit| unit.replace('·', "."));
    mat::write(&arrays(calibration, facts, units), out)
}
