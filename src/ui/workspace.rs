//! The arrangement of the panes: for each workspace a tree of tabs, rows and columns that the user can drag.

use std::collections::BTreeMap;

use egui::{Sense, Ui};
use egui_tiles::{
    Behavior, Container, Linear, LinearDir, SimplificationOptions, TabState, Tile, TileId, Tiles,
    Tree, UiResponse,
};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::ui::{
    appearance::focus_ring,
    command::{Command, Out, Pane, Workspace},
    panes, trace_panes,
};

impl Serialize for Pane {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key)
    }
}

impl<'de> Deserialize<'de> for Pane {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        panes::named(&key).ok_or_else(|| de::Error::custom(format!("no pane is called {key}")))
    }
}

/// Returns the panes in the order of the menus.
fn in_order(panes: impl Iterator<Item = Pane>) -> Vec<Pane> {
    let mut panes: Vec<Pane> = panes.collect();
    panes.sort_by_key(|pane| panes::all().position(|known| known == *pane));
    panes
}

/// Arrangements of all workspaces, and the workspace on screen.
#[derive(Serialize, Deserialize)]
pub struct Workspaces {
    shown: Workspace,
    arrangements: BTreeMap<Workspace, Arrangement>,
    #[serde(skip)]
    maximized: Option<Pane>,
}

impl Default for Workspaces {
    fn default() -> Self {
        let shown = Workspace::Calibrate;
        let arrangements = [(shown, Arrangement::of(shown))].into();
        Self { shown, arrangements, maximized: None }
    }
}

impl Workspaces {
    /// Returns the arrangements from the JSON of [`Self::to_value`]; `None` if the JSON is not valid.
    pub fn from_value(value: &serde_json::Value) -> Option<Self> {
        let mut read: Self = serde_json::from_value(value.clone()).ok()?;
        read.show(read.shown);
        read.arrangements.values().all(Arrangement::is_sound).then_some(read)
    }

    pub fn to_value(&self) -> serde_json::Value {
        serde_json::to_value(self).unwrap_or_default()
    }

    pub fn shown(&self) -> Workspace {
        self.shown
    }

    pub fn show(&mut self, workspace: Workspace) {
        self.arrangements.entry(workspace).or_insert_with(|| Arrangement::of(workspace));
        self.shown = workspace;
        self.maximized = None;
    }

    pub fn reset(&mut self) {
        self.arrangements.remove(&self.shown);
        self.show(self.shown);
    }

    fn arrangement(&self) -> &Arrangement {
        &self.arrangements[&self.shown]
    }

    pub fn arrangement_mut(&mut self) -> &mut Arrangement {
        self.arrangements.entry(self.shown).or_insert_with(|| Arrangement::of(self.shown))
    }

    pub fn is_open(&self, pane: Pane) -> bool {
        self.arrangement().is_open(pane)
    }

    /// Returns the panes whose tabs are selected.
    pub fn on_screen(&self) -> Vec<Pane> {
        self.maximized.map_or_else(|| self.arrangement().on_screen(), |pane| vec![pane])
    }

    /// Selects the tab of a pane, in the present workspace or else in the first workspace that contains the pane.
    pub fn bring(&mut self, pane: Pane) {
        let has_it = |workspace: &Workspace| match self.arrangements.get(workspace) {
            Some(arrangement) => arrangement.is_open(pane),
            None => Arrangement::of(*workspace).is_open(pane),
        };
        let all = Workspace::ALL.iter().map(|(workspace, ..)| *workspace);
        let place = std::iter::once(self.shown).chain(all).find(has_it);
        self.maximized.take_if(|shown| *shown != pane);
        if let Some(place) = place.filter(|place| *place != self.shown) {
            self.show(place);
        }
        self.arrangement_mut().bring(pane);
    }

    /// Maximises a pane, or shows all panes again if a pane is maximised.
    pub fn toggle_maximized(&mut self, pane: Option<Pane>) {
        self.maximized = pane.filter(|pane| self.maximized.is_none() && self.is_open(*pane));
    }

