//! Measures that combine the errors of several axes in one number.
//!
//! Guarantees: every measure is the root of a weighted sum of the axes' squared errors. The same weights therefore apply to
//! sums of squared errors.

use serde::{Deserialize, Serialize};

use crate::recording::Axis;

/// Error that the choice of thresholds or feature values minimises: that of one axis, or that of several axes in one number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// RMSE of the axis with this index, in the unit of the axis.
    Axis(usize),
    /// Root mean square of the RMSEs of the force axes (N).
    Forces,
    /// Root mean square of the RMSEs of the moment axes (N·m).
    Moments,
    /// Root mean square of the RMSEs of all axes, each in percent of its full scale. Axes without a full scale do not count.
    FullScale,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasureScale {
    /// Load axes of the sensor, in the order in which lists give the errors of the axes.
    pub axes: Vec<Axis>,
    pub full_scale: Vec<f64>,
}

impl MeasureScale {
    /// Returns all measures that exist for these axes: first those that combine several axes, then each axis alone.
    pub fn measures(&self) -> Vec<Measure> {
        let groups = [Measure::Forces, Measure::Moments, Measure::FullScale];
        let axes = (0..self.axes.len()).map(Measure::Axis);
        groups.into_iter().chain(axes).filter(|measure| measure.weights(self).is_some()).collect()
    }

    /// Returns the default measure: the error of the force axes or, without a force axis, of all axes in percent of full
    /// scale.
    pub fn default_measure(&self) -> Measure {
        if Measure::Forces.weights(self).is_some() { Measure::Forces } else { Measure::FullScale }
    }
}

impl Measure {
    /// Returns the weight of each axis' squared error in the measure; `None` if no axis of the sensor belongs to the measure.
    pub fn weights(self, scale: &MeasureScale) -> Option<Vec<f64>> {
        let weight = |(at, (axis, full)): (usize, (&Axis, &f64))| {
            let (counts, factor) = match self {
                Self::Axis(only) => (only == at, 1.0),
                Self::Forces => (axis.is_force(), 1.0),
                Self::Moments => (!axis.is_force(), 1.0),
                Self::FullScale => (*full > 0.0, 100.0 / full),
            };
            if counts { factor.powi(2) } else { 0.0 }
        };
        let axes = scale.axes.iter().zip(&scale.full_scale).enumerate();
        let mut weights: Vec<f64> = axes.map(weight).collect();
        let count = weights.iter().filter(|weight| **weight > 0.0).count();
        for weight in &mut weights {
            *weight /= count.max(1) as f64;
        }
        (count > 0).then_some(weights)
    }

    /// Returns the value of the measure, computed from the RMSE of each axis; `None` if no axis of the sensor belongs to it.
    pub fn of_rmse(self, scale: &MeasureScale, rmse: &[f64]) -> Option<f64> {
        let weights = self.weights(scale)?;
        let squares = weights.iter().zip(rmse).map(|(w, rmse)| w * rmse * rmse);
        Some(squares.sum::<f64>().sqrt())
    }

    pub(crate) fn unit(self, scale: &MeasureScale) -> &'static str {
        match self {
            Self::Axis(at) => scale.axes.get(at).map_or("", |axis| axis.unit()),
            Self::Forces => Axis::Fx.unit(),
            Self::Moments => Axis::Mx.unit(),
            Self::FullScale => "% FS",
        }
    }

    /// Returns the name with a capital letter.
    pub(crate) fn title(self, scale: &MeasureScale) -> &'static str {
        match self {
            Self::Forces => "Forces",
            Self::Moments => "Moments",
            Self::FullScale => "All axes",
            Self::Axis(_) => self.label(scale),
        }
    }

    pub(crate) fn label(self, scale: &MeasureScale) -> &'static str {
        match self {
            Self::Axis(at) => scale.axes.get(at).map_or("", |axis| axis.symbol()),
            Self::Forces => "forces",
            Self::Moments => "moments",
            Self::FullScale => "all axes",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoring::metrics::Group;

    fn scale() -> MeasureScale {
        MeasureScale { axes: vec![Axis::Fx, Axis::Fz, Axis::Mx], full_scale: vec![10.0, 20.0, 0.0] }
    }

    #[test]
    fn groups_are_those_of_the_table_of_errors() {
        let (scale, rmse) = (scale(), [1.0, 7.0, 9.0]);
        let of = |measure: Measure| measure.of_rmse(&scale, &rmse);
        assert_eq!(of(Measure::Forces), Group::Force.rmse(&scale.axes, &rmse));
        assert_eq!(of(Measure::Moments), Group::Moment.rmse(&scale.axes, &rmse));
        assert_eq!(of(Measure::Axis(1)), Some(7.0));
        assert_eq!(of(Measure::Axis(3)), None);
    }

    /// The errors are 10 % of 10 N and 35 % of 20 N: √((100 + 1225) / 2). The axis without a full scale does not count.
    #[test]
    fn full_scale_counts_each_axis_in_percent_of_its_own() {
        let value = Measure::FullScale.of_rmse(&scale(), &[1.0, 7.0, 9.0]);
        assert!((value.unwrap() - 662.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn only_measures_with_an_axis_are_offered() {
        let moment = MeasureScale { axes: vec![Axis::Mz], full_scale: vec![0.5] };
        assert_eq!(moment.measures(), [Measure::Moments, Measure::FullScale, Measure::Axis(0)]);
        assert_eq!(moment.default_measure(), Measure::FullScale);
        assert_eq!(scale().default_measure(), Measure::Forces);
    }
}
