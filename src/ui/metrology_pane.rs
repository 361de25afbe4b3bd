//! The figures of a certificate: rows with their definitions at hand, Conv. beside Comp. for every axis.

use egui::RichText;

use crate::analysis::loops::{Question, TableOf, TableQuestion};
use crate::app::{AppState, Command, Existing, FileContent};
use crate::evaluation::metrology::{Cell, Figure, Metrology, MetrologySettings, Reason, Row};
use crate::recording::{Axis, Role};
use crate::ui::dead_band::dead_band;
use crate::ui::looking::Looking;
use crate::ui::numbers::significant;
use crate::ui::palette::Trace;

/// The longest time that a rest can be asked to last (s).
const LONGEST_REST_SECS: f64 = 1e5;
/// Columns of figures are at least this wide.
const FIGURE_WIDTH: f32 = 38.0;

/// What the figures are shown in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Shown {
    #[default]
    PercentFs,
    Units,
}

/// What the pane remembers between frames.
#[derive(Debug)]
pub struct MetrologyPane {
    /// `None` follows the recordings: the test recordings where there are some, else all.
    of: Option<TableOf>,
    settings: MetrologySettings,
    /// The axes that the dead bands are of.
    axes: Vec<Axis>,
    shown: Shown,
    path: String,
}

impl Default for MetrologyPane {
    fn default() -> Self {
        Self {
            of: None,
            settings: MetrologySettings::default(),
            axes: Vec::new(),
            shown: Shown::default(),
            path: "metrology.csv".to_owned(),
        }
    }
}

/// One of a cell's two figures.
type Pick = fn(&Cell) -> &Figure;

const OUTPUTS: [(Trace, Pick); 2] = [
    (Trace::Conventional, |cell| &cell.conventional),
    (Trace::Compensated, |cell| &cell.compensated),
];

impl MetrologyPane {
    /// What must be answered for the pane to be drawn.
    pub fn question(&self, state: &AppState) -> Option<Question> {
        state.analysis.as_ref()?;
        Some(Question::Table(TableQuestion {
            of: self.of(state),
            settings: self.settings.clone(),
        }))
    }

    fn of(&self, state: &AppState) -> TableOf {
        let entries = state.recordings.entries();
        let tests = entries.iter().any(|entry| entry.role == Role::Test);
        let usual = if tests { TableOf::Test } else { TableOf::All };
        self.of.unwrap_or(usual)
    }

    /// Draws the pane.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        state: &AppState,
        looking: &Looking,
        out: &mut Vec<Command>,
    ) {
        if state.axes() != self.axes {
            self.axes = state.axes().to_vec();
            self.settings.dead_bands.clear(); // they were in other axes' units
        }
        let table = looking.seen.table.as_ref().map(|(table, _)| table);
        ui.horizontal_wrapped(|ui| {
            self.choices(ui, state);
            self.definitions(ui, table.map(|table| &**table));
            ui.separator();
            ui.add_enabled_ui(table.is_some(), |ui| {
                if ui
                    .button("Copy table")
                    .on_hover_text("As tab-separated text")
                    .clicked()
                    && let Some(table) = table
                {
                    ui.copy_text(as_text(table, self.shown));
                }
                let label = ui.label("CSV");
                let field = egui::TextEdit::singleline(&mut self.path).desired_width(120.0);
                ui.add(field)
                    .labelled_by(label.id)
                    .on_hover_text("Where the table is written");
                let save = ui.button("Save").on_hover_text(
                    "With units, % of full scale, places, reasons, definitions and sources",
                );
                let path = self.path.trim();
                if save.clicked()
                    && !path.is_empty()
                    && let Some(table) = table
                {
                    let content = FileContent::Metrology(table.clone());
                    out.push(Command::Save(content, path.into(), Existing::Ask));
                }
            });
        });
        ui.separator();
        if let Some(problem) = &looking.seen.problem {
            ui.colored_label(ui.visuals().warn_fg_color, problem);
        }
        let Some(table) = table else {
            ui.weak("No table yet.");
            return;
        };
        let width = ui.available_width();
        egui::ScrollArea::both()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                grid(ui, table, self.shown);
                crosstalk(ui, table);
                // Sentences are read without scrolling, however wide the table is.
                ui.vertical(|ui| {
                    ui.set_max_width(width);
                    notes(ui, table);
                });
            });
    }

    fn choices(&mut self, ui: &mut egui::Ui, state: &AppState) {
        let mut of = self.of(state);
        for (one, label, explanation) in [
            (TableOf::Test, "Test", "The test recordings"),
            (TableOf::Train, "Train", "The training recordings"),
            (TableOf::All, "All", "All recordings"),
        ] {
            ui.selectable_value(&mut of, one, label)
                .on_hover_text(explanation);
        }
        if of != self.of(state) {
            self.of = Some(of);
        }
        ui.separator();
        ui.selectable_value(&mut self.shown, Shown::PercentFs, "% FS")
            .on_hover_text("In percent of full scale");
        ui.selectable_value(&mut self.shown, Shown::Units, "N, N·m")
            .on_hover_text("In the unit of the axis");
        ui.separator();
        let explanation =
            "A load that stands still for so long is a rest: creep and zero return are read there";
        let label = ui.label("Rest").on_hover_text(explanation);
        let field = egui::DragValue::new(&mut self.settings.hold_secs)
            .range(0.1..=LONGEST_REST_SECS)
            .speed(0.1)
            .suffix(" s");
        ui.add(field)
            .labelled_by(label.id)
            .on_hover_text(explanation);
    }
}

