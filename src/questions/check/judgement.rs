//! What the figures of a check make of the model, as findings.

use std::cmp::Reverse;

use crate::finding::{Finding, Id, Verdict};
use crate::questions::check::independent_loads::{AxisReach, CONDITION, Sufficiency};
use crate::questions::check::load_count::LoadCount;
use crate::recording::Axis;
use crate::scoring::load_spread::LoadSpread;
use crate::scoring::numbers::{percent, significant};

/// Ratio of the error on loads that were left out to that of the fit up to which the loads count as predicted.
const RATIO_PREDICTED: f64 = 2.0;
/// Ratio of a left-out error to that of the fit from which the coefficients are made of noise, where it is more than [`ERROR_MATTERS`].
const RATIO_FAILS: f64 = 5.0;
/// Share of full scale from which such an error matters.
const ERROR_MATTERS: f64 = 0.01;
/// Share of what a load varies by from which a left-out error is no better than the mean.
const NO_BETTER: f64 = 0.9;
/// Correlation above which two load axes are reported as moving together.
const CORRELATED: f64 = 0.8;
/// The variance of what an axis does beside the others is this much smaller than its own: it is hard to tell from them.
const INFLATION_SAID: f64 = 5.0;
/// Share of a rated load that the training loads have to reach.
const REACHED: f64 = 0.8;
/// A load goes one way only where the other is below this share of it.
pub(super) const ONE_WAY: f64 = 0.1;

use Verdict::{Doubtful, Enough, Insufficient};

impl Sufficiency {
    /// Adds what follows from its figures to the reasons that are there, and settles the verdict.
    pub fn judged(mut self, spread: &LoadSpread, cross_validation: Option<&str>) -> Self {
        let count = LoadCount {
            cases: self.load_cases,
            coefficients: self.coefficients,
            free: self.free_coefficients,
        };
        let few = count.finding(self.predicts_loads());
        self.summary = match &few {
            Some(Finding { seen, figures, .. }) if !figures.is_empty() => {
                format!("{seen}: {figures}")
            }
            Some(few) => few.seen.clone(),
            None => format!("{}, {} samples", count.words(), self.n_samples),
        };
        let mut found = std::mem::take(&mut self.reasons);
        found.extend(few);
        found.extend(self.of_errors(cross_validation));
        found.extend(self.axes.iter().filter_map(AxisReach::one_sided));
        found.extend(self.axes.iter().filter_map(AxisReach::not_reached));
        found.extend(self.few_directions(spread));
        found.extend(self.coupled(spread));
        found.extend(self.hardly_determined());
        // What is wrong with a recording comes before what that makes of the errors.
        found.sort_by_key(|own| {
            let is_cause = own.id.is_cause();
            (!(own.severity > Enough && is_cause), Reverse(own.severity))
        });
        self.verdict = found.iter().map(|own| own.severity).max().unwrap_or(Enough);
        self.reasons = found;
        self
    }

    /// Whether loads that were left out are predicted nearly as well as the others, which counts for more than how many there are.
    fn predicts_loads(&self) -> bool {
        let times = |own: &AxisReach| Some(own.load_left_out_rmse? / own.train_rmse?);
        self.axes.iter().all(|own| times(own).is_some_and(|times| times <= RATIO_PREDICTED))
    }

    /// What the left-out errors say beside those of the fit; `by` says what was left out.
    fn of_errors(&self, by: Option<&str>) -> impl Iterator<Item = Finding> {
        type Error = fn(&AxisReach) -> Option<f64>;
        let ways: [(Option<&str>, Error); 2] =
            [(by, |own| own.left_out_rmse), (Some("by load case"), |own| own.load_left_out_rmse)];
        let (mut no_better, mut larger) = (None, None::<(f64, Finding)>);
        for (by, error) in ways {
            let Some(by) = by else { continue };
            let errors = self.axes.iter().filter_map(|own| Some((own, error(own)?)));
            let (lost, others): (Vec<_>, Vec<_>) = errors.partition(|(own, error)| {
                own.deviation > 0.0 && *error >= NO_BETTER * own.deviation
            });
            no_better = no_better.or_else(|| no_better_than_mean(by, &lost));
            let own = larger_left_out(by, others);
            let most = larger.as_ref().map_or(0.0, |(most, _)| *most);
            larger = own.filter(|(times, _)| *times > most).or(larger);
        }
        no_better.into_iter().chain(larger.map(|(_, found)| found))
    }

