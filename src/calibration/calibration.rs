//! Calibration: the result of a fit, with its quality.
//!
//! Guarantees: a fitted or read [`Calibration`] has matching shapes and finite numbers, and applies as it was fitted.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::calibration::coefficient_errors::CoefficientErrors;
use crate::calibration::cross_validation::CrossValidation;
use crate::calibration::error::CalibrationError;
use crate::calibration::expected_error::ExpectedError;
use crate::calibration::kernel::GridEdge;
use crate::calibration::learned::{Learned, LearnedScratch};
use crate::calibration::linear_map::{LinearMap, loads_from_gauges};
use crate::calibration::no_cross_validation::NoCrossValidation;
use crate::calibration::settings::Regressor;
use crate::calibration::sums::RowsOf;
use crate::calibration::used_recording::UsedRecording;
use crate::features::{
    AuxiliaryChannel, Column, Design, FeatureSettings, FeatureStream, GaugeScale, LoadPath,
};
use crate::finding::{Finding, Id, Verdict};
use crate::progress::Progress;
use crate::recording::{Axis, Identity, Recording, Tare, span};
use crate::shown::counted;

/// Root mean squared errors per axis; `None` if there is nothing to score.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    pub train_rmse: Option<Vec<f64>>,
    pub test_rmse: Option<Vec<f64>>,
    /// Error on each group of training recordings with a fit to the others; see [`CrossValidation`].
    pub cv_rmse: Option<Vec<f64>>,
}

/// Errors of the manufacturer's calibration per axis; `None` if it lacks the axis, or nothing can be scored.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FactoryScores {
    pub train_rmse: Vec<Option<f64>>,
    pub test_rmse: Vec<Option<f64>>,
    /// Offset added on each axis because there is no tare, in the unit of the axis.
    pub offsets: Vec<Option<f64>>,
}

/// Quality of a calibration on the recordings from which it was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Quality {
    pub n_train: u64,
    pub n_test: u64,
    /// Scores of the conventional calibration, which uses the present sample alone.
    pub conventional: Scores,
    pub compensated: Scores,
    /// Number of independent features of the linear fit.
    pub rank: usize,
    /// Ratio of the largest to the smallest singular value of the independent columns, standardised and scaled to unit length.
    pub condition: Option<f64>,
    /// Ridge strength of the linear fit per axis; empty if each block has its own.
    pub ridge: Vec<f64>,
    /// End of the range of candidates at which the kernel's ridge lies, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel_ridge_edge: Option<GridEdge>,
    /// Two standard deviations around the compensated load, if known: RMS per axis over test (else training) samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ridge_by_block: Vec<BlockRidge>,
    /// Groups held out in cross-validation; `None` if there was none, or the file does not contain it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cross_validation: Option<CrossValidation>,
    /// Standard errors of the compensated matrix, if there is a cross-validation and the matrix is not too large.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficients: Option<CoefficientErrors>,
    /// Value within which 95 % of the held-out errors lie, if enough groups were held out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_error: Option<ExpectedError>,
    /// Effective number of coefficients with the ridge, for the axis with most. Set by a linear fit, never stored in files.
    #[serde(skip)]
    pub free_coefficients: Option<f64>,
}

impl Quality {
    /// Returns a description of the ridge, or `None` without ridge.
    pub fn ridge_in_words(&self, axes: &[Axis]) -> Option<String> {
        let by_axis = |texts: &mut dyn Iterator<Item = String>| {
            let named = axes.iter().zip(texts);
            let named = named.map(|(axis, text)| format!("{axis} {text}"));
            named.collect::<Vec<_>>().join(", ")
        };
        if !self.ridge_by_block.is_empty() {
            let blocks = self.ridge_by_block.iter().map(|own| {
                let text = |strength: &Option<f64>| match strength {
                    Some(strength) => format!("{strength:e}"),
                    None => "removed".to_owned(),
                };
                let strengths = by_axis(&mut own.strengths.iter().map(text));
                format!("{}: {strengths}", own.block)
            });
            return Some(blocks.collect::<Vec<_>>().join("; "));
        }
        let is_shrunk = self.ridge.iter().any(|strength| *strength > 0.0);
        let mut strengths = self.ridge.iter().map(|strength| format!("{strength:e}"));
        is_shrunk.then(|| by_axis(&mut strengths))
    }
}

/// Ridge of one block, described in words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockRidge {
    pub block: String,
    /// Strength per axis; `None` if the block does not help and is removed.
    pub strengths: Vec<Option<f64>>,
}

