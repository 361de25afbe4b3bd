//! Choosing thresholds: the map, the curves through the present pair, what it touches, and what is suggested.

mod ages;
mod curves;
mod map;

use crate::app::{AppState, Command, PictureTo, StudyCommand, Wish};
use crate::evaluation::threshold_study::{Measure, ScoreSet, Suggestion, ThresholdMap};
use crate::features::{BLOCKS, Distance, Thresholds};
use crate::ui::fields::Fields;
use crate::ui::numbers::significant;
use crate::ui::picture::screen_part;

pub use map::MapTexture;

/// The share of the height that the ages of the past get beside the curves.
const AGES_SHARE: f32 = 0.26;
/// In a lower pane the curves take it all.
const LEAST_HEIGHT_FOR_AGES: f32 = 340.0;

/// Draws the pane.
pub fn thresholds_pane(
    ui: &mut egui::Ui,
    state: &AppState,
    fields: &mut Fields,
    texture: &mut MapTexture,
    out: &mut Vec<Command>,
) {
    if let Some(problem) = &state.study.problem {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    let (Some(map), Some(measure)) = (&state.study.map, state.study.shown_measure()) else {
        if state.study.problem.is_none() {
            ui.weak("The map appears here as soon as recordings are loaded.");
        }
        return;
    };
    let pane = ui.max_rect();
    choices(ui, map, measure, pane, fields, out);
    suggestion(ui, state, map, measure, out);
    blocks(ui, state, out);
    ui.separator();
    let size = ui.available_size();
    let left = (0.46 * size.x).max(240.0);
    ui.horizontal_top(|ui| {
        ui.vertical(|ui| {
            ui.set_width(left);
            map::map(ui, state, map, measure, fields.study_on, texture, out);
        });
        ui.vertical(|ui| {
            let room = size.y > LEAST_HEIGHT_FOR_AGES;
            let ages_height = if room && state.study.touch.is_some() {
                AGES_SHARE * size.y
            } else {
                0.0
            };
            curves::curves(ui, state, map, size.y - ages_height, out);
            if let Some(touch) = state.study.touch.as_ref().filter(|_| room) {
                let place = [ui.available_width() - 6.0, (ages_height - 8.0).max(60.0)];
                ages::ages(ui, state, touch, place, out);
            }
        });
    });
}

fn choices(
    ui: &mut egui::Ui,
    map: &ThresholdMap,
    measure: Measure,
    pane: egui::Rect,
    fields: &mut Fields,
    out: &mut Vec<Command>,
) {
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Errors of");
        egui::ComboBox::from_id_salt("measure")
            .selected_text(measure_text(map, measure))
            .show_ui(ui, |ui| {
                for one in map.scale.measures() {
                    if ui
                        .selectable_label(one == measure, measure_text(map, one))
                        .clicked()
                    {
                        out.push(Command::Study(StudyCommand::Show(one)));
                        ui.close(); // by a key it would stay
                    }
                }
            })
            .response
            .labelled_by(label.id)
            .on_hover_text("Whose root mean squared error the map is coloured by, and the suggestion chosen by");
        ui.separator();
        for (set, label, explanation) in [
            (
                ScoreSet::LeftOut,
                "Left out",
                "Each training recording by a fit to the others: choose by this one",
            ),
            (
                ScoreSet::Train,
                "Train",
                "The training recordings themselves",
            ),
            (
                ScoreSet::Test,
                "Test",
                "To look at; choosing by it would spend it",
            ),
        ] {
            ui.selectable_value(&mut fields.study_on, set, label)
                .on_hover_text(explanation);
        }
        ui.separator();
        let label = ui.label("Save as");
        let field = egui::TextEdit::singleline(&mut fields.study)
            .hint_text("path ending in .csv, .svg or .png")
            .desired_width(130.0);
        ui.add(field)
            .labelled_by(label.id)
            .on_hover_text("Its ending says as what it is saved");
        let path = fields.study.trim();
        let save = ui.button("Save").on_hover_text(
            ".csv: every number; .svg: the map and its curves; .png: this pane as it is on screen",
        );
        if save.clicked() && !path.is_empty() {
            out.push(if path.to_lowercase().ends_with(".png") {
                let to = PictureTo::Path(path.into());
                Command::Wish(Wish::Picture(screen_part(pane), to))
            } else {
                Command::Study(StudyCommand::Save(path.into()))
            });
        }
        if !map.is_complete() {
            ui.weak(format!(
                "{} of {} rows",
                map.n_rows_done(),
                map.grid.f_ths().len()
            ));
        }
    });
}

/// Whether the first button is held on the plot; the second is for its menu.
fn pressed(response: &egui::Response) -> bool {
    response.is_pointer_button_down_on() && response.ctx.input(|input| input.pointer.primary_down())
}

fn measure_text(map: &ThresholdMap, measure: Measure) -> String {
    format!(
        "{} [{}]",
        measure.label(&map.scale),
        measure.unit(&map.scale)
    )
}

