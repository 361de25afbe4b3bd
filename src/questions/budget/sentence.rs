//! The sentence that says where an error comes from, where the data allow one.

use crate::scoring::budget::{Budget, Cause, Shares};

/// Ratio of the held-out to the in-sample mean squared error, above which nothing is said.
const MOST_OVER_IN_SAMPLE: f64 = 3.0;
/// Minimum number of recordings.
const FEWEST_RECORDINGS: usize = 4;
/// Share of the mean squared error from which a cause is most of it, and that of two causes together.
const MOST: f64 = 0.5;
const MOST_OF_TWO: f64 = 0.6;

/// Returns the name of a cause, as it is written in a sentence.
pub fn name(cause: Cause, budget: &Budget) -> &'static str {
    match cause {
        Cause::Curvature => "curvature",
        Cause::Hysteresis => "hysteresis",
        Cause::Creep => "creep",
        Cause::Lag => "lag",
        Cause::Zeros if budget.are_segments => "slow changes (zero, drift, slow creep)",
        Cause::Zeros => "zeros between recordings",
        Cause::Drift => "drift",
        Cause::Sensitivity => "sensitivity",
        Cause::Temperature => "auxiliary channels",
    }
}

/// Returns what most of the error is, such as "mostly creep"; `None` if the data do not tell it surely.
pub fn mostly(shares: &Shares, budget: &Budget) -> Option<String> {
    let is_sure =
        budget.n_recordings >= FEWEST_RECORDINGS && shares.over_in_sample <= MOST_OVER_IN_SAMPLE;
    if !is_sure {
        return None;
    }
    if shares.unexplained >= MOST * shares.total {
        return Some("mostly not told apart".to_owned());
    }
    if shares.noise >= MOST * shares.total {
        return Some("mostly noise".to_owned());
    }
    let (history, others): (Vec<_>, Vec<_>) =
        shares.shares.iter().partition(|own| own.cause.is_history());
    let mut causes: Vec<(String, f64)> = others
        .iter()
        .filter(|own| !budget.in_model.contains(&own.cause))
        .map(|own| {
            let or = own.or.iter().map(|other| format!(" or {}", name(*other, budget)));
            let of_zeros = "slow changes between recordings (zeros, temperature or slow creep)";
            let words = if own.cause == Cause::Zeros { of_zeros } else { name(own.cause, budget) };
            (format!("{words}{}", or.collect::<String>()), own.square)
        })
        .collect();
    let names: Vec<&str> = history.iter().map(|own| name(own.cause, budget)).collect();
    if !names.is_empty() {
        causes.push((names.join(" and "), history.iter().map(|own| own.square).sum()));
    }
    causes.sort_by(|a, b| b.1.total_cmp(&a.1));
    match &causes[..] {
        [(first, square), ..] if *square >= MOST * shares.total => Some(format!("mostly {first}")),
        [(first, a), (second, b), ..] if a + b >= MOST_OF_TWO * shares.total => {
            Some(format!("mostly {first}, and {second}"))
        }
        _ => None,
    }
}
