//! Decides which causes the error comes from, and how large the share of each is.

use serde::Serialize;

use crate::{
    calibration::t_beyond,
    scoring::budget::{
        cause::{Cause, Causes},
        held_out::{AllErrors, AxisErrors},
    },
};

/// Mean squared error (full scale²) below which there is no error to explain.
const NO_ERROR: f64 = 1e-12;
/// Mean squared error per cause, as a share of the total, by which a larger set must be better.
const PER_CAUSE: f64 = 1e-3;
/// Smallest share of the mean squared error that is named, of the total and of the unexplained rest.
const LEAST_SHARE: f64 = 0.02;
const LEAST_OF_REST: f64 = 0.3;
/// Confidence that a cause with columns lowers the error.
const CONFIDENCE: f64 = 0.99;
/// Smallest ratio of a gain of the units to its standard deviation by chance.
const LEAST_GAIN: f64 = 4.0;
/// Maximum number of causes that are added to the best set.
const MOST_ADDED: usize = 3;
/// Share of a cause's gain that another cause must reach to be given as an alternative. Temperature that is constant in each
/// recording looks like zeros, so these two need less.
const ALTERNATIVE: f64 = 0.8;
const ALTERNATIVE_OF_ZEROS: f64 = 0.5;
/// Minimum number of blocks for a budget.
const FEWEST_BLOCKS: usize = 4;
/// Factor by which the scatter over blocks becomes a standard error that holds.
const WIDER: f64 = 1.5;

/// Share of one cause in the mean squared error.
#[derive(Debug, Serialize)]
pub struct Share {
    /// Cause of this part of the error.
    pub cause: Cause,
    /// Share of the mean squared error (full scale²).
    pub square: f64,
    /// Standard error of `square`.
    pub standard_error: f64,
    /// Causes that explain the same part nearly as well.
    pub or: Vec<Cause>,
}

/// Error of one axis or of several axes, split by cause. `shares`, `noise` and `unexplained` add to `total`.
#[derive(Debug, Serialize)]
pub struct Shares {
    /// Mean squared held-out error (full scale²).
    pub total: f64,
    /// Named causes, the largest first.
    pub shares: Vec<Share>,
    /// Part that is white noise.
    pub noise: f64,
    /// Part without a named cause.
    pub unexplained: f64,
    /// Causes that perhaps have a part of the unexplained error, the largest first.
    pub perhaps: Vec<Cause>,
    /// Ratio of the held-out to the in-sample mean squared error.
    pub over_in_sample: f64,
    /// Factor by which the shares were multiplied, so that `total` is the error that the fit's cross-validation gives.
    pub factor: f64,
}

/// Reason why there is no error budget.
#[derive(Clone, Copy, Debug, Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum NoBudget {
    /// No gauge varies, or no load can be computed from the gauges.
    #[error("no gauge varies with the load")]
    NothingToExplain,
    /// There are too few blocks of samples.
    #[error("there are too few samples")]
    TooFewSamples,
    /// The error is zero.
    #[error("there is no error")]
    NoError,
    /// The held-out error is many times the in-sample error, as with recordings that load different axes or with few load cases.
    #[error("the error comes from load cases that occur in one part of the samples only")]
    MissingLoads,
}

/// Figures from which the shares are decided.
pub struct Decision<'a> {
    pub errors: &'a AllErrors,
    /// Number of samples of each block.
    pub n_samples: &'a [f64],
    /// Noise of the calibration and least noise of any calibration, on each axis, in full scales.
    pub floor: &'a [f64],
    /// Mean squared residual on each axis, when fitted to all samples, in full scales.
    pub in_sample: &'a [f64],
    /// Causes that are tested.
    pub tested: &'a [Cause],
}

/// Errors of one set of causes over the chosen axes: squared errors of each block, and their systematic part.
struct OfSet<'a> {
    raw: Vec<f64>,
    systematic: Vec<f64>,
    axes: Vec<&'a AxisErrors>,
}

impl Shares {
    /// Changes the mean square of the error.
    pub fn scale_to(&mut self, total: f64) {
        let factor = if total.is_finite() { total / self.total } else { 1.0 };
        for own in &mut self.shares {
            own.square *= factor;
            own.standard_error *= factor;
        }
        for own in [&mut self.total, &mut self.noise, &mut self.unexplained, &mut self.factor] {
            *own *= factor;
        }
    }
}

