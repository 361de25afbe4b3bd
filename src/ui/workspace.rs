//! The arrangement of the panes: each workspace has groups of tabs, between which the user can drag the borders.

use egui::{CursorIcon, Sense, Ui, UiBuilder};

use crate::ui::{
    appearance::focus_ring,
    calibration_pane::PANE as CALIBRATION,
    channels_pane::PANE as CHANNELS,
    check_pane::PANE as CHECK,
    command::{Command, Out, Pane, Workspace},
    errors_pane::PANE as ERRORS,
    export_pane::PANE as EXPORT,
    live_pane::PANE as LIVE,
    loops_pane::PANE as LOOPS,
    metrology_pane::PANE as METROLOGY,
    models_pane::PANE as MODELS,
    notes_pane::PANE as NOTES,
    recordings_panel::PANE as RECORDINGS,
    settings_panel::PANE as SETTINGS,
    thresholds_pane::PANE as THRESHOLDS,
    trace_panes::PANE as TRACES,
};

/// Width of the border between two areas (points).
const BORDER: f32 = 4.0;
/// Share of the space that each of two areas keeps while their border is dragged.
const MIN_SHARE: f32 = 0.1;

/// Areas of all workspaces, and the workspace on screen.
pub struct Workspaces {
    shown: Workspace,
    /// Areas of the workspaces in the order of [`Workspace::ALL`].
    areas: [Area; Workspace::ALL.len()],
    maximized: Option<Pane>,
    /// Pane that gets the keyboard focus in the next frame.
    focus: Option<Pane>,
}

impl Default for Workspaces {
    fn default() -> Self {
        let areas = Workspace::ALL.map(|(workspace, ..)| Area::of(workspace));
        Self { shown: Workspace::Calibrate, areas, maximized: None, focus: None }
    }
}

impl Workspaces {
    pub fn shown(&self) -> Workspace {
        self.shown
    }

    pub fn show(&mut self, workspace: Workspace) {
        self.shown = workspace;
        self.maximized = None;
    }

    /// Returns the panes whose tabs are selected.
    pub fn on_screen(&self) -> Vec<Pane> {
        let area = &self.areas[self.shown as usize];
        self.maximized.map_or_else(|| area.on_screen(), |pane| vec![pane])
    }

    /// Selects the tab of a pane, in the present workspace or else in the first workspace that contains the pane.
    pub fn bring(&mut self, pane: Pane) {
        self.maximized.take_if(|shown| *shown != pane);
        self.focus = Some(pane);
        let all = Workspace::ALL.map(|(workspace, ..)| workspace);
        let mut places = std::iter::once(self.shown).chain(all);
        let place = places.find(|place| self.areas[*place as usize].select(pane));
        if let Some(place) = place.filter(|place| *place != self.shown) {
            self.show(place);
        }
    }

    /// Maximises a pane, or shows all panes again if a pane is maximised.
    pub fn toggle_maximized(&mut self, pane: Option<Pane>) {
        self.maximized = pane.filter(|_| self.maximized.is_none());
    }

    pub fn draw(
        &mut self,
        ui: &mut Ui,
        out: &mut Out,
        draw: &mut dyn FnMut(&mut Ui, &mut Out, Pane),
    ) {
        let mut drawing = Drawing { draw, focus: self.focus.take(), out };
        if let Some(pane) = self.maximized {
            ui.horizontal(|ui| {
                let title = egui::Label::new(egui::RichText::new(pane.title).strong());
                let title = ui.add(title.sense(Sense::click()));
                let back = ui
                    .button("All panes")
                    .on_hover_text("Shows all panes of the workspace again (F9)");
                if title.double_clicked() || back.clicked() {
                    drawing.out.send(Command::ToggleMaximized(None));
                }
            });
            drawing.pane(ui, pane);
        } else {
            self.areas[self.shown as usize].draw(ui, &mut drawing);
        }
    }
}

/// Part of a workspace.
enum Area {
    /// Panes as tabs, and the pane whose tab is selected.
    Tabs(&'static [Pane], Pane),
    /// Two areas, one above the other if `is_column` or else side by side, and the share of the first.
    Two { is_column: bool, share: f32, parts: Box<[Self; 2]> },
}

impl Area {
    fn of(workspace: Workspace) -> Self {
        let tabs = |panes: &'static [Pane]| Self::Tabs(panes, panes[0]);
        let row = |share, left, right| {
            let parts = Box::new([left, right]);
            Self::Two { is_column: false, share, parts }
        };
        let column = |share, above, below| {
            let parts = Box::new([above, below]);
            Self::Two { is_column: true, share, parts }
        };
        let settings_above = |share, below| column(share, tabs(&[SETTINGS]), tabs(below));
        match workspace {
            Workspace::Import => {
                let right = column(0.62, tabs(&[TRACES, CHANNELS]), tabs(&[NOTES]));
                row(0.4, tabs(&[RECORDINGS]), right)
            }
            Workspace::Calibrate => {
                let right = column(0.66, tabs(&[TRACES]), tabs(&[ERRORS]));
                row(0.28, settings_above(0.54, &[RECORDINGS]), right)
            }
            Workspace::Loops => {
                let foot = row(0.55, tabs(&[TRACES]), tabs(&[METROLOGY]));
                let right = column(0.5, tabs(&[LOOPS]), foot);
                row(0.24, settings_above(0.5, &[RECORDINGS]), right)
            }
            Workspace::Thresholds => {
                let right = column(0.5, tabs(&[TRACES]), tabs(&[THRESHOLDS]));
                row(0.32, settings_above(0.5, &[ERRORS]), right)
            }
            Workspace::Models => {
                let right = column(0.72, tabs(&[MODELS]), tabs(&[ERRORS]));
                row(0.26, settings_above(0.6, &[RECORDINGS]), right)
            }
            Workspace::Check => {
                let right = column(0.5, tabs(&[CHECK]), tabs(&[TRACES, LIVE]));
                row(0.34, tabs(&[RECORDINGS]), right)
            }
            Workspace::Export => {
                let right = column(0.66, tabs(&[CALIBRATION]), tabs(&[ERRORS, NOTES]));
                row(0.34, tabs(&[EXPORT]), right)
            }
        }
    }

