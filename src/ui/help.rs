//! Help window: the guide, the shortcuts, and the page About.

use std::sync::LazyLock;

use egui::{Label, RichText, ScrollArea, TextStyle, Ui};
use egui_commonmark::{CommonMarkCache, CommonMarkViewer};

use crate::{
    about::{LICENCES_OF_CRATES, OWN_LICENCES, built},
    ui::{actions::Action, command::Command, controls::Controls as _},
};

#[derive(Debug, Default)]
pub struct Help {
    open: bool,
    page: Page,
    guide: usize,
    about: About,
    laid_out: CommonMarkCache,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
enum Page {
    #[default]
    Guide,
    Shortcuts,
    About,
}

const PAGES: [(Page, &str, &str); 3] = [
    (Page::Guide, "Guide", "Explains the use of the program, page by page"),
    (Page::Shortcuts, "Shortcuts", "Keys and mouse actions"),
    (Page::About, "About", "Version, build and licences of the program"),
];

/// Prefix of the addresses by which the guide's pages refer to its pictures.
const IN_GUIDE: &str = "bytes://";
const PICTURES: [(&str, &[u8]); 4] = [
    ("cost.png", include_bytes!("../../assets/guide/cost.png")),
    ("first-import.png", include_bytes!("../../assets/guide/first-import.png")),
    ("first-errors.png", include_bytes!("../../assets/guide/first-errors.png")),
    ("first-enough.png", include_bytes!("../../assets/guide/first-enough.png")),
];
/// Pages of the guide, each with its title.
const GUIDE: [(&str, &str); 17] = [
    ("First steps", include_str!("../../assets/guide/first-steps.md")),
    ("Your files", include_str!("../../assets/guide/your-files.md")),
    ("Window", include_str!("../../assets/guide/window.md")),
    ("Recordings", include_str!("../../assets/guide/recordings.md")),
    ("Command line", include_str!("../../assets/guide/command-line.md")),
    ("Python", include_str!("../../assets/guide/python.md")),
    ("Exports", include_str!("../../assets/guide/exports.md")),
    ("On a robot", include_str!("../../assets/guide/robot.md")),
    ("Many sensors", include_str!("../../assets/guide/many-sensors.md")),
    ("Calibration file", include_str!("../../assets/guide/calibration-file.md")),
    ("Where the error comes from", include_str!("../../assets/guide/checking.md")),
    ("Choosing a model", include_str!("../../assets/guide/choosing.md")),
    ("Method", include_str!("../../assets/guide/method.md")),
    ("Equations", include_str!("../../assets/guide/equations.md")),
    ("Built-in sensor", include_str!("../../assets/guide/built-in-sensor.md")),
    ("Speed", include_str!("../../assets/guide/speed.md")),
    ("Glossary", include_str!("../../assets/guide/glossary.md")),
];

/// Returns actions that open the pages of the guide in which a text occurs.
pub fn pages_with(typed: &str) -> Vec<Action> {
    const FEWEST_BYTES: usize = 3;
    static IN_LOWER_CASE: LazyLock<Vec<String>> =
        LazyLock::new(|| GUIDE.iter().map(|(_, text)| text.to_lowercase()).collect());
    let typed = typed.trim().to_lowercase();
    let page = |(at, (title, _)): (usize, &(&str, &str))| {
        let is_found = typed.len() >= FEWEST_BYTES && IN_LOWER_CASE[at].contains(&typed);
        is_found.then(|| Action {
            name: format!("Guide: {title}"),
            explanation: "Opens this page of the guide, which contains the typed text".into(),
            keys: None,
            enabled: true,
            command: Command::ShowGuide(at),
        })
    };
    GUIDE.iter().enumerate().filter_map(page).collect()
}

impl Help {
    pub fn is_open(&self) -> bool {
        self.open
    }

    pub fn toggle(&mut self) {
        self.open = !self.open;
    }

    /// Opens the page of the guide with this index.
    pub fn open_guide(&mut self, guide: usize) {
        *self = Self { open: true, guide, ..Self::default() };
    }

    pub fn open_about(&mut self) {
        self.open = true;
        self.page = Page::About;
    }

    pub fn show(&mut self, context: &egui::Context, actions: &dyn Fn() -> Vec<Action>) {
        if !self.open {
            return;
        }
        egui_extras::install_image_loaders(context);
        for (name, bytes) in PICTURES {
            context.include_bytes(format!("{IN_GUIDE}{name}"), bytes);
        }
        let is_on_top = context.memory(|memory| memory.top_modal_layer().is_none());
        let mut open = !(is_on_top
            && context
                .input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Escape)));
        egui::Window::new("Help")
            .open(&mut open)
            .default_size([720.0, 480.0])
            .pivot(egui::Align2::CENTER_CENTER)
            .default_pos(context.content_rect().center())
            .show(context, |ui| {
                ui.horizontal(|ui| {
                    for (page, label, explanation) in PAGES {
                        ui.select(&mut self.page, page, label, explanation);
                    }
                });
                if self.page == Page::Guide {
                    ui.horizontal_wrapped(|ui| {
                        for (at, (title, _)) in GUIDE.iter().enumerate() {
                            ui.select(&mut self.guide, at, title, "Shows this page of the guide");
                        }
                    });
                }
                ui.separator();
                let (page, guide) = (self.page, self.guide);
                let area = ScrollArea::vertical().id_salt((page, guide));
                let area = area.auto_shrink([false, false]);
                match page {
                    Page::Guide => {
                        area.show(ui, |ui| guide_page(ui, &mut self.laid_out, GUIDE[guide].1));
                    }
                    Page::Shortcuts => {
                        area.show(ui, |ui| shortcuts(ui, &actions()));
                    }
                    Page::About => self.about.ui(ui),
                }
            });
        self.open = open;
    }
}

