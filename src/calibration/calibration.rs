//! Calibration of a force/torque sensor: the result of a fit, with its errors on the recordings.
//!
//! Guarantees: the matrices of a [`Calibration`] from a fit or a file have matching shapes, and its numbers are finite. It
//! computes features and loads in the same way as the fit.

mod state_effects;
mod unloaded;

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    calibration::{
        coefficient_errors::CoefficientErrors,
        cross_validation::CrossValidation,
        error::CalibrationError,
        expected_error::ExpectedError,
        kernel::GridEdge,
        learned::{Learned, LearnedScratch},
        linear_map::{LinearMap, loads_from_gauges},
        no_cross_validation::NoCrossValidation,
        settings::{FitSettings, Regressor, RidgeChoice},
        sums::RowsOf,
        used_recording::UsedRecording,
    },
    features::{
        AuxiliaryChannel, Column, Design, FeatureSettings, FeatureStream, GaugeScale, LoadPath,
        named,
    },
    finding::{Finding, Id, Verdict},
    progress::Progress,
    recording::{Axis, Identity, Recording, SensorFrame, Tare, Weight, span},
    shown::counted,
};

/// Root mean squared errors of a calibration per axis, in the unit of the axis; `None` if there is no sample to score.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    pub train_rmse: Option<Vec<f64>>,
    pub test_rmse: Option<Vec<f64>>,
    /// Error in cross-validation: each group of training recordings is scored with a fit to the other groups; see
    /// [`CrossValidation`].
    pub cv_rmse: Option<Vec<f64>>,
}

/// Root mean squared errors of the manufacturer's calibration per axis; `None` if it lacks the axis or there is no sample.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FactoryScores {
    pub train_rmse: Vec<Option<f64>>,
    pub test_rmse: Vec<Option<f64>>,
    /// Constant that is added to the load of each axis if the recordings are not tared, in the unit of the axis.
    pub offsets: Vec<Option<f64>>,
}

/// Quality of a calibration on the training and test recordings of its fit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Quality {
    pub n_train: u64,
    pub n_test: u64,
    /// Scores of the conventional calibration, which uses the present sample alone.
    pub conventional: Scores,
    pub compensated: Scores,
    /// Rank of the linear fit: number of linearly independent feature columns.
    pub rank: usize,
    /// Condition number of the linear fit: ratio of the largest to the smallest singular value of the independent feature
    /// columns. The columns are standardised and scaled to unit length.
    pub condition: Option<f64>,
    /// Ridge strength of the linear fit per axis; empty if each feature block has a strength of its own.
    pub ridge: Vec<f64>,
    /// Which end of the range of tried ridge strengths was chosen for the kernel; `None` if the chosen strength is inside
    /// the range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel_ridge_edge: Option<GridEdge>,
    /// Two standard deviations of the compensated load; `None` if the regressor does not predict them. RMS per axis over the
    /// test samples, or over the training samples if there are no test samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ridge_by_block: Vec<BlockRidge>,
    /// Groups of recordings that cross-validation held out; `None` without cross-validation, or if the file does not contain
    /// them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cross_validation: Option<CrossValidation>,
    /// Standard errors of the coefficients of the compensated matrix; `None` without cross-validation or for a large matrix.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficients: Option<CoefficientErrors>,
    /// Expected error: on each axis, the value within which 95 % of the errors on further recordings should lie. `None` if
    /// too few groups were held out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_error: Option<ExpectedError>,
    /// Difference between the loads of runs that start at different samples: root mean square per axis; `None` if the history
    /// stores all samples, so that there is none. See [`scatter_of_starts`](crate::calibration::scatter_of_starts).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history_scatter: Option<Vec<f64>>,
    /// Effective number of coefficients after shrinkage by the ridge, on the axis with the most. Set by a linear fit, never
    /// stored in files.
    #[serde(skip)]
    pub free_coefficients: Option<f64>,
}

