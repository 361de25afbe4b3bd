//! How calibrations stand in files.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::calibration::calibration::Calibration;
use crate::calibration::linear_map::LinearMap;
use crate::calibration::validate::CalibrationError;
use crate::calibration::validate::{check_features, check_head};
use crate::features::{Column, FeatureSettings};

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

/// A map whose columns have names, for whoever reads the file. What they are is settled by their order, which `gauges`,
/// `features` and `offset` fix; the names are only compared.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct NamedMap {
    features: Vec<String>,
    matrix: Vec<Vec<f64>>,
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
        let file: Calibration<NamedMap> = serde_json::from_slice(content)?;
        let (gauges, offset) = (&file.gauges, file.offset);
        file.features.check_columns(gauges.len()).map_err(CalibrationError::from)?;
        let map = |field, map: &NamedMap, features: &FeatureSettings| {
            let columns = features.columns(gauges.len(), offset);
            check_features(field, &Column::names(&columns, gauges), &map.features)?;
            let matrix = map.matrix.clone();
            Ok::<_, CalibrationError>(LinearMap { columns, matrix })
        };
        let present = FeatureSettings::present();
        let conventional = map("conventional", &file.conventional, &present)?;
        let compensated = file.compensated.as_ref();
        let compensated =
            compensated.map(|compensated| map("compensated", compensated, &file.features));
        let compensated = compensated.transpose()?;
        let mut calibration = file.with_maps(conventional, compensated);
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

    /// The calibration as its file has it.
    pub fn in_file(&self) -> Calibration<NamedMap> {
        let named = |map: &LinearMap| NamedMap {
            features: map.names(&self.gauges),
            matrix: map.matrix.clone(),
        };
        let compensated = self.compensated.as_ref().map(named);
        self.clone().with_maps(named(&self.conventional), compensated)
    }
}

impl<M> Calibration<M> {
    fn with_maps<N>(self, conventional: N, compensated: Option<N>) -> Calibration<N> {
        Calibration {
            format: self.format,
            version: self.version,
            program: self.program,
            simulated: self.simulated,
            identity: self.identity,
            gauges: self.gauges,
            axes: self.axes,
            units: self.units,
            full_scale: self.full_scale,
            rated: self.rated,
            offset: self.offset,
            decimation: self.decimation,
            gap_secs: self.gap_secs,
            history_step_secs: self.history_step_secs,
            limits: self.limits,
            gauge_limits: self.gauge_limits,
            features: self.features,
            gauge_scale: self.gauge_scale,
            regressor: self.regressor,
            conventional,
            compensated,
            learned: self.learned,
            quality: self.quality,
            trained_on: self.trained_on,
            rate_hz: self.rate_hz,
            sources: self.sources,
            tare: self.tare,
        }
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
