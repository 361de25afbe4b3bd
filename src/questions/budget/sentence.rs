//! The sentences that say where an error comes from, where the data allow them.

use crate::{
    questions::budget::query::ErrorBudget,
    scoring::{
        budget::{Budget, Cause, Shares},
        numbers::significant,
    },
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
/// Share of the mean squared error from which it is said what the compensation does to a cause.
const LEAST_BEFORE: f64 = 0.1;
/// Part of a cause's share that is left, below which the cause is gone.
const GONE: f64 = 0.25;
/// Part of a cause's share by which the whole error must fall, if the cause is gone.
const LEAST_FALL: f64 = 0.5;
/// Largest factor between the mean squared errors of the fit's cross-validation and of the budget's own fits.
const MOST_SCALED: f64 = 1.25;

impl ErrorBudget {
    /// Returns the sentences about the errors of each pool of axes.
    pub fn sentences(&self) -> Vec<String> {
        (0..self.pools.len()).map(|pool| sentence(self, pool)).collect()
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
    for words in gone(before, &of.uncompensated, after) {
        text += &format!(", {words}: gone");
    }
    text.extend(mostly(after, budget).map(|words| format!("; what is left is mostly {words}")));
    text + "."
}

/// Returns true if the shares say which cause is the largest.
fn is_sure(shares: &Shares) -> bool {
    let factor = shares.factor.max(1.0 / shares.factor);
    shares.over_in_sample <= MOST_OVER_IN_SAMPLE && factor <= MOST_SCALED
}

/// Shares of an error: each cause alone, but hysteresis, creep and lag together.
struct Part<'a> {
    causes: Vec<Cause>,
    square: f64,
    or: Vec<&'a Cause>,
}

fn parts(shares: &Shares) -> Vec<Part<'_>> {
    let mut parts: Vec<Part<'_>> = Vec::new();
    for own in &shares.shares {
        let is_history = own.cause.is_history();
        let same = parts.iter_mut().find(|part| is_history && part.causes[0].is_history());
        let or = own.or.iter().filter(|other| !(is_history && other.is_history()));
        match same {
            Some(part) => {
                part.causes.push(own.cause);
                part.square += own.square;
                part.or.extend(or);
            }
            None => {
                parts.push(Part { causes: vec![own.cause], square: own.square, or: or.collect() })
            }
        }
    }
    parts.sort_by(|a, b| b.square.total_cmp(&a.square));
    parts
}

impl Part<'_> {
    fn words(&self, budget: &Budget) -> String {
        let words = |cause: &Cause| match cause {
            Cause::Zeros if !budget.are_segments => {
                "slow changes between recordings (zeros, temperature or slow creep)"
            }
            cause => cause.name(budget.are_segments),
        };
        let causes: Vec<&str> = self.causes.iter().map(words).collect();
        let mut or: Vec<Cause> = self.or.iter().copied().copied().collect();
        or.sort_unstable();
        or.dedup();
        let or = or.iter().map(|other| format!(" or {}", other.name(budget.are_segments)));
        causes.join(" and ") + &or.collect::<String>()
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
    let in_model = |part: &Part<'_>| part.causes.iter().any(|own| budget.in_model.contains(own));
    let parts: Vec<Part<'_>> = parts(shares).into_iter().filter(|own| !in_model(own)).collect();
    match &parts[..] {
        [first, ..] if first.square >= MOST * shares.total => Some(first.words(budget)),
        [first, second, ..] if first.square + second.square >= MOST_OF_TWO * shares.total => {
            Some(format!("{}, and {}", first.words(budget), second.words(budget)))
        }
        _ => None,
    }
}

/// Returns the causes of the uncompensated error that the compensation removes.
fn gone(before: &Shares, budget: &Budget, after: &Shares) -> Vec<String> {
    let rise = (after.unexplained - before.unexplained).max(0.0);
    let all_after = parts(after);
    let large = |own: &Part<'_>| own.square >= LEAST_BEFORE * before.total;
    let is_gone = |own: &&Part<'_>| {
        let is_same = |other: &&Part<'_>| {
            other.causes.iter().any(|cause| {
                own.causes.contains(cause) || (cause.is_history() && own.causes[0].is_history())
            })
        };
        let left = all_after.iter().find(is_same).map_or(0.0, |part| part.square);
        let fell = before.total - after.total >= LEAST_FALL * own.square;
        fell && left + rise < GONE * own.square && left < MOST * after.total
    };
    let parts = parts(before);
    let gone = parts.iter().filter(|own| large(own) && is_gone(own));
    gone.map(|own| own.words(budget)).collect()
}
