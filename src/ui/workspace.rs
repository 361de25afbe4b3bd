//! Where the panes stand: a tree of tabs, rows and columns that can be dragged about, with arrangements to begin from.

use egui_tiles::{
    Behavior, Container, Linear, LinearDir, SimplificationOptions, TabState, Tile, TileId, Tiles,
    Tree, UiResponse,
};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::ui::appearance::focus_ring;
use crate::ui::command::{Pane, PaneMove, Preset};
use crate::ui::{panes, trace_panes};

/// What a pane along an edge of the window gets of it.
const EDGE_SHARE: f32 = 0.34;
/// One step of a pane's size.
const RESIZE_STEP: f32 = 1.2;

impl Serialize for Pane {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.key)
    }
}

impl<'de> Deserialize<'de> for Pane {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        panes::named(&key).ok_or_else(|| de::Error::custom(format!("no pane is called {key}")))
    }
}

/// In the order in which menus have them.
fn in_order(mut panes: Vec<Pane>) -> Vec<Pane> {
    panes.sort_by_key(|pane| panes::all().position(|own| own == *pane));
    panes
}

/// The tree of panes. Every pane is in it at most once.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
pub struct Workspace {
    tree: Tree<Pane>,
    /// The pane that is to have the keyboard's focus.
    #[serde(skip)]
    focus: Option<Pane>,
}

impl Default for Workspace {
    fn default() -> Self {
        Self::preset(Preset::Calibrate)
    }
}

impl Workspace {
    /// One of the arrangements to begin from.
    pub fn preset(preset: Preset) -> Self {
        use crate::ui::{
            calibration_pane::PANE as CALIBRATION, check_pane::PANE as CHECK,
            errors_pane::PANE as ERRORS, live_pane::PANE as LIVE, loops_pane::PANE as LOOPS,
            metrology_pane::PANE as METROLOGY, models_pane::PANE as MODELS,
            notes_pane::PANE as NOTES, recordings_panel::PANE as RECORDINGS,
            sensor_pane::PANE as SENSOR, settings_panel::PANE as SETTINGS,
            thresholds_pane::PANE as THRESHOLDS, trace_panes::PANE as TRACES,
        };
        let mut tiles = Tiles::default();
        let mut build = Build(&mut tiles);
        let root = match preset {
            Preset::Calibrate => {
                let (top, below) = (build.tabs(&[RECORDINGS]), build.tabs(&[SETTINGS]));
                let left = build.column([top, below], 0.5);
                let middle = build
                    .tabs(&[TRACES, THRESHOLDS, MODELS, LOOPS, METROLOGY, LIVE, CHECK, SENSOR]);
                let (errors, matrix) = (build.tabs(&[ERRORS]), build.tabs(&[CALIBRATION, NOTES]));
                let foot = build.row([errors, matrix], 0.66);
                let right = build.column([middle, foot], 0.68);
                build.row([left, right], 0.32)
            }
            Preset::InspectLoops => {
                let left = build.tabs(&[SETTINGS, RECORDINGS]);
                let loops = build.tabs(&[LOOPS, METROLOGY, MODELS, CHECK, SENSOR]);
                let traces = build.tabs(&[TRACES, THRESHOLDS, ERRORS, CALIBRATION, NOTES, LIVE]);
                let right = build.column([loops, traces], 0.5);
                build.row([left, right], 0.26)
            }
            Preset::DemonstrateThresholds => {
                let (settings, others) = (
                    build.tabs(&[SETTINGS, RECORDINGS]),
                    build.tabs(&[ERRORS, CALIBRATION, NOTES]),
                );
                let left = build.column([settings, others], 0.62);
                let traces = build.tabs(&[TRACES, LOOPS, METROLOGY, MODELS, LIVE, CHECK, SENSOR]);
                let map = build.tabs(&[THRESHOLDS]);
                let right = build.column([traces, map], 0.5);
                build.row([left, right], 0.34)
            }
        };
        let mut workspace = Self { tree: tree(root, tiles), focus: None };
        workspace.add_missing();
        workspace
    }

    /// Puts panes that no arrangement names behind the traces.
    fn add_missing(&mut self) {
        for pane in panes::all().filter(|pane| !self.is_open(*pane)).collect::<Vec<_>>() {
            let new = self.tree.tiles.insert_pane(pane);
            if let Some(home) = self.home() {
                self.tree.move_tile_to_container(new, home, usize::MAX, false);
            }
        }
    }

