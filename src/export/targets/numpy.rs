//! Every array of a calibration for NumPy.

use std::io;

use crate::export::npz;
use crate::export::target::{Export, Target};

/// `.npz`.
pub(super) struct NumPy;

impl Target for NumPy {
    fn name(&self) -> &'static str {
        "NumPy arrays"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["npz"]
    }

    fn holds(&self) -> &'static str {
        "matrices, choices of the blocks, scales, rule for gaps, network or kernel"
    }

    fn write(&self, export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        npz::write(export.calibration, &export.facts, out)
    }
}
