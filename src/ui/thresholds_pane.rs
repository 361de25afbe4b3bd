//! Pane of the thresholds: the map of the error for pairs of force threshold F_th and time threshold t_th.

mod map;

use std::sync::Arc;

use egui::Ui;

use crate::{
    engine::FileContent,
    features::{Distance, Thresholds},
    questions::thresholds::{
        MAP_FORMATS, Measure, ShownFTh, ThresholdMap,
        asked::{StudyThresholds, ThresholdStudy},
    },
    ui::{
        command::{Command, Out, PathFor},
        controls::Controls as _,
        numbers::significant,
        pane::{Cx, PaneView},
    },
};

pub use map::MapTexture;

const HEAD_HEIGHT: f32 = 32.0;

#[derive(Default)]
pub struct View {
    texture: MapTexture,
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let project = cx.engine.project();
        if !project.recordings.entries().is_empty() {
            cx.ask(StudyThresholds::of(&cx.engine.request(), project.thresholds()));
        }
        let study = cx.engine.lane::<StudyThresholds>();
        if let Some(problem) = study.problem() {
            ui.fail(problem);
        }
        match study.answer().and_then(|study| Some((study, study.map.as_ref()?))) {
            Some((study, map)) => self.draw(ui, cx, study, map),
            None if study.problem().is_none() => {
                ui.awaited("The map", cx.engine);
            }
            None => {}
        }
    }
}

impl View {
    fn draw(
        &mut self,
        ui: &mut Ui,
        Cx { engine, scope, presents, out, .. }: &mut Cx<'_>,
        study: &ThresholdStudy,
        map: &Arc<ThresholdMap>,
    ) {
        let measure = scope.measure(&map.scale);
        if !*presents {
            head(ui, map, measure, out);
        }
        let marked = (measure, scope.on, study.hysteresis.value);
        map::map(ui, engine, map, marked, &mut self.texture, out);
    }
}

fn head(ui: &mut Ui, map: &Arc<ThresholdMap>, measure: Measure, out: &mut Out) {
    ui.horizontal(|ui| {
        ui.set_height(HEAD_HEIGHT);
        let of = format!("RMSE of {} [{}]", measure.label(&map.scale), measure.unit(&map.scale));
        ui.label(egui::RichText::new(of).size(15.0));
        if !map.is_complete() {
            let (done, all) = (map.n_rows_done(), map.grid.f_ths.len());
            ui.weak(format!("{done} of {all} rows computed"));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let formats =
                MAP_FORMATS.iter().map(|format| format!(".{}: {}", format.ending, format.holds));
            if ui.press("Save as…", formats.collect::<Vec<_>>().join("; ")) {
                let content = FileContent::Thresholds(Arc::clone(map), measure);
                out.send(Command::Choose(PathFor::Save(content)));
            }
            ui.weak("○ present   ◆ lowest   ■ mean hysteresis");
        });
    });
}

/// Returns true if the left mouse button is pressed on the plot. The right button opens the menu.
fn pressed(response: &egui::Response) -> bool {
    response.is_pointer_button_down_on() && response.ctx.input(|input| input.pointer.primary_down())
}

pub fn f_th_text(distance: Distance, f_th: f64) -> String {
    let shown = ShownFTh::of(distance);
    format!("{} {}", significant(shown.factor * f_th, 3), shown.unit)
}

fn pair_text(distance: Distance, thresholds: Thresholds) -> String {
    let t_th = significant(thresholds.t_th_secs, 3);
    format!("{}, {t_th} s", f_th_text(distance, thresholds.f_th))
}
