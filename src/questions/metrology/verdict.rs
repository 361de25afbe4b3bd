//! Improvement and deterioration by compensation, for each figure and axis.

use crate::calibration::Quality;
use crate::questions::metrology::figures::{Cell, Figure, Metrology};
use crate::questions::metrology::quantity::Quantity;
use crate::recording::Axis;
use crate::scoring::metrics::percent_change;

/// Figures of the metrology table that the verdict contains.
const COUNTED: [Quantity; 5] = [
    Quantity::LargestError,
    Quantity::Hysteresis,
    Quantity::Creep,
    Quantity::Repeatability,
    Quantity::ZeroReturn,
];

/// One figure, uncompensated and compensated.
#[derive(Clone, Debug, PartialEq)]
pub struct VerdictFigure {
    /// Short name.
    pub name: String,
    /// Definition of the figure and its samples.
    pub about: String,
    /// True for an RMSE, which is in the table of errors; other figures are in the metrology table.
    pub is_rmse: bool,
    /// Magnitudes per axis, uncompensated and compensated; `None` if the samples do not determine them.
    pub of_axes: Vec<Option<[f64; 2]>>,
}

impl VerdictFigure {
    /// Returns the change of each axis in whole percent; negative is better.
    pub fn changes(&self) -> impl Iterator<Item = Option<f64>> {
        self.of_axes.iter().map(|own| {
            let [before, after] = (*own)?;
            Some(percent_change(before, after)?.round())
        })
    }
}

/// Changes by compensation.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The axes.
    pub axes: Vec<Axis>,
    /// RMSE first, then the figures of the metrology table.
    pub figures: Vec<VerdictFigure>,
}

impl Verdict {
    /// Compares both calibrations by the metrology table and by their RMSE: on held-out samples, else on test samples, else
    /// on training samples.
    pub fn of(quality: &Quality, metrology: &Metrology) -> Self {
        let both = [&quality.conventional, &quality.compensated];
        let sets: [(&str, [Option<&Vec<f64>>; 2]); 3] = [
            ("RMSE, held-out", both.map(|own| own.cv_rmse.as_ref())),
            ("RMSE, test", both.map(|own| own.test_rmse.as_ref())),
            ("RMSE, train", both.map(|own| own.train_rmse.as_ref())),
        ];
        let scored =
            sets.into_iter().find_map(|(name, [before, after])| Some((name, before?, after?)));
        let rmse = scored.map(|(name, before, after)| VerdictFigure {
            name: name.to_owned(),
            about: "root mean squared error; held-out if there is a cross-validation".to_owned(),
            is_rmse: true,
            of_axes: before
                .iter()
                .zip(after)
                .map(|(before, after)| Some([*before, *after]))
                .collect(),
        });
        let measured = COUNTED.into_iter().filter_map(|quantity| {
            let row_of = |own| metrology.rows.iter().find(|row| row.quantity == own);
            let row = row_of(quantity)?;
            // If a lag explains a part of the loop, only the rest is hysteresis.
            let without_lag =
                row_of(Quantity::HysteresisWithoutLag).filter(|_| quantity == Quantity::Hysteresis);
            let of_axes = row.cells.iter().enumerate().map(|(at, cell)| {
                let value = |output: fn(&Cell) -> &Figure| {
                    let without_lag =
                        without_lag.and_then(|row| output(&row.cells[at]).as_ref().ok());
                    let value = without_lag.or(output(cell).as_ref().ok())?;
                    Some(value.value.abs())
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
        assert_eq!(change("RMSE, held-out"), Some(-45.0));
        assert_eq!(change("Largest error"), Some(250.0));
        assert_eq!(change("Creep"), None, "there is no dwell");
    }
}