impl Quality {
    /// Returns the ridge strengths in words, or `None` without ridge.
    pub fn ridge_in_words(&self, axes: &[Axis]) -> Option<String> {
        let by_axis = |strengths: &[Option<f64>]| {
            let named = axes.iter().zip(strengths).map(|(axis, strength)| match strength {
                Some(strength) => format!("{axis} {strength:e}"),
                None => format!("{axis} removed"),
            });
            named.collect::<Vec<_>>().join(", ")
        };
        if !self.ridge_by_block.is_empty() {
            let blocks = self.ridge_by_block.iter();
            let blocks =
                blocks.map(|ridge| format!("{}: {}", ridge.block, by_axis(&ridge.strengths)));
            return Some(blocks.collect::<Vec<_>>().join("; "));
        }
        let is_shrunk = self.ridge.iter().any(|strength| *strength > 0.0);
        let strengths: Vec<Option<f64>> = self.ridge.iter().copied().map(Some).collect();
        is_shrunk.then(|| by_axis(&strengths))
    }
}

/// Ridge strengths of one feature block.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockRidge {
    pub block: String,
    /// Ridge strength per axis; `None` for an axis on which the block does not help and is removed.
    pub strengths: Vec<Option<f64>>,
}

/// Sizes of an undetermined fit: it has at most as many samples as coefficients, so it can pass through every sample.
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

/// Calibration of a sensor, which computes the load from the gauges. In a file, the matrix columns have names; see
/// [`Calibration::in_file`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Name of the file format, always [`FORMAT`](super::error::FORMAT).
    pub format: String,
    /// File version, at most [`VERSION`](super::error::VERSION).
    pub version: u32,
    /// Name and version of the program that made the calibration.
    pub program: String,
    /// True if the calibration was made from the built-in simulated sensor.
    pub simulated: bool,
    /// Identity of the sensor, and date, operator and reference of the calibration.
    #[serde(default, skip_serializing_if = "Identity::is_empty")]
    pub identity: Identity,
    /// Names of the gauges, in the order of the matrix columns.
    pub gauges: Vec<String>,
    /// Axes of the load, in the order of the matrix rows.
    pub axes: Vec<Axis>,
    /// Unit of each axis.
    pub units: Vec<String>,
    /// Full scale of each axis, in its unit.
    pub full_scale: Vec<f64>,
    /// True for each axis whose full scale is the rated load entered by the user; empty if no rated load was entered.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rated: Vec<bool>,
    /// True if the model adds a constant to the load of each axis.
    pub offset: bool,
    /// Decimation n of the fit: every n-th sample was used.
    pub decimation: usize,
    /// Longest time between samples that is not a pause (s).
    pub gap_secs: f64,
    /// Longest pause (s) after which a memory of feature blocks is kept, by the name of the memory; see
    /// [`measured_pauses`](crate::calibration::measured_pauses). After a longer pause, it starts anew. A memory that is missing
    /// starts anew after every pause.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub keep_secs: BTreeMap<String, f64>,
    /// Factors of the fade after a start, by the key of the feature block, one for each state. Each state has an unknown part
    /// (`Stream::missing`). Let u be the sum of these parts, each times its factor. The load is then the conventional load plus
    /// 1 / (1 + u²) of the difference between the compensated and the conventional load. Empty without a fade. See [`measured_fade`](crate::calibration::measured_fade).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub fade: BTreeMap<String, Vec<f64>>,
    /// Minimum time between the earlier samples that are stored for look-backs and lags (s).
    pub history_step_secs: f64,
    /// Largest load of each axis for which the calibration is valid: the greater of the rated load and the largest training
    /// load. Without a rated load, 1.2 times the largest training load. Zero or missing if unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<f64>,
    /// Minimum and maximum valid reading of each gauge; `None` for an unknown limit, empty if all limits are unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gauge_limits: Vec<(Option<f64>, Option<f64>)>,
    /// Features of the compensated load in addition to the present gauges, such as look-backs.
    pub features: FeatureSettings,
    /// Shift and scale that standardise the gauges. Play radii, monomials, networks and kernels refer to standardised gauges.
    pub gauge_scale: GaugeScale,
    /// Method that computes the compensated load from the features.
    #[serde(default)]
    pub regressor: Regressor,
    /// Conventional calibration: matrix that computes the load from the present gauges alone.
    pub conventional: LinearMap,
    /// Linear part of the compensated load; `None` if a network or kernel alone computes the load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compensated: Option<LinearMap>,
    /// Network or kernel whose prediction is added to the linear part; `None` for the linear regressor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learned: Option<Learned>,
    /// Errors on the training and test recordings, and other numbers that describe the quality of the fit.
    pub quality: Quality,
    /// Names of the training recordings.
    pub trained_on: Vec<String>,
    /// Median sample rate of the training recordings before decimation (Hz); `None` if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Names and checksums of the files of the training and test recordings; see
    /// [`with_sources`](crate::export::with_sources).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<UsedRecording>,
    /// Tare of the training recordings; `None` without tare. A tared calibration needs tared gauges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tare: Option<Tare>,
    /// Sensor frame in which the calibration gives loads; `None` if it gives them in the frame in which the reference was
    /// measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<SensorFrame>,
    /// Weight that the sensor carried in the training recordings, where poses gave its load; `None` if unknown. A robot that still
    /// carries it subtracts its weight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<Weight>,
}