/// A field for a share of full scale: its label, what it decides, and the value.
type ShareField<'a> = (&'a str, &'a str, &'a mut f64);

impl MetrologyPane {
    /// What counts as a reversal, as still, as zero, as loaded.
    fn definitions(&mut self, ui: &mut egui::Ui, table: Option<&Metrology>) {
        let keep_open = egui::containers::menu::MenuConfig::new()
            .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
        let button = egui::containers::menu::MenuButton::new("Definitions…").config(keep_open);
        let (response, _) = button.ui(ui, |ui| {
            ui.reset_style(); // fields, not menu items
            ui.set_min_width(300.0);
            let settings = &mut self.settings;
            let shares: [ShareField<'_>; 4] = [
                (
                    "Still within",
                    "A rest: every axis stays within this much for the time beside \"Rest\"",
                    &mut settings.still_share,
                ),
                (
                    "Zero within",
                    "A load this small is no load: zero return is read there",
                    &mut settings.zero_share,
                ),
                (
                    "Loaded from",
                    "An axis with at least this much is loaded: crosstalk is read there",
                    &mut settings.loaded_share,
                ),
                (
                    "Not loaded up to",
                    "The other axes stay below this while one is loaded alone",
                    &mut settings.alone_share,
                ),
            ];
            egui::Grid::new("definitions")
                .num_columns(3)
                .show(ui, |ui| {
                    for (name, explanation, share) in shares {
                        let label = ui.label(name).on_hover_text(explanation);
                        let mut percent = 100.0 * *share;
                        let field = egui::DragValue::new(&mut percent)
                            .range(0.01..=100.0)
                            .speed(0.05)
                            .suffix(" % FS");
                        let field = ui.add(field).labelled_by(label.id);
                        if field.on_hover_text(explanation).changed() {
                            *share = 0.01 * percent;
                        }
                        ui.end_row();
                    }
                    for (at, axis) in table
                        .map_or(&[][..], |table| &table.axes)
                        .iter()
                        .enumerate()
                    {
                        settings
                            .dead_bands
                            .resize(settings.dead_bands.len().max(at + 1), None);
                        let used = table.and_then(|table| table.dead_bands.get(at).copied());
                        let name = format!("Dead band {}", axis.symbol());
                        dead_band(ui, &name, *axis, &mut settings.dead_bands[at], used);
                        ui.end_row();
                    }
                });
        });
        response.on_hover_text("What counts as a reversal, as a rest, as zero, and as loaded");
    }
}

fn heading(ui: &mut egui::Ui, table: &Metrology, title: &str) {
    ui.strong(title);
    for (at, axis) in table.axes.iter().enumerate() {
        let scales = format!(
            "Full scale {} {unit}, dead band {} {unit}",
            significant(table.full_scale[at], 4),
            significant(table.dead_bands[at], 3),
            unit = axis.unit(),
        );
        ui.strong(axis.symbol()).on_hover_text(scales);
        ui.label("");
    }
    ui.end_row();
    ui.label("");
    for _ in &table.axes {
        for (trace, _) in OUTPUTS {
            let color = trace.color(ui.visuals());
            ui.label(RichText::new(trace.label()).small().color(color))
                .on_hover_text(trace.explanation());
        }
    }
    ui.end_row();
}

fn grid(ui: &mut egui::Ui, table: &Metrology, shown: Shown) {
    table_grid("metrology").show(ui, |ui| {
        let unit = match shown {
            Shown::PercentFs => "% of full scale",
            Shown::Units => "N and N·m",
        };
        heading(ui, table, unit);
        for row in table.own_rows() {
            let mut name = row.definition.name.clone();
            if row.quantity.is_time() {
                name.push_str(" [s]");
            }
            defined(ui, row, &name);
            for cell in &row.cells {
                figures(ui, cell, shown);
            }
            ui.end_row();
        }
    });
}

fn table_grid(id: &str) -> egui::Grid {
    egui::Grid::new(id)
        .striped(true)
        .min_col_width(FIGURE_WIDTH)
        .spacing([6.0, 3.0])
}

/// A row's name, with what it means.
fn defined(ui: &mut egui::Ui, row: &Row, name: &str) {
    let about = &row.definition;
    ui.label(name).on_hover_ui(|ui| {
        ui.set_max_width(420.0);
        ui.strong(&about.name);
        ui.label(about.definition);
        ui.label(format!("Source: {}", about.source));
        if !about.free_running.is_empty() {
            ui.weak(format!("Free-running: {}", about.free_running));
        }
    });
}

