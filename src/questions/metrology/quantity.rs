//! What the table has rows of: each quantity with its definition, its source, and what a free-running recording lacks.

use std::mem::discriminant;

use serde::Serialize;

use crate::recording::Axis;

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Largest width of the largest cycle's loop.
    Hysteresis,
    /// Largest width of the mean loop of the full cycles.
    MeanLoopHysteresis,
    /// Mean width of that loop.
    MeanWidth,
    /// Rising branch against the line between its ends.
    TerminalNonlinearity,
    /// Rising branch against its best-fit line.
    BestFitNonlinearity,
    /// Both branches against the line between the ends of the rising one.
    CombinedError,
    /// Spread of repeated branches of one recording.
    Repeatability,
    /// Output at zero after a load less that before.
    ZeroReturn,
    /// How late the output is behind the reference.
    TimeLag,
    /// Hysteresis with the output and the reference brought to one time.
    HysteresisWithoutLag,
    /// Change of the output under a load that stands still.
    Creep,
    /// Time constant of that change.
    CreepTime,
    /// Change of the output at zero after a load.
    CreepRecovery,
    /// Response at full load of this axis alone.
    Crosstalk(Axis),
    /// Largest systematic deviation while this axis alone is loaded.
    CrosstalkDeviation(Axis),
    /// Root mean squared error.
    Rmse,
    /// Largest error.
    LargestError,
    /// What 95 % of the errors stay within.
    Error95,
}

/// What a row means, for whoever reads it in the window, in a file or in print.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Definition {
    /// Short and stable, for programs.
    pub id: String,
    /// Short, for people.
    pub name: String,
    /// How it is computed.
    pub definition: &'static str,
    /// Whose definition it follows.
    pub source: &'static str,
    /// Which conditions of that source a free-running recording does not meet; empty where there are none.
    pub free_running: &'static str,
}

impl Definition {
    /// How it is computed, whose definition that follows, and what a free-running recording does not meet: a sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let mut sentences =
            vec![format!("{}.", self.definition), format!("Source: {}.", self.source)];
        if !self.free_running.is_empty() {
            sentences.push(format!("Free-running: {}.", self.free_running));
        }
        sentences
    }
}

impl Quantity {
    /// All rows for these axes, in the order of the table.
    pub fn all(axes: &[Axis]) -> Vec<Self> {
        let all = QUANTITIES.iter().flat_map(|(quantity, _)| match quantity {
            Self::Crosstalk(_) => axes.iter().copied().map(Self::Crosstalk).collect(),
            Self::CrosstalkDeviation(_) => {
                axes.iter().copied().map(Self::CrosstalkDeviation).collect()
            }
            own => vec![*own],
        });
        all.collect()
    }

    /// The axis that is loaded while the others are read, for crosstalk.
    pub fn crosstalk_from(self) -> Option<Axis> {
        match self {
            Self::Crosstalk(axis) | Self::CrosstalkDeviation(axis) => Some(axis),
            _ => None,
        }
    }

    /// What the row is called whichever axis is loaded; `None` where the definition's name says it.
    pub fn general_name(self) -> Option<&'static str> {
        match self {
            Self::Crosstalk(_) => Some("Crosstalk"),
            Self::CrosstalkDeviation(_) => Some("Crosstalk, largest"),
            _ => None,
        }
    }

    /// Whether the figures are times in seconds rather than loads.
    pub fn is_time(self) -> bool {
        matches!(self, Self::CreepTime | Self::TimeLag)
    }

    /// What the row means.
    pub fn definition(self) -> Definition {
        let is_own = |(of, _): &&(Self, _)| discriminant(of) == discriminant(&self);
        let (_, texts) = QUANTITIES.iter().find(is_own).expect("every quantity has a row");
        let [id, name, definition, source, free_running] = *texts;
        let (id, name) = match self.crosstalk_from() {
            None => (id.to_owned(), name.to_owned()),
            Some(axis) => {
                let symbol = axis.symbol();
                (format!("{id}_{}", symbol.to_lowercase()), name.replace("Fx", symbol))
            }
        };
        Definition { id, name, definition, source, free_running }
    }
}

