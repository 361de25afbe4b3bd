//! Draws the list of dwells, the error of the chosen dwell, and its fitted exponential.

use super::{LoopsPane, for_print, rgb};
use crate::engine::Engine;
use crate::questions::loops::{DwellCurve, DwellPlot, drifts};
use crate::report::figure::{Figure, Line, Scale};
use crate::report::{Cell, Column, Table, Trace};
use crate::ui::command::Command;
use crate::ui::controls::Controls as _;
use crate::ui::numbers::significant;
use crate::ui::plots::Zoom;
use crate::ui::table;

const LIST_HEIGHT: f32 = 170.0;

pub(super) fn show(
    ui: &mut egui::Ui,
    pane: &mut LoopsPane,
    engine: &Engine,
    picture: &DwellPlot,
    out: &mut Vec<Command>,
) {
    // Skips an answer that was computed for another shortest dwell than the present one.
    if picture.hold_secs != engine.project().measuring.hold_secs {
        return;
    }
    let curve = match &picture.curve {
        Ok(curve) => curve,
        Err(reason) => {
            ui.label(reason.to_string());
            list(ui, pane, picture);
            return;
        }
    };
    let shown: Vec<Trace> =
        (Trace::OUTPUTS.into_iter()).filter(|output| pane.is_shown(*output)).collect();
    let zoom = *pane.zoom();
    let drawing = drawing(picture, curve, &shown, &ui.visuals().clone(), zoom);
    let print = self::drawing(picture, curve, &shown, &for_print(), zoom);
    pane.lay_out(ui, &drawing, &print, out, |ui, pane, _| {
        figures(ui, picture, curve);
        ui.separator();
        list(ui, pane, picture);
    });
}

fn list(ui: &mut egui::Ui, pane: &mut LoopsPane, picture: &DwellPlot) {
    let n = picture.dwells.len();
    let axis = picture.question.axis;
    let level = |at: usize| match picture.dwells[at].level {
        _ if picture.dwells[at].at_zero => "at zero".to_owned(),
        Some(level) => format!("{} {}", significant(level, 3), axis.unit()),
        None => "–".to_owned(),
    };
    ui.horizontal(|ui| {
        ui.label(format!("{n} dwell{}", if n == 1 { "" } else { "s" }));
        if ui.press_small("Copy list", "Copies the list as tab-separated text") {
            let place = |at: &usize| &picture.dwells[*at].place;
            let list = Table::of(0..picture.dwells.len())
                .words("recording", |at| &place(at).name)
                .column(Column::words("from [s]"), |at| Cell::digits(Some(place(at).from_secs), 5))
                .column(Column::words("to [s]"), |at| Cell::digits(Some(place(at).to_secs), 5))
                .words("level", |at| level(*at))
                .table("", "");
            ui.copy_text(list.tab_separated());
        }
    });
    egui::ScrollArea::vertical()
        .id_salt("dwells")
        .max_height(LIST_HEIGHT)
        .auto_shrink([false, true])
        .show_rows(ui, 18.0, n, |ui, rows| {
            for at in rows {
                let place = &picture.dwells[at].place;
                let secs = place.to_secs - place.from_secs;
                let words = format!("{}, {} s: {}", level(at), significant(secs, 3), place.name);
                let row = egui::Button::selectable(at == picture.chosen, &*words).truncate();
                let row = ui.add(row).on_hover_text(&words);
                if row.clicked() {
                    pane.rest = Some(at);
                    *pane.zoom_mut() = None;
                }
            }
        });
}

fn figures(ui: &mut egui::Ui, picture: &DwellPlot, curve: &DwellCurve) {
    let place = &picture.dwells[picture.chosen].place;
    ui.strong(&place.name);
    ui.weak(format!(
        "{} s to {} s",
        significant(place.from_secs, 5),
        significant(place.to_secs, 5)
    ));
    let figures = drifts(picture.question.axis, curve);
    table::show(ui, &figures);
    if ui.press("Copy figures", "Copies the figures as tab-separated text") {
        ui.copy_text(figures.tab_separated());
    }
}

fn drawing<'a>(
    picture: &DwellPlot,
    curve: &'a DwellCurve,
    shown: &[Trace],
    visuals: &egui::Visuals,
    zoom: Zoom,
) -> Figure<'a> {
    let axis = picture.question.axis;
    let frame = zoom.unwrap_or(curve.whole);
    let lines = Trace::OUTPUTS.into_iter().zip(&curve.outputs);
    let lines = lines.filter(|(output, _)| shown.contains(output));
    Figure {
        title: axis.label_of("drift"),
        across: Scale::new("dwell time [s]", frame.loads),
        up: Scale::new(axis.label_of("error"), frame.outputs),
        lines: lines
            .flat_map(|(output, own)| {
                let color = rgb(output.color(visuals));
                let name = output.label();
                [
                    Line { opacity: 0.45, width: 1.0, ..Line::new(name, color, [&own.points[..]]) },
                    Line {
                        width: 2.2,
                        ..Line::new(format!("{name} fitted"), color, [&own.fit[..]])
                    },
                ]
            })
            .collect(),
        ..Figure::default()
    }
}
