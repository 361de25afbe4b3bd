//! Pane with the calibration matrices, and the names of the features above their columns.

use egui::Ui;

use crate::{
    calibration::LinearMap,
    features::Column as Appended,
    questions::Analysis,
    recording::Axis,
    report::{Cell, Column, Table},
    ui::{
        controls::Controls as _,
        numbers::significant,
        palette::Trace,
        pane::{Cx, PaneView},
        table,
    },
};

#[derive(Debug, Default)]
pub struct View {
    uncertain: bool,
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        if let Some(analysis) = cx.engine.analysis() {
            self.draw(ui, analysis);
        }
    }
}

impl View {
    fn draw(&mut self, ui: &mut Ui, analysis: &Analysis) {
        let uncertain = &mut self.uncertain;
        ui.horizontal_wrapped(|ui| {
            if analysis.calibration.simulated {
                ui.warn("This is the calibration of a simulated sensor");
            }
            ui.weak(analysis.calibration.describe());
        });
        let calibration = &analysis.calibration;
        ui.scrolled(|ui| {
            if let Some(learned) = &calibration.learned {
                let linear = match calibration.compensated {
                    Some(_) => "matrix × features + ",
                    None => "",
                };
                let text = format!("Compensated = {linear}{}", learned.describe());
                ui.colored_label(Trace::Compensated.color(ui.visuals()), text).on_hover_text(
                    "This network or kernel has too many numbers to show; the .json export contains all of them",
                );
                ui.add_space(6.0);
            }
            let compensated = calibration.compensated.as_ref();
            let maps = compensated.map(|map| (Trace::Compensated, map));
            let conventional = (Trace::Conventional, &calibration.conventional);
            for (trace, map) in maps.into_iter().chain([conventional]) {
                let known = calibration.quality.coefficients.as_ref();
                let known = known.filter(|_| trace == Trace::Compensated);
                let standard = known.filter(|_| *uncertain).map(|known| &known.standard[..]);
                let matrix = as_table(map, &calibration.gauges, &calibration.axes, standard);
                ui.horizontal(|ui| {
                    let color = trace.color(ui.visuals());
                    ui.colored_label(color, trace.label()).on_hover_text(trace.explanation());
                    let what = format!("{} matrix", trace.label());
                    ui.copies(&what, || matrix.tab_separated());
                    if let Some(known) = known {
                        ui.checkbox(uncertain, "± u").on_hover_text(format!(
                            "Shows the standard error of each coefficient of the matrix, computed by a jackknife, {}",
                            known.left_out
                        ));
                    }
                });
                ui.push_id(trace.label(), |ui| table::show(ui, &matrix));
                if map.columns.iter().any(|column| matches!(column, Appended::Monomial(_))) {
                    ui.weak("Squares and products are those of standardised gauges, (value − mean) / σ; the exported files hold mean and σ.");
                }
                ui.add_space(6.0);
            }
        });
    }
}

/// Returns a matrix with a row for each axis and a column for each feature. `standard` are the standard errors of the
/// coefficients, which stand beside them.
fn as_table(
    map: &LinearMap,
    gauges: &[String],
    axes: &[Axis],
    standard: Option<&[Vec<f64>]>,
) -> Table {
    Table::of(axes.iter().zip(&map.matrix).enumerate())
        .words("", |(_, (axis, _))| axis.label())
        .columns(
            map.names(gauges).into_iter().enumerate(),
            |(_, name)| Column::numbers(name),
            |(axis, (_, row)), (at, _)| {
                let error = standard.map(|all| format!(" ± {}", significant(all[*axis][*at], 2)));
                let text = significant(row[*at], 5) + &error.unwrap_or_default();
                Cell::number(row[*at], text)
            },
        )
        .table("", "")
}
