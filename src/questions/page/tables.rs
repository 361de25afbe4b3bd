//! Tables of a calibration report: the sensor, the recordings, the settings of the fit, and the calibration matrices.

use super::data::{ReportData, ReportRecording};
use crate::{
    calibration::{Calibration, LinearMap},
    export::settings_of,
    features::Distance,
    report::{Align, Cell, Column, Table},
    scoring::numbers::significant,
};

/// Maximum number of features (rows) that the report shows of each calibration matrix.
const MAX_FEATURES: usize = 400;

pub fn sensor(calibration: &Calibration) -> Vec<(&'static str, String)> {
    let entered = calibration.identity.entered();
    let mut rows: Vec<(&str, String)> =
        entered.map(|(item, text)| (item.label(), text.to_owned())).collect();
    let axes = calibration.axes.iter().zip(&calibration.full_scale);
    let rated = axes.zip(&calibration.rated).filter(|(_, is_rated)| **is_rated);
    let rated =
        rated.map(|((axis, load), _)| format!("{axis} {} {}", significant(*load, 4), axis.unit()));
    let rated: Vec<String> = rated.collect();
    if !rated.is_empty() {
        rows.push(("Rated loads", rated.join(", ")));
    }
    rows
}

pub fn recordings(report: &ReportData) -> [Table; 2] {
    let files = Table::of(&report.recordings)
        .words("Name", |entry| &entry.used.name)
        .words("Role", |entry| entry.used.role.label())
        .words("Group", |entry| entry.result.group.as_deref().unwrap_or("–"))
        .column(Column::numbers("Samples"), |entry| Cell::whole(entry.recording.n_samples()))
        .digits("Duration [s]", 5, |entry| Some(entry.recording.duration_secs()))
        .digits("Rate [Hz]", 4, |entry| entry.recording.rate_hz())
        .words("File", |entry| entry.used.file.as_deref().unwrap_or("built-in simulated sensor"))
        .column(
            Column { align: Align::Anywhere, ..Column::words("SHA-256 of the file") },
            |entry| match (&entry.used.file, &entry.used.sha256) {
                (None, _) => Cell::words("–"),
                (Some(_), Some(hash)) => Cell::words(hash),
                (Some(_), None) => Cell::words("unknown, because the file could not be read again"),
            },
        )
        .table("", "");
    let rmse = |ReportRecording { result, .. }: &ReportRecording| {
        Some([result.conventional_rmse.clone()?, result.compensated_rmse.clone()?])
    };
    let errors = Table::of(
        report.recordings.iter().map(|recording| (&recording.used.name, rmse(recording))),
    )
    .words("RMSE, Uncompensated → Compensated", |(name, _)| *name)
    .instead(|(_, rmse)| match rmse {
        Some(_) => None,
        None => Some(Cell::missing("–", "no reference load")),
    })
    .columns(
        report.calibration.axes.iter().copied().enumerate(),
        |(_, axis)| Column::load(*axis),
        |(_, rmse), (at, _)| {
            let texts = rmse.iter().flatten().map(|rmse| significant(rmse[*at], 3));
            Cell::words(texts.collect::<Vec<_>>().join(" → "))
        },
    )
    .table("", "");
    [files, errors]
}

pub fn settings(calibration: &Calibration) -> Table {
    let quality = &calibration.quality;
    let ridge = quality.ridge_in_words(&calibration.axes);
    let condition = quality.condition.map(|number| significant(number, 4));
    let none = || "none".to_owned();
    let rank = format!(
        "rank {} of {} features, condition number {}",
        quality.rank,
        calibration.columns().len(),
        condition.unwrap_or_else(none)
    );
    let distance = match calibration.features.distance {
        Distance::Force => "the force axes, in newtons",
        Distance::FullScale => "all load axes, each divided by its full scale",
    };
    let mut rows = settings_of(calibration);
    rows.extend([
        ("axes of the force threshold F_th", distance.to_owned()),
        ("ridge", ridge.unwrap_or_else(none)),
        ("rank and condition number", rank),
    ]);
    Table::of(rows)
        .words("Setting", |(name, _)| *name)
        .words("Value", |(_, value)| value.clone())
        .table("", "")
}

pub fn matrices(calibration: &Calibration) -> Vec<Table> {
    let conventional = &calibration.conventional;
    let mut tables = vec![matrix("Uncompensated", conventional, calibration)];
    if let Some(map) = &calibration.compensated {
        tables.push(matrix("Compensated", map, calibration));
        if let Some(known) = &calibration.quality.coefficients {
            let map = LinearMap::new(map.columns.clone(), known.standard.clone());
            let title = format!(
                "Compensated: standard errors of the coefficients, by a jackknife {}",
                known.left_out
            );
            tables.push(matrix(&title, &map, calibration));
        }
    }
    tables
}

fn matrix(title: &str, map: &LinearMap, calibration: &Calibration) -> Table {
    let features = map.names(&calibration.gauges).into_iter().enumerate();
    let note = match map.columns.len().saturating_sub(MAX_FEATURES) {
        0 => String::new(),
        more => format!("{more} more features are only in the calibration file (JSON)."),
    };
    Table::of(features.take(MAX_FEATURES))
        .words("Feature", |(_, name)| name.clone())
        .columns(
            calibration.axes.iter().zip(&map.matrix),
            |(axis, _)| Column::load(**axis),
            |(feature, _), (_, numbers)| Cell::digits(Some(numbers[*feature]), 7),
        )
        .table(title, note)
}
