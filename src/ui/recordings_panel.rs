//! Pane of the recordings, with the role, group, length and errors of each recording.

mod faults;
mod row;

use egui::{Color32, Ui};

use egui_extras::{Column, TableBuilder, TableRow};

use faults::faults_row;
use row::{group_button, group_of, name_button, rmse_label, role_menu};

use crate::{
    engine::{Action, Edit, Engine, ImportCommand, Project},
    min_max::MinMax,
    questions::{self, RecordingResult, check::query::FindFaults},
    recording::{Axis, Channel, Entry, GaugeRange, GroupPattern, Role, Source, Tare, ValidRange},
    report::{self, Cell, Table},
    scoring::metrics::Group,
    shown::{and_more, printable},
    ui::{
        channels_pane,
        command::{Command, Out, Pane},
        context_menu::context_menu,
        controls::Controls as _,
        numbers::{elided, significant},
        palette::Trace,
        pane::{Cx, PaneView},
    },
};

const OPEN_WIDTH: f32 = 224.0;
/// Width of the list (points) below which groups, numbers of samples and rates are omitted.
const MIN_WIDTH_FOR_COUNTS: f32 = 460.0;
/// Width of the list (points) below which the errors are omitted too.
const MIN_WIDTH_FOR_ERRORS: f32 = 210.0;

/// Explanation of the simulated sensor.
pub const SIMULATED: &str = "The recordings come from the built-in simulated sensor, not from a real sensor. The simulation is of a six-axis resin sensor on a robot arm, which turns a weight of 1.128 kg";

pub const PANE: Pane = Pane {
    key: "recordings",
    title: "Recordings",
    explanation: "The open recordings with their roles, groups, lengths and errors",
};

#[derive(Debug)]
pub struct View {
    open: String,
    /// Share of each recording's time that the button Split assigns to training (%).
    split_percent: f64,
    /// Recording whose group is being edited.
    group: Typed,
}

/// Index of a recording, and the text that the user types into a field about the recording.
type Typed = Option<(usize, String)>;

impl Default for View {
    fn default() -> Self {
        Self { open: String::new(), split_percent: 60.0, group: None }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        cx.ask(FindFaults::of(&cx.engine.request(), cx.engine.project().valid_range()));
        recordings_panel(ui, cx.engine, self, cx.out);
    }
}

fn recordings_panel(ui: &mut Ui, engine: &Engine, fields: &mut View, out: &mut Out) {
    path_field(ui, fields, out);
    split_row(ui, engine, fields, out);
    if !engine.entries().is_empty() {
        faults_row(ui, engine, out);
    }
    if engine.project().recordings.is_simulated() {
        ui.warn("simulated").on_hover_text(SIMULATED);
    }
    if let Some(applied) = &engine.project().applied {
        ui.horizontal_wrapped(|ui| {
            ui.warn(format!("Applying {}", applied.path.display()));
            if ui.press(
                "Fit again",
                "Closes the applied calibration, and fits a calibration to the recordings again",
            ) {
                out.send(Edit::Apply(None));
            }
        });
    }
    ui.separator();
    if engine.entries().is_empty() {
        ui.weak(
            "Open files, drop them on the window, or choose File > Built-in sensor (simulated).",
        );
        return;
    }
    table(ui, engine, fields, out);
}

fn path_field(ui: &mut Ui, fields: &mut View, out: &mut Out) {
    ui.horizontal(|ui| {
        let width = (ui.available_width() - OPEN_WIDTH).max(60.0);
        let about = [
            "A recording, a calibration (.json or .cal), a session, or a folder of them",
            "Load",
            "Opens the file or folder at this path",
        ];
        let hint = "path of a recording or calibration";
        if let Some(path) = ui.path_field("Open", &mut fields.open, (width, hint), about) {
            out.send(Action::Open(vec![path]));
        }
        if ui.press("…", "Chooses files to open") {
            out.send(Command::ChooseFiles);
        }
        let path = fields.open.trim();
        let about =
            "Shows the columns of the file at this path, to choose their roles before it is loaded";
        if ui.press_if(!path.is_empty(), "Columns…", about) {
            out.send(ImportCommand::Open(path.into()));
        }
    });
}

fn split_row(ui: &mut Ui, engine: &Engine, fields: &mut View, out: &mut Out) {
    ui.horizontal_wrapped(|ui| {
        let field = egui::DragValue::new(&mut fields.split_percent)
            .range(1.0..=99.0)
            .max_decimals(1)
            .suffix(" %");
        ui.field("Train/test split: train on the first", field, "Share of each recording's time that is used for training");
        if ui.press(
            "Split",
            "Splits each recording in time: the first segment is for training, the second for testing. Each test segment starts cold: features with memory, such as the look-back, know nothing of the loads before the split",
        ) {
            out.send(Edit::Split(fields.split_percent / 100.0));
        }
        ui.copies("list", || as_table(engine).tab_separated());
        if engine.project().split.is_some()
            && ui.press("Undo split", "Joins the training and the test segment of each recording again") {
                out.send(Edit::Unsplit);
            }
    });
}

