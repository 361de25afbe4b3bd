//! What a fit leaves behind: two matrices, the rule that picks the past sample, and how good they are.
//!
//! Guarantees: a [`Calibration`] that exists is whole (shapes match, every number finite), whether it was fitted or
//! read; applied to a recording it gives the numbers that the fit gave.

use serde::{Deserialize, Serialize};

use crate::features::{Distance, LoadPath, Thresholds};
use crate::recording::{Axis, Recording};

/// What the field `format` of a calibration file says.
pub const FORMAT: &str = "loopscope calibration";
/// The newest version of the file that this program writes and reads.
pub const VERSION: u32 = 1;

/// A load as a linear function of named features: `load = matrix · features`.
///
/// **Shapes** `matrix` has one row per axis and one column per feature; the feature `offset` is always 1.
///
/// **Units** (N) or (N·m) per unit of the gauge.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinearMap {
    /// Column names: the gauges, then `<gauge>_past` where the past is used, then `offset` where there is one.
    pub features: Vec<String>,
    /// One row per axis.
    pub matrix: Vec<Vec<f64>>,
}

impl LinearMap {
    /// Writes the load of one sample from the parts of its feature row.
    #[inline]
    pub fn apply(&self, gauges: &[f64], past: &[f64], load: &mut [f64]) {
        for (load, row) in load.iter_mut().zip(&self.matrix) {
            let (present, rest) = row.split_at(gauges.len());
            let (earlier, offset) = rest.split_at(past.len());
            *load = dot(present, gauges) + dot(earlier, past) + offset.first().unwrap_or(&0.0);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Root mean squared errors per axis; `None` where nothing could be scored.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// On the recordings that were fitted.
    pub train_rmse: Option<Vec<f64>>,
    /// On the recordings in the test role.
    pub test_rmse: Option<Vec<f64>>,
    /// Each training recording scored by a fit to the others (with fewer than three: contiguous blocks of them).
    pub cv_rmse: Option<Vec<f64>>,
}

/// How good a calibration was on the recordings it was made with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Samples that were fitted.
    pub n_train: u64,
    /// Samples in the test role.
    pub n_test: u64,
    /// With the present sample alone.
    pub conventional: Scores,
    /// With what the past adds.
    pub compensated: Scores,
    /// How many of the compensated fit's features are independent.
    pub rank: usize,
    /// Largest over smallest singular value of the independent columns `[z, z_past − z, 1]` of the compensated fit,
    /// each scaled to unit length (z: gauges less their mean); `None` where no column is independent.
    pub condition: Option<f64>,
}

/// A calibration that can be saved, read and applied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Always [`FORMAT`].
    pub format: String,
    /// The file's version, at most [`VERSION`].
    pub version: u32,
    /// The program that made it.
    pub program: String,
    /// Whether it was made from the built-in simulated sensor rather than from a real one.
    pub simulated: bool,
    /// Gauge names in column order.
    pub gauges: Vec<String>,
    /// Axes in row order.
    pub axes: Vec<Axis>,
    /// The unit of each axis.
    pub units: Vec<String>,
    /// The full scale of each axis, in its unit.
    pub full_scale: Vec<f64>,
    /// Whether the model has an offset term.
    pub offset: bool,
    /// Every how many-th sample was fitted.
    pub decimation: usize,
    /// The thresholds of the look-back.
    pub thresholds: Thresholds,
    /// What F_th is measured in.
    pub distance: Distance,
    /// The load from the present gauges.
    pub conventional: LinearMap,
    /// The load from the present and past gauges.
    pub compensated: LinearMap,
    /// How good it was.
    pub quality: Quality,
    /// Names of the training recordings.
    pub trained_on: Vec<String>,
}

/// Why a calibration cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum CalibrationError {
    #[error("this is not a calibration: its \"format\" is not \"{FORMAT}\"")]
    Format,
    #[error("the calibration has version {version}; this program knows versions up to {VERSION}")]
    Version { version: u32 },
    #[error("the calibration has no {what}")]
    Nothing { what: &'static str },
    #[error("the axes must be distinct and in the order Fx Fy Fz Mx My Mz")]
    AxisOrder,
    #[error("{field} has {actual} entries where {expected} are needed")]
    Length {
        field: String,
        expected: usize,
        actual: usize,
    },
    #[error("the unit of {axis} is {actual:?} where {expected:?} is needed")]
    Unit {
        axis: &'static str,
        expected: &'static str,
        actual: String,
    },
    #[error("{field} holds a number that is not finite, or is negative where it must not be")]
    Number { field: String },
    #[error("{field}: feature {position} is {actual:?} where {expected:?} is needed")]
    Feature {
        field: &'static str,
        position: usize,
        expected: String,
        actual: String,
    },
    #[error("{recording} has the gauges {} where the calibration was made for {}", .actual.join(" "), .expected.join(" "))]
    Gauges {
        recording: String,
        expected: Vec<String>,
        actual: Vec<String>,
    },
}

/// What a calibration makes of a recording.
///
/// **Shapes** loads `n × n_axes` row-major, `past` one index per sample.
#[derive(Clone, Debug, PartialEq)]
pub struct AppliedLoads {
    /// Conv.: from the present gauges.
    pub conventional: Vec<f64>,
    /// Comp.: with what the past adds.
    pub compensated: Vec<f64>,
    /// The past sample of each sample; its own index where there is none.
    pub past: Vec<u32>,
}

