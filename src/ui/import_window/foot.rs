//! Foot of the import page: the recordings that would be loaded, the problems, and the buttons.

use egui::RichText;

use crate::{
    engine::{ImportCommand, Importing},
    finding::Face,
    import::inspect::{Inspection, Question},
    recording::Axis,
    shown::counted,
    ui::{command::Out, controls::Controls as _, numbers::rate_in_words, status_line::busy},
};

pub fn foot(ui: &mut egui::Ui, importing: &Importing, inspection: &Inspection, out: &mut Out) {
    let check = &inspection.check;
    ui.add_space(4.0);
    egui::ScrollArea::vertical().id_salt("check").max_height(96.0).show(ui, |ui| {
        match &check.error {
            Some(error) => {
                ui.fail(error);
            }
            None => {
                ui.label(RichText::new(would_load(inspection)).size(15.0));
                ui.weak(allows(importing, inspection));
            }
        }
        for warning in &check.warnings {
            ui.warn(warning.text(Face::Window));
        }
    });
    ui.horizontal(|ui| {
        let can_load = check.error.is_none() && !importing.is_detecting;
        let load = ui.add_enabled(can_load, egui::Button::new("Load the file"));
        let load = load.on_hover_text("Reads the whole file with this column map, and stores the map for files with the same columns");
        let why = "The file cannot be loaded; the problem is listed above";
        if load.on_disabled_hover_text(why).clicked() {
            out.send(ImportCommand::Load);
        }

        let next = if importing.waiting.is_empty() {
            "Closes the import without loading the file; the recordings that are already open stay"
        } else {
            "Skips this file and shows the next file that needs a column map"
        };

        if ui.press("Cancel import", next) {
            out.send(ImportCommand::Cancel);
        }
        if !importing.waiting.is_empty() {
            let n_left = importing.waiting.len() + 1;
            let explanation =
                "Skips all files that still need a column map; the recordings that are already open stay. Escape does the same";
            if ui.press(format!("Cancel all ({n_left} files left)"), explanation) {
                out.send(ImportCommand::CancelAll);
            }
        }
        if importing.is_detecting {
            busy(ui);
        }
    });
    ui.add_space(4.0);
}

/// Says what the roles of the channels allow, and how many questions are open.
fn allows(importing: &Importing, inspection: &Inspection) -> String {
    let check = &inspection.check;
    let is_open =
        |question: &&Question| question.is_open(&importing.map, &inspection.table.columns);
    let next = match (check.gauges.is_empty(), check.axes.is_empty()) {
        (true, _) => "This can be looked at. To calibrate, choose the gauges.",
        (false, true) => {
            "This can be looked at and checked for faults. To calibrate, choose the reference load."
        }
        (false, false) => "This is enough to calibrate and to show hysteresis.",
    };
    match importing.questions.iter().filter(is_open).count() {
        0 => next.to_owned(),
        n => format!("{next} Open: {}; the file can be loaded without.", counted(n, "question")),
    }
}

fn would_load(inspection: &Inspection) -> String {
    let check = &inspection.check;
    let samples: usize = check.recordings.iter().map(|recording| recording.n_samples).sum();
    let rate = check.recordings.first().and_then(|recording| {
        rate_in_words(recording.rate_hz, recording.n_samples, recording.duration_secs)
    });
    let axes = Axis::symbols(&check.axes);
    format!(
        "Would load {}{}, {samples} samples{}, gauges {}, {}",
        if check.is_sample { "from the start of the file " } else { "" },
        counted(check.recordings.len(), "recording"),
        rate.map_or_else(String::new, |rate| format!(" at {rate}")),
        check.gauges.join(" "),
        if axes.is_empty() {
            "no reference load".to_owned()
        } else {
            format!("reference {}", axes.join(" "))
        },
    )
}
