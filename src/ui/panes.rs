//! The list of panes, in the order in which menus have them. A new one is a file and a line here.

use crate::ui::command::Pane;
use crate::ui::pane::PaneView;
use crate::ui::{
    calibration_pane, compare_pane, errors_pane, loops_pane, metrology_pane, notes_pane,
    recordings_panel, settings_panel, thresholds_pane, trace_panes,
};

/// A pane with what makes its view.
type Entry = (Pane, fn() -> Box<dyn PaneView>);

const PANES: [Entry; 10] = [
    (recordings_panel::PANE, || {
        Box::<recordings_panel::View>::default()
    }),
    (settings_panel::PANE, || {
        Box::<settings_panel::View>::default()
    }),
    (trace_panes::PANE, || Box::<trace_panes::View>::default()),
    (thresholds_pane::PANE, || {
        Box::<thresholds_pane::View>::default()
    }),
    (compare_pane::PANE, || Box::<compare_pane::View>::default()),
    (loops_pane::PANE, || Box::<loops_pane::LoopsPane>::default()),
    (metrology_pane::PANE, || {
        Box::<metrology_pane::MetrologyPane>::default()
    }),
    (errors_pane::PANE, || Box::<errors_pane::View>::default()),
    (calibration_pane::PANE, || {
        Box::<calibration_pane::View>::default()
    }),
    (notes_pane::PANE, || Box::<notes_pane::View>::default()),
];

/// All of them.
pub fn all() -> impl DoubleEndedIterator<Item = Pane> + ExactSizeIterator {
    PANES.into_iter().map(|(pane, _)| pane)
}

/// The one that files call so.
pub fn named(key: &str) -> Option<Pane> {
    all().find(|pane| pane.0.key == key)
}

/// The views of all panes.
pub struct Views(Vec<(Pane, Box<dyn PaneView>)>);

impl Default for Views {
    fn default() -> Self {
        Self(
            PANES
                .into_iter()
                .map(|(pane, make)| (pane, make()))
                .collect(),
        )
    }
}

impl Views {
    /// The view of this pane.
    pub fn of(&mut self, pane: Pane) -> Option<&mut dyn PaneView> {
        let found = self.0.iter_mut().find(|(own, _)| *own == pane)?;
        Some(&mut *found.1)
    }
}
