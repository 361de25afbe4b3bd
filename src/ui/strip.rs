//! The answer in one line: the error before and after the compensation with its causes as two bars, a sentence, and the
//! remedy that lowers the error that is left.

use std::time::Duration;

use egui::{Button, ComboBox, Rect, RichText, Sense, Ui, Vec2};

use crate::{
    calibration::{FitSettings, Regressor},
    engine::{Action as Do, Edit, Engine, SEARCH_MINUTES},
    features::{BLOCKS, Block, FeatureSettings},
    questions::{
        Analysis, Candidates,
        budget::{Action, ErrorBudget, Remedy},
        check::{independent_loads::Sufficiency, query::CheckData},
        thresholds::{Measure, MeasureScale},
    },
    recording::{Role, Tare},
    scoring::{
        budget::{Budget, Shares},
        score_set::ScoreSet,
    },
    ui::{
        bars,
        choice::choice,
        command::{Command, Out, Workspace},
        controls::{named, place, place_down},
        numbers::significant,
        palette::Trace,
        pane::Cx,
        scope::{Errors, Scope, percent_change, scale_of},
    },
};

pub const HEIGHT: f32 = 44.0;
const SCOPE_WIDTH: f32 = 136.0;
const NAMES_WIDTH: f32 = 104.0;
const FIGURES_WIDTH: f32 = 76.0;
const REMEDY_WIDTH: f32 = 168.0;
/// Number of characters up to which a remedy and its error stand in one line of the button.
const SHORT_REMEDY: usize = 12;
const BAR_HEIGHT: f32 = 16.0;
/// Widths of the sentence (points) below which its letters are smaller, and below which it is two figures.
const NARROW_SENTENCE: f32 = 440.0;
const LEAST_SENTENCE: f32 = 360.0;
const GAP: f32 = 12.0;
/// Widths of the window (points) from which the bars have these widths.
const BARS: [(f32, f32); 3] = [(1500.0, 520.0), (1200.0, 320.0), (0.0, 180.0)];
/// Opacity of figures that belong to earlier settings.
pub const OLD: f32 = 0.6;

/// Ratio of the compensated to the uncompensated error above which a compensation brings nothing, and above which it does harm.
const BRINGS_NOTHING: f64 = 0.98;
const MAKES_WORSE: f64 = 1.05;
const SWITCH_OFF: &str = "Switches all features and the nonlinear model off, because they do not lower the error of the held-out samples";

/// Ratios of the compensated to the uncompensated error, and words for the part that is left.
const LEFT: [(f64, &str); 5] = [
    (0.1, "a tenth"),
    (0.2, "a fifth"),
    (0.25, "a quarter"),
    (0.333, "a third"),
    (0.4, "two fifths"),
];

