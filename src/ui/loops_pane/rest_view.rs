//! Where the load rests: the list, the chosen one's curve, its fitted exponential.

use egui::RichText;

use super::{LoopsPane, for_print, rgb, trace_of};
use crate::analysis::loops::{Output, RestCurve, RestPicture};
use crate::evaluation::holds::Drift;
use crate::report::figure::{Figure, Line, Scale};
use crate::ui::command::Command;
use crate::ui::numbers::significant;
use crate::ui::plots::Zoom;

/// Height of the list of rests.
const LIST_HEIGHT: f32 = 170.0;

pub(super) fn show(
    ui: &mut egui::Ui,
    pane: &mut LoopsPane,
    picture: &RestPicture,
    out: &mut Vec<Command>,
) {
    // An answer to another time than the one that stands above is no answer to look at.
    if picture.question.hold_secs != pane.hold_secs {
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
    let shown: Vec<Output> = (Output::ALL.into_iter())
        .filter(|output| pane.is_shown(*output))
        .collect();
    let zoom = *pane.zoom();
    let drawing = drawing(picture, curve, &shown, &ui.visuals().clone(), zoom);
    let print = self::drawing(picture, curve, &shown, &for_print(), zoom);
    pane.lay_out(ui, &drawing, &print, out, |ui, pane, _| {
        figures(ui, picture, curve);
        ui.separator();
        list(ui, pane, picture);
    });
}

fn list(ui: &mut egui::Ui, pane: &mut LoopsPane, picture: &RestPicture) {
    let n = picture.rests.len();
    let axis = picture.question.axis;
    let level = |at: usize| match picture.levels[at] {
        _ if picture.rests[at].at_zero => "at zero".to_owned(),
        Some(level) => format!("{} {}", significant(level, 3), axis.unit()),
        None => "–".to_owned(),
    };
    ui.horizontal(|ui| {
        ui.label(format!("{n} rest{}", if n == 1 { "" } else { "s" }));
        let copy = ui.small_button("Copy list");
        if copy.on_hover_text("As tab-separated text").clicked() {
            let rows = picture.rests.iter().enumerate().map(|(at, rest)| {
                let place = &rest.place;
                format!(
                    "{}\t{}\t{}\t{}",
                    place.name.replace(['\t', '\n'], " "),
                    place.from_secs,
                    place.to_secs,
                    level(at)
                )
            });
            let titles = "recording\tfrom [s]\tto [s]\tlevel".to_owned();
            let lines: Vec<String> = std::iter::once(titles).chain(rows).collect();
            ui.copy_text(lines.join("\n"));
        }
    });
    egui::ScrollArea::vertical()
        .id_salt("rests")
        .max_height(LIST_HEIGHT)
        .auto_shrink([false, true])
        .show_rows(ui, 18.0, n, |ui, rows| {
            for at in rows {
                let place = &picture.rests[at].place;
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

fn figures(ui: &mut egui::Ui, picture: &RestPicture, curve: &RestCurve) {
    let unit = picture.question.axis.unit();
    let place = &picture.rests[picture.chosen].place;
    ui.strong(&place.name);
    ui.weak(format!(
        "{} s to {} s",
        significant(place.from_secs, 5),
        significant(place.to_secs, 5)
    ));
    let heads = Output::ALL.map(|output| trace_of(output).label());
    let mut lines = vec![format!("drift\t{}", heads.join("\t"))];
    egui::Grid::new("drift").striped(true).spacing([12.0, 3.0]).show(ui, |ui| {
        ui.label("");
        for output in Output::ALL {
            let trace = trace_of(output);
            ui.label(RichText::new(trace.label()).color(trace.color(ui.visuals())));
        }
        ui.end_row();
        type Said = fn(&Drift) -> String;
        let rows: [(&str, &str, Said); 3] = [
            (
                "Drift",
                "Change of output − load from the beginning of the rest to its end, on the fitted exponential",
                |drift| significant(drift.size, 3),
            ),
            ("τ [s]", "Time constant of a + b (1 − exp(−t / τ)); a dash where the data show none", |drift| {
                drift.tau_secs().map_or_else(|_| "–".to_owned(), |tau| significant(tau, 3))
            }),
            ("Noise", "Root mean square of what the fit leaves over", |drift| {
                significant(drift.noise, 3)
            }),
        ];
        for (at, (title, explanation, pick)) in rows.into_iter().enumerate() {
            let title = if at == 1 { title.to_owned() } else { format!("{title} [{unit}]") };
            let mut line = title.clone();
            ui.label(title).on_hover_text(explanation);
            for output in &curve.outputs {
                let said = output.drift.as_ref().map_or_else(|| "–".to_owned(), pick);
                line = format!("{line}\t{said}");
                ui.label(said);
            }
            lines.push(line);
            ui.end_row();
        }
    });
    let copy = ui.button("Copy figures");
    if copy.on_hover_text("As tab-separated text").clicked() {
        ui.copy_text(lines.join("\n"));
    }
    for (output, own) in Output::ALL.into_iter().zip(&curve.outputs) {
        if let Some(Err(reason)) = own.drift.as_ref().map(Drift::tau_secs) {
            ui.weak(format!("{} {reason}", trace_of(output).label()));
        }
    }
}

fn drawing<'a>(
    picture: &RestPicture,
    curve: &'a RestCurve,
    shown: &[Output],
    visuals: &egui::Visuals,
    zoom: Zoom,
) -> Figure<'a> {
    let axis = picture.question.axis;
    let frame = zoom.unwrap_or(curve.whole);
    let lines = Output::ALL.into_iter().zip(&curve.outputs);
    let lines = lines.filter(|(output, _)| shown.contains(output));
    Figure {
        title: format!("{} drift [{}]", axis.symbol(), axis.unit()),
        across: Scale::new("time at rest [s]", frame.loads),
        up: Scale::new(
            format!("{} error [{}]", axis.symbol(), axis.unit()),
            frame.outputs,
        ),
        lines: lines
            .flat_map(|(output, own)| {
                let color = rgb(trace_of(output).color(visuals));
                let name = trace_of(output).label();
                [
                    Line {
                        opacity: 0.45,
                        width: 1.0,
                        ..Line::new(name, color, [&own.points[..]])
                    },
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
