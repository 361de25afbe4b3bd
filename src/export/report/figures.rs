//! The pictures of a report.

use std::io;

use super::ReportData;
use super::markup::Markup;
use crate::export::svg::write_curves_svg;
use crate::export::write_drawing_svg;

/// Two loops stand beside each other.
const LOOP_SIZE: (f64, f64) = (620.0, 480.0);
/// Time goes across the whole page.
const TRACE_SIZE: (f64, f64) = (1100.0, 300.0);

pub(super) fn thresholds(report: &ReportData, page: &mut Markup) -> io::Result<()> {
    let mut done = Ok(());
    page.section(
        "thresholds",
        "page",
        "Errors over the thresholds",
        |page| match &report.thresholds {
            Err(reason) => page.element("p", reason),
            Ok(curves) => {
                page.element("p", &curves.about);
                page.within("div", "class=\"curves\"", |page| {
                    let mut plots = curves.plots.iter();
                    done =
                        plots.try_for_each(|plot| picture(page, |out| write_curves_svg(plot, out)));
                });
            }
        },
    );
    done
}

pub(super) fn loops(report: &ReportData, page: &mut Markup) -> io::Result<()> {
    let mut done = Ok(());
    page.section("loops", "page", "Hysteresis loops", |page| {
        page.element(
            "p",
            &format!(
                "The error over the true load, of {}. Thin: all branches; thick: the mean loop of the full cycles. A sensor \
                 without hysteresis draws one line.",
                report.measured
            ),
        );
        page.within("div", "class=\"pictures\"", |page| {
            done = (report.loops.iter().zip(&report.calibration.axes))
                .try_for_each(|(drawing, axis)| match drawing {
                    Ok(drawing) => picture(page, |out| write_drawing_svg(drawing, LOOP_SIZE, out)),
                    Err(reason) => {
                        page.within("figure", "", |page| {
                            page.element("h3", axis.symbol());
                            page.element("figcaption", reason);
                        });
                        Ok(())
                    }
                });
        });
    });
    done
}

pub(super) fn errors(report: &ReportData, page: &mut Markup) -> io::Result<()> {
    let mut done = Ok(());
    page.section("errors", "page", "Errors over time", |page| {
        let Some(errors) = &report.errors else {
            page.element("p", "No recording has a reference load to compare with.");
            return;
        };
        let about = format!("{}: {}.", errors.recording, errors.chosen);
        page.element("p", &about);
        done = (errors.drawings.iter()).try_for_each(|drawing| {
            picture(page, |out| write_drawing_svg(drawing, TRACE_SIZE, out))
        });
    });
    done
}

fn picture(
    page: &mut Markup,
    write: impl FnOnce(&mut dyn io::Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut svg = Vec::new();
    write(&mut svg)?;
    let svg = String::from_utf8(svg).map_err(io::Error::other)?;
    page.within("figure", "", |page| page.raw(&svg));
    Ok(())
}
