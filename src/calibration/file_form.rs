//! How calibrations stand in files.

use serde::Deserialize;
use serde_json::Value;

use crate::calibration::calibration::Calibration;
use crate::calibration::error::CalibrationError;
use crate::calibration::validate::{check_features, check_head};
use crate::features::FeatureSettings;

/// Why bytes are no calibration that can be used.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationFileError {
    /// They are no JSON, or a field is missing or of another kind.
    #[error("not a calibration in JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// What they say cannot be used.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
}

/// What a file says of itself.
#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
}

impl Calibration {
    /// Reads what [`Calibration::in_file`] is written as; everything that a file could have wrong is checked.
    ///
    /// # Errors
    /// [`CalibrationFileError`] with the first thing found.
    pub fn from_json(content: &[u8]) -> Result<Self, CalibrationFileError> {
        let head: Head = serde_json::from_slice(content)?;
        check_head(&head.format, head.version)?;
        let mut calibration: Self = serde_json::from_slice(content)?;
        let (features, offset) = (&calibration.features, calibration.offset);
        let gauges = &calibration.gauges;
        features.check_columns(gauges.len()).map_err(CalibrationError::from)?;
        let conventional =
            [("conventional", &mut calibration.conventional, &FeatureSettings::present())];
        let compensated = calibration.compensated.iter_mut();
        let compensated = compensated.map(|map| ("compensated", map, features));
        // What the columns are is settled by their order, which gauges, features and offset fix; names are only compared.
        for (field, map, features) in conventional.into_iter().chain(compensated) {
            map.columns = features.columns(gauges.len(), offset);
            let names = std::mem::take(&mut map.names_in_file);
            check_features(field, &map.names(gauges), &names)?;
        }
        let (n_axes, n_columns) = (calibration.axes.len(), calibration.columns().len());
        let known = calibration.quality.coefficients.take();
        calibration.quality.coefficients = known.filter(|known| known.is_of(n_axes, n_columns));
        calibration.validate()?;
        Ok(calibration)
    }

    /// The keys of a file that this calibration was read from which mean nothing to this program, each with where it stands.
    ///
    /// # Errors
    /// If the bytes are no JSON.
    pub fn unknown_keys(&self, content: &[u8]) -> Result<Vec<String>, serde_json::Error> {
        let file: Value = serde_json::from_slice(content)?;
        let known = serde_json::to_value(self.in_file())?;
        let mut unknown = Vec::new();
        add_unknown(&file, &known, "", &mut unknown);
        Ok(unknown)
    }

    /// The calibration as its file has it: the columns of its maps with their names.
    pub fn in_file(&self) -> Self {
        let mut file = self.clone();
        for map in std::iter::once(&mut file.conventional).chain(&mut file.compensated) {
            map.names_in_file = map.names(&self.gauges);
        }
        file
    }
}

/// Adds the keys of `file` that `known` has not, but for those that say nothing.
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
