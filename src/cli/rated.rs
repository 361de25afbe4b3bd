//! Rated loads, from arguments, a sensor's file or a calibration.

use crate::calibration::Calibration;
use crate::recording::Axis;
use crate::recording::identity::SensorFile;

/// Rated loads of the axes. The first source that names an axis wins.
#[derive(Debug, Default)]
pub struct Rated {
    pub full_scale: Vec<f64>,
    by_axis: Vec<SensorFile>,
}

impl Rated {
    pub fn of(full_scale: &[f64]) -> Self {
        Self { full_scale: full_scale.to_vec(), ..Self::default() }
    }

    /// Adds the rated loads of a sensor's file for the axes that have none yet.
    pub fn and(mut self, sensor: &SensorFile) -> Self {
        self.by_axis.push(sensor.clone());
        self
    }

    /// Adds the full scales of a calibration for the axes that have none yet.
    pub fn and_of(self, calibration: &Calibration) -> Self {
        let all = calibration.axes.iter().zip(&calibration.full_scale).zip(&calibration.rated);
        let rated_loads =
            all.filter(|(_, is_rated)| **is_rated).map(|((axis, scale), _)| (*axis, *scale));
        self.and(&SensorFile { rated_loads: rated_loads.collect(), ..SensorFile::default() })
    }

    /// Returns the rated load of each axis. Wrong values and wrong counts are reported elsewhere.
    pub fn on(&self, axes: &[Axis]) -> Vec<Option<f64>> {
        let is_of_them = self.full_scale.len() <= axes.len();
        let own = self.full_scale.iter().filter(|_| is_of_them);
        let mut rated: Vec<Option<f64>> =
            own.map(|load| Some(*load).filter(|load| *load > 0.0)).collect();
        for sensor in &self.by_axis {
            sensor.rate(axes, &mut rated);
        }
        rated
    }
}