/// Stands for an unknown limit: above every gauge reading and load, but within the range of single precision.
pub(crate) const NEVER_REACHED: f64 = 1e30;

/// Longest pause after which a memory can be kept (s), within the range of the 32-bit clock of exported code.
const LONGEST_KEPT_SECS: f64 = 1000.0;

/// Returns the default minimum time between stored earlier samples (s): about a third of the time between recorded samples.
/// So jitter drops no sample, and a robot that samples faster needs hardly more memory.
pub(crate) fn history_step_by_rate(rate_hz: Option<f64>) -> f64 {
    const UNKNOWN_RATE_HZ: f64 = 1000.0;
    // The factor 0.3137 is no simple fraction, so that rounding errors of the times do not decide which samples are stored.
    0.3137 / rate_hz.unwrap_or(UNKNOWN_RATE_HZ)
}

/// Loads that a calibration computes for a recording, `n × n_axes` row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct AppliedLoads {
    /// Loads by the conventional calibration, which uses the present gauges alone.
    pub conventional: Vec<f64>,
    /// Loads by the compensated calibration, which also uses the other features.
    pub compensated: Vec<f64>,
    /// For each look-back and each sample, the index of the earlier sample that the look-back found; its own index if none.
    pub past: Vec<Vec<u32>>,
}

impl Calibration {
    /// Returns the lowest and the highest valid readings of all gauges. An unknown limit is ± [`NEVER_REACHED`]. `None` if
    /// all limits are unknown.
    pub fn clipped_at(&self) -> Option<[Vec<f64>; 2]> {
        let ends = |end: fn(&(Option<f64>, Option<f64>)) -> f64| {
            self.gauge_limits.iter().map(end).collect()
        };
        let low = ends(|(low, _)| low.unwrap_or(-NEVER_REACHED));
        let high = ends(|(_, high)| high.unwrap_or(NEVER_REACHED));
        (!self.gauge_limits.is_empty()).then_some([low, high])
    }

    /// Returns true if any gauge reading is at or beyond the limits of its valid readings.
    pub fn has_gauge_beyond(&self, gauges: impl Iterator<Item = f64>) -> bool {
        // The comparison has a tolerance, because subtracting a tare and adding it again leaves rounding errors.
        let rounding = |limit: f64| 1e-12 * limit.abs();
        let mut limits = self.gauge_limits.iter().zip(gauges);
        limits.any(|((low, high), gauge)| {
            low.is_some_and(|low| gauge <= low + rounding(low))
                || high.is_some_and(|high| gauge >= high - rounding(high))
        })
    }

