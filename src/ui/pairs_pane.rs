//! Pairs of thresholds that are proposed: the pair of lowest cross-validated error, and the mean hysteresis.

use egui::{Align, Button, Label, Layout, RichText, Ui};

use crate::{
    engine::{Edit, Engine},
    features::Thresholds,
    finding::Face,
    questions::thresholds::{
        ShownFTh, ThresholdMap,
        asked::{StudyThresholds, ThresholdStudy},
    },
    scoring::score_set::ScoreSet,
    ui::{
        command::Out,
        controls::{Controls as _, named},
        numbers::significant,
        pane::{Cx, PaneView},
        scope::Scope,
        thresholds_pane::f_th_text,
    },
};

const ROW_HEIGHT: f32 = 46.0;
const BUTTON_WIDTH: f32 = 64.0;

#[derive(Debug, Default)]
pub struct View;

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let study = cx.engine.lane::<StudyThresholds>();
        let Some((study, map)) =
            study.answer().and_then(|study| Some((study, study.map.as_ref()?)))
        else {
            ui.awaited("The list", cx.engine);
            return;
        };
        ui.scrolled(|ui| {
            lowest(ui, cx.engine, map, cx.scope, cx.out);
            mean_hysteresis(ui, cx.engine, (study, map), cx.scope, cx.out);
            let found = RichText::new(study.past_ages.to_string()).weak();
            ui.add(Label::new(found).wrap());
            if let Some(lag) = &study.lag {
                ui.warn(lag.text(Face::Window));
            }
        });
    }
}

/// One proposed pair in words.
struct Proposed {
    mark: &'static str,
    name: &'static str,
    error: String,
    words: String,
    /// The same in more words; empty if there are none.
    hover: String,
    about: &'static str,
    pair: Option<Thresholds>,
}

fn row(ui: &mut Ui, engine: &Engine, shown: Proposed, out: &mut Out) {
    ui.horizontal(|ui| {
        ui.set_height(ROW_HEIGHT);
        ui.label(RichText::new(shown.mark).size(15.0));
        let width = ui.available_width() - BUTTON_WIDTH - 16.0;
        ui.allocate_ui_with_layout(
            egui::vec2(width, ROW_HEIGHT),
            Layout::top_down(Align::Min),
            |ui| {
                ui.set_width(width);
                ui.spacing_mut().item_spacing.y = 1.0;
                ui.label(format!("{}  {}", shown.name, shown.error));
                let words = Label::new(RichText::new(&shown.words).weak());
                let hover = if shown.hover.is_empty() { &shown.words } else { &shown.hover };
                ui.add(words.truncate()).on_hover_text(hover);
            },
        );
        let is_used = shown.pair == Some(engine.project().thresholds())
            && !engine.project().settings.features.look_backs.is_empty();
        let can = shown.pair.is_some() && !is_used;
        let button = Button::new(if is_used { "In use" } else { "Use" });
        let button = ui.add_enabled(can, button.min_size(egui::vec2(BUTTON_WIDTH, 28.0)));
        named(&button, egui::Role::Button, &format!("Use: {}", shown.name));
        let button = button.on_hover_text(shown.about).on_disabled_hover_text(shown.about);
        if let (true, Some(pair)) = (button.clicked(), shown.pair) {
            out.send(Edit::Thresholds(pair));
        }
    });
}

fn lowest(ui: &mut Ui, engine: &Engine, map: &ThresholdMap, scope: &Scope, out: &mut Out) {
    let measure = scope.measure(&map.scale);
    let mut shown = Proposed {
        mark: "◆",
        name: "Lowest error",
        error: String::new(),
        words: String::new(),
        hover: String::new(),
        about: "Sets the pair with the lowest cross-validated error. The range holds all F_th whose error is not significantly larger (90 % confidence)",
        pair: None,
    };
    if map.is_complete() {
        match map.suggestion(measure) {
            Ok(found) => {
                let unit = measure.unit(&map.scale);
                shown.error = format!("{} {unit}", significant(found.left_out, 3));
                let in_units = ShownFTh::of(map.distance);
                let range = found.f_th_range.in_words(|f_th| in_units.text(f_th));
                let pair = found.thresholds;
                let t_th = significant(pair.t_th_secs, 3);
                let f_th = f_th_text(map.distance, pair.f_th);
                shown.words = format!("{f_th}, {t_th} s; as good: {range}");
                if found.beats_conventional {
                    shown.pair = Some(pair);
                } else {
                    shown.words =
                        "not clearly below the uncompensated error in all parts".to_owned();
                }
            }
            Err(reason) => shown.words = reason.to_string(),
        }
    } else {
        let (done, all) = (map.n_rows_done(), map.grid.f_ths.len());
        shown.words = format!("known after all rows of the map ({done} of {all})");
    }
    row(ui, engine, shown, out);
}

fn mean_hysteresis(
    ui: &mut Ui,
    engine: &Engine,
    (study, map): (&ThresholdStudy, &ThresholdMap),
    scope: &Scope,
    out: &mut Out,
) {
    let measure = scope.measure(&map.scale);
    let present = engine.project().thresholds();
    let pair = study.hysteresis.value.map(|f_th| Thresholds { f_th, ..present });
    let error = pair.and_then(|pair| {
        let (f_at, t_at) = map.nearest(pair);
        let error = map.value(ScoreSet::LeftOut, measure, f_at, t_at)?;
        Some(format!("{} {}", significant(error, 3), measure.unit(&map.scale)))
    });
    let shown = Proposed {
        mark: "■",
        name: "Mean hysteresis",
        error: error.unwrap_or_default(),
        words: match study.hysteresis.value {
            Some(f_th) => {
                format!("{}, the rule of the paper", f_th_text(map.distance, f_th))
            }
            None => "not measured: no load rises and falls again".to_owned(),
        },
        hover: study.hysteresis.in_words(|value| f_th_text(map.distance, value)),
        about: "Sets F_th near the mean hysteresis, the mean difference between rising and falling branches of the conventional load (rule of Koike et al. 2019, section 4.2)",
        pair,
    };
    row(ui, engine, shown, out);
}
