//! Pane of the check: where the error comes from with a remedy for each cause, and the findings about recordings and rig.

use egui::{Label, Rect, RichText, Ui, Vec2};

use crate::{
    engine::Engine,
    finding::{Face, Verdict},
    questions::{
        budget::{Action, ErrorBudget, Remedy, Row},
        check::{independent_loads::Sufficiency, query::CheckData, rig_figures},
        thresholds::Measure,
    },
    scoring::budget::Cause,
    ui::{
        command::Out,
        controls::{Controls as _, cells, place, place_down, place_right},
        numbers::significant,
        palette::Trace,
        pane::{Cx, PaneView},
        plots::{self, Zoom},
        scope::scale_of,
        strip::{command, percent_left, shares_of, short},
    },
};

const FIGURE_HEIGHT: f32 = 220.0;
/// Width of the list of findings (points), and the share of the pane that it takes at most.
const FINDINGS_WIDTH: f32 = 416.0;
const FINDINGS_SHARE: f32 = 0.38;
const ROW_HEIGHT: f32 = 32.0;
const NAME_WIDTH: f32 = 236.0;
const NUMBER_WIDTH: f32 = 66.0;
const REMEDY_WIDTH: f32 = 230.0;
const SOURCE_WIDTH: f32 = 220.0;
/// Width of a row (points) from which it says what the share is found from.
const WIDTH_WITH_SOURCE: f32 = 1000.0;
const GAP: f32 = 10.0;
const BAR_HEIGHT: f32 = 9.0;

#[derive(Debug, Default)]
pub struct View {
    /// Visible ranges of the plot of the gauges' zeros, and of the plot of their sensitivities.
    zooms: [Zoom; 2],
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        self.draw(ui, cx);
        let project = cx.engine.project();
        if !project.recordings.entries().is_empty() {
            cx.ask(CheckData::of(&cx.engine.request(), project.valid_range()));
        }
    }
}

impl View {
    fn draw(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let check = cx.engine.lane::<CheckData>();
        if let Some(problem) = check.problem() {
            ui.warn(problem);
        }
        let Some(found) = check.answer() else {
            if check.problem().is_none() {
                ui.awaited("The result of the check", cx.engine);
            }
            return;
        };
        let whole = ui.available_rect_before_wrap();
        let width = FINDINGS_WIDTH.min(FINDINGS_SHARE * whole.width());
        let left = whole.with_max_x(whole.right() - width - GAP);
        let right = whole.with_min_x(whole.right() - width);
        // Each part scrolls alone.
        let scrolled = |ui: &mut Ui, rect: Rect, id: &str, contents: &mut dyn FnMut(&mut Ui)| {
            place_down(ui, rect, id, |ui| {
                egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                    ui.set_max_width(rect.width() - GAP);
                    contents(ui);
                });
            });
        };
        scrolled(ui, left, "causes", &mut |ui| self.causes(ui, found, cx));
        scrolled(ui, right, "findings", &mut |ui| findings(ui, found, check.is_current()));
    }

    fn causes(&mut self, ui: &mut Ui, found: &Sufficiency, cx: &mut Cx<'_>) {
        match &found.budget {
            Ok(budget) => budget_table(ui, cx, found, budget),
            Err(reason) => drop(ui.label(format!("The error is not split by cause: {reason}."))),
        }
        ui.add_space(12.0);
        let figures = rig_figures(&found.rig);
        let width = 0.5 * (ui.available_width() - GAP);
        ui.horizontal_top(|ui| {
            for (at, (figure, zoom)) in figures.iter().zip(&mut self.zooms).enumerate() {
                ui.add_space(6.0); // for the label of the vertical axis
                ui.allocate_ui(Vec2::new(width - 12.0, FIGURE_HEIGHT), |ui| {
                    let id = if at == 0 { "zeros" } else { "sensitivities" };
                    plots::plot(ui, (id, None), FIGURE_HEIGHT, |_| figure.clone(), zoom, cx.out);
                });
            }
        });
    }
}

/// Returns the part of the data from which a share is found.
fn found_from(row: Row) -> &'static str {
    match row {
        Row::Cause(cause) => match cause {
            Cause::Curvature => "squares, products of the gauges",
            Cause::Hysteresis => "gauges on rising and falling load",
            Cause::Creep => "slow low-passes of the gauges",
            Cause::Lag => "gauges a moment earlier or later",
            Cause::Zeros => "an offset for each recording",
            Cause::Drift => "a slope in time in each recording",
            Cause::Sensitivity => "a factor for each recording",
            Cause::Temperature => "the auxiliary channels",
        },
        Row::Noise => "changes from sample to sample",
        Row::Unexplained => "the remainder",
        Row::Total => "",
    }
}

/// Returns the places in a row of the budget: name, bars, what the share is found from (empty in a narrow pane), both
/// numbers, and the remedy.
fn columns(row: Rect) -> [Rect; 6] {
    let source = if row.width() < WIDTH_WITH_SOURCE { 0.0 } else { SOURCE_WIDTH };
    let widths = [NAME_WIDTH, f32::INFINITY, source, NUMBER_WIDTH, NUMBER_WIDTH, REMEDY_WIDTH];
    cells(row, GAP, widths)
}