    /// Returns a sentence for each auxiliary channel (such as temperature) whose values in this recording leave the range of
    /// the training recordings.
    pub fn auxiliary_beyond(&self, recording: &Recording) -> Vec<String> {
        let Ok(prepared) = self.prepared(recording) else {
            return Vec::new();
        };
        let channels = self.features.auxiliary.iter();
        let outside = channels.zip(prepared.auxiliary().ranges()).filter(|(channel, range)| {
            channel.is_beyond(range.min) || channel.is_beyond(range.max)
        });
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

    /// Returns true if the value of an auxiliary channel lies outside the range of this channel in the training recordings.
    pub fn has_auxiliary_beyond(&self, auxiliary: &[f64]) -> bool {
        let mut channels = self.features.auxiliary.iter().zip(auxiliary);
        channels.any(|(channel, value)| channel.is_beyond(*value))
    }

    /// Returns a copy of the calibration with this identity of the sensor. Items that `identity` lacks keep their value.
    pub fn of_sensor(&self, identity: &Identity) -> Self {
        Self { identity: self.identity.with(identity), ..self.clone() }
    }

    /// Returns the full scales that are rated loads entered by the user (N, N·m).
    pub(crate) fn rated_loads(&self) -> BTreeMap<Axis, f64> {
        let all = self.axes.iter().zip(&self.full_scale).zip(&self.rated);
        all.filter(|(_, rated)| **rated).map(|((axis, load), _)| (*axis, *load)).collect()
    }

    /// Returns the settings of a fit that gives a calibration with these features.
    pub(crate) fn settings(&self) -> FitSettings {
        let is_whole = self.history_step_secs == history_step_by_rate(self.rate_hz);
        let rated = self.full_scale.iter().enumerate();
        let rated = rated.map(|(axis, load)| (*load, self.rated.get(axis) == Some(&true)));
        FitSettings {
            features: self.features.clone(),
            regressor: self.regressor,
            ridge: match self.quality.ridge[..] {
                [] => RidgeChoice::ByBlock,
                [first, ..] => RidgeChoice::Strength(first),
            },
            offset: self.offset,
            decimation: self.decimation,
            history_rate_hz: Some(if is_whole { 0.0 } else { 1.0 / self.history_step_secs }),
            full_scale: rated.map(|(load, is_rated)| is_rated.then_some(load)).collect(),
            ..FitSettings::default()
        }
    }

    /// Returns the column names of the compensated matrix, in order.
    pub fn feature_names(&self) -> Vec<String> {
        Column::names(&self.columns(), &self.gauges)
    }

    /// Returns the number of parameters: the nonzero coefficients, and the numbers of the network or kernel.
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

    /// Returns the design, which computes the feature rows of the compensated load.
    pub fn design(&self) -> Design {
        Design {
            features: self.features.clone(),
            scale: self.gauge_scale.clone(),
            offset: self.offset,
            history_step_secs: self.history_step_secs,
        }
    }

    /// Returns the weight of each axis in the load difference that the look-back compares with its force threshold F_th.
    pub fn distance_weights(&self) -> Vec<f64> {
        self.features.distance.weights(&self.axes, &self.full_scale)
    }

    /// Returns the median time between samples of the training recordings (s), if known.
    pub fn step_secs(&self) -> Option<f64> {
        self.rate_hz.map(f64::recip)
    }

    /// Returns the longest pause (s) after which this memory is kept; see [`Block::memory`](crate::features::Block::memory).
    pub(crate) fn keep_secs_of(&self, memory: &str) -> f64 {
        let secs = self.keep_secs.get(memory).copied().unwrap_or_default();
        secs.min(LONGEST_KEPT_SECS).max(self.gap_secs)
    }

    /// Returns the regressor and the features in words.
    pub fn describe(&self) -> String {
        let blocks = self.features.describe();
        let blocks = if blocks.is_empty() { "no history" } else { &blocks };
        match self.regressor {
            Regressor::Linear => blocks.to_owned(),
            regressor => format!("{}; {blocks}", regressor.label()),
        }
    }

    /// Returns the numbers of samples and coefficients if the fit has at most as many samples as coefficients; otherwise
    /// `None`.
    pub fn undetermined(&self) -> Option<Undetermined> {
        let (samples, coefficients) = (self.quality.n_train, self.design().n_columns());
        (samples > 0 && samples <= coefficients as u64)
            .then_some(Undetermined { samples, coefficients })
    }

    /// Returns the reason why there are no cross-validation errors; `None` if there are errors, or if there are no training
    /// samples.
    pub fn no_cross_validation(&self) -> Option<NoCrossValidation> {
        let is_known = self.quality.compensated.cv_rmse.is_some() || self.quality.n_train == 0;
        (!is_known).then(|| NoCrossValidation::of(self.regressor.learner()))
    }

    /// Returns the kernel's ridge strength and the end of the range of tried strengths at which it lies; `None` if it lies
    /// inside.
    pub(crate) fn kernel_ridge_at_edge(&self) -> Option<(GridEdge, f64)> {
        let Some(Learned::Kernel(kernel)) = &self.learned else {
            return None;
        };
        Some((self.quality.kernel_ridge_edge?, kernel.band.strength))
    }

    /// Returns the axes on which a hybrid regressor's network or kernel adds nothing to the linear part.
    pub(crate) fn linear_alone(&self) -> Vec<Axis> {
        let Some(learned) = self.learned.as_ref().filter(|_| self.regressor.is_hybrid()) else {
            return Vec::new();
        };
        let axes = self.axes.iter().enumerate();
        let silent = axes.filter(|(at, _)| learned.is_silent(*at));
        silent.map(|(_, axis)| *axis).collect()
    }

    /// Checks that a recording has the gauges of the calibration. The error is [`CalibrationError::Gauges`].
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

    /// Returns the recording as the calibration needs it: with tared or untared gauges, and with its auxiliary channels. The
    /// error is [`CalibrationError`] if the recording has other gauges or lacks a channel.
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
        let channels = || recording.auxiliary().names().iter().zip(recording.auxiliary().units());
        let is_there = |channel: &AuxiliaryChannel| {
            channels()
                .find(|(name, _)| **name == channel.name)
                .is_some_and(|(_, unit)| *unit == channel.unit)
        };
        if let Some(channel) = self.features.auxiliary.iter().find(|channel| !is_there(channel)) {
            let found: Vec<String> = channels().map(|(name, unit)| named(name, unit)).collect();
            return Err(CalibrationError::Auxiliary {
                recording: recording.name().to_owned(),
                channel: named(&channel.name, &channel.unit),
                found: found.join(", "),
            });
        }
        let picked = recording.with_auxiliary_of(&names);
        Ok(Cow::Owned(picked.expect("the recording has every channel")))
    }

