//! Findings about the model from the figures of a check, and the verdict.

use crate::finding::{Finding, Id, Verdict};
use crate::questions::check::independent_loads::{AxisReach, Sufficiency};
use crate::scoring::numbers::{percent, significant};

/// Minimum ratio of a held-out error to that of the fit for a finding, if the error exceeds [`ERROR_MATTERS`]. With 1.25 loads
/// per coefficient the ratio is five by the count alone.
const RATIO_FAILS: f64 = 5.0;
/// Minimum held-out error for a finding, as a share of full scale.
const ERROR_MATTERS: f64 = 0.01;
/// Minimum held-out error that is no better than that of the mean load, as a share of the load's standard deviation.
const NO_BETTER: f64 = 0.9;
/// Minimum ratio of a load's variance to the part that does not follow from the other axes, for axes that move together.
const INFLATION: f64 = 5.0;
/// The same for axes that the loads do not separate: two axes with a correlation of 0.999.
const SAME: f64 = 500.0;
/// Share of a rated load that the training loads have to reach.
const REACHED: f64 = 0.8;
/// Share of the larger side below which the other side of an axis counts as not loaded.
pub(super) const ONE_WAY: f64 = 0.1;

use Verdict::{Doubtful, Enough, Insufficient};

impl Sufficiency {
    /// Adds the findings that follow from its figures, puts all in order, and sets the verdict.
    pub fn judged(mut self, cross_validation: Option<&str>) -> Self {
        let mut found = std::mem::take(&mut self.reasons);
        found.extend(cross_validation.and_then(|by| self.no_better_than_mean(by)));
        found.extend(cross_validation.and_then(|by| self.larger_left_out(by)));
        found.extend(self.axes.iter().filter_map(AxisReach::one_sided));
        found.extend(self.axes.iter().filter_map(AxisReach::not_reached));
        found.extend(self.move_together());
        self.verdict = found.iter().map(|own| own.severity).max().unwrap_or(Enough);
        self.reasons = Finding::ordered(found);
        self
    }

    /// Returns the axes with their held-out errors: those whose error is no better than that of the mean load, or the others.
    fn left_out(&self, is_lost: bool) -> impl Iterator<Item = (&AxisReach, f64)> {
        let errors = self.axes.iter().filter_map(|own| Some((own, own.left_out_rmse?)));
        errors.filter(move |(own, error)| {
            (own.deviation > 0.0 && *error >= NO_BETTER * own.deviation) == is_lost
        })
    }

    /// Returns the axes whose held-out errors are no better than those of the mean load; `by` describes the held-out part.
    fn no_better_than_mean(&self, by: &str) -> Option<Finding> {
        let one = |(own, error): (&AxisReach, f64)| {
            let [error, mean] = [error, own.deviation].map(|value| own.load(value));
            format!("{} errs by {error}, its mean alone by {mean}", own.axis.symbol())
        };
        let all: Vec<String> = self.left_out(true).map(one).collect();
        let seen = format!("left out {by}, {}", all.join("; "));
        (!all.is_empty())
            .then(|| Finding::new(Id::NoBetterThanMean, Insufficient, seen).costing(1.0))
    }

    /// Returns the finding of held-out errors that are many times those of the fit, with the largest ratio.
    fn larger_left_out(&self, by: &str) -> Option<Finding> {
        let times = self.left_out(false).filter_map(|(own, error)| {
            let least = 1e-9 * own.deviation;
            let times = error / own.train_rmse?.max(least);
            let fails = times > RATIO_FAILS && error > ERROR_MATTERS * own.full_scale;
            (error > least && fails).then_some((own, error, times))
        });
        let mut times: Vec<(&AxisReach, f64, f64)> = times.collect();
        times.sort_by(|a, b| b.2.total_cmp(&a.2));
        let ((own, error, most), others) = times.split_first()?;
        let seen = format!(
            "left out {by}, {} errs by {}, {} times the {} of the fit",
            own.axis.symbol(),
            own.load(*error),
            significant(*most, 2),
            own.load(own.train_rmse.unwrap_or(0.0)),
        );
        let others: Vec<String> = (others.iter())
            .map(|(own, _, times)| {
                format!("{} {} times", own.axis.symbol(), significant(*times, 2))
            })
            .collect();
        let found = Finding::new(Id::LargerLeftOut, Insufficient, seen).with(others.join(", "));
        Some(found.costing(error / own.full_scale))
    }

    /// Returns the finding of axes whose loads mostly follow from those of the others.
    fn move_together(&self) -> Option<Finding> {
        let tied = |own: &&AxisReach| own.inflation.is_some_and(|own| own >= INFLATION);
        let tied: Vec<&AxisReach> = self.axes.iter().filter(tied).collect();
        let (symbols, figures): (Vec<&str>, Vec<String>) = (tied.iter())
            .filter_map(|own| {
                let ((other, r), share) = (own.moves_with?, 1.0 - 1.0 / own.inflation?);
                let (symbol, share, other) = (own.axis.symbol(), percent(share), other.symbol());
                Some((symbol, format!("{share} of {symbol}, correlation {r:+.2} with {other}")))
            })
            .unzip();
        let seen = format!("{} follow from the loads on other axes", symbols.join(", "));
        let is_same = tied.iter().any(|own| own.inflation >= Some(SAME));
        let severity = if is_same { Insufficient } else { Doubtful };
        let found = Finding::new(Id::MovesTogether, severity, seen).with(figures.join("; "));
        (!symbols.is_empty()).then_some(found)
    }
}

impl AxisReach {
    fn load(&self, value: f64) -> String {
        format!("{} {}", significant(value, 3), self.axis.unit())
    }

    fn one_sided(&self) -> Option<Finding> {
        let (up, down) = (self.high.max(0.0), (-self.low).max(0.0));
        let (some, other) = (up.max(down), up.min(down));
        let is_one_sided = self.rated && self.deviation > 0.0 && other <= ONE_WAY * some;
        let way = if up > down { "upward" } else { "downward" };
        is_one_sided.then(|| {
            let seen = format!("{} is loaded {way} only", self.axis.symbol());
            let figures = format!(
                "{} to {} of ± {}",
                significant(self.low, 3),
                self.load(self.high),
                self.load(self.full_scale)
            );
            Finding::new(Id::OneSided, Doubtful, seen).with(figures).costing(1.0)
        })
    }

    fn not_reached(&self) -> Option<Finding> {
        if !self.rated || self.full_scale <= 0.0 || self.deviation == 0.0 {
            return None;
        }
        let ends = [(self.region.0, self.low), (self.region.1, self.high)];
        let reached = ends.into_iter().filter(|(end, _)| *end != 0.0);
        let short: Vec<(f64, f64)> = reached
            .map(|(end, reached)| (end, (reached / end).max(0.0)))
            .filter(|(_, share)| *share < REACHED)
            .collect();
        let least = short.iter().map(|(_, share)| *share).fold(1.0, f64::min);
        let short: Vec<String> = (short.iter())
            .map(|(end, share)| format!("{} of {}", percent(*share), self.load(*end)))
            .collect();
        let seen = format!("{} reaches {} only", self.axis.symbol(), short.join(" and "));
        (!short.is_empty())
            .then(|| Finding::new(Id::NotReached, Doubtful, seen).costing(1.0 - least))
    }
}
