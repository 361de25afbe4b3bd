//! HTML page of a report: fills the template with texts, tables and figures.

use minijinja::{Value, context};

use super::{
    data::{ReportData, utc},
    request::sentence,
    tables,
};
use crate::{
    export::filled_markup,
    finding::Face,
    questions::{
        budget::budget_table,
        check::{independent_loads::Sufficiency, rig_and_axes, rig_figures},
        errors::{errors, factory_note},
        expected_error::{expected_error_table, limits_table},
        loops::{FiguresOf, Inks, LoopPlot, LoopView},
        metrology::{axis_figures, crosstalk},
    },
    recording::Role,
    report::{Align, Cell, Column, Shown, Table, Value as CellValue, figure::Figure},
    scoring::score_set::ScoreSet,
};

const CURVES_SIZE: (f64, f64) = (620.0, 400.0);
const LOOP_SIZE: (f64, f64) = (620.0, 480.0);
const TRACE_SIZE: (f64, f64) = (1100.0, 300.0);

pub fn html_of(report: &ReportData) -> String {
    let calibration = &report.calibration;
    let count = |role: Role| {
        report.recordings.iter().filter(|recording| recording.used.role == role).count()
    };
    let notes = report.notes.lines().map(|line| line.trim().to_owned());
    let scores = [ScoreSet::Test, ScoreSet::LeftOut, ScoreSet::Train].map(|set| {
        let found = errors(calibration, report.factory.as_ref(), set, Shown::All);
        (set.label(), or_reason(&found, table))
    });
    let loops = report.loops.iter().zip(&calibration.axes);
    let loops = loops.map(|(found, axis)| {
        let shown = or_reason(found, |plots| plots.iter().flat_map(loop_pictures).collect());
        (axis.symbol(), shown)
    });
    let values = context! {
        style => Value::from_safe_string(include_str!("style.css").to_owned()),
        version => env!("CARGO_PKG_VERSION"),
        made => utc(report.made),
        program => &*calibration.program,
        kind => if report.fitted { "fitted to" } else { "applied to" },
        n_recordings => report.recordings.len(),
        n_train => count(Role::Train),
        n_test => count(Role::Test),
        sensor => tables::sensor(calibration),
        notes => notes.filter(|line| !line.is_empty()).collect::<Vec<_>>(),
        warnings => report.warnings.iter().map(|warning| sentence(&warning.to_string())).collect::<Vec<_>>(),
        budget => report.check.as_ref().ok().and_then(|found| found.budget.as_ref().ok()).map(|budget| table(&budget_table(budget))),
        remedies => report.check.as_ref().map_or_else(|_| Vec::new(), Sufficiency::remedies_in_words),
        check => or_reason(&report.check, |found| context! {
            verdict => found.verdict.words(),
            sentences => found.sentences(Face::Page).collect::<Vec<_>>(),
            holds_for => &*found.holds_for,
            pictures => pictures(&rig_figures(&found.rig), CURVES_SIZE),
            rank => found.rank_in_words(),
            tables => all(&rig_and_axes(found)),
        }),
        scores,
        factory => report.factory.as_ref().map(|factory| factory_note(calibration, factory)),
        expected_error => or_reason(&report.expected_error, |found| table(&Table {
            title: String::new(),
            ..expected_error_table(found)
        })),
        limits => (!report.limits.is_empty()).then(|| table(&limits_table(&report.limits))),
        settings => table(&tables::settings(calibration)),
        thresholds => or_reason(&report.thresholds, |curves| context! {
            about => &*curves.about,
            pictures => pictures(&curves.plots, CURVES_SIZE),
        }),
        measured => report.measured,
        loops => loops.collect::<Vec<_>>(),
        errors => report.errors.as_ref().map(|errors| context! {
            recording => &*errors.recording,
            chosen => errors.chosen,
            pictures => pictures(&errors.figures, TRACE_SIZE),
        }),
        metrology => or_reason(&report.metrology, |found| {
            let axes = (0..found.axes.len()).map(|at| axis_figures(found, at, Shown::All));
            let definitions = found.definitions().map(|(name, about)| (name, about.sentences()));
            context! {
                n_recordings => found.n_recordings,
                n_samples => found.n_samples,
                notes => found.findings.iter().map(ToString::to_string).collect::<Vec<_>>(),
                tables => all(&axes.chain(crosstalk(found)).collect::<Vec<_>>()),
                definitions => definitions.collect::<Vec<_>>(),
            }
        }),
        matrices => all(&tables::matrices(calibration)),
        is_learned => calibration.learned.is_some(),
        recordings => all(&tables::recordings(report)),
    };
    filled_markup(include_str!("report.html"), values)
}