    pub fn draw(
        &mut self,
        ui: &mut Ui,
        out: &mut Out,
        draw: &mut dyn FnMut(&mut Ui, &mut Out, Pane),
    ) {
        let maximized = self.maximized;
        let arrangement = self.arrangement_mut();
        let mut drawing = Drawing { draw, focus: arrangement.focus.take(), out };
        match maximized {
            Some(mut pane) => {
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
                let _ = drawing.pane_ui(ui, TileId::from_u64(0), &mut pane);
            }
            None if arrangement.tree.is_empty() => {
                ui.centered_and_justified(|ui| {
                    ui.label("All panes of this workspace are closed. Open panes or reset the workspace in the View menu");
                });
            }
            None => arrangement.tree.ui(&mut drawing, ui),
        }
    }
}

/// Tree of panes, in which each pane occurs at most once.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
pub struct Arrangement {
    tree: Tree<Pane>,
    #[serde(skip)]
    focus: Option<Pane>,
}

impl Arrangement {
    pub fn of(workspace: Workspace) -> Self {
        use crate::ui::{
            calibration_pane::PANE as CALIBRATION, channels_pane::PANE as CHANNELS,
            check_pane::PANE as CHECK, errors_pane::PANE as ERRORS, export_pane::PANE as EXPORT,
            live_pane::PANE as LIVE, loops_pane::PANE as LOOPS, metrology_pane::PANE as METROLOGY,
            models_pane::PANE as MODELS, notes_pane::PANE as NOTES,
            recordings_panel::PANE as RECORDINGS, settings_panel::PANE as SETTINGS,
            thresholds_pane::PANE as THRESHOLDS, trace_panes::PANE as TRACES,
        };
        use LinearDir::{Horizontal, Vertical};
        let mut tiles = Tiles::default();
        let mut build = Build(&mut tiles);
        let (left, right, share) = match workspace {
            Workspace::Import => {
                let right = build.column([&[TRACES, CHANNELS], &[NOTES]], 0.62);
                (build.tabs(&[RECORDINGS]), right, 0.4)
            }
            Workspace::Calibrate => {
                let left = build.column([&[SETTINGS], &[RECORDINGS]], 0.54);
                (left, build.column([&[TRACES], &[ERRORS]], 0.66), 0.28)
            }
            Workspace::Loops => {
                let foot = [build.tabs(&[TRACES]), build.tabs(&[METROLOGY])];
                let right = [build.tabs(&[LOOPS]), build.line(Horizontal, foot, 0.55)];
                let left = build.column([&[SETTINGS], &[RECORDINGS]], 0.5);
                (left, build.line(Vertical, right, 0.5), 0.24)
            }
            Workspace::Thresholds => {
                let left = build.column([&[SETTINGS], &[ERRORS]], 0.5);
                (left, build.column([&[TRACES], &[THRESHOLDS]], 0.5), 0.32)
            }
            Workspace::Models => {
                let left = build.column([&[SETTINGS], &[RECORDINGS]], 0.6);
                (left, build.column([&[MODELS], &[ERRORS]], 0.72), 0.26)
            }
            Workspace::Check => {
                let right = build.column([&[CHECK], &[TRACES, LIVE]], 0.5);
                (build.tabs(&[RECORDINGS]), right, 0.34)
            }
            Workspace::Export => {
                let right = build.column([&[CALIBRATION], &[ERRORS, NOTES]], 0.66);
                (build.tabs(&[EXPORT]), right, 0.34)
            }
        };
        let root = build.line(Horizontal, [left, right], share);
        Self { tree: tree(root, tiles), focus: None }
    }

    /// Returns true if the tree has at least one pane, and no pane twice.
    fn is_sound(&self) -> bool {
        let panes = in_order(self.panes());
        panes.windows(2).all(|pair| pair[0] != pair[1]) && !panes.is_empty()
    }

    /// Returns the panes whose tabs are selected.
    pub fn on_screen(&self) -> Vec<Pane> {
        let active = self.tree.active_tiles();
        let panes = active.iter().filter_map(|tile| self.tree.tiles.get_pane(tile));
        in_order(panes.copied())
    }

    pub fn is_open(&self, pane: Pane) -> bool {
        self.tree.tiles.find_pane(&pane).is_some()
    }

