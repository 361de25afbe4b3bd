//! Pane of metrology figures (hysteresis, nonlinearity, creep, …) with their definitions, uncompensated beside compensated
//! for every axis.

use egui::Ui;

use crate::{
    engine::{Edit, Engine, FileContent},
    finding::Face,
    questions::{
        loops::{Look, Question, TableOf, query::LookAt},
        metrology::{
            Metrology, MetrologySettings, axis_figures, crosstalk, figure_records, overview,
        },
    },
    recording::Axis,
    report::{Shown, Table, Trace},
    shown::counted,
    ui::{
        command::{Out, Pane},
        controls::Controls as _,
        pane::{Cx, PaneView},
        reversal_threshold::{dwell_secs, reversal_threshold},
        strip::OLD,
        table,
    },
};

#[derive(Debug, Default)]
pub struct MetrologyPane {
    /// Recordings that the table covers; `None` for the default recordings, see [`TableOf::usual`].
    of: Option<TableOf>,
    shown: Shown,
}

impl PaneView for MetrologyPane {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        self.draw(ui, cx.engine, cx.scope.axes().first().copied(), cx.out);
        // The result is requested after the drawing, because the drawing may have changed the settings of the pane.
        if let Some(look) = cx.engine.look(None, Question::Table(self.of(cx.engine))) {
            cx.ask_as(Pane::METROLOGY.key, LookAt(look));
        }
    }
}

impl MetrologyPane {
    /// Returns the recordings that this table covers.
    fn of(&self, engine: &Engine) -> TableOf {
        self.of.unwrap_or_else(|| TableOf::usual(&engine.project().recordings))
    }

    fn draw(&mut self, ui: &mut Ui, engine: &Engine, axis: Option<Axis>, out: &mut Out) {
        let lane = engine.lane_of::<LookAt>(Pane::METROLOGY.key);
        let (answer, problem) = (lane.answer(), lane.problem());
        let table = match answer.filter(|_| engine.analysis().is_some()) {
            Some(Look::Table(table)) => Some(table),
            _ => None,
        };
        let tables: Vec<Table> = table.map_or_else(Vec::new, |table| {
            std::iter::once(overview(table, self.shown)).chain(crosstalk(table)).collect()
        });
        ui.horizontal_wrapped(|ui| {
            let before = &engine.project().measuring;
            let mut measuring = before.clone();
            self.choices(ui, engine, &mut measuring);
            definitions(ui, table.map(|table| &**table), engine.project().axes(), &mut measuring);
            if measuring != *before {
                out.send(Edit::Measuring(measuring));
            }
            ui.end_row();
            let holds = "Saves all metrology figures with definitions, sources and the reasons for missing figures";
            let content = table.map(|table| || FileContent::Table("metrology.csv", Box::new(figure_records(table))));
            table::saving(ui, holds, || table::joined(&tables), content, out);
        });
        ui.separator();
        if let Some(problem) = problem {
            ui.warn(problem);
        }
        if !lane.is_current() {
            ui.multiply_opacity(OLD); // the figures are those of earlier settings
        }
        let Some(table) = table else {
            if engine.analysis().is_none() {
                ui.weak("No calibration is fitted yet.");
            } else if problem.is_none() {
                ui.awaited("The table of metrology figures", engine);
            }
            return;
        };
        let width = ui.available_width();
        ui.scrolled(|ui| {
            let at = axis.and_then(|axis| table.axes.iter().position(|known| *known == axis));
            let at = at.unwrap_or(0);
            if at < table.axes.len() {
                let mut figures = axis_figures(table, at, self.shown);
                // A title in the grid would widen the column of names.
                let unit = match self.shown {
                    Shown::PercentFs => "% FS",
                    _ => table.axes[at].unit(),
                };
                ui.label(format!("Figures of {} [{unit}]", table.axes[at].symbol()))
                    .on_hover_text(std::mem::take(&mut figures.title));
                for column in &mut figures.columns {
                    let short = column.trace.map(|trace| match trace {
                        Trace::Conventional => "Uncomp.",
                        _ => "Comp.",
                    });
                    (column.name, column.unit) =
                        (short.map_or(std::mem::take(&mut column.name), str::to_owned), "");
                }
                table::show(ui, &figures);
                ui.add_space(8.0);
            }
            for shown in &tables[1..] {
                table::show(ui, shown);
                ui.add_space(8.0);
            }
            // The notes on the table wrap at the width of the pane, even if the table is wider.
            ui.vertical(|ui| {
                ui.set_max_width(width);
                notes(ui, table);
            });
        });
    }

