//! Pane that follows a growing log file, and shows its newest minute: the loads that the present calibration computes.

use crate::{
    engine::{Action, Followed, LiveTraces},
    questions::loops::Inks,
    recording::Axis,
    report::figure::{Figure, Line, Scale},
    ui::{
        command::{Command, PathFor},
        controls::Controls as _,
        numbers::significant,
        palette::{Trace, bytes},
        pane::{Cx, PaneView},
        plots::{self, Zoom},
    },
};

#[derive(Debug, Default)]
pub struct View {
    axis: usize,
    zoom: Zoom,
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        let Some(follow) = cx.engine.following.asked() else {
            ui.weak("No file is followed.");
            let about =
                "Reads a log file from its beginning, and then each new row as it is written";
            if ui.press("Follow a growing file…", about) {
                cx.out.send(Command::Choose(PathFor::Follow));
            }
            return;
        };
        let name = follow.path.display().to_string();
        let followed = cx.engine.following.answer().cloned().unwrap_or_default();
        self.axis = self.axis.min(followed.axes.len().saturating_sub(1));
        ui.horizontal_wrapped(|ui| {
            if ui.press("Stop", "Stops following the file") {
                cx.out.send(Action::StopFollowing);
            }
            for (at, (axis, _)) in followed.axes.iter().enumerate() {
                if ui.selectable_label(self.axis == at, axis.symbol()).clicked() {
                    (self.axis, self.zoom) = (at, None);
                }
            }
            for trace in [Trace::Calculated, Trace::Conventional, Trace::Compensated] {
                ui.colored_label(trace.color(ui.visuals()), trace.label());
            }
            ui.label(words(&followed, self.axis));
            ui.weak(name);
        });
        if let Some(problem) = cx.engine.following.problem() {
            ui.fail(problem);
        }
        for note in &followed.notes {
            ui.weak(note);
        }
        if let Some((axis, traces)) = followed.axes.get(self.axis) {
            let (height, visuals) = (ui.available_height(), ui.visuals().clone());
            let figure = |_: &Inks| figure(*axis, traces, followed.span, &visuals);
            plots::plot(ui, ("live", None), height, figure, &mut self.zoom, cx.out);
        }
    }
}

/// Returns a text: the number of rows read from the log, the status of the newest row, and the RMS errors of the loads.
fn words(followed: &Followed, axis: usize) -> String {
    let (rows, broken) = followed.counts;
    let broken = match broken {
        0 => String::new(),
        1 => ", 1 unusable line".to_owned(),
        many => format!(", {many} unusable lines"),
    };
    let of_axis = followed.axes.get(axis);
    let errors = of_axis.and_then(|(axis, traces)| {
        let [conventional, compensated] = traces.rms_errors?.map(|rms| significant(rms, 3));
        let unit = axis.unit();
        Some(format!(
            "; RMS error Uncompensated {conventional} {unit}, Compensated {compensated} {unit}"
        ))
    });
    let errors = errors.unwrap_or_default();
    format!("{rows} rows{broken}; newest: {}{errors}", followed.status)
}

fn figure<'a>(
    axis: Axis,
    traces: &'a LiveTraces,
    span: (f64, f64),
    visuals: &egui::Visuals,
) -> Figure<'a> {
    let lines = [
        (Trace::Calculated, &traces.reference),
        (Trace::Conventional, &traces.conventional),
        (Trace::Compensated, &traces.compensated),
    ];
    let lines = lines.into_iter().filter(|(_, points)| !points.is_empty());
    let loads = lines.clone().flat_map(|(_, points)| points).map(|[_, load]| *load);
    Figure {
        title: format!("{}, newest minute", axis.label()),
        across: Scale::new("t [s]", (span.0, span.1.max(span.0 + 1e-3))),
        up: Scale::spanning(axis.label(), loads, 0.05),
        lines: lines
            .map(|(trace, points)| Line {
                width: trace.stroke(visuals).width,
                ..Line::new(trace.label(), bytes(trace.color(visuals)), [&points[..]])
            })
            .collect(),
        ..Figure::default()
    }
}
