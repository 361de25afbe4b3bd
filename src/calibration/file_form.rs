//! How calibrations stand in files, older versions included.

use serde::Deserialize;

use crate::calibration::learned::Learned;
use crate::calibration::{Calibration, LinearMap, Quality, Regressor, UsedRecording};
use crate::features::{Distance, FeatureSettings, GaugeScale, Thresholds};
use crate::recording::{Axis, Tare};

/// The fields of every version.
///
/// Version 1 knew one look-back and nothing else: it had `thresholds` and `distance` in place of `features`, and no
/// `gauge_scale`, which the look-back does not need.
#[derive(Deserialize)]
pub(super) struct FileForm {
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
    thresholds: Option<Thresholds>,
    distance: Option<Distance>,
    gauge_scale: Option<GaugeScale>,
    #[serde(default)]
    regressor: Regressor,
    conventional: LinearMap,
    compensated: Option<LinearMap>,
    learned: Option<Learned>,
    quality: Quality,
    trained_on: Vec<String>,
    rate_hz: Option<f64>,
    #[serde(default)]
    sources: Vec<UsedRecording>,
    #[serde(default)]
    tare: Option<Tare>,
}

impl From<FileForm> for Calibration {
    fn from(file: FileForm) -> Self {
        let FileForm {
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
        let features = features.unwrap_or_else(|| FeatureSettings {
            look_backs: thresholds.into_iter().collect(),
            distance: distance.unwrap_or_default(),
            ..FeatureSettings::present()
        });
        Self {
            format,
            version,
            program,
            simulated,
            gauge_scale: gauge_scale.unwrap_or_else(|| GaugeScale::identity(gauges.len())),
            gauges,
            axes,
            units,
            full_scale,
            offset,
            decimation,
            features,
            regressor,
            conventional,
            compensated,
            learned,
            quality,
            trained_on,
            rate_hz,
            sources,
            tare,
        }
    }
}
