//! HTML page of a report: fills the template with texts, tables and figures.

use minijinja::{Value, context};

use super::{
    data::{ReportData, utc},
    request::sentence,
    tables,
};
use crate::{
    export::filled_markup,
    finding::{Face, Finding},
    questions::{
        budget::budget_table,
        check::{independent_loads::Sufficiency, rig_figures},
        errors::factory_note,
        expected_error::{expected_error_table, limits_table},
        loops::{Inks, LoopPlot, LoopView},
    },
    recording::Role,
    report::{Align, Cell, Column, Table, figure::Figure},
};

/// Sizes of the figures (SVG units). The page has two figures of either size side by side.
const FIGURE: (f64, f64) = (660.0, 436.0);
const TRACE: (f64, f64) = (620.0, 260.0);
/// Maximum length of the findings on the first page, in characters. Further findings are on the second page.
const FIRST_FINDINGS: usize = 900;

pub fn html_of(report: &ReportData) -> String {
    let calibration = &report.calibration;
    let count = |role: Role| {
        report.recordings.iter().filter(|recording| recording.used.role == role).count()
    };
    let lines = |text: &str| -> Vec<String> {
        let lines = text.lines().map(|line| line.trim().to_owned());
        lines.filter(|line| !line.is_empty()).collect()
    };
    let check = report.check.as_ref();
    let (first_loop, loops) = split_loops(report);
    let (findings, more_findings) = findings(report);
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
        scores => table(tables::errors(calibration, report.factory.as_ref())),
        factory => report.factory.as_ref().map(|factory| factory_note(calibration, factory)),
        budget => check.ok().and_then(|found| found.budget.as_ref().ok()).map(|found| table(budget_table(found))),
        first_loop,
        expected_error => report.expected_error.as_ref().map_or_else(
            |reason| Value::from(&**reason),
            |found| table(expected_error_table(found)),
        ),
        findings,
        more_findings,
        notes => lines(&report.notes),
        limits => (!report.limits.is_empty()).then(|| table(limits_table(&report.limits))),
        remedies => check.map_or_else(|_| Vec::new(), Sufficiency::remedies_in_words),
        gauges => check.map_or_else(|_| Vec::new(), |found| pictures(&rig_figures(&found.rig), FIGURE)),
        settings => table(tables::settings_of_page(calibration)),
        measured => report.measured,
        loops,
        thresholds => report.thresholds.as_ref().ok().map(|curves| context! {
            about => &*curves.about,
            pictures => pictures(&curves.plots, FIGURE),
        }),
        errors => report.errors.as_ref().map(|errors| context! {
            recording => &*errors.recording,
            chosen => errors.chosen,
            pictures => pictures(&errors.figures, TRACE),
        }),
        metrology => report.metrology.as_ref().ok().map(|found| context! {
            n_recordings => found.n_recordings,
            n_samples => found.n_samples,
            notes => found.findings.iter().map(ToString::to_string).collect::<Vec<_>>(),
            table => table(tables::metrology(found)),
            definitions => tables::definitions(found),
        }),
        matrices => tables::matrices(calibration).into_iter().map(table).collect::<Vec<_>>(),
        is_learned => calibration.learned.is_some(),
        recordings => table(tables::recordings(report)),
    };
    filled_markup(include_str!("report.html"), values)
}

/// Returns the verdict of the check and the findings as sentences: those that the first page has space for, and the others.
fn findings(report: &ReportData) -> (Vec<String>, Vec<String>) {
    let of_check: Vec<String> = match &report.check {
        Ok(found) => {
            let verdict = [found.verdict.words().to_owned()];
            verdict.into_iter().chain(found.sentences(Face::Page)).collect()
        }
        Err(reason) => vec![reason.clone()],
    };
    let known = report.check.iter().flat_map(|found| &found.findings);
    let known: Vec<_> = known.map(|finding| finding.id).collect();
    let others = report.warnings.iter().filter(|warning| !known.contains(&warning.id));
    let others = Finding::ordered(others.cloned().collect());
    let all = of_check.into_iter().chain(others.iter().map(Finding::to_string));
    let all: Vec<String> = all.map(|text| sentence(&text)).collect();
    let mut length = 0;
    let (first, more): (Vec<_>, Vec<_>) = all.into_iter().partition(|text| {
        length += text.len();
        length < FIRST_FINDINGS
    });
    (first, more)
}

/// Returns the figure of the widest loop in shares of full scale, and those of the other axes. If a time lag explains much of a
/// width, the loop without the lag follows.
fn split_loops(report: &ReportData) -> (Option<Value>, Vec<Value>) {
    fn view(plot: &LoopPlot) -> LoopView<'_> {
        LoopView::of_all(plot, ("", ""))
    }
    let width = |plot: &LoopPlot| {
        let widths = view(plot).found().into_iter().map(|(_, figures)| figures.mean_width());
        widths.fold(0.0, f64::max) / plot.full_scale.max(f64::MIN_POSITIVE)
    };
    let mut plots: Vec<&LoopPlot> = report.loops.iter().flatten().flatten().collect();
    let widest = (0..plots.len()).max_by(|a, b| width(plots[*a]).total_cmp(&width(plots[*b])));
    let drawn = |plot: &LoopPlot| {
        Value::from_safe_string(view(plot).figure(&Inks::PRINT, None).svg(FIGURE))
    };
    let first = widest.map(|at| drawn(plots.remove(at)));
    (first, plots.into_iter().map(drawn).collect())
}

fn pictures(figures: &[Figure<'_>], size: (f64, f64)) -> Vec<Value> {
    figures.iter().map(|figure| Value::from_safe_string(figure.svg(size))).collect()
}

/// Returns the HTML markup of a table. Columns and rows without any number or text are left out; the names of these rows, and
/// the reasons for other missing numbers, are in the note.
fn table(table: Table) -> Value {
    let table = tables::known(table);
    let cell = |(column, cell): (&Column, &Cell)| {
        let class = match column.align {
            Align::Left => "",
            Align::Right => "number",
            Align::Anywhere => "hash",
        };
        (class, cell.text.clone())
    };
    let row = |cells: &[Cell]| table.columns.iter().zip(cells).map(cell).collect::<Vec<_>>();
    let titles: Vec<Cell> = table.columns.iter().map(|own| Cell::words(own.title())).collect();
    let values = context! {
        title => &*table.title,
        head => row(&titles),
        rows => table.rows.iter().map(|cells| row(cells)).collect::<Vec<_>>(),
        note => &*table.note,
    };
    let markup = filled_markup(include_str!("table.html"), values);
    Value::from_safe_string(markup.trim_end().to_owned())
}