    fn choices(&mut self, ui: &mut Ui, engine: &Engine, measuring: &mut MetrologySettings) {
        let before = self.of(engine);
        let mut of = before;
        let not_fitted = "Computes the metrology figures from the recordings that the fit does not use: those with the role test or off";
        let all = [
            (TableOf::Test, "Test", "Computes the metrology figures from the test recordings"),
            (TableOf::NotFitted, "Not fitted", not_fitted),
            (
                TableOf::Train,
                "Train",
                "Computes the metrology figures from the training recordings",
            ),
            (TableOf::All, "All", "Computes the metrology figures from all recordings"),
        ];
        ui.select_from(&mut of, all);
        if of != before {
            self.of = Some(of);
        }
        let units = [
            (Shown::PercentFs, "% FS", "Shows the metrology figures in percent of full scale"),
            (Shown::Units, "N, N·m", "Shows the metrology figures in the unit of the axis"),
        ];
        ui.select_from(&mut self.shown, units);
        dwell_secs(ui, "Dwell", measuring);
    }
}

fn definitions(
    ui: &mut Ui,
    table: Option<&Metrology>,
    axes: &[Axis],
    settings: &mut MetrologySettings,
) {
    let button = egui::Button::new("Definitions…");
    let response = ui.menu_of_fields(button, |ui| {
        ui.reset_style(); // fields, not menu items
        ui.set_min_width(300.0);
        egui::Grid::new("definitions").num_columns(3).show(ui, |ui| {
            for (name, explanation, share) in [
                (
                    "Constant load within",
                    "In a dwell, the load of every axis stays within this share of its full scale for the time in the field \"Dwell\"",
                    &mut settings.still_share,
                ),
                (
                    "Zero load up to",
                    "A load up to this share of its axis's full scale counts as zero",
                    &mut settings.zero_share,
                ),
                (
                    "Axis loaded from",
                    "An axis counts as loaded if its load is at least this share of its full scale",
                    &mut settings.loaded_share,
                ),
                (
                    "Axis unloaded up to",
                    "Crosstalk is measured while one axis is loaded and every other axis stays below this share of its full scale",
                    &mut settings.alone_share,
                ),
            ] {
                let mut percent = 100.0 * *share;
                let field = egui::DragValue::new(&mut percent)
                    .range(0.01..=100.0)
                    .speed(0.05)
                    .suffix(" % FS");
                if ui.field(name, field, explanation).changed() {
                    *share = 0.01 * percent;
                }
                ui.end_row();
            }
            for (at, axis) in axes.iter().enumerate() {
                let used = table.and_then(|table| table.reversal_thresholds.get(at).copied());
                let name = format!("Reversal threshold {}", axis.symbol());
                reversal_threshold(ui, &name, (axes, at), settings, used);
                ui.end_row();
            }
        });
    });
    response.on_hover_text(
        "Shows the definitions of a reversal, a dwell, a zero load and a loaded axis",
    );
}

fn notes(ui: &mut Ui, table: &Metrology) {
    ui.weak(format!(
        "{}, {} samples. Hover over a name for its definition, and over a figure for its place or the reason why it is missing. These figures compare two calibrations on the same data; they do not replace a calibration in steps on a reference machine.",
        counted(table.n_recordings, "recording"),
        table.n_samples
    ));
    for found in &table.findings {
        ui.warn(format!("Note: {}", found.text(Face::Window)));
    }
}
