//! The tables of a report: what it is about, how good it is, what it was made of, and the matrices.

use super::markup::Markup;
use super::{ReportData, ReportRecording, utc};
use crate::calibration::{Calibration, LinearMap};
use crate::export::facts::settings_of;
use crate::features::Distance;
use crate::questions::check::sufficiency_tables;
use crate::questions::errors::{Shown, errors, factory_note};
use crate::questions::expected_error::{expected_error_table, limits_table};
use crate::questions::thresholds::ScoreSet;
use crate::recording::Role;
use crate::report::{Align, Cell, Column, Table};
use crate::scoring::numbers::significant;

/// A longer matrix is told of only in part: nobody reads it, and the complete calibration has it.
const MAX_FEATURES: usize = 400;

pub(super) fn head(report: &ReportData, page: &mut Markup) {
    let calibration = &report.calibration;
    page.element("h1", "Calibration report");
    let kind = match report.fitted {
        true => "fitted to",
        false => "applied to",
    };
    let count = |role: Role| {
        let roles = report.recordings.iter();
        let roles = roles.map(|recording| recording.used.role);
        roles.filter(|own| *own == role).count()
    };
    let (train, test) = (count(Role::Train), count(Role::Test));
    page.raw("<p class=\"about\">");
    page.text(&format!(
        "LoopScope {}, {}. The calibration was made by {} and {kind} {} recordings, {train} of them to train on and {test} to \
         test on. Their files stand at the end.",
        env!("CARGO_PKG_VERSION"),
        utc(report.made),
        calibration.program,
        report.recordings.len(),
    ));
    page.raw("</p>");
}

/// Writes the sensor's identity, where any of it was entered.
pub(super) fn sensor(report: &ReportData, page: &mut Markup) {
    let calibration = &report.calibration;
    let entered = calibration.identity.entered();
    let mut rows: Vec<(&str, String)> = entered
        .map(|(item, text)| (item.label(), text.to_owned()))
        .collect();
    let rated = calibration
        .axes
        .iter()
        .zip(&calibration.full_scale)
        .zip(&calibration.rated);
    let rated = rated
        .filter(|(_, is_rated)| **is_rated)
        .map(|((axis, load), _)| {
            format!(
                "{} {} {}",
                axis.symbol(),
                significant(*load, 4),
                axis.unit()
            )
        });
    let rated: Vec<String> = rated.collect();
    if !rated.is_empty() {
        rows.push(("Rated loads", rated.join(", ")));
    }
    if rows.is_empty() {
        return;
    }
    page.section("sensor", "", "Sensor", |page| {
        page.within("dl", "", |page| {
            for (label, text) in rows {
                page.element("dt", label);
                page.element("dd", &text);
            }
        });
    });
}

/// Each paragraph of the notes as one.
pub(super) fn notes(report: &ReportData, page: &mut Markup) {
    let lines = report.notes.lines().map(str::trim);
    let lines: Vec<&str> = lines.filter(|line| !line.is_empty()).collect();
    if lines.is_empty() {
        return;
    }
    page.section("notes", "", "Notes", |page| {
        for line in lines {
            page.element("p", line);
        }
    });
}

pub(super) fn warnings(report: &ReportData, page: &mut Markup) {
    page.section("warnings", "", "Warnings", |page| {
        if report.warnings.is_empty() {
            page.element("p", "None.");
            return;
        }
        page.within("div", "class=\"warnings\"", |page| {
            page.within("ul", "", |page| {
                for warning in &report.warnings {
                    page.element("li", warning);
                }
            });
        });
    });
}

pub(super) fn check(report: &ReportData, page: &mut Markup) {
    page.section("check", "", "Enough data?", |page| {
        let found = match &report.check {
            Ok(found) => found,
            Err(reason) => return page.element("p", reason),
        };
        page.element("p", &format!("{}.", found.verdict.words()));
        page.within("ul", "", |page| {
            for sentence in found.sentences() {
                page.element("li", &format!("{sentence}."));
            }
        });
        page.element("p", &found.rank_in_words());
        sufficiency_tables(found)
            .iter()
            .for_each(|table| page.table(table));
    });
}

