//! The conventional matrix alone, for carriers that have room for nothing else; what that leaves out is told before it is written.

use crate::calibration::Calibration;
use crate::export::target::{Export, Outline, Refusal, Target};
use crate::recording::Axis;

/// What such formats have in common.
pub(super) const MATRIX: Target = Target {
    leaves_out: |_| "all history (compensated load), the offset (take the unloaded gauges as bias), names of gauges",
    caution,
    ..Target::PLAIN
};

/// What whoever loads such a file must know: nothing where the matrix is the whole calibration.
fn caution(calibration: &Calibration) -> Option<String> {
    let is_more = calibration.learned.is_some()
        || calibration.columns().len() > calibration.conventional.columns.len();
    let compensation = is_more.then(|| {
        format!("the compensation ({}): its load is the conventional one", calibration.describe())
    });
    let offset = calibration
        .offset
        .then(|| "the offset: tare before use, with the unloaded gauges as bias".to_owned());
    let parts: Vec<String> = compensation.into_iter().chain(offset).collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// The coefficients of an axis on the gauges, without the offset.
pub(super) fn rows(calibration: &Calibration) -> impl Iterator<Item = &[f64]> {
    let n_gauges = calibration.gauges.len();
    let rows = calibration.conventional.matrix.iter();
    rows.map(move |row| &row[..n_gauges])
}

/// What the file says of itself, as it stands in a `comment`; `how` says in which units or order offsets are that are left out.
pub(super) fn facts(export: &Export<'_>, how: &str, comment: fn(&str) -> String) -> Vec<String> {
    let offsets = export.calibration.conventional.matrix.iter();
    let offsets = offsets.filter_map(|row| Some(row.last()?.to_string()));
    let offsets = export.calibration.offset.then(|| {
        let offsets = offsets.collect::<Vec<_>>().join(" ");
        format!("offset left out, {how}: {}", comment(&offsets))
    });
    export.lines(comment).chain(offsets).collect()
}

/// Checks that there are all six axes, and no more gauges than `most`, no fewer than `least`.
pub(super) fn check(
    file: &'static str,
    (least, most): (usize, usize),
    outline: &Outline<'_>,
) -> Result<(), Refusal> {
    if (least..=most).contains(&outline.n_gauges) && *outline.axes == Axis::ALL {
        return Ok(());
    }
    let room =
        if least == most { format!("{most} gauges") } else { format!("up to {most} gauges") };
    Err(Box::new(NoRoom {
        file,
        room,
        gauges: outline.n_gauges,
        axes: Axis::symbols(outline.axes),
    }))
}

/// A calibration that such a file has no room for.
#[derive(Debug, thiserror::Error)]
#[error(
    "{file} holds {room} and the axes Fx Fy Fz Mx My Mz, and this calibration has {gauges} gauges and the axes {}; use \
     .yaml, .h, .inc or .json", .axes.join(" ")
)]
struct NoRoom {
    file: &'static str,
    room: String,
    gauges: usize,
    axes: Vec<&'static str>,
}
