//! Where the panes stand: a tree of tabs, rows and columns that can be dragged about, with arrangements to begin from.

use egui_tiles::{
    Behavior, Container, Linear, LinearDir, SimplificationOptions, TabState, Tile, TileId, Tiles,
    Tree, UiResponse,
};
use serde::{Deserialize, Serialize};

use crate::app::{Pane, Preset};

/// The tree of panes. Every pane is in it at most once.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
pub struct Workspace {
    tree: Tree<Pane>,
}

impl Default for Workspace {
    fn default() -> Self {
        Self::preset(Preset::Calibrate)
    }
}

impl Workspace {
    /// One of the arrangements to begin from.
    pub fn preset(preset: Preset) -> Self {
        use Pane::{
            Calibration, Compare, Errors, Loops, Metrology, Notes, Recordings, Settings,
            Thresholds, Traces,
        };
        let mut tiles = Tiles::default();
        let mut build = Build(&mut tiles);
        let root = match preset {
            Preset::Calibrate => {
                let (top, below) = (build.tabs(&[Recordings]), build.tabs(&[Settings]));
                let left = build.column([top, below], 0.5);
                let middle = build.tabs(&[Traces, Thresholds, Compare, Loops, Metrology]);
                let (errors, matrix) = (build.tabs(&[Errors]), build.tabs(&[Calibration, Notes]));
                let foot = build.row([errors, matrix], 0.66);
                let right = build.column([middle, foot], 0.68);
                build.row([left, right], 0.32)
            }
            Preset::InspectLoops => {
                let left = build.tabs(&[Settings, Recordings]);
                let loops = build.tabs(&[Loops, Metrology, Compare]);
                let traces = build.tabs(&[Traces, Thresholds, Errors, Calibration, Notes]);
                let right = build.column([loops, traces], 0.6);
                build.row([left, right], 0.26)
            }
            Preset::DemonstrateThresholds => {
                let (settings, others) = (
                    build.tabs(&[Settings, Recordings]),
                    build.tabs(&[Errors, Calibration, Notes]),
                );
                let left = build.column([settings, others], 0.62);
                let traces = build.tabs(&[Traces, Loops, Metrology, Compare]);
                let map = build.tabs(&[Thresholds]);
                let right = build.column([traces, map], 0.42);
                build.row([left, right], 0.34)
            }
        };
        Self {
            tree: Tree::new(egui::Id::unique("workspace"), root, tiles),
        }
    }

    /// Reads what [`Self::to_value`] wrote; `None` where it cannot be used.
    pub fn from_value(value: &serde_json::Value) -> Option<Self> {
        let workspace: Self = serde_json::from_value(value.clone()).ok()?;
        let mut panes: Vec<Pane> = workspace.panes().map(|(_, pane)| pane).collect();
        panes.sort_unstable();
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
        self.tree.ui(&mut Drawing { draw }, ui);
    }

    /// The panes that are on screen: open, and in front among their tabs.
    pub fn on_screen(&self) -> Vec<Pane> {
        let active = self.tree.active_tiles();
        let panes = active
            .iter()
            .filter_map(|tile| self.tree.tiles.get_pane(tile));
        let mut panes: Vec<Pane> = panes.copied().collect();
        panes.sort_unstable();
        panes
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
                Some(home) => self
                    .tree
                    .move_tile_to_container(new, home, usize::MAX, true),
                None => {
                    let root = self.tree.tiles.insert_tab_tile(vec![new]);
                    let tiles = std::mem::take(&mut self.tree.tiles);
                    self.tree = Tree::new(egui::Id::unique("workspace"), root, tiles);
                }
            }
        }
        self.tree
            .make_active(|_, tile| matches!(tile, Tile::Pane(own) if *own == pane));
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
        let traces = self.tree.tiles.find_pane(&Pane::Traces);
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

/// Puts tiles together.
struct Build<'a>(&'a mut Tiles<Pane>);

impl Build<'_> {
    fn tabs(&mut self, panes: &[Pane]) -> TileId {
        let children = panes.iter().map(|pane| self.0.insert_pane(*pane)).collect();
        self.0.insert_tab_tile(children)
    }

    fn row(&mut self, children: [TileId; 2], first_share: f32) -> TileId {
        let row = Linear::new_binary(LinearDir::Horizontal, children, first_share);
        self.0.insert_container(Container::Linear(row))
    }

    fn column(&mut self, children: [TileId; 2], first_share: f32) -> TileId {
        let column = Linear::new_binary(LinearDir::Vertical, children, first_share);
        self.0.insert_container(Container::Linear(column))
    }
}

struct Drawing<'a> {
    draw: &'a mut dyn FnMut(&mut egui::Ui, Pane),
}

impl Behavior<Pane> for Drawing<'_> {
    fn pane_ui(&mut self, ui: &mut egui::Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        egui::Frame::NONE
            .inner_margin(egui::Margin::symmetric(6, 4))
            .show(ui, |ui| {
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
        if state.active {
            visuals.panel_fill
        } else {
            visuals.faint_bg_color
        }
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        3.0
    }

    fn min_size(&self) -> f32 {
        80.0
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions {
            // The tab is where a pane is dragged and closed.
            all_panes_must_have_tabs: true,
            ..Default::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(workspace: &Workspace) -> Vec<Pane> {
        let mut panes: Vec<Pane> = workspace.panes().map(|(_, pane)| pane).collect();
        panes.sort_unstable();
        panes
    }

    #[test]
    fn every_arrangement_holds_every_pane_once() {
        for preset in Preset::ALL {
            assert_eq!(open(&Workspace::preset(preset)), Pane::ALL, "{preset:?}");
        }
    }

    #[test]
    fn a_closed_pane_comes_back_to_the_traces_even_when_all_are_closed() {
        let mut workspace = Workspace::default();
        workspace.close(Pane::Loops);
        assert!(!workspace.is_open(Pane::Loops));
        workspace.bring(Pane::Loops);
        assert!(workspace.is_open(Pane::Loops));
        let loops = workspace.tree.tiles.find_pane(&Pane::Loops).unwrap();
        let traces = workspace.tree.tiles.find_pane(&Pane::Traces).unwrap();
        let parent = |tile| workspace.tree.tiles.parent_of(tile);
        assert_eq!(parent(loops), parent(traces));
        for pane in Pane::ALL {
            workspace.close(pane);
        }
        assert_eq!(open(&workspace), []);
        workspace.bring(Pane::Settings);
        assert_eq!(workspace.on_screen(), [Pane::Settings]);
    }

    #[test]
    fn an_arrangement_comes_back_from_json_and_a_broken_one_does_not() {
        let mut workspace = Workspace::preset(Preset::InspectLoops);
        workspace.close(Pane::Compare);
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
