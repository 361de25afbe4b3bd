//! Regressors side by side: a table that fills in as rows end, and bars per axis as in the paper's figures.

use egui::{Color32, RichText};
use egui_plot::{Bar, BarChart, Plot};

use crate::analysis::{TrainingStep, comparison_table};
use crate::calibration::Regressor;
use crate::engine::{Action, Engine, Existing, FileContent, Row};
use crate::evaluation::metrics::Group;
use crate::evaluation::threshold_study::ScoreSet;
use crate::recording::Axis;
use crate::ui::command::{Command, Kind, Pane};
use crate::ui::numbers::{duration, significant};
use crate::ui::pane::{Cx, PaneView};
use crate::ui::{palette, picture, plots};

/// Height of the bars.
const BARS_HEIGHT: f32 = 170.0;

/// The pane.
pub const PANE: Pane = Pane(&Kind {
    key: "compare",
    title: "Compare",
    explanation: "Every regressor without and with the past",
});

/// What is chosen and typed.
#[derive(Debug)]
pub struct View {
    /// Which errors are shown.
    errors_on: ScoreSet,
    /// The path to save the table to.
    path: String,
}

impl Default for View {
    fn default() -> Self {
        Self {
            errors_on: ScoreSet::Test,
            path: "comparison.csv".to_owned(),
        }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        compare_pane(ui, cx.engine, self, cx.out);
    }
}

/// Draws the pane.
fn compare_pane(ui: &mut egui::Ui, engine: &Engine, fields: &mut View, out: &mut Vec<Command>) {
    let comparison = &engine.comparison;
    ui.horizontal_wrapped(|ui| {
        if engine.is_comparing() {
            let stop = ui.button("Stop");
            let stop = stop.on_hover_text("Rows that have ended keep their results");
            if stop.clicked() {
                out.push(Action::StopComparing.into());
            }
        } else {
            let ready = !engine.project().recordings.entries().is_empty();
            ui.add_enabled_ui(ready, |ui| {
                let start = ui.button("Fit ticked rows").on_hover_text(
                    "Rows that already have a result that holds are not fitted again",
                );
                if start.clicked() {
                    out.push(Action::Compare.into());
                }
                let whole = ui.button("Whole comparison of the paper").on_hover_text(
                    "Linear, network and hybrid, without and with the past, on all samples (A) and on every tenth (B): \
                     Figures 9, 10, 12 and 13. Networks on all samples take minutes",
                );
                if whole.clicked() {
                    out.push(Action::ComparePaper.into());
                }
            });
        }
        ui.separator();
        for set in ScoreSet::ALL {
            ui.selectable_value(&mut fields.errors_on, set, set.title())
                .on_hover_text(set.explanation());
        }
        ui.separator();
        let rows: Vec<_> = comparison.rows.iter().filter_map(Row::compared).cloned().collect();
        ui.add_enabled_ui(!rows.is_empty(), |ui| {
            if ui.button("Copy table").on_hover_text("As tab-separated text").clicked() {
                ui.copy_text(comparison_table(&rows, &ScoreSet::ALL).tab_separated());
            }
            let label = ui.label("CSV");
            let field = egui::TextEdit::singleline(&mut fields.path).desired_width(130.0);
            ui.add(field)
                .labelled_by(label.id)
                .on_hover_text("Where the table is written");
            let path = fields.path.trim();
            let save = ui.button("Save");
            let save = save.on_hover_text("Every row that has a result, with train, test and cross-validation");
            if save.clicked() && !path.is_empty() {
                let content = FileContent::Comparison(rows.clone());
                out.push(Action::Save(content, path.into(), Existing::Ask).into());
            }
        });
    });
    ui.separator();
    egui::ScrollArea::both()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            bars(ui, engine, fields.errors_on, out);
            table(ui, engine, fields.errors_on, out);
        });
}

