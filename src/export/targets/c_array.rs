//! The conventional matrix as an array of C, as drivers have it in their source.

use std::io;

use super::matrix;
use crate::calibration::Calibration;
use crate::export::target::{Export, Target};
use crate::export::text::{for_block_comment, identifier};

/// `.inc`.
pub(super) struct CArray;

impl Target for CArray {
    fn name(&self) -> &'static str {
        "Matrix for drivers (C array)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["inc"]
    }

    fn holds(&self) -> &'static str {
        "the conventional matrix, row-major"
    }

    fn leaves_out(&self, _calibration: &Calibration) -> &'static str {
        matrix::LEFT_OUT
    }

    fn caution(&self, calibration: &Calibration) -> Option<String> {
        matrix::leaves_out(calibration)
    }

    fn write(&self, export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        let calibration = export.calibration;
        let name = identifier(export.name);
        writeln!(out, "/*")?;
        for (fact, text) in &export.facts {
            writeln!(out, " * {fact}: {}", for_block_comment(text))?;
        }
        if let Some(offsets) = matrix::offsets(calibration) {
            writeln!(out, " * offset left out, per axis: {offsets}")?;
        }
        let axes: Vec<&str> = calibration.axes.iter().map(|axis| axis.symbol()).collect();
        let (n_axes, n_gauges) = (axes.len(), calibration.gauges.len());
        writeln!(
            out,
            " * load = matrix * (gauges - unloaded gauges); rows: {}\n */",
            axes.join(" ")
        )?;
        writeln!(
            out,
            "static const double {name}_matrix[{n_axes}][{n_gauges}] = {{"
        )?;
        for row in matrix::rows(calibration) {
            let values: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
            writeln!(out, "    {{{}}},", values.join(", "))?;
        }
        writeln!(out, "}};")
    }
}