pub fn strip(ui: &mut Ui, cx: &mut Cx<'_>) {
    let rect = ui.max_rect().shrink2(Vec2::new(8.0, 0.0));
    let Some(analysis) = cx.engine.analysis() else {
        place(ui, rect, |ui| ui.weak("Nothing to compare yet"));
        return;
    };
    let project = cx.engine.project();
    if cx.engine.gesture.is_none() && cx.engine.is_current() && project.missing().is_none() {
        cx.ask(CheckData::of(&cx.engine.request(), project.valid_range()));
    }
    let scale = scale_of(analysis);
    let Some(errors) = Errors::of(analysis, cx.scope.on) else {
        place(ui, rect, |ui| ui.weak("No reference load: there is nothing to compare with"));
        return;
    };
    let wide = ui.ctx().content_rect().width();
    let width = BARS.iter().find(|(least, _)| wide >= *least).map_or(0.0, |(_, width)| *width);
    let mut left = rect.left();
    let mut next = |width: f32| {
        let place = Rect::from_x_y_ranges(left..=left + width, rect.y_range());
        left += width + GAP;
        place
    };
    let (scope, names, area, figures) =
        (next(SCOPE_WIDTH), next(NAMES_WIDTH), next(width), next(FIGURES_WIDTH));
    let remedy_place =
        Rect::from_x_y_ranges(rect.right() - REMEDY_WIDTH..=rect.right(), rect.y_range());
    let sentence =
        Rect::from_x_y_ranges(figures.right() + GAP..=remedy_place.left() - GAP, rect.y_range());
    place(ui, scope, |ui| scope_menu(ui, cx.scope, &scale));
    let measure = cx.scope.measure(&scale);
    let lane = cx.engine.lane::<CheckData>();
    let found = lane.answer();
    let is_old = !cx.engine.is_current() || found.is_some() && !lane.is_current();
    ui.scope(|ui| {
        if is_old {
            ui.multiply_opacity(OLD);
        }
        let calibration = &analysis.calibration;
        let is_compensated = calibration.learned.is_some() || calibration.features.adds_columns();
        let compared = Compared { scale: &scale, measure, errors: &errors, is_compensated };
        let budget = found.and_then(|found| found.budget.as_ref().ok());
        two_bars(
            ui,
            &compared,
            budget.filter(|_| errors.on == ScoreSet::LeftOut),
            (names, area, figures),
            cx.out,
        );
        sentences(ui, &compared, analysis, budget, sentence);
    });
    let budget = found.and_then(|found| found.budget.as_ref().ok());
    let offered = match (offer(found, cx.engine), budget) {
        (Some(Offer::Remedy(remedy)), Some(budget)) => {
            let error = percent_left(remedy, budget, measure);
            let remedy_name = short(remedy, cx.engine);
            let text = match error.map(|error| format!("→ {} % FS", significant(error, 2))) {
                Some(error) if remedy_name.chars().count() > SHORT_REMEDY => {
                    format!("{remedy_name}\n{error}")
                }
                Some(error) => format!("{remedy_name} {error}"),
                None => remedy_name,
            };
            Some((text, format!("Remedy for {}", remedy.text(&remedy.action.words(), budget))))
        }
        (Some(Offer::Off(_)), _) => Some(("Switch it off".to_owned(), SWITCH_OFF.to_owned())),
        _ => None,
    };
    if let Some((text, about)) = offered {
        let height = if text.contains('\n') { 38.0 } else { 28.0 };
        let button = Button::new(RichText::new(text).color(ui.visuals().selection.stroke.color));
        let button = button.fill(ui.visuals().selection.bg_fill).wrap();
        let press = |ui: &mut Ui| ui.add_sized([REMEDY_WIDTH, height], button);
        let pressed = place(ui, remedy_place, press).on_hover_text(format!("{about} (R)"));
        if pressed.clicked() {
            cx.out.0.extend(remedy(cx.engine));
        }
    }
}

fn scope_menu(ui: &mut Ui, scope: &mut Scope, scale: &MeasureScale) {
    let measure = scope.measure(scale);
    let sets = [ScoreSet::LeftOut, ScoreSet::Test, ScoreSet::Train];
    let measures = scale.measures();
    let all = measures.iter().flat_map(|measure| sets.map(|on| (*measure, on)));
    let mut chosen = (measure, scope.on);
    let described = |(measure, on): (Measure, ScoreSet)| {
        (format!("{}, {}", measure.title(scale), on.title()), on.explanation())
    };
    let button = ComboBox::from_id_salt("scope").width(SCOPE_WIDTH - 8.0).truncate();
    let about =
        "Axes and samples whose errors the bars, the sentence, the sliders and the map show";
    choice(ui, button, &mut chosen, all, described).on_hover_text(about);
    if chosen != (measure, scope.on) {
        scope.choose(chosen.0);
        scope.on = chosen.1;
    }
}

/// What is compared: the errors of these axes before and after the compensation.
struct Compared<'a> {
    scale: &'a MeasureScale,
    measure: Measure,
    errors: &'a Errors<'a>,
    is_compensated: bool,
}

impl Compared<'_> {
    /// Returns both errors in the unit of the axes.
    fn in_units(&self) -> Option<[f64; 2]> {
        let of = |rmse: &[f64]| self.measure.of_rmse(self.scale, rmse);
        Some([of(self.errors.before)?, of(self.errors.after)?])
    }

    /// Returns both errors in % of full scale.
    fn in_percent(&self) -> Option<[f64; 2]> {
        let weights = self.measure.weights(self.scale)?;
        let n = weights.iter().filter(|weight| **weight > 0.0).count();
        let percent = |rmse: &[f64]| {
            let axes = rmse.iter().zip(&self.scale.full_scale).zip(&weights);
            let counted = axes.filter(|((_, full), weight)| **weight > 0.0 && **full > 0.0);
            let squares = counted.map(|((rmse, full), _)| (rmse / full).powi(2));
            100.0 * (squares.sum::<f64>() / n.max(1) as f64).sqrt()
        };
        Some([percent(self.errors.before), percent(self.errors.after)])
    }
}

