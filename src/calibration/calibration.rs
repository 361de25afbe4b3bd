//! What a fit leaves behind: matrices, blocks, what was learned, and how good it is.
//!
//! Guarantees: a [`Calibration`] that exists is whole (shapes match, every number finite), whether it was fitted or
//! read; applied to a recording it gives the numbers that the fit gave.

use std::borrow::Cow;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::calibration::coefficient_errors::CoefficientErrors;
use crate::calibration::cross_validation::CrossValidation;
use crate::calibration::error::CalibrationError;
use crate::calibration::expected_error::ExpectedError;
use crate::calibration::kernel::GridEdge;
use crate::calibration::learned::{Learned, LearnedScratch};
use crate::calibration::linear_map::{LinearMap, loads_from_gauges};
use crate::calibration::settings::Regressor;
use crate::calibration::sums::RowsOf;
use crate::calibration::used_recording::UsedRecording;
use crate::features::{
    AuxiliaryChannel, Column, Design, FeatureSettings, FeatureStream, GaugeScale, LoadPath,
};
use crate::finding::{Finding, Id, Verdict};
use crate::progress::Progress;
use crate::recording::{Axis, Identity, Recording, Tare, span};

/// Root mean squared errors per axis; `None` where nothing could be scored.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// On the recordings that were fitted.
    pub train_rmse: Option<Vec<f64>>,
    /// On the recordings in the test role.
    pub test_rmse: Option<Vec<f64>>,
    /// Each group of training recordings scored by a fit to the others; see [`CrossValidation`].
    pub cv_rmse: Option<Vec<f64>>,
}

/// How the calibration that a sensor came with does on the recordings that another was made with.
///
/// **Shapes** one entry per axis; `None` where the factory's calibration lacks it, or nothing could be scored.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FactoryScores {
    /// RMSE over the training recordings.
    pub train_rmse: Vec<Option<f64>>,
    /// RMSE over the test recordings.
    pub test_rmse: Vec<Option<f64>>,
    /// What was added for want of a tare, in the axis' unit.
    pub offsets: Vec<Option<f64>>,
}

/// How good a calibration was on the recordings it was made with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Quality {
    /// Samples that were fitted.
    pub n_train: u64,
    /// Samples in the test role.
    pub n_test: u64,
    /// With the present sample alone.
    pub conventional: Scores,
    /// With what the blocks and the regressor add.
    pub compensated: Scores,
    /// How many of the linear fit's features are independent.
    pub rank: usize,
    /// Largest over smallest singular value of the independent columns of the linear fit, standardised and each scaled
    /// to unit length; `None` where no column is independent.
    pub condition: Option<f64>,
    /// The strength of the linear fit's ridge, per axis; empty where each block has its own.
    pub ridge: Vec<f64>,
    /// Whether the kernel's ridge stands at an end of what is tried.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel_ridge_edge: Option<GridEdge>,
    /// Two standard deviations of the load around the compensated one, as far as the regressor knows them: root mean square
    /// over the test samples, or without any over the training samples, per axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<Vec<f64>>,
    /// Where each block has a ridge of its own: what was chosen.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ridge_by_block: Vec<BlockRidge>,
    /// What was left out in turn; `None` where nothing was, or whoever wrote it did not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cross_validation: Option<CrossValidation>,
    /// How certain the coefficients of the compensated matrix are, where parts were left out and it has not too many.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficients: Option<CoefficientErrors>,
    /// Value within which 95 % of the held-out errors lie, where enough groups were held out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_error: Option<ExpectedError>,
    /// How many coefficients are free, with the ridge, on the axis with most, right after a linear fit; no file keeps it.
    #[serde(skip)]
    pub free_coefficients: Option<f64>,
}

