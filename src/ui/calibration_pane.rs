//! Pane with the calibration matrices, and the names of the features above their columns.

use std::ops::Range;

use egui::{Rect, RichText, Ui};

use crate::{
    calibration::LinearMap,
    features::Column,
    questions::Analysis,
    recording::Axis,
    report::{self, Cell, Table},
    ui::{
        command::Pane,
        controls::Controls as _,
        equation::laid_out,
        numbers::{elided, significant},
        palette::Trace,
        pane::{Cx, PaneView},
        table,
    },
};

/// Space between two columns of a matrix (points).
const GAP: f32 = 12.0;
/// Maximum number of characters of a feature's name above a column.
const NAME_LENGTH: usize = 24;

pub const PANE: Pane = Pane {
    key: "calibration",
    title: "Calibration",
    explanation: "Calibration matrices, with the name of the feature above each column",
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
                let blocks = blocks(&map.columns);
                let names = map.names(&calibration.gauges);
                let known = calibration.quality.coefficients.as_ref();
                let known = known.filter(|_| trace == Trace::Compensated);
                ui.horizontal(|ui| {
                    let color = trace.color(ui.visuals());
                    ui.colored_label(color, trace.label()).on_hover_text(trace.explanation());
                    let text = || as_table(map, &names, &calibration.axes).tab_separated();
                    ui.copies(&format!("{} matrix", trace.label()), text);
                    if let Some(known) = known {
                        ui.checkbox(uncertain, "± u").on_hover_text(format!(
                            "Shows the standard error of each coefficient of the matrix, computed by a jackknife, {}",
                            known.left_out
                        ));
                    }
                    ui.label(laid_out(ui, &equation(&blocks), color))
                        .on_hover_text(trace.explanation());
                });
                let known = known.filter(|_| *uncertain).map(|known| &known.standard[..]);
                matrix(ui, trace.label(), map, known, &names, &blocks, &calibration.axes);
                ui.add_space(6.0);
            }
        });
    }
}

fn as_table(map: &LinearMap, names: &[String], axes: &[Axis]) -> Table {
    Table::of(axes.iter().zip(&map.matrix))
        .words("", |(axis, _)| axis.label())
        .columns(
            names.iter().enumerate(),
            |(_, name)| report::Column::numbers(*name),
            |(_, row), (at, _)| Cell::digits(Some(row[*at]), 5),
        )
        .table("", "")
}

/// Group of neighbouring matrix columns that share a symbol in the equation.
#[derive(Clone, Debug, PartialEq)]
struct Block {
    symbol: String,
    is_offset: bool,
    columns: Range<usize>,
}

/// Returns the groups of matrix columns: gauges, each feature with memory, products of features, auxiliary channels, and the
/// offset.
fn blocks(columns: &[Column]) -> Vec<Block> {
    let symbol = |column: &Column| match column {
        Column::Gauge(_) => "S".to_owned(),
        Column::Past { history, .. } => {
            format!("S_{{{}}}", history.to_string().replace('_', " "))
        }
        Column::Monomial(_) => "products".to_owned(),
        Column::Auxiliary { .. } => "auxiliary".to_owned(),
        Column::Offset => "c".to_owned(),
    };
    let mut end = 0;
    let blocks = columns.chunk_by(|one, other| symbol(one) == symbol(other)).map(|columns| {
        let start = end;
        end += columns.len();
        let is_offset = columns[0] == Column::Offset;
        Block { symbol: symbol(&columns[0]), is_offset, columns: start..end }
    });
    blocks.collect()
}

/// Returns the equation of a matrix: load = matrix × features + offset.
fn equation(blocks: &[Block]) -> String {
    let symbols: Vec<&str> =
        (blocks.iter().filter(|block| !block.is_offset)).map(|block| &*block.symbol).collect();
    let columns = match &symbols[..] {
        [one] => (*one).to_owned(),
        several => format!("[{}]^T", several.join(", ")),
    };
    let offset = if symbols.len() < blocks.len() { " + c" } else { "" };
    format!("L = C^{{-1}} {columns}{offset}")
}

