//! A model and its calibration as a session has them.

use std::sync::Arc;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use crate::analysis::{Cost, Model};
use crate::calibration::{Calibration, FitSettings, Scores};
use crate::recording::Axis;

/// What of a model stands in a session; its settings are those of its row.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Model")]
pub struct ModelInFile {
    #[serde(skip)]
    settings: FitSettings,
    axes: Vec<Axis>,
    scores: Scores,
    cv_spread: Vec<f64>,
    spread: Option<f64>,
    left_out: String,
    conventional: Scores,
    cost: Cost,
    seconds: Option<f64>,
    #[serde(with = "in_file_if_any")]
    trained: Option<Arc<Calibration>>,
}

/// Calibrations as their files have them, checked when they are read.
pub mod in_file {
    use super::*;

    pub fn serialize<S: Serializer>(own: &Arc<Calibration>, to: S) -> Result<S::Ok, S::Error> {
        own.in_file().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<Calibration>, D::Error> {
        let value = Value::deserialize(from)?;
        let text = serde_json::to_vec(&value).map_err(D::Error::custom)?;
        Calibration::from_json(&text)
            .map(Arc::new)
            .map_err(D::Error::custom)
    }
}

/// [`in_file`], where there is one.
mod in_file_if_any {
    use super::*;

    #[derive(Serialize, Deserialize)]
    struct Own(#[serde(with = "in_file")] Arc<Calibration>);

    pub fn serialize<S: Serializer>(
        own: &Option<Arc<Calibration>>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        own.clone().map(Own).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<Arc<Calibration>>, D::Error> {
        Ok(Option::<Own>::deserialize(from)?.map(|own| own.0))
    }
}
