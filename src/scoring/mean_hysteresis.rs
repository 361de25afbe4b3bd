//! Mean hysteresis of the recordings. Koike et al. (2019) chose a force threshold F_th for the look-back that is close to it.
//!
//! Guarantees: hysteresis is measured on conventional loads. The look-back (search for an earlier load that differs by F_th)
//! compares the same loads. Cycles and reversals are those of the [loops](crate::scoring::loops).

use serde::Serialize;

use crate::{
    column::column,
    recording::Axis,
    scoring::loops::{Loop, Loops, default_reversal_threshold},
    shown::counted,
};

/// Minimum number of load reversals for a reliable mean hysteresis.
const FEWEST_REVERSALS: usize = 10;

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AxisHysteresis {
    pub axis: Axis,
    /// Mean loop width over the full cycles, in the unit of the force threshold F_th; `None` without a cycle.
    pub mean_width: Option<f64>,
    /// Number of full cycles, each with one reversal between its two branches.
    pub n_reversals: usize,
    /// Smallest change of the load that counts as a reversal, in the unit of the axis.
    pub reversal_threshold: f64,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MeanHysteresis {
    /// Mean of the loop widths over the axes with cycles, in the unit of the force threshold F_th; `None` without any cycle.
    pub value: Option<f64>,
    pub n_reversals: usize,
    /// Hysteresis of each axis whose load is compared with the force threshold F_th.
    pub axes: Vec<AxisHysteresis>,
}

/// Loads of one recording whose hysteresis is measured; `reference` is `n × n_axes`, row-major.
#[derive(Clone, Copy)]
pub struct HysteresisRun<'a> {
    pub reference: &'a [f64],
    /// Returns the conventional load of each sample on the axis with this index.
    pub conventional: &'a dyn Fn(usize) -> Vec<f64>,
}

