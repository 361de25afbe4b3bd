//! Tables of the errors of a calibration.

use crate::{
    calibration::{Calibration, FactoryScores},
    report::{
        table::{Cell, Column, Table},
        trace::{Shown, Trace},
    },
    scoring::{numbers::significant, score_set::ScoreSet},
};

/// Returns a table of the RMSE of each axis on one set of samples (such as the test recordings), one row per axis.
///
/// # Errors
/// A sentence with the reason why this set of samples has no errors.
pub fn errors(
    calibration: &Calibration,
    factory: Option<&FactoryScores>,
    set: ScoreSet,
    shown: Shown,
) -> Result<Table, String> {
    let quality = &calibration.quality;
    let scores = [&quality.conventional, &quality.compensated].map(|scores| set.rmse(scores));
    let [Some(before), Some(after)] = scores else {
        return Err(set.missing(calibration.no_cross_validation()));
    };
    let how = match (set, &quality.cross_validation) {
        (ScoreSet::LeftOut, Some(how)) => format!(" {how}"),
        _ => String::new(),
    };
    let outputs = [(Trace::Conventional, before), (Trace::Compensated, after)];
    let errors = outputs.into_iter().flat_map(|(trace, rmse)| {
        shown.both("", "% FS").into_iter().map(move |unit| (Column::of(trace, unit), rmse))
    });
    Ok(Table::of(0..calibration.axes.len())
        .words("Axis", |at| calibration.axes[*at].label())
        .columns(
            errors,
            |(head, _)| head.clone(),
            |at, (head, rmse)| {
                let (rmse, full_scale) = (rmse[*at], calibration.full_scale[*at]);
                match head.unit {
                    "" => Cell::digits(Some(rmse), 4),
                    _ => Cell::digits((full_scale > 0.0).then(|| 100.0 * rmse / full_scale), 3),
                }
            },
        )
        .column(Column::change(), |at| Cell::change(before[*at], after[*at]))
        .columns(
            factory,
            |_| Column::of(Trace::Factory, ""),
            |at, factory| Cell::digits(set.factory_rmse(factory).get(*at).copied().flatten(), 4),
        )
        .table(format!("RMSE, {}{how}", set.label()), format!("{}.", set.explanation())))
}

/// Returns the note below the table of errors that explains its factory column, with the offsets that were added to the
/// factory calibration's loads.
pub fn factory_note(calibration: &Calibration, factory: &FactoryScores) -> String {
    let added = (calibration.axes.iter().zip(&factory.offsets))
        .filter_map(|(axis, offset)| {
            let offset = offset.filter(|offset| *offset != 0.0)?;
            let (symbol, unit) = (axis.symbol(), axis.unit());
            Some(format!("{symbol} {} {unit}", significant(offset, 3)))
        })
        .collect::<Vec<_>>();
    let note = "Factory: errors of the calibration that the sensor came with, computed from the same gauges.";
    if added.is_empty() {
        note.to_owned()
    } else {
        format!(
            "{note} An offset was added to the factory load of each axis, so that its mean error on the training recordings is zero: {}.",
            added.join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::FitSettings;
    use crate::progress::Progress;
    use crate::questions::errors::query::analyse;
    use crate::questions::request::Request;
    use crate::recording::simulated;

    #[test]
    fn the_copied_table_equals_the_pane() {
        let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
        let settings = FitSettings { decimation: 20, ..FitSettings::default() };
        let request = Request::fit(recordings, settings);
        let calibration = analyse(&request, &Progress::default()).unwrap().calibration;
        let table = |set| errors(&calibration, None, set, Shown::Units).unwrap();
        let tables = ScoreSet::ALL.map(|set| (set.title().to_owned(), table(set)));
        let text = Table::beside("RMSE", tables).tab_separated();
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split('\t').collect()).collect();
        assert_eq!((rows.len(), rows[0].len()), (7, 10));
        assert_eq!((rows[0][5], rows[3][0]), ("Test Compensated", "Fz [N]"));
        let test = calibration.quality.compensated.test_rmse.as_ref().unwrap();
        let shown: f64 = rows[3][5].parse().unwrap();
        assert!((shown - test[2]).abs() < 1e-5 * test[2]);
    }

    #[test]
    fn missing_scores_have_a_reason() {
        let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
        let settings = FitSettings { decimation: 50, ..FitSettings::default() };
        let request = Request::fit(recordings, settings);
        let mut calibration =
            (*analyse(&request, &Progress::default()).unwrap().calibration).clone();
        calibration.quality.compensated.test_rmse = None;
        let message = errors(&calibration, None, ScoreSet::Test, Shown::All).unwrap_err();
        assert_eq!(message, "no recording is in the test role");
        assert!(errors(&calibration, None, ScoreSet::Train, Shown::All).is_ok());
    }
}