    /// Reads what [`Self::to_value`] wrote; `None` where it cannot be used.
    pub fn from_value(value: &serde_json::Value) -> Option<Self> {
        let workspace: Self = serde_json::from_value(value.clone()).ok()?;
        let panes = in_order(workspace.panes().map(|(_, pane)| pane).collect());
        let is_sound = panes.windows(2).all(|pair| pair[0] != pair[1]);
        (is_sound && !panes.is_empty()).then_some(workspace)
    }

    /// The arrangement as JSON.
    pub fn to_value(&self) -> serde_json::Value {
        serde_json::to_value(self).unwrap_or_default()
    }

    /// Draws the panes.
    pub fn show(&mut self, ui: &mut egui::Ui, draw: &mut dyn FnMut(&mut egui::Ui, Pane)) {
        if self.tree.is_empty() {
            ui.centered_and_justified(|ui| {
                ui.label("Every pane is closed; choose some in the View menu");
            });
            return;
        }
        let focus = self.focus.take();
        self.tree.ui(&mut Drawing { draw, focus }, ui);
    }

    /// The panes that are on screen: open, and in front among their tabs.
    pub fn on_screen(&self) -> Vec<Pane> {
        let active = self.tree.active_tiles();
        let panes = active.iter().filter_map(|tile| self.tree.tiles.get_pane(tile));
        in_order(panes.copied().collect())
    }

    /// Whether the pane is anywhere in the tree.
    pub fn is_open(&self, pane: Pane) -> bool {
        self.tree.tiles.find_pane(&pane).is_some()
    }

    /// Brings a pane to the front, or back.
    pub fn bring(&mut self, pane: Pane) {
        if !self.is_open(pane) {
            let new = self.tree.tiles.insert_pane(pane);
            match self.home() {
                Some(home) => self.tree.move_tile_to_container(new, home, usize::MAX, true),
                None => {
                    let root = self.tree.tiles.insert_tab_tile(vec![new]);
                    self.set_root(root);
                }
            }
        }
        self.tree.make_active(|_, tile| matches!(tile, Tile::Pane(own) if *own == pane));
        self.focus = Some(pane);
    }

    /// Gives a pane another place or size, and brings it to the front.
    pub fn move_pane(&mut self, pane: Pane, to: PaneMove) {
        self.bring(pane);
        use LinearDir::{Horizontal, Vertical};
        match to {
            PaneMove::Left => self.put_at_edge(pane, Horizontal, true),
            PaneMove::Right => self.put_at_edge(pane, Horizontal, false),
            PaneMove::Top => self.put_at_edge(pane, Vertical, true),
            PaneMove::Bottom => self.put_at_edge(pane, Vertical, false),
            PaneMove::NextTabs => self.put_in_next_tabs(pane),
            PaneMove::Wider => self.resize(pane, Horizontal, RESIZE_STEP),
            PaneMove::Narrower => self.resize(pane, Horizontal, RESIZE_STEP.recip()),
            PaneMove::Taller => self.resize(pane, Vertical, RESIZE_STEP),
            PaneMove::Lower => self.resize(pane, Vertical, RESIZE_STEP.recip()),
        }
        self.bring(pane);
    }

    fn put_at_edge(&mut self, pane: Pane, dir: LinearDir, first: bool) {
        self.close(pane);
        self.tree.simplify(&simplification());
        let Some(rest) = self.tree.root() else {
            return; // it was alone, and comes back so
        };
        let mut build = Build(&mut self.tree.tiles);
        let own = build.tabs(&[pane]);
        let (children, share) = match first {
            true => ([own, rest], EDGE_SHARE),
            false => ([rest, own], 1.0 - EDGE_SHARE),
        };
        let root = build.line(dir, children, share);
        self.set_root(root);
    }

    fn put_in_next_tabs(&mut self, pane: Pane) {
        let mut groups = Vec::new();
        self.collect_tabs(self.tree.root(), &mut groups);
        let tile = self.tree.tiles.find_pane(&pane);
        let Some((tile, own)) =
            tile.and_then(|tile| Some((tile, self.tree.tiles.parent_of(tile)?)))
        else {
            return;
        };
        let at = groups.iter().position(|group| *group == own);
        if let Some(at) = at
            && groups.len() > 1
        {
            let next = groups[(at + 1) % groups.len()];
            self.tree.move_tile_to_container(tile, next, usize::MAX, true);
        }
    }