/// Returns the place of the pool of these axes; `None` for one axis, and for forces and moments together.
fn pool_of(of: &ErrorBudget, measure: Measure) -> Option<usize> {
    let named = |name: &str| of.pools.iter().position(|pool| *pool == name);
    match measure {
        Measure::Forces => named("Forces"),
        Measure::Moments => named("Moments"),
        Measure::FullScale => (of.pools.len() == 1).then_some(0),
        Measure::Axis(_) => None,
    }
}

/// Returns the shares of these axes in a budget.
pub fn shares_of<'a>(of: &ErrorBudget, budget: &'a Budget, measure: Measure) -> Option<&'a Shares> {
    let shares = match measure {
        Measure::Axis(at) => budget.axes.get(at)?,
        _ => budget.pools.get(pool_of(of, measure)?)?,
    };
    shares.as_ref().ok()
}

/// Returns the error of these axes with a remedy, in % of full scale; `None` if it is not known for them.
pub fn percent_left(remedy: &Remedy, of: &ErrorBudget, measure: Measure) -> Option<f64> {
    Some(100.0 * remedy.errors.get(pool_of(of, measure)?)?)
}

fn two_bars(
    ui: &mut Ui,
    compared: &Compared<'_>,
    of: Option<&ErrorBudget>,
    (names, area, figures): (Rect, Rect, Rect),
    out: &mut Out,
) {
    let Some(percent) = compared.in_percent() else { return };
    let longest = percent[0].max(percent[1]);
    let budgets = of.map(|of| [Some(&of.uncompensated), of.compensated.as_ref()]);
    let parts: [Vec<bars::Part>; 2] = [0, 1].map(|at| {
        let budget = budgets.and_then(|budgets| budgets[at]);
        let shares =
            budget.and_then(|budget| Some((shares_of(of?, budget, compared.measure)?, budget)));
        shares.map_or_else(Vec::new, |(shares, budget)| bars::parts(shares, budget))
    });
    let bright = bars::largest(&parts[1]).or(bars::largest(&parts[0]));
    let middle = area.center().y;
    let tops = [middle - BAR_HEIGHT - 2.0, middle + 2.0];
    let visuals = ui.visuals().clone();
    let outputs = [Trace::Conventional, Trace::Compensated];
    let mut about = Vec::new();
    for (at, trace) in outputs.into_iter().enumerate() {
        let row =
            |rect: Rect| Rect::from_x_y_ranges(rect.x_range(), tops[at]..=tops[at] + BAR_HEIGHT);
        let color = trace.color(&visuals);
        place(ui, row(names), |ui| ui.label(RichText::new(trace.label()).color(color)));
        if at == 1 && !compared.is_compensated {
            continue;
        }
        let whole = row(area);
        let length = (percent[at] / longest.max(f64::MIN_POSITIVE)) as f32;
        let bar = whole.with_max_x(whole.left() + length * whole.width());
        bars::bar(ui.painter(), bar, &parts[at], bright, color, &visuals);
        let figure = format!("{} % FS", significant(percent[at], 3));
        let causes =
            parts[at].iter().map(|part| format!("{} {:.0} %", part.name, 100.0 * part.share));
        about.push(format!(
            "{}: {figure}. {}",
            trace.label(),
            causes.collect::<Vec<_>>().join(", ")
        ));
        place(ui, row(figures), |ui| ui.label(figure));
    }
    let about = format!(
        "{}. Shares of the mean squared error. Press for the whole table",
        about.join("\n")
    );
    let bars = ui.interact(area, ui.scope_id().with("bars"), Sense::click()).on_hover_text(&about);
    named(&bars, egui::Role::Button, &about);
    if bars.clicked() {
        out.send(Command::Show(Workspace::Check));
    }
}

