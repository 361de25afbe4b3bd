//! The calibration matrices with their features named, and their way out.

use egui::RichText;

use crate::app::{AppState, Command, Existing};
use crate::calibration::LinearMap;
use crate::recording::Axis;
use crate::ui::numbers::significant;
use crate::ui::palette::Trace;
use crate::ui::shell::Fields;

/// Draws the matrices and the export row.
pub fn calibration_pane(
    ui: &mut egui::Ui,
    state: &AppState,
    fields: &mut Fields,
    out: &mut Vec<Command>,
) {
    ui.horizontal_wrapped(|ui| {
        if let Some(analysis) = &state.analysis {
            let calibration = &analysis.calibration;
            if calibration.simulated {
                ui.colored_label(ui.visuals().warn_fg_color, "of the simulated sensor");
            }
            ui.weak(calibration.describe());
        }
    });
    export_row(ui, state, fields, out);
    let Some(analysis) = &state.analysis else {
        return;
    };
    let calibration = &analysis.calibration;
    egui::ScrollArea::both()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            if let Some(learned) = &calibration.learned {
                let linear = match calibration.compensated {
                    Some(_) => "matrix × features + ",
                    None => "",
                };
                let text = format!("Comp. = {linear}{}", learned.describe());
                ui.colored_label(Trace::Compensated.color(ui.visuals()), text)
                    .on_hover_text("Too much to show as a matrix; the .json file has all of it");
                ui.add_space(6.0);
            }
            let compensated = calibration.compensated.as_ref();
            let maps = compensated.map(|map| (Trace::Compensated, map));
            let conventional = (Trace::Conventional, &calibration.conventional);
            for (trace, map) in maps.into_iter().chain([conventional]) {
                ui.horizontal(|ui| {
                    ui.label(
                        RichText::new(format!("{} = matrix × features", trace.label()))
                            .color(trace.color(ui.visuals())),
                    )
                    .on_hover_text(trace.explanation());
                    let copy = ui.small_button(format!("Copy {}", trace.label()));
                    if copy
                        .on_hover_text("The matrix as tab-separated text")
                        .clicked()
                    {
                        ui.copy_text(as_text(map, &calibration.axes));
                    }
                });
                matrix(ui, trace.label(), map, &calibration.axes);
                ui.add_space(6.0);
            }
        });
}

fn export_row(ui: &mut egui::Ui, state: &AppState, fields: &mut Fields, out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let label = ui.label("Export to");
        let buttons = 118.0;
        let field = egui::TextEdit::singleline(&mut fields.export)
            .hint_text("path ending in .json, .h, .py, …")
            .desired_width((ui.available_width() - buttons).clamp(40.0, 400.0));
        let field = ui.add(field).labelled_by(label.id);
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        ui.add_enabled_ui(state.analysis.is_some(), |ui| {
            let export = ui.button("Export").on_hover_text(
                ".json holds everything and can be opened here again; .csv the matrices; .h, .rs and .py are code that runs; .yaml, \
                 .npz, .mat, .cal and .onnx hold what each can carry",
            );
            let path = fields.export.trim();
            if (export.clicked() || entered) && !path.is_empty() {
                out.push(Command::Export(path.into(), Existing::Ask));
            }
            if ui.button("…").on_hover_text("Choose a file").clicked() {
                out.push(Command::ChooseExport);
            }
        });
    });
}

/// A matrix with its features and axes as tab-separated text, every digit of it.
fn as_text(map: &LinearMap, axes: &[Axis]) -> String {
    let mut lines = vec![format!("\t{}", map.features.join("\t"))];
    for (axis, row) in axes.iter().zip(&map.matrix) {
        let values: Vec<String> = row.iter().map(f64::to_string).collect();
        lines.push(format!(
            "{} [{}]\t{}",
            axis.symbol(),
            axis.unit(),
            values.join("\t")
        ));
    }
    lines.join("\n")
}

fn matrix(ui: &mut egui::Ui, name: &str, map: &LinearMap, axes: &[Axis]) {
    egui::Grid::new(name)
        .striped(true)
        .min_col_width(64.0)
        .spacing([8.0, 2.0])
        .show(ui, |ui| {
            ui.label("");
            for feature in &map.features {
                ui.strong(feature);
            }
            ui.end_row();
            for (axis, row) in axes.iter().zip(&map.matrix) {
                ui.label(format!("{} [{}]", axis.symbol(), axis.unit()));
                for value in row {
                    ui.monospace(significant(*value, 5));
                }
                ui.end_row();
            }
        });
}