/// A fit with no more samples than coefficients, which could pass through every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undetermined {
    pub samples: u64,
    pub coefficients: usize,
}

impl Undetermined {
    pub(crate) fn finding(&self) -> Finding {
        let Self { samples, coefficients } = self;
        let samples = counted(*samples as usize, "training sample");
        let seen = format!("only {samples} for {coefficients} coefficients per axis");
        Finding::new(Id::Undetermined, Verdict::Insufficient, seen)
    }
}

/// Calibration that can be saved, read and applied. In a file, columns have names; see [`Calibration::in_file`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Always [`FORMAT`](super::error::FORMAT).
    pub format: String,
    /// File version, at most [`VERSION`](super::error::VERSION).
    pub version: u32,
    /// Program that made the calibration.
    pub program: String,
    /// True if the calibration was made from the built-in simulated sensor.
    pub simulated: bool,
    /// Identity of the sensor, and date, operator and reference of the calibration.
    #[serde(default, skip_serializing_if = "Identity::is_empty")]
    pub identity: Identity,
    /// Gauge names in column order.
    pub gauges: Vec<String>,
    /// Axes in row order.
    pub axes: Vec<Axis>,
    /// The unit of each axis.
    pub units: Vec<String>,
    /// The full scale of each axis, in its unit.
    pub full_scale: Vec<f64>,
    /// True for each axis whose full scale is the rated load entered by the user; empty if none is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rated: Vec<bool>,
    /// True if the model has an offset term.
    pub offset: bool,
    /// Decimation: every n-th sample was used.
    pub decimation: usize,
    /// Gap length (s). After a longer step the history starts anew.
    pub gap_secs: f64,
    /// Minimum time between samples kept for look-backs and lags (s).
    pub history_step_secs: f64,
    /// Largest known load of each axis: the rated load, else 1.2 times the largest training load. Zero or missing if unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<f64>,
    /// Range of valid readings of each gauge; `None` for an unknown limit, empty if all are unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gauge_limits: Vec<(Option<f64>, Option<f64>)>,
    /// Features that are appended to the gauges.
    pub features: FeatureSettings,
    /// Standardisation of gauges for play radii, monomials and nonlinear regressors.
    pub gauge_scale: GaugeScale,
    /// Regressor of the compensated load.
    #[serde(default)]
    pub regressor: Regressor,
    /// Conventional calibration: the load from the present gauges.
    pub conventional: LinearMap,
    /// Linear part of the compensated load; `None` for a network or kernel without linear stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compensated: Option<LinearMap>,
    /// Network or kernel that is added to the linear part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learned: Option<Learned>,
    /// Quality on the recordings of the fit.
    pub quality: Quality,
    /// Names of the training recordings.
    pub trained_on: Vec<String>,
    /// Median sample rate of the training recordings before decimation (Hz); `None` if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Files of training and test recordings, if read again; see [`with_sources`](crate::export::with_sources).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<UsedRecording>,
    /// Tare of the training recordings. If there is one, gauges must also be tared before the calibration is applied.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tare: Option<Tare>,
}

/// Value beyond every gauge reading and every load, in the range of single precision.
pub(crate) const NEVER_REACHED: f64 = 1e30;

/// Returns the default minimum time between kept samples (s), a third of the recordings' step: jitter drops no sample, and
/// a robot that samples faster needs no more memory.
pub(crate) fn history_step_by_rate(rate_hz: Option<f64>) -> f64 {
    const UNKNOWN_RATE_HZ: f64 = 1000.0;
    // The factor is no simple fraction, so rounding of times cannot decide which samples are kept.
    0.3137 / rate_hz.unwrap_or(UNKNOWN_RATE_HZ)
}

/// Loads that a calibration computes for a recording, `n × n_axes` row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct AppliedLoads {
    /// Load from the present gauges.
    pub conventional: Vec<f64>,
    /// Load with history and regressor.
    pub compensated: Vec<f64>,
    /// Past sample of each sample for each look-back, or its own index if there is none.
    pub past: Vec<Vec<u32>>,
}

impl Calibration {
    /// Returns the mean over the axes of the error in cross-validation, as a share of full scale.
    pub fn mean_cv_share(&self) -> Option<f64> {
        self.mean_share(self.quality.compensated.cv_rmse.as_ref()?)
    }

    /// Returns the mean over the axes of the error on the training recordings, as a share of full scale.
    pub fn mean_train_share(&self) -> Option<f64> {
        self.mean_share(self.quality.compensated.train_rmse.as_ref()?)
    }

