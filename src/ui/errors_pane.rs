//! Pane with the errors of each axis on training samples, on test samples and by cross-validation.

use std::sync::Arc;

use egui::Ui;

use crate::{
    engine::Engine,
    finding::Face,
    questions::{
        Analysis,
        errors::errors,
        expected_error::{expected_error_column, expected_error_table, query::AskExpectedError},
    },
    report::{Shown, Table},
    scoring::score_set::ScoreSet,
    ui::{
        command::Pane,
        controls::Controls as _,
        pane::{Cx, PaneView},
        status_line::preview_of,
        table,
    },
};

pub const PANE: Pane = Pane {
    key: "errors",
    title: "Errors",
    explanation: "RMSE of each axis on training samples, on test samples and by cross-validation; expected error on new recordings",
};

#[derive(Debug, Default)]
pub struct View;

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        errors_pane(ui, cx.engine);
        // While a slider is dragged, the pane keeps the expected error of the previous settings.
        if let Some((of, analysis)) = cx.engine.exact().filter(|_| cx.engine.gesture.is_none())
            && cx.engine.is_current()
        {
            cx.ask(AskExpectedError::of(of, analysis));
        }
    }
}

fn errors_pane(ui: &mut Ui, engine: &Engine) {
    ui.take_available_width();
    ui.horizontal_wrapped(|ui| {
        ui.strong("RMSE");
        let Some(analysis) = engine.analysis() else {
            return;
        };
        ui.copies("table", || all_errors(analysis, engine).tab_separated());
        if !analysis.fitted {
            ui.weak("Errors of the loaded calibration, applied to these recordings");
            return;
        }
        if let Some(each) = analysis.preview_of {
            ui.warn(preview_of(each));
        }
        let quality = &analysis.calibration.quality;
        if let Some(how) = &quality.cross_validation
            && quality.compensated.cv_rmse.is_some()
        {
            ui.weak(format!("Cross-validation (CV) {how}"));
        }
        for found in &analysis.findings {
            ui.warn(&found.seen).on_hover_text(found.text(Face::Window));
        }
    });
    let Some(analysis) = engine.analysis() else {
        ui.weak("No calibration is fitted yet.");
        return;
    };
    ui.scrolled(|ui| {
        table::show(ui, &all_errors(analysis, engine));
        ui.add_space(8.0);
        expected(ui, engine);
    });
}

fn expected(ui: &mut Ui, engine: &Engine) {
    let lane = engine.lane::<AskExpectedError>();
    match lane.answer() {
        Some(Ok(found)) => {
            table::show(ui, &expected_error_table(found));
            if !is_of_screen(engine) {
                ui.weak("updating");
            }
        }
        Some(Err(reason)) => {
            drop(ui.weak(format!("The expected error cannot be computed: {reason}")))
        }
        None => drop(ui.weak(lane.problem().unwrap_or("The expected error is not computed yet."))),
    }
}

fn is_of_screen(engine: &Engine) -> bool {
    let answered = engine.lane::<AskExpectedError>().answered();
    let shown = engine.analysis().zip(answered);
    shown.is_some_and(|(analysis, answered)| {
        Arc::ptr_eq(&analysis.calibration, &answered.calibration)
    })
}

/// Returns a table with one row for each axis: the expected error, then the errors on training samples, on test samples and
/// by cross-validation.
fn all_errors(analysis: &Analysis, engine: &Engine) -> Table {
    let factory = analysis.factory.as_ref();
    let known = engine.lane::<AskExpectedError>().answer().and_then(|answer| answer.as_ref().ok());
    let known = known.filter(|expected| expected.axes.len() == analysis.calibration.axes.len());
    let title = if is_of_screen(engine) { "Expected" } else { "Expected, updating" };
    let expected = known.map(|expected| (title.to_owned(), expected_error_column(expected)));
    let tables = ScoreSet::ALL.into_iter().filter_map(|set| {
        let table = errors(&analysis.calibration, factory, set, Shown::Units).ok()?;
        Some((set.title().to_owned(), table))
    });
    Table::beside("", expected.into_iter().chain(tables))
}
