//! Quantities of the metrology table, and their definitions.

use std::mem::discriminant;

use serde::Serialize;

use crate::recording::Axis;

/// Quantity that a row of the metrology table shows, defined in [`QUANTITIES`]. A crosstalk quantity contains the loaded
/// axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    Hysteresis,
    MeanLoopHysteresis,
    LoopArea,
    TerminalNonlinearity,
    BestFitNonlinearity,
    CombinedError,
    Repeatability,
    ZeroReturn,
    TimeLag,
    HysteresisWithoutLag,
    Creep,
    CreepTime,
    CreepRecovery,
    Noise,
    NoisePeakToPeak,
    TemperatureZero,
    TemperatureSpan,
    Crosstalk(Axis),
    Rmse,
    LargestError,
    Error95,
}

#[derive(Clone, Debug, Serialize)]
pub struct Definition {
    /// Short, constant id of the quantity, for programs that read the table.
    pub id: String,
    pub name: String,
    pub definition: &'static str,
    /// Standard or book from which the definition is taken.
    pub source: &'static str,
    /// Conditions that the source of the definition requires and a free-running recording does not meet; may be empty.
    pub free_running: &'static str,
}

impl Definition {
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
    pub fn all(axes: &[Axis]) -> Vec<Self> {
        let all = QUANTITIES.iter().flat_map(|(quantity, _)| match quantity {
            Self::Crosstalk(_) => axes.iter().copied().map(Self::Crosstalk).collect(),
            single => vec![*single],
        });
        all.collect()
    }

    /// Returns the loaded axis of a crosstalk row; `None` for any other row.
    pub fn crosstalk_from(self) -> Option<Axis> {
        match self {
            Self::Crosstalk(axis) => Some(axis),
            _ => None,
        }
    }

    /// Returns true if the figures of the quantity are times in seconds, not loads.
    pub fn is_time(self) -> bool {
        matches!(self, Self::CreepTime | Self::TimeLag)
    }

