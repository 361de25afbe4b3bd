//! Computes the gauge readings that a tared sensor has without load. Recordings, running sensors and exported code use them.

use std::borrow::Cow;

use faer::Mat;

use crate::{calibration::calibration::Calibration, recording::Recording};

impl Calibration {
    /// Returns the gauge readings that the tared sensor has without load. They are zero if the calibration was fitted to
    /// tared gauges or has no offset term. Otherwise, many readings give the conventional load zero. Those nearest to the
    /// training mean are returned, where distances are measured in standard deviations of each gauge.
    pub fn unloaded(&self) -> Vec<f64> {
        let scale = &self.gauge_scale;
        if self.tare.is_some() || !self.offset {
            return vec![0.0; scale.shift.len()];
        }
        let mut base = vec![0.0; self.axes.len()];
        self.conventional.apply(&scale.shift, &mut base);
        let loads = Mat::from_fn(base.len(), 1, |axis, _| -base[axis]);
        let Some(slopes) = self.gauges_per_load() else {
            return scale.shift.clone();
        };
        let steps = slopes * loads;
        let gauges = scale.shift.iter().zip(&scale.deviation).enumerate();
        let gauges =
            gauges.map(|(gauge, (shift, deviation))| shift + deviation * steps[(gauge, 0)]);
        gauges.collect()
    }

    /// Returns the smallest change of the gauges (in standard deviations) that changes the conventional load by one unit on
    /// one axis: one column per axis. `None` if the singular values of the matrix cannot be computed.
    pub(crate) fn gauges_per_load(&self) -> Option<Mat<f64>> {
        let deviation = &self.gauge_scale.deviation;
        let matrix = &self.conventional.matrix;
        let slopes = Mat::from_fn(matrix.len(), deviation.len(), |axis, gauge| {
            matrix[axis][gauge] * deviation[gauge]
        });
        Some(slopes.thin_svd().ok()?.pseudoinverse())
    }

    /// Adds the readings of [`unloaded`](Self::unloaded) to the gauges of a tared recording if the calibration was fitted
    /// without tare.
    pub(super) fn with_own_zero<'a>(&self, recording: Cow<'a, Recording>) -> Cow<'a, Recording> {
        match recording.tare() {
            Some(tare) if self.tare.is_none() && self.offset => {
                let offsets: Vec<f64> = self.unloaded().iter().map(|gauge| -gauge).collect();
                Cow::Owned(recording.into_owned().less_offsets(&offsets, tare))
            }
            _ => recording,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use crate::calibration::calibration::Calibration;
    use crate::calibration::estimator::Estimator;
    use crate::calibration::settings::FitSettings;
    use crate::progress::Progress;
    use crate::questions::{Request, train};
    use crate::recording::{Entry, Recording, RecordingSet, Role, Tare, simulated};

    /// Returns a calibration of the built-in sensor without tare, fitted to two recordings, and a third recording.
    fn fitted() -> (Calibration, Recording) {
        let all = simulated::recordings(7);
        let of = |at: usize| all.entries()[at].recording.decimated(4);
        let mut set = RecordingSet::default();
        for at in [3, 40] {
            set.push(Entry::new(of(at), Role::Train)).unwrap();
        }
        let request = Request::fit(Arc::new(set), FitSettings::default());
        let calibration = train(&request, &Progress::default(), &mut |_| {}).unwrap();
        (calibration, of(11))
    }

    #[test]
    fn tared_gauges_show_no_load_where_the_calibration_was_not_tared() {
        let (calibration, recording) = fitted();
        assert_eq!(calibration.tare, None);
        let (tared, _) = recording.tared(Tare::Interval(0.0, 1.0)).unwrap();
        let first = tared.times().partition_point(|t| t - tared.times()[0] <= 1.0);
        let loads = calibration.apply(&tared).unwrap().conventional;
        for (axis, full_scale) in calibration.full_scale.iter().enumerate() {
            let own = loads[axis..].iter().step_by(6).take(first);
            let mean = own.sum::<f64>() / first as f64;
            assert!(mean.abs() < 1e-9 * full_scale, "{axis}: {mean}");
        }
    }

    #[test]
    fn the_estimator_tares_as_apply_does() {
        let (calibration, recording) = fitted();
        let (tared, _) = recording.clone().tared(Tare::Interval(0.0, 1.0)).unwrap();
        let mean: Vec<f64> = (0..6).map(|gauge| tared.tared_by(gauge)).collect();
        let expected = calibration.apply(&tared).unwrap();
        let design = calibration.design();
        let mut estimator = Estimator::new(&calibration, &design).unwrap();
        assert!(estimator.tare(&mean[1..]).is_err());
        estimator.tare(&mean).unwrap();
        for (k, time) in recording.times().iter().enumerate() {
            let (_, load) = estimator.update(*time, recording.gauges_at(k)).unwrap();
            for (axis, load) in load.iter().enumerate() {
                let expected = expected.compensated[6 * k + axis];
                let off = (load - expected).abs() / calibration.full_scale[axis];
                assert!(off < 1e-9, "sample {k}: {load} is not {expected}");
            }
        }
    }
}