    /// That the loads do not move in as many directions as there are axes that move.
    fn few_directions(&self, spread: &LoadSpread) -> Option<Finding> {
        let (n_moving, n) = (spread.n_moving(), spread.n_directions);
        let (direction, deviation) = spread.stiffest.as_ref().filter(|_| n < n_moving)?;
        let terms = direction.iter().zip(&self.axes).filter(|(part, _)| part.abs() > 0.2);
        let terms: Vec<String> =
            terms.map(|(part, own)| format!("{part:+.2} {}", own.axis.symbol())).collect();
        let seen = format!("the loads of {n_moving} axes move in {n} independent directions only");
        let figures = format!(
            "along {}, each axis in its standard deviations, by {} of what an axis does",
            terms.join(" "),
            percent(*deviation),
        );
        Some(Finding::new(Id::FewDirections, Insufficient, seen).with(figures))
    }

    /// Which axes move together.
    fn coupled(&self, spread: &LoadSpread) -> Vec<Finding> {
        let (mut found, mut named) = (Vec::new(), Vec::new());
        for pair in &self.pairs {
            let Some(r) = pair.correlation.filter(|r| r.abs() >= CORRELATED) else { continue };
            let [a, b] = pair.axes.map(Axis::symbol);
            named.extend(pair.axes);
            let how = if r > 0.0 { "together" } else { "against each other" };
            let own = Finding::new(Id::MovesTogether, Doubtful, format!("{a} and {b} move {how}"));
            found.push(own.with(format!("correlation {r:.2}")));
        }
        if spread.n_directions < spread.n_moving() {
            return found;
        }
        for own in self.axes.iter().filter(|own| !named.contains(&own.axis)) {
            if let Some(inflation) = own.inflation.filter(|inflation| *inflation >= INFLATION_SAID)
            {
                let (symbol, share) = (own.axis.symbol(), percent(1.0 - 1.0 / inflation));
                let seen = format!("{share} of what {symbol} does follows from the other axes");
                found.push(Finding::new(Id::NeverAlone, Doubtful, seen));
            }
        }
        found
    }

    fn hardly_determined(&self) -> Option<Finding> {
        let condition = self.condition.filter(|condition| *condition > CONDITION)?;
        let seen = "some combinations of features are hardly determined";
        let figures = format!("condition number {}", significant(condition, 2));
        Some(Finding::new(Id::HardlyDetermined, Doubtful, seen).with(figures))
    }
}

/// The axes whose left-out errors are no better than what the mean of the loads would do.
fn no_better_than_mean(by: &str, lost: &[(&AxisReach, f64)]) -> Option<Finding> {
    let one = |(own, error): &(&AxisReach, f64)| {
        let [error, mean] = [*error, own.deviation].map(|value| own.load(value));
        format!("{} errs by {error}, its mean alone by {mean}", own.axis.symbol())
    };
    let all: Vec<String> = lost.iter().map(one).collect();
    let seen = format!("left out {by}, {}", all.join("; "));
    (!all.is_empty()).then(|| Finding::new(Id::NoBetterThanMean, Insufficient, seen))
}

/// The axes whose left-out errors are many times those of the fit, and how many times at most.
fn larger_left_out(by: &str, errors: Vec<(&AxisReach, f64)>) -> Option<(f64, Finding)> {
    let times = errors.into_iter().filter_map(|(own, error)| {
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
    let others = others.iter();
    let others: Vec<String> = others
        .map(|(own, _, times)| format!("{} {} times", own.axis.symbol(), significant(*times, 2)))
        .collect();
    Some((*most, Finding::new(Id::LargerLeftOut, Insufficient, seen).with(others.join(", "))))
}

impl AxisReach {
    fn load(&self, value: f64) -> String {
        format!("{} {}", significant(value, 3), self.axis.unit())
    }

    /// A rated load that was reached one way only, where the other is rated as well.
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
            Finding::new(Id::OneSided, Doubtful, seen).with(figures)
        })
    }

    /// The part of a rated load that was not reached.
    fn not_reached(&self) -> Option<Finding> {
        if !self.rated || self.full_scale <= 0.0 || self.deviation == 0.0 {
            return None;
        }
        let ends = [(self.region.0, self.low), (self.region.1, self.high)];
        let reached = ends.into_iter().filter(|(end, _)| *end != 0.0);
        let short: Vec<String> = reached
            .map(|(end, reached)| (end, (reached / end).max(0.0)))
            .filter(|(_, share)| *share < REACHED)
            .map(|(end, share)| format!("{} of {}", percent(share), self.load(end)))
            .collect();
        let seen = format!("{} reaches {} only", self.axis.symbol(), short.join(" and "));
        (!short.is_empty()).then(|| Finding::new(Id::NotReached, Doubtful, seen))
    }
}