impl Calibration {
    /// The names of the columns of a matrix, in order.
    #[must_use]
    pub fn feature_names(gauges: &[String], with_past: bool, offset: bool) -> Vec<String> {
        let past = gauges
            .iter()
            .filter(|_| with_past)
            .map(|gauge| format!("{gauge}_past"));
        gauges
            .iter()
            .cloned()
            .chain(past)
            .chain(offset.then(|| "offset".to_owned()))
            .collect()
    }

    /// Checks everything that a file could have wrong.
    ///
    /// # Errors
    /// [`CalibrationError`] with the first thing found.
    pub fn validate(&self) -> Result<(), CalibrationError> {
        if self.format != FORMAT {
            return Err(CalibrationError::Format);
        }
        if self.version == 0 || self.version > VERSION {
            return Err(CalibrationError::Version {
                version: self.version,
            });
        }
        if self.gauges.is_empty() {
            return Err(CalibrationError::Nothing { what: "gauges" });
        }
        if self.axes.is_empty() {
            return Err(CalibrationError::Nothing { what: "axes" });
        }
        if !self.axes.is_sorted_by(|a, b| a < b) {
            return Err(CalibrationError::AxisOrder);
        }
        let n_axes = self.axes.len();
        length("units", n_axes, self.units.len())?;
        length("full_scale", n_axes, self.full_scale.len())?;
        for (axis, unit) in self.axes.iter().zip(&self.units) {
            if unit != axis.unit() {
                return Err(CalibrationError::Unit {
                    axis: axis.symbol(),
                    expected: axis.unit(),
                    actual: unit.clone(),
                });
            }
        }
        for (field, numbers) in [
            ("full_scale", &self.full_scale[..]),
            ("thresholds.f_th", &[self.thresholds.f_th]),
            ("thresholds.t_th_secs", &[self.thresholds.t_th_secs]),
        ] {
            if !numbers
                .iter()
                .all(|number| *number >= 0.0 && number.is_finite())
            {
                return Err(CalibrationError::Number {
                    field: field.to_owned(),
                });
            }
        }
        for (field, map, with_past) in [
            ("conventional", &self.conventional, false),
            ("compensated", &self.compensated, true),
        ] {
            let features = Self::feature_names(&self.gauges, with_past, self.offset);
            length(
                &format!("{field}.features"),
                features.len(),
                map.features.len(),
            )?;
            let named = features.iter().zip(&map.features).enumerate();
            for (position, (expected, actual)) in named {
                if expected != actual {
                    return Err(CalibrationError::Feature {
                        field,
                        position: position + 1,
                        expected: expected.clone(),
                        actual: actual.clone(),
                    });
                }
            }
            length(&format!("{field}.matrix"), n_axes, map.matrix.len())?;
            for (axis, row) in self.axes.iter().zip(&map.matrix) {
                let field = format!("{field}.matrix, row {}", axis.symbol());
                length(&field, features.len(), row.len())?;
                if !row.iter().all(|number| number.is_finite()) {
                    return Err(CalibrationError::Number { field });
                }
            }
        }
        Ok(())
    }

    /// Checks that a recording has the gauges that the calibration was made for.
    ///
    /// # Errors
    /// [`CalibrationError::Gauges`] if it has not.
    pub fn check_gauges(&self, recording: &Recording) -> Result<(), CalibrationError> {
        if recording.gauge_names() == self.gauges {
            Ok(())
        } else {
            Err(CalibrationError::Gauges {
                recording: recording.name().to_owned(),
                expected: self.gauges.clone(),
                actual: recording.gauge_names().to_vec(),
            })
        }
    }

    /// Applies the calibration to every sample of a recording, whose history starts with its first sample.
    ///
    /// # Errors
    /// [`CalibrationError::Gauges`] if the recording's gauges are not those that it was made for.
    pub fn apply(&self, recording: &Recording) -> Result<AppliedLoads, CalibrationError> {
        self.check_gauges(recording)?;
        let conventional = loads_from_gauges(&self.conventional, recording);
        let weights = self.distance.weights(&self.axes, &self.full_scale);
        let past =
            LoadPath::new(&conventional, &weights).past_samples(recording.times(), self.thresholds);
        let compensated = loads_from_history(&self.compensated, recording, &past);
        Ok(AppliedLoads {
            conventional,
            compensated,
            past,
        })
    }
}

/// The load of every sample from its present gauges, `n × n_axes` row-major.
pub(crate) fn loads_from_gauges(map: &LinearMap, recording: &Recording) -> Vec<f64> {
    let n_axes = map.matrix.len();
    let mut loads = vec![0.0; recording.n_samples() * n_axes];
    let samples = recording.gauges().chunks_exact(recording.n_gauges());
    for (gauges, load) in samples.zip(loads.chunks_exact_mut(n_axes)) {
        map.apply(gauges, &[], load);
    }
    loads
}

/// The load of every sample from its present and past gauges, `n × n_axes` row-major.
pub(crate) fn loads_from_history(map: &LinearMap, recording: &Recording, past: &[u32]) -> Vec<f64> {
    let n_axes = map.matrix.len();
    let mut loads = vec![0.0; recording.n_samples() * n_axes];
    for (k, load) in loads.chunks_exact_mut(n_axes).enumerate() {
        map.apply(
            recording.gauges_at(k),
            recording.gauges_at(past[k] as usize),
            load,
        );
    }
    loads
}

fn length(field: &str, expected: usize, actual: usize) -> Result<(), CalibrationError> {
    if expected == actual {
        Ok(())
    } else {
        Err(CalibrationError::Length {
            field: field.to_owned(),
            expected,
            actual,
        })
    }
}