/// Draws a page of the guide. Code blocks are drawn here, because the Markdown viewer's copy button needs a glyph that the
/// window's fonts lack.
fn guide_page(ui: &mut Ui, laid_out: &mut CommonMarkCache, text: &str) {
    for (at, part) in text.split("\n```").enumerate() {
        ui.push_id(at, |ui| match at % 2 {
            0 => {
                CommonMarkViewer::new()
                    .default_implicit_uri_scheme(IN_GUIDE)
                    .show(ui, laid_out, part);
            }
            _ => {
                let (_language, code) = part.split_once('\n').unwrap_or_default();
                let frame = egui::Frame::group(ui.style()).fill(ui.visuals().extreme_bg_color);
                frame.show(ui, |ui| {
                    ui.add(Label::new(RichText::new(code).monospace()).extend());
                    if ui.press_small("Copy", "Copies these lines of code to the clipboard") {
                        ui.ctx().copy_text(code.to_owned());
                    }
                });
            }
        });
    }
}

/// The About page: version, build, and the licences of the program and of its crates.
#[derive(Debug, Default)]
struct About {
    shown: usize,
}

impl About {
    fn ui(&mut self, ui: &mut Ui) {
        ui.heading("LoopScope");
        ui.label("Calibrates force/torque sensors and compensates their hysteresis");
        ui.add_space(6.0);
        egui::Grid::new("built").num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
            for (name, value) in built() {
                ui.label(RichText::new(name).strong());
                ui.label(value);
                ui.end_row();
            }
        });
        if ui.press(
            "Copy version",
            "Copies the version and the build of the program, to be pasted into a fault report",
        ) {
            let lines = built().map(|(name, value)| format!("{name}: {value}"));
            ui.ctx().copy_text(lines.join("\n"));
        }
        ui.separator();
        let crates = "Lists the Rust crates in this program, with their authors and licences";
        let of_program = OWN_LICENCES
            .map(|(name, text)| (name, text, "Shows the text of this licence of the program"));
        let texts = [of_program[0], of_program[1], ("Crates", LICENCES_OF_CRATES, crates)];
        ui.horizontal(|ui| {
            ui.label("Licence: MIT or Apache-2.0, at your choice");
            for (at, (name, _, explanation)) in texts.iter().enumerate() {
                ui.select(&mut self.shown, at, name, explanation);
            }
        });
        let (name, text, _) = texts[self.shown];
        let lines: Vec<&str> = text.lines().collect();
        let height = ui.text_style_height(&TextStyle::Monospace);
        ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
        ScrollArea::both().id_salt(name).auto_shrink([false, false]).show_rows(
            ui,
            height,
            lines.len(),
            |ui, rows| {
                for line in &lines[rows] {
                    ui.monospace(*line);
                }
            },
        );
    }
}

fn shortcuts(ui: &mut Ui, actions: &[Action]) {
    let context = ui.ctx().clone();
    let of_actions = actions
        .iter()
        .filter_map(|action| Some((context.format_shortcut(&action.keys?), &*action.name)));
    let others = [
        ("Tab, Shift+Tab", "moves the focus to the next or previous control"),
        ("Space, Enter", "presses the control that has the focus"),
        ("Arrows", "move the slider or the plot that has the focus"),
        ("+, −", "zoom the plot that has the focus; with Alt, zoom its value axis"),
        ("Backspace", "shows all data of the plot that has the focus"),
        ("Shift+F10, Menu", "opens the menu of the plot that has the focus"),
        ("Escape", "removes the cursors, closes dialogs and lists"),
    ];
    let others = others.map(|(keys, name)| (keys.to_owned(), name));
    egui::Grid::new("shortcuts").num_columns(2).striped(true).spacing([16.0, 6.0]).show(ui, |ui| {
        for (keys, name) in of_actions.chain(others) {
            ui.label(RichText::new(keys).strong());
            ui.add(Label::new(name).wrap());
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_of_the_guide_are_found_by_the_words_of_the_field() {
        let words = "strain gauge|load cell|HX711|amplifier|gravity|tool weight|sensor frame|zero return|dead weight|testing machine";
        for words in words.split('|') {
            assert!(!pages_with(words).is_empty(), "{words}");
        }
        assert!(pages_with("no such words anywhere").is_empty() && pages_with(" ").is_empty());
    }

    #[test]
    fn every_picture_of_the_guide_is_in_the_program() {
        for (title, text) in GUIDE {
            for picture in text.split("](").skip(1) {
                let name = picture.split(')').next().unwrap_or_default();
                let is_there = PICTURES.iter().any(|(known, _)| *known == name);
                let is_other = !name.ends_with(".png") || name.starts_with("../");
                assert!(is_there || is_other, "{title}: {name}");
            }
        }
    }
}
