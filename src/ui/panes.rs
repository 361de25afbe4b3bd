//! List of all panes, in the order of the menus. A new pane needs one file, and one line in this list.

use crate::ui::{command::Pane, pane::PaneView};

type Entry = (Pane, fn() -> Box<dyn PaneView>);

const PANES: &[Entry] = &[
    (super::recordings_panel::PANE, of::<super::recordings_panel::View>),
    (super::settings_panel::PANE, of::<super::settings_panel::View>),
    (super::trace_panes::PANE, of::<super::trace_panes::View>),
    (super::look_back_pane::PANE, of::<super::look_back_pane::View>),
    (super::thresholds_pane::PANE, of::<super::thresholds_pane::View>),
    (super::pairs_pane::PANE, of::<super::pairs_pane::View>),
    (super::models_pane::PANE, of::<super::models_pane::View>),
    (super::trade_pane::PANE, of::<super::trade_pane::View>),
    (super::loops_pane::PANE, of::<super::loops_pane::LoopsPane>),
    (super::axes_pane::PANE, of::<super::axes_pane::View>),
    (super::metrology_pane::PANE, of::<super::metrology_pane::MetrologyPane>),
    (super::errors_pane::PANE, of::<super::errors_pane::View>),
    (super::calibration_pane::PANE, of::<super::calibration_pane::View>),
    (super::export_pane::PANE, of::<super::export_pane::View>),
    (super::notes_pane::PANE, of::<super::notes_pane::View>),
    (super::live_pane::PANE, of::<super::live_pane::View>),
    (super::check_pane::PANE, of::<super::check_pane::View>),
    (super::channels_pane::PANE, of::<super::channels_pane::View>),
];

fn of<V: PaneView + Default + 'static>() -> Box<dyn PaneView> {
    Box::<V>::default()
}

/// Returns all panes, in the order in which the menus list them.
pub fn all() -> impl DoubleEndedIterator<Item = Pane> + ExactSizeIterator {
    PANES.iter().map(|(pane, _)| *pane)
}

/// Returns true if the pane shows nothing without a calibration. The panes of traces and loops then show single channels.
pub fn needs_calibration(pane: Pane) -> bool {
    let waiting = [
        super::thresholds_pane::PANE,
        super::pairs_pane::PANE,
        super::models_pane::PANE,
        super::axes_pane::PANE,
        super::metrology_pane::PANE,
        super::errors_pane::PANE,
        super::calibration_pane::PANE,
        super::check_pane::PANE,
    ];
    waiting.contains(&pane)
}

/// Returns the pane with this key.
pub fn named(key: &str) -> Option<Pane> {
    all().find(|pane| pane.key == key)
}

pub struct Views(Vec<(Pane, Box<dyn PaneView>)>);

impl Default for Views {
    fn default() -> Self {
        Self(PANES.iter().map(|(pane, make)| (*pane, make())).collect())
    }
}

impl Views {
    pub fn of(&mut self, pane: Pane) -> Option<&mut dyn PaneView> {
        let found = self.0.iter_mut().find(|(known, _)| *known == pane)?;
        Some(&mut *found.1)
    }
}
