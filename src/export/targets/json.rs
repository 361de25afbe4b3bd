//! The complete calibration, as this program reads it back.

use std::io;

use crate::calibration::Calibration;
use crate::export::target::{Export, ReadBack, Target};

/// `.json`.
pub(super) struct Json;

impl Target for Json {
    fn name(&self) -> &'static str {
        "Complete calibration (JSON)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["json"]
    }

    fn holds(&self) -> &'static str {
        "everything"
    }

    fn write(&self, export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, &export.calibration.in_file())?;
        writeln!(out)
    }

    fn reader(&self) -> Option<ReadBack> {
        Some(|content| {
            let calibration = Calibration::from_json(content)?;
            let unknown = calibration.unknown_keys(content)?;
            let note = |keys: &[String]| {
                let keys = keys.join(", ");
                format!(
                    "not known and not used: {keys}; see the guide's page on the calibration file"
                )
            };
            let notes = (!unknown.is_empty()).then(|| note(&unknown));
            Ok((calibration, notes.into_iter().collect()))
        })
    }
}