    fn on_screen(&self) -> Vec<Pane> {
        match self {
            Self::Tabs(_, selected) => vec![*selected],
            Self::Two { parts, .. } => parts.iter().flat_map(Self::on_screen).collect(),
        }
    }

    /// Selects the tab of a pane. Returns false if the area does not contain the pane.
    fn select(&mut self, pane: Pane) -> bool {
        match self {
            Self::Tabs(panes, selected) => {
                let is_here = panes.contains(&pane);
                if is_here {
                    *selected = pane;
                }
                is_here
            }
            Self::Two { parts, .. } => parts.iter_mut().any(|part| part.select(pane)),
        }
    }

    fn draw(&mut self, ui: &mut Ui, drawing: &mut Drawing<'_>) {
        match self {
            Self::Tabs(panes, selected) => {
                ui.horizontal(|ui| {
                    for pane in *panes {
                        let about =
                            format!("{}. A double click maximises the pane", pane.explanation);
                        let tab = ui.selectable_value(selected, *pane, pane.title);
                        if tab.on_hover_text(about).double_clicked() {
                            drawing.out.send(Command::ToggleMaximized(Some(*pane)));
                        }
                    }
                });
                drawing.pane(ui, *selected);
            }
            Self::Two { is_column, share, parts } => {
                let whole = ui.available_rect_before_wrap();
                // Index of the coordinate across the border: x, or y in a column.
                let across = usize::from(*is_column);
                let (start, end) = (whole.min[across], whole.max[across]);
                let at = egui::lerp(start..=end, *share);
                let beyond = (at + BORDER).min(end);
                let (mut first, mut border, mut second) = (whole, whole, whole);
                first.max[across] = at;
                (border.min[across], border.max[across]) = (at, beyond);
                second.min[across] = beyond;
                let cursor = [CursorIcon::ResizeHorizontal, CursorIcon::ResizeVertical][across];
                let drag = ui.interact(border, ui.scope_id().with("border"), Sense::DRAG);
                let drag = drag.on_hover_and_drag_cursor(cursor);
                if drag.dragged() {
                    let moved = drag.drag_delta()[across] / (end - start);
                    *share = (*share + moved).clamp(MIN_SHARE, 1.0 - MIN_SHARE);
                }
                let line = if drag.hovered() || drag.dragged() {
                    ui.visuals().widgets.hovered.bg_fill
                } else {
                    ui.visuals().faint_bg_color
                };
                ui.painter().rect_filled(border, 0.0, line);
                for (part, rect) in parts.iter_mut().zip([first, second]) {
                    let place = UiBuilder::new().max_rect(rect).id_salt(rect == first);
                    let mut ui = ui.new_child(place);
                    ui.shrink_clip_rect(rect);
                    part.draw(&mut ui, drawing);
                }
            }
        }
    }
}

struct Drawing<'a> {
    draw: &'a mut dyn FnMut(&mut Ui, &mut Out, Pane),
    focus: Option<Pane>,
    out: &'a mut Out,
}

impl Drawing<'_> {
    fn pane(&mut self, ui: &mut Ui, pane: Pane) {
        // The pane as a whole can take the keyboard focus; the Tab key then moves the focus to the controls of the pane.
        let rect = ui.available_rect_before_wrap();
        let id = egui::Id::unique(("pane", pane.key));
        let whole = ui.interact(rect, id, Sense::focusable_noninteractive());
        whole.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Pane, true, pane.title));
        if self.focus == Some(pane) {
            whole.request_focus();
        }
        if whole.has_focus() {
            focus_ring(ui.painter(), rect.shrink(1.0));
        }
        let place = UiBuilder::new().max_rect(rect.shrink2(egui::vec2(6.0, 4.0))).id_salt(pane.key);
        let mut ui = ui.new_child(place);
        ui.shrink_clip_rect(rect);
        (self.draw)(&mut ui, self.out, pane);
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
    fn every_pane_has_a_workspace_and_each_shows_three_to_five_at_once() {
        let mut areas = Workspaces::default().areas;
        assert!(areas.iter().all(|area| (3..=5).contains(&area.on_screen().len())));
        for pane in panes::all() {
            assert!(areas.iter_mut().any(|area| area.select(pane)), "{}", pane.title);
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
        assert_eq!(workspaces.on_screen().len(), 4);
    }
}
