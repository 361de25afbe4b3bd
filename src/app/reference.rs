//! The matrix that the sensor came with, beside the one that is fitted.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::{AppState, Effect, Level, Notice};
use crate::calibration::Calibration;
use crate::export::{name_gauges, names_gauges};

/// A calibration to compare with.
#[derive(Clone, Debug, PartialEq)]
pub struct FactoryCalibration {
    /// The file that it came from.
    pub path: PathBuf,
    /// It, with the gauges of the loaded recordings.
    pub calibration: Arc<Calibration>,
}

impl AppState {
    pub(super) fn take_factory(&mut self, path: PathBuf, calibration: &Calibration) -> Vec<Effect> {
        let calibration = Arc::new(calibration.clone());
        self.factory = Some(FactoryCalibration { path, calibration });
        self.fit_factory();
        self.analyse()
    }

    /// Goes on without it.
    pub(super) fn drop_factory(&mut self) -> Vec<Effect> {
        self.factory = None;
        self.analyse()
    }

    /// Gives it the loaded gauges' names where it knows them by their order only; one for other gauges goes.
    pub(super) fn fit_factory(&mut self) {
        let names = &self.recordings.layout().gauge_names;
        let Some(factory) = self.factory.as_mut().filter(|_| !names.is_empty()) else {
            return;
        };
        if !names_gauges(&factory.path) {
            name_gauges(Arc::make_mut(&mut factory.calibration), names);
        }
        if factory.calibration.gauges != *names {
            let text = format!(
                "{}: made for {} gauges, while the loaded recordings have {}",
                factory.path.display(),
                factory.calibration.gauges.len(),
                names.join(" "),
            );
            self.factory = None;
            self.tell(Notice::new(Level::Error, text));
        }
    }
}
