//! The certificate: on its first page what a laboratory hands over, then what that rests on.

use super::markup::Markup;
use super::{Certificate, ReportData, figures, metrology, tables, utc};
use crate::calibration::{Calibration, UsedRecording};
use crate::evaluation::limits::{Checked, Verdict};
use crate::evaluation::numbers::significant;
use crate::evaluation::uncertainty::{Source, StepQuantity, Uncertainty};
use crate::recording::{Item, Role};
use crate::report::{Align, Cell, Column, Table, uncertainty_tables};

/// What a certificate has a line for, whether or not somebody filled it in.
const ALWAYS: [Item; 8] = [
    Item::Manufacturer,
    Item::Model,
    Item::Serial,
    Item::Laboratory,
    Item::Date,
    Item::Operator,
    Item::Reference,
    Item::ReferenceCertificate,
];
/// More files than this are told of at the end.
const FILES: usize = 6;
/// More figures that are out of their limits are counted.
const FAILED: usize = 4;

pub(super) fn contents(report: &ReportData, certificate: &Certificate, page: &mut Markup) {
    page.within("section", "id=\"certificate\" class=\"first\"", |page| {
        head(report, certificate, page);
        identity(&report.calibration, page);
        results(report, certificate, page);
        statements(report, page);
        files(&report.calibration, page);
        signatures(&report.calibration, page);
    });
    page.section("uncertainty", "page", "Uncertainty", |page| {
        uncertainty(report, page)
    });
    if !certificate.checked.is_empty() {
        page.section("limits", "", "Limits", |page| {
            page.table(&limits(certificate))
        });
    }
    tables::settings(report, page);
    tables::matrices(report, page);
    figures::loops(report, page);
    figures::errors(report, page);
    if !report.calibration.features.look_backs.is_empty() {
        figures::thresholds(report, page);
    }
    metrology::section(report, page);
    tables::recordings(report, page);
    tables::warnings(report, page);
}

fn head(report: &ReportData, certificate: &Certificate, page: &mut Markup) {
    let calibration = &report.calibration;
    page.element("h1", "Calibration certificate");
    let number = calibration.identity.get(Item::Certificate).trim();
    let number = if number.is_empty() {
        String::new()
    } else {
        format!("No. {number}. ")
    };
    page.raw("<p class=\"about\">");
    page.text(&format!(
        "{number}Multi-axis force/torque sensor, {} axes, {} gauges. LoopScope {}{}.",
        calibration.axes.len(),
        calibration.gauges.len(),
        env!("CARGO_PKG_VERSION"),
        if certificate.dated {
            format!(", {}", utc(report.made))
        } else {
            String::new()
        },
    ));
    page.raw("</p>");
    if calibration.simulated {
        page.raw("<p class=\"warnings\">");
        page.text("Made from the built-in simulated sensor, not from a real one.");
        page.raw("</p>");
    }
}

/// Under the headings of the items, what was entered, and lines to fill in.
fn identity(calibration: &Calibration, page: &mut Markup) {
    let identity = &calibration.identity;
    let rated: Vec<String> = calibration
        .axes
        .iter()
        .enumerate()
        .filter(|(at, _)| calibration.rated.get(*at) == Some(&true))
        .map(|(at, axis)| {
            format!(
                "{} {} {}",
                axis.symbol(),
                significant(calibration.full_scale[at], 4),
                axis.unit()
            )
        })
        .collect();
    let mut headings: Vec<&str> = Item::all().map(Item::heading).collect();
    headings.sort_by_key(|heading| Item::all().position(|item| item.heading() == *heading));
    headings.dedup();
    page.within("div", "class=\"identity\"", |page| {
        for heading in headings {
            let items = Item::all().filter(|item| item.heading() == heading);
            let shown = items.filter(|item| {
                *item != Item::Certificate
                    && (ALWAYS.contains(item) || !identity.get(*item).trim().is_empty())
            });
            let mut rows: Vec<(&str, String)> = shown
                .map(|item| (item.label(), identity.get(item).trim().to_owned()))
                .collect();
            if heading == Item::Serial.heading() && !rated.is_empty() {
                rows.push(("Rated loads", rated.join(", ")));
            }
            if rows.is_empty() {
                continue;
            }
            page.within("div", "", |page| {
                page.element("h3", heading);
                page.within("dl", "", |page| {
                    for (label, text) in rows {
                        page.element("dt", label);
                        match text.is_empty() {
                            true => page.raw("<dd class=\"blank\"></dd>"),
                            false => page.element("dd", &text),
                        }
                    }
                });
            });
        }
    });
}