    /// Selects the tab of a pane, and adds the pane first if it was closed.
    pub fn bring(&mut self, pane: Pane) {
        if !self.is_open(pane) {
            let new = self.tree.tiles.insert_pane(pane);
            match self.home() {
                Some(home) => {
                    self.tree.move_tile_to_container(new, home, usize::MAX, true);
                }
                None => self.tree.root = Some(self.tree.tiles.insert_tab_tile(vec![new])),
            }
        }
        self.tree.make_active(|_, tile| matches!(tile, Tile::Pane(known) if *known == pane));
        self.focus = Some(pane);
    }

    pub fn close(&mut self, pane: Pane) {
        if let Some(tile) = self.tree.tiles.find_pane(&pane) {
            self.tree.remove_recursively(tile);
        }
    }

    /// Returns the group of tabs to which a reopened pane is added: the group that contains the traces, else the largest
    /// group.
    fn home(&self) -> Option<TileId> {
        let traces = self.tree.tiles.find_pane(&trace_panes::PANE);
        let tabs = self.tree.tiles.iter().filter_map(|(id, tile)| match tile {
            Tile::Container(Container::Tabs(tabs)) => Some((*id, &tabs.children)),
            _ => None,
        });
        let has_traces = |tabs: &[TileId]| traces.is_some_and(|tile| tabs.contains(&tile));
        tabs.max_by_key(|(_, tabs)| (has_traces(tabs), tabs.len())).map(|(id, _)| id)
    }

    fn panes(&self) -> impl Iterator<Item = Pane> {
        self.tree.tiles.tiles().filter_map(|tile| match tile {
            Tile::Pane(pane) => Some(*pane),
            Tile::Container(_) => None,
        })
    }
}

fn tree(root: TileId, tiles: Tiles<Pane>) -> Tree<Pane> {
    Tree::new(egui::Id::unique("workspace"), root, tiles)
}

struct Build<'a>(&'a mut Tiles<Pane>);

impl Build<'_> {
    fn tabs(&mut self, panes: &[Pane]) -> TileId {
        let children = panes.iter().map(|pane| self.0.insert_pane(*pane)).collect();
        self.0.insert_tab_tile(children)
    }

    /// Adds a column with two groups of tabs, one above the other.
    fn column(&mut self, groups: [&[Pane]; 2], first_share: f32) -> TileId {
        let children = groups.map(|panes| self.tabs(panes));
        self.line(LinearDir::Vertical, children, first_share)
    }

    fn line(&mut self, dir: LinearDir, children: [TileId; 2], first_share: f32) -> TileId {
        let line = Linear::new_binary(dir, children, first_share);
        self.0.insert_container(Container::Linear(line))
    }
}

struct Drawing<'a> {
    draw: &'a mut dyn FnMut(&mut Ui, &mut Out, Pane),
    focus: Option<Pane>,
    out: &'a mut Out,
}

