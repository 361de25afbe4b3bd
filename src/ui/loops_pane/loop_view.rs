//! Draws the loops of one axis, and below them the load over time and the figures of the loop.

use egui::{Label, RichText, Ui};

use super::{LoopsPane, Mode, cards, linked};
use crate::{
    engine::Engine,
    questions::loops::{Inks, LoopPlot, LoopView, Span, Up},
    shown::counted,
    ui::{command::Out, controls::place, numbers::significant, plots, time_view::TimeView},
};

pub fn show(
    ui: &mut Ui,
    pane: &mut LoopsPane,
    engine: &Engine,
    picture: &LoopPlot,
    time: &mut TimeView,
    out: &mut Out,
) {
    let recordings = &engine.project().recordings;
    let gauge = match picture.question.up {
        Up::Gauge(gauge) => {
            let names = &recordings.layout().gauge_names;
            let name = names.get(gauge).map_or("gauge", |name| name);
            (name, recordings.gauge_unit(gauge))
        }
        Up::Load | Up::Error => ("", ""),
    };
    let mut view = LoopView::of_all(picture, gauge);
    view.shown.retain(|curve| curve.output.is_none_or(|output| pane.is_shown(output)));
    let zoom = pane.zoom();
    let figure = |inks: &Inks| view.figure(inks, zoom);
    let shared = linked::Shared::of(picture, engine);
    let size = pane.plot_size(ui);
    let has_strip = pane.has_figures && ui.available_height() - size.y >= linked::STRIP_HEIGHT;
    let zoom = &mut pane.zooms[Mode::Loops as usize];
    let drawn = plots::plot(ui, ("Loop", Some(view.title())), size.y, figure, zoom, out);
    let hovered = match &shared {
        Some(shared) if has_strip => linked::strip(ui, shared, time),
        _ => None,
    };
    if pane.has_figures {
        let beside = cards::show(ui, engine, &view);
        let text = format!(
            "{} cycles, {} full, {} samples of {}",
            picture.cycles.len(),
            picture.n_full_cycles,
            picture.n_samples,
            counted(picture.parts.len(), "recording"),
        );
        let unit = picture.question.axis.unit();
        let about = format!(
            "Reversal threshold {} {unit}; full scale {} {unit}. Thin lines: all branches, falling ones paler. Thick lines: the loop that the figures describe, its falling branch dashed",
            significant(picture.reversal_threshold, 3),
            significant(picture.full_scale, 4),
        );
        let text = Label::new(RichText::new(text).weak().size(12.0)).wrap();
        place(ui, beside, |ui| ui.add(text)).on_hover_text(about);
    }
    if let Some(shared) = shared
        && let Some(samples) = linked::link(ui, &drawn, &view, &shared, time, hovered)
    {
        // After a click on a cycle, the traces show only this cycle, and the loops show only what is visible in the traces.
        pane.span = Span::Visible;
        time.show_samples(samples);
    }
}
