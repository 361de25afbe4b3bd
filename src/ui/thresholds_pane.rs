//! Pane of the thresholds: the map of the error for pairs of force threshold F_th and time threshold t_th, and the proposed
//! pairs.

mod map;

use std::sync::Arc;

use egui::Ui;

use crate::{
    engine::{Action, Edit, Engine, FileContent, Level, query::Background as _},
    features::{BLOCKS, Distance, Thresholds},
    finding::Face,
    questions::thresholds::{
        MAP_FORMATS, Measure, ShownFTh, ThresholdMap,
        asked::{ChooseBlock, StudyThresholds, ThresholdStudy},
    },
    ui::{
        command::{Command, Out, Pane},
        controls::Controls as _,
        numbers::significant,
        pane::{Cx, PaneView},
        status_line::busy,
    },
};

pub use map::MapTexture;

pub const PANE: Pane = Pane {
    key: "thresholds",
    title: "Thresholds",
    explanation: "Map of the error for pairs of force threshold F_th and time threshold t_th, and the proposed pairs",
};

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
            choices(ui, map, measure, out);
            if let Some(lag) = &study.lag {
                ui.warn(lag.text(Face::Window));
            }
            suggestion(ui, engine, study, measure, out);
            blocks(ui, engine, measure, out);
            ui.separator();
        }
        map::map(ui, engine, map, measure, scope.on, &mut self.texture, out);
    }
}

fn choices(ui: &mut Ui, map: &Arc<ThresholdMap>, measure: Measure, out: &mut Out) {
    ui.horizontal_wrapped(|ui| {
        ui.strong(format!("Error of {}", measure_text(map, measure)));
        let formats =
            MAP_FORMATS.iter().map(|format| format!(".{}: {}", format.ending, format.holds));
        if ui.press("Save as…", formats.collect::<Vec<_>>().join("; ")) {
            let content = FileContent::Thresholds(Arc::clone(map), measure);
            out.send(Command::ChooseFileFor(content));
        }
        if !map.is_complete() {
            ui.weak(format!(
                "{} of {} rows of the map computed",
                map.n_rows_done(),
                map.grid.f_ths.len()
            ));
        }
    });
}

/// Returns true if the left mouse button is pressed on the plot. The right button opens the menu.
fn pressed(response: &egui::Response) -> bool {
    response.is_pointer_button_down_on() && response.ctx.input(|input| input.pointer.primary_down())
}

fn measure_text(map: &ThresholdMap, measure: Measure) -> String {
    format!("{} [{}]", measure.label(&map.scale), measure.unit(&map.scale))
}

fn f_th_text(distance: Distance, f_th: f64) -> String {
    let shown = ShownFTh::of(distance);
    format!("{} {}", significant(shown.factor * f_th, 3), shown.unit)
}

fn pair_text(distance: Distance, thresholds: Thresholds) -> String {
    let t_th = significant(thresholds.t_th_secs, 3);
    format!("{}, {t_th} s", f_th_text(distance, thresholds.f_th))
}

fn suggestion(
    ui: &mut Ui,
    engine: &Engine,
    study: &ThresholdStudy,
    measure: Measure,
    out: &mut Out,
) {
    let Some(map) = &study.map else { return };
    ui.horizontal_wrapped(|ui| {
        let is_complete = map.is_complete();
        let found = map.suggestion(measure);
        if ui.press_if(
            is_complete,
            "Take the cross-validation minimum",
            "Sets the pair of thresholds F_th and t_th with the smallest cross-validated error; test recordings are not used. The text beside the button gives the range of F_th whose error is not significantly larger than the minimum (90 % confidence)",
        ) {
            out.send(match &found {
                Ok(found) => Edit::Thresholds(found.thresholds).into(),
                Err(reason) => Command::tell(Level::Error, reason.to_string()),
            });
        }
        match found {
            Ok(_) if !is_complete => {
                let (done, all) = (map.n_rows_done(), map.grid.f_ths.len());
                ui.weak(format!("{done} of {all} rows of the map are computed; the minimum is known after the last row"))
            }
            Ok(found) => ui.label(format!("{}; {}", found.in_words(map, measure), found.ranges_in_words(map.distance))),
            Err(reason) => ui.weak(reason.to_string()),
        };
    });
    ui.horizontal_wrapped(|ui| {
        let value = study.hysteresis.value;
        let is_taken = ui.press_if(
            value.is_some(),
            "Set F_th to the mean hysteresis",
            "Sets F_th near the mean hysteresis, by the rule of Koike et al. (2019), section 4.2. The mean hysteresis is the mean difference between rising and falling branches of the conventional load in the full cycles of the training recordings",
        );
        if let Some(f_th) = value.filter(|_| is_taken) {
            let present = engine.project().thresholds();
            out.send(Edit::Thresholds(Thresholds { f_th, ..present }));
        }
        let words = study.hysteresis.in_words(|value| f_th_text(map.distance, value));
        if study.hysteresis.rests_on_few() {
            ui.weak(words);
        } else {
            ui.label(words);
        }
        ui.separator();
        let pair = pair_text(map.distance, engine.project().thresholds());
        ui.label(format!("{pair}: {}", study.past_ages));
    });
}

fn blocks(ui: &mut Ui, engine: &Engine, measure: Measure, out: &mut Out) {
    let choice = engine.lane::<ChooseBlock>();
    let choosing = !choice.is_idle();
    ui.horizontal_wrapped(|ui| {
        for block in BLOCKS.iter().copied().filter(|block| block.search().is_some()) {
            let label = format!("Choose {}", block.setting().label.to_lowercase());
            if ui.press_if(
                !choosing,
                label,
                "Tries lists of values of this feature by cross-validation, with all other settings unchanged. Chooses the shortest list whose error is within 1 % of the smallest error",
            ) {
                out.send(Action::ChooseBlock(block, Some(measure)));
            }
        }
        if choosing {
            busy(ui);
        } else if let Some(chosen) = choice.answer() {
            ui.label(format!(
                "{}: {}; cross-validated error {}, without this feature {} ({} lists of values were tried)",
                chosen.block.setting().label,
                chosen.block.setting().in_words(&chosen.values),
                significant(chosen.left_out, 4),
                significant(chosen.left_out_without, 4),
                chosen.n_tried
            ));
        }
    });
}