fn budget_table(ui: &mut Ui, cx: &mut Cx<'_>, found: &Sufficiency, budget: &ErrorBudget) {
    let Some(analysis) = cx.engine.analysis() else { return };
    let scale = scale_of(analysis);
    let measure = cx.scope.measure(&scale);
    ui.horizontal_wrapped(|ui| {
        for one in scale.measures().into_iter().filter(|one| *one != Measure::FullScale) {
            let about = "Splits the error of these axes by cause";
            let button = ui.selectable_label(one == measure, one.title(&scale));
            if button.on_hover_text(about).clicked() {
                cx.scope.choose(one);
            }
        }
    });
    let before = &budget.uncompensated;
    let split = |one| Some((one, shares_of(budget, one, measure)?));
    let Some(uncompensated) = split(before) else {
        ui.label("The error of these axes is not split by cause.");
        return;
    };
    let both = [Some(uncompensated), budget.compensated.as_ref().and_then(split)];
    let colors = [Trace::Conventional, Trace::Compensated].map(|trace| trace.color(ui.visuals()));
    let width = ui.available_width();
    let row = |ui: &mut Ui, height: f32| columns(ui.allocate_space(Vec2::new(width, height)).1);
    let [_, _, source_head, before_head, after_head, remedy_head] = row(ui, 24.0);
    for (rect, color) in [before_head, after_head].into_iter().zip(colors) {
        place_right(ui, rect, |ui| ui.colored_label(color, "% FS"));
    }
    place(ui, remedy_head, |ui| ui.weak("Remedy, and the error with it"));
    let has_source = source_head.is_positive();
    if has_source {
        place(ui, source_head, |ui| ui.weak("Found from"));
    }
    let totals = both.iter().flatten().map(|(_, shares)| shares.total);
    let longest = totals.fold(0.0, f64::max).sqrt();
    let (total, parts): (Vec<Row>, Vec<Row>) = Row::all().partition(|row| *row == Row::Total);
    for shown in parts.into_iter().chain(total) {
        let [name_place, bars, source_place, numbers @ .., remedy_place] = row(ui, ROW_HEIGHT);
        let name = RichText::new(shown.name(before));
        let name = if shown == Row::Total { name.strong() } else { name };
        let source = found_from(shown);
        let label = place(ui, name_place, |ui| ui.add(Label::new(name).truncate()));
        if has_source {
            place(ui, source_place, |ui| {
                ui.add(Label::new(RichText::new(source).weak()).truncate())
            });
        } else if !source.is_empty() {
            label.on_hover_text(format!("Found from {source}"));
        }
        let middle = bars.center().y;
        for (at, (budget_and_shares, number)) in both.iter().zip(numbers).enumerate() {
            let Some((one, shares)) = budget_and_shares else { continue };
            let square = shown.square(shares);
            let text = RichText::new(shown.cell(one, shares).text);
            let text = if square > 0.0 { text } else { text.weak().size(11.0) };
            place_right(ui, number, |ui| ui.label(text));
            let length = (square.max(0.0).sqrt() / longest) as f32 * bars.width();
            let top = middle + [-BAR_HEIGHT - 0.5, 0.5][at];
            let corner = egui::pos2(bars.left(), top);
            let bar = Rect::from_min_size(corner, Vec2::new(length, BAR_HEIGHT));
            ui.painter().rect_filled(bar, 1.0, colors[at]);
        }
        let is_for = |remedy: &&Remedy| {
            shown
                == match (remedy.cause, &remedy.action) {
                    (Some(cause), _) => Row::Cause(cause),
                    (None, Action::Mean(_)) => Row::Noise,
                    (None, Action::RecordTemperature) => Row::Cause(Cause::Temperature),
                    (None, _) => Row::Unexplained,
                }
        };
        if let Some(remedy) = found.remedies.iter().find(is_for) {
            place(ui, remedy_place, |ui| {
                remedy_cell(ui, cx.engine, remedy, budget, measure, cx.out)
            });
        }
    }
    for sentence in budget.sentences() {
        ui.add(Label::new(RichText::new(sentence).weak()).wrap());
    }
}

fn remedy_cell(
    ui: &mut Ui,
    engine: &Engine,
    remedy: &Remedy,
    budget: &ErrorBudget,
    measure: Measure,
    out: &mut Out,
) {
    let name = short(remedy, engine);
    let about = remedy.text(&remedy.action.words(), budget);
    match command(remedy, engine) {
        Some(command) => {
            if ui.press(name, about) {
                out.send(command);
            }
        }
        None => drop(ui.label(name).on_hover_text(about)),
    }
    if let Some(error) = percent_left(remedy, budget, measure) {
        ui.label(format!("→ {} % FS", significant(error, 3)));
    }
}

/// Draws the verdict on the recordings and the findings, those to act on first.
fn findings(ui: &mut Ui, found: &Sufficiency, is_current: bool) {
    let words = RichText::new(found.verdict.words()).strong().size(15.0);
    let words = match found.verdict {
        Verdict::Enough => words,
        Verdict::Doubtful => words.color(ui.visuals().warn_fg_color),
        Verdict::Insufficient => words.color(ui.visuals().error_fg_color),
    };
    ui.add(Label::new(words).wrap());
    if !is_current {
        ui.weak("updating");
    }
    for sentence in found.sentences(Face::Window) {
        ui.add_space(6.0);
        ui.add(Label::new(format!("• {sentence}.")).wrap());
    }
    ui.add_space(6.0);
    ui.add(Label::new(&found.holds_for).wrap());
    ui.add_space(6.0);
    ui.add(Label::new(RichText::new(found.rank_in_words()).weak()).wrap());
}