/// Conv. and Comp. of one axis; what both lack is said once.
fn figures(ui: &mut egui::Ui, cell: &Cell, shown: Shown) {
    let same = cell.conventional.is_err() && cell.conventional == cell.compensated;
    for (at, (trace, figure)) in OUTPUTS.into_iter().enumerate() {
        if same && at == 1 {
            ui.label("");
        } else {
            one_figure(ui, cell, figure(cell), trace, shown);
        }
    }
}

fn one_figure(ui: &mut egui::Ui, cell: &Cell, figure: &Figure, trace: Trace, shown: Shown) {
    match figure {
        Ok(value) => {
            let number = match shown {
                Shown::PercentFs => value.percent_fs.unwrap_or(value.value),
                Shown::Units => value.value,
            };
            let response = ui.label(significant(number, 3));
            response.on_hover_ui(|ui| {
                ui.strong(format!("{} {}", cell.axis.symbol(), trace.label()));
                let percent = value.percent_fs.map_or_else(String::new, |percent| {
                    format!(" = {} % of full scale", significant(percent, 4))
                });
                ui.label(format!(
                    "{} {}{percent}",
                    significant(value.value, 4),
                    cell.unit
                ));
                if let Some(place) = &value.place {
                    ui.weak(format!(
                        "{}, {} s to {} s",
                        place.name,
                        significant(place.from_secs, 5),
                        significant(place.to_secs, 5)
                    ));
                }
            });
        }
        Err(reason) => {
            let weak = RichText::new(short(reason)).small().weak();
            ui.label(weak).on_hover_text(reason.to_string());
        }
    }
}

/// A word or two that stand for the sentence.
fn short(reason: &Reason) -> &'static str {
    match reason {
        Reason::NoReference { .. } => "no ref.",
        Reason::ConstantLoad { .. } => "constant",
        Reason::OneBranch { .. } => "1 branch",
        Reason::NoCycle { .. } => "no cycle",
        Reason::NoRisingBranch { .. } => "no rise",
        Reason::TooFewLoads { .. } => "few loads",
        Reason::TooFewCycles { .. } => "1 cycle",
        Reason::NoFullScale { .. } => "no FS",
        Reason::NoHold { .. } => "no hold",
        Reason::NoZero { .. } => "no zero",
        Reason::NoReturn { .. } => "no return",
        Reason::NoRecovery { .. } => "no zero",
        Reason::NoTimeConstant(_) => "no τ",
        Reason::LoadedAxis { .. } => "·",
        Reason::OnlyAxis { .. } => "only axis",
        Reason::NeverAlone { .. } => "not alone",
        Reason::NotFinite { .. } => "not finite",
        Reason::Overflow { .. } => "too large",
    }
}

/// A row for each loaded axis, columns for the axes that read it, always in % of full scale.
fn crosstalk(ui: &mut egui::Ui, table: &Metrology) {
    if table.axes.len() < 2 {
        return;
    }
    ui.add_space(8.0);
    table_grid("crosstalk").show(ui, |ui| {
        heading(ui, table, "Crosstalk, % of full scale");
        for (from, row) in table.crosstalk_rows() {
            defined(ui, row, &format!("from {}", from.symbol()));
            for cell in &row.cells {
                figures(ui, cell, Shown::PercentFs);
            }
            ui.end_row();
        }
    });
}

fn notes(ui: &mut egui::Ui, table: &Metrology) {
    ui.add_space(6.0);
    ui.weak(format!(
        "{} recordings, {} samples. Point at a name for its definition and source, at a figure for where it comes from, \
         at a word in place of a figure for the reason. These figures compare two calibrations on the same data; they do \
         not replace a certificate's measurement.",
        table.n_recordings, table.n_samples
    ));
    for note in &table.notes {
        ui.colored_label(ui.visuals().warn_fg_color, format!("Note: {note}"));
    }
}

/// The rows as tab-separated text, in what is shown.
fn as_text(table: &Metrology, shown: Shown) -> String {
    let mut head = vec!["quantity".to_owned()];
    for axis in &table.axes {
        let unit = match shown {
            Shown::PercentFs => "% FS",
            Shown::Units => axis.unit(),
        };
        head.extend(
            OUTPUTS.map(|(trace, _)| format!("{} {} [{unit}]", axis.symbol(), trace.label())),
        );
    }
    let rows = table.rows.iter().map(|row| {
        let figure = |figure: &Figure| match (figure, shown) {
            (Ok(value), Shown::PercentFs) => value.percent_fs.unwrap_or(value.value).to_string(),
            (Ok(value), Shown::Units) => value.value.to_string(),
            (Err(reason), _) => reason.to_string(),
        };
        let cells = row.cells.iter();
        let cells = cells.flat_map(|cell| OUTPUTS.map(|(_, pick)| figure(pick(cell))));
        let unit = if row.quantity.is_time() { " [s]" } else { "" };
        let name = format!("{}{unit}", row.definition.name);
        std::iter::once(name)
            .chain(cells)
            .collect::<Vec<_>>()
            .join("\t")
    });
    let lines: Vec<String> = std::iter::once(head.join("\t")).chain(rows).collect();
    lines.join("\n")
}
