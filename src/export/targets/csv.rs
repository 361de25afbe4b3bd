//! The conventional and compensated matrices of a calibration as a table with named rows and columns.

use std::io;

use crate::{
    export::target::{Export, Target, linear_parts},
    features::Column,
    formats::csv::CsvWriter,
    shown::printable,
};

pub(super) static CSV: Target = Target {
    name: "Matrices (CSV)",
    purpose: "Spreadsheets",
    endings: &["csv"],
    holds: "matrices, shift and scale of each gauge",
    leaves_out: |calibration| match calibration.learned {
        Some(_) => {
            "the network or kernel, so the compensated load is incomplete; settings of the feature blocks (only described in words)"
        }
        None => "settings of the feature blocks (only described in words)",
    },
    write,
    parts: linear_parts,
    ..Target::PLAIN
};

/// Writes the facts as lines that begin with `#`, then one row for each axis of the conventional and of the compensated
/// calibration.
fn write(export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
    let calibration = export.calibration;
    for line in export.lines(|text| printable(text).into_owned()) {
        writeln!(out, "# {line}")?;
    }
    if calibration.compensated.is_some() {
        // Play operators and polynomials are of standardised gauges.
        let scale = &calibration.gauge_scale;
        let scales = scale.shift.iter().zip(&scale.inverse_scale);
        for (gauge, (shift, inverse)) in calibration.gauges.iter().zip(scales) {
            writeln!(out, "# standardised {}: ({0} - {shift}) * {inverse}", printable(gauge))?;
        }
    }
    let mut csv = CsvWriter::new(out);
    let columns = calibration.columns();
    let features = Column::names(&columns, &calibration.gauges);
    csv.row(["calibration", "blocks", "axis", "unit"].map(str::to_owned).iter().chain(&features))?;
    let blocks = calibration.describe();
    let compensated = calibration.compensated.as_ref();
    let maps = std::iter::once(("conventional", "", &calibration.conventional))
        .chain(compensated.map(|map| ("compensated", &*blocks, map)));
    for (name, blocks, map) in maps {
        // Readers of the table must see that the calibration is of a simulated sensor, not of a real one.
        let name = if calibration.simulated {
            format!("{name} (simulated sensor)")
        } else {
            name.to_owned()
        };
        for ((axis, unit), row) in calibration.axes.iter().zip(&calibration.units).zip(&map.matrix)
        {
            let head = [&name, blocks, axis.symbol(), unit].map(str::to_owned);
            // The matrix of a calibration has some of the columns of the table, in the same order.
            let mut entries = map.columns.iter().zip(row).peekable();
            let numbers = columns.iter().map(|column| {
                let number = entries.next_if(|(known, _)| *known == column);
                number.map_or(String::new(), |(_, number)| number.to_string())
            });
            csv.row(head.into_iter().chain(numbers))?;
        }
    }
    csv.flush()
}
