//! Calibration in the form that exported code runs. Constants are combined beforehand, so that the update for a sample needs
//! few steps.
//!
//! Guarantees: exported code gives the loads of the calibration, except for rounding. A centre near the mean, exact in
//! single precision, is subtracted from each gauge. Past gauges are taken relative to the present gauges. Therefore even
//! large raw offsets cost no digits in single precision.

use serde::Serialize;

use crate::{
    calibration::{Calibration, Kernel, Learned, LinearMap, NEVER_REACHED, Network},
    dot::dot,
    features::{
        Appends, AuxiliaryChannel, Column, Design, Rows, STORED_SAMPLES, Source,
        look_back::measured,
    },
};

/// Shortest time between stored samples (s). It replaces the zero of old files, which asks to store every sample.
const SHORTEST_STEP_SECS: f64 = 1e-5;

/// The steps of the update for one sample, with their constants. A *row* consists of the gauges minus their centre, then past
/// minus present gauges for each look-back, lag, creep or play value, then monomials and auxiliary columns. The load is the
/// map `linear` applied to the row, plus the output of the network or kernel `learned`.
#[derive(Clone, Debug, Serialize)]
pub(in crate::export) struct Program {
    pub centre: Vec<f64>,
    /// Conventional calibration, as a map from the gauges minus their centre to the load.
    pub conventional: Affine,
    /// Force threshold F_th squared and time threshold t_th (s) of each look-back.
    pub look_backs: Vec<(f64, f64)>,
    /// Index of each axis that counts in the distance between two samples of a look-back, with the factor of its load.
    pub measured: Vec<(usize, f64)>,
    /// Time for which exported code stores samples (s); zero if no feature needs stored samples.
    pub window_secs: f64,
    /// Minimum time between stored samples (s).
    pub history_step_secs: f64,
    /// Step in time above which the sensor counts as paused (s).
    pub gap_secs: f64,
    /// Longest pause after which the stored samples are kept (s).
    pub stored_keep_secs: f64,
    /// Load of each axis beyond which the sensor was not tested.
    pub limits: Vec<f64>,
    /// Lowest reading of each gauge, at which it is clipped; empty if unknown.
    pub gauge_low: Vec<f64>,
    pub gauge_high: Vec<f64>,
    /// True if the clipping limits apply to gauges after the tare is subtracted.
    pub limits_tared: bool,
    /// Readings of the gauges of the unloaded sensor, after the tare is subtracted.
    pub unloaded: Vec<f64>,
    pub blocks: Vec<RunBlock>,
    /// True if the compensated load fades in from the conventional load while states of the blocks are unknown.
    pub fades: bool,
    /// Auxiliary channels that each update needs, as name with unit and range.
    pub auxiliary: Vec<String>,
    /// Factor and constant that turn each gauge minus its centre into a standardised gauge.
    pub standardise: Vec<(f64, f64)>,
    pub n_columns: usize,
    pub linear: Option<Affine>,
    pub learned: Option<LearnedProgram>,
}

#[derive(Clone, Debug, Serialize)]
pub(in crate::export) struct RunBlock {
    pub sets: usize,
    /// Longest pause after which the state of the block is kept (s).
    pub keep_secs: f64,
    pub source: Source,
}

/// Linear map from a row to the loads: `load = matrix · row + base`.
#[derive(Clone, Debug, Serialize)]
pub(in crate::export) struct Affine {
    pub matrix: Vec<Vec<f64>>,
    pub base: Vec<f64>,
}

/// The network or kernel, whose output is added to that of the linear map. Its inputs are `row · factor + constant`.
#[derive(Clone, Debug, Serialize)]
pub(in crate::export) struct LearnedProgram {
    pub inputs: Vec<(f64, f64)>,
    pub regression: Learned,
}

