//! The complete calibration, which this program can read back.

use crate::calibration::Calibration;
use crate::export::target::Target;

pub(super) static JSON: Target = Target {
    name: "Complete calibration (JSON)",
    endings: &["json"],
    holds: "everything",
    write: |export, out| {
        serde_json::to_writer_pretty(&mut *out, &export.calibration.in_file())?;
        writeln!(out)
    },
    reader: Some(|content| {
        let calibration = Calibration::from_json(content)?;
        let unknown = calibration.unknown_keys(content)?;
        let mut notes = Vec::new();
        if !unknown.is_empty() {
            let keys = unknown.join(", ");
            notes.push(format!(
                "unknown keys, which were ignored: {keys}; see the guide's page on the calibration file"
            ));
        }
        Ok((calibration, notes))
    }),
    ..Target::PLAIN
};
