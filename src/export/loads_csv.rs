//! Conv. and Comp. of each sample as a table.

use std::io;

use crate::calibration::{AppliedLoads, Calibration};
use crate::recording::Recording;

/// Writes recordings with what a calibration makes of them, one row per sample: time, then per axis Calc. (where the
/// recording has it), Conv. and Comp.
///
/// The recordings are the uninterrupted runs of one file, so the rows are those of the file. Numbers are written so
/// that reading them gives the same value.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write_loads_csv(
    calibration: &Calibration,
    recordings: &[(&Recording, AppliedLoads)],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    let n_axes = calibration.axes.len();
    let reference: Vec<usize> = match recordings.first() {
        Some((recording, _)) => (0..n_axes)
            .filter(|axis| recording.axes().contains(&calibration.axes[*axis]))
            .collect(),
        None => Vec::new(),
    };
    let all: Vec<usize> = (0..n_axes).collect();
    let mut record = vec!["t [s]".to_owned()];
    for (kind, axes) in [("calc", &reference), ("conv", &all), ("comp", &all)] {
        record.extend(axes.iter().map(|&axis| {
            let axis = calibration.axes[axis];
            format!("{} {kind} [{}]", axis.symbol(), axis.unit())
        }));
    }
    csv.write_record(&record)?;
    for (recording, loads) in recordings {
        let columns: Vec<usize> = reference
            .iter()
            .filter_map(|&axis| {
                let axis = calibration.axes[axis];
                recording.axes().iter().position(|own| *own == axis)
            })
            .collect();
        for (k, time) in recording.times().iter().enumerate() {
            let truth = &recording.loads()[k * recording.axes().len()..];
            let row = k * n_axes..(k + 1) * n_axes;
            let numbers = std::iter::once(time)
                .chain(columns.iter().map(|&column| &truth[column]))
                .chain(&loads.conventional[row.clone()])
                .chain(&loads.compensated[row]);
            csv.write_record(numbers.map(f64::to_string))?;
        }
    }
    csv.flush()
}
