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
        let runs = !running.is_empty() || refit.is_some();
        if runs {
            let cancel = ui.button("Cancel");
            let cancel = cancel.on_hover_text("Ends what runs; what is loaded stays as it is");
            if cancel.clicked() {
                out.push(Action::Cancel.into());
            }
        }
        for running in &running {
            let (title, fraction) = (&*running.title, running.progress.fraction());
            let time_left = running.time_left();
            busy(ui);
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
            if let Some(each) = analysis.preview_of {
                ui.colored_label(ui.visuals().warn_fg_color, preview_of(each))
                    .on_hover_text("What all samples give takes its place as soon as it is there");
                return;
            }
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

/// How often what tells of progress is drawn again: whatever is drawn, all of the window is.
pub(super) const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);

/// Draws that something runs, in a picture that changes no oftener than progress does.
pub(super) fn busy(ui: &mut egui::Ui) {
    const DOTS: usize = 8;
    let size = ui.spacing().interact_size.y;
    let (rect, response) = ui.allocate_exact_size(egui::Vec2::splat(size), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::new(egui::Role::ProgressIndicator));
    let steps = ui.input(|input| input.time) / PROGRESS_INTERVAL.as_secs_f64();
    let head = steps as usize % DOTS;
    let color = ui.visuals().strong_text_color();
    for dot in 0..DOTS {
        let angle = std::f32::consts::TAU * dot as f32 / DOTS as f32;
        let age = (head + DOTS - dot) % DOTS;
        let at = rect.center() + 0.32 * size * egui::Vec2::angled(angle);
        let shade = color.gamma_multiply(1.0 - age as f32 / DOTS as f32);
        ui.painter().circle_filled(at, 0.08 * size, shade);
    }
    ui.request_repaint_after(PROGRESS_INTERVAL);
}

/// That what is shown is a preview.
pub(super) fn preview_of(each: usize) -> String {
    format!("Preview: every {each}th sample")
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
