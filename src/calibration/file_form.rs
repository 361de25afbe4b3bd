//! How calibrations stand in files, older versions included.

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::calibration::calibration::history_step_by_rate;
use crate::calibration::validate::{check_features, check_head};
use crate::calibration::{Calibration, CalibrationError, LinearMap};
use crate::features::{Column, Distance, FeatureSettings, GaugeScale, Thresholds};
use crate::recording::gap::gap_by_rate;

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

/// What a file says of itself, and whether it has what came after version 1.
#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
    features: Option<IgnoredAny>,
    gauge_scale: Option<IgnoredAny>,
}

/// Version 1 knew one look-back and nothing else: it had these in place of `features`, and no `gauge_scale`, which the
/// look-back does not need.
#[derive(Deserialize)]
struct Version1 {
    thresholds: Option<Thresholds>,
    #[serde(default)]
    distance: Distance,
    gauges: Vec<String>,
}

impl Calibration {
    /// Reads what [`Calibration::in_file`] is written as; everything that a file could have wrong is checked.
    ///
    /// # Errors
    /// [`CalibrationFileError`] with the first thing found.
    pub fn from_json(content: &[u8]) -> Result<Self, CalibrationFileError> {
        let head: Head = serde_json::from_slice(content)?;
        check_head(&head.format, head.version)?;
        let file: Calibration<NamedMap> = match (head.features, head.gauge_scale) {
            (Some(_), Some(_)) => serde_json::from_slice(content)?,
            _ => serde_json::from_value(of_version_1(content)?)?,
        };
        let (gauges, offset) = (&file.gauges, file.offset);
        file.features
            .check_columns(gauges.len())
            .map_err(CalibrationError::from)?;
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
        let rate_hz = (calibration.rate_hz).map(|rate| rate / calibration.decimation.max(1) as f64);
        if calibration.gap_secs.is_nan() {
            calibration.gap_secs = gap_by_rate(rate_hz);
        }
        if calibration.history_step_secs.is_nan() {
            calibration.history_step_secs = history_step_by_rate(rate_hz);
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
        if self.version == 1 {
            unknown.retain(|key| !["thresholds", "distance"].contains(&&**key));
        }
        Ok(unknown)
    }

    /// The calibration as its file has it.
    pub fn in_file(&self) -> Calibration<NamedMap> {
        let named = |map: &LinearMap| NamedMap {
            features: map.names(&self.gauges),
            matrix: map.matrix.clone(),
        };
        let compensated = self.compensated.as_ref().map(named);
        self.clone()
            .with_maps(named(&self.conventional), compensated)
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

/// An old file with the fields that are missing in it.
fn of_version_1(content: &[u8]) -> Result<Value, serde_json::Error> {
    let old: Version1 = serde_json::from_slice(content)?;
    let features = FeatureSettings {
        look_backs: old.thresholds.into_iter().collect(),
        distance: old.distance,
        ..FeatureSettings::present()
    };
    let mut fields: Map<String, Value> = serde_json::from_slice(content)?;
    fields.entry("features").or_insert(json!(features));
    let scale = GaugeScale::identity(old.gauges.len());
    fields.entry("gauge_scale").or_insert(json!(scale));
    Ok(Value::Object(fields))
}
