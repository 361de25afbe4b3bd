//! The table of errors: Conv. and Comp. per axis, on train, on test, and by leave-one-recording-out.

use egui::RichText;

use crate::app::AppState;
use crate::calibration::{Quality, Scores};
use crate::evaluation::metrics::percent_change;
use crate::ui::numbers::{percent, significant};
use crate::ui::palette::Trace;

type Pick = fn(&Scores) -> &Option<Vec<f64>>;

/// Draws the table.
pub fn errors_pane(ui: &mut egui::Ui, state: &AppState) {
    ui.take_available_width();
    ui.horizontal(|ui| {
        ui.strong("RMSE");
        if let Some(analysis) = &state.analysis
            && !analysis.fitted
        {
            ui.weak("of the applied calibration on these recordings");
        }
        if let Some(analysis) = &state.analysis
            && analysis.fitted
            && let Some(reason) = analysis.calibration.why_not_left_out()
        {
            ui.weak(format!("no LOO-CV: {reason}"));
        }
    });
    let Some(analysis) = &state.analysis else {
        ui.weak("Nothing is fitted yet.");
        return;
    };
    let calibration = &analysis.calibration;
    let quality = &calibration.quality;
    let sets: [(&str, &str, Pick); 3] = [
        ("Train", "On the training recordings themselves", |s| {
            &s.train_rmse
        }),
        ("Test", "On the test recordings", |s| &s.test_rmse),
        (
            "LOO-CV",
            "Leave-one-recording-out: each training recording scored by a fit to the others; with fewer than three, five contiguous blocks of \
             them take turns. The look-back's trigger stays the conventional calibration of all",
            |s| &s.cv_rmse,
        ),
    ];
    egui::ScrollArea::both()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            egui::Grid::new("errors")
                .striped(true)
                .min_col_width(46.0)
                .spacing([10.0, 3.0])
                .show(ui, |ui| {
                    ui.label("");
                    for (title, explanation, _) in sets {
                        ui.strong(title).on_hover_text(explanation);
                        ui.label("");
                        ui.label("");
                        if analysis.factory.is_some() {
                            ui.label("");
                        }
                    }
                    ui.end_row();
                    ui.label("");
                    for _ in sets {
                        for trace in [Trace::Conventional, Trace::Compensated] {
                            let color = trace.color(ui.visuals());
                            ui.label(RichText::new(trace.label()).color(color))
                                .on_hover_text(trace.explanation());
                        }
                        ui.label("change").on_hover_text("From Conv. to Comp.");
                        if analysis.factory.is_some() {
                            let color = Trace::Factory.color(ui.visuals());
                            ui.colored_label(color, Trace::Factory.label())
                                .on_hover_text(Trace::Factory.explanation());
                        }
                    }
                    ui.end_row();
                    for (at, axis) in calibration.axes.iter().enumerate() {
                        ui.label(format!("{} [{}]", axis.symbol(), axis.unit()));
                        for (set, _, pick) in sets {
                            cells(ui, quality, pick, at);
                            if let Some(factory) = &analysis.factory {
                                let rmse = match set {
                                    "Train" => factory.train_rmse.get(at),
                                    "Test" => factory.test_rmse.get(at),
                                    _ => None,
                                };
                                let rmse = rmse.copied().flatten();
                                ui.label(
                                    rmse.map_or_else(
                                        || "–".to_owned(),
                                        |rmse| significant(rmse, 4),
                                    ),
                                );
                            }
                        }
                        ui.end_row();
                    }
                });
        });
}

fn cells(ui: &mut egui::Ui, quality: &Quality, pick: Pick, at: usize) {
    let value = |scores: &Scores| pick(scores).as_ref().and_then(|rmse| rmse.get(at).copied());
    let (before, after) = (value(&quality.conventional), value(&quality.compensated));
    for value in [before, after] {
        let text = value.map_or_else(|| "–".to_owned(), |value| significant(value, 4));
        ui.label(text);
    }
    let change = before
        .zip(after)
        .and_then(|(before, after)| percent_change(before, after));
    ui.label(percent(change));
}
