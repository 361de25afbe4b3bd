//! Plots of the model on screen, for recordings that the model was not fitted to: compensated against reference load, and
//! error against reference load.

use crate::{
    questions::loops::{
        Channel, CrossQuestion, FiguresOf, Inks, Look, LoopQuestion, LoopView, Question, Span,
        TableOf, Up, query::LookAt,
    },
    recording::Axis,
    report::Trace,
    ui::{
        controls::Controls as _,
        pane::Cx,
        plots::{self, Zoom},
    },
};

const SMALLEST: f32 = 80.0;
/// Names by which the two plots ask for their contents.
const PREDICTED: &str = "predicted";
const RESIDUAL: &str = "residual";

#[derive(Debug, Default)]
pub struct ModelPlots {
    axis: Option<Axis>,
    zooms: [Zoom; 2],
}

impl ModelPlots {
    pub fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        let engine = cx.engine;
        let axes = engine.project().axes();
        let chosen = self.axis.filter(|axis| axes.contains(axis));
        let Some(mut axis) = chosen.or(axes.first().copied()) else { return };
        ui.horizontal_wrapped(|ui| {
            ui.strong("Model on screen").on_hover_text(
                "To show another model here, press the button Use in its row of the list",
            );
            for one in axes {
                ui.select(&mut axis, *one, one.symbol(), "Shows the plots of this axis");
            }
        });
        if self.axis.is_some_and(|before| before != axis) {
            self.zooms = Default::default();
        }
        self.axis = Some(axis);
        let size = ui.available_size();
        let (width, height) = ((0.5 * size.x - 8.0).max(SMALLEST), (size.y - 4.0).max(SMALLEST));
        let pixels = [width, height].map(|side| f64::from(side * ui.pixels_per_point()));
        let span = Span::Of(TableOf::usual(&engine.project().recordings));
        let [across, up] =
            [Trace::Calculated, Trace::Compensated].map(|load| Channel::Load(load, axis));
        let [first, second] = self.zooms;
        let cross = CrossQuestion { across, up, span, frame: first, pixels };
        let loops =
            LoopQuestion { axis, up: Up::Error, span, lag_removed: false, frame: second, pixels };
        ui.horizontal_top(|ui| {
            let [first_zoom, second_zoom] = &mut self.zooms;
            let size = egui::vec2(width, height);
            if let Some(Look::Cross(plot)) = engine.lane_of::<LookAt>(PREDICTED).answer() {
                let labels = || ["Reference", "Compensated"].map(|name| axis.label_of(name));
                let figure = |inks: &Inks| plot.figure(labels(), inks, first);
                ui.allocate_ui(size, |ui| {
                    plots::plot(ui, ("predicted", None), height, figure, first_zoom, cx.out);
                });
            }
            if let Some(Look::Loops(plot)) = engine.lane_of::<LookAt>(RESIDUAL).answer() {
                let mut view = LoopView::of_all(plot, ("", ""), FiguresOf::Largest);
                view.shown.retain(|curve| curve.output == Some(Trace::Compensated));
                let (name, figure) = (view.title(), |inks: &Inks| view.figure(inks, second));
                ui.allocate_ui(size, |ui| {
                    let id = ("residual", Some(name));
                    plots::plot(ui, id, height, figure, second_zoom, cx.out);
                });
            }
        });
        if engine.gesture.is_some() {
            return; // While a slider moves, the plots of the previous settings stay.
        }
        if let Some(look) = engine.look(None, Question::Cross(cross)) {
            cx.ask_as(PREDICTED, LookAt(look));
        }
        if let Some(look) = engine.look(None, Question::Loops(loops)) {
            cx.ask_as(RESIDUAL, LookAt(look));
        }
    }
}
