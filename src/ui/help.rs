//! Keys and words: what can be pressed, what the abbreviations mean, and the equations behind them.

use egui::RichText;

use crate::ui::actions::Action;

/// The window with the help texts.
#[derive(Debug, Default)]
pub struct Help {
    open: bool,
    page: Page,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Page {
    #[default]
    Keys,
    Mouse,
    Words,
    Equations,
}

const PAGES: [(Page, &str); 4] = [
    (Page::Keys, "Keys"),
    (Page::Mouse, "Mouse"),
    (Page::Words, "Words"),
    (Page::Equations, "Equations"),
];

const MOUSE: [(&str, &str); 9] = [
    ("Wheel over a plot", "zooms at the pointer"),
    ("Drag", "moves"),
    ("Right drag", "zooms into a box"),
    ("Double click", "shows all again"),
    (
        "Right click",
        "the plot as a picture: to the clipboard or a file",
    ),
    (
        "Click in a trace",
        "puts cursor A there; with Shift, cursor B",
    ),
    (
        "Pointer over a trace",
        "shows the sample and the past that was found for it",
    ),
    (
        "Drag a tab",
        "moves a pane: beside, above or below others, or among their tabs",
    ),
    (
        "Drop files",
        "opens recordings, calibrations and folders of them",
    ),
];

const WORDS: [(&str, &str); 12] = [
    ("Calc.", "calculated: the load that was really applied"),
    (
        "Conv.",
        "conventional calibration: least squares on the present gauges (Eq. 3-8), with an offset unless it is off",
    ),
    (
        "Comp.",
        "compensated: the same with what the past adds (Eq. 9-12)",
    ),
    (
        "S, S_past",
        "the gauges now, and those at the moment that the look-back found",
    ),
    (
        "F_th",
        "the look-back goes back to the last sample whose conventional load differed by this much",
    ),
    ("t_th", "how old that sample may be, in seconds"),
    (
        "Full scale, FS",
        "per axis: entered, else half the peak-to-peak reference over the training recordings",
    ),
    ("RMSE", "root of the mean squared error against Calc."),
    (
        "LOO-CV",
        "leave-one-recording-out: each training recording scored by a fit to the others",
    ),
    (
        "Play",
        "p ← max(s − r, min(s + r, p)): follows the gauge with a slack of r; the element of hysteresis",
    ),
    (
        "Creep",
        "a first-order low-pass of the gauge with a time constant",
    ),
    (
        "Ridge",
        "shrinks what the blocks append, so that Comp. ends at Conv. where the past says nothing",
    ),
];

const EQUATIONS: [(&str, &str); 6] = [
    ("Eq. 3", "L = C⁻¹ S: the load is a matrix times the gauges"),
    (
        "Eq. 4-8",
        "C⁻¹ = L S' (S S')⁻¹, S' the transpose: least squares over all training samples",
    ),
    (
        "Eq. 9",
        "Ŝ = [S, S_past]: the gauges of now and of the past, one under the other",
    ),
    (
        "Eq. 10",
        "L = Ĉ⁻¹ Ŝ: twice as many columns, the same least squares",
    ),
    (
        "Eq. 11",
        "‖F − F_past‖ ≥ F_th: what counts as different, on the conventional force",
    ),
    (
        "Eq. 12",
        "t − t_past ≤ t_th: no older than this; where there is none, S_past = S",
    ),
];

impl Help {
    /// Opens or closes it.
    pub fn toggle(&mut self) {
        self.open = !self.open;
    }

    /// Draws it while it is open.
    pub fn show(&mut self, context: &egui::Context, actions: &dyn Fn() -> Vec<Action>) {
        let mut open = self.open;
        egui::Window::new("Keys and words")
            .open(&mut open)
            .default_size([560.0, 420.0])
            .pivot(egui::Align2::CENTER_CENTER)
            .default_pos(context.content_rect().center())
            .show(context, |ui| {
                ui.horizontal(|ui| {
                    for (page, label) in PAGES {
                        ui.selectable_value(&mut self.page, page, label);
                    }
                });
                ui.separator();
                egui::ScrollArea::vertical()
                    .auto_shrink([false, false])
                    .show(ui, |ui| match self.page {
                        Page::Keys => keys(ui, &actions()),
                        Page::Mouse => rows(ui, "mouse", MOUSE.iter().copied()),
                        Page::Words => rows(ui, "words", WORDS.iter().copied()),
                        Page::Equations => {
                            ui.weak("R. Koike, S. Sakaino, T. Tsuji: Hysteresis Compensation in Force/Torque Sensors Using Time Series Information, 2019");
                            rows(ui, "equations", EQUATIONS.iter().copied());
                        }
                    });
            });
        self.open = open;
    }
}

fn keys(ui: &mut egui::Ui, actions: &[Action]) {
    let texts: Vec<(String, &str)> = actions
        .iter()
        .filter_map(|action| Some((ui.ctx().format_shortcut(&action.keys?), &*action.name)))
        .collect();
    let others = [
        ("Tab, Shift+Tab", "the next or last control"),
        ("Space, Enter", "presses the control that has the focus"),
        ("Arrows", "move a slider that has the focus"),
        ("Escape", "takes the cursors away, closes what floats"),
    ];
    let own = texts.iter().map(|(keys, name)| (&**keys, *name));
    rows(ui, "keys", own.chain(others));
}

fn rows<'a>(ui: &mut egui::Ui, name: &str, rows: impl Iterator<Item = (&'a str, &'a str)>) {
    egui::Grid::new(name)
        .num_columns(2)
        .striped(true)
        .spacing([16.0, 6.0])
        .show(ui, |ui| {
            for (left, right) in rows {
                ui.label(RichText::new(left).strong());
                ui.add(egui::Label::new(right).wrap());
                ui.end_row();
            }
        });
}
