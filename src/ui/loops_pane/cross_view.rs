//! Any channel over any other.

use super::{LoopsPane, channel_name, channel_unit, for_print, rgb};
use crate::analysis::loops::{Channel, CrossPlot, clouds};
use crate::engine::Engine;
use crate::report::figure::{Figure, Line, Scale};
use crate::ui::command::Command;
use crate::ui::palette::look_back;
use crate::ui::plots::Zoom;

pub(super) fn show(
    ui: &mut egui::Ui,
    pane: &mut LoopsPane,
    engine: &Engine,
    picture: &CrossPlot,
    out: &mut Vec<Command>,
) {
    let gauges = &engine.project().recordings.layout().gauge_names;
    let zoom = *pane.zoom();
    let drawing = drawing(picture, gauges, &ui.visuals().clone(), zoom);
    let print = self::drawing(picture, gauges, &for_print(), zoom);
    pane.lay_out(ui, &drawing, &print, out, |ui, _, _| {
        ui.strong(format!(
            "{} over {}",
            drawing.up.label, drawing.across.label
        ));
        ui.weak(format!("{} samples", picture.n_samples));
        if [picture.question.across, picture.question.up].contains(&Channel::Time) {
            ui.weak(
                "Time is that on each recording's own clock, so recordings lie over each other.",
            );
        }
    });
}

fn drawing<'a>(
    picture: &'a CrossPlot,
    gauges: &[String],
    visuals: &egui::Visuals,
    zoom: Zoom,
) -> Figure<'a> {
    let frame = zoom.unwrap_or(picture.whole);
    let label = |channel: Channel| {
        let name = channel_name(channel, gauges);
        format!("{name} [{}]", channel_unit(channel))
    };
    let (across, up) = (label(picture.question.across), label(picture.question.up));
    let pieces = picture
        .drawn
        .strokes
        .iter()
        .map(|stroke| &stroke.points[..]);
    Figure {
        title: format!("{up} over {across}"),
        across: Scale::new(across, frame.loads),
        up: Scale::new(up, frame.outputs),
        clouds: clouds(&picture.drawn, rgb(look_back(visuals)), [0; 3]),
        lines: vec![Line {
            opacity: 0.75,
            width: 1.1,
            ..Line::new("", rgb(look_back(visuals)), pieces)
        }],
        ..Figure::default()
    }
}
