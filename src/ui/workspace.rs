//! The arrangement of the panes in each workspace: one large pane, and smaller ones in a column at its right.

use egui::{CursorIcon, Sense, Ui, UiBuilder};

use crate::ui::{
    appearance::{focus_ring, is_compact},
    command::{Command, Pane, Workspace},
    controls::named,
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

/// Areas of all workspaces, and the workspace on screen.
pub struct Workspaces {
    shown: Workspace,
    /// Areas of the workspaces in the order of [`Workspace::ALL`]. The first area is the large one.
    areas: [Vec<Area>; Workspace::ALL.len()],
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

/// Place of one pane, or of several panes as tabs.
struct Area {
    panes: &'static [Pane],
    selected: Pane,
    /// Share of the height of the right column.
    share: f32,
}

impl Default for Workspaces {
    fn default() -> Self {
        let areas = Workspace::ALL.map(|(workspace, ..)| areas(workspace));
        Self {
            shown: Workspace::Calibrate,
            areas,
            maximized: None,
            focus: None,
            drawer: None,
            right_width: None,
            opens_right: false,
        }
    }
}

fn areas(workspace: Workspace) -> Vec<Area> {
    let all: &[(&'static [Pane], f32)] = match workspace {
        Workspace::Import => &[
            (&[Pane::TRACES, Pane::CHANNELS], 0.0),
            (&[Pane::RECORDINGS], 0.75),
            (&[Pane::NOTES], 0.25),
        ],
        Workspace::Calibrate => {
            &[(&[Pane::TRACES], 0.0), (&[Pane::ERRORS], 0.56), (&[Pane::LOOK_BACK], 0.44)]
        }
        Workspace::Loops => {
            &[(&[Pane::LOOPS], 0.0), (&[Pane::AXES], 0.34), (&[Pane::METROLOGY], 0.66)]
        }
        Workspace::Thresholds => {
            &[(&[Pane::THRESHOLDS], 0.0), (&[Pane::PAIRS], 0.33), (&[Pane::TRACES], 0.67)]
        }
        Workspace::Models => {
            &[(&[Pane::MODELS], 0.0), (&[Pane::TRADE], 0.5), (&[Pane::ERRORS], 0.5)]
        }
        Workspace::Check => &[(&[Pane::CHECK, Pane::LIVE], 0.0)],
        Workspace::Export => &[(&[Pane::EXPORT], 0.0), (&[Pane::CALIBRATION], 1.0)],
    };
    let area =
        |(panes, share): &(&'static [Pane], f32)| Area { panes, selected: panes[0], share: *share };
    all.iter().map(area).collect()
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

    /// Returns the panes whose tabs are selected.
    pub fn on_screen(&self) -> Vec<Pane> {
        let areas = self.areas[self.shown as usize].iter().map(|area| area.selected);
        let areas = self.maximized.map_or_else(|| areas.collect(), |pane| vec![pane]);
        areas.into_iter().chain(self.drawer).collect()
    }

    /// Selects the tab of a pane, in the present workspace or else in the first workspace that contains the pane. A pane that
    /// is in no area of the present workspace and can be a drawer becomes the drawer.
    pub fn bring(&mut self, pane: Pane) {
        self.maximized.take_if(|shown| *shown != pane);
        self.focus = Some(pane);
        let mut select = |place: Workspace| {
            let mut areas = self.areas[place as usize].iter_mut();
            let area = areas.find(|area| area.panes.contains(&pane));
            area.map(|area| area.selected = pane).is_some()
        };
        if select(self.shown) {
            (self.drawer, self.opens_right) = (None, true);
        } else if DRAWER_WIDTHS.iter().any(|(drawer, _)| *drawer == pane) {
            self.drawer = Some(pane);
        } else if let Some((place, ..)) = Workspace::ALL.iter().find(|(place, ..)| select(*place)) {
            self.show(*place);
        }
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
            drawing.maximized(ui, pane);
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
                    drawing.head(&mut ui, &mut None, &[pane]);
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
        let areas = &mut self.areas[self.shown as usize];
        let [hero, right @ ..] = &mut areas[..] else { return };
        let right = if is_open { right } else { &mut [] };
        let (least, most) = RIGHT_SHARES.into_inner();
        let width = self.right_width.unwrap_or(usual);
        let width = width.clamp(least * whole.width(), most * whole.width());
        let edge = if right.is_empty() { whole.right() } else { whole.right() - width };
        let column = whole.with_min_x((edge + BORDER).min(whole.right()));
        hero.draw(ui, whole.with_max_x(edge), false, drawing);
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
        for area in right {
            let bottom = (top + area.share * column.height()).min(column.bottom());
            area.draw(ui, column.with_min_y(top).with_max_y(bottom), true, drawing);
            top = bottom;
        }
    }
}

impl Area {
    fn draw(
        &mut self,
        ui: &mut Ui,
        rect: egui::Rect,
        has_head: bool,
        drawing: &mut Drawing<'_, '_>,
    ) {
        let place = UiBuilder::new().max_rect(rect).id_salt(self.panes[0].key);
        let mut ui = ui.new_child(place);
        ui.shrink_clip_rect(rect);
        if has_head || self.panes.len() > 1 {
            let mut selected = Some(self.selected);
            drawing.head(&mut ui, &mut selected, self.panes);
            self.selected = selected.unwrap_or(self.selected);
        }
        drawing.pane(&mut ui, self.selected);
    }
}

struct Drawing<'a, 'c> {
    draw: &'a mut dyn FnMut(&mut Ui, &mut Cx<'_>, Pane),
    focus: Option<Pane>,
    cx: &'a mut Cx<'c>,
}

impl Drawing<'_, '_> {
    /// Draws the title of a pane, or the tabs of several panes.
    fn head(&mut self, ui: &mut Ui, selected: &mut Option<Pane>, panes: &[Pane]) {
        ui.horizontal(|ui| {
            ui.set_height(HEAD_HEIGHT);
            ui.add_space(8.0);
            for pane in panes {
                let about = format!("{}. A double click maximises the pane", pane.explanation);
                let title = egui::RichText::new(pane.title).size(15.0);
                let tab = match panes {
                    [_] => ui.add(egui::Label::new(title.strong()).sense(Sense::click())),
                    _ => ui.selectable_value(selected, Some(*pane), title),
                };
                if tab.on_hover_text(about).double_clicked() {
                    self.cx.out.send(Command::ToggleMaximized(Some(*pane)));
                }
            }
            if let (None, [pane]) = (&selected, panes) {
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.add_space(8.0);
                    let close = ui.button("Close").on_hover_text("Closes this list (Escape)");
                    if close.clicked() {
                        self.cx.out.send(Command::ToggleDrawer(*pane));
                    }
                });
            }
        });
    }

    fn maximized(&mut self, ui: &mut Ui, pane: Pane) {
        ui.horizontal(|ui| {
            ui.add_space(8.0);
            let title = egui::Label::new(egui::RichText::new(pane.title).strong());
            let title = ui.add(title.sense(Sense::click()));
            let back =
                ui.button("All panes").on_hover_text("Shows all panes of the workspace again (F9)");
            if title.double_clicked() || back.clicked() {
                self.cx.out.send(Command::ToggleMaximized(None));
            }
        });
        self.pane(ui, pane);
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
        let shown = Workspaces::default();
        assert!(shown.areas.iter().all(|areas| (1..=3).contains(&areas.len())));
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
        assert_eq!(workspaces.shown(), Workspace::Import);
        assert!(
            !workspaces.on_screen().contains(&named("channels")),
            "one tab of a group is selected"
        );
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