/// What is handed over: one row per axis.
fn results(report: &ReportData, certificate: &Certificate, page: &mut Markup) {
    let calibration = &report.calibration;
    let with_limits = !certificate.checked.is_empty();
    let mut columns = vec![
        Column::words("Axis"),
        Column::numbers("Full scale"),
        Column::numbers("Loaded from … to"),
    ];
    columns.extend(
        [
            "U (k = 2)",
            "U [% FS]",
            "Errors within U [%]",
            "RMSE left out",
            "RMSE test",
        ]
        .map(Column::numbers),
    );
    if with_limits {
        columns.push(Column::words("Limits"));
    }
    let scores = &calibration.quality.compensated;
    let row = |at: usize| {
        let axis = calibration.axes[at];
        let unit = axis.unit();
        let load = |value: Option<f64>| match value {
            Some(value) => Cell::number(value, format!("{} {unit}", significant(value, 3))),
            None => Cell::none(),
        };
        let own = report
            .uncertainty
            .as_ref()
            .ok()
            .and_then(|found| found.of_axis(axis).ok());
        let full = calibration.full_scale[at];
        let mut cells = vec![
            Cell::words(axis.symbol()),
            Cell::number(full, format!("{} {unit}", significant(full, 4))),
            match own.map(|own| own.range) {
                Some((low, high)) => Cell::number(
                    high - low,
                    format!("{} … {}", significant(low, 3), significant(high, 3)),
                ),
                None => Cell::none(),
            },
            load(own.map(|own| own.expanded)),
            Cell::digits(own.and_then(|own| own.percent_fs), 3),
            Cell::digits(
                own.and_then(|own| own.coverage.as_ref().ok())
                    .map(|own| 100.0 * own.share),
                3,
            ),
            load(scores.cv_rmse.as_ref().map(|rmse| rmse[at])),
            load(scores.test_rmse.as_ref().map(|rmse| rmse[at])),
        ];
        if with_limits {
            let mut of_axis = certificate
                .checked
                .iter()
                .filter(|own| own.axis == Some(axis))
                .peekable();
            cells.push(Cell::words(
                match (of_axis.peek().is_some(), of_axis.all(|own| own.pass)) {
                    (false, _) => "–",
                    (true, true) => "pass",
                    (true, false) => "FAIL",
                },
            ));
        }
        cells
    };
    page.table(&Table {
        title: "Results".to_owned(),
        columns,
        rows: (0..calibration.axes.len()).map(row).collect(),
        ..Table::default()
    });
    let verdict = match Verdict::of(&certificate.checked) {
        Verdict::Pass => "The calibration keeps all limits that were given: PASS.".to_owned(),
        Verdict::Fail => {
            let failed: Vec<String> = certificate
                .checked
                .iter()
                .filter(|own| !own.pass)
                .map(Checked::told)
                .collect();
            let more = failed.len().saturating_sub(FAILED);
            let more = if more > 0 {
                format!("; and {more} more, under Limits")
            } else {
                String::new()
            };
            let failed = failed[..failed.len().min(FAILED)].join("; ");
            format!(
                "The calibration does not keep all limits that were given: FAIL. {failed}{more}."
            )
        }
        Verdict::None => "No limits were given; nothing is said of conformity.".to_owned(),
    };
    page.within("p", "class=\"verdict\"", |page| page.text(&verdict));
}

fn statements(report: &ReportData, page: &mut Markup) {
    match &report.uncertainty {
        Ok(found) => {
            page.element("p", &stated(found));
            for note in &found.notes {
                page.element("p", &format!("{note}."));
            }
        }
        Err(reason) => page.element("p", &format!("No uncertainty is stated: {reason}")),
    }
    if !report.warnings.is_empty() {
        let n = report.warnings.len();
        let what = if n == 1 { "warning" } else { "warnings" };
        page.element(
            "p",
            &format!("To be read with the {n} {what} on the last pages."),
        );
    }
}

