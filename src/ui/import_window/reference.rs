//! A reference on its own clock: in a file of its own, and how it is joined.

use egui::TextEdit;

use super::columns::columns;
use super::settings::{layout, number};
use crate::import::inspect::Inspection;
use crate::import::map::{ColumnMap, JoinMethod, ReferenceFile, TableMap};
use crate::ui::controls::Controls as _;
use crate::ui::numbers::significant;

pub(super) fn reference(ui: &mut egui::Ui, inspection: &Inspection, map: &mut ColumnMap) {
    let mut own_file = map.reference.is_some();
    if ui.tick(
        &mut own_file,
        "The reference load stands in a file of its own",
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
                "Seen from the folder of the file with the gauges; {stem} stands for that file's name without its ending",
            );
        });
        if let Some(table) = &inspection.reference {
            if reference.table == TableMap::default() {
                // Begin with how the file itself is cut.
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
            (JoinMethod::Interpolate, "interpolate", "On the straight line between two samples"),
            (JoinMethod::Nearest, "take the nearest", "The sample whose time is nearest"),
            (JoinMethod::Hold, "hold the last", "The last sample, until the next one comes"),
        ] {
            ui.select_radio(&mut map.join.method, method, label, explanation);
        }
        let explanation = "By how much the reference's clock is behind that of the gauges";
        number(
            ui,
            ["add to the reference's times", " s", explanation],
            &mut map.join.clock_offset_secs,
        );
    });
    if let Some(offset) = inspection.check.clock_offset {
        ui.horizontal_wrapped(|ui| {
            ui.label(format!(
                "By cross-correlation the reference seems to need {} s. A gauge that follows the load slowly looks the same: apply it only if the clocks differ.",
                significant(offset.offset_secs, 4)
            ));
            if ui.press("Apply", "Adds it to the reference's times") {
                map.join.clock_offset_secs = offset.offset_secs;
            }
        });
    }
}
