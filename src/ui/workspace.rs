//! The arrangement of the panes in each workspace: one large pane, and smaller ones in a column at its right.

use egui::{CursorIcon, Sense, Ui, UiBuilder};

use crate::ui::{
    appearance::{focus_ring, is_compact},
    command::{Command, Pane, Workspace},
    controls::{Controls as _, named},
    pane::Cx,
};

/// Width of the border between two panes (points).
const BORDER: f32 = 6.0;
/// Widths of the right column (points): in a window at least as wide as the second number, and in a narrower one.
const RIGHT_WIDTHS: (f32, f32, f32) = (416.0, 1500.0, 360.0);
/// Minimum and maximum share of the window's width for the right column.
const RIGHT_SHARES: std::ops::RangeInclusive<f32> = 0.1..=0.6;
/// Width of the list of exports (points).
const CHECKLIST_WIDTH: f32 = 760.0;
const HEAD_HEIGHT: f32 = 30.0;
const DRAWER_WIDTHS: [(Pane, f32); 2] = [(Pane::RECORDINGS, 460.0), (Pane::SETTINGS, 480.0)];

/// The workspace on screen, and what the user has changed of its arrangement.
pub struct Workspaces {
    shown: Workspace,
    /// Pane that takes the place of all others.
    maximized: Option<Pane>,
    /// Pane that gets the keyboard focus in the next frame.
    focus: Option<Pane>,
    /// Pane that lies over the left part of the large pane.
    drawer: Option<Pane>,
    /// Width of the right column that the user chose (points).
    right_width: Option<f32>,
    /// True if a narrow window shows the right column.
    opens_right: bool,
}

impl Default for Workspaces {
    fn default() -> Self {
        Self {
            shown: Workspace::Calibrate,
            maximized: None,
            focus: None,
            drawer: None,
            right_width: None,
            opens_right: false,
        }
    }
}

/// Returns the large pane of a workspace, and the panes of the right column with their shares of its height.
fn panes(workspace: Workspace) -> (Pane, &'static [(Pane, f32)]) {
    match workspace {
        Workspace::Import => (Pane::CHANNELS, &[(Pane::RECORDINGS, 0.75), (Pane::NOTES, 0.25)]),
        Workspace::Calibrate => (Pane::TRACES, &[(Pane::ERRORS, 0.56), (Pane::LOOK_BACK, 0.44)]),
        Workspace::Loops => (Pane::LOOPS, &[(Pane::AXES, 0.34), (Pane::METROLOGY, 0.66)]),
        Workspace::Thresholds => (Pane::THRESHOLDS, &[(Pane::PAIRS, 0.33), (Pane::TRACES, 0.67)]),
        Workspace::Models => (Pane::MODELS, &[(Pane::TRADE, 0.5), (Pane::ERRORS, 0.5)]),
        Workspace::Check => (Pane::CHECK, &[]),
        Workspace::Export => (Pane::EXPORT, &[(Pane::CALIBRATION, 1.0)]),
    }
}

fn all_of(workspace: Workspace) -> impl Iterator<Item = Pane> {
    let (hero, right) = panes(workspace);
    std::iter::once(hero).chain(right.iter().map(|(pane, _)| *pane))
}

impl Workspaces {
    pub fn shown(&self) -> Workspace {
        self.shown
    }

    pub fn show(&mut self, workspace: Workspace) {
        self.shown = workspace;
        (self.maximized, self.drawer) = (None, None);
    }

    /// Returns true if the workspace shows the thresholds and the features of the model.
    pub fn has_dock(&self) -> bool {
        matches!(self.shown, Workspace::Calibrate | Workspace::Loops | Workspace::Thresholds)
    }

    /// Opens a pane as drawer, or closes it.
    pub fn toggle_drawer(&mut self, pane: Option<Pane>) {
        self.drawer = pane.filter(|pane| self.drawer != Some(*pane));
    }

    /// Opens or closes the right column of a narrow window.
    pub fn toggle_right(&mut self) {
        self.opens_right = !self.opens_right;
    }

    pub fn on_screen(&self) -> Vec<Pane> {
        let panes = match self.maximized {
            Some(pane) => vec![pane],
            None => all_of(self.shown).collect(),
        };
        panes.into_iter().chain(self.drawer).collect()
    }

