//! Controls of a reference load that another logger recorded with its own clock, in a separate file or in the same file.

use egui::TextEdit;

use super::columns::columns;
use super::settings::{layout, number};
use crate::{
    import::{
        inspect::Inspection,
        map::{ColumnMap, JoinMethod, ReferenceFile, TableMap},
    },
    ui::{controls::Controls as _, numbers::significant},
};

pub fn reference(ui: &mut egui::Ui, inspection: &Inspection, map: &mut ColumnMap) {
    let mut own_file = map.reference.is_some();
    if ui.tick(
        &mut own_file,
        "The reference load is in a separate file",
        "For two loggers with two clocks; gauges and reference are joined by their times",
    ) {
        map.reference =
            own_file.then(|| ReferenceFile { file: String::new(), table: TableMap::default() });
    }
    if let Some(reference) = &mut map.reference {
        ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut reference.file)
                .hint_text("states.csv")
                .desired_width(260.0);
            ui.field(
                "File",
                field,
                "Path of the reference file, relative to the folder of the gauge file; {stem} stands for the name of the gauge file without its ending",
            );
        });
        if let Some(table) = &inspection.reference {
            if reference.table == TableMap::default() {
                // The default text layout of the reference file is the layout with which the preview was read.
                reference.table.text = table.text.clone();
                reference.table.shape.columns = table.columns.len();
            }
            ui.push_id("reference layout", |ui| layout(ui, &mut reference.table.text));
            columns(ui, "reference columns", &table.columns, &mut reference.table, None);
        }
    }
    if !map.has_two_clocks() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Reference load between two reference samples");
        for (method, label, explanation) in [
            (
                JoinMethod::Interpolate,
                "interpolate",
                "Interpolates linearly between two reference samples",
            ),
            (
                JoinMethod::Nearest,
                "take the nearest sample",
                "Takes the reference sample whose time is nearest",
            ),
            (JoinMethod::Hold, "hold the last sample", "Holds each reference sample until the next one"),
        ] {
            ui.select_radio(&mut map.join.method, method, label, explanation);
        }
        let explanation =
            "Time by which the clock of the reference is behind the clock of the gauges; added to the times of the reference";
        number(
            ui,
            ["add to the times of the reference", " s", explanation],
            &mut map.join.clock_offset_secs,
        );
    });
    if let Some(offset) = inspection.check.clock_offset {
        ui.horizontal_wrapped(|ui| {
            ui.label(format!(
                "The reference fits the gauges best if its times are shifted by {} s. Gauges that respond slowly look the same, so apply it only if the clocks differ.",
                significant(offset.offset_secs, 4)
            ));
            if ui.press("Apply", "Adds this shift to the times of the reference") {
                map.join.clock_offset_secs = offset.offset_secs;
            }
        });
    }
}
