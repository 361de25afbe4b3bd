//! Pane with the errors of each axis, which also chooses the axes that the traces show.

use egui::{Label, Rect, RichText, Sense, Ui, Vec2};

use crate::{
    engine::Engine,
    finding::Face,
    questions::{Analysis, AxisTraces, expected_error::query::AskExpectedError},
    scoring::score_set::ScoreSet,
    ui::{
        command::{Command, Out},
        controls::{Controls as _, cells, named_selected, place as place_in, place_right},
        numbers::significant,
        palette::Trace,
        pane::{Cx, PaneView},
        scope::{AxisChoice, Errors, Scope},
        small_plot::{over_samples, range},
    },
};

/// Heights of a row (points): in a window of at least this height, and in a lower one.
const ROW_HEIGHTS: (f32, f32, f32) = (40.0, 880.0, 34.0);
const AXIS_WIDTH: f32 = 58.0;
const NUMBER_WIDTH: f32 = 54.0;
const CHANGE_WIDTH: f32 = 46.0;
const GAP: f32 = 6.0;

#[derive(Debug, Default)]
pub struct View;

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        errors_pane(ui, cx.engine, cx.scope, cx.out);
        // While a slider is dragged, the pane keeps the expected error of the previous settings.
        if let Some((of, analysis)) = cx.engine.exact().filter(|_| cx.engine.gesture.is_none())
            && cx.engine.is_current()
        {
            cx.ask(AskExpectedError::of(of, analysis));
        }
    }
}

fn errors_pane(ui: &mut Ui, engine: &Engine, scope: &mut Scope, out: &mut Out) {
    ui.take_available_width();
    let Some(analysis) = engine.analysis() else {
        ui.weak("No calibration is fitted yet.");
        return;
    };
    ui.horizontal(|ui| {
        let sets = [ScoreSet::LeftOut, ScoreSet::Test, ScoreSet::Train];
        for set in sets {
            ui.select(&mut scope.on, set, set.title(), set.explanation());
        }
    });
    let quality = &analysis.calibration.quality;
    let words = match (&quality.cross_validation, Errors::of(analysis, scope.on)) {
        _ if !analysis.fitted => "Errors of the loaded calibration".to_owned(),
        (_, Some(errors)) if errors.on != scope.on => {
            let reason = scope.on.missing(analysis.calibration.no_cross_validation());
            format!("{} ({reason})", errors.on.title())
        }
        (Some(how), Some(errors)) if errors.on == ScoreSet::LeftOut => {
            format!("CV {how}")
        }
        _ => String::new(),
    };
    ui.add(Label::new(RichText::new(words).weak()).truncate());
    ui.scrolled(|ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        table(ui, engine, analysis, scope, out);
        ui.add_space(6.0);
        for found in &analysis.findings {
            let text = RichText::new(&found.seen).color(ui.visuals().warn_fg_color);
            ui.add(Label::new(text).wrap()).on_hover_text(found.text(Face::Window));
        }
    });
}

/// Returns the places of the columns of a row: the axis, the small plot, both errors, their change and the expected error.
fn columns(row: Rect) -> [Rect; 6] {
    let widths =
        [AXIS_WIDTH, f32::INFINITY, NUMBER_WIDTH, NUMBER_WIDTH, CHANGE_WIDTH, NUMBER_WIDTH];
    cells(row.shrink2(Vec2::new(GAP, 0.0)), GAP, widths)
}

fn table(ui: &mut Ui, engine: &Engine, analysis: &Analysis, scope: &Scope, out: &mut Out) {
    let (_, head) = ui.allocate_space(Vec2::new(ui.available_width(), 22.0));
    let [_, _, heads @ ..] = columns(head);
    let visuals = ui.visuals().clone();
    let [before, after] =
        [Trace::Conventional, Trace::Compensated].map(|trace| trace.color(&visuals));
    let weak = visuals.weak_text_color();
    let about = "Load error within which 95 % of the held-out errors lie";
    let titles = [("Uncomp.", before), ("Comp.", after), ("change", weak), ("95 %", weak)];
    for ((title, color), place) in titles.into_iter().zip(heads) {
        let label = place_right(ui, place, |ui| ui.colored_label(color, title));
        if title == "95 %" {
            label.on_hover_text(about);
        }
    }
    let errors = Errors::of(analysis, scope.on);
    let expected =
        engine.lane::<AskExpectedError>().answer().and_then(|answer| answer.as_ref().ok());
    let (tall, least, low) = ROW_HEIGHTS;
    let height = if ui.ctx().content_rect().height() >= least { tall } else { low };
    for (at, axis) in analysis.calibration.axes.iter().enumerate() {
        let size = Vec2::new(ui.available_width(), height);
        let (place, row) = ui.allocate_exact_size(size, Sense::click());
        let [name, plot, numbers @ ..] = columns(place);
        let is_shown = scope.axes().contains(axis);
        named_selected(&row, egui::Role::RadioButton, is_shown, &axis.label());
        let row = row.on_hover_text("Shows the traces of this axis; Shift adds or removes it");
        if is_shown {
            ui.painter().rect_filled(place, 4.0, visuals.selection.bg_fill);
        } else if row.hovered() || row.has_focus() {
            ui.painter().rect_filled(place, 4.0, visuals.widgets.hovered.weak_bg_fill);
        }
        let color = if is_shown { visuals.selection.stroke.color } else { visuals.text_color() };
        place_in(ui, name, |ui| {
            ui.add(Label::new(RichText::new(axis.label()).color(color)).selectable(false));
        });
        if let Some(traces) = analysis.traces.axes.iter().find(|traces| traces.axis == *axis) {
            errors_over_time(ui, traces, plot.shrink2(Vec2::new(0.0, 3.0)));
        }
        let pair = errors
            .as_ref()
            .and_then(|errors| Some((*errors.before.get(at)?, *errors.after.get(at)?)));
        let texts = [
            pair.map(|(before, _)| significant(before, 4)),
            pair.map(|(_, after)| significant(after, 4)),
            errors.as_ref().and_then(|errors| errors.change(at)),
            expected
                .and_then(|expected| expected.axes.get(at)?.value)
                .map(|value| significant(value, 3)),
        ];
        for (text, place) in texts.into_iter().zip(numbers) {
            let text = RichText::new(text.unwrap_or_else(|| "–".to_owned())).color(color);
            place_right(ui, place, |ui| ui.add(Label::new(text).selectable(false)));
        }
        if row.clicked() {
            let adds = ui.input(|input| input.modifiers.shift);
            let choice = if adds { AxisChoice::Toggle(at) } else { AxisChoice::Only(at) };
            out.send(Command::Axes(choice));
        }
    }
}

/// Draws the errors over the whole time, as thin lines about zero.
fn errors_over_time(ui: &Ui, axis: &AxisTraces, place: Rect) {
    let lines = [Trace::Conventional, Trace::Compensated];
    let lines = lines.into_iter().filter_map(|trace| Some((trace, axis.error(trace)?)));
    let lines: Vec<_> =
        lines.map(|(trace, series)| (trace.color(ui.visuals()), &**series)).collect();
    let (low, high) = range(lines.iter().map(|(_, series)| *series));
    let largest = high.max(-low);
    over_samples(ui, place, (-largest, largest), &lines);
}
