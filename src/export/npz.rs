//! A calibration as NumPy's `.npz`.

use std::io;

use super::arrays::arrays;
use super::facts::Fact;
use crate::calibration::Calibration;
use crate::formats::npz;

/// Writes all [`arrays`]; vectors have one dimension.
pub(super) fn write(
    calibration: &Calibration,
    facts: &[Fact],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    npz::write(&arrays(calibration, facts), out)
}
