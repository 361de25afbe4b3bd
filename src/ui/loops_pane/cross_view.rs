//! Draws the cross-plot of two channels.

use super::{LoopsPane, channel_name, channel_unit};
use crate::{
    engine::Engine,
    questions::loops::{Channel, CrossPlot, Inks},
    ui::{command::Out, numbers::significant},
};

pub fn show(
    ui: &mut egui::Ui,
    pane: &mut LoopsPane,
    engine: &Engine,
    picture: &CrossPlot,
    out: &mut Out,
) {
    let label = |channel: Channel| {
        let name = channel_name(channel, engine);
        format!("{name} [{}]", channel_unit(channel, engine))
    };
    let question = &picture.question;
    let labels = [question.across, question.up].map(label);
    let zoom = pane.zoom();
    let figure = |inks: &Inks| picture.figure(labels.clone(), inks, zoom);
    pane.lay_out(ui, (None, &figure), out, |ui, _, _| {
        let [across, up] = &labels;
        ui.strong(format!("{up} against {across}"));
        ui.weak(format!("{} samples", picture.n_samples));
        if [picture.question.across, picture.question.up].contains(&Channel::Time) {
            ui.weak(
                "Each recording has its own clock, so the times of different recordings overlap.",
            );
        } else if let Some([slope, correlation]) = picture.trend {
            let units = [question.up, question.across].map(|of| channel_unit(of, engine));
            let [slope, correlation] = [slope, correlation].map(|value| significant(value, 4));
            ui.label(format!("Slope {slope} {}/{}", units[0], units[1]));
            ui.label(format!("Correlation {correlation}"));
        }
    });
}