    /// Returns the unit of the figures for this axis.
    pub fn unit(self, axis: Axis) -> &'static str {
        match self {
            Self::LoopArea if axis.is_force() => "N²",
            Self::LoopArea => "(N·m)²",
            _ if self.is_time() => "s",
            _ => axis.unit(),
        }
    }

    pub fn definition(self) -> Definition {
        let is_own = |(of, _): &&(Self, _)| discriminant(of) == discriminant(&self);
        let (_, texts) = QUANTITIES.iter().find(is_own).expect("QUANTITIES defines every quantity");
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

const ONE_AXIS_AT_REST: &str = "the standard loads one axis alone, in steps, and reads at set times after each step; here other axes may be loaded too, and their effect at equal load counts as loop width";

/// All quantities in the order of the metrology table, each with the five texts of its [`Definition`]. Crosstalk is listed
/// for Fx only.
const QUANTITIES: [(Quantity, [&str; 5]); 21] = [
    (
        Quantity::Hysteresis,
        [
            "hysteresis",
            "Hysteresis",
            "largest |falling − rising| of the output at equal load, in the cycle whose branches share the largest range of loads. Cycles are counted by rainflow. Both branches, of which smaller cycles are left out, are averaged over hundredths of their range and compared at 101 loads. The difference is averaged over neighbouring loads, up to 12 on each side, until its noise is at most a fiftieth of the largest difference",
            "OIML R 60-1, 3.7 (difference at the same load, rising from the minimum and falling from the maximum); relative to full scale, because VDI/VDE 2638 refers errors to the nominal load",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::MeanLoopHysteresis,
        [
            "hysteresis_mean_loop",
            "Hysteresis, mean loop",
            "largest |falling − rising| of the mean loop. The mean loop averages all cycles that cover at least 80 % of the largest cycle's range, at the loads that these cycles have in common. A mean loop needs at least three cycles, and their common loads must cover more than half of the load range",
            "as for Hysteresis; this program also averages the cycles, to keep what repeats and to reduce effects of loads on other axes",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::LoopArea,
        [
            "loop_area",
            "Loop area",
            "integral of |falling − rising| of the output over the load, across the load range of the mean loop, or without a mean loop of the largest cycle; in percent, relative to the square of full scale",
            "as for Hysteresis; the area divided by the range of the loads is the mean width",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::TerminalNonlinearity,
        [
            "nonlinearity_terminal",
            "Nonlinearity, terminal line",
            "largest deviation of the mean rising branch from the straight line through its two ends, averaged over hundredths of the range and over the cycles of the mean loop (without a mean loop, in the largest cycle). On a staircase, the last third of each step is averaged instead. Elsewhere, the deviation is averaged over neighbours as for Hysteresis. The mean square of the noise is subtracted from the square of the deviation. A deviation below three standard deviations of the noise is \"below noise\"",
            "load-cell makers' glossaries: from no load to rated load, rising only",
            "the branch goes from the minimum to the maximum recorded load, not from no load to rated load, and the hysteresis of earlier loads affects its start",
        ],
    ),
    (
        Quantity::BestFitNonlinearity,
        [
            "nonlinearity_best_fit",
            "Nonlinearity, best-fit line",
            "as for Nonlinearity, terminal line, but from the least-squares line, with equal weight for every hundredth of the range, or for every step of a staircase",
            "sensor makers' data sheets (best-fit straight line), rising only",
            "as for Nonlinearity, terminal line",
        ],
    ),
    (
        Quantity::CombinedError,
        [
            "combined_error",
            "Combined error",
            "largest deviation of both mean branches from the line through the ends of the rising branch; noise as for Nonlinearity, terminal line",
            "load-cell makers' glossaries: nonlinearity and hysteresis in one figure",
            "as for Hysteresis and for Nonlinearity, terminal line",
        ],
    ),
    (
        Quantity::Repeatability,
        [
            "repeatability",
            "Repeatability",
            "largest difference at equal load between branches of the same direction, in two or more successive, repeated cycles, without its noise; the maximum of all recordings. Cycles are repeated if they turn at the same loads within 5 % of the largest cycle's range, and the loads of all other axes agree within 5 % of full scale at equal load",
            "load-cell makers' glossaries: same load, same direction, same conditions",
            "the conditions, for example the speed, may differ between the repeated cycles of a recording",
        ],
    ),
    (
        Quantity::TimeLag,
        [
            "time_lag",
            "Time lag",
            "delay of the output behind the reference, or time constant of a first-order low-pass, whichever has the smaller residual. Found by least squares on the delayed reference of all axes, its play operators of several radii, its squares and cubes, \
             and slow creep. Assumptions: one lag for all loads; hysteresis that does not depend on the rate; creep slower than three times the time in which the load changes by its own standard deviation",
            "system identification; no standard defines a time lag of the sensor",
            "the load must move at rates that differ by a factor of about two: at one rate, lag and hysteresis look alike",
        ],
    ),
    (
        Quantity::HysteresisWithoutLag,
        [
            "hysteresis_without_lag",
            "Hysteresis, lag removed",
            "hysteresis of the mean loop (without a mean loop, of the largest cycle) after the reference is delayed by the lag of the output. Gains and crosstalk of the output are fitted again to the delayed reference by least squares on these recordings. The figure is given if the lag explains more than a tenth of the mean loop width, and if the hysteresis changes by at most a tenth, or by 0.3 % of full scale, when the lag is changed by two standard errors",
            "as for Hysteresis",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::ZeroReturn,
        [
            "zero_return",
            "Zero return",
            "mean of output − load in the first seconds at zero after the axis was loaded, minus the mean in the last seconds at zero before the load; the largest change in all recordings, with its sign. Both intervals are as long as the shortest dwell",
            "OIML R 60-1, 2.1.5 (output at minimum load after a load, minus the output before)",
            "the standard applies the load for 30 min; here the time depends on the recording",
        ],
    ),
    (
        Quantity::Creep,
        [
            "creep",
            "Creep",
            "change of output − load from the beginning to the end of the longest dwell with the axis loaded, on a fitted first-order \
        exponential, with its sign",
            "OIML R 60-1, 2.1.5 (change of the output under a constant load)",
            "the standard holds 90 to 100 % of the maximum load for 30 min; here half of full scale is enough, and the time depends on the recording",
        ],
    ),
    (
        Quantity::CreepTime,
        [
            "creep_time_constant",
            "Creep, time constant",
            "τ of output − load = a + b (1 − exp(−t / τ)), fitted to the dwell of the creep figure",
            "a first-order creep element; no standard defines its time constant",
            "",
        ],
    ),
    (
        Quantity::CreepRecovery,
        [
            "creep_recovery",
            "Creep recovery",
            "change of output − load from the beginning to the end of the longest dwell at zero after the axis was loaded, on a \
        fitted first-order exponential, with its sign",
            "load-cell makers' glossaries: change of zero after a held load is removed",
            "here the load may have been removed without being held before",
        ],
    ),
    (
        Quantity::Noise,
        [
            "noise",
            "Noise, RMS",
            "standard deviation of the output's white noise at the sampling rate in the longest dwell: of each value minus the mean of its two neighbours, divided by √1.5. Without a dwell, it is that of the noisiest recording, from the median",
            "statistics; no standard defines this figure",
            "",
        ],
    ),
    (
        Quantity::NoisePeakToPeak,
        [
            "noise_peak_to_peak",
            "Noise, peak to peak",
            "largest minus smallest of the values from which Noise, RMS is computed, in the longest dwell",
            "statistics; no standard defines this figure",
            "a longer dwell has a larger value",
        ],
    ),
    (
        Quantity::TemperatureZero,
        [
            "temperature_zero",
            "Temperature effect on zero",
            "change of output − load at zero load for 10 °C, by least squares on the load, the first channel in °C, and their product. Its uncertainty comes from leaving out each tenth of the samples",
            "OIML R 60-1 and VDI/VDE 2638 (temperature effect on the zero signal)",
            "the standards wait until the temperature is equal everywhere; a gradient has other effects",
        ],
    ),
    (
        Quantity::TemperatureSpan,
        [
            "temperature_span",
            "Temperature effect on span",
            "further change of output − load at full scale for 10 °C; from the product in Temperature effect on zero",
            "OIML R 60-1 and VDI/VDE 2638 (temperature effect on the sensitivity)",
            "as for Temperature effect on zero",
        ],
    ),
    (
        Quantity::Crosstalk(Axis::Fx),
        [
            "crosstalk_from",
            "Crosstalk from Fx",
            "error (output − load) of the axis at full load of the named axis alone: slope of a least-squares line with an offset for each recording, times the full scale of the loaded axis. Only samples count in which all other axes are within 2 % of full scale, and the loaded axis must reach 50 % of its full scale (both shares can be set)",
            "common practice for multi-axis sensors",
            "a calibration bench loads one axis at a time; here the other axes may carry up to 2 % of full scale, and drift and hysteresis of the axis under the load also count as crosstalk",
        ],
    ),
    (
        Quantity::Rmse,
        [
            "rmse",
            "RMSE",
            "root mean square of output − load over all samples",
            "statistics; no standard defines this error figure",
            "",
        ],
    ),
    (
        Quantity::LargestError,
        [
            "largest_error",
            "Largest error",
            "largest |output − load| over all samples",
            "statistics; no standard defines this error figure",
            "",
        ],
    ),
    (
        Quantity::Error95,
        [
            "error_95",
            "95 % error",
            "|output − load| that 95 % of all samples do not exceed",
            "statistics; makers of multi-axis sensors state accuracy per axis in percent of full scale",
            "neighbouring samples are correlated, so the 95 % are a share of time, not a confidence level",
        ],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_row_has_its_own_id_and_a_definition() {
        let all = Quantity::all(&Axis::ALL);
        assert_eq!(all.len(), 26);
        let definitions = all.iter().map(|quantity| quantity.definition());
        let ids: HashSet<String> = definitions
            .inspect(|row| assert!(!row.definition.is_empty() && !row.source.is_empty()))
            .map(|row| row.id)
            .collect();
        assert_eq!(ids.len(), all.len());
        assert!(ids.contains("crosstalk_from_fx"));
    }
}
