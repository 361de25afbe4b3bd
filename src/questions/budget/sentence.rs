//! The sentences that say where an error comes from, where the data allow them.

use crate::{
    questions::budget::query::ErrorBudget,
    scoring::{
        budget::{Budget, Cause, Share, Shares},
        numbers::significant,
    },
    shown::joined,
};

/// Ratio of the held-out to the in-sample mean squared error, above which nothing is said.
const MOST_OVER_IN_SAMPLE: f64 = 3.0;
/// Minimum number of recordings.
const FEWEST_RECORDINGS: usize = 4;
/// Share of the mean squared error from which a cause is most of it, and that of two causes together.
const MOST: f64 = 0.5;
const MOST_OF_TWO: f64 = 0.6;
/// Ratio of the compensated to the uncompensated RMS error, above which the compensation makes the error larger.
const WORSE: f64 = 1.1;
/// Largest factor between the mean squared errors of the fit's cross-validation and of the budget's own fits.
const MOST_SCALED: f64 = 1.25;

impl ErrorBudget {
    /// Returns the sentences about the errors of each pool of axes.
    pub fn sentences(&self) -> Vec<String> {
        (0..self.pools.len()).map(|pool| sentence(self, pool)).collect()
    }

    /// Returns the share of the uncompensated mean square that curvature, hysteresis, creep, lag and auxiliary channels have.
    pub fn explained_by_columns(&self) -> f64 {
        let (mut explained, mut total) = (0.0, 0.0);
        for own in self.uncompensated.axes.iter().flatten() {
            let known = own.shares.iter().filter(|own| Cause::WITH_COLUMNS.contains(&own.cause));
            explained += known.map(|own| own.square).sum::<f64>();
            total += own.total;
        }
        if total > 0.0 { explained / total } else { 0.0 }
    }

    /// Returns what most of an error is; `None` if the recordings do not tell surely.
    pub fn mostly(&self, shares: &Shares, budget: &Budget) -> Option<String> {
        let is_known = self.uncompensated.n_recordings >= FEWEST_RECORDINGS && is_sure(shares);
        is_known.then(|| mostly(shares, budget))?
    }
}

fn sentence(of: &ErrorBudget, pool: usize) -> String {
    let before = match &of.uncompensated.pools[pool] {
        Ok(before) => before,
        Err(reason) => return format!("{} are not split: {reason}.", of.pools[pool]),
    };
    let percent = |shares: &Shares| significant(100.0 * shares.total.sqrt(), 3);
    let error = format!("{}: {} % FS", of.pools[pool], percent(before));
    let n = of.uncompensated.n_recordings;
    if n < FEWEST_RECORDINGS {
        return format!("{error}. Four recordings or more tell which cause is the largest.");
    }
    if !is_sure(before) {
        return format!("{error}. The recordings do not tell surely which cause is the largest.");
    }
    let mut text = error;
    text.extend(mostly(before, &of.uncompensated).map(|words| format!(", mostly {words}")));
    let Some(budget) = &of.compensated else { return text + "." };
    let Ok(after) = &budget.pools[pool] else { return text + "." };
    if after.total > WORSE * WORSE * before.total {
        return format!(
            "{text}. The compensation makes the error larger: {} % FS.",
            percent(after)
        );
    }
    text += &format!(". Compensated: {} % FS", percent(after));
    if !is_sure(after) {
        return text + ".";
    }
    text.extend(mostly(after, budget).map(|words| format!("; what is left is mostly {words}")));
    text + "."
}

/// Returns true if the shares say which cause is the largest.
fn is_sure(shares: &Shares) -> bool {
    let factor = shares.factor.max(1.0 / shares.factor);
    shares.over_in_sample <= MOST_OVER_IN_SAMPLE && factor <= MOST_SCALED
}

/// Share of an error: one cause, or hysteresis, creep and lag together.
struct Part {
    causes: Vec<Cause>,
    square: f64,
    or: Vec<Cause>,
}

fn parts(shares: &Shares) -> Vec<Part> {
    let (history, others): (Vec<&Share>, Vec<&Share>) =
        shares.shares.iter().partition(|own| own.cause.is_history());
    let others = others.into_iter().map(|own| vec![own]);
    let groups = [history].into_iter().chain(others).filter(|own| !own.is_empty());
    let mut parts: Vec<Part> = groups
        .map(|own| {
            let is_history = own[0].cause.is_history();
            let or = own.iter().flat_map(|own| own.or.iter().copied());
            let mut or: Vec<Cause> = or.filter(|or| !(is_history && or.is_history())).collect();
            or.sort_unstable();
            or.dedup();
            let causes = own.iter().map(|own| own.cause).collect();
            Part { causes, square: own.iter().map(|own| own.square).sum(), or }
        })
        .collect();
    parts.sort_by(|a, b| b.square.total_cmp(&a.square));
    parts
}

impl Part {
    fn words(&self, budget: &Budget) -> String {
        let words = |cause: &Cause| match cause {
            Cause::Zeros if !budget.are_segments => {
                "slow changes between recordings (zeros, temperature or slow creep)"
            }
            cause => cause.name(budget.are_segments),
        };
        let or = self.or.iter().map(|other| format!(" or {}", other.name(budget.are_segments)));
        joined(" and ", self.causes.iter().map(words)) + &or.collect::<String>()
    }
}

/// Returns what most of the error is; `None` if it is not one cause, or two.
fn mostly(shares: &Shares, budget: &Budget) -> Option<String> {
    if shares.unexplained >= MOST * shares.total {
        return Some("not told apart".to_owned());
    }
    if shares.noise >= MOST * shares.total {
        return Some("noise".to_owned());
    }
    let in_model = |part: &Part| part.causes.iter().any(|own| budget.in_model.contains(own));
    let parts: Vec<Part> = parts(shares).into_iter().filter(|own| !in_model(own)).collect();
    match &parts[..] {
        [first, ..] if first.square >= MOST * shares.total => Some(first.words(budget)),
        [first, second, ..] if first.square + second.square >= MOST_OF_TWO * shares.total => {
            Some(format!("{}, and {}", first.words(budget), second.words(budget)))
        }
        _ => None,
    }
}