pub(super) fn scores(report: &ReportData, page: &mut Markup) {
    let (calibration, factory) = (&report.calibration, report.factory.as_ref());
    page.section("scores", "", "Errors", |page| {
        page.element(
            "p",
            "Root mean squared error per axis. Calc.: the true load; Conv.: from the present gauges alone; Comp.: with what the \
             past adds.",
        );
        // The most telling first.
        for set in [ScoreSet::Test, ScoreSet::LeftOut, ScoreSet::Train] {
            match errors(calibration, factory, set, Shown::All) {
                Ok(table) => page.table(&table),
                Err(reason) => page.element("p", &format!("RMSE, {}: {reason}.", set.label())),
            }
        }
        if let Some(factory) = factory {
            page.element("p", &factory_note(calibration, factory));
        }
    });
}

pub(super) fn recordings(report: &ReportData, page: &mut Markup) {
    page.section("recordings", "page", "Recordings", |page| {
        let mut columns = ["Name", "Role", "Group"].map(Column::words).to_vec();
        columns.extend(["Samples", "Duration [s]", "Rate [Hz]"].map(Column::numbers));
        columns.push(Column::words("File"));
        columns.push(Column {
            align: Align::Anywhere,
            ..Column::words("SHA-256 of the file")
        });
        page.table(&Table {
            columns,
            rows: report.recordings.iter().map(recording_row).collect(),
            ..Table::default()
        });
        let mut columns = vec![Column::words("RMSE, Conv. → Comp.")];
        columns.extend(report.calibration.axes.iter().copied().map(Column::load));
        let rows = report.recordings.iter();
        page.table(&Table {
            rows: rows
                .map(|recording| rmse_row(recording, columns.len()))
                .collect(),
            columns,
            ..Table::default()
        });
    });
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

pub(super) fn expected_error(report: &ReportData, page: &mut Markup) {
    page.section(
        "expected-error",
        "",
        "Expected error",
        |page| match &report.expected_error {
            Ok(found) => page.table(&Table {
                title: String::new(),
                ..expected_error_table(found)
            }),
            Err(reason) => page.element("p", reason),
        },
    );
}

/// Writes the outcome of each limit, where there are any.
pub(super) fn limits(report: &ReportData, page: &mut Markup) {
    if report.limits.is_empty() {
        return;
    }
    page.section("limits", "", "Limits", |page| {
        page.table(&limits_table(&report.limits))
    });
}

pub(super) fn settings(report: &ReportData, page: &mut Markup) {
    let rows = setting_rows(&report.calibration).into_iter();
    let rows = rows.map(|(name, value)| vec![Cell::words(name), Cell::words(value)]);
    let table = Table {
        columns: ["Setting", "Value"].map(Column::words).to_vec(),
        rows: rows.collect(),
        ..Table::default()
    };
    page.section("settings", "", "Settings", |page| page.table(&table));
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

pub(super) fn matrices(report: &ReportData, page: &mut Markup) {
    let calibration = &report.calibration;
    page.section("matrices", "page", "Calibration matrices", |page| {
        page.element(
            "p",
            "The load is the sum over the features, each times its number. Forces in N, moments in N·m, gauges in the unit of \
             the recordings.",
        );
        matrix("Conventional (Conv.)", &calibration.conventional, calibration, page);
        if let Some(map) = &calibration.compensated {
            matrix("Compensated (Comp.)", map, calibration, page);
            if let Some(known) = &calibration.quality.coefficients {
                let map = LinearMap { columns: map.columns.clone(), matrix: known.standard.clone() };
                let title = format!("Compensated (Comp.): standard errors, a jackknife {}", known.left_out);
                matrix(&title, &map, calibration, page);
            }
        }
        if calibration.learned.is_some() {
            page.element(
                "p",
                "What the network or kernel adds to it is in the complete calibration (JSON) alone.",
            );
        }
    });
}

fn matrix(title: &str, map: &LinearMap, calibration: &Calibration, page: &mut Markup) {
    let mut columns = vec![Column::words("Feature")];
    columns.extend(calibration.axes.iter().copied().map(Column::load));
    let features = map.names(&calibration.gauges);
    let features = features.iter().enumerate().take(MAX_FEATURES);
    let rows = features.map(|(column, feature)| {
        let numbers = map.matrix.iter();
        let numbers = numbers.map(|numbers| Cell::digits(Some(numbers[column]), 7));
        std::iter::once(Cell::words(feature))
            .chain(numbers)
            .collect()
    });
    let more = map.columns.len().saturating_sub(MAX_FEATURES);
    page.table(&Table {
        title: title.to_owned(),
        columns,
        rows: rows.collect(),
        note: match more {
            0 => String::new(),
            more => format!("and {more} more, which the complete calibration (JSON) has."),
        },
    });
}
