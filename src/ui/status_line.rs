//! What runs, how far it is, and how long the last refit took.

use std::time::Duration;

use crate::engine::{Action, Engine};
use crate::ui::command::Command;
use crate::ui::numbers::{duration, significant};

/// Work that ends sooner is not worth a word.
const WORTH_SAYING: Duration = Duration::from_millis(100);

/// Draws the line at the foot of the window.
pub fn status_line(ui: &mut egui::Ui, engine: &Engine, out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let running = engine.running();
        let refit = engine.refit();
        let refit = refit.filter(|refit| refit.since.elapsed() > WORTH_SAYING);
        // First in the line, so that it stays in its place while bars come and go.
        let busy = !running.is_empty() || refit.is_some();
        if busy {
            let cancel = ui.button("Cancel");
            let cancel = cancel.on_hover_text("Ends what runs; what is loaded stays as it is");
            if cancel.clicked() {
                out.push(Action::Cancel.into());
            }
        }
        for running in &running {
            let (title, fraction) = (&*running.title, running.progress.fraction());
            let time_left = running.time_left();
            ui.spinner();
            ui.label(title);
            if let Some(fraction) = fraction {
                bar(ui, title, fraction);
            }
            if let Some(time_left) = time_left {
                ui.weak(format!("{} left", duration(time_left)));
            }
        }
        if let Some(refit) = refit {
            ui.label(&refit.title);
            let fraction = refit.progress.fraction();
            bar(ui, &refit.title, fraction.unwrap_or(0.0));
        }
        if !engine.notices.is_empty() {
            let all = match engine.notices.len() {
                1 => "1 notice".to_owned(),
                n => format!("{n} notices"),
            };
            let all = ui.small_button(all);
            if all.on_hover_text("What was said since they were dismissed").clicked() {
                out.push(Command::ToggleNotices);
            }
        }
        if let Some(problem) = engine.problem() {
            ui.colored_label(ui.visuals().error_fg_color, problem);
        } else if let Some(analysis) = engine.analysis() {
            let quality = &analysis.calibration.quality;
            let condition = quality
                .condition
                .map_or_else(|| "none".to_owned(), |value| significant(value, 3));
            let verb = if analysis.fitted { "Refit" } else { "Applied" };
            ui.label(format!(
                "{verb} in {} ms · {} training and {} test samples · rank {} of {} · condition {condition}",
                significant(1e3 * analysis.elapsed.as_secs_f64(), 3),
                quality.n_train,
                quality.n_test,
                quality.rank,
                analysis.calibration.feature_names().len(),
            ))
            .on_hover_text(
                "Rank: how many columns of the compensated fit are independent; condition: how far its gauges and \
                 their past are from being interchangeable (1 is best)",
            );
        }
    });
}

fn bar(ui: &mut egui::Ui, what: &str, fraction: f32) {
    let bar = egui::ProgressBar::new(fraction)
        .desired_width(120.0)
        .show_percentage();
    let response = ui.add(bar);
    let label = format!("{what}: {:.0} %", 100.0 * fraction);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, label.clone())
    });
}
