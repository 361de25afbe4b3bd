//! What undo and redo go back and forward over: every setting and role, and which calibration is applied or compared with.

use std::sync::Arc;

use crate::app::{AppState, Applied, Effect, FactoryCalibration};
use crate::calibration::{Calibration, FitSettings};
use crate::recording::{Axis, RecordingSet};

/// The choices of one moment. Recordings are shared, not copied.
#[derive(Clone, Debug)]
pub struct Choices {
    settings: FitSettings,
    recordings: Arc<RecordingSet>,
    unsplit: Option<Arc<RecordingSet>>,
    cut: f64,
    hidden_axes: Vec<Axis>,
    applied: Option<Applied>,
    factory: Option<FactoryCalibration>,
}

impl PartialEq for Choices {
    /// Whether nothing was chosen in between; recordings are not compared number by number.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.recordings, &other.recordings)
            && self.unsplit.as_ref().map(Arc::as_ptr) == other.unsplit.as_ref().map(Arc::as_ptr)
            && self.settings == other.settings
            && self.hidden_axes == other.hidden_axes
            && self.calibrations() == other.calibrations()
    }
}

impl Choices {
    /// Which calibrations they are; equal ones that were opened twice count as two.
    fn calibrations(&self) -> [Option<*const Calibration>; 2] {
        [
            self.applied.as_ref().map(|one| &one.calibration),
            self.factory.as_ref().map(|one| &one.calibration),
        ]
        .map(|calibration| calibration.map(Arc::as_ptr))
    }
}

impl AppState {
    /// The choices of now.
    #[must_use]
    pub fn choices(&self) -> Choices {
        Choices {
            settings: self.settings.clone(),
            recordings: Arc::clone(&self.recordings),
            unsplit: self.unsplit.clone(),
            cut: self.cut,
            hidden_axes: self.hidden_axes.clone(),
            applied: self.applied.clone(),
            factory: self.factory.clone(),
        }
    }

    /// Goes to the choices of another moment.
    pub(super) fn restore(&mut self, choices: Choices) -> Vec<Effect> {
        let Choices {
            settings,
            recordings,
            unsplit,
            cut,
            hidden_axes,
            applied,
            factory,
        } = choices;
        let parts = |set: &RecordingSet| -> Vec<_> {
            set.entries()
                .iter()
                .map(|entry| Arc::as_ptr(&entry.recording))
                .collect()
        };
        let same_order = parts(&self.recordings) == parts(&recordings);
        self.settings = settings;
        self.recordings = recordings;
        self.unsplit = unsplit;
        self.cut = cut;
        self.hidden_axes = hidden_axes;
        self.applied = applied;
        self.factory = factory;
        if !same_order {
            self.forget_results();
            self.view = self.view.within(self.recordings.entries().len());
        }
        self.analyse()
    }
}
