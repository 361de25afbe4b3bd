//! The figures of a report.

use super::ReportData;
use super::markup::Markup;
use crate::report::figure::Figure;

/// Curves stand beside each other where the page is wide.
const CURVES_SIZE: (f64, f64) = (620.0, 400.0);
/// Two loops stand beside each other.
const LOOP_SIZE: (f64, f64) = (620.0, 480.0);
/// Time goes across the whole page.
const TRACE_SIZE: (f64, f64) = (1100.0, 300.0);

pub(super) fn thresholds(report: &ReportData, page: &mut Markup) {
    page.section(
        "thresholds",
        "page",
        "Errors over the thresholds",
        |page| match &report.thresholds {
            Err(reason) => page.element("p", reason),
            Ok(curves) => {
                page.element("p", &curves.about);
                page.within("div", "class=\"curves\"", |page| {
                    for plot in &curves.plots {
                        picture(page, plot, CURVES_SIZE);
                    }
                });
            }
        },
    );
}

pub(super) fn loops(report: &ReportData, page: &mut Markup) {
    page.section("loops", "page", "Hysteresis loops", |page| {
        page.element(
            "p",
            &format!(
                "The error over the true load, of {}. Thin: all branches; thick: the mean loop of the full cycles, or \
                 the largest cycle where these are fewer than three or cover little, dashed where the load falls. A sensor without hysteresis draws one line.",
                report.measured
            ),
        );
        page.within("div", "class=\"pictures\"", |page| {
            for (figure, axis) in report.loops.iter().zip(&report.calibration.axes) {
                match figure {
                    Ok(figure) => picture(page, figure, LOOP_SIZE),
                    Err(reason) => page.within("figure", "", |page| {
                        page.element("h3", axis.symbol());
                        page.element("figcaption", reason);
                    }),
                }
            }
        });
    });
}

pub(super) fn errors(report: &ReportData, page: &mut Markup) {
    page.section("errors", "page", "Errors over time", |page| {
        let Some(errors) = &report.errors else {
            page.element("p", "No recording has a reference load to compare with.");
            return;
        };
        let about = format!("{}: {}.", errors.recording, errors.chosen);
        page.element("p", &about);
        for figure in &errors.figures {
            picture(page, figure, TRACE_SIZE);
        }
    });
}

fn picture(page: &mut Markup, figure: &Figure<'_>, size: (f64, f64)) {
    page.within("figure", "", |page| page.raw(&figure.svg(size)));
}
