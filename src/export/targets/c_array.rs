//! The conventional calibration matrix as a C array, as sensor drivers have it in their source code.

use std::io;

use minijinja::context;

use super::matrix::{self, MATRIX};
use crate::{
    export::{
        target::{Export, Target},
        template::filled,
        text::{for_block_comment, identifier},
    },
    recording::Axis,
    shown::joined,
};

pub(super) static C_ARRAY: Target = Target {
    name: "Matrix for drivers (C array)",
    purpose: "Drivers that take a C array",
    endings: &["inc"],
    holds: "the conventional matrix, row-major",
    write,
    ..MATRIX
};

fn write(export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
    let rows = matrix::rows(export.calibration)
        .map(|row| joined(", ", row.iter().map(|value| format!("{value:?}"))));
    let values = context! {
        facts => matrix::facts(export, "per axis", for_block_comment),
        axes => Axis::symbols(&export.calibration.axes),
        name => identifier(export.name),
        n_gauges => export.calibration.gauges.len(),
        rows => rows.collect::<Vec<_>>(),
    };
    let text = filled(include_str!("../templates/calibration.inc"), values);
    out.write_all(text.as_bytes())
}