fn stated(found: &Uncertainty) -> String {
    format!(
        "U is the combined standard uncertainty of one reading of the compensated load, times the coverage factor k = 2, after JCGM 100 (GUM). \
         It is one figure for all loads between those of the table, and is of {}. Errors within U: how often an error of what was left out is within the U of the others; 95 % is expected.",
        found.of
    )
}

fn files(calibration: &Calibration, page: &mut Markup) {
    let sources: &[UsedRecording] = &calibration.sources;
    if sources.is_empty() {
        return;
    }
    let mut seen: Vec<(&str, &str, Role)> = Vec::new();
    for used in sources {
        let (file, hash) = (
            used.file.as_deref().unwrap_or("–"),
            used.sha256.as_deref().unwrap_or("not known"),
        );
        if !seen
            .iter()
            .any(|(own, other, _)| (*own, *other) == (file, hash))
        {
            seen.push((file, hash, used.role));
        }
    }
    let more = seen.len().saturating_sub(FILES);
    let rows = seen.iter().take(FILES).map(|(file, hash, role)| {
        vec![
            Cell::words(*file),
            Cell::words(role.label()),
            Cell::words(*hash),
        ]
    });
    page.table(&Table {
        title: "Recordings".to_owned(),
        columns: vec![
            Column::words("File"),
            Column::words("Role"),
            Column {
                align: Align::Anywhere,
                ..Column::words("SHA-256")
            },
        ],
        rows: rows.collect(),
        note: if more > 0 {
            format!("and {more} more files, at the end.")
        } else {
            String::new()
        },
    });
}

/// Lines to sign on.
fn signatures(calibration: &Calibration, page: &mut Markup) {
    page.within("div", "class=\"signatures\"", |page| {
        for (label, item) in [
            ("Calibrated by", Item::Operator),
            ("Approved by", Item::Approver),
        ] {
            page.within("div", "", |page| {
                page.raw("<div class=\"line\"></div>");
                let name = calibration.identity.get(item).trim();
                let name = if name.is_empty() {
                    String::new()
                } else {
                    format!(": {name}")
                };
                page.element("p", &format!("{label}{name}; date, signature"));
            });
        }
    });
}

fn uncertainty(report: &ReportData, page: &mut Markup) {
    let found = match &report.uncertainty {
        Ok(found) => found,
        Err(reason) => return page.element("p", reason),
    };
    for table in uncertainty_tables(found) {
        page.table(&table);
    }
    page.element("h3", "How each part is made");
    page.within("dl", "class=\"definitions\"", |page| {
        for source in Source::ALL {
            let texts = source.texts();
            page.element("dt", texts.name);
            page.element("dd", &format!("{}. {}.", texts.formula, texts.basis));
        }
        if found.steps.iter().any(|own| !own.levels.is_empty()) {
            for quantity in StepQuantity::ALL {
                let [symbol, name, about] = quantity.texts();
                page.element("dt", &format!("{symbol}, {name}"));
                page.element("dd", &format!("{about}."));
            }
        }
    });
}

fn limits(certificate: &Certificate) -> Table {
    let columns = vec![
        Column::words("Figure"),
        Column::words("Axis"),
        Column::numbers("Value"),
        Column::numbers("Limit"),
        Column::words("Unit"),
        Column::words(""),
    ];
    let rows = certificate.checked.iter().map(|own| {
        let sign = if own.at_least { "≥" } else { "≤" };
        vec![
            Cell::words(&own.figure),
            Cell::words(own.axis.map_or("–", crate::recording::Axis::symbol)),
            match (own.value, &own.reason) {
                (Some(value), _) => Cell::digits(Some(value), 4),
                (None, reason) => Cell::missing("–", reason.clone().unwrap_or_default()),
            },
            Cell::number(own.limit, format!("{sign} {}", significant(own.limit, 4))),
            Cell::words(&own.unit),
            Cell::words(if own.pass { "pass" } else { "FAIL" }),
        ]
    });
    Table {
        columns,
        rows: rows.collect(),
        ..Table::default()
    }
}