impl Decision<'_> {
    pub fn shares(&self, axes: &[usize]) -> Result<Shares, NoBudget> {
        if self.n_samples.len() < FEWEST_BLOCKS {
            return Err(NoBudget::TooFewSamples);
        }
        let n_axes = axes.len() as f64;
        let sets = self.errors.iter();
        let sets = sets.map(|errors| errors.as_ref().map(|errors| self.of_set(errors, axes)));
        let explained = Explained {
            sets: sets.collect(),
            n: self.n_samples.iter().map(|n| n * n_axes).collect(),
            tested: self.tested,
        };
        let total = explained.set(Causes::default()).raw.iter().sum::<f64>() / explained.n_total();
        if !total.is_finite() || total <= NO_ERROR {
            return Err(NoBudget::NoError);
        }
        let in_sample = axes.iter().map(|axis| self.in_sample[*axis]).sum::<f64>() / n_axes;
        let over_in_sample = total / in_sample.max(1e-300);
        Ok(Shares { over_in_sample, ..explained.shares(total) })
    }

    fn of_set<'a>(&self, errors: &'a [AxisErrors], axes: &[usize]) -> OfSet<'a> {
        let noise: f64 = axes.iter().map(|axis| errors[*axis].noise.min(self.floor[*axis])).sum();
        let axes: Vec<&AxisErrors> = axes.iter().map(|axis| &errors[*axis]).collect();
        let raw = |block: usize| axes.iter().map(|axis| axis.squares[block]).sum();
        let raw: Vec<f64> = (0..self.n_samples.len()).map(raw).collect();
        let systematic = raw.iter().zip(self.n_samples).map(|(square, n)| square - n * noise);
        OfSet { systematic: systematic.collect(), raw, axes }
    }
}

struct Explained<'a> {
    sets: Vec<Option<OfSet<'a>>>,
    /// Number of errors of each block.
    n: Vec<f64>,
    tested: &'a [Cause],
}

