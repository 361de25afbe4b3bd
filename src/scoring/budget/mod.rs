//! The error budget: the mean squared held-out error of a calibration, split by cause into shares that add up.
//!
//! Each cause is described by columns that it would add to the calibration. The products of all columns are summed over
//! contiguous blocks of samples, and all fits and held-out errors follow from these sums. The share of a cause is its Shapley
//! value in the set of causes that the data need. Noise that no calibration can avoid is subtracted first, so that a cause gets
//! no share for averaging noise.
//!
//! Guarantees: the work is linear in the samples, can be cancelled, and needs memory for the sums and the rows of a few samples
//! only.

mod cause;
mod columns;
mod freedoms;
mod held_out;
mod inputs;
mod noise;
mod run;
mod shares;
mod sums;
mod time_scale;

use serde::{Serialize, Serializer};

pub use crate::scoring::budget::{
    cause::Cause,
    run::{ColumnStream, Model, Run},
    shares::{NoBudget, Share, Shares},
};
use crate::{
    progress::{Cancelled, Progress},
    scoring::{
        budget::{
            columns::Columns, held_out::HeldOut, inputs::Inputs, noise::Noise, run::Unit,
            shares::Decision, sums::Sums, time_scale::TimeScale,
        },
        cross_validation::FEWEST_RECORDINGS,
        load_spread::hold_one_load,
    },
};

/// Maximum number of numbers in the sums of all blocks.
const MOST_NUMBERS: usize = 1 << 25;

/// Error budget of a calibration.
#[derive(Debug, Serialize)]
pub struct Budget {
    /// Causes that were tested.
    pub tested: Vec<Cause>,
    /// True if there are fewer than three recordings, so that segments of them are left out.
    pub are_segments: bool,
    /// True if the samples are load cases without order in time.
    pub is_table: bool,
    /// True if noise can be told apart from other causes.
    pub noise_is_known: bool,
    /// Number of samples in which the load changes by a tenth of its variance.
    pub change_samples: f64,
    /// Number of recordings that were used.
    pub n_recordings: usize,
    /// Causes whose columns the calibration contains already, so that what it does not follow is unexplained.
    pub in_model: Vec<Cause>,
    /// True if parts of the samples have loads that the others lack.
    #[serde(skip)]
    pub has_new_loads: bool,
    /// Shares on each axis.
    #[serde(serialize_with = "shares_or_reasons")]
    pub axes: Vec<Result<Shares, NoBudget>>,
    /// Shares over the axes of each pool.
    #[serde(serialize_with = "shares_or_reasons")]
    pub pools: Vec<Result<Shares, NoBudget>>,
}

fn shares_or_reasons<S: Serializer>(
    all: &[Result<Shares, NoBudget>],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    #[serde(untagged)]
    enum Shown<'a> {
        Shares(&'a Shares),
        Reason { no_budget: NoBudget },
    }
    let shown = all.iter().map(|own| match own {
        Ok(shares) => Shown::Shares(shares),
        Err(reason) => Shown::Reason { no_budget: *reason },
    });
    serializer.collect_seq(shown)
}

impl Budget {
    /// Returns the budget without the shares whose error comes from missing load cases, and with the mean squared errors that the
    /// fit's cross-validation gives on each axis (full scale²), if they are given. The fits of the budget differ from it in the
    /// ridge, and leave out several recordings together if there are many.
    pub fn scaled_to(mut self, mean_squares: Option<&[f64]>, pools: &[Vec<usize>]) -> Self {
        let has_new_loads = self.has_new_loads;
        let scale = |shares: &mut Result<Shares, NoBudget>, axes: &[usize]| {
            let Ok(own) = shares else { return };
            if has_new_loads && own.over_in_sample > MOST_OVER_IN_SAMPLE {
                *shares = Err(NoBudget::MissingLoads);
            } else if let Some(squares) = mean_squares {
                let sum: f64 = axes.iter().map(|axis| squares[*axis]).sum();
                own.scale_to(sum / axes.len() as f64);
            }
        };
        self.axes.iter_mut().enumerate().for_each(|(axis, own)| scale(own, &[axis]));
        self.pools.iter_mut().zip(pools).for_each(|(own, axes)| scale(own, axes));
        self
    }
}

/// Ratio of the held-out to the in-sample mean squared error, above which the recordings load different axes.
const MOST_OVER_IN_SAMPLE: f64 = 4.0;
/// Share of the variance of a cause's columns that the calibration's columns explain, above which the cause is in the model.
const IN_MODEL: f64 = 0.95;

/// Sums of recordings, from which the budgets of the uncompensated and of the compensated calibration follow.
pub struct Measured<'a> {
    n_recordings: usize,
    /// True if each recording holds one load, so that a zero of its own would explain whatever the calibration does not follow.
    hold_one_load: bool,
    full_scale: &'a [f64],
    scale: TimeScale,
    columns: Columns,
    units: Vec<Unit>,
    sums: Sums,
    model_ridge: f64,
}