    /// Shows a pane: in the present workspace, as a drawer, in the first workspace that has it, or else maximised.
    pub fn bring(&mut self, pane: Pane) {
        self.maximized.take_if(|shown| *shown != pane);
        let has = |place: Workspace| all_of(place).any(|other| other == pane);
        if has(self.shown) {
            (self.drawer, self.opens_right) = (None, true);
        } else if DRAWER_WIDTHS.iter().any(|(drawer, _)| *drawer == pane) {
            self.drawer = Some(pane);
        } else if let Some((place, ..)) = Workspace::ALL.into_iter().find(|(place, ..)| has(*place))
        {
            self.show(place);
        } else {
            (self.maximized, self.drawer) = (Some(pane), None);
        }
        self.focus = Some(pane);
    }

    /// Maximises a pane, or shows all panes again if a pane is maximised.
    pub fn toggle_maximized(&mut self, pane: Option<Pane>) {
        self.maximized = pane.filter(|_| self.maximized.is_none());
        self.drawer.take_if(|drawer| self.maximized == Some(*drawer));
    }

    pub fn draw(
        &mut self,
        ui: &mut Ui,
        cx: &mut Cx<'_>,
        draw: &mut dyn FnMut(&mut Ui, &mut Cx<'_>, Pane),
    ) {
        let whole = ui.available_rect_before_wrap();
        let mut drawing = Drawing { draw, focus: self.focus.take(), cx };
        if let Some(pane) = self.maximized {
            let about = "Shows all panes of the workspace again (F9)";
            drawing.head(ui, pane, Some(("All panes", about, Command::ToggleMaximized(None))));
            drawing.pane(ui, pane);
        } else {
            self.areas(ui, whole, &mut drawing);
        }
        if let Some(pane) = self.drawer {
            let width = DRAWER_WIDTHS.iter().find(|(drawer, _)| *drawer == pane);
            let width = width.map_or(whole.width(), |(_, width)| width.min(whole.width()));
            let rect = whole.with_max_x(whole.left() + width);
            let area = egui::Area::new(egui::Id::unique("drawer"))
                .order(egui::Order::Middle)
                .fixed_pos(rect.min);
            area.show(ui.ctx(), |ui| {
                let frame = egui::Frame::popup(ui.style()).inner_margin(0.0).corner_radius(0.0);
                frame.show(ui, |ui| {
                    let inside = rect.shrink(1.0);
                    ui.set_min_size(inside.size());
                    ui.set_max_size(inside.size());
                    let place = UiBuilder::new().max_rect(inside);
                    let mut ui = ui.new_child(place);
                    let about = "Closes this list (Escape)";
                    let close = ("Close", about, Command::ToggleDrawer(pane));
                    drawing.head(&mut ui, pane, Some(close));
                    drawing.pane(&mut ui, pane);
                });
            });
            let is_typing = ui.ctx().text_edit_focused() || egui::Popup::is_any_open(ui.ctx());
            if !is_typing && ui.input(|input| input.key_pressed(egui::Key::Escape)) {
                self.drawer = None;
            }
        }
    }

    fn areas(&mut self, ui: &mut Ui, whole: egui::Rect, drawing: &mut Drawing<'_, '_>) {
        let (wide, least, narrow) = RIGHT_WIDTHS;
        let usual = match self.shown {
            Workspace::Export => whole.width() - CHECKLIST_WIDTH,
            _ if whole.width() >= least => wide,
            _ => narrow,
        };
        let is_open = self.opens_right || self.shown == Workspace::Import || !is_compact(ui);
        let (hero, right) = panes(self.shown);
        let right = if is_open { right } else { &[] };
        let (least, most) = RIGHT_SHARES.into_inner();
        let width = self.right_width.unwrap_or(usual);
        let width = width.clamp(least * whole.width(), most * whole.width());
        let edge = if right.is_empty() { whole.right() } else { whole.right() - width };
        let column = whole.with_min_x((edge + BORDER).min(whole.right()));
        drawing.area(ui, whole.with_max_x(edge), hero, false);
        if right.is_empty() {
            return;
        }
        let border = whole.with_min_x(edge).with_max_x(edge + BORDER);
        let drag = ui.interact(border, ui.scope_id().with("border"), Sense::DRAG);
        let drag = drag.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
        if drag.dragged() {
            self.right_width = Some(width - drag.drag_delta().x);
        }
        let line = if drag.hovered() || drag.dragged() {
            ui.visuals().widgets.hovered.bg_fill
        } else {
            ui.visuals().faint_bg_color
        };
        ui.painter().rect_filled(border.shrink2(egui::vec2(2.0, 0.0)), 0.0, line);
        let mut top = column.top();
        for (pane, share) in right {
            let bottom = (top + share * column.height()).min(column.bottom());
            drawing.area(ui, column.with_min_y(top).with_max_y(bottom), *pane, true);
            top = bottom;
        }
    }
}

struct Drawing<'a, 'c> {
    draw: &'a mut dyn FnMut(&mut Ui, &mut Cx<'_>, Pane),
    focus: Option<Pane>,
    cx: &'a mut Cx<'c>,
}