/// F_th as it is shown, with its unit.
fn f_th_text(distance: Distance, f_th: f64) -> String {
    match distance {
        Distance::Force => format!("{} N", significant(f_th, 3)),
        Distance::FullScale => format!("{} % FS", significant(100.0 * f_th, 3)),
    }
}

fn pair_text(distance: Distance, thresholds: Thresholds) -> String {
    let t_th = significant(thresholds.t_th_secs, 3);
    format!("{}, {t_th} s", f_th_text(distance, thresholds.f_th))
}

fn suggestion(
    ui: &mut egui::Ui,
    state: &AppState,
    map: &ThresholdMap,
    measure: Measure,
    out: &mut Vec<Command>,
) {
    ui.horizontal_wrapped(|ui| {
        let take = ui.button("Take the leave-one-out minimum").on_hover_text(
            "Test recordings take no part in it. The range holds the F_th whose left-out error is no more than one standard \
             error over recordings above the minimum",
        );
        if take.clicked() {
            out.push(Command::Study(StudyCommand::TakeSuggestion));
        }
        match map.suggestion(measure) {
            Ok(found) => ui.label(suggestion_text(map, measure, &found)),
            Err(reason) => ui.weak(reason.to_string()),
        };
    });
    ui.horizontal_wrapped(|ui| {
        let hysteresis = state.study.hysteresis.as_ref();
        let value = hysteresis.and_then(|found| found.value);
        let take = egui::Button::new("Take the mean hysteresis");
        let take = ui.add_enabled(value.is_some(), take).on_hover_text(
            "The paper's own rule (section 4.2): F_th near the mean hysteresis, here the mean gap between rising and falling \
             branches of the conventional load over the full cycles of the training recordings",
        );
        if take.clicked() {
            out.push(Command::Study(StudyCommand::TakeHysteresis));
        }
        match (hysteresis, value) {
            (Some(found), Some(value)) => ui.label(format!(
                "{} over {} reversals",
                f_th_text(map.distance, value),
                found.n_reversals
            )),
            (Some(_), None) => ui.weak("the training recordings hold no full cycle of a load to measure it on"),
            (None, _) => ui.weak("is being measured"),
        };
        if let Some(touch) = &state.study.touch {
            ui.separator();
            let age = touch.age_quantile_secs(0.5);
            let age = age.map_or_else(String::new, |age| format!(", half within {} s", significant(age, 2)));
            ui.label(format!(
                "{}: a past for {:.0} %{age}, cut off {:.0} %",
                pair_text(map.distance, state.thresholds()),
                100.0 * touch.share_found(),
                100.0 * touch.share_cut_off(),
            ));
        }
    });
}

fn suggestion_text(map: &ThresholdMap, measure: Measure, found: &Suggestion) -> String {
    let Suggestion {
        thresholds,
        left_out,
        conventional,
        f_th_range,
        n_parts,
        parts_are_blocks,
        ..
    } = found;
    let open = |is_edge: bool| if is_edge { " or beyond" } else { "" };
    let parts = if *parts_are_blocks {
        "blocks"
    } else {
        "recordings"
    };
    let unit = measure.unit(&map.scale);
    let gain = if found.beats_conventional {
        ""
    } else {
        ", no better than Conv. beyond luck"
    };
    format!(
        "{}: {} {unit} (Conv. {}){gain}; F_th from {}{} to {}{} does as well; {n_parts} {parts}",
        pair_text(map.distance, *thresholds),
        significant(*left_out, 4),
        significant(*conventional, 4),
        f_th_text(map.distance, f_th_range.from),
        open(f_th_range.from_is_first_tried && f_th_range.from > 0.0),
        f_th_text(map.distance, f_th_range.to),
        open(f_th_range.to_is_last_tried),
    )
}

fn blocks(ui: &mut egui::Ui, state: &AppState, out: &mut Vec<Command>) {
    ui.horizontal_wrapped(|ui| {
        for block in BLOCKS.iter().copied().filter(|block| block.search().is_some()) {
            let label = format!("Choose {}", block.setting().label.to_lowercase());
            let button = egui::Button::new(label);
            let button = ui.add_enabled(state.study.choosing.is_none(), button).on_hover_text(
                "By leave-one-out over a grid, everything else as it is set; the shortest list that does about as well as the best",
            );
            if button.clicked() {
                out.push(Command::Study(StudyCommand::Choose(block)));
            }
        }
        if state.study.choosing.is_some() {
            ui.spinner();
        } else if let Some(chosen) = &state.study.chosen {
            ui.label(format!(
                "{}: {}; left-out error {}, without {} ({} lists tried)",
                chosen.block.setting().label,
                chosen.block.setting().in_words(&chosen.values),
                significant(chosen.left_out, 4),
                significant(chosen.left_out_without, 4),
                chosen.n_tried
            ));
        }
    });
}
