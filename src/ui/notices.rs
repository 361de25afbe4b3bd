//! What there is to say, over the window: it comes for a while, and stands in a list until it is dismissed. Nothing moves for it.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use egui::{Color32, RichText};

use crate::engine::{Action, Engine, Level, Notice};
use crate::ui::command::Command;
use crate::ui::numbers::elided;

/// So many stand over the window, the newest ones.
const MAX_SHOWN: usize = 4;
/// How wide they are.
const WIDTH: f32 = 380.0;
/// How far above the lower edge of the window they stand: above the status line.
const ABOVE_STATUS: f32 = 34.0;
/// Characters of one that have room there; the list has all.
const MAX_CHARACTERS: usize = 400;

/// What is remembered of them between frames.
#[derive(Debug, Default)]
pub struct Notices {
    /// Since when each was there, by its number.
    since: BTreeMap<u64, Instant>,
    list: bool,
}

/// How long it stands over the window; an error until it is dismissed.
fn lasts(level: Level) -> Option<Duration> {
    match level {
        Level::Info => Some(Duration::from_secs(10)),
        Level::Warning => Some(Duration::from_secs(20)),
        Level::Error => None,
    }
}

impl Notices {
    /// Shows or hides the list of all.
    pub fn toggle_list(&mut self) {
        self.list = !self.list;
    }

    /// Draws the new ones over the window, and the list where it was asked for.
    pub fn show(&mut self, context: &egui::Context, engine: &Engine, out: &mut Vec<Command>) {
        let notices = &engine.notices;
        let now = Instant::now();
        let is_there = |number: &u64| notices.iter().any(|notice| notice.number == *number);
        self.since.retain(|number, _| is_there(number));
        let mut fresh = Vec::new();
        for (at, notice) in notices.iter().enumerate().rev() {
            let age = now - *self.since.entry(notice.number).or_insert(now);
            match lasts(notice.level).map(|lasts| lasts.checked_sub(age)) {
                None => fresh.push((at, notice)),
                Some(Some(left)) => {
                    context.request_repaint_after(left);
                    fresh.push((at, notice));
                }
                Some(None) => {}
            }
        }
        if !fresh.is_empty() && !self.list {
            self.over_window(context, &fresh, notices.len(), out);
        }
        if notices.is_empty() {
            self.list = false;
        }
        let mut open = self.list;
        egui::Window::new("Notices")
            .open(&mut open)
            .default_size([560.0, 260.0])
            .show(context, |ui| list(ui, notices, out));
        self.list = open;
    }

    fn over_window(
        &mut self,
        context: &egui::Context,
        fresh: &[(usize, &Notice)],
        n_all: usize,
        out: &mut Vec<Command>,
    ) {
        egui::Area::new(egui::Id::unique("notices"))
            .order(egui::Order::Foreground)
            .anchor(egui::Align2::RIGHT_BOTTOM, [-10.0, -ABOVE_STATUS])
            .show(context, |ui| {
                ui.set_max_width(WIDTH);
                for (at, notice) in fresh.iter().take(MAX_SHOWN).rev() {
                    egui::Frame::popup(ui.style()).show(ui, |ui| {
                        ui.set_width(WIDTH - 16.0);
                        one(ui, *at, notice, MAX_CHARACTERS, out);
                    });
                }
                egui::Frame::popup(ui.style()).show(ui, |ui| {
                    ui.set_width(WIDTH - 16.0);
                    ui.horizontal(|ui| {
                        let all = match n_all {
                            1 => "1 notice".to_owned(),
                            n => format!("All {n} notices"),
                        };
                        let all = ui.button(all);
                        if all
                            .on_hover_text("The list of all, to read and to copy")
                            .clicked()
                        {
                            self.list = true;
                        }
                        dismiss_all(ui, out);
                    });
                });
            });
    }
}

fn dismiss_all(ui: &mut egui::Ui, out: &mut Vec<Command>) {
    let dismiss = ui.button("Dismiss all");
    let dismiss = dismiss.on_hover_text("They were read; the list is empty then");
    if dismiss.clicked() {
        out.push(Action::DismissAll.into());
    }
}

/// All of them, newest first, with ways to copy and dismiss them.
fn list(ui: &mut egui::Ui, notices: &[Notice], out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let copy = ui.button("Copy all");
        let copy = copy.on_hover_text("Every notice, a line each");
        if copy.clicked() {
            let texts: Vec<_> = notices.iter().map(|notice| &*notice.text).collect();
            ui.copy_text(texts.join("\n"));
        }
        dismiss_all(ui, out);
    });
    egui::ScrollArea::vertical()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            for (at, notice) in notices.iter().enumerate().rev() {
                one(ui, at, notice, usize::MAX, out);
            }
        });
}

fn one(
    ui: &mut egui::Ui,
    at: usize,
    notice: &Notice,
    max_characters: usize,
    out: &mut Vec<Command>,
) {
    ui.horizontal_top(|ui| {
        let dismiss = ui.small_button("×");
        if dismiss.on_hover_text("Dismiss this notice").clicked() {
            out.push(Action::Dismiss(at).into());
        }
        let (label, color) = kind(notice.level, ui.visuals());
        ui.label(RichText::new(label).color(color));
        ui.add(egui::Label::new(elided(&notice.text, max_characters)).wrap());
    });
}

fn kind(level: Level, visuals: &egui::Visuals) -> (&'static str, Color32) {
    match level {
        Level::Info => ("Done", visuals.text_color()),
        Level::Warning => ("Warning", visuals.warn_fg_color),
        Level::Error => ("Error", visuals.error_fg_color),
    }
}
