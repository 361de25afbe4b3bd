//! The figures of a report, with what each means.

use super::ReportData;
use super::markup::Markup;
use crate::questions::errors::Shown;
use crate::questions::metrology::{axis_figures, crosstalk};

pub(super) fn section(report: &ReportData, page: &mut Markup) {
    page.section("metrology", "page", "Figures", |page| {
        let table = match &report.metrology {
            Ok(table) => table,
            Err(reason) => return page.element("p", reason),
        };
        page.element(
            "p",
            &format!(
                "Of {}: {} recordings, {} samples. How each figure is computed stands below.",
                report.measured, table.n_recordings, table.n_samples
            ),
        );
        for note in &table.notes {
            page.element("p", &format!("Note: {note}"));
        }
        let axes = (0..table.axes.len()).map(|at| axis_figures(table, at, Shown::All));
        for shown in axes.chain(crosstalk(table)) {
            page.table(&shown);
        }
        page.element("h3", "Definitions");
        page.within("dl", "class=\"definitions\"", |page| {
            for (name, about) in table.definitions() {
                page.element("dt", name);
                for sentence in about.sentences() {
                    page.element("dd", &sentence);
                }
            }
        });
    });
}