impl Explained<'_> {
    fn set(&self, causes: Causes) -> &OfSet<'_> {
        self.sets[causes.index()].as_ref().expect("all sets of tested causes have errors")
    }

    fn n_total(&self) -> f64 {
        self.n.iter().sum()
    }

    fn mean(&self, causes: Causes) -> f64 {
        self.set(causes).systematic.iter().sum::<f64>() / self.n_total()
    }

    fn shares(&self, total: f64) -> Shares {
        let tested = self.tested;
        let best = self.best(total);
        let values: Vec<(Cause, Vec<f64>)> = (tested.iter().filter(|cause| best.contains(**cause)))
            .map(|cause| (*cause, self.shapley(best, *cause, total)))
            .collect();
        let rest = self.mean(best).max(0.0);
        let least = (LEAST_SHARE * total).max(LEAST_OF_REST * rest);
        let (mut shares, mut unnamed) = (Vec::new(), Vec::new());
        for (cause, value) in &values {
            let square = value.iter().sum::<f64>() / self.n_total();
            if square < least {
                unnamed.push((*cause, square));
                continue;
            }
            let deviations = value.iter().zip(&self.n).map(|(own, n)| (own - square * n).powi(2));
            let scatter: f64 = deviations.sum();
            let standard_error = WIDER * scatter.sqrt() / self.n_total();
            let or = self.alternatives(best, *cause);
            shares.push(Share { cause: *cause, square, standard_error, or });
        }
        shares.sort_by(|a, b| b.square.total_cmp(&a.square));
        unnamed.retain(|(_, square)| *square > 0.0);
        unnamed.sort_by(|a, b| b.1.total_cmp(&a.1));
        Shares {
            total,
            shares,
            noise: (total - self.mean(Causes::default())).min(total),
            unexplained: rest + unnamed.iter().map(|own| own.1).sum::<f64>(),
            perhaps: unnamed.iter().map(|own| own.0).collect(),
            over_in_sample: 1.0,
            factor: 1.0,
        }
    }

    /// Returns the set of causes that the data need.
    fn best(&self, total: f64) -> Causes {
        let tested = self.tested;
        let sets = Causes::subsets(tested);
        let cost = |set: &Causes| self.mean(*set) + PER_CAUSE * total * set.len() as f64;
        let best = sets.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
        let mut best = best.unwrap_or_default();
        let needed = |set: Causes, cause: Cause| {
            let need = self.needed(set, cause, total);
            // A zero is the simplest difference of a recording, so the others must show beside it.
            let beside = Cause::OF_UNITS.contains(&cause) && tested.contains(&Cause::Zeros);
            let of_zeros = if beside { set.with(Cause::Zeros) } else { set };
            (cause, need.min(self.needed(of_zeros, cause, total)))
        };
        let by_need = |a: &(Cause, f64), b: &(Cause, f64)| a.1.total_cmp(&b.1);
        loop {
            let inside = tested.iter().filter(|cause| best.contains(**cause));
            let weakest = inside.map(|cause| needed(best, *cause)).min_by(by_need);
            match weakest {
                Some((cause, need)) if need < 1.0 => best = best.without(cause),
                _ => break,
            }
        }
        for _ in 0..MOST_ADDED {
            let outside = tested.iter().filter(|cause| !best.contains(**cause));
            let strongest = outside.map(|cause| needed(best.with(*cause), *cause)).max_by(by_need);
            match strongest {
                Some((cause, need)) if need >= 1.0 => best = best.with(cause),
                _ => break,
            }
        }
        best
    }

    /// Returns at least 1 if the error without `cause` is larger by the least share that is named, and by more than chance.
    fn needed(&self, set: Causes, cause: Cause, total: f64) -> f64 {
        let (with, without) = (self.set(set), self.set(set.without(cause)));
        let gain = (without.systematic.iter().sum::<f64>() - with.systematic.iter().sum::<f64>())
            / self.n_total();
        let certain = match Cause::OF_UNITS.iter().position(|own| *own == cause) {
            Some(at) => {
                let gains = with.axes.iter().map(|axis| axis.gains[at]);
                let (gain, variance) =
                    gains.fold((0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
                gain / (variance + 1e-300).sqrt() / LEAST_GAIN
            }
            None => certainty(without, with) / critical(self.n.len()),
        };
        certain.min(gain / (LEAST_SHARE * total))
    }

    /// Returns a set without the causes that make the error larger by more than the least share that is named.
    fn useful(&self, set: Causes, total: f64) -> Causes {
        let is_worse = |cause: &&Cause| {
            let gain = self.mean(set.without(**cause)) - self.mean(set);
            set.contains(**cause) && gain < -LEAST_SHARE * total
        };
        let worse = self.tested.iter().find(is_worse);
        worse.map_or(set, |cause| self.useful(set.without(*cause), total))
    }

    /// Returns the Shapley value of a cause in a set, for each block.
    fn shapley(&self, set: Causes, cause: Cause, total: f64) -> Vec<f64> {
        let others: Vec<Cause> = (self.tested.iter().copied())
            .filter(|own| set.contains(*own) && *own != cause)
            .collect();
        let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
        let mut value = vec![0.0; self.n.len()];
        for before in Causes::subsets(&others) {
            let after = others.len() - before.len();
            let weight = factorial(before.len()) * factorial(after) / factorial(set.len());
            let [without, with] = [before, before.with(cause)]
                .map(|own| &self.set(self.useful(own, total)).systematic);
            for ((value, a), b) in value.iter_mut().zip(without).zip(with) {
                *value += weight * (a - b);
            }
        }
        value
    }

    /// Returns the causes outside the set that explain nearly as much in place of `cause`.
    fn alternatives(&self, set: Causes, cause: Cause) -> Vec<Cause> {
        let without = set.without(cause);
        let gain = self.mean(without) - self.mean(set);
        let is_alternative = |other: &Cause| {
            let pair = [cause, *other];
            let of_zeros = pair.contains(&Cause::Zeros) && pair.contains(&Cause::Temperature);
            let share = if of_zeros { ALTERNATIVE_OF_ZEROS } else { ALTERNATIVE };
            !set.contains(*other)
                && self.mean(without) - self.mean(without.with(*other)) > share * gain
        };
        self.tested.iter().copied().filter(is_alternative).collect()
    }
}

/// Returns the t statistic of the differences between the errors of blocks, relative to their size and bounded.
fn certainty(without: &OfSet<'_>, with: &OfSet<'_>) -> f64 {
    let raw = without.raw.iter().zip(&with.raw).map(|(a, b)| a + b);
    let differences = without.systematic.iter().zip(&with.systematic).map(|(a, b)| a - b);
    let relative: Vec<f64> = (differences.zip(raw))
        .filter(|(_, raw)| *raw > 1e-300)
        .map(|(difference, raw)| (difference / raw).clamp(-1.0, 1.0))
        .collect();
    if relative.len() < FEWEST_BLOCKS {
        return 0.0;
    }
    let n = relative.len() as f64;
    let mean = relative.iter().sum::<f64>() / n;
    let variance = relative.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / (n - 1.0);
    mean / ((variance / n).sqrt() + 1e-9)
}

/// Returns the one-sided quantile of Student's t distribution for this number of blocks.
fn critical(n_blocks: usize) -> f64 {
    let freedom = n_blocks.saturating_sub(1).max(2) as f64;
    t_beyond(freedom, 1.0 - CONFIDENCE)
}
