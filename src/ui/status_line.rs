//! The status line: running work with its progress, and the time of the last refit.

use std::time::Duration;

use egui::Ui;

use crate::{
    engine::{Action, Engine, query::Background as _},
    questions::errors::query::Analyse,
    recording::Role,
    shown::counted,
    ui::{
        command::{Command, Out},
        controls::Controls as _,
        numbers::{duration, significant},
    },
};

/// Time after which a running refit is shown in the status line.
const WORTH_SAYING: Duration = Duration::from_millis(100);

pub fn status_line(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    ui.horizontal(|ui| {
        let running = engine.running();
        let refit =
            engine.lane::<Analyse>().running().filter(|refit| refit.since.elapsed() > WORTH_SAYING);
        // The buttons come first, so that progress bars do not move them.
        if !engine.notices.is_empty() {
            let all = counted(engine.notices.len(), "notice");
            if ui.press_small(all, "Lists all notices that were not dismissed") {
                out.send(Command::ToggleNotices);
            }
        }
        let runs = !running.is_empty() || refit.is_some();
        if runs
            && ui.press(
                "Cancel",
                "Cancels the running work; recordings that are already loaded stay",
            )
        {
            out.send(Action::Cancel);
        }
        for running in &running {
            busy(ui);
            ui.label(&running.title);
            if let Some(fraction) = running.progress.fraction() {
                bar(ui, &running.title, fraction);
            }
            if let Some(time_left) = running.time_left() {
                ui.weak(format!("{} left", duration(time_left)));
            }
        }
        if let Some(refit) = refit {
            ui.label(&refit.title);
            bar(ui, &refit.title, refit.progress.fraction().unwrap_or(0.0));
        }
        if engine.entries().is_empty() {
            ui.weak("No recordings");
        } else if let Some(problem) = engine.problem() {
            ui.fail(problem);
        } else if let Some(analysis) = engine.analysis() {
            let quality = &analysis.calibration.quality;
            if let Some(each) = analysis.preview_of {
                ui.warn(preview_of(each)).on_hover_text(
                    "The result of all samples replaces this one as soon as it is computed",
                );
                return;
            }
            ui.label(if analysis.fitted { "Up to date" } else { "Applied" }).on_hover_text(
                format!("Computed in {} ms", significant(1e3 * analysis.elapsed.as_secs_f64(), 3)),
            );
            let n_of =
                |role: Role| engine.entries().iter().filter(|entry| entry.role == role).count();
            let mut words = format!(
                "{}: {} train, {} test",
                counted(engine.entries().len(), "recording"),
                n_of(Role::Train),
                n_of(Role::Test),
            );
            match n_of(Role::Off) {
                0 => {}
                n => words += &format!(", {n} off"),
            }
            if let Some(how) = &quality.cross_validation {
                words += &format!(" · CV {how}");
            }
            ui.weak(words);
        }
    });
}

const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);
/// Maximum share of the processor time for redraws that show progress. Without a graphics card a frame takes long.
const DRAWING_SHARE: f32 = 0.05;
/// Maximum time between two redraws that show progress (s).
const LONGEST_INTERVAL: f32 = 1.0;

/// Returns the time until the next redraw that shows progress. Every redraw draws the whole window.
pub fn progress_interval(context: &egui::Context) -> Duration {
    let frame_secs: f32 = context.data(|data| data.get_temp(frame_secs()).unwrap_or(0.0));
    let secs = (frame_secs / DRAWING_SHARE).clamp(0.0, LONGEST_INTERVAL);
    PROGRESS_INTERVAL.max(Duration::from_secs_f32(secs))
}

pub fn note_frame(context: &egui::Context, secs: f32) {
    context.data_mut(|data| data.insert_temp(frame_secs(), secs));
}

fn frame_secs() -> egui::Id {
    egui::Id::unique("how long a frame takes")
}

/// Draws a sign of running work.
pub fn busy(ui: &mut Ui) {
    let sign = ui.weak("working…");
    sign.widget_info(|| egui::WidgetInfo::new(egui::Role::ProgressIndicator));
}

fn preview_of(each: usize) -> String {
    format!("Preview from every {each}th sample")
}

fn bar(ui: &mut Ui, what: &str, fraction: f32) {
    let bar = egui::ProgressBar::new(fraction).desired_width(120.0).show_percentage();
    ui.add(bar).widget_info(|| {
        let label = format!("{what}: {:.0} %", 100.0 * fraction);
        egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, label)
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longer_a_frame_takes_the_fewer_tell_of_progress() {
        let context = egui::Context::default();
        let secs = |frame_secs: Option<f32>| {
            frame_secs.into_iter().for_each(|secs| note_frame(&context, secs));
            progress_interval(&context).as_secs_f32()
        };
        let found = [None, Some(0.002), Some(0.02), Some(3.0)].map(secs);
        let expected = [0.1, 0.1, 0.4, 1.0];
        let near = |(found, expected): (&f32, &f32)| (found - expected).abs() < 1e-3;
        assert!(found.iter().zip(&expected).all(near), "{found:?}");
    }
}
