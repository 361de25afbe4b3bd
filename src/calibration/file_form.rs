//! Reads and writes calibrations as JSON.

use serde::Deserialize;
use serde_json::Value;

use crate::{
    calibration::{
        calibration::Calibration,
        error::CalibrationError,
        validate::{check_features, check_head},
    },
    features::FeatureSettings,
};

#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
}

impl Calibration {
    /// Reads a calibration file and validates it.
    pub fn from_json(content: &[u8]) -> Result<Self, CalibrationError> {
        let not_json =
            |error: serde_json::Error| CalibrationError::Json { reason: error.to_string() };
        let head: Head = serde_json::from_slice(content).map_err(not_json)?;
        check_head(&head.format, head.version)?;
        let mut calibration: Self = serde_json::from_slice(content).map_err(not_json)?;
        let (features, offset) = (&calibration.features, calibration.offset);
        let gauges = &calibration.gauges;
        features.check_columns(gauges.len())?;
        let conventional =
            [("conventional", &mut calibration.conventional, &FeatureSettings::present())];
        let compensated = calibration.compensated.iter_mut();
        let compensated = compensated.map(|map| ("compensated", map, features));
        // The matrix columns follow from gauges, features and offset term. The column names in the file are only compared
        // with them.
        for (field, map, features) in conventional.into_iter().chain(compensated) {
            map.columns = features.columns(gauges.len(), offset);
            let names = std::mem::take(&mut map.names_in_file);
            check_features(field, &map.names(gauges), &names)?;
        }
        let memories = calibration.features.memories();
        calibration.keep_secs.retain(|memory, _| memories.contains(&&**memory));
        calibration.fade.retain(|block, _| memories.contains(&&**block));
        let (n_axes, n_columns) = (calibration.axes.len(), calibration.columns().len());
        let known = calibration.quality.coefficients.take();
        calibration.quality.coefficients = known.filter(|known| known.is_of(n_axes, n_columns));
        calibration.validate()?;
        Ok(calibration)
    }

    /// Returns the JSON path of each unknown key in the file from which this calibration was read.
    pub fn unknown_keys(&self, content: &[u8]) -> Result<Vec<String>, serde_json::Error> {
        let file: Value = serde_json::from_slice(content)?;
        let known = serde_json::to_value(self.in_file())?;
        let mut unknown = Vec::new();
        add_unknown(&file, &known, "", &mut unknown);
        Ok(unknown)
    }

    /// Returns the calibration as it is written to a file, where the matrix columns have names.
    pub fn in_file(&self) -> Self {
        let mut file = self.clone();
        for map in std::iter::once(&mut file.conventional).chain(&mut file.compensated) {
            map.names_in_file = map.names(&self.gauges);
        }
        file
    }
}

/// Adds to the list the JSON paths of the keys in `file` that are not in `known`. Keys with an empty value are skipped.
fn add_unknown(file: &Value, known: &Value, place: &str, unknown: &mut Vec<String>) {
    match (file, known) {
        (Value::Object(file), Value::Object(known)) => {
            for (key, value) in file {
                let place = match place {
                    "" => key.clone(),
                    place => format!("{place}.{key}"),
                };
                let says_nothing = value.is_null() || value.as_array().is_some_and(Vec::is_empty);
                match known.get(key) {
                    Some(known) => add_unknown(value, known, &place, unknown),
                    None if says_nothing => {}
                    None => unknown.push(place),
                }
            }
        }
        (Value::Array(file), Value::Array(known)) => {
            for (at, (file, known)) in file.iter().zip(known).enumerate() {
                add_unknown(file, known, &format!("{place}[{at}]"), unknown);
            }
        }
        _ => {}
    }
}