/// Returns the mean hysteresis of these recordings. Panics unless there is one weight per axis.
///
/// The width of a cycle is the mean of `|falling − rising|` of the conventional load at equal reference load, over the range
/// that both branches cover. The value of an axis is the mean over its full cycles (see [`Loops::full_cycles`]). The value of
/// the sensor is the mean over its axes.
///
/// **Source** Koike et al. 2019, section 4.2: F_th = 3 N, "around the average hysteresis" of 2.64 N after rated load. The paper
/// does not define the average, so this definition is ours. If several axes are loaded at once, crosstalk adds to the width.
///
/// **Shapes** `weights` holds one factor per axis that converts its load to the unit of the force threshold F_th. The factor
/// is zero for an axis that is not compared with F_th; see [`Distance::weights`](crate::features::Distance::weights).
pub fn mean_hysteresis(
    runs: &[HysteresisRun<'_>],
    axes: &[Axis],
    weights: &[f64],
) -> MeanHysteresis {
    assert_eq!(axes.len(), weights.len(), "each axis has one weight");
    let counted = axes.iter().zip(weights).enumerate();
    let axes: Vec<AxisHysteresis> = counted
        .filter(|(_, (_, weight))| **weight > 0.0)
        .map(|(at, (axis, weight))| of_axis(runs, at, axes.len(), *axis, *weight))
        .collect();
    let widths: Vec<f64> = axes.iter().filter_map(|axis| axis.mean_width).collect();
    MeanHysteresis {
        value: mean(&widths),
        n_reversals: axes.iter().map(|axis| axis.n_reversals).sum(),
        axes,
    }
}

fn of_axis(
    runs: &[HysteresisRun<'_>],
    at: usize,
    n_axes: usize,
    axis: Axis,
    weight: f64,
) -> AxisHysteresis {
    let references: Vec<Vec<f64>> =
        runs.iter().map(|run| column(run.reference, n_axes, at).collect()).collect();
    let reversal_threshold = default_reversal_threshold(references.iter().map(Vec::as_slice));
    let loops = Loops::of(references.iter().map(Vec::as_slice), reversal_threshold);
    let cycles = loops.full_cycles();
    let mut widths = Vec::with_capacity(cycles.len());
    for of_recording in cycles.chunk_by(|a, b| a.recording == b.recording) {
        let recording = of_recording[0].recording;
        let outputs = (runs[recording].conventional)(at);
        widths.extend(of_recording.iter().map(|cycle| {
            weight * Loop::of(cycle, &references[recording], |k| outputs[k]).mean_width()
        }));
    }
    AxisHysteresis {
        axis,
        mean_width: mean(&widths),
        n_reversals: widths.len(),
        reversal_threshold,
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

impl MeanHysteresis {
    /// Returns the mean hysteresis as a clause. A width is written as `text` writes a force threshold F_th.
    pub fn in_words(&self, text: impl Fn(f64) -> String) -> String {
        let Some(value) = self.value else {
            return "mean hysteresis not measured, because no load rises and falls again"
                .to_owned();
        };
        let axes = self.axes.iter().map(|axis| {
            let width = axis.mean_width.map_or_else(|| "–".to_owned(), &text);
            format!("{} {width}", axis.axis)
        });
        let axes = axes.collect::<Vec<_>>().join(", ");
        let reversals = counted(self.n_reversals, "reversal");
        let doubt = if self.rests_on_few() {
            "; with so few reversals it is uncertain: record more cycles"
        } else {
            ""
        };
        format!("mean hysteresis {} from {reversals} ({axes}){doubt}", text(value))
    }

    /// Returns true if there are fewer reversals than a reliable mean hysteresis needs.
    pub fn rests_on_few(&self) -> bool {
        self.n_reversals < FEWEST_REVERSALS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fz moves between −1 and 1, and Mx is constant. The conventional Fz lags by a play of ±0.1, so the mean loop width is
    /// `2·0.1·(1 − 0.1)` (see the tests of the loops).
    fn run(cycles: usize) -> (Vec<f64>, Vec<f64>) {
        let (steps, radius) = (1000, 0.1);
        let (mut reference, mut conventional) = (Vec::new(), Vec::new());
        let mut state: f64 = -0.9;
        for k in 0..=2 * cycles * steps {
            let phase = (k % (2 * steps)) as f64 / steps as f64;
            let load = if phase <= 1.0 { 2.0 * phase - 1.0 } else { 3.0 - 2.0 * phase };
            state = state.clamp(load - radius, load + radius);
            reference.extend([load, 7.0]);
            conventional.extend([state, 7.0]);
        }
        (reference, conventional)
    }

    fn of(cycles: usize, weights: [f64; 2]) -> MeanHysteresis {
        let (reference, conventional) = run(cycles);
        let run = HysteresisRun {
            reference: &reference,
            conventional: &|at| column(&conventional, 2, at).collect(),
        };
        mean_hysteresis(&[run, run], &[Axis::Fz, Axis::Mx], &weights)
    }

    #[test]
    fn a_play_operator_has_the_width_of_its_loop() {
        let found = of(6, [1.0, 0.0]);
        // Each of the two recordings has six cycles.
        assert_eq!((found.n_reversals, found.axes.len()), (12, 1));
        assert!((found.value.unwrap() / 0.18 - 1.0).abs() < 0.01, "{found:?}");
        assert!(!found.rests_on_few());
    }

    #[test]
    fn axes_without_a_cycle_are_left_out_of_the_mean_and_few_reversals_are_reported() {
        let found = of(1, [0.5, 2.0]);
        assert!((found.value.unwrap() / 0.09 - 1.0).abs() < 0.01, "{found:?}");
        assert_eq!(found.axes[1].mean_width, None);
        assert!(found.rests_on_few());
        assert_eq!(of(0, [1.0, 1.0]).value, None);
        assert_eq!(mean_hysteresis(&[], &[], &[]), MeanHysteresis::default());
    }
}