    /// Computes the loads of every sample of a recording. All states start anew at its first sample. The error is
    /// [`CalibrationError`] if the gauges differ or an auxiliary channel is missing.
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

    /// Returns the compensated load of every sample, `n × n_axes` row-major. `past` is as in [`AppliedLoads::past`].
    pub(crate) fn compensated_loads(&self, recording: &Recording, past: &[Vec<u32>]) -> Vec<f64> {
        let mut loads = vec![0.0; recording.n_samples() * self.axes.len()];
        self.compensated_loads_from(&self.design(), recording, past, 0, &mut loads);
        loads
    }

    /// Returns true if the compensated load of a single sample can be computed fast, without all samples before it.
    pub(crate) fn is_quick_anywhere(&self) -> bool {
        self.learned.is_none() && !self.features.has_memory()
    }

    /// Computes the compensated loads of the samples from index `first` on, `n × n_axes` row-major. Unless `first` is zero,
    /// [`Self::is_quick_anywhere`] must be true.
    pub(crate) fn compensated_loads_from(
        &self,
        design: &Design,
        recording: &Recording,
        past: &[Vec<u32>],
        first: usize,
        loads: &mut [f64],
    ) {
        self.over_blocks(design, recording, past, first, loads, |rows, scratch, loads| {
            self.loads_of_rows(rows, scratch, loads);
        });
    }

