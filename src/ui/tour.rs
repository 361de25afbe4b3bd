//! Tour that explains how to calibrate the built-in simulated sensor. Each step points at one pane, and the user can end the
//! tour at any step.

use egui::{Rect, Vec2};

use crate::ui::command::{Command, Out, Pane};
use crate::ui::controls::Controls as _;
use crate::ui::{export_pane, loops_pane, recordings_panel, settings_panel, trace_panes};

type Step = (Pane, &'static str, &'static str);

const STEPS: [Step; 6] = [
    (
        trace_panes::PANE,
        "What LoopScope does",
        "These recordings come from a simulated force/torque sensor. Each plot shows one axis. Reference is the applied load, and Uncompensated is the load by the conventional calibration. Compensated is the load that is compensated with earlier gauge values. The errors are below the loads.",
    ),
    (
        trace_panes::PANE,
        "The past of a sample",
        "Move the pointer over a trace. The green interval before it is the time threshold t_th. The diamond is the last sample in this interval whose load differed by the force threshold F_th. The small plot at the pointer shows this difference for all samples in the interval. Space plays the recording.",
    ),
    (
        settings_panel::PANE,
        "Thresholds",
        "Move the sliders of the thresholds F_th and t_th: the calibration is fitted again while you move them. If F_th is 0 N, Compensated equals Uncompensated. The tab Thresholds shows the error for every pair of F_th and t_th. It proposes a pair without using the test recordings.",
    ),
    (
        loops_pane::PANE,
        "Loops",
        "The plot shows the uncompensated and the compensated error against the load: the area of a loop is the hysteresis. The tab Metrology shows the figures of \
         a data sheet, and the tab Models finds the best model.",
    ),
    (
        recordings_panel::PANE,
        "Your own recordings",
        "Drop files on the window, or File > Open; the tour ends then. Choose a role for each recording: train, test or off. For a file \
         whose columns have no names, the import window opens first.",
    ),
    (
        export_pane::PANE,
        "Results",
        "Export the calibration here: .json for this program, .h, .rs or .py to run on a robot, and more. F1 shows all keys, \
         Ctrl+P finds any action.",
    ),
];

/// Size of the window of each step (points). All steps have the same size, so that the buttons stay in place.
const SIZE: Vec2 = Vec2::new(360.0, 190.0);
/// Distance of the ring around a pane from its contents (points).
const RING: f32 = 5.0;
/// Minimum distance of a tour step from the edges of the window, which leaves room for menus and status line (points).
const EDGE: Vec2 = Vec2::new(24.0, 60.0);

#[derive(Debug, Default)]
pub struct Tour {
    /// Index of the present step; `None` without a tour.
    pub step: Option<usize>,
}

impl Tour {
    /// Starts the tour. Returns the pane of its first step.
    pub fn begin(&mut self) -> Pane {
        self.step = Some(0);
        STEPS[0].0
    }

    /// Draws the present step beside the pane that the step explains. `places` are the areas of the panes on screen.
    pub fn show(&mut self, context: &egui::Context, places: &[(Pane, Rect)], out: &mut Out) {
        let Some(step) = self.step else {
            return;
        };
        let (pane, title, text) = STEPS[step];
        let place = places.iter().find(|(own, _)| *own == pane);
        let place = place.map(|(_, place)| *place);
        if let Some(place) = place {
            let layer = egui::LayerId::new(egui::Order::Middle, egui::Id::unique("tour points"));
            let stroke = context.global_style().visuals.selection.stroke;
            let stroke = egui::Stroke::new(2.0, stroke.color);
            let painter = context.layer_painter(layer);
            painter.rect_stroke(place.expand(RING), 4.0, stroke, egui::StrokeKind::Inside);
        }
        let mut next = None;
        egui::Window::new(format!("Tour, {} of {}: {title}", step + 1, STEPS.len()))
            .id(egui::Id::unique("tour"))
            .fixed_pos(beside(place, context.content_rect()))
            .collapsible(false)
            .resizable(false)
            .show(context, |ui| {
                ui.set_width(SIZE.x);
                ui.set_height(SIZE.y - 60.0);
                ui.add(egui::Label::new(text).wrap());
                ui.with_layout(egui::Layout::bottom_up(egui::Align::Min), |ui| {
                    ui.horizontal(|ui| {
                        if ui.press_if(step > 0, "Back", "Shows the previous step") {
                            next = Some(step - 1);
                        }
                        let is_last = step + 1 == STEPS.len();
                        if !is_last && ui.press("Next", "Shows the next step") {
                            next = Some(step + 1);
                        }
                        let end = if is_last { "Done" } else { "Skip the tour" };
                        if ui.press(end, "Ends the tour; the Help menu starts it again") {
                            out.send(Command::Tour(false));
                        }
                    });
                });
            });
        if let Some(next) = next {
            self.step = Some(next);
            out.send(Command::ShowPane(STEPS[next].0));
        }
    }
}

/// Returns the place of a tour step's box: the corner of the window where the box covers the least of the pane that the step
/// explains.
fn beside(place: Option<Rect>, window: Rect) -> egui::Pos2 {
    let room = window.shrink2(EDGE);
    let (left, right) = (room.left(), (room.right() - SIZE.x - EDGE.x).max(room.left()));
    let (top, low) = (room.top(), (room.bottom() - SIZE.y - EDGE.x).max(room.top()));
    let corners = [(right, top), (right, low), (left, low), (left, top)];
    let corners = corners.map(|(x, y)| egui::pos2(x, y));
    let hidden = |corner: &egui::Pos2| {
        place.map_or(0.0, |place| {
            let shared = place.intersect(Rect::from_min_size(*corner, SIZE + Vec2::splat(EDGE.x)));
            shared.width().max(0.0) * shared.height().max(0.0)
        })
    };
    let least = corners.into_iter().min_by(|a, b| hidden(a).total_cmp(&hidden(b)));
    least.unwrap_or(room.min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_stands_in_the_corner_that_hides_nothing_of_what_it_speaks_of() {
        let window = Rect::from_min_size(egui::Pos2::ZERO, Vec2::new(1280.0, 800.0));
        let step = |place: Rect| Rect::from_min_size(beside(Some(place), window), SIZE);
        let panes = [
            Rect::from_min_max(egui::pos2(412.0, 50.0), egui::pos2(1280.0, 530.0)),
            Rect::from_min_max(egui::pos2(0.0, 430.0), egui::pos2(410.0, 770.0)),
            Rect::from_min_max(egui::pos2(0.0, 50.0), egui::pos2(410.0, 400.0)),
            Rect::from_min_max(egui::pos2(990.0, 560.0), egui::pos2(1280.0, 770.0)),
        ];
        for pane in panes {
            assert!(!step(pane).intersects(pane), "{pane:?} {:?}", step(pane));
        }
        assert!(window.contains_rect(step(window)));
    }
}