fn table(ui: &mut Ui, engine: &Engine, fields: &mut View, out: &mut Out) {
    let axes = engine.project().axes();
    let group = if axes.iter().any(|axis| axis.is_force()) { Group::Force } else { Group::Moment };
    let unit = axes.first().map_or("", |axis| axis.unit());
    // In a narrow list, the name gets the width of the omitted columns. The hover text of the name gives the number of
    // samples.
    let counted = ui.available_width() > MIN_WIDTH_FOR_COUNTS;
    let has_errors = ui.available_width() > MIN_WIDTH_FOR_ERRORS;
    if !counted {
        ui.spacing_mut().item_spacing.x = 4.0;
    }
    let counts = [Column::exact(54.0).clip(true), Column::exact(50.0), Column::exact(34.0)];
    let mut builder = TableBuilder::new(ui)
        .striped(true)
        .auto_shrink([false, false])
        .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
        .column(Column::exact(46.0))
        .column(Column::remainder().at_least(16.0).clip(true));
    for count in counts.into_iter().filter(|_| counted) {
        builder = builder.column(count);
    }
    builder
        .columns(Column::exact(54.0), if has_errors { 2 } else { 0 })
        .column(Column::exact(18.0))
        .header(18.0, |row| header(row, (counted, has_errors), unit))
        .body(|body| {
            body.rows(20.0, engine.entries().len(), |mut row| {
                let at = row.index();
                let entry = &engine.entries()[at];
                row.set_selected(engine.project().view == questions::View::One(at));
                row.col(|ui| role_menu(ui, at, entry, out));
                row.col(|ui| name_button(ui, engine, at, fields, out));
                let result = engine.result_of(at);
                if counted {
                    row.col(|ui| group_button(ui, engine, at, &mut fields.group, out));
                    row.col(|ui| {
                        let samples = result.map_or(entry.recording.n_samples(), |r| r.n_samples);
                        ui.label(samples.to_string());
                    });
                    row.col(|ui| {
                        let step = engine.project().settings.decimation.max(1) as f64;
                        let rate =
                            entry.recording.rate_hz().map(|rate| significant(rate / step, 3));
                        ui.label(rate.unwrap_or_else(|| "–".to_owned()));
                    });
                }
                let rmse =
                    result.map(|result| [&result.conventional_rmse, &result.compensated_rmse]);
                for at in (0..2).filter(|_| has_errors) {
                    let rmse = rmse.and_then(|rmse| rmse[at].as_deref());
                    row.col(|ui| rmse_label(ui, group, axes, rmse, result));
                }
                row.col(|ui| {
                    if ui.press_small("×", "Closes this recording") {
                        out.send(Edit::Remove(at));
                    }
                });
            });
        });
}

fn as_table(engine: &Engine) -> Table {
    let axes = engine.project().axes();
    let errors = [Trace::Conventional, Trace::Compensated].into_iter().enumerate();
    let errors = errors.flat_map(|(output, trace)| {
        axes.iter().enumerate().map(move |(at, axis)| (output, trace, at, axis))
    });
    Table::of(engine.entries().iter().enumerate())
        .words("role", |(_, entry)| entry.role.label())
        .words("name", |(_, entry)| entry.recording.name())
        .words("group", |(at, _)| group_of(engine, *at).unwrap_or_default())
        .column(report::Column::numbers("samples"), |(_, entry)| {
            Cell::whole(entry.recording.n_samples())
        })
        .columns(
            errors,
            |(_, trace, _, axis)| {
                let name = format!("{} RMSE {}", trace.label(), axis.symbol());
                report::Column::numbers(name).unit(axis.unit())
            },
            |(row, _), (output, _, at, _)| {
                let result = engine.result_of(*row);
                let rmse =
                    result.map(|result| [&result.conventional_rmse, &result.compensated_rmse]);
                let rmse = rmse.and_then(|rmse| rmse[*output].as_ref());
                Cell::digits(rmse.and_then(|rmse| rmse.get(*at)).copied(), 5)
            },
        )
        .table("", "")
}

fn header(mut header: TableRow<'_, '_>, (counted, has_errors): (bool, bool), unit: &str) {
    let rmse = format!(
        "RMSE of the forces, or of the moments if the recordings have no force axis [{unit}]"
    );
    let titles = [
        ("Role", "Role of the recording: train, test or off; press to change the role"),
        (
            "Name",
            "Press to show the recording. A right click or Shift+F10 opens a menu to tare the recording and to set its group",
        ),
        (
            "Group",
            "Recordings of one group have the same load programme, day or mounting. Cross-validation leaves out a whole group at a time; press to change the group",
        ),
        ("Samples", "Number of samples after decimation"),
        ("Hz", "Sample rate: 1 divided by the median time step"),
    ];
    let n = if counted { 5 } else { 2 };
    for (title, explanation) in titles.into_iter().take(n) {
        header.col(|ui| {
            ui.strong(title).on_hover_text(explanation);
        });
    }
    let errors = [(Trace::Conventional, "Uncomp."), (Trace::Compensated, "Comp.")];
    for (trace, head) in errors.into_iter().filter(|_| has_errors) {
        header.col(|ui| {
            ui.colored_label(trace.color(ui.visuals()), head)
                .on_hover_text(format!("{}: {rmse}", trace.explanation()));
        });
    }
    header.col(|_| {});
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

    use super::*;

    /// The list is 227 points wide in a window of 1280 points with a text size of 150 %.
    #[test]
    fn a_narrow_list_keeps_the_button_that_closes_a_recording() {
        let mut engine = Engine::new(Arc::new(|| {}));
        engine.act(Action::OpenBuiltIn(None));
        while engine.entries().is_empty() {
            engine.take();
            std::thread::sleep(Duration::from_millis(1));
        }
        for width in [140.0, 227.0] {
            let (mut fields, mut out) = (View::default(), Out::default());
            let list = |ui: &mut Ui| table(ui, &engine, &mut fields, &mut out);
            let window = Harness::builder().with_size([width, 400.0]).build_ui(list);
            let buttons = window.query_all_by_role_and_label(egui::accesskit::Role::Button, "×");
            let ends: Vec<f32> = buttons.map(|button| button.rect().right()).collect();
            assert!(ends.len() > 5 && ends.iter().all(|end| *end <= width), "{width}: {ends:?}");
        }
    }
}
