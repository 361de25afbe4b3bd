//! Pane with the newest minute of a growing file, and its loads by the present calibration.

use std::borrow::Cow;

use crate::engine::{Action, Followed, LiveTraces};
use crate::recording::Axis;
use crate::report::figure::{Figure, Line, Scale};
use crate::ui::command::{Kind, Pane};
use crate::ui::controls::Controls as _;
use crate::ui::numbers::significant;
use crate::ui::palette::{Trace, bytes};
use crate::ui::pane::{Cx, PaneView};
use crate::ui::plots;
use crate::ui::plots::Zoom;

pub const PANE: Pane = Pane(&Kind {
    key: "live",
    title: "Live",
    explanation: "The newest minute of a growing file, with its loads by the present calibration",
});

#[derive(Debug, Default)]
pub struct View {
    axis: usize,
    zoom: Zoom,
    path: String,
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        let Some(follow) = cx.engine.following.asked() else {
            ui.weak("No file is followed. Enter the path of a log that is being written, or choose File > Follow a growing file…");
            ui.horizontal(|ui| {
                let path = egui::TextEdit::singleline(&mut self.path);
                let field = ui.labelled("File", path);
                let asked = ui.entered(&field);
                if (ui.press("Follow", "Reads the file from its beginning, and then each new row")
                    || asked)
                    && !self.path.trim().is_empty()
                {
                    cx.out.push(Action::Follow(self.path.trim().into()).into());
                }
            });
            return;
        };
        let name = follow.path.display().to_string();
        let followed = cx.engine.following.answer().cloned().unwrap_or_default();
        self.axis = self.axis.min(followed.axes.len().saturating_sub(1));
        ui.horizontal_wrapped(|ui| {
            if ui.press("Stop", "Stops following the file") {
                cx.out.push(Action::StopFollowing.into());
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
            let whole = figure(*axis, traces, followed.span, ui.visuals());
            let mut shown = whole.clone();
            if let Some(zoom) = self.zoom {
                (shown.across.range, shown.up.range) = (zoom.loads, zoom.outputs);
            }
            let height = ui.available_height();
            plots::plot(ui, "live", height, [&shown, &whole], &mut self.zoom, cx.out);
        }
    }
}

/// Returns the number of rows, the status of the newest row, and the error of the loads.
fn words(followed: &Followed, axis: usize) -> String {
    let (rows, broken) = followed.counts;
    let broken = match broken {
        0 => String::new(),
        1 => ", 1 line without a usable row".to_owned(),
        many => format!(", {many} lines without a usable row"),
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
    let line = |trace: Trace, points: &'a [[f64; 2]]| Line {
        name: trace.label().to_owned(),
        color: bytes(trace.color(visuals)),
        opacity: 1.0,
        width: trace.stroke(visuals).width,
        dash: None,
        pieces: vec![Cow::Borrowed(points)],
    };
    let lines = vec![
        line(Trace::Calculated, &traces.reference),
        line(Trace::Conventional, &traces.conventional),
        line(Trace::Compensated, &traces.compensated),
    ];
    let lines: Vec<_> = (lines.into_iter()).filter(|line| !line.pieces[0].is_empty()).collect();
    let loads = lines.iter().flat_map(|line| line.pieces[0].iter());
    let loads: Vec<f64> = loads.map(|[_, load]| *load).collect();
    Figure {
        title: format!("{}, newest minute", axis.label()),
        across: Scale::new("t [s]", (span.0, span.1.max(span.0 + 1e-3))),
        up: Scale::spanning(axis.label(), loads, 0.05),
        lines,
        ..Figure::default()
    }
}