impl Behavior<Pane> for Drawing<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        // The pane as a whole can take the keyboard focus; the Tab key then moves the focus to the controls of the pane.
        let id = egui::Id::unique(("pane", pane.key));
        let whole = ui.interact(ui.max_rect(), id, Sense::focusable_noninteractive());
        whole.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Pane, true, pane.title));
        if self.focus == Some(*pane) {
            whole.request_focus();
        }
        if whole.has_focus() {
            focus_ring(ui.painter(), ui.max_rect().shrink(1.0));
        }
        egui::Frame::NONE.inner_margin(egui::Margin::symmetric(6, 4)).show(ui, |ui| {
            ui.set_min_size(ui.available_size());
            (self.draw)(ui, self.out, *pane);
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        pane.title.into()
    }

    fn is_tab_closable(&self, _tiles: &Tiles<Pane>, _tile: TileId) -> bool {
        true
    }

    fn on_tab_close(&mut self, tiles: &mut Tiles<Pane>, tile: TileId) -> bool {
        if let Some(pane) = tiles.get_pane(&tile) {
            self.out.send(Command::ClosePane(*pane));
        }
        false // the command closes the pane
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<Pane>,
        tile: TileId,
        tab: egui::Response,
    ) -> egui::Response {
        let Some(pane) = tiles.get_pane(&tile) else { return tab };
        if tab.double_clicked() {
            self.out.send(Command::ToggleMaximized(Some(*pane)));
        }
        tab.on_hover_text(format!("{}. A double click maximises the pane", pane.explanation))
    }

    fn tab_bg_color(
        &self,
        visuals: &egui::Visuals,
        _tiles: &Tiles<Pane>,
        _tile: TileId,
        state: &TabState,
    ) -> egui::Color32 {
        if state.active { visuals.panel_fill } else { visuals.faint_bg_color }
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        3.0
    }

    fn min_size(&self) -> f32 {
        80.0
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions {
            // Every pane has a tab, because users drag and close a pane by its tab.
            all_panes_must_have_tabs: true,
            ..Default::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(key: &str) -> Pane {
        panes::named(key).unwrap()
    }

    fn all() -> Vec<Pane> {
        panes::all().collect()
    }

    fn open(workspace: &Arrangement) -> Vec<Pane> {
        in_order(workspace.panes())
    }

    /// All panes in tabs beside the traces.
    fn full() -> Arrangement {
        let mut arrangement = Arrangement::of(Workspace::Calibrate);
        all().into_iter().for_each(|pane| arrangement.bring(pane));
        arrangement
    }

    #[test]
    fn every_pane_has_a_workspace_and_each_shows_three_to_five_at_once() {
        let first = Workspace::ALL.map(|(workspace, ..)| Arrangement::of(workspace));
        assert!(first.iter().all(|arrangement| (3..=5).contains(&arrangement.on_screen().len())));
        assert!(first.iter().all(Arrangement::is_sound));
        for pane in all() {
            assert!(first.iter().any(|arrangement| arrangement.is_open(pane)), "{}", pane.title);
        }
    }

    #[test]
    fn a_pane_is_brought_where_it_is_and_each_workspace_keeps_its_own_arrangement() {
        let mut workspaces = Workspaces::default();
        workspaces.arrangement_mut().close(named("errors"));
        workspaces.bring(named("loops"));
        assert_eq!(workspaces.shown(), Workspace::Loops);
        workspaces.show(Workspace::Calibrate);
        assert!(!workspaces.is_open(named("errors")));
        workspaces.toggle_maximized(Some(named("traces")));
        assert_eq!(workspaces.on_screen(), [named("traces")]);
        workspaces.toggle_maximized(None);
        assert_eq!(workspaces.on_screen().len(), 3);
        workspaces.reset();
        assert!(workspaces.is_open(named("errors")));
    }

    #[test]
    fn a_closed_pane_comes_back_to_the_traces_even_when_all_are_closed() {
        let mut workspace = full();
        workspace.close(named("loops"));
        assert!(!workspace.is_open(named("loops")));
        workspace.bring(named("loops"));
        assert!(workspace.is_open(named("loops")));
        let loops = workspace.tree.tiles.find_pane(&named("loops")).unwrap();
        let traces = workspace.tree.tiles.find_pane(&trace_panes::PANE).unwrap();
        let parent = |tile| workspace.tree.tiles.parent_of(tile);
        assert_eq!(parent(loops), parent(traces));
        for pane in panes::all() {
            workspace.close(pane);
        }
        assert_eq!(open(&workspace), []);
        workspace.bring(named("settings"));
        assert_eq!(workspace.on_screen(), [named("settings")]);
    }

    #[test]
    fn arrangements_come_back_from_json_and_a_broken_one_does_not() {
        let mut workspaces = Workspaces::default();
        workspaces.show(Workspace::Loops);
        workspaces.arrangement_mut().close(named("recordings"));
        let value = workspaces.to_value();
        let back = Workspaces::from_value(&value).expect("what was written");
        assert_eq!(back.shown(), Workspace::Loops);
        assert_eq!(back.on_screen(), workspaces.on_screen());
        assert_eq!(back.to_value(), value);
        assert!(Workspaces::from_value(&serde_json::json!({"tree": 1})).is_none());
        let twice = value.to_string().replace("\"metrology\"", "\"loops\"");
        let twice = serde_json::from_str(&twice).unwrap();
        assert!(Workspaces::from_value(&twice).is_none(), "a pane twice");
    }
}