fn or_reason<T>(found: &Result<T, String>, shown: impl FnOnce(&T) -> Value) -> Value {
    match found {
        Ok(found) => shown(found),
        Err(reason) => context! { reason => &**reason },
    }
}

/// Returns the plot of the loops. If a time lag explains much of the loop width, adds a plot of width against load rate.
fn loop_pictures(plot: &LoopPlot) -> Vec<Value> {
    let view = LoopView::of_all(plot, ("", ""), FiguresOf::Mean);
    let by_rate = plot.lag.is_worth_removing().then(|| view.widths_by_rate(&Inks::PRINT));
    let loops = view.figure(&Inks::PRINT, None);
    pictures(&[loops].into_iter().chain(by_rate.flatten()).collect::<Vec<_>>(), LOOP_SIZE)
}

fn pictures(figures: &[Figure<'_>], size: (f64, f64)) -> Vec<Value> {
    figures.iter().map(|figure| Value::from_safe_string(figure.svg(size))).collect()
}

fn all(tables: &[Table]) -> Vec<Value> {
    tables.iter().map(table).collect()
}

/// Returns the HTML markup of a table, with its title above and its notes below.
fn table(table: &Table) -> Value {
    let titles = table.columns.iter();
    let titles: Vec<Cell> = titles.map(|column| Cell::words(column.title())).collect();
    let mut notes = Vec::new();
    let mut row = |cells: &[Cell]| row(&table.columns, cells, &mut notes);
    let head = row(&titles);
    let rows: Vec<_> = table.rows.iter().map(|cells| row(cells)).collect();
    let values = context! { title => &*table.title, head, rows, notes, note => &*table.note };
    let markup = filled_markup(include_str!("table.html"), values);
    Value::from_safe_string(markup.trim_end().to_owned())
}

/// Returns the HTML attributes and the text of each cell in a table row. A reason in a narrow cell is replaced by the number
/// of a footnote.
fn row(columns: &[Column], cells: &[Cell], notes: &mut Vec<String>) -> Vec<(Value, String)> {
    let mut row = Vec::new();
    let mut cells = columns.iter().zip(cells).peekable();
    while let Some((column, cell)) = cells.next() {
        let mut span = 1;
        while cells.next_if(|(_, next)| next.value == CellValue::Continued).is_some() {
            span += 1;
        }
        let Some(reason) = cell.reason() else {
            let attributes = match column.align {
                Align::Left => "",
                Align::Right => " class=\"number\"",
                Align::Anywhere => " class=\"hash\"",
            };
            let attributes = Value::from_safe_string(attributes.to_owned());
            row.push((attributes, cell.text.clone()));
            continue;
        };
        let mut text = reason.to_owned();
        if span == 1 && columns.len() > 3 {
            let known = notes.iter().position(|known_note| known_note == reason);
            let at = known.unwrap_or_else(|| {
                notes.push(text);
                notes.len() - 1
            });
            text = format!("({})", at + 1);
        }
        let attributes = format!(" class=\"reason\" colspan=\"{span}\"");
        row.push((Value::from_safe_string(attributes), text));
    }
    row
}
