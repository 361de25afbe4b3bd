//! The conventional matrix without compensation and offset, for file formats that hold nothing else. The user is warned of
//! the omissions before writing.

use crate::{
    calibration::Calibration,
    export::target::{Export, Held, Target, all_parts, is_compensated},
    shown::joined,
};

pub(super) const MATRIX: Target = Target {
    leaves_out: |_| "the compensation of hysteresis, the offset (take the unloaded gauges as bias), gauge names",
    caution,
    parts: |calibration| {
        all_parts(calibration).map(|part| if part == Held::Whole { Held::LeftOut } else { part })
    },
    ..Target::PLAIN
};

/// Returns a warning about the parts that the file omits; `None` if the conventional matrix is the whole calibration.
fn caution(calibration: &Calibration) -> Option<String> {
    let compensation = is_compensated(calibration).then(|| {
        format!(
            "the compensation ({}): the file gives the conventional load",
            calibration.describe()
        )
    });
    let offset = calibration
        .offset
        .then(|| "the offset: tare before use, with the unloaded gauges as bias".to_owned());
    let parts: Vec<String> = compensation.into_iter().chain(offset).collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// Returns the row of gauge coefficients of each axis in the conventional calibration, without the axis' offset.
pub(super) fn rows(calibration: &Calibration) -> impl Iterator<Item = &[f64]> {
    let n_gauges = calibration.gauges.len();
    calibration.conventional.matrix.iter().map(move |row| &row[..n_gauges])
}

/// Returns the facts about the calibration, each as a line escaped by `comment`. A last line gives the offsets, which the
/// matrix does not contain. `how` is the text about the unit or the order of the offsets.
pub(super) fn facts(export: &Export<'_>, how: &str, comment: fn(&str) -> String) -> Vec<String> {
    let offsets = export.calibration.conventional.matrix.iter().filter_map(|row| row.last());
    let offsets = (export.calibration.offset)
        .then(|| format!("offset left out, {how}: {}", comment(&joined(" ", offsets))));
    export.lines(comment).chain(offsets).collect()
}
