//! What the strip, the sliders, the map and the table of errors are about: one axis or several, the samples on which errors
//! are measured, and the axes on screen.

use crate::{
    engine::Engine,
    questions::{
        Analysis,
        thresholds::{Measure, MeasureScale},
    },
    recording::Axis,
    scoring::{metrics, score_set::ScoreSet},
};

/// Axes that the user asks for. The numbers are places in the sensor's list of axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisChoice {
    Only(usize),
    Toggle(usize),
    All,
}

#[derive(Debug)]
pub struct Scope {
    /// Axis or group of axes whose errors are shown; `None` until the user chooses one.
    measure: Option<Measure>,
    pub on: ScoreSet,
    /// Axes that the traces show; empty before the first fit.
    axes: Vec<Axis>,
}

impl Default for Scope {
    fn default() -> Self {
        Self { measure: None, on: ScoreSet::LeftOut, axes: Vec::new() }
    }
}

/// Errors of the uncompensated and of the compensated load on each axis.
pub struct Errors<'a> {
    pub on: ScoreSet,
    pub before: &'a [f64],
    pub after: &'a [f64],
}

impl<'a> Errors<'a> {
    /// Returns the errors on these samples, or on others if there are none on these.
    pub fn of(analysis: &'a Analysis, on: ScoreSet) -> Option<Self> {
        let quality = &analysis.calibration.quality;
        let sets = [on, ScoreSet::LeftOut, ScoreSet::Test, ScoreSet::Train];
        sets.into_iter().find_map(|on| {
            let (before, after) = (on.rmse(&quality.conventional)?, on.rmse(&quality.compensated)?);
            Some(Self { on, before, after })
        })
    }

    /// Returns the change of an axis' error by the compensation, such as "−52 %"; `None` without an error before.
    pub fn change(&self, axis: usize) -> Option<String> {
        percent_change(*self.before.get(axis)?, *self.after.get(axis)?)
    }
}

/// Returns the change from one error to another, such as "−52 %"; `None` if the first error is zero.
pub fn percent_change(before: f64, after: f64) -> Option<String> {
    let percent = metrics::percent_change(before, after)?;
    Some(format!("{percent:+.0} %").replace('-', "−"))
}

pub fn scale_of(analysis: &Analysis) -> MeasureScale {
    let calibration = &analysis.calibration;
    MeasureScale { axes: calibration.axes.clone(), full_scale: calibration.full_scale.clone() }
}

impl Scope {
    pub fn measure(&self, scale: &MeasureScale) -> Measure {
        let chosen = self.measure.filter(|measure| measure.weights(scale).is_some());
        chosen.unwrap_or_else(|| scale.default_measure())
    }

    pub fn choose(&mut self, measure: Measure) {
        self.measure = Some(measure);
    }

    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Removes axes that the sensor does not have. Before the user has chosen an axis, chooses the axis whose error the
    /// compensation lowers most.
    pub fn follow(&mut self, engine: &Engine) {
        let known = engine.project().axes();
        self.axes.retain(|axis| known.contains(axis));
        if let Some(analysis) = engine.analysis().filter(|_| self.axes.is_empty()) {
            let left = |at: usize| {
                let errors = Errors::of(analysis, self.on)?;
                let (before, after) = (errors.before.get(at)?, errors.after.get(at)?);
                Some(after / before).filter(|left| left.is_finite())
            };
            let axes = analysis.calibration.axes.iter().enumerate();
            let best = axes.min_by(|a, b| {
                let [a, b] = [a, b].map(|(at, _)| left(*at).unwrap_or(f64::INFINITY));
                a.total_cmp(&b)
            });
            self.axes.extend(best.map(|(_, axis)| *axis));
        }
    }

    pub fn show(&mut self, choice: AxisChoice, known: &[Axis]) {
        match choice {
            AxisChoice::All => self.axes = known.to_vec(),
            AxisChoice::Only(at) => {
                if let Some(axis) = known.get(at) {
                    self.axes = vec![*axis];
                }
            }
            AxisChoice::Toggle(at) => {
                let Some(axis) = known.get(at) else { return };
                let others = self.axes.iter().filter(|shown| *shown != axis).count();
                if others == self.axes.len() {
                    self.axes.push(*axis);
                    self.axes.sort_by_key(|axis| known.iter().position(|other| other == axis));
                } else if others > 0 {
                    self.axes.retain(|shown| shown != axis);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_chosen_added_and_removed_but_never_all() {
        let known = [Axis::Fx, Axis::Fz, Axis::Mx];
        let mut scope = Scope::default();
        let mut after = |choice| {
            scope.show(choice, &known);
            scope.axes().to_vec()
        };
        assert_eq!(after(AxisChoice::Only(1)), [Axis::Fz]);
        assert_eq!(after(AxisChoice::Toggle(0)), [Axis::Fx, Axis::Fz]);
        assert_eq!(after(AxisChoice::Toggle(1)), [Axis::Fx]);
        assert_eq!(after(AxisChoice::Toggle(0)), [Axis::Fx]);
        assert_eq!(after(AxisChoice::Only(7)), [Axis::Fx]);
        assert_eq!(after(AxisChoice::All), known);
    }
}