impl Quality {
    /// The ridge in words; `None` where nothing is shrunk.
    pub fn ridge_in_words(&self, axes: &[Axis]) -> Option<String> {
        let by_axis = |texts: &mut dyn Iterator<Item = String>| {
            let named = axes.iter().zip(texts);
            let named = named.map(|(axis, text)| format!("{} {text}", axis.symbol()));
            named.collect::<Vec<_>>().join(", ")
        };
        if !self.ridge_by_block.is_empty() {
            let blocks = self.ridge_by_block.iter().map(|own| {
                let text = |strength: &Option<f64>| match strength {
                    Some(strength) => format!("{strength:e}"),
                    None => "left away".to_owned(),
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

/// How one block is shrunk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockRidge {
    /// The block in words.
    pub block: String,
    /// The strength per axis; `None` where the block does not help and is left away.
    pub strengths: Vec<Option<f64>>,
}

/// A fit that could go through every sample it was made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undetermined {
    /// Samples that were fitted.
    pub samples: u64,
    /// Coefficients of each axis.
    pub coefficients: usize,
}

impl Undetermined {
    /// What it does to the calibration.
    pub(crate) fn finding(&self) -> Finding {
        let Self { samples, coefficients } = self;
        let seen =
            format!("only {samples} training samples for {coefficients} coefficients of each axis");
        Finding::new(Id::Undetermined, Verdict::Insufficient, seen)
    }
}

/// A calibration that can be saved, read and applied.
///
/// Its maps know their columns by what they are. In a file the columns have names instead: see [`Calibration::in_file`].
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
    /// Which sensor it is of, who calibrated it, when, and against what.
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
    /// Whether that of each axis is the rated load, which the user entered; empty where none is entered.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rated: Vec<bool>,
    /// Whether the model has an offset term.
    pub offset: bool,
    /// Every how many-th sample was fitted.
    pub decimation: usize,
    /// A longer step than this is a gap (s): after it the history starts anew.
    pub gap_secs: f64,
    /// Look-backs and lags keep no samples that are closer to each other than this (s).
    pub history_step_secs: f64,
    /// The load of each axis, in its unit, beyond which nothing is known of the sensor: the rated one where the user entered it,
    /// else a fifth above the largest that it was fitted to; zero or
    /// missing where it is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<f64>,
    /// Between which values each gauge is to be believed; `None` at an end where that is not known, empty where it is of no gauge.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gauge_limits: Vec<(Option<f64>, Option<f64>)>,
    /// What is appended to the gauges.
    pub features: FeatureSettings,
    /// How gauges are standardised: for play radii, monomials, and what was learned.
    pub gauge_scale: GaugeScale,
    /// How the compensated load is made of the features.
    #[serde(default)]
    pub regressor: Regressor,
    /// The load from the present gauges.
    pub conventional: LinearMap,
    /// The linear part of the compensated load; none for a network or a kernel that stands alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compensated: Option<LinearMap>,
    /// What a network or a kernel adds to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learned: Option<Learned>,
    /// How good it was.
    pub quality: Quality,
    /// Names of the training recordings.
    pub trained_on: Vec<String>,
    /// The median of the training recordings' rates, before decimation (Hz); `None` where it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// The files of the training and test recordings, as far as they were looked at; see
    /// [`with_sources`](crate::export::with_sources).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<UsedRecording>,
    /// How their gauges were tared; gauges that it is applied to must be tared, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tare: Option<Tare>,
}

/// No gauge and no load is as great; single precision has it.
pub(crate) const NEVER_REACHED: f64 = 1e30;

/// How far apart kept samples are at least where nobody says (s): a third of a step of recordings of this rate, so that jitter
/// drops none of them, and the memory of a robot that samples faster stays what these recordings need.
pub(crate) fn history_step_by_rate(rate_hz: Option<f64>) -> f64 {
    const UNKNOWN_RATE_HZ: f64 = 1000.0;
    // No simple fraction: the last digits of no clock decide.
    0.3137 / rate_hz.unwrap_or(UNKNOWN_RATE_HZ)
}

/// What a calibration makes of a recording.
///
/// **Shapes** loads `n × n_axes` row-major; `past` one index per sample for each look-back.
#[derive(Clone, Debug, PartialEq)]
pub struct AppliedLoads {
    /// Conv.: from the present gauges.
    pub conventional: Vec<f64>,
    /// Comp.: with what the blocks and the regressor add.
    pub compensated: Vec<f64>,
    /// The past sample of each sample; its own index where there is none.
    pub past: Vec<Vec<u32>>,
}

impl Calibration {
    /// Where each gauge is clipped, below and above, with what no gauge reaches where that is not known; `None` where it is known of none.
    pub fn clipped_at(&self) -> Option<[Vec<f64>; 2]> {
        let ends = |end: fn(&(Option<f64>, Option<f64>)) -> f64| {
            self.gauge_limits.iter().map(end).collect()
        };
        let low = ends(|(low, _)| low.unwrap_or(-NEVER_REACHED));
        let high = ends(|(_, high)| high.unwrap_or(NEVER_REACHED));
        (!self.gauge_limits.is_empty()).then_some([low, high])
    }

    /// Whether a gauge shows what it is not to be believed.
    pub fn has_gauge_beyond(&self, gauges: impl Iterator<Item = f64>) -> bool {
        // What a tare took off and is put back rounds.
        let rounding = |limit: f64| 1e-12 * limit.abs();
        let mut limits = self.gauge_limits.iter().zip(gauges);
        limits.any(|((low, high), gauge)| {
            low.is_some_and(|low| gauge <= low + rounding(low))
                || high.is_some_and(|high| gauge >= high - rounding(high))
        })
    }

    /// What auxiliary channels of a recording show that was not trained, in sentences.
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
                    "{} of {} is {}, and was trained from {}",
                    channel.name,
                    recording.name(),
                    span(range, &channel.unit),
                    channel.trained()
                )
            })
            .collect()
    }

    /// Whether an auxiliary channel shows what was not trained.
    pub fn has_auxiliary_beyond(&self, auxiliary: &[f64]) -> bool {
        let mut channels = self.features.auxiliary.iter().zip(auxiliary);
        channels.any(|(channel, value)| channel.is_beyond(*value))
    }

    /// This calibration with the identity that the user entered; what it knows stays where nothing is entered.
    pub fn of_sensor(&self, identity: &Identity) -> Self {
        Self { identity: self.identity.with(identity), ..self.clone() }
    }

    /// The names of the columns of the compensated matrix, in order.
    pub fn feature_names(&self) -> Vec<String> {
        Column::names(&self.columns(), &self.gauges)
    }

    /// How many numbers a load is made with: coefficients that are not zero, and what was learned.
    pub fn n_coefficients(&self) -> usize {
        let maps = self.compensated.iter().chain([&self.conventional]);
        let linear =
            maps.map(|map| map.matrix.iter().flatten().filter(|number| **number != 0.0).count());
        let learned = self.learned.as_ref().map_or(0, Learned::n_numbers);
        linear.sum::<usize>() + learned
    }

    /// What the columns of the compensated matrix are.
    pub fn columns(&self) -> Vec<Column> {
        self.features.columns(self.gauges.len(), self.offset)
    }

    /// The rows that the compensated load is made of.
    pub fn design(&self) -> Design {
        Design {
            features: self.features.clone(),
            scale: self.gauge_scale.clone(),
            offset: self.offset,
            history_step_secs: self.history_step_secs,
        }
    }

    /// What the look-back multiplies the difference on each axis with.
    pub fn distance_weights(&self) -> Vec<f64> {
        self.features.distance.weights(&self.axes, &self.full_scale)
    }

    /// The step of the training recordings (s), where it is known.
    pub fn step_secs(&self) -> Option<f64> {
        self.rate_hz.map(f64::recip)
    }

    /// The regressor and the blocks in words.
    pub fn describe(&self) -> String {
        let blocks = self.features.describe();
        let blocks = if blocks.is_empty() { "no history" } else { &blocks };
        match self.regressor {
            Regressor::Linear => blocks.to_owned(),
            regressor => format!("{}; {blocks}", regressor.label()),
        }
    }

    /// Whether it was fitted to no more samples than it has coefficients.
    pub fn undetermined(&self) -> Option<Undetermined> {
        let (samples, coefficients) = (self.quality.n_train, self.design().n_columns());
        (samples > 0 && samples <= coefficients as u64)
            .then_some(Undetermined { samples, coefficients })
    }

    /// Why there are no scores of left-out recordings, where there are none though it was fitted.
    pub fn why_not_left_out(&self) -> Option<&'static str> {
        if self.quality.compensated.cv_rmse.is_some() || self.quality.n_train == 0 {
            return None;
        }
        Some(match self.learned {
            Some(Learned::Network(_)) => {
                "the network was not cross-validated: nobody asked for it, or it was stopped, or too little is left without a \
                 part"
            }
            Some(Learned::Kernel(_)) => {
                "the cross-validation was stopped, or too little is left to fit without a part"
            }
            None => {
                "there are too few training samples: without a part of them, fewer remain than there are coefficients"
            }
        })
    }

    /// The kernel's ridge and where it stands, if that is at an end of what is tried.
    pub(crate) fn kernel_ridge_at_edge(&self) -> Option<(GridEdge, f64)> {
        let Some(Learned::Kernel(kernel)) = &self.learned else {
            return None;
        };
        Some((self.quality.kernel_ridge_edge?, kernel.band.strength))
    }

    /// The axes on which a second stage adds nothing to the linear one.
    pub(crate) fn linear_alone(&self) -> Vec<Axis> {
        let Some(learned) = self.learned.as_ref().filter(|_| self.regressor.is_hybrid()) else {
            return Vec::new();
        };
        let axes = self.axes.iter().enumerate();
        let silent = axes.filter(|(at, _)| learned.is_silent(*at));
        silent.map(|(_, axis)| *axis).collect()
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

    /// The recording with the auxiliary channels that the calibration was made for, and no others, and with gauges that a tare
    /// made as the calibration knows them.
    ///
    /// # Errors
    /// [`CalibrationError`] if it has other gauges, or lacks a channel.
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

    /// Applies the calibration to every sample of a recording, whose history starts with its first sample.
    ///
    /// # Errors
    /// [`CalibrationError`] if the recording's gauges are not those that it was made for, or an auxiliary channel is missing.
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

    /// The compensated load of every sample, `n × n_axes` row-major.
    pub(crate) fn compensated_loads(&self, recording: &Recording, past: &[Vec<u32>]) -> Vec<f64> {
        let design = self.design();
        let mut loads = vec![0.0; recording.n_samples() * self.axes.len()];
        let stream = FeatureStream::new(&design);
        let take = Self::loads_of_rows;
        self.over_blocks(stream, recording, past, 0, &mut loads, take);
        loads
    }

    /// Whether the load of any sample can be made without those before it, and quickly.
    pub(crate) fn is_quick_anywhere(&self) -> bool {
        self.learned.is_none() && !self.features.has_memory()
    }

    /// The compensated loads of some samples, `n × n_axes` row-major, where [`Self::is_quick_anywhere`].
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

    /// The standard deviation of the load around the compensated one, `n × n_axes` row-major, where the regressor
    /// knows it.
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

    /// Calls `take` with raw rows from sample `first` on, rows for what was learned (empty without), room to work, and a part of
    /// `out`, which has a number for each axis of each sample.
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

    /// The one place where features become compensated loads.
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

/// A channel with its unit.
fn named(name: &str, unit: &str) -> String {
    match unit {
        "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    }
}

/// Rows that are made before they are used.
const BLOCK: usize = 256;

/// Appends the standardised features without the offset: what networks and kernels learn from.
pub(crate) fn learned_inputs(design: &Design, raw: &[f64], inputs: &mut Vec<f64>) {
    let start = inputs.len();
    inputs.extend(raw);
    design.standardise(&mut inputs[start..]);
    inputs.truncate(start + raw.len() - usize::from(design.offset));
}

/// The past samples of a recording, one list for each look-back.
pub(crate) type Past = Vec<Vec<u32>>;

/// The past samples of each look-back; some samples have none once the work is cancelled.
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
