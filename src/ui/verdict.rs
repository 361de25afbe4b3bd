//! The strip under the menus: the changes of the errors by compensation, and the button that finds a better model.

use std::time::Duration;

use egui::{TextFormat, TextStyle};
use egui::{Ui, text::LayoutJob};

use crate::engine::{Action, Engine, SEARCH_MINUTES};
use crate::questions::loops::asked::{AskVerdict, LookAt};
use crate::questions::loops::{Look, Question, TableOf};
use crate::questions::metrology::{Verdict, VerdictFigure};
use crate::recording::Axis;
use crate::ui::command::{Command, Out};
use crate::ui::controls::Controls as _;
use crate::ui::numbers::significant;
use crate::ui::pane::Cx;
use crate::ui::{errors_pane, metrology_pane, palette};

/// Maximum number of axes whose changes are shown as numbers. For more axes only arrows fit.
const MANY_AXES: usize = 3;

pub fn verdict_strip(ui: &mut Ui, cx: &mut Cx<'_>) {
    let engine = cx.engine;
    ui.horizontal_wrapped(|ui| {
        if !engine.is_trying() {
            let find = egui::RichText::new("Find the best model").strong();
            let about = "Tries models and proposes the most accurate model; the workspace Models lists all tried models";
            if ui.press(find, about) {
                let limit = Duration::from_secs_f64(60.0 * SEARCH_MINUTES);
                cx.out.send(Action::FindBest(limit));
                cx.out.send(Command::ShowPane(super::models_pane::PANE));
            }
        }
        let Some(verdict) = verdict(engine) else { return };
        let about = "Change of each metrology figure by the compensation, from the uncompensated to the compensated load. A minus or an arrow down means an improvement. Click a figure to show its table";
        // The strip is paler while it is out of date. A further word could begin a new row, and all panes would jump.
        if engine.gesture.is_some() || !engine.lane::<AskVerdict>().is_current() {
            ui.multiply_opacity(0.6);
        }
        ui.weak("Compensation:").on_hover_text(about);
        for figure in &verdict.figures {
            one(ui, figure, &verdict.axes, cx.out);
        }
    });
    // While a slider moves, the strip keeps the errors for the previous settings.
    let of = TableOf::usual(&engine.project().recordings);
    let question = Question::Table(of);
    if engine.gesture.is_none()
        && engine.is_current()
        && let Some(look) = engine.look(None, question)
    {
        cx.ask::<AskVerdict>(LookAt(look));
    }
}

fn verdict(engine: &Engine) -> Option<Verdict> {
    let (_, analysis) = engine.exact()?;
    let Some(Look::Table(metrology)) = engine.lane::<AskVerdict>().answer() else { return None };
    let quality = &analysis.calibration.quality;
    let fits = metrology.axes == analysis.calibration.axes;
    fits.then(|| Verdict::of(quality, metrology))
}

/// Draws one metrology figure as a button that shows its name, and each axis in the colour of its change.
fn one(ui: &mut Ui, figure: &VerdictFigure, axes: &[Axis], out: &mut Out) {
    let visuals = ui.visuals().clone();
    let text = |color| TextFormat::simple(TextStyle::Body.resolve(ui.style()), color);
    let (mut job, mut spoken) = (LayoutJob::default(), figure.name.clone());
    job.append(&figure.name, 0.0, text(visuals.text_color()));
    let mut lines = vec![figure.about.clone()];
    for ((axis, change), values) in axes.iter().zip(figure.changes()).zip(&figure.of_axes) {
        let (Some(change), Some([before, after])) = (change, values) else { continue };
        let (color, sign, word) = match change {
            change if change < 0.0 => (palette::look_back(&visuals), "↓", "better"),
            change if change > 0.0 => (visuals.error_fg_color, "↑", "worse"),
            _ => (visuals.weak_text_color(), "=", "unchanged"),
        };
        let many = axes.len() > MANY_AXES;
        let change_text = if many { sign.to_owned() } else { format!(" {change:+.0} %") };
        let shown = format!("{}{change_text}", axis.symbol());
        job.append(&shown, 5.0, text(color));
        let [before, after] = [before, after].map(|value| significant(*value, 4));
        let line =
            format!("{} {before} → {after} {}: {change:+.0} %, {word}", axis.symbol(), axis.unit());
        spoken.push_str(&format!("; {line}"));
        lines.push(line);
    }
    if lines.len() == 1 {
        job.append("–", 5.0, text(visuals.weak_text_color()));
        lines.push(
            "This metrology figure is not available for these recordings; the pane Metrology gives the reason".to_owned(),
        );
    }
    let button = ui.add(egui::Button::new(job).small());
    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &spoken));
    if button.on_hover_text(lines.join("\n")).clicked() {
        let pane = if figure.is_rmse { errors_pane::PANE } else { metrology_pane::PANE };
        out.send(Command::ShowPane(pane));
    }
}
