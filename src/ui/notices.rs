//! Notices over the lower right corner of the large pane. A notice is shown for some seconds, and stays in a list until the user
//! dismisses it.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use egui::{Color32, Rect, RichText, Ui};

use crate::{
    engine::{Action, Engine, Level, Notice},
    shown::counted,
    ui::{command::Out, controls::Controls as _, numbers::elided},
};

const MAX_SHOWN: usize = 3;
const WIDTH: f32 = 344.0;
/// Distance of the notices from the right and lower edge of the large pane (points), above the tick labels of its plot.
const FROM_CORNER: egui::Vec2 = egui::vec2(12.0, 40.0);
/// Factor by which a notice stays on screen longer while the engine computes, because the user may look elsewhere and frames
/// are drawn late.
const SLOWER_WHILE_BUSY: u32 = 4;
/// Maximum number of characters shown of a notice; the list of notices shows the whole text.
const MAX_CHARACTERS: usize = 240;
/// Time that a notice stays on screen. An error stays until the user dismisses it.
const LASTS: Duration = Duration::from_secs(6);

#[derive(Debug, Default)]
pub struct Notices {
    /// Time that each notice was on screen while the pointer was not on it. The key is the number of the notice.
    stood: BTreeMap<u64, Duration>,
    /// Time of the last frame in which notices were drawn; true if the pointer was on a notice.
    drawn: Option<(Instant, bool)>,
    list: bool,
}

impl Notices {
    pub fn toggle_list(&mut self) {
        self.list = !self.list;
    }

    /// Draws the notices in the lower right corner of `hero`, the large pane.
    pub fn show(&mut self, ui: &mut Ui, engine: &Engine, hero: Rect, out: &mut Out) {
        let context = &ui.ctx().clone();
        let notices = &engine.notices;
        let now = Instant::now();
        let slower = if engine.is_busy() { SLOWER_WHILE_BUSY } else { 1 };
        let passed = match self.drawn {
            Some((last, false)) => (now - last) / slower,
            _ => Duration::ZERO,
        };
        let is_there = |number: &u64| notices.iter().any(|notice| notice.number == *number);
        self.stood.retain(|number, _| is_there(number));
        let mut fresh = Vec::new();
        for (at, notice) in notices.iter().enumerate().rev() {
            let stood = self.stood.entry(notice.number);
            let stood = stood.and_modify(|stood| *stood += passed).or_default();
            let left = LASTS.checked_sub(*stood);
            if let Some(left) = left {
                context.request_repaint_after(left * slower);
            }
            if left.is_some() || notice.level == Level::Error {
                fresh.push((at, notice));
            }
        }
        let is_pointed_at = !fresh.is_empty()
            && !self.list
            && self.in_corner(ui, &fresh, (notices.len(), hero), out);
        self.drawn = Some((now, is_pointed_at));
        if notices.is_empty() {
            self.list = false;
        }
        let mut open = self.list;
        egui::Window::new("Notices")
            .open(&mut open)
            .default_size([560.0, 260.0])
            .default_pos(hero.min)
            .show(context, |ui| list(ui, notices, out));
        self.list = open;
    }

    fn in_corner(
        &mut self,
        ui: &mut Ui,
        fresh: &[(usize, &Notice)],
        (n_all, hero): (usize, Rect),
        out: &mut Out,
    ) -> bool {
        let width = WIDTH.min(hero.width() - 16.0);
        let area = egui::Area::new(egui::Id::unique("notices"))
            .order(egui::Order::Foreground)
            .pivot(egui::Align2::RIGHT_BOTTOM)
            .fixed_pos(hero.right_bottom() - FROM_CORNER);
        let panel = area.show(ui.ctx(), |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(width);
                for (at, notice) in fresh.iter().take(MAX_SHOWN).rev() {
                    let row = ui.scope(|ui| one(ui, *at, notice, MAX_CHARACTERS, out));
                    // A click anywhere on the row dismisses the notice. The small button serves users without a mouse.
                    let is_pressed = row.response.contains_pointer()
                        && ui.input(|input| input.pointer.primary_clicked());
                    if is_pressed && !row.inner {
                        out.send(Action::Dismiss(*at));
                    }
                }
                ui.horizontal(|ui| {
                    if ui
                        .press_small(counted(n_all, "notice"), "Lists all notices to read and copy")
                    {
                        self.list = true;
                    }
                    dismiss_all(ui, out);
                });
            })
        });
        panel.response.contains_pointer()
    }
}

fn dismiss_all(ui: &mut Ui, out: &mut Out) {
    if ui.press("Dismiss all", "Empties this list") {
        out.send(Action::DismissAll);
    }
}

fn list(ui: &mut Ui, notices: &[Notice], out: &mut Out) {
    ui.horizontal(|ui| {
        if ui.press("Copy all", "Copies all notices, one on each line") {
            let texts: Vec<_> = notices.iter().map(|notice| &*notice.text).collect();
            ui.copy_text(texts.join("\n"));
        }
        dismiss_all(ui, out);
    });
    egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        for (at, notice) in notices.iter().enumerate().rev() {
            one(ui, at, notice, usize::MAX, out);
        }
    });
}

/// Draws a notice. Returns true if it was dismissed.
fn one(ui: &mut Ui, at: usize, notice: &Notice, max_characters: usize, out: &mut Out) -> bool {
    let row = ui.horizontal_top(|ui| {
        let is_dismissed = ui.press_small("×", "Dismisses this notice");
        if is_dismissed {
            out.send(Action::Dismiss(at));
        }
        let (label, color) = kind(notice.level, ui.visuals());
        ui.label(RichText::new(label).color(color));
        ui.add(egui::Label::new(elided(&notice.text, max_characters)).wrap());
        is_dismissed
    });
    row.inner
}

fn kind(level: Level, visuals: &egui::Visuals) -> (&'static str, Color32) {
    match level {
        Level::Info => ("Done", visuals.text_color()),
        Level::Warning => ("Warning", visuals.warn_fg_color),
        Level::Error => ("Error", visuals.error_fg_color),
    }
}
