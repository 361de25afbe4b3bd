//! Loads and errors of the sensor's factory calibration, for comparison with the fitted calibration.
//!
//! Guarantees: the gauges of the factory calibration are matched by name with the gauges of the recordings. An axis that the
//! factory calibration lacks has no factory trace and no factory error.
//!
//! A factory matrix has no offset, because a sensor is tared before use. In place of a tare, the mean error of each axis on
//! the training recordings is subtracted from the axis' loads in all recordings.

use std::path::Path;

use rayon::prelude::*;

use crate::{
    calibration::{Calibration, CalibrationError, FactoryScores, loads_from_gauges},
    column::column,
    export::{ReadCalibrationError, name_gauges, names_gauges, read_calibration},
    recording::{Axis, Entry, Role, SensorFrame, frame::change_frame},
};

/// Reads the factory calibration for a comparison; see [`Request::factory`](crate::questions::Request::factory). If the file
/// lists its gauges by position only (an ATI-style `.cal`), the gauges get the names `gauge_names`.
///
/// # Errors
/// [`ReadCalibrationError`] if the file cannot be read.
pub fn read_factory(
    path: &Path,
    gauge_names: &[String],
) -> Result<Calibration, ReadCalibrationError> {
    let mut calibration = read_calibration(path)?;
    if !names_gauges(path) {
        name_gauges(&mut calibration, gauge_names);
    }
    Ok(calibration)
}

#[derive(Debug)]
pub struct Factory {
    /// Loads of each recording by the factory calibration before the offset, `n × n_axes` row-major with its axes.
    loads: Vec<Vec<f64>>,
    axes: Vec<Axis>,
    /// Offset that takes the place of a tare: added to the loads of each axis of the factory calibration (N or N·m).
    offsets: Vec<f64>,
}

impl Factory {
    /// Computes the loads of the factory calibration in the frame of the reference loads.
    pub fn new(calibration: &Calibration, entries: &[Entry]) -> Result<Self, CalibrationError> {
        for entry in entries {
            calibration.check_gauges(&entry.recording)?;
        }
        let mut loads: Vec<Vec<f64>> = (entries.par_iter())
            .map(|entry| loads_from_gauges(&calibration.conventional, &entry.recording))
            .collect();
        let measured = entries.iter().find(|entry| entry.recording.has_reference());
        let frame = measured.map_or(calibration.frame, |entry| entry.recording.frame());
        if frame != calibration.frame {
            let matrix = SensorFrame::between(calibration.frame, frame, &calibration.axes);
            let matrix =
                matrix.map_err(|(axis, missing)| CalibrationError::Frame { axis, missing })?;
            loads.par_iter_mut().for_each(|loads| *loads = change_frame(loads, &matrix));
        }
        let mut factory = Self {
            offsets: vec![0.0; calibration.axes.len()],
            axes: calibration.axes.clone(),
            loads,
        };
        if !calibration.offset {
            let mean_error = |axis: &Axis| mean(factory.errors(entries, *axis, Role::Train));
            let errors: Vec<_> = factory.axes.iter().map(mean_error).collect();
            factory.offsets =
                errors.into_iter().map(|error| error.map_or(0.0, |error| -error)).collect();
        }
        Ok(factory)
    }

    fn column(&self, axis: Axis) -> Option<usize> {
        self.axes.iter().position(|known| *known == axis)
    }