impl Drawing<'_, '_> {
    fn area(&mut self, ui: &mut Ui, rect: egui::Rect, pane: Pane, has_head: bool) {
        let place = UiBuilder::new().max_rect(rect).id_salt(pane.key);
        let mut ui = ui.new_child(place);
        ui.shrink_clip_rect(rect);
        if has_head {
            self.head(&mut ui, pane, None);
        }
        self.pane(&mut ui, pane);
    }

    /// Draws the title of a pane, and a button with this label, explanation and command.
    fn head(&mut self, ui: &mut Ui, pane: Pane, button: Option<(&str, &str, Command)>) {
        ui.horizontal(|ui| {
            ui.set_height(HEAD_HEIGHT);
            ui.add_space(8.0);
            let title = egui::RichText::new(pane.title).size(15.0).strong();
            let title = ui.add(egui::Label::new(title).sense(Sense::click()));
            let title = title.on_hover_text("A double click maximises this pane");
            if title.double_clicked() {
                self.cx.out.send(Command::ToggleMaximized(Some(pane)));
            }
            let layout = egui::Layout::right_to_left(egui::Align::Center);
            ui.with_layout(layout, |ui| {
                ui.add_space(8.0);
                if let Some((label, about, command)) = button
                    && ui.press(label, about)
                {
                    self.cx.out.send(command);
                }
            });
        });
    }

    fn pane(&mut self, ui: &mut Ui, pane: Pane) {
        // The pane as a whole can take the keyboard focus; the Tab key then moves the focus to the controls of the pane.
        let rect = ui.available_rect_before_wrap();
        let id = egui::Id::unique(("pane", pane.key));
        let whole = ui.interact(rect, id, Sense::focusable_noninteractive());
        named(&whole, egui::Role::Pane, pane.title);
        if self.focus == Some(pane) {
            whole.request_focus();
        }
        if whole.has_focus() {
            focus_ring(ui.painter(), rect.shrink(1.0));
        }
        let place = UiBuilder::new().max_rect(rect.shrink2(egui::vec2(8.0, 4.0))).id_salt(pane.key);
        let mut ui = ui.new_child(place);
        ui.shrink_clip_rect(rect);
        (self.draw)(&mut ui, self.cx, pane);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::panes;

    fn named(key: &str) -> Pane {
        panes::named(key).unwrap()
    }

    #[test]
    fn every_pane_can_be_brought_and_a_workspace_shows_one_to_three() {
        for (workspace, ..) in Workspace::ALL {
            assert!((1..=3).contains(&all_of(workspace).count()));
        }
        for pane in panes::all() {
            let mut workspaces = Workspaces::default();
            workspaces.bring(pane);
            assert!(workspaces.on_screen().contains(&pane), "{}", pane.title);
        }
    }

    #[test]
    fn a_pane_is_brought_where_it_is_and_maximised() {
        let mut workspaces = Workspaces::default();
        workspaces.bring(named("loops"));
        assert_eq!(workspaces.shown(), Workspace::Loops);
        workspaces.bring(named("channels"));
        assert_eq!(workspaces.shown(), Workspace::Import);
        assert!(workspaces.on_screen().contains(&named("channels")));
        workspaces.bring(named("traces"));
        assert_eq!(workspaces.shown(), Workspace::Calibrate);
        workspaces.bring(named("live"));
        assert_eq!(workspaces.on_screen(), [named("live")]);
        workspaces.show(Workspace::Calibrate);
        workspaces.toggle_maximized(Some(named("traces")));
        assert_eq!(workspaces.on_screen(), [named("traces")]);
        workspaces.toggle_maximized(None);
        assert_eq!(workspaces.on_screen().len(), 3);
    }

    #[test]
    fn a_drawer_lies_over_the_workspace_until_it_is_closed() {
        let mut workspaces = Workspaces::default();
        workspaces.bring(named("settings"));
        assert_eq!(workspaces.shown(), Workspace::Calibrate);
        assert_eq!(workspaces.drawer, Some(named("settings")));
        workspaces.toggle_drawer(Some(named("recordings")));
        assert_eq!(workspaces.drawer, Some(named("recordings")));
        workspaces.toggle_drawer(Some(named("recordings")));
        assert_eq!(workspaces.drawer, None);
        workspaces.show(Workspace::Import);
        workspaces.bring(named("recordings"));
        assert_eq!(workspaces.drawer, None, "the workspace has the list already");
    }
}