fn sentences(
    ui: &mut Ui,
    compared: &Compared<'_>,
    analysis: &Analysis,
    budget: Option<&ErrorBudget>,
    rect: Rect,
) {
    let Some(errors) = compared.in_units() else { return };
    let unit = compared.measure.unit(compared.scale);
    let first = if compared.is_compensated {
        result(errors, unit)
    } else {
        format!("Without compensation the error is {} {unit}.", significant(errors[0], 3))
    };
    let left = budget.and_then(|of| {
        let budget = of.compensated.as_ref().filter(|_| compared.is_compensated);
        let budget = budget.unwrap_or(&of.uncompensated);
        of.mostly(shares_of(of, budget, compared.measure)?, budget)
    });
    let second = match (left, compared.is_compensated) {
        (Some(left), true) => format!("What is left is mostly {left}."),
        (Some(left), false) => format!("It is mostly {left}."),
        (None, _) => match &analysis.calibration.quality.cross_validation {
            Some(how) if compared.errors.on == ScoreSet::LeftOut => {
                format!("CV {how}.")
            }
            _ => format!("Errors on the {} samples.", compared.errors.on.label()),
        },
    };
    let is_worse = compared.is_compensated && errors[1] > 1.05 * errors[0];
    let rect = Rect::from_center_size(rect.center(), Vec2::new(rect.width(), 38.0));
    place_down(ui, rect, "sentences", |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        let visuals = ui.visuals();
        let color = if is_worse { visuals.warn_fg_color } else { visuals.strong_text_color() };
        let size = if rect.width() < NARROW_SENTENCE { 13.0 } else { 15.0 };
        let is_least = rect.width() < LEAST_SENTENCE;
        let shown = if is_least && compared.is_compensated {
            let change = percent_change(errors[0], errors[1]).unwrap_or_default();
            format!("{} ({change})", figures(errors, unit))
        } else {
            first.clone()
        };
        let shown = egui::Label::new(RichText::new(shown).size(size).color(color));
        ui.add(shown.truncate()).on_hover_text(first);
        let second = RichText::new(second).weak().size(if is_least { 12.0 } else { 13.0 });
        ui.add(egui::Label::new(second).truncate());
    });
}

fn figures([before, after]: [f64; 2], unit: &str) -> String {
    format!("{} → {} {unit}", significant(before, 3), significant(after, 3))
}

/// Returns what the compensation does to the error, in one sentence.
fn result([before, after]: [f64; 2], unit: &str) -> String {
    let ratio = after / before;
    let figures = figures([before, after], unit);
    if !ratio.is_finite() {
        return format!("The error is {figures}.");
    }
    if ratio < 0.45 {
        let far = |known: f64| (ratio / known).ln().abs();
        let near = LEFT.iter().min_by(|a, b| far(a.0).total_cmp(&far(b.0)));
        let words = near.filter(|_| ratio > 0.07).map_or("little", |(_, words)| *words);
        return format!("Compensation leaves {words} of the error: {figures}.");
    }
    match ratio {
        _ if ratio <= 0.55 => format!("Compensation halves the error: {figures}."),
        _ if ratio <= 0.95 => {
            format!(
                "Compensation takes off {:.0} % of the error: {figures}.",
                100.0 * (1.0 - ratio)
            )
        }
        _ if ratio <= 1.05 => format!("Compensation changes nothing: {figures}."),
        _ => format!("Compensation makes the error worse: {figures}."),
    }
}

/// What the button of the strip does.
enum Offer<'a> {
    Remedy(&'a Remedy),
    /// Switches the compensation off.
    Off(Command),
}

/// Returns the remedy with a known error, or else the edit that switches a useless compensation off, or else the remedy whose
/// error is not known. A compensation that does harm is switched off first.
fn offer<'a>(found: Option<&'a Sufficiency>, engine: &Engine) -> Option<Offer<'a>> {
    let remedy = found.and_then(|found| first_remedy(found, engine));
    let left = left_over(engine);
    let off = left.filter(|left| *left > BRINGS_NOTHING).and_then(|_| switched_off(engine));
    let does_harm = left.is_some_and(|left| left > MAKES_WORSE);
    match (remedy, off) {
        (Some(remedy), off) if off.is_none() || !does_harm && !remedy.errors.is_empty() => {
            Some(Offer::Remedy(remedy))
        }
        (_, off) => off.map(Offer::Off),
    }
}

