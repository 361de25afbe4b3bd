//! Tables of a calibration report. A table has so few rows that the report keeps within its pages; the calibration file has
//! the rest.

use super::data::{ReportData, ReportRecording};
use crate::{
    calibration::{Calibration, FactoryScores, LinearMap},
    export::settings_of,
    features::Distance,
    questions::metrology::{Metrology, axis_figures},
    report::{Align, Cell, Column, Shown, Table, Value},
    scoring::{numbers::significant, score_set::ScoreSet},
};

/// Maximum number of features (rows) that the report shows of each calibration matrix.
const MAX_FEATURES: usize = 16;
/// Maximum number of recordings (rows) that the report lists.
const MAX_RECORDINGS: usize = 16;
/// Number of hexadecimal digits of the SHA-256 of a file that the report shows.
const HASH_DIGITS: usize = 16;

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

/// Returns the table without the columns and rows that have neither a number nor a text. Its note then names these rows, and
/// gives the reasons for other missing numbers.
pub fn known(mut table: Table) -> Table {
    let is_known = |cell: &Cell| !matches!(cell.value, Value::Missing | Value::Continued);
    let has_number =
        |row: &Vec<Cell>| row.iter().any(|cell| matches!(cell.value, Value::Number(_)));
    let mut notes = Vec::new();
    if table.rows.iter().any(has_number) {
        let (kept, left): (Vec<_>, Vec<_>) = table.rows.into_iter().partition(has_number);
        table.rows = kept;
        let (mut names, mut reasons) = (Vec::new(), Vec::new());
        for row in &left {
            let mut texts: Vec<&str> =
                row[1..].iter().filter(|cell| is_known(cell)).map(|cell| &*cell.text).collect();
            texts.dedup();
            let name = &row[0].text;
            match row.iter().find_map(Cell::reason) {
                Some(reason) => reasons.push(format!("{name}: {reason}.")),
                None if texts.is_empty() => names.push(name.clone()),
                None => names.push(format!("{name} ({})", texts.join(", "))),
            }
        }
        if !names.is_empty() {
            notes.push(format!("Without a number: {}.", names.join(", ")));
        }
        notes.extend(reasons);
    }
    let used = |at: usize| at == 0 || table.rows.iter().any(|row| is_known(&row[at]));
    let used: Vec<bool> = (0..table.columns.len()).map(used).collect();
    table.keep_columns(|at, _| used[at]);
    for row in &table.rows {
        let reason = row.iter().find_map(Cell::reason);
        notes.extend(reason.map(|reason| format!("{}: {reason}.", row[0].text)));
    }
    notes.insert(0, std::mem::take(&mut table.note));
    Table { note: notes.join(" ").trim().to_owned(), ..table }
}

/// Returns a cell such as `0.96 → 0.67`; a dash if both numbers are missing.
fn change(before: Option<f64>, after: Option<f64>, digits: usize) -> Cell {
    let text =
        |value: Option<f64>| value.map_or("–".to_owned(), |value| significant(value, digits));
    after.or(before).map_or_else(Cell::none, |value| {
        Cell::number(value, format!("{} → {}", text(before), text(after)))
    })
}

