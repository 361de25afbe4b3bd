//! How calibrations stand in files, older versions included.

use serde::{Deserialize, Serialize};

use crate::calibration::learned::Learned;
use crate::calibration::validate::{check_features, check_head};
use crate::calibration::{
    Calibration, CalibrationError, LinearMap, Quality, Regressor, UsedRecording,
};
use crate::features::{Column, Distance, FeatureSettings, GaugeScale, Thresholds};
use crate::recording::{Axis, Tare};

/// A calibration as its file has it: the fields of every version.
///
/// Version 1 knew one look-back and nothing else: it had `thresholds` and `distance` in place of `features`, and no
/// `gauge_scale`, which the look-back does not need.
#[derive(Debug, Serialize, Deserialize)]
pub struct CalibrationFile {
    format: String,
    version: u32,
    program: String,
    simulated: bool,
    gauges: Vec<String>,
    axes: Vec<Axis>,
    units: Vec<String>,
    full_scale: Vec<f64>,
    offset: bool,
    decimation: usize,
    features: Option<FeatureSettings>,
    #[serde(skip_serializing)]
    thresholds: Option<Thresholds>,
    #[serde(skip_serializing)]
    distance: Option<Distance>,
    gauge_scale: Option<GaugeScale>,
    #[serde(default)]
    regressor: Regressor,
    conventional: MapForm,
    #[serde(skip_serializing_if = "Option::is_none")]
    compensated: Option<MapForm>,
    #[serde(skip_serializing_if = "Option::is_none")]
    learned: Option<Learned>,
    quality: Quality,
    trained_on: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate_hz: Option<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    sources: Vec<UsedRecording>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tare: Option<Tare>,
}

/// A map whose columns have names, for whoever reads the file. What they are is settled by their order, which `gauges`,
/// `features` and `offset` fix; the names are only compared.
#[derive(Debug, Serialize, Deserialize)]
struct MapForm {
    features: Vec<String>,
    matrix: Vec<Vec<f64>>,
}

impl MapForm {
    fn of(map: LinearMap, gauges: &[String]) -> Self {
        Self {
            features: map.names(gauges),
            matrix: map.matrix,
        }
    }

    fn read(
        self,
        field: &'static str,
        columns: Vec<Column>,
        gauges: &[String],
    ) -> Result<LinearMap, CalibrationError> {
        check_features(field, &Column::names(&columns, gauges), &self.features)?;
        Ok(LinearMap {
            columns,
            matrix: self.matrix,
        })
    }
}

impl TryFrom<CalibrationFile> for Calibration {
    type Error = CalibrationError;

    /// Everything that a file could have wrong is checked.
    fn try_from(file: CalibrationFile) -> Result<Self, CalibrationError> {
        let CalibrationFile {
            format,
            version,
            program,
            simulated,
            gauges,
            axes,
            units,
            full_scale,
            offset,
            decimation,
            features,
            thresholds,
            distance,
            gauge_scale,
            regressor,
            conventional,
            compensated,
            learned,
            quality,
            trained_on,
            rate_hz,
            sources,
            tare,
        } = file;
        check_head(&format, version)?;
        let features = features.unwrap_or_else(|| FeatureSettings {
            look_backs: thresholds.into_iter().collect(),
            distance: distance.unwrap_or_default(),
            ..FeatureSettings::present()
        });
        features.check_columns(gauges.len())?;
        let map = |field, map: MapForm, features: &FeatureSettings| {
            map.read(field, features.columns(gauges.len(), offset), &gauges)
        };
        let calibration = Self {
            format,
            version,
            program,
            simulated,
            gauge_scale: gauge_scale.unwrap_or_else(|| GaugeScale::identity(gauges.len())),
            conventional: map("conventional", conventional, &FeatureSettings::present())?,
            compensated: compensated
                .map(|compensated| map("compensated", compensated, &features))
                .transpose()?,
            gauges,
            axes,
            units,
            full_scale,
            offset,
            decimation,
            features,
            regressor,
            learned,
            quality,
            trained_on,
            rate_hz,
            sources,
            tare,
        };
        calibration.validate()?;
        Ok(calibration)
    }
}

impl From<Calibration> for CalibrationFile {
    fn from(calibration: Calibration) -> Self {
        let Calibration {
            format,
            version,
            program,
            simulated,
            gauges,
            axes,
            units,
            full_scale,
            offset,
            decimation,
            features,
            gauge_scale,
            regressor,
            conventional,
            compensated,
            learned,
            quality,
            trained_on,
            rate_hz,
            sources,
            tare,
        } = calibration;
        Self {
            format,
            version,
            program,
            simulated,
            conventional: MapForm::of(conventional, &gauges),
            compensated: compensated.map(|map| MapForm::of(map, &gauges)),
            gauges,
            axes,
            units,
            full_scale,
            offset,
            decimation,
            features: Some(features),
            thresholds: None,
            distance: None,
            gauge_scale: Some(gauge_scale),
            regressor,
            learned,
            quality,
            trained_on,
            rate_hz,
            sources,
            tare,
        }
    }
}