    /// The groups of tabs as they stand, from the left and the top.
    fn collect_tabs(&self, from: Option<TileId>, groups: &mut Vec<TileId>) {
        let Some(id) = from else { return };
        match self.tree.tiles.get_container(id) {
            Some(Container::Tabs(_)) => groups.push(id),
            Some(container) => {
                for child in container.children() {
                    self.collect_tabs(Some(*child), groups);
                }
            }
            None => {}
        }
    }

    /// Changes the share of the nearest of the pane's surroundings that stands in such a line.
    fn resize(&mut self, pane: Pane, dir: LinearDir, factor: f32) {
        let mut child = self.tree.tiles.find_pane(&pane);
        while let Some(at) = child {
            child = self.tree.tiles.parent_of(at);
            if let Some(parent) = child
                && let Some(Tile::Container(Container::Linear(line))) =
                    self.tree.tiles.get_mut(parent)
                && line.dir == dir
            {
                let share = line.shares[at];
                line.shares.set_share(at, share * factor);
                return;
            }
        }
    }

    fn set_root(&mut self, root: TileId) {
        self.tree = tree(root, std::mem::take(&mut self.tree.tiles));
    }

    /// Takes a pane out.
    pub fn close(&mut self, pane: Pane) {
        if let Some(tile) = self.tree.tiles.find_pane(&pane) {
            self.tree.remove_recursively(tile);
        }
    }

    /// The tabs that a pane without a place goes to: those with the traces, else any.
    fn home(&self) -> Option<TileId> {
        let tabs = || {
            self.tree.tiles.iter().filter_map(|(id, tile)| match tile {
                Tile::Container(Container::Tabs(tabs)) => Some((*id, tabs)),
                _ => None,
            })
        };
        let traces = self.tree.tiles.find_pane(&trace_panes::PANE);
        let with_traces =
            tabs().find(|(_, tabs)| traces.is_some_and(|t| tabs.children.contains(&t)));
        let any = || tabs().max_by_key(|(_, tabs)| tabs.children.len());
        with_traces.or_else(any).map(|(id, _)| id)
    }

    fn panes(&self) -> impl Iterator<Item = (TileId, Pane)> {
        self.tree.tiles.iter().filter_map(|(id, tile)| match tile {
            Tile::Pane(pane) => Some((*id, *pane)),
            Tile::Container(_) => None,
        })
    }
}

fn tree(root: TileId, tiles: Tiles<Pane>) -> Tree<Pane> {
    Tree::new(egui::Id::unique("workspace"), root, tiles)
}

fn simplification() -> SimplificationOptions {
    SimplificationOptions {
        // The tab is where a pane is dragged and closed.
        all_panes_must_have_tabs: true,
        ..Default::default()
    }
}

/// Puts tiles together.
struct Build<'a>(&'a mut Tiles<Pane>);

impl Build<'_> {
    fn tabs(&mut self, panes: &[Pane]) -> TileId {
        let children = panes.iter().map(|pane| self.0.insert_pane(*pane)).collect();
        self.0.insert_tab_tile(children)
    }

    fn row(&mut self, children: [TileId; 2], first_share: f32) -> TileId {
        self.line(LinearDir::Horizontal, children, first_share)
    }

    fn column(&mut self, children: [TileId; 2], first_share: f32) -> TileId {
        self.line(LinearDir::Vertical, children, first_share)
    }

    fn line(&mut self, dir: LinearDir, children: [TileId; 2], first_share: f32) -> TileId {
        let line = Linear::new_binary(dir, children, first_share);
        self.0.insert_container(Container::Linear(line))
    }
}

struct Drawing<'a> {
    draw: &'a mut dyn FnMut(&mut egui::Ui, Pane),
    /// The pane that is to have the focus.
    focus: Option<Pane>,
}

