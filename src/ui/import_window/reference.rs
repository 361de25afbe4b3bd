//! Reference load with its own clock: in a file of its own, or joined from the same file.

use egui::TextEdit;

use super::columns::columns;
use super::settings::{layout, number};
use crate::import::inspect::Inspection;
use crate::import::map::{ColumnMap, JoinMethod, ReferenceFile, TableMap};
use crate::ui::controls::Controls as _;
use crate::ui::numbers::significant;

pub fn reference(ui: &mut egui::Ui, inspection: &Inspection, map: &mut ColumnMap) {
    let mut own_file = map.reference.is_some();
    if ui.tick(
        &mut own_file,
        "The reference load is in a file of its own",
        "Two loggers, two clocks: the times of both files are joined",
    ) {
        map.reference =
            own_file.then(|| ReferenceFile { file: String::new(), table: TableMap::default() });
    }
    if let Some(reference) = &mut map.reference {
        ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut reference.file)
                .hint_text("states.csv")
                .desired_width(260.0);
            ui.explained_field(
                "File",
                field,
                "Path from the folder of the gauge file; {stem} stands for the gauge file's name without its ending",
            );
        });
        if let Some(table) = &inspection.reference {
            if reference.table == TableMap::default() {
                // The layout of the gauge file is the first guess.
                reference.table.text = table.text.clone();
                reference.table.shape.columns = table.columns.len();
            }
            ui.push_id("reference layout", |ui| layout(ui, &mut reference.table.text));
            columns(ui, "reference columns", &table.columns, &mut reference.table);
        }
    }
    if !map.has_two_clocks() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Between reference samples");
        for (method, label, explanation) in [
            (JoinMethod::Interpolate, "interpolate", "Interpolates linearly between two samples"),
            (JoinMethod::Nearest, "take the nearest", "Takes the sample whose time is nearest"),
            (JoinMethod::Hold, "hold the last", "Holds each sample until the next sample"),
        ] {
            ui.select_radio(&mut map.join.method, method, label, explanation);
        }
        let explanation = "Time by which the reference's clock is behind the gauges' clock";
        number(
            ui,
            ["add to the reference's times", " s", explanation],
            &mut map.join.clock_offset_secs,
        );
    });
    if let Some(offset) = inspection.check.clock_offset {
        ui.horizontal_wrapped(|ui| {
            ui.label(format!(
                "The reference fits the gauges best with a shift of {} s. Slow gauges look the same as a clock offset: apply it only if the clocks differ.",
                significant(offset.offset_secs, 4)
            ));
            if ui.press("Apply", "Adds it to the reference's times") {
                map.join.clock_offset_secs = offset.offset_secs;
            }
        });
    }
}