const OTHERS_NEARLY_UNLOADED: &str = "a bench loads one axis at a time and everything else with nothing; here the others may \
    carry up to 2 %, and what drift and hysteresis of the axis do along with the load counts too";

const ONE_AXIS_AT_REST: &str = "the standard loads one axis alone, in steps, and reads at set times after each step; here \
    other axes may be loaded too, and what they add at equal load counts as width";

/// All quantities in the order of the table, crosstalk as from Fx, each with its id, name, definition, source, and what a free-running
/// recording lacks.
const QUANTITIES: [(Quantity, [&str; 5]); 18] = [
    (
        Quantity::Hysteresis,
        [
            "hysteresis",
            "Hysteresis",
            "largest |falling − rising| output at equal load, in the one cycle (counted by rainflow) whose branches share the widest \
        range of loads; branches, without the cycles on their way, averaged over hundredths of their range and compared at 101 \
        loads; noise of the difference is averaged over up to 12 neighbouring loads to each side, as few as make it a fiftieth of the \
        largest",
            "OIML R 60-1, 3.7 (difference at the same load, up from the least and down from the greatest); over full scale, as \
        VDI/VDE 2638 refers errors to the nominal load",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::MeanLoopHysteresis,
        [
            "hysteresis_mean_loop",
            "Hysteresis, mean loop",
            "largest |falling − rising| of the mean loop of all cycles that cover at least 80 % of the largest one's range, over the \
        loads that all of them have; of three cycles or more, over more than half of all loads",
            "as hysteresis; averaging over cycles is this program's, as it leaves what repeats and drops what other axes happened to \
        do",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::MeanWidth,
        [
            "hysteresis_mean_width",
            "Hysteresis, mean width",
            "mean |falling − rising| over the load range of the mean loop",
            "as the mean loop; noise is averaged as for hysteresis, so it hardly raises the mean of a loop that is closed",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::TerminalNonlinearity,
        [
            "nonlinearity_terminal",
            "Nonlinearity, terminal line",
            "largest deviation of the rising branch of the largest cycle from the straight line through its ends (the outer \
        averages over hundredths of its range, carried on to the ends)",
            "load-cell makers' glossaries: from no load to rated load, rising only",
            "the branch goes from the least to the greatest load that was recorded, not from no load to rated load, and its start \
        still carries hysteresis of what was before",
        ],
    ),
    (
        Quantity::BestFitNonlinearity,
        [
            "nonlinearity_best_fit",
            "Nonlinearity, best-fit line",
            "largest deviation of the rising branch of the largest cycle from its least-squares line, every hundredth of its range \
        counting alike",
            "sensor makers' data sheets (best-fit straight line), rising only",
            "as for the terminal line",
        ],
    ),
    (
        Quantity::CombinedError,
        [
            "combined_error",
            "Combined error",
            "largest deviation of both branches of the largest cycle from the line through the ends of the rising one",
            "load-cell makers' glossaries: nonlinearity and hysteresis in one figure",
            "as for hysteresis and nonlinearity",
        ],
    ),
    (
        Quantity::Repeatability,
        [
            "repeatability",
            "Repeatability",
            "largest difference at equal load between branches that go the same way, of two or more cycles that follow each other and \
        repeat: they turn at the same loads within 5 % of the largest cycle's range, and at equal load every other axis is \
        loaded alike within 5 % of its full scale; the worst recording",
            "load-cell makers' glossaries: same load, same direction, same conditions",
            "conditions are the same only as far as the recording repeats itself: the speed may differ from cycle to cycle",
        ],
    ),
    (
        Quantity::TimeLag,
        [
            "time_lag",
            "Time lag",
            "how late the output is behind the reference, as a delay or as the time constant of a first-order low-pass, whichever leaves \
             less over; by least squares on the late reference of all axes, its play operators of several radii, its squares and cubes, \
             and slow creep. Assumed: one lag for all loads, hysteresis that does not depend on the rate, creep slower than three \
             times the time in which the load moves by its own size",
            "system identification; no standard asks for it",
            "the load must move at rates that differ by a factor of about two: at one rate, lag and hysteresis look alike",
        ],
    ),
    (
        Quantity::HysteresisWithoutLag,
        [
            "hysteresis_without_lag",
            "Hysteresis, lag removed",
            "as hysteresis of the mean loop (of the largest cycle where there is no mean loop), over the reference made as late as the \
             output, by the same delay or low-pass; the gains of the output, and its crosstalk, fitted anew to that reference by \
             least squares over these recordings. Given where the lag explains \
             more than a tenth of the mean width, and where two standard errors of the lag change it by at most a tenth of itself or \
             0.3 % of full scale",
            "as hysteresis",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::ZeroReturn,
        [
            "zero_return",
            "Zero return",
            "mean output − load over the first seconds at zero after the axis was loaded, less that over the last seconds at zero \
        before (seconds: the shortest hold); the largest of the recordings, with its sign",
            "OIML R 60-1, 2.1.5 (output at the least load after a load less that before)",
            "the standard keeps the load on for 30 min; here it is as long as the recording has it",
        ],
    ),
    (
        Quantity::Creep,
        [
            "creep",
            "Creep",
            "change of output − load from the beginning to the end of the longest hold with the axis loaded, on a fitted first-order \
        exponential, with its sign",
            "OIML R 60-1, 2.1.5 (change of the output under a constant load)",
            "the standard holds 90 to 100 % of the greatest load for 30 min; here half of full scale is enough, and the hold is as \
        long as the recording has it",
        ],
    ),
    (
        Quantity::CreepTime,
        [
            "creep_time_constant",
            "Creep, time constant",
            "τ of output − load = a + b (1 − exp(−t / τ)), fitted over the hold that gives the creep",
            "a first-order creep element; no standard asks for it",
            "",
        ],
    ),
    (
        Quantity::CreepRecovery,
        [
            "creep_recovery",
            "Creep recovery",
            "change of output − load from the beginning to the end of the longest rest at zero after the axis was loaded, on a \
        fitted first-order exponential, with its sign",
            "load-cell makers' glossaries: change of zero after a load that was held is removed",
            "the load need not have been held before it was removed",
        ],
    ),
    (
        Quantity::Crosstalk(Axis::Fx),
        [
            "crosstalk_from",
            "Crosstalk from Fx",
            "what the axis reads, output − load, at full load of the other named axis alone: slope of a least-squares line, each \
        recording with an offset of its own, times the full scale of the loaded axis; over the samples in which the others \
        stay within 2 % of their full scale, where the loaded one reaches 50 % of its own or more (shares can be chosen)",
            "common practice for multi-axis sensors",
            OTHERS_NEARLY_UNLOADED,
        ],
    ),
    (
        Quantity::CrosstalkDeviation(Axis::Fx),
        [
            "crosstalk_deviation_from",
            "Crosstalk from Fx, largest",
            "largest systematic deviation of the axis while the other named axis alone is loaded: output − load less its value at no \
        load, averaged over tenths of the full scale of the loaded axis; an average within three standard errors counts as \
        nothing",
            "as crosstalk; with what is not linear in the load",
            OTHERS_NEARLY_UNLOADED,
        ],
    ),
    (
        Quantity::Rmse,
        [
            "rmse",
            "RMSE",
            "root of the mean squared output − load over all samples",
            "statistics; no standard asks for it",
            "",
        ],
    ),
    (
        Quantity::LargestError,
        [
            "largest_error",
            "Largest error",
            "largest |output − load| over all samples",
            "statistics; no standard asks for it",
            "",
        ],
    ),
    (
        Quantity::Error95,
        [
            "error_95",
            "95 % error",
            "95 % of all samples have an |output − load| of at most this",
            "statistics; makers of multi-axis sensors state accuracy per axis in percent of full scale",
            "neighbouring samples know of each other, so this is a share of time, not a confidence",
        ],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_row_has_an_id_of_its_own_and_says_what_it_is() {
        let all = Quantity::all(&Axis::ALL);
        assert_eq!(all.len(), 28);
        let definitions = all.iter().map(|quantity| quantity.definition());
        let ids: HashSet<String> = definitions
            .inspect(|row| assert!(!row.definition.is_empty() && !row.source.is_empty()))
            .map(|row| row.id)
            .collect();
        assert_eq!(ids.len(), all.len());
        assert!(ids.contains("crosstalk_from_fx"));
    }
}
