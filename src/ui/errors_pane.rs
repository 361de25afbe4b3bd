//! The table of errors: Conv. and Comp. per axis, on train, on test, and by cross-validation.

use crate::analysis::Analysis;
use crate::app::AppState;
use crate::evaluation::threshold_study::ScoreSet;
use crate::report::{Shown, Table, errors};
use crate::ui::table;

/// Draws the table.
pub fn errors_pane(ui: &mut egui::Ui, state: &AppState) {
    ui.take_available_width();
    ui.horizontal_wrapped(|ui| {
        ui.strong("RMSE");
        if let Some(analysis) = &state.analysis
            && ui
                .small_button("Copy table")
                .on_hover_text("As tab-separated text")
                .clicked()
        {
            ui.copy_text(all_errors(analysis).tab_separated());
        }
        let Some(analysis) = &state.analysis else {
            return;
        };
        if !analysis.fitted {
            ui.weak("of the applied calibration on these recordings");
            return;
        }
        if let Some(undetermined) = analysis.calibration.undetermined() {
            let color = ui.visuals().warn_fg_color;
            let counts = format!(
                "only {} samples for {} coefficients",
                undetermined.samples, undetermined.coefficients
            );
            ui.colored_label(color, counts)
                .on_hover_text(undetermined.to_string());
        }
        if let Some(reason) = analysis.calibration.why_not_left_out() {
            ui.weak(format!("no cross-validation: {reason}"));
        }
    });
    let Some(analysis) = &state.analysis else {
        ui.weak("Nothing is fitted yet.");
        return;
    };
    egui::ScrollArea::both()
        .auto_shrink([false, false])
        .show(ui, |ui| table::show(ui, &all_errors(analysis)));
}

/// One row per axis, the sets of samples beside each other as far as they are scored.
fn all_errors(analysis: &Analysis) -> Table {
    let factory = analysis.factory.as_ref();
    let tables = ScoreSet::ALL.into_iter().filter_map(|set| {
        let table = errors(&analysis.calibration, factory, set, Shown::Units).ok()?;
        Some((set.title().to_owned(), table))
    });
    Table::beside("", tables)
}
