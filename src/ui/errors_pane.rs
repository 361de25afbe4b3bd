//! The table of errors: Conv. and Comp. per axis, on train, on test, and by leave-one-recording-out.

use egui::RichText;

use crate::app::AppState;
use crate::calibration::{Calibration, Quality, Scores};
use crate::evaluation::metrics::percent_change;
use crate::evaluation::threshold_study::ScoreSet;
use crate::ui::numbers::{percent, significant};
use crate::ui::palette::Trace;

/// Draws the table.
pub fn errors_pane(ui: &mut egui::Ui, state: &AppState) {
    ui.take_available_width();
    ui.horizontal(|ui| {
        ui.strong("RMSE");
        if let Some(analysis) = &state.analysis
            && ui
                .small_button("Copy table")
                .on_hover_text("As tab-separated text")
                .clicked()
        {
            ui.copy_text(as_text(&analysis.calibration));
        }
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
        if let Some(analysis) = &state.analysis
            && analysis.fitted
            && let Some(undetermined) = analysis.calibration.undetermined()
        {
            let colour = ui.visuals().warn_fg_color;
            ui.colored_label(
                colour,
                format!(
                    "⚠ {} samples for {} coefficients",
                    undetermined.samples, undetermined.coefficients
                ),
            )
            .on_hover_text(undetermined.to_string());
        }
    });
    let Some(analysis) = &state.analysis else {
        ui.weak("Nothing is fitted yet.");
        return;
    };
    let calibration = &analysis.calibration;
    let quality = &calibration.quality;
    let sets = SETS;
    egui::ScrollArea::both()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            egui::Grid::new("errors")
                .striped(true)
                .min_col_width(46.0)
                .spacing([10.0, 3.0])
                .show(ui, |ui| {
                    ui.label("");
                    for (_, title, explanation) in sets {
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
                        for (set, ..) in sets {
                            cells(ui, quality, set, at);
                            if let Some(factory) = &analysis.factory {
                                let rmse = set.factory_rmse(factory).get(at);
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

const SETS: [(ScoreSet, &str, &str); 3] = [
    (
        ScoreSet::Train,
        "Train",
        "On the training recordings themselves",
    ),
    (ScoreSet::Test, "Test", "On the test recordings"),
    (
        ScoreSet::LeftOut,
        "LOO-CV",
        "Leave-one-recording-out: each training recording scored by a fit to the others; with fewer than three, five contiguous \
         blocks of them take turns. The look-back's trigger stays the conventional calibration of all",
    ),
];

/// The table as tab-separated text.
fn as_text(calibration: &Calibration) -> String {
    let outputs = [
        (
            Trace::Conventional.label(),
            &calibration.quality.conventional,
        ),
        (Trace::Compensated.label(), &calibration.quality.compensated),
    ];
    let columns = || {
        SETS.iter()
            .flat_map(|set| outputs.iter().map(move |output| (set, output)))
    };
    let titles = columns().map(|((_, set, _), (output, _))| format!("{set} {output}"));
    let mut lines = vec![
        std::iter::once("RMSE".to_owned())
            .chain(titles)
            .collect::<Vec<_>>(),
    ];
    for (at, axis) in calibration.axes.iter().enumerate() {
        let values = columns().map(|((set, ..), (_, scores))| {
            let rmse = set.rmse(scores).and_then(|rmse| rmse.get(at));
            rmse.map_or_else(String::new, |rmse| significant(*rmse, 6))
        });
        let title = format!("{} [{}]", axis.symbol(), axis.unit());
        lines.push(std::iter::once(title).chain(values).collect());
    }
    let lines: Vec<String> = lines.iter().map(|cells| cells.join("\t")).collect();
    lines.join("\n")
}

fn cells(ui: &mut egui::Ui, quality: &Quality, set: ScoreSet, at: usize) {
    let value = |scores: &Scores| set.rmse(scores).and_then(|rmse| rmse.get(at).copied());
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::analysis::{Request, analyse};
    use crate::calibration::FitSettings;
    use crate::progress::Progress;
    use crate::recording::simulated;

    #[test]
    fn the_copied_table_holds_what_the_pane_shows() {
        let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
        let settings = FitSettings {
            decimation: 20,
            ..FitSettings::default()
        };
        let request = Request::fit(recordings, settings);
        let analysis = analyse(&request, &Progress::default()).unwrap();
        let text = as_text(&analysis.calibration);
        let rows: Vec<Vec<&str>> = text
            .lines()
            .map(|line| line.split('\t').collect())
            .collect();
        assert_eq!((rows.len(), rows[0].len()), (7, 7));
        assert_eq!((rows[0][4], rows[3][0]), ("Test Comp.", "Fz [N]"));
        let test = analysis
            .calibration
            .quality
            .compensated
            .test_rmse
            .as_ref()
            .unwrap();
        let shown: f64 = rows[3][4].parse().unwrap();
        assert!((shown - test[2]).abs() < 1e-5 * test[2]);
    }
}
