//! The complete calibration as JSON, which this program can read back.

use crate::{calibration::Calibration, export::target::Target};

pub(super) static JSON: Target = Target {
    name: "Complete calibration (JSON)",
    purpose: "LoopScope and the command line",
    endings: &["json"],
    holds: "everything",
    write: |export, out| {
        serde_json::to_writer_pretty(&mut *out, &export.calibration.in_file())?;
        writeln!(out)
    },
    reader: Some(|content| {
        let calibration = Calibration::from_json(content)?;
        let unknown = calibration.unknown_keys(content)?;
        let note = (!unknown.is_empty()).then(|| {
            format!(
                "unknown keys, which were ignored: {}; see the guide's page on the calibration file",
                unknown.join(", ")
            )
        });
        Ok((calibration, note.into_iter().collect()))
    }),
    ..Target::PLAIN
};
