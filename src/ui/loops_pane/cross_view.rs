//! Draws any channel over any other channel.

use super::{LoopsPane, channel_name, channel_unit};
use crate::engine::Engine;
use crate::questions::loops::{Channel, CrossPlot, Inks};
use crate::ui::command::Command;
use crate::ui::palette::inks;

pub(super) fn show(
    ui: &mut egui::Ui,
    pane: &mut LoopsPane,
    engine: &Engine,
    picture: &CrossPlot,
    out: &mut Vec<Command>,
) {
    let label = |channel: Channel| {
        let name = channel_name(channel, engine);
        format!("{name} [{}]", channel_unit(channel, engine))
    };
    let question = &picture.question;
    let labels = [question.across, question.up].map(label);
    let zoom = *pane.zoom();
    let drawing = picture.figure(labels.clone(), &inks(ui.visuals()), zoom);
    let print = picture.figure(labels, &Inks::PRINT, zoom);
    pane.lay_out(ui, &drawing, &print, out, |ui, _, _| {
        ui.strong(format!("{} against {}", drawing.up.label, drawing.across.label));
        ui.weak(format!("{} samples", picture.n_samples));
        if [picture.question.across, picture.question.up].contains(&Channel::Time) {
            ui.weak("Each recording's time starts on its own clock, so recordings overlap.");
        }
    });
}
