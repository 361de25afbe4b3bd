//! The tables of a report: what it is about, how good it is, what it was made of, and the matrices.

use super::data::{ReportData, ReportRecording};
use crate::calibration::{Calibration, LinearMap};
use crate::export::facts::settings_of;
use crate::features::Distance;
use crate::report::{Align, Cell, Column, Table};
use crate::scoring::numbers::significant;
use crate::shown::and_more;

/// A longer matrix is told of only in part: nobody reads it, and the complete calibration has it.
const MAX_FEATURES: usize = 400;

/// Which sensor it is, by label.
pub(super) fn sensor(calibration: &Calibration) -> Vec<(&'static str, String)> {
    let entered = calibration.identity.entered();
    let mut rows: Vec<(&str, String)> =
        entered.map(|(item, text)| (item.label(), text.to_owned())).collect();
    let axes = calibration.axes.iter().zip(&calibration.full_scale);
    let rated = axes.zip(&calibration.rated).filter(|(_, is_rated)| **is_rated);
    let rated = rated.map(|((axis, load), _)| {
        format!("{} {} {}", axis.symbol(), significant(*load, 4), axis.unit())
    });
    let rated: Vec<String> = rated.collect();
    if !rated.is_empty() {
        rows.push(("Rated loads", rated.join(", ")));
    }
    rows
}

/// The recordings with their files, and how large the error is on each.
pub(super) fn recordings(report: &ReportData) -> [Table; 2] {
    let mut columns = ["Name", "Role", "Group"].map(Column::words).to_vec();
    columns.extend(["Samples", "Duration [s]", "Rate [Hz]"].map(Column::numbers));
    columns.push(Column::words("File"));
    columns.push(Column { align: Align::Anywhere, ..Column::words("SHA-256 of the file") });
    let files = Table {
        columns,
        rows: report.recordings.iter().map(recording_row).collect(),
        ..Table::default()
    };
    let mut columns = vec![Column::words("RMSE, Conv. → Comp.")];
    columns.extend(report.calibration.axes.iter().copied().map(Column::load));
    let rows = report.recordings.iter();
    let rows = rows.map(|recording| rmse_row(recording, columns.len()));
    let errors = Table { rows: rows.collect(), columns, ..Table::default() };
    [files, errors]
}

fn recording_row(recording: &ReportRecording) -> Vec<Cell> {
    let used = &recording.used;
    let (file, hash) = match (&used.file, &used.sha256) {
        (None, _) => ("built-in simulated sensor", "–"),
        (Some(file), Some(hash)) => (&**file, &**hash),
        (Some(file), None) => (&**file, "the file could not be read again"),
    };
    vec![
        Cell::words(&used.name),
        Cell::words(used.role.label()),
        Cell::words(recording.group.as_deref().unwrap_or("–")),
        Cell::words(recording.n_samples.to_string()),
        Cell::digits(Some(recording.duration_secs), 5),
        Cell::digits(recording.rate_hz, 4),
        Cell::words(file),
        Cell::words(hash),
    ]
}

fn rmse_row(recording: &ReportRecording, n_columns: usize) -> Vec<Cell> {
    let mut row = vec![Cell::words(&recording.used.name)];
    match (&recording.conventional_rmse, &recording.compensated_rmse) {
        (Some(before), Some(after)) => row.extend(before.iter().zip(after).map(|both| {
            let (before, after) = (significant(*both.0, 3), significant(*both.1, 3));
            Cell::words(format!("{before} → {after}"))
        })),
        _ => row.push(Cell::missing("–", "no reference load")),
    }
    row.resize(n_columns, Cell::continued());
    row
}

/// What the calibration was made with.
pub(super) fn settings(calibration: &Calibration) -> Table {
    let rows = setting_rows(calibration).into_iter();
    let rows = rows.map(|(name, value)| vec![Cell::words(name), Cell::words(value)]);
    Table {
        columns: ["Setting", "Value"].map(Column::words).to_vec(),
        rows: rows.collect(),
        ..Table::default()
    }
}

fn setting_rows(calibration: &Calibration) -> Vec<(&'static str, String)> {
    let quality = &calibration.quality;
    let ridge = quality.ridge_in_words(&calibration.axes);
    let ridge = ridge.unwrap_or_else(|| "none".to_owned());
    let condition = quality.condition;
    let condition = condition.map_or_else(|| "none".to_owned(), |number| significant(number, 4));
    let n_features = calibration.columns().len();
    let distance = match calibration.features.distance {
        Distance::Force => "the force axes, in newtons",
        Distance::FullScale => "all axes, each divided by its full scale",
    };
    let mut rows = settings_of(calibration);
    rows.extend([
        ("F_th is measured over", distance.to_owned()),
        ("ridge", ridge),
        (
            "rank and condition number",
            format!("{} of {n_features} features, {condition}", quality.rank),
        ),
    ]);
    rows
}

/// The matrices, that of the standard errors among them.
pub(super) fn matrices(calibration: &Calibration) -> Vec<Table> {
    let conventional = &calibration.conventional;
    let mut tables = vec![matrix("Conventional (Conv.)", conventional, calibration)];
    if let Some(map) = &calibration.compensated {
        tables.push(matrix("Compensated (Comp.)", map, calibration));
        if let Some(known) = &calibration.quality.coefficients {
            let map = LinearMap { columns: map.columns.clone(), matrix: known.standard.clone() };
            let title =
                format!("Compensated (Comp.): standard errors, a jackknife {}", known.left_out);
            tables.push(matrix(&title, &map, calibration));
        }
    }
    tables
}

fn matrix(title: &str, map: &LinearMap, calibration: &Calibration) -> Table {
    let mut columns = vec![Column::words("Feature")];
    columns.extend(calibration.axes.iter().copied().map(Column::load));
    let features = map.names(&calibration.gauges);
    let features = features.iter().enumerate().take(MAX_FEATURES);
    let rows = features.map(|(column, feature)| {
        let numbers = map.matrix.iter();
        let numbers = numbers.map(|numbers| Cell::digits(Some(numbers[column]), 7));
        std::iter::once(Cell::words(feature)).chain(numbers).collect()
    });
    let more = and_more(map.columns.len(), MAX_FEATURES);
    let note = more.map(|more| format!("{more}, which the complete calibration (JSON) has."));
    Table { title: title.to_owned(), columns, rows: rows.collect(), note: note.unwrap_or_default() }
}