impl Behavior<Pane> for Drawing<'_> {
    fn pane_ui(&mut self, ui: &mut egui::Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        // The keyboard goes to a pane first, and by Tab to what is in it.
        let id = egui::Id::unique(("pane", pane.0.key));
        let whole = ui.interact(ui.max_rect(), id, egui::Sense::focusable_noninteractive());
        whole.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Pane, true, pane.title()));
        if self.focus == Some(*pane) {
            whole.request_focus();
        }
        if whole.has_focus() {
            focus_ring(ui.painter(), ui.max_rect().shrink(1.0));
        }
        egui::Frame::NONE.inner_margin(egui::Margin::symmetric(6, 4)).show(ui, |ui| {
            ui.set_min_size(ui.available_size());
            (self.draw)(ui, *pane);
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        pane.title().into()
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<Pane>,
        tile: TileId,
        response: egui::Response,
    ) -> egui::Response {
        match tiles.get_pane(&tile) {
            Some(pane) => response.on_hover_text(pane.explanation()),
            None => response,
        }
    }

    fn is_tab_closable(&self, tiles: &Tiles<Pane>, tile: TileId) -> bool {
        tiles.get_pane(&tile).is_some()
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
        simplification()
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

    fn open(workspace: &Workspace) -> Vec<Pane> {
        in_order(workspace.panes().map(|(_, pane)| pane).collect())
    }

    #[test]
    fn every_arrangement_holds_every_pane_once() {
        for (preset, ..) in Preset::ALL {
            assert_eq!(open(&Workspace::preset(preset)), all(), "{preset:?}");
        }
    }

    #[test]
    fn a_closed_pane_comes_back_to_the_traces_even_when_all_are_closed() {
        let mut workspace = Workspace::default();
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
    fn a_pane_goes_to_an_edge_and_to_the_next_tabs_without_a_mouse() {
        let mut workspace = Workspace::default();
        workspace.move_pane(named("loops"), PaneMove::Right);
        assert_eq!(open(&workspace), all());
        let mut groups = Vec::new();
        workspace.collect_tabs(workspace.tree.root(), &mut groups);
        let own = workspace.tree.tiles.find_pane(&named("loops")).unwrap();
        let group = |workspace: &Workspace| workspace.tree.tiles.parent_of(own).unwrap();
        assert_eq!(groups.last(), Some(&group(&workspace)));
        workspace.move_pane(named("loops"), PaneMove::NextTabs);
        assert_eq!(group(&workspace), groups[0], "after the last comes the first");
        assert!(workspace.on_screen().contains(&named("loops")));
        assert_eq!(open(&workspace), all());
    }

    #[test]
    fn a_pane_alone_stays_where_it_is() {
        let mut workspace = Workspace::default();
        for pane in panes::all().filter(|pane| *pane != named("traces")) {
            workspace.close(pane);
        }
        for (to, ..) in PaneMove::ALL {
            workspace.move_pane(named("traces"), to);
            assert_eq!(open(&workspace), [named("traces")], "{to:?}");
            assert_eq!(workspace.on_screen(), [named("traces")], "{to:?}");
        }
    }

    #[test]
    fn a_pane_grows_by_what_its_neighbours_give() {
        let mut workspace = Workspace::default();
        let share = |workspace: &Workspace| {
            let tile = workspace.tree.tiles.find_pane(&named("errors")).unwrap();
            let tabs = workspace.tree.tiles.parent_of(tile).unwrap();
            let row = workspace.tree.tiles.parent_of(tabs).unwrap();
            match workspace.tree.tiles.get_container(row) {
                Some(Container::Linear(line)) => line.shares[tabs],
                other => panic!("{other:?}"),
            }
        };
        let before = share(&workspace);
        workspace.move_pane(named("errors"), PaneMove::Wider);
        assert!(share(&workspace) > 1.1 * before);
        workspace.move_pane(named("errors"), PaneMove::Narrower);
        assert!((share(&workspace) - before).abs() < 1e-6);
    }

    #[test]
    fn an_arrangement_comes_back_from_json_and_a_broken_one_does_not() {
        let mut workspace = Workspace::preset(Preset::InspectLoops);
        workspace.close(named("compare"));
        let value = workspace.to_value();
        let back = Workspace::from_value(&value).expect("what was written");
        assert_eq!(open(&back), open(&workspace));
        assert_eq!(back.on_screen(), workspace.on_screen());
        assert!(Workspace::from_value(&serde_json::json!({"tree": 1})).is_none());
        let twice = value.to_string().replace("\"metrology\"", "\"loops\"");
        let twice = serde_json::from_str(&twice).unwrap();
        assert!(Workspace::from_value(&twice).is_none(), "a pane twice");
    }
}