    pub fn load(&self, recording: usize, axis: Axis) -> Option<impl Iterator<Item = f64> + '_> {
        let column = self.column(axis)?;
        let offset = self.offsets[column];
        let values = self::column(&self.loads[recording], self.axes.len(), column);
        Some(values.map(move |load| load + offset))
    }

    /// Returns the errors of the factory calibration on one axis (N or N·m), in all recordings that have this role and a
    /// reference for the axis.
    fn errors(&self, entries: &[Entry], axis: Axis, role: Role) -> impl Iterator<Item = f64> {
        let entries = entries.iter().enumerate().filter(move |(_, entry)| entry.role == role);
        let pairs = entries.filter_map(move |(at, entry)| {
            Some(self.load(at, axis)?.zip(entry.recording.load(axis)?))
        });
        pairs.flatten().map(|(load, truth)| load - truth)
    }

    pub fn scores(&self, entries: &[Entry], axes: &[Axis]) -> FactoryScores {
        let rmse = |role: Role| {
            let squares =
                |axis: &Axis| self.errors(entries, *axis, role).map(|error| error * error);
            axes.iter().map(|axis| mean(squares(axis)).map(f64::sqrt)).collect()
        };
        let offset = |axis: &Axis| Some(self.offsets[self.column(*axis)?]);
        FactoryScores {
            train_rmse: rmse(Role::Train),
            test_rmse: rmse(Role::Test),
            offsets: axes.iter().map(offset).collect(),
        }
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (n, sum) = values.fold((0_u64, 0.0), |(n, sum), value| (n + 1, sum + value));
    (n > 0).then(|| sum / n as f64)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::FitSettings;
    use crate::progress::Progress;
    use crate::questions::error::AnalysisError;
    use crate::questions::errors::query::analyse;
    use crate::questions::request::Request;
    use crate::questions::request::View;
    use crate::recording::{Recording, RecordingSet, Source};

    /// Six gauges, each of which reads half of its own load plus 3. The axes of the recording are Fz and Mx.
    fn set() -> Arc<RecordingSet> {
        let mut set = RecordingSet::default();
        for (name, role) in [("a", Role::Train), ("b", Role::Train), ("c", Role::Test)] {
            let n = 60;
            let times: Vec<f64> = (0..n).map(|k| f64::from(k) / 10.0).collect();
            let load = |t: f64, axis: usize| (t * (1.0 + axis as f64)).sin() + 0.2 * axis as f64;
            let gauges = times.iter().flat_map(|t| (0..6).map(move |g| 0.5 * load(*t, g) + 3.0));
            let loads = times.iter().flat_map(|t| [load(*t, 2), load(*t, 3)]);
            let names = (1..=6).map(|g| format!("gauge {g}")).collect();
            let (gauges, loads) = (gauges.collect(), loads.collect());
            let axes = vec![Axis::Fz, Axis::Mx];
            let recording =
                Recording::new(name, Source::Simulated, times, names, gauges, axes, loads);
            set.push(Entry::new(recording.unwrap(), role)).unwrap();
        }
        Arc::new(set)
    }

    /// Forces in kN and moments in N-mm: in SI, the matrix of the file is twice the unit matrix.
    fn cal_file(directory: &Path) -> std::path::PathBuf {
        let rows: String = (["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"].iter().enumerate())
            .map(|(at, name)| {
                let mut values = ["0"; 6];
                values[at] = if at < 3 { "0.002" } else { "2000" };
                let values = values.join(" ");
                format!("<UserAxis Name=\"{name}\" values=\"{values}\" max=\"9\"/>")
            })
            .collect();
        let units = "ForceUnits=\"kN\" TorqueUnits=\"N-mm\"";
        let text = format!(
            "<FTSensor NumGages=\"6\"><Calibration {units}>{rows}</Calibration></FTSensor>"
        );
        let path = directory.join("s.cal");
        std::fs::write(&path, text).unwrap();
        path
    }

    /// The matrix gives 2 (load / 2 + 3) = load + 6, and the tare subtracts 6.
    #[test]
    fn a_right_matrix_has_no_error_after_taring() {
        let directory = tempfile::tempdir().unwrap();
        let set = set();
        let names = &set.layout().gauge_names;
        let factory = read_factory(&cal_file(directory.path()), names).unwrap();
        let request = Request {
            factory: Some(Arc::new(factory)),
            view: View::All,
            ..Request::fit(Arc::clone(&set), FitSettings::default())
        };
        let analysis = analyse(&request, &Progress::default()).unwrap();
        let scores = analysis.factory.unwrap();
        for (rmse, offset) in scores.test_rmse.iter().zip(&scores.offsets) {
            assert!(rmse.unwrap() < 1e-12, "{scores:?}");
            assert!((offset.unwrap() + 6.0).abs() < 1e-12);
        }
        let [fz, mx] = &analysis.traces.axes[..] else {
            panic!("two axes");
        };
        for axis in [fz, mx] {
            let (factory, truth) = (axis.factory.as_ref(), axis.calculated.as_ref());
            let (factory, truth) = (factory.unwrap(), truth.unwrap());
            assert_eq!(factory.len(), 180);
            assert!((0..180).all(|k| (factory.value(k) - truth.value(k)).abs() < 1e-12));
            assert!(axis.factory_error.as_ref().unwrap().value(7).abs() < 1e-12);
        }
    }

    #[test]
    fn a_factory_matrix_for_other_gauges_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        let factory = read_factory(&cal_file(directory.path()), &["S1".to_owned()]).unwrap();
        let request = Request {
            factory: Some(Arc::new(factory)),
            ..Request::fit(set(), FitSettings::default())
        };
        let refused = analyse(&request, &Progress::default()).unwrap_err();
        assert!(matches!(refused, AnalysisError::Calibration(CalibrationError::Gauges { .. })));
    }
}