impl<'a> Measured<'a> {
    /// Sums the products of all columns over training recordings. There is at least one recording, and each has samples.
    /// `full_scale` has a value for each axis. Returns `None` if there is nothing to explain: no gauge or no conventional load
    /// varies.
    ///
    /// # Errors
    /// [`Cancelled`] if the work was cancelled.
    pub fn of(
        runs: &[Run<'_>],
        full_scale: &'a [f64],
        model: Option<Model<'_>>,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let Some(inputs) = Inputs::of(runs, full_scale.len()) else { return Ok(None) };
        progress.check()?;
        let scale = TimeScale::of(runs, &inputs.moves);
        let lengths = runs.iter().map(|run| run.n_samples as f64).collect();
        let median_samples = time_scale::middle(lengths).unwrap_or(0.0);
        let n_model = model.map_or(0, |own| own.n_columns);
        let columns = Columns::new(inputs, scale, median_samples, n_model);
        let most_blocks = MOST_NUMBERS / columns.width.pow(2);
        let units = Unit::all(runs, scale.change_samples, most_blocks);
        let noise = if scale.separates_noise() {
            Noise::measure(runs, &columns.inputs, &units, progress)?
        } else {
            None
        };
        let sums = Sums::collect(runs, &columns, model, (&units, noise), progress)?;
        Ok(Some(Self {
            n_recordings: runs.len(),
            hold_one_load: hold_one_load(runs.iter().map(|run| run.loads), full_scale.len()),
            full_scale,
            scale,
            columns,
            units,
            sums,
            model_ridge: model.map_or(0.0, |own| own.ridge),
        }))
    }

    /// Returns where the held-out error comes from, on each axis and over the axes of each pool: that of the conventional
    /// calibration, or that of the model. Errors are also split where load cases are missing.
    ///
    /// # Errors
    /// [`Cancelled`] if the work was cancelled.
    pub fn budget(
        &self,
        pools: &[Vec<usize>],
        of_model: bool,
        progress: &Progress,
    ) -> Result<Budget, Cancelled> {
        let Self { full_scale, scale, columns, units, sums, .. } = self;
        let model = if of_model { &sums.model[..] } else { &[] };
        let base: Vec<usize> = (0..=columns.n_gauges()).chain(model.iter().copied()).collect();
        let are_segments = self.n_recordings < FEWEST_RECORDINGS;
        let held_out = HeldOut {
            columns,
            units,
            sums,
            base,
            model_ridge: self.model_ridge,
            of_units: if self.hold_one_load {
                Vec::new()
            } else {
                of_units(units, sums, are_segments, *scale)
            },
            full_scale,
        };
        let errors = held_out.errors(progress)?;
        let squares = || full_scale.iter().map(|full| full * full);
        let in_sample = held_out.in_sample();
        let noise = sums.noise.as_ref();
        let floor = |(axis, square): (usize, f64)| {
            noise.map_or(0.0, |own| own.floor[axis].min(in_sample[axis].1) / square)
        };
        let with_columns = sums.of_causes.iter().map(|own| own.0);
        let tested: Vec<Cause> = with_columns.chain(held_out.of_units.iter().copied()).collect();
        let in_model = if of_model { sums.causes_in(&held_out.base, IN_MODEL) } else { Vec::new() };
        let decision = Decision {
            errors: &errors,
            n_samples: &sums.n_samples,
            floor: &squares().enumerate().map(floor).collect::<Vec<f64>>(),
            in_sample: &in_sample
                .iter()
                .zip(squares())
                .map(|(own, square)| own.0 / square)
                .collect::<Vec<f64>>(),
            tested: &tested,
        };
        Ok(Budget {
            are_segments,
            is_table: scale.is_table,
            noise_is_known: noise.is_some(),
            change_samples: scale.change_samples,
            n_recordings: self.n_recordings,
            in_model,
            has_new_loads: held_out.leaves_out_new_loads(),
            axes: (0..full_scale.len()).map(|axis| decision.shares(&[axis])).collect(),
            pools: pools.iter().map(|axes| decision.shares(axes)).collect(),
            tested,
        })
    }
}

/// Returns the causes of units that can be tested. Segments of one recording do not tell drift from slow changes.
fn of_units(units: &[Unit], sums: &Sums, are_segments: bool, scale: TimeScale) -> Vec<Cause> {
    let fewest = sums.n_samples.iter().copied().fold(f64::INFINITY, f64::min);
    let is_tested = |cause: &Cause| match cause {
        Cause::Drift => !are_segments && !scale.is_table && scale.has_times,
        Cause::Sensitivity => !are_segments,
        _ => true,
    };
    let can_tell = units.len() >= 3 && fewest >= 2.0;
    Cause::OF_UNITS.into_iter().filter(|cause| can_tell && is_tested(cause)).collect()
}

#[cfg(test)]
mod tests;