/// Returns the table of the RMSE before and after compensation, on each set of samples that has errors.
pub fn errors(calibration: &Calibration, factory: Option<&FactoryScores>) -> Table {
    let quality = &calibration.quality;
    let sets = [ScoreSet::Test, ScoreSet::LeftOut, ScoreSet::Train].into_iter().filter_map(|set| {
        Some((set, set.rmse(&quality.conventional)?, set.rmse(&quality.compensated)?))
    });
    type Errors<'a> = (ScoreSet, &'a [f64], &'a [f64]);
    let columns = sets.flat_map(|set: Errors<'_>| ["", "% FS", "change"].map(|kind| (set, kind)));
    let how = quality.cross_validation.as_ref();
    let how = how.map_or_else(String::new, |how| format!(" Cross-validation {how}."));
    let factories = factory.into_iter().flat_map(|scores| {
        [ScoreSet::Test, ScoreSet::Train].map(|set| (set, set.factory_rmse(scores)))
    });
    Table::of(0..calibration.axes.len())
        .words("Axis", |at| calibration.axes[*at].label())
        .columns(
            columns,
            |((set, ..), kind)| match *kind {
                "" => Column::numbers(set.label()),
                kind => Column::numbers(kind),
            },
            |at, ((_, before, after), kind)| {
                let (before, after, full_scale) =
                    (before[*at], after[*at], calibration.full_scale[*at]);
                let share = |rmse: f64| (full_scale > 0.0).then(|| 100.0 * rmse / full_scale);
                match *kind {
                    "" => change(Some(before), Some(after), 4),
                    "% FS" => change(share(before), share(after), 3),
                    _ => Cell::change(before, after),
                }
            },
        )
        .columns(
            factories,
            |(set, _)| Column::numbers(format!("factory, {}", set.label())),
            |at, (_, rmse)| Cell::digits(rmse.get(*at).copied().flatten(), 3),
        )
        .table(
            "Errors: RMSE, uncompensated → compensated",
            format!("Uncompensated: load from the present gauges alone. Compensated: load from the present gauges and the other features, such as past samples.{how}"),
        )
}

/// Returns the table of the metrology figures in % of full scale, with few axes also in their units. Times are in s.
pub fn metrology(found: &Metrology) -> Table {
    let axes = found.axes.iter().enumerate();
    let units = if found.axes.len() > 3 { &[true][..] } else { &[false, true] };
    let columns = axes.flat_map(|(at, axis)| units.iter().map(move |share| (at, axis, *share)));
    let conditions = (0..found.axes.len()).map(|at| axis_figures(found, at, Shown::All).title);
    Table::of(found.shown_rows())
        .words("Figure", |row| {
            let is_time = row.cells.first().is_some_and(|cell| cell.unit == "s");
            format!("{}{}", row.definition.name, if is_time { " [s]" } else { "" })
        })
        .columns(
            columns,
            |(_, axis, share)| {
                let head = Column::load(**axis);
                if *share { head.unit("% FS") } else { head }
            },
            |row, (at, _, share)| {
                let cell = &row.cells[*at];
                let in_percent = *share && cell.unit != "s";
                let [before, after] = [&cell.conventional, &cell.compensated].map(|figure| {
                    let value = figure.as_ref().ok()?;
                    if in_percent { value.percent_fs } else { Some(value.value) }
                });
                change(before, after, if in_percent { 3 } else { 4 })
            },
        )
        .table("", format!("{}.", conditions.collect::<Vec<_>>().join("; ")))
}

/// Returns the names of the measured figures with their definitions.
pub fn definitions(found: &Metrology) -> Vec<(String, String)> {
    let shown: Vec<_> = found.shown_rows().map(|row| &row.definition.definition).collect();
    let all = found.definitions().filter(|(_, own)| shown.contains(&&own.definition));
    all.map(|(name, own)| (name, own.sentences()[..2].join(" "))).collect()
}

/// Returns the root mean square of the errors over all axes, each as a share of its full scale.
pub fn pooled(rmse: &[f64], full_scale: &[f64]) -> f64 {
    let shares = rmse.iter().zip(full_scale).filter(|(_, full)| **full > 0.0);
    let squares: Vec<f64> = shares.map(|(rmse, full)| (rmse / full).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

pub fn recordings(report: &ReportData) -> Table {
    let shown = report.recordings.iter().take(MAX_RECORDINGS);
    let pooled = |rmse: &Option<Vec<f64>>| {
        Some(100.0 * pooled(rmse.as_ref()?, &report.calibration.full_scale))
    };
    Table::of(shown)
        .words("Name", |entry| &entry.used.name)
        .words("Role", |entry| entry.used.role.label())
        .words("Group", |entry| entry.result.group.as_deref().unwrap_or("–"))
        .column(Column::numbers("Samples"), |entry| Cell::whole(entry.recording.n_samples()))
        .digits("Duration [s]", 5, |entry| Some(entry.recording.duration_secs()))
        .digits("Rate [Hz]", 4, |entry| entry.recording.rate_hz())
        .column(Column::numbers("RMSE of all axes [% FS]"), |ReportRecording { result, .. }| {
            change(pooled(&result.conventional_rmse), pooled(&result.compensated_rmse), 3)
        })
        .words("File", |entry| entry.used.file.as_deref().unwrap_or("built-in"))
        .column(
            Column { align: Align::Anywhere, ..Column::words("SHA-256, first digits") },
            |entry| match (&entry.used.file, &entry.used.sha256) {
                (None, _) => Cell::words("–"),
                (Some(_), Some(hash)) => Cell::words(&hash[..HASH_DIGITS.min(hash.len())]),
                (Some(_), None) => Cell::words("unknown, because the file could not be read again"),
            },
        )
        .table("", beyond(report.recordings.len(), MAX_RECORDINGS, "recordings"))
}

/// Returns the note that a table does not have all its rows; empty if it has.
fn beyond(n: usize, shown: usize, what: &str) -> String {
    match n.saturating_sub(shown) {
        0 => String::new(),
        more => format!("{more} more {what} are only in the calibration file (JSON)."),
    }
}

/// Returns the table of settings without the names of the recordings, which the report lists elsewhere.
pub fn settings_of_page(calibration: &Calibration) -> Table {
    let mut table = settings(calibration);
    table.rows.retain(|row| row[0].text != "trained on");
    table
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

/// Returns the matrices, the compensated one with the standard errors of its coefficients where they are known.
pub fn matrices(calibration: &Calibration) -> Vec<Table> {
    let of = |title: &str, map: &LinearMap, errors: Option<&[Vec<f64>]>| {
        let features = map.names(&calibration.gauges).into_iter().enumerate();
        Table::of(features.take(MAX_FEATURES))
            .words("Feature", |(_, name)| name.clone())
            .columns(
                calibration.axes.iter().zip(&map.matrix).enumerate(),
                |(_, (axis, _))| Column::load(**axis),
                |(feature, _), (at, (_, numbers))| {
                    let mut cell = Cell::digits(Some(numbers[*feature]), 6);
                    if let Some(errors) = errors {
                        cell.text += &format!(" ± {}", significant(errors[*at][*feature], 2));
                    }
                    cell
                },
            )
            .table(title, beyond(map.columns.len(), MAX_FEATURES, "features"))
    };
    let mut tables = vec![of("Uncompensated", &calibration.conventional, None)];
    tables.extend(calibration.compensated.as_ref().map(
        |map| match &calibration.quality.coefficients {
            None => of("Compensated", map, None),
            Some(known) => {
                let title = format!(
                    "Compensated: coefficients ± standard errors by a jackknife {}",
                    known.left_out
                );
                of(&title, map, Some(&known.standard))
            }
        },
    ));
    tables
}