impl Program {
    pub fn new(calibration: &Calibration) -> Self {
        let design = calibration.design();
        let features = &calibration.features;
        let scale = &calibration.gauge_scale;
        let n_columns = design.where_column(|column| column != Column::Offset).len();
        // The centre is rounded to single precision, so that single-precision code subtracts the same number.
        let centre: Vec<f64> = scale.shift.iter().map(|s| f64::from(*s as f32)).collect();
        let standardise: Vec<_> = (scale.inverse_scale.iter().zip(&scale.shift).zip(&centre))
            .map(|((factor, shift), centre)| (*factor, (centre - shift) * factor))
            .collect();
        let used = features.blocks.used().filter(|(block, _)| {
            !matches!(block.appends(), Appends::Auxiliary) || features.uses_auxiliary()
        });
        let (effects, fade) = (calibration.state_effects(), calibration.fade_of_states());
        let blocks = used.zip(&effects).enumerate().map(|(at, ((block, values), effects))| {
            let channels = &features.auxiliary[..];
            let fade = fade.get(at).map_or(&[][..], Vec::as_slice);
            let rows = Rows { scale, standardise: &standardise, channels, effects, fade };
            RunBlock {
                sets: values.len(),
                keep_secs: block.memory().map_or(0.0, |memory| calibration.keep_secs_of(memory)),
                source: block.source(values, &rows),
            }
        });
        let blocks: Vec<_> = blocks.collect();
        let mut measured = measured(&calibration.distance_weights());
        if measured.is_empty() {
            measured.push((0, 0.0)); // distance zero everywhere, in an array that is not empty
        }
        let [gauge_low, gauge_high] = calibration.clipped_at().unwrap_or_default();
        let mut program = Self {
            conventional: on_rows(&calibration.conventional, &centre),
            look_backs: features
                .look_backs
                .iter()
                .map(|look_back| (look_back.f_th * look_back.f_th, look_back.t_th_secs))
                .collect(),
            measured,
            window_secs: features.window_secs(),
            history_step_secs: (calibration.history_step_secs).max(SHORTEST_STEP_SECS),
            gap_secs: calibration.gap_secs,
            stored_keep_secs: calibration.keep_secs_of(STORED_SAMPLES),
            limits: limits(calibration),
            gauge_low,
            gauge_high,
            limits_tared: calibration.tare.is_some(),
            unloaded: calibration.unloaded(),
            blocks,
            fades: !fade.is_empty(),
            auxiliary: (features.auxiliary.iter()).map(AuxiliaryChannel::in_words).collect(),
            standardise,
            n_columns,
            linear: (calibration.compensated.as_ref()).map(|map| on_rows(map, &centre)),
            learned: None,
            centre,
        };
        program.learned = calibration.learned.as_ref().map(|regression| LearnedProgram {
            inputs: program.inputs(&design, regression),
            regression: regression.clone(),
        });
        program
    }

    /// Returns the number of samples that the ring buffer holds, rounded up to whole boxes. These are the samples of the
    /// stored time, one older sample, the newest sample, and a box that is being overwritten (16 samples in C and Rust, 64 in
    /// MATLAB).
    pub fn ring_samples(&self) -> usize {
        let in_window = (self.window_secs / self.history_step_secs).floor() as usize;
        (in_window + 3 + 64).next_multiple_of(256)
    }

    pub fn keeps_samples(&self) -> bool {
        !self.look_backs.is_empty() || self.window_secs > 0.0
    }

    /// Returns the number of multiplications in the update for one sample. The search of the look-back is not counted; at
    /// worst, it visits all stored samples.
    pub fn n_products(&self) -> usize {
        let n_axes = self.conventional.base.len();
        let learned = match self.learned.as_ref().map(|learned| &learned.regression) {
            Some(Learned::Network(network)) => network.n_parameters(),
            Some(Learned::Kernel(kernel)) => kernel.landmarks.len() * (self.n_columns + n_axes),
            None => 0,
        };
        n_axes * (self.centre.len() + self.n_columns) + learned
    }

    /// Returns the factors and constants from a row to the inputs of the network or kernel. They combine two
    /// standardisations: of the features and of the inputs.
    fn inputs(&self, design: &Design, regression: &Learned) -> Vec<(f64, f64)> {
        let (shift, factor) = match regression {
            Learned::Network(Network { input_shift, input_inverse_scale, .. }) => {
                (input_shift, input_inverse_scale)
            }
            Learned::Kernel(Kernel { input_shift, input_scale, .. }) => (input_shift, input_scale),
        };
        (shift.iter().zip(factor).zip(design.columns()))
            .map(|((shift, factor), column)| {
                let (first, constant) = match column {
                    Column::Gauge(gauge) => self.standardise[gauge],
                    Column::Past { gauge, .. } => (self.standardise[gauge].0, 0.0),
                    Column::Monomial(_) | Column::Auxiliary { .. } | Column::Offset => (1.0, 0.0),
                };
                (first * factor, (constant - shift) * factor)
            })
            .collect()
    }
}

/// Returns the largest known load of each axis; for an axis without a known one, a value that no load reaches.
fn limits(calibration: &Calibration) -> Vec<f64> {
    let limit = |axis| match calibration.limits.get(axis) {
        Some(limit) if *limit > 0.0 => *limit,
        _ => NEVER_REACHED,
    };
    (0..calibration.axes.len()).map(limit).collect()
}

fn on_rows(map: &LinearMap, centre: &[f64]) -> Affine {
    let mut affine = Affine { matrix: Vec::new(), base: Vec::new() };
    for raw in &map.matrix {
        let mut row = Vec::with_capacity(raw.len());
        let mut offset = 0.0;
        for (column, slope) in map.columns.iter().zip(raw) {
            match column {
                Column::Offset => offset = *slope,
                // A row holds past minus present gauges. So the slope of a past gauge also counts for the present gauge.
                Column::Past { gauge, .. } => {
                    row[*gauge] += slope;
                    row.push(*slope);
                }
                Column::Gauge(_) | Column::Monomial(_) | Column::Auxiliary { .. } => {
                    row.push(*slope);
                }
            }
        }
        affine.base.push(offset + dot(&row, centre));
        affine.matrix.push(row);
    }
    affine
}