    fn mean_share(&self, errors: &[f64]) -> Option<f64> {
        let shares = errors.iter().zip(&self.full_scale).filter(|(_, scale)| **scale > 0.0);
        let shares: Vec<f64> = shares.map(|(error, scale)| error / scale).collect();
        (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
    }

    /// Returns the lower and upper clipping limits of all gauges ([`NEVER_REACHED`] if unknown), or `None` if all are unknown.
    pub fn clipped_at(&self) -> Option<[Vec<f64>; 2]> {
        let ends = |end: fn(&(Option<f64>, Option<f64>)) -> f64| {
            self.gauge_limits.iter().map(end).collect()
        };
        let low = ends(|(low, _)| low.unwrap_or(-NEVER_REACHED));
        let high = ends(|(_, high)| high.unwrap_or(NEVER_REACHED));
        (!self.gauge_limits.is_empty()).then_some([low, high])
    }

    /// Returns true if a gauge reading is at or beyond its limits.
    pub fn has_gauge_beyond(&self, gauges: impl Iterator<Item = f64>) -> bool {
        // Subtracting a tare and adding it again causes rounding errors.
        let rounding = |limit: f64| 1e-12 * limit.abs();
        let mut limits = self.gauge_limits.iter().zip(gauges);
        limits.any(|((low, high), gauge)| {
            low.is_some_and(|low| gauge <= low + rounding(low))
                || high.is_some_and(|high| gauge >= high - rounding(high))
        })
    }

    /// Returns a sentence for each auxiliary channel that leaves its training range in this recording.
    pub fn auxiliary_beyond(&self, recording: &Recording) -> Vec<String> {
        let Ok(prepared) = self.prepared(recording) else {
            return Vec::new();
        };
        let channels = self.features.auxiliary.iter();
        let outside = channels
            .zip(prepared.auxiliary().ranges())
            .filter(|(channel, own)| channel.is_beyond(own.min) || channel.is_beyond(own.max));
        outside
            .map(|(channel, range)| {
                format!(
                    "{} of {} is {}, but the training recordings cover {}",
                    channel.name,
                    recording.name(),
                    span(range, &channel.unit),
                    channel.trained()
                )
            })
            .collect()
    }

    /// Returns true if an auxiliary channel is outside its training range.
    pub fn has_auxiliary_beyond(&self, auxiliary: &[f64]) -> bool {
        let mut channels = self.features.auxiliary.iter().zip(auxiliary);
        channels.any(|(channel, value)| channel.is_beyond(*value))
    }

    /// Returns the calibration with the identity entered by the user. Items that were not entered keep their value.
    pub fn of_sensor(&self, identity: &Identity) -> Self {
        Self { identity: self.identity.with(identity), ..self.clone() }
    }

    /// Returns the full scales that are rated loads entered by the user (N, N·m).
    pub(crate) fn rated_loads(&self) -> BTreeMap<Axis, f64> {
        let all = self.axes.iter().zip(&self.full_scale).zip(&self.rated);
        all.filter(|(_, rated)| **rated).map(|((axis, load), _)| (*axis, *load)).collect()
    }

    /// Returns the column names of the compensated matrix, in order.
    pub fn feature_names(&self) -> Vec<String> {
        Column::names(&self.columns(), &self.gauges)
    }

    /// Returns the number of parameters: nonzero coefficients, and numbers of the network or kernel.
    pub fn n_coefficients(&self) -> usize {
        let maps = self.compensated.iter().chain([&self.conventional]);
        let linear =
            maps.map(|map| map.matrix.iter().flatten().filter(|number| **number != 0.0).count());
        let learned = self.learned.as_ref().map_or(0, Learned::n_numbers);
        linear.sum::<usize>() + learned
    }

    /// Returns the columns of the compensated matrix.
    pub fn columns(&self) -> Vec<Column> {
        self.features.columns(self.gauges.len(), self.offset)
    }

    /// Returns the design of the compensated load.
    pub fn design(&self) -> Design {
        Design {
            features: self.features.clone(),
            scale: self.gauge_scale.clone(),
            offset: self.offset,
            history_step_secs: self.history_step_secs,
        }
    }

    /// Returns the weight of each axis in the distance of the look-back.
    pub fn distance_weights(&self) -> Vec<f64> {
        self.features.distance.weights(&self.axes, &self.full_scale)
    }

    /// Returns the sampling step of the training recordings (s), if known.
    pub fn step_secs(&self) -> Option<f64> {
        self.rate_hz.map(f64::recip)
    }

    /// Returns a description of regressor and features.
    pub fn describe(&self) -> String {
        let blocks = self.features.describe();
        let blocks = if blocks.is_empty() { "no history" } else { &blocks };
        match self.regressor {
            Regressor::Linear => blocks.to_owned(),
            regressor => format!("{}; {blocks}", regressor.label()),
        }
    }

    /// Returns the numbers of samples and coefficients of an undetermined fit; `None` for a determined one.
    pub fn undetermined(&self) -> Option<Undetermined> {
        let (samples, coefficients) = (self.quality.n_train, self.design().n_columns());
        (samples > 0 && samples <= coefficients as u64)
            .then_some(Undetermined { samples, coefficients })
    }

    /// Returns the reason why there are no cross-validation scores; `None` if there are scores, or the fit was not made here.
    pub fn no_cross_validation(&self) -> Option<NoCrossValidation> {
        let is_known = self.quality.compensated.cv_rmse.is_some() || self.quality.n_train == 0;
        (!is_known).then(|| NoCrossValidation::of(self.regressor.learner()))
    }

    /// Returns the kernel's ridge if it lies at an end of the range of candidates, and which end.
    pub(crate) fn kernel_ridge_at_edge(&self) -> Option<(GridEdge, f64)> {
        let Some(Learned::Kernel(kernel)) = &self.learned else {
            return None;
        };
        Some((self.quality.kernel_ridge_edge?, kernel.band.strength))
    }

    /// Returns the axes on which the second stage adds nothing to the linear stage.
    pub(crate) fn linear_alone(&self) -> Vec<Axis> {
        let Some(learned) = self.learned.as_ref().filter(|_| self.regressor.is_hybrid()) else {
            return Vec::new();
        };
        let axes = self.axes.iter().enumerate();
        let silent = axes.filter(|(at, _)| learned.is_silent(*at));
        silent.map(|(_, axis)| *axis).collect()
    }

    /// Checks that a recording has the gauges of the calibration; otherwise the error is [`CalibrationError::Gauges`].
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

    /// Returns the recording with only the auxiliary channels of the calibration, and with gauges tared as in it. The error is
    /// [`CalibrationError`] if the recording has other gauges or lacks a channel.
    pub fn prepared<'a>(
        &self,
        recording: &'a Recording,
    ) -> Result<Cow<'a, Recording>, CalibrationError> {
        self.check_gauges(recording)?;
        Ok(self.with_own_zero(self.with_own_auxiliary(recording)?))
    }

    fn with_own_auxiliary<'a>(
        &self,
        recording: &'a Recording,
    ) -> Result<Cow<'a, Recording>, CalibrationError> {
        let names = self.features.auxiliary_names();
        if names.is_empty() {
            return Ok(Cow::Borrowed(recording));
        }
        let own = recording.auxiliary();
        let own: Vec<String> =
            (own.names().iter().zip(own.units())).map(|(name, unit)| named(name, unit)).collect();
        let refused = |channel: &AuxiliaryChannel| CalibrationError::Auxiliary {
            recording: recording.name().to_owned(),
            channel: named(&channel.name, &channel.unit),
            found: own.join(", "),
        };
        let channels = &self.features.auxiliary;
        let picked = recording.with_auxiliary_of(&names).map_err(|missing| {
            let channel = channels.iter().find(|channel| channel.name == missing);
            refused(channel.expect("a channel has this name"))
        })?;
        let units = channels.iter().zip(picked.auxiliary().units());
        let other = units.into_iter().find(|(channel, unit)| channel.unit != **unit);
        match other {
            Some((channel, _)) => Err(refused(channel)),
            None => Ok(Cow::Owned(picked)),
        }
    }

    /// Applies the calibration to every sample of a recording, whose first sample starts the history. The error is
    /// [`CalibrationError`] if the gauges differ, or an auxiliary channel is missing.
    pub fn apply(&self, recording: &Recording) -> Result<AppliedLoads, CalibrationError> {
        let recording = &*self.prepared(recording)?;
        let conventional = loads_from_gauges(&self.conventional, recording);
        let n_axes = self.axes.len();
        let path = LoadPath::with_history_step(
            recording.times(),
            &|k, axis| conventional[k * n_axes + axis],
            &self.distance_weights(),
            self.history_step_secs,
        );
        let past = past_samples(&self.features, &path, recording, &Progress::default());
        let compensated = self.compensated_loads(recording, &past);
        Ok(AppliedLoads { conventional, compensated, past })
    }

    /// Returns the compensated load of every sample, `n × n_axes` row-major.
    pub(crate) fn compensated_loads(&self, recording: &Recording, past: &[Vec<u32>]) -> Vec<f64> {
        let design = self.design();
        let mut loads = vec![0.0; recording.n_samples() * self.axes.len()];
        let stream = FeatureStream::new(&design);
        let take = Self::loads_of_rows;
        self.over_blocks(stream, recording, past, 0, &mut loads, take);
        loads
    }

    /// Returns true if the load of any sample can be computed quickly and without earlier samples.
    pub(crate) fn is_quick_anywhere(&self) -> bool {
        self.learned.is_none() && !self.features.has_memory()
    }

    /// Computes the compensated loads of some samples, `n × n_axes` row-major. Requires [`Self::is_quick_anywhere`].
    pub(crate) fn compensated_loads_of(
        &self,
        design: &Design,
        recording: &Recording,
        past: &[Vec<u32>],
        samples: Range<usize>,
        loads: &mut [f64],
    ) {
        let stream = FeatureStream::new(design);
        let take = Self::loads_of_rows;
        self.over_blocks(stream, recording, past, samples.start, loads, take);
    }

    /// Returns the standard deviation around the compensated load, `n × n_axes` row-major, if the regressor gives it.
    pub(crate) fn deviations(&self, recording: &Recording, past: &[Vec<u32>]) -> Option<Vec<f64>> {
        let learned = self.learned.as_ref().filter(|learned| learned.knows_deviation())?;
        let n_axes = self.axes.len();
        let design = self.design();
        let mut deviations = vec![0.0; recording.n_samples() * n_axes];
        let stream = FeatureStream::new(&design);
        let take =
            |_: &Self, _: &[f64], inputs: &[f64], scratch: &mut LearnedScratch, out: &mut [f64]| {
                learned.deviations(inputs, scratch, out, n_axes);
            };
        self.over_blocks(stream, recording, past, 0, &mut deviations, take);
        Some(deviations)
    }

    /// Calls `take` once for each block of samples. Its arguments are the block's raw rows, the inputs of the network or kernel if
    /// there is one, buffers, and the part of `out` that belongs to the block.
    fn over_blocks(
        &self,
        mut stream: FeatureStream<'_>,
        recording: &Recording,
        past: &[Vec<u32>],
        first: usize,
        out: &mut [f64],
        take: impl Fn(&Self, &[f64], &[f64], &mut LearnedScratch, &mut [f64]),
    ) {
        let (design, from, n_axes) = (stream.design(), RowsOf::of(recording), self.axes.len());
        let width = design.n_columns();
        let mut raw = vec![0.0; BLOCK * width];
        let (mut inputs, mut scratch) = (Vec::new(), LearnedScratch::default());
        for (start, out) in (first..).step_by(BLOCK).zip(out.chunks_mut(BLOCK * n_axes)) {
            let raw = &mut raw[..out.len() / n_axes * width];
            inputs.clear();
            for (k, row) in (start..).zip(raw.chunks_exact_mut(width)) {
                from.raw_row(&mut stream, |at| past[at][k], k, row);
                if self.learned.is_some() {
                    learned_inputs(design, row, &mut inputs);
                }
            }
            take(self, raw, &inputs, &mut scratch, out);
        }
    }

    /// Computes compensated loads from features. All other functions use this one.
    pub(crate) fn loads_of_rows(
        &self,
        raw: &[f64],
        inputs: &[f64],
        scratch: &mut LearnedScratch,
        loads: &mut [f64],
    ) {
        let n_axes = self.axes.len();
        match &self.compensated {
            Some(map) => {
                map.apply_rows(raw, map.columns.len(), loads);
            }
            None => loads.fill(0.0),
        }
        if let Some(learned) = &self.learned {
            learned.add(inputs, scratch, loads, n_axes);
        }
    }
}

fn named(name: &str, unit: &str) -> String {
    match unit {
        "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    }
}

/// Number of rows computed at a time.
const BLOCK: usize = 256;

/// Appends the standardised features without offset, the inputs of networks and kernels.
pub(crate) fn learned_inputs(design: &Design, raw: &[f64], inputs: &mut Vec<f64>) {
    let start = inputs.len();
    inputs.extend(raw);
    design.standardise(&mut inputs[start..]);
    inputs.truncate(start + raw.len() - usize::from(design.offset));
}

/// Past samples of a recording, one list for each look-back.
pub(crate) type Past = Vec<Vec<u32>>;

/// Returns the past samples. After cancellation, the remaining samples have none.
pub(crate) fn past_samples(
    features: &FeatureSettings,
    path: &LoadPath,
    recording: &Recording,
    progress: &Progress,
) -> Past {
    features
        .look_backs
        .iter()
        .map(|thresholds| path.past_samples_until(recording.times(), *thresholds, progress))
        .collect()
}
