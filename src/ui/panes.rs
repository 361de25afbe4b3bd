//! List of all panes, in the order of the menus. A new pane needs one file, and one line in this list.

use crate::ui::{command::Pane, pane::PaneView};

type Entry = (Pane, fn() -> Box<dyn PaneView>);

const PANES: &[Entry] = &[
    (Pane::RECORDINGS, of::<super::recordings_panel::View>),
    (Pane::SETTINGS, of::<super::settings_panel::View>),
    (Pane::TRACES, of::<super::trace_panes::View>),
    (Pane::LOOK_BACK, of::<super::look_back_pane::View>),
    (Pane::THRESHOLDS, of::<super::thresholds_pane::View>),
    (Pane::PAIRS, of::<super::pairs_pane::View>),
    (Pane::MODELS, of::<super::models_pane::View>),
    (Pane::TRADE, of::<super::trade_pane::View>),
    (Pane::LOOPS, of::<super::loops_pane::LoopsPane>),
    (Pane::AXES, of::<super::axes_pane::View>),
    (Pane::METROLOGY, of::<super::metrology_pane::MetrologyPane>),
    (Pane::ERRORS, of::<super::errors_pane::View>),
    (Pane::CALIBRATION, of::<super::calibration_pane::View>),
    (Pane::EXPORT, of::<super::export_pane::View>),
    (Pane::NOTES, of::<super::notes_pane::View>),
    (Pane::LIVE, of::<super::live_pane::View>),
    (Pane::CHECK, of::<super::check_pane::View>),
    (Pane::CHANNELS, of::<super::channels_pane::View>),
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
        Pane::THRESHOLDS,
        Pane::PAIRS,
        Pane::MODELS,
        Pane::AXES,
        Pane::METROLOGY,
        Pane::ERRORS,
        Pane::CALIBRATION,
        Pane::CHECK,
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
