//! Relative changes of error figures by the compensation, for each axis.

use crate::calibration::Quality;
use crate::questions::metrology::figures::{Cell, Figure, Metrology};
use crate::questions::metrology::quantity::Quantity;
use crate::questions::thresholds::ScoreSet;
use crate::recording::Axis;
use crate::scoring::metrics::percent_change;

/// Figures of the metrology table that the verdict strip shows.
const COUNTED: [Quantity; 5] = [
    Quantity::LargestError,
    Quantity::Hysteresis,
    Quantity::Creep,
    Quantity::Repeatability,
    Quantity::ZeroReturn,
];

/// One error figure, of the uncompensated and of the compensated load.
#[derive(Clone, Debug, PartialEq)]
pub struct VerdictFigure {
    /// Short name.
    pub name: String,
    /// Definition of the figure, and a description of the samples from which it is computed.
    pub about: String,
    /// True for the RMSE, which the table of errors shows. The metrology table shows the other figures.
    pub is_rmse: bool,
    /// Magnitude of the figure for each axis, uncompensated and compensated; `None` if the samples do not determine the
    /// figure.
    pub of_axes: Vec<Option<[f64; 2]>>,
}

impl VerdictFigure {
    /// Returns the change of the figure by the compensation for each axis, in whole percent. A negative change is an
    /// improvement.
    pub fn changes(&self) -> impl Iterator<Item = Option<f64>> {
        self.of_axes.iter().map(|own| {
            let [before, after] = (*own)?;
            Some(percent_change(before, after)?.round())
        })
    }
}

/// Comparison of the uncompensated with the compensated load by several error figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The axes.
    pub axes: Vec<Axis>,
    /// RMSE first, then the figures of the metrology table.
    pub figures: Vec<VerdictFigure>,
}

impl Verdict {
    /// Compares the conventional with the compensated calibration by the metrology table and by their RMSE: in
    /// cross-validation, else on the test recordings, else on the training recordings.
    pub fn of(quality: &Quality, metrology: &Metrology) -> Self {
        let sets = [ScoreSet::LeftOut, ScoreSet::Test, ScoreSet::Train].into_iter();
        let mut scored = sets.filter_map(|set| {
            Some((set, set.rmse(&quality.conventional)?, set.rmse(&quality.compensated)?))
        });
        let rmse = scored.next().map(|(set, before, after)| VerdictFigure {
            name: format!("RMSE, {}", set.label()),
            about: format!("Root mean squared error. {}", set.explanation()),
            is_rmse: true,
            of_axes: before.iter().zip(after).map(|(a, b)| Some([*a, *b])).collect(),
        });
        let row_of = |own| metrology.rows.iter().find(|row| row.quantity == own);
        let measured = COUNTED.into_iter().filter_map(|quantity| {
            let row = row_of(quantity)?;
            // If a time lag explains a part of the loop, only the loop width without the lag is hysteresis.
            let without_lag =
                row_of(Quantity::HysteresisWithoutLag).filter(|_| quantity == Quantity::Hysteresis);
            let of_axes = row.cells.iter().enumerate().map(|(at, cell)| {
                let value = |output: fn(&Cell) -> &Figure| {
                    let corrected =
                        without_lag.and_then(|row| output(&row.cells[at]).as_ref().ok());
                    Some(corrected.or(output(cell).as_ref().ok())?.value.abs())
                };
                Some([value(|cell| &cell.conventional)?, value(|cell| &cell.compensated)?])
            });
            Some(VerdictFigure {
                name: row.definition.name.clone(),
                about: row.definition.definition.to_owned(),
                is_rmse: false,
                of_axes: of_axes.collect(),
            })
        });
        Self { axes: metrology.axes.clone(), figures: rmse.into_iter().chain(measured).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::Scores;
    use crate::questions::metrology::figures::Run;
    use crate::questions::metrology::tests::table_of;

    /// Compensation halves the error, except for one sample with a large error.
    #[test]
    fn a_lower_rmse_hides_no_larger_error() {
        let times: Vec<f64> = (0..200).map(|k| f64::from(k) / 10.0).collect();
        let reference: Vec<f64> = times.iter().map(|time| 10.0 * time.sin()).collect();
        let off = |by: f64| reference.iter().map(|load| load + by).collect::<Vec<_>>();
        let mut compensated = off(0.5);
        compensated[40] += 3.0;
        let run = Run {
            name: "a",
            times: &times,
            gauges: &[],
            reference_axes: &[Axis::Fx],
            reference: &reference,
            conventional: &off(1.0),
            compensated: &compensated,
            is_static: false,
        };
        let metrology = table_of(&[run], &[Axis::Fx], &[10.0]);
        let scores = |rmse: f64| Scores { cv_rmse: Some(vec![rmse]), ..Scores::default() };
        let quality =
            Quality { conventional: scores(1.0), compensated: scores(0.55), ..Quality::default() };
        let verdict = Verdict::of(&quality, &metrology);
        let change = |name: &str| {
            let own = verdict.figures.iter().find(|own| own.name == name).expect("a figure");
            own.changes().next().flatten()
        };
        assert_eq!(change("RMSE, cross-validation"), Some(-45.0));
        assert_eq!(change("Largest error"), Some(250.0));
        assert_eq!(change("Creep"), None, "there is no dwell");
    }
}
