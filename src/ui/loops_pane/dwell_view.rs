//! Draws the list of dwells, and for the chosen dwell the error and the fitted exponential.

use egui::Ui;

use super::LoopsPane;
use crate::{
    engine::Engine,
    questions::loops::{DwellCurve, DwellPlot, Inks, drifts},
    report::{
        Trace,
        figure::{Figure, Line, Scale},
    },
    shown::counted,
    ui::{command::Out, numbers::significant, plots::Zoom, table},
};

const LIST_HEIGHT: f32 = 170.0;

pub fn show(
    ui: &mut Ui,
    pane: &mut LoopsPane,
    engine: &Engine,
    picture: &DwellPlot,
    out: &mut Out,
) {
    // Skips a result that was computed for another minimum duration of dwells.
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
    let (zoom, shown) = (pane.zoom(), pane.shown);
    let figure = |inks: &Inks| drawing(picture, curve, shown, inks, zoom);
    pane.lay_out(ui, (None, &figure), out, |ui, pane, _| {
        figures(ui, picture, curve);
        ui.separator();
        list(ui, pane, picture);
    });
}

fn list(ui: &mut Ui, pane: &mut LoopsPane, picture: &DwellPlot) {
    let n = picture.dwells.len();
    let axis = picture.question.axis;
    let level = |at: usize| match picture.dwells[at].level {
        _ if picture.dwells[at].at_zero => "zero load".to_owned(),
        Some(level) => format!("{} {}", significant(level, 3), axis.unit()),
        None => "–".to_owned(),
    };
    ui.label(counted(n, "dwell"));
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
                    pane.show_all();
                }
            }
        });
}

fn figures(ui: &mut Ui, picture: &DwellPlot, curve: &DwellCurve) {
    let place = &picture.dwells[picture.chosen].place;
    ui.strong(&place.name);
    ui.weak(format!(
        "{} s to {} s",
        significant(place.from_secs, 5),
        significant(place.to_secs, 5)
    ));
    table::show(ui, &drifts(picture.question.axis, curve));
}

fn drawing<'a>(
    picture: &DwellPlot,
    curve: &'a DwellCurve,
    shown: [bool; 2],
    inks: &Inks,
    zoom: Zoom,
) -> Figure<'a> {
    let axis = picture.question.axis;
    let frame = zoom.unwrap_or(curve.whole);
    let lines = Trace::OUTPUTS.into_iter().zip(&curve.outputs);
    let lines = lines.zip([inks.conventional, inks.compensated]).zip(shown);
    Figure {
        title: axis.label_of("drift"),
        across: Scale::new("time since the start of the dwell [s]", frame.loads),
        up: Scale::new(axis.label_of("error"), frame.outputs),
        lines: lines
            .filter(|(_, is_shown)| *is_shown)
            .flat_map(|(((output, dwell), color), _)| {
                let name = output.label();
                [
                    Line {
                        opacity: 0.45,
                        width: 1.0,
                        ..Line::new(name, color, [&dwell.points[..]])
                    },
                    Line {
                        width: 2.2,
                        ..Line::new(format!("{name} fitted"), color, [&dwell.fit[..]])
                    },
                ]
            })
            .collect(),
        ..Figure::default()
    }
}
