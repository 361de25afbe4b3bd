//! Every array of a calibration for MATLAB (version 5).

use std::io;

use crate::export::mat;
use crate::export::target::{Export, Target};

/// `.mat`.
pub(super) struct Matlab;

impl Target for Matlab {
    fn name(&self) -> &'static str {
        "MATLAB arrays"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["mat"]
    }

    fn holds(&self) -> &'static str {
        "matrices, choices of the blocks, scales, rule for gaps, network or kernel"
    }

    fn write(&self, export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        mat::write(export.calibration, &export.facts, out)
    }
}