/// Returns what a press on the remedy of the strip does; `None` without a remedy.
pub fn remedy(engine: &Engine) -> Option<Command> {
    match offer(engine.lane::<CheckData>().answer(), engine)? {
        Offer::Remedy(remedy) => command(remedy, engine),
        Offer::Off(off) => Some(off),
    }
}

/// Returns the error of the compensated load divided by that of the uncompensated load: the root mean square over all axes,
/// each in % of full scale, on samples that the fit has not seen.
fn left_over(engine: &Engine) -> Option<f64> {
    let analysis = engine.analysis().filter(|analysis| analysis.fitted)?;
    let errors = Errors::of(analysis, ScoreSet::LeftOut)?;
    let scale = scale_of(analysis);
    let in_percent = |rmse: &[f64]| Measure::FullScale.of_rmse(&scale, rmse);
    let ratio = in_percent(errors.after)? / in_percent(errors.before)?;
    (errors.on != ScoreSet::Train && ratio.is_finite()).then_some(ratio)
}

/// Returns the edit that switches the compensation off; `None` if there is none.
fn switched_off(engine: &Engine) -> Option<Command> {
    let settings = &engine.project().settings;
    let features =
        FeatureSettings { distance: settings.features.distance, ..FeatureSettings::present() };
    let off = FitSettings { features, regressor: Regressor::Linear, ..settings.clone() };
    (off != *settings).then(|| Edit::Settings(off).into())
}

/// Returns the remedy of the largest cause that can be pressed.
fn first_remedy<'a>(found: &'a Sufficiency, engine: &Engine) -> Option<&'a Remedy> {
    let can_be_pressed = |remedy: &&Remedy| command(remedy, engine).is_some();
    found.remedies.iter().find(can_be_pressed)
}

/// Returns what a press on a remedy does; `None` if a press can do nothing.
pub fn command(remedy: &Remedy, engine: &Engine) -> Option<Command> {
    let project = engine.project();
    Some(match &remedy.action {
        Action::Features(features) => {
            let features = (**features).clone();
            let (regressor, settings) = (Regressor::Linear, project.settings.clone());
            Edit::Settings(FitSettings { features, regressor, ..settings }).into()
        }
        Action::Tare => Do::Tare((0..engine.entries().len()).collect(), Tare::Auto).into(),
        Action::LeaveOut(name) => {
            let at = engine.entries().iter().position(|entry| entry.recording.name() == name)?;
            Edit::Roles(vec![at], Role::Off).into()
        }
        Action::TryModels => {
            let limit = Duration::from_secs_f64(60.0 * SEARCH_MINUTES);
            Do::FindBest(Candidates::All, limit).into()
        }
        Action::ZeroReference | Action::RecordTemperature | Action::Mean(_) => return None,
    })
}

/// Returns a short name of what a press on a remedy does.
pub fn short(remedy: &Remedy, engine: &Engine) -> String {
    match &remedy.action {
        Action::Features(features) => {
            let present = &engine.project().settings.features;
            let is_added = |block: &&&dyn Block| {
                let values = features.blocks.of(**block);
                !values.is_empty() && values != present.blocks.of(**block)
            };
            let blocks = BLOCKS.iter().filter(is_added).map(|block| block.name().to_lowercase());
            let look_back = present.look_backs.is_empty() && !features.look_backs.is_empty();
            let look_back = look_back.then(|| "look-back".to_owned());
            let added: Vec<String> = blocks.chain(look_back).collect();
            match &added[..] {
                [] => "Change features".to_owned(),
                all => format!("Add {}", all.join(", ")),
            }
        }
        Action::Tare => "Tare each recording".to_owned(),
        Action::ZeroReference => "Zero the reference".to_owned(),
        Action::LeaveOut(name) => format!("Leave out {name}"),
        Action::TryModels => "Try all models".to_owned(),
        Action::RecordTemperature => "Record a temperature".to_owned(),
        Action::Mean(n) => format!("Mean over {n} samples"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_says_how_much_of_the_error_is_left() {
        let said = |after: f64, part: &str| {
            let words = result([2.0, after], "N");
            assert!(words.contains(part) && words.contains("2.00 → "), "{words}");
        };
        said(0.2, "a tenth");
        said(0.5, "a quarter");
        said(0.7, "a third");
        said(1.0, "halves");
        said(1.6, "20 %");
        said(2.0, "nothing");
        said(2.4, "worse");
        said(0.01, "little");
    }
}