    /// Returns the standard deviation of the compensated load, `n × n_axes` row-major; `None` if the regressor has none.
    pub(crate) fn deviations(&self, recording: &Recording, past: &[Vec<u32>]) -> Option<Vec<f64>> {
        let kernel = match &self.learned {
            Some(Learned::Kernel(kernel)) if kernel.has_band() => kernel,
            _ => return None,
        };
        let (design, mut out) = (self.design(), vec![0.0; recording.n_samples() * self.axes.len()]);
        self.over_blocks(&design, recording, past, 0, &mut out, |rows, scratch, out| {
            kernel.deviations(rows.inputs, &mut scratch.kernel, out);
        });
        Some(out)
    }

    /// Calls `take` once for each block of consecutive samples, with their rows, buffers, and the part of `out` for these
    /// samples.
    fn over_blocks(
        &self,
        design: &Design,
        recording: &Recording,
        past: &[Vec<u32>],
        first: usize,
        out: &mut [f64],
        take: impl Fn(Rows<'_>, &mut LearnedScratch, &mut [f64]),
    ) {
        let (mut stream, from) = (FeatureStream::new(design), RowsOf::of(recording));
        let (width, n_axes) = (design.n_columns(), self.axes.len());
        let mut raw = vec![0.0; BLOCK * width];
        let (mut inputs, mut scratch) = (Vec::new(), LearnedScratch::default());
        let (fade, mut shares) = (self.fade_of_states(), Vec::new());
        for (start, out) in (first..).step_by(BLOCK).zip(out.chunks_mut(BLOCK * n_axes)) {
            let raw = &mut raw[..out.len() / n_axes * width];
            inputs.clear();
            shares.clear();
            for (k, row) in (start..).zip(raw.chunks_exact_mut(width)) {
                from.raw_row(&mut stream, |at| past[at][k], k, row);
                if self.learned.is_some() {
                    learned_inputs(design, row, &mut inputs);
                }
                if !fade.is_empty() {
                    shares.push(stream.share(&fade));
                }
            }
            take(Rows { raw, inputs: &inputs, shares: &shares }, &mut scratch, out);
        }
    }

    /// Computes the compensated loads of samples from their rows.
    pub(crate) fn loads_of_rows(
        &self,
        rows: Rows<'_>,
        scratch: &mut LearnedScratch,
        loads: &mut [f64],
    ) {
        let n_axes = self.axes.len();
        let width = rows.raw.len() / (loads.len() / n_axes);
        match &self.compensated {
            Some(map) => map.apply_rows(rows.raw, width, loads),
            None => loads.fill(0.0),
        }
        if let Some(learned) = &self.learned {
            learned.add(rows.inputs, scratch, loads);
        }
        let mut conventional = vec![0.0; if rows.shares.is_empty() { 0 } else { n_axes }];
        let samples = rows.raw.chunks_exact(width).zip(loads.chunks_exact_mut(n_axes));
        for ((row, loads), share) in samples.zip(rows.shares) {
            self.conventional.apply(&row[..self.gauges.len()], &mut conventional);
            for (load, conventional) in loads.iter_mut().zip(&conventional) {
                *load = conventional + share * (*load - conventional);
            }
        }
    }
}

/// Feature rows of consecutive samples.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a> {
    /// Raw rows of the design matrix.
    pub raw: &'a [f64],
    /// Inputs of the network or kernel; empty if there is none.
    pub inputs: &'a [f64],
    /// Share of each sample in the fade, see [`FeatureStream::share`]; empty without a fade.
    pub shares: &'a [f64],
}

/// Number of samples whose feature rows are computed at a time.
const BLOCK: usize = 256;

/// Appends to `inputs` the inputs of a network or kernel for one sample: its standardised features without the offset column.
pub(crate) fn learned_inputs(design: &Design, raw: &[f64], inputs: &mut Vec<f64>) {
    let start = inputs.len();
    inputs.extend(raw);
    design.standardise(&mut inputs[start..]);
    inputs.truncate(start + raw.len() - usize::from(design.offset));
}

/// For each look-back, the index of the earlier sample that it found for each sample of a recording.
pub(crate) type Past = Vec<Vec<u32>>;

/// Returns, for each look-back, the index of the earlier sample that it finds for each sample. After cancellation, the
/// remaining samples get their own index, as if none was found.
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