fn table(ui: &mut egui::Ui, engine: &Engine, on: ScoreSet, out: &mut Vec<Command>) {
    let rows = &engine.comparison.rows;
    let axes = engine.project().axes();
    egui::Grid::new("comparison")
        .striped(true)
        .min_col_width(20.0)
        .spacing([10.0, 3.0])
        .show(ui, |ui| {
            let mut all = rows.iter().all(|row| row.ticked);
            if ui
                .checkbox(&mut all, "")
                .on_hover_text("Tick all rows, or none")
                .changed()
            {
                out.push(Action::TickAll(all).into());
            }
            for title in ["Regressor", "History", "Data", "State"] {
                ui.strong(title);
            }
            for axis in axes {
                ui.strong(axis.label());
            }
            for (group, unit) in [(Group::Force, "N"), (Group::Moment, "N·m")] {
                if axes.iter().any(|axis| group.contains(*axis)) {
                    ui.strong(format!("{} [{unit}]", group_name(group)))
                        .on_hover_text("Root mean square over the axes");
                }
            }
            ui.end_row();
            for (at, row) in rows.iter().enumerate() {
                table_row(ui, engine, at, row, on, out);
                ui.end_row();
            }
        });
}

fn table_row(
    ui: &mut egui::Ui,
    engine: &Engine,
    at: usize,
    row: &Row,
    on: ScoreSet,
    out: &mut Vec<Command>,
) {
    let candidate = &row.candidate;
    let regressor = candidate.regressor.label();
    let mut ticked = row.ticked;
    let tick = ui.checkbox(&mut ticked, "");
    tick.widget_info(|| {
        let label = format!(
            "{regressor}, {}, {}",
            candidate.history(),
            candidate.pattern()
        );
        egui::WidgetInfo::selected(egui::Role::CheckBox, true, ticked, label)
    });
    if tick
        .on_hover_text("Whether \"Fit ticked rows\" fits this one")
        .changed()
    {
        out.push(Action::Tick(at, ticked).into());
    }
    ui.colored_label(
        palette::regressor(candidate.regressor, ui.visuals()),
        regressor,
    );
    let history = candidate.history();
    ui.label(shortened(&history, 30)).on_hover_text(&history);
    ui.label(candidate.pattern())
        .on_hover_text(candidate.data());
    let stale = row.is_stale(engine.project());
    row_state(ui, row, stale);
    let axes = engine.project().axes();
    let rmse = row.compared().and_then(|row| on.rmse(&row.scores));
    let weak = ui.visuals().weak_text_color();
    let mut cell = |value: Option<f64>| {
        let text = value.map_or_else(|| "–".to_owned(), |value| significant(value, 4));
        let text = RichText::new(text);
        ui.label(if stale { text.color(weak) } else { text });
    };
    for axis in 0..axes.len() {
        cell(rmse.and_then(|rmse| rmse.get(axis).copied()));
    }
    for group in [Group::Force, Group::Moment] {
        if axes.iter().any(|axis| group.contains(*axis)) {
            cell(rmse.and_then(|rmse| group.rmse(axes, rmse)));
        }
    }
}

/// Whether the row runs, holds, or failed.
fn row_state(ui: &mut egui::Ui, row: &Row, stale: bool) {
    match (&row.running, &row.outcome) {
        (Some(step), _) => {
            ui.label(match step {
                Some(TrainingStep::Epoch(report)) => format!(
                    "{} of {}, {}",
                    report.epoch,
                    report.epochs,
                    duration(report.time_left())
                ),
                Some(step) => format!("cross-validation, {}", duration(step.time_left())),
                None => "runs".to_owned(),
            });
        }
        (None, None) => {
            ui.weak("not fitted");
        }
        (None, Some(outcome)) => match &outcome.result {
            Err(error) => {
                ui.colored_label(ui.visuals().error_fg_color, shortened(error, 40))
                    .on_hover_text(error);
            }
            Ok(_) if stale => {
                ui.colored_label(ui.visuals().warn_fg_color, "stale")
                    .on_hover_text("Settings, blocks or recordings are others now; fit it again");
            }
            Ok(compared) => {
                let seconds = significant(compared.elapsed.as_secs_f64(), 2);
                ui.weak(format!("{seconds} s"));
            }
        },
    }
}