fn matrix(
    ui: &mut Ui,
    name: &str,
    map: &LinearMap,
    standard: Option<&[Vec<f64>]>,
    features: &[String],
    blocks: &[Block],
    axes: &[Axis],
) {
    let cells = map.matrix.iter().enumerate().map(|(axis, row)| {
        let text = |(at, value): (usize, &f64)| {
            let error = standard.map(|all| format!(" ± {}", significant(all[axis][at], 2)));
            significant(*value, 5) + &error.unwrap_or_default()
        };
        row.iter().enumerate().map(text).collect()
    });
    let cells: Vec<Vec<String>> = cells.collect();
    let heads: Vec<String> = features.iter().map(|name| elided(name, NAME_LENGTH)).collect();
    let length = |text: &String| text.chars().count();
    let widths = heads.iter().enumerate().map(|(column, head)| {
        let values = cells.iter().filter_map(|row| row.get(column));
        values.map(length).fold(length(head), usize::max)
    });
    let widths: Vec<usize> = widths.collect();
    let mut numbers = Rect::NOTHING;
    let mut borders = vec![Rect::NOTHING; blocks.len()];
    egui::Grid::new(name).striped(true).min_col_width(20.0).spacing([GAP, 2.0]).show(ui, |ui| {
        let color = ui.visuals().strong_text_color();
        ui.label("");
        for column in 0..features.len() {
            let block = blocks.iter().find(|block| block.columns.start == column);
            ui.label(laid_out(ui, block.map_or("", |block| &block.symbol), color));
        }
        ui.end_row();
        ui.label("");
        for ((head, feature), width) in heads.iter().zip(features).zip(&widths) {
            ui.label(RichText::new(format!("{head:>width$}")).monospace().strong())
                .on_hover_text(feature);
        }
        ui.end_row();
        for (axis, row) in axes.iter().zip(&cells) {
            ui.label(axis.label());
            for (column, (value, width)) in row.iter().zip(&widths).enumerate() {
                let cell = ui.monospace(format!("{value:>width$}"));
                table::say(&cell, || format!("{} {} {value}", axis.symbol(), features[column]));
                let place = cell.rect;
                numbers |= place;
                let starts = |block: &Block| block.columns.start == column;
                if let Some(at) = blocks.iter().position(starts) {
                    borders[at] |= place;
                }
            }
            ui.end_row();
        }
    });
    if numbers.is_positive() {
        brackets(ui, numbers, borders.iter().skip(1));
    }
}

/// Draws the brackets around the numbers, and a thin line at each border between groups of columns.
fn brackets<'a>(ui: &Ui, numbers: Rect, borders: impl Iterator<Item = &'a Rect>) {
    let around = numbers.expand2(egui::vec2(0.5 * GAP, 1.0));
    let stroke = egui::Stroke::new(1.4, ui.visuals().text_color());
    for (x, inwards) in [(around.left(), 4.0), (around.right(), -4.0)] {
        let corners = [
            egui::pos2(x + inwards, around.top()),
            egui::pos2(x, around.top()),
            egui::pos2(x, around.bottom()),
            egui::pos2(x + inwards, around.bottom()),
        ];
        ui.painter().line(corners.to_vec(), stroke);
    }
    let thin = ui.visuals().widgets.noninteractive.bg_stroke;
    for border in borders {
        let x = border.left() - 0.5 * GAP;
        ui.painter().vline(x, around.y_range(), thin);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::{Blocks, FeatureSettings, Play, Polynomial};

    #[test]
    fn blocks_and_their_equation_follow_the_columns() {
        let mut features = FeatureSettings::default();
        let said = |features: &FeatureSettings, offset| {
            let columns = features.columns(2, offset);
            let blocks = blocks(&columns);
            let end = blocks.last().map(|block| block.columns.end);
            assert_eq!(end, Some(columns.len()));
            equation(&blocks)
        };
        assert_eq!(said(&features, true), "L = C^{-1} [S, S_{past}]^T + c");
        features.blocks = Blocks::default().with(&Play, &[0.1]).with(&Polynomial, &[2.0]);
        assert_eq!(said(&features, true), "L = C^{-1} [S, S_{past}, S_{play 0.1}, products]^T + c");
        assert_eq!(said(&features, false), "L = C^{-1} [S, S_{past}, S_{play 0.1}, products]^T");
        features.look_backs.clear();
        features.blocks = Blocks::default();
        assert_eq!(said(&features, false), "L = C^{-1} S");
    }
}
