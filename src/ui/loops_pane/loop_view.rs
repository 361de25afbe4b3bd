//! Draws the loops of one axis, the width of a loop against the load, and the table of loop figures.

use egui::Ui;

use super::{LoopsPane, cards, linked};
use crate::{
    engine::Engine,
    questions::{
        loops::{FiguresOf, Inks, LoopPlot, LoopView, Span, Up, lag_in_words, loop_figures},
        metrology::Reason,
    },
    report::figure::Figure,
    shown::counted,
    ui::{
        command::Out,
        controls::{Controls as _, place},
        numbers::significant,
        plots, table,
        time_view::TimeView,
    },
};

const WIDTHS_HEIGHT: f32 = 150.0;

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
    let mut view = LoopView::of_all(picture, gauge, pane.figures_of);
    view.shown.retain(|curve| curve.output.is_none_or(|output| pane.is_shown(output)));
    let zoom = pane.zoom();
    let figure = |inks: &Inks| view.figure(inks, zoom);
    let shared = linked::Shared::of(picture, engine);
    let size = pane.plot_size(ui);
    let has_strip = pane.has_figures && ui.available_height() - size.y >= linked::STRIP_HEIGHT;
    let zoom = &mut pane.zooms[super::Mode::Loops as usize];
    let drawn = plots::plot(ui, ("Loop", Some(view.title())), size.y, figure, zoom, out);
    let hovered = match &shared {
        Some(shared) if has_strip => linked::strip(ui, shared, time),
        _ => None,
    };
    if pane.has_figures {
        let beside = cards::show(ui, engine, &view);
        let missing = shared.as_ref().and_then(|shared| shared.missing());
        let button = place(ui, beside, |ui| {
            let label = format!("Figures of {}…", picture.question.axis.symbol());
            ui.menu_of_fields(egui::Button::new(label), |ui| {
                ui.reset_style(); // texts and plots, not menu items
                ui.set_width(super::FIGURES_WIDTH);
                details(ui, pane, &view, missing, out);
            })
        });
        button.on_hover_text("Widths and area of the loop, its width over the load and over the rate, and the removal of the time lag");
    }
    if let Some(shared) = shared
        && let Some(samples) = linked::link(ui, &drawn, &view, &shared, time, hovered)
    {
        // After a click on a cycle, the traces show only this cycle, and the loops show only what is visible in the traces.
        pane.span = Span::Visible;
        time.show_samples(samples);
    }
}

/// Draws the choice of the loop that the figures describe, and its figures.
fn details(
    ui: &mut Ui,
    pane: &mut LoopsPane,
    view: &LoopView<'_>,
    reason: Option<String>,
    out: &mut Out,
) {
    let picture = view.plot;
    let has_mean = picture.curves.iter().any(|curve| curve.mean.is_ok());
    ui.horizontal(|ui| {
        for (of, label, explanation) in [
            (
                FiguresOf::Mean,
                "Mean loop",
                "Mean of the cycles that cover at least 80 % of the range of the largest cycle",
            ),
            (
                FiguresOf::Largest,
                "Largest cycle",
                "Shows the cycle whose rising and falling branches have the largest common range of loads",
            ),
        ] {
            let can = has_mean || of == FiguresOf::Largest;
            let button = egui::Button::selectable(of == view.figures_of, label);
            let button = ui.add_enabled(can, button).on_hover_text(explanation);
            if button.clicked() {
                pane.figures_of = of;
            }
        }
    });
    if let Some(Err(reason @ Reason::FewCycles { .. })) =
        picture.curves.first().map(|curve| &curve.mean)
    {
        ui.weak(format!("No mean loop: {reason}."));
    }
    counts(ui, view);
    if let Some(reason) = reason {
        ui.weak(reason);
    }
    lag(ui, pane, picture);
    figures(ui, view);
    if !view.found().is_empty() {
        whole_plot(ui, "loop widths", |inks| view.widths(inks), out);
        by_rate(ui, view, out);
    }
}

fn lag(ui: &mut Ui, pane: &mut LoopsPane, picture: &LoopPlot) {
    let words = lag_in_words(&picture.lag);
    if picture.lag.is_worth_removing() && !pane.lag_removed {
        ui.warn(words)
    } else {
        ui.weak(words)
    };
    let switch = egui::Checkbox::new(&mut pane.lag_removed, "Lag removed");
    ui.add_enabled(picture.lag.is_removable() || picture.question.lag_removed, switch).on_hover_text(
        "Delays the reference load by the delay or low-pass of the gauges. The width that remains is hysteresis, without the effect of an amplifier's filter",
    );
}

/// Draws the width of the load cycles against the rate at which the load changes. A width that grows with the rate shows a
/// lag; a constant width shows hysteresis.
fn by_rate(ui: &mut Ui, view: &LoopView<'_>, out: &mut Out) {
    const ABOUT: &str = "Width of the full cycles against the mean rate at which the load changes. A width proportional to the rate shows a lag, a constant width shows hysteresis";
    let figure = |inks: &Inks| view.widths_by_rate(inks);
    let text = if figure(&Inks::PRINT).is_some() {
        whole_plot(ui, "widths by rate", |inks| figure(inks).unwrap_or_default(), out);
        "Width against rate"
    } else {
        "The load changes at about the same rate in all full cycles, so the widths of the cycles do not distinguish lag from hysteresis."
    };
    ui.weak(text).on_hover_text(ABOUT);
}

fn whole_plot<'a>(ui: &mut Ui, id: &str, figure: impl Fn(&Inks) -> Figure<'a>, out: &mut Out) {
    plots::plot(ui, (id, None), WIDTHS_HEIGHT, figure, &mut None, out);
}

fn counts(ui: &mut Ui, view: &LoopView<'_>) {
    let picture = view.plot;
    let unit = picture.question.axis.unit();
    let of = view.found().first().map_or_else(String::new, |(_, figures)| {
        let basis = figures.basis;
        let what = match view.figures_of {
            FiguresOf::Mean => format!("Mean of {} cycles", basis.n_cycles),
            FiguresOf::Largest => "One cycle".to_owned(),
        };
        let share = significant(100.0 * basis.range_share, 2);
        format!("{what}, which covers {share} % of the range of the loads\n")
    });
    let words = format!(
        "{of}{} cycles, {} full · {} samples of {}",
        picture.cycles.len(),
        picture.n_full_cycles,
        picture.n_samples,
        counted(picture.parts.len(), "recording"),
    );
    ui.weak(words).on_hover_text(format!(
            "Reversal threshold {} {unit}; full scale {} {unit}. Thin lines: all branches, falling ones paler. Thick lines: the loop that the figures describe, its falling branch dashed",
            significant(picture.reversal_threshold, 3),
            significant(picture.full_scale, 4),
        ));
}

fn figures(ui: &mut Ui, view: &LoopView<'_>) {
    let mut reasons: Vec<&Reason> = Vec::new();
    for curve in &view.shown {
        if let Err(reason) = view.figures(curve)
            && !reasons.contains(&reason)
        {
            reasons.push(reason);
        }
    }
    for reason in reasons {
        ui.label(reason.to_string());
    }
    if view.found().is_empty() {
        return;
    }
    let figures = loop_figures(view);
    egui::ScrollArea::horizontal().id_salt("loop figures").show(ui, |ui| table::show(ui, &figures));
    ui.copies("figures", || figures.tab_separated());
    ui.add_space(4.0);
}