/// One chart per unit: a group of bars for each axis, a bar for each row that has a result.
fn bars(ui: &mut egui::Ui, engine: &Engine, on: ScoreSet, out: &mut Vec<Command>) {
    let axes = engine.project().axes();
    let rows: Vec<(&Row, &[f64])> = engine
        .comparison
        .rows
        .iter()
        .filter_map(|row| Some((row, on.rmse(&row.compared()?.scores)?)))
        .filter(|(_, rmse)| rmse.len() == axes.len())
        .collect();
    if rows.is_empty() {
        ui.weak("Tick rows and fit them: bars of their errors appear here.");
        return;
    }
    let groups: Vec<Group> = [Group::Force, Group::Moment]
        .into_iter()
        .filter(|group| axes.iter().any(|axis| group.contains(*axis)))
        .collect();
    let width = (ui.available_width() / groups.len() as f32 - 8.0).max(200.0);
    ui.horizontal(|ui| {
        for group in groups {
            chart(ui, group, axes, &rows, width, out);
        }
    });
    ui.weak("Pale bars: without the past. Colours: the regressor, as in the table. Broad bars: all samples (A); narrow: every tenth (B); narrowest: few trajectories (C).");
}

fn chart(
    ui: &mut egui::Ui,
    group: Group,
    axes: &[Axis],
    rows: &[(&Row, &[f64])],
    width: f32,
    out: &mut Vec<Command>,
) {
    let of_group: Vec<(usize, Axis)> = axes
        .iter()
        .copied()
        .enumerate()
        .filter(|(_, axis)| group.contains(*axis))
        .collect();
    let unit = of_group.first().map_or("", |(_, axis)| axis.unit());
    let slot = 0.85 / rows.len() as f64;
    let visuals = ui.visuals().clone();
    let bars: Vec<Bar> = of_group
        .iter()
        .enumerate()
        .flat_map(|(place, (column, axis))| {
            let visuals = &visuals;
            rows.iter().enumerate().map(move |(at, (row, rmse))| {
                let x = place as f64 + (at as f64 + 0.5) * slot - 0.425;
                let candidate = &row.candidate;
                let name = format!(
                    "{} of {}, {}, {}",
                    axis.symbol(),
                    candidate.regressor.label(),
                    candidate.history(),
                    candidate.pattern()
                );
                let share = match (candidate.few_trajectories, candidate.decimation) {
                    (false, 1) => 0.95,
                    (false, _) => 0.55,
                    (true, _) => 0.3,
                };
                Bar::new(x, rmse[*column])
                    .width(share * slot)
                    .name(name)
                    .fill(bar_color(
                        candidate.regressor,
                        candidate.features.has_history(),
                        visuals,
                    ))
            })
        })
        .collect();
    let names: Vec<&str> = of_group.iter().map(|(_, axis)| axis.symbol()).collect();
    let shown = Plot::new(("comparison", group_name(group)))
        .width(width)
        .height(BARS_HEIGHT)
        .allow_scroll(false)
        .allow_zoom(false)
        .allow_drag(false)
        .show_grid([false, true])
        .y_axis_label(format!("RMSE [{unit}]"))
        .y_axis_min_width(48.0)
        .include_y(0.0)
        .x_grid_spacer(|_| {
            (0..3)
                .map(|value| egui_plot::GridMark {
                    value: f64::from(value),
                    step_size: 1.0,
                })
                .collect()
        })
        .x_axis_formatter(move |mark, _| {
            let at = mark.value.round();
            let is_whole = (mark.value - at).abs() < 1e-6 && at >= 0.0;
            let name = names.get(at as usize).filter(|_| is_whole);
            name.map_or(String::new(), |name| (*name).to_owned())
        })
        .show(ui, |plot| {
            plot.bar_chart(BarChart::new("RMSE", bars));
        });
    let part = plots::with_labels(shown.response.rect);
    picture::menu(&shown.response, part, None, out);
}

fn bar_color(regressor: Regressor, has_history: bool, visuals: &egui::Visuals) -> Color32 {
    let color = palette::regressor(regressor, visuals);
    if has_history {
        color
    } else {
        color.gamma_multiply(0.4)
    }
}

fn group_name(group: Group) -> &'static str {
    match group {
        Group::Force => "forces",
        Group::Moment => "moments",
    }
}

/// The first characters of a text.
fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let start: String = text.chars().take(most - 1).collect();
    format!("{start}…")
}
