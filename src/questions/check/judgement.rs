//! Derives the findings about the linear model, and the verdict, from the figures of a check of the recordings.

use crate::{
    finding::{Finding, Id, Verdict},
    questions::check::independent_loads::{AxisReach, Sufficiency},
    scoring::numbers::{percent, significant},
    shown::joined,
};

/// Ratio of the held-out error to the error of the fit above which the held-out error is reported, if it also exceeds
/// [`ERROR_MATTERS`]. With 1.25 load cases per coefficient, a ratio of five is expected merely because there are few loads.
const RATIO_FAILS: f64 = 5.0;
/// Held-out error, as a share of full scale, below which no ratio of errors is reported.
const ERROR_MATTERS: f64 = 0.01;
/// Held-out error from which the calibration counts as useless on an axis: no better than always reporting the mean load. It
/// is a share of the standard deviation of the load.
const NO_BETTER: f64 = 0.9;
/// Variance inflation factor (variance of a load divided by the variance of its independent part) above which axes are
/// reported as moving together.
const INFLATION: f64 = 5.0;
/// Variance inflation factor above which the loads do not separate the axes at all. It corresponds to a correlation of 0.999
/// between two axes.
const SAME: f64 = 500.0;
/// Share of the rated load that the training loads must reach on an axis, for no finding to be reported.
const REACHED: f64 = 0.8;
/// Ratio of the largest loads in the two directions of an axis, the smaller divided by the larger, up to which the axis
/// counts as loaded in one direction only.
pub const ONE_WAY: f64 = 0.1;

use Verdict::{Doubtful, Enough, Insufficient};

impl Sufficiency {
    /// Adds the findings that follow from the figures of the check, sorts all findings, and sets the verdict.
    pub fn judged(mut self, cross_validation: Option<&str>) -> Self {
        let mut found = std::mem::take(&mut self.findings);
        found.extend(cross_validation.and_then(|by| self.no_better_than_mean(by)));
        found.extend(cross_validation.and_then(|by| self.larger_left_out(by)));
        found.extend(self.axes.iter().filter_map(AxisReach::one_sided));
        found.extend(self.axes.iter().filter_map(AxisReach::not_reached));
        found.extend(self.move_together());
        self.verdict = found.iter().map(|own| own.severity).max().unwrap_or(Enough);
        self.findings = Finding::ordered(found);
        self
    }

    /// Returns the finding that on some axes the held-out error is no better than that of always reporting the mean load.
    /// `by` says what the cross-validation leaves out.
    fn no_better_than_mean(&self, by: &str) -> Option<Finding> {
        let of_axis = |own: &AxisReach| {
            let [error, mean] = [own.left_out_rmse?, own.deviation].map(|value| own.load(value));
            let symbol = own.axis.symbol();
            own.is_lost().then(|| {
                format!(
                    "the error of {symbol} is {error}, and always reporting the mean load would give {mean}"
                )
            })
        };
        let all: Vec<String> = self.axes.iter().filter_map(of_axis).collect();
        let seen = format!("cross-validated {by}, {}", all.join("; "));
        let found = Finding::new(Id::NoBetterThanMean, Insufficient, seen).costing(1.0);
        (!all.is_empty()).then_some(found)
    }

    /// Returns the finding that on the worst axis the held-out error is many times the error of the fit. `by` says what the
    /// cross-validation leaves out.
    fn larger_left_out(&self, by: &str) -> Option<Finding> {
        let times = self.axes.iter().filter(|own| !own.is_lost()).filter_map(|own| {
            let (error, least) = (own.left_out_rmse?, 1e-9 * own.deviation);
            let times = error / own.train_rmse?.max(least);
            let fails = times > RATIO_FAILS && error > ERROR_MATTERS * own.full_scale;
            (error > least && fails).then_some((own, error, times))
        });
        let (own, error, times) = times.max_by(|a, b| a.2.total_cmp(&b.2))?;
        let seen = format!(
            "cross-validated {by}, the error of {} is {}, which is {} times the error {} of the fit",
            own.axis.symbol(),
            own.load(error),
            significant(times, 2),
            own.load(own.train_rmse?),
        );
        let found = Finding::new(Id::LargerLeftOut, Insufficient, seen);
        Some(found.costing(error / own.full_scale))
    }

    /// Returns the finding that the loads on some axes follow mostly from the loads on other axes.
    fn move_together(&self) -> Option<Finding> {
        let mut is_same = false;
        let tied = self.axes.iter().filter_map(|own| {
            let inflation = own.inflation.filter(|inflation| *inflation >= INFLATION)?;
            is_same |= inflation >= SAME;
            let (share, (other, r)) = (percent(1.0 - 1.0 / inflation), own.moves_with?);
            let (symbol, other) = (own.axis.symbol(), other.symbol());
            let figures = format!(
                "{share} of the variance of {symbol} follows from other axes; the correlation with {other} is {r:+.2}"
            );
            Some((symbol, figures))
        });
        let (symbols, figures): (Vec<&str>, Vec<String>) = tied.unzip();
        let seen =
            format!("the training loads on {} follow from those on other axes", symbols.join(", "));
        let severity = if is_same { Insufficient } else { Doubtful };
        let found = Finding::new(Id::MovesTogether, severity, seen).with(figures.join("; "));
        (!symbols.is_empty()).then_some(found)
    }
}

impl AxisReach {
    fn load(&self, value: f64) -> String {
        format!("{} {}", significant(value, 3), self.axis.unit())
    }

    /// Returns true if the held-out error is no better than that of always reporting the mean load.
    fn is_lost(&self) -> bool {
        let is_lost = |error| self.deviation > 0.0 && error >= NO_BETTER * self.deviation;
        self.left_out_rmse.is_some_and(is_lost)
    }

    fn one_sided(&self) -> Option<Finding> {
        let (up, down) = (self.high.max(0.0), (-self.low).max(0.0));
        if self.deviation == 0.0 || up.min(down) > ONE_WAY * up.max(down) {
            return None;
        }
        let seen = format!(
            "in the training recordings, {} is loaded in the {} direction only",
            self.axis.symbol(),
            if up > down { "positive" } else { "negative" }
        );
        let (low, high) = (significant(self.low, 3), self.load(self.high));
        let recorded = format!("the recorded loads are {low} to {high}");
        // Without a rated load, the sensor may be meant for one direction.
        Some(if self.rated {
            let rated = format!("{recorded}, the rated load is ± {}", self.load(self.full_scale));
            Finding::new(Id::OneSided, Doubtful, seen).with(rated).costing(1.0)
        } else {
            Finding::new(Id::OneSided, Enough, seen).with(recorded)
        })
    }

    fn not_reached(&self) -> Option<Finding> {
        if !self.rated || self.deviation == 0.0 {
            return None;
        }
        let ends = [(self.region.0, self.low), (self.region.1, self.high)];
        let ends = ends.into_iter().filter(|(end, _)| *end != 0.0);
        let short = ends.map(|(end, reached)| (end, (reached / end).max(0.0)));
        let short: Vec<(f64, f64)> = short.filter(|(_, share)| *share < REACHED).collect();
        let least = short.iter().map(|(_, share)| *share).reduce(f64::min)?;
        let short =
            short.iter().map(|(end, share)| format!("{} of {}", percent(*share), self.load(*end)));
        let seen = format!(
            "the training loads on {} reach only {}",
            self.axis.symbol(),
            joined(" and ", short)
        );
        Some(Finding::new(Id::NotReached, Doubtful, seen).costing(1.0 - least))
    }
}
