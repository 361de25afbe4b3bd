//! The complete calibration, as this program reads it back.

use std::io;

use crate::calibration::{Calibration, CalibrationFile};
use crate::export::target::{Export, ReadBack, Refusal, Target};

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
        serde_json::to_writer_pretty(&mut *out, export.calibration)?;
        writeln!(out)
    }

    fn reader(&self) -> Option<ReadBack> {
        Some(read)
    }
}

fn read(content: &[u8]) -> Result<Calibration, Refusal> {
    let file: CalibrationFile = serde_json::from_slice(content)
        .map_err(|error| format!("not a calibration in JSON: {error}"))?;
    Ok(file.try_into()?)
}
