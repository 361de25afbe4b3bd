//! Recordings that contradict the others: of another mounting, with a wrong reference or a gauge that changed.

use crate::calibration::{Calibration, NormalEquations, OddRecording};
use crate::questions::dataset::Dataset;
use crate::questions::errors::fit::Sums;
use crate::recording::Role;
use crate::scoring::cross_validation::are_left_out_whole;
use crate::scoring::information::Information;
use crate::shown::first;

/// Left out, it errs by so many times what the same fit leaves on the others ...
const TIMES: f64 = 4.0;
/// ... and by so many times what that is for most of the others ...
const TIMES_OF_MOST: f64 = 3.0;
/// ... and by this share of full scale.
const MATTERS: f64 = 0.02;
/// With fewer parts it cannot be told which of them contradicts.
const FEWEST: usize = 3;

impl Dataset {
    /// Those of the training recordings that the fits without them predict far worse than they fit the others, although these say what to
    /// expect. `each` has the coefficients of the fit without each part.
    pub fn odd_recordings(
        &self,
        sums: &Sums,
        each: &[Vec<f64>],
        calibration: &Calibration,
    ) -> Vec<OddRecording> {
        let parts = &sums.parts;
        if each.len() < FEWEST || !are_left_out_whole(&self.training_groups()) {
            return Vec::new();
        }
        let mean = |squares: f64, n: u64| (squares.max(0.0) / n.max(1) as f64).sqrt();
        // By part, by axis: the error on the part that is left out, and on the others.
        let errors: Vec<Vec<(f64, f64)>> = (parts.iter().zip(each))
            .map(|(part, coefficients)| {
                let n_others = sums.train.n_samples() - part.n_samples();
                let own = part.squared_residuals(coefficients).into_iter();
                let all = sums.train.squared_residuals(coefficients).into_iter();
                own.zip(all)
                    .map(|(own, all)| (mean(own, part.n_samples()), mean(all - own, n_others)))
                    .collect()
            })
            .collect();
        let mut found: Vec<OddRecording> = Vec::new();
        for (at, part) in parts.iter().enumerate() {
            let worst = calibration.axes.iter().enumerate().filter_map(|(axis, name)| {
                let times = |of: &Vec<(f64, f64)>| of[axis].0 / of[axis].1;
                let (error, others) = errors[at][axis];
                let mut most: Vec<f64> = errors.iter().map(times).collect();
                most.sort_by(f64::total_cmp);
                let is_odd = error > TIMES * others
                    && error > TIMES_OF_MOST * most[most.len() / 2] * others
                    && error > MATTERS * calibration.full_scale[axis];
                is_odd.then_some((error / others, *name, error, others))
            });
            let Some((_, axis, error, others)) = worst.max_by(|a, b| a.0.total_cmp(&b.0)) else {
                continue;
            };
            // Where the others do not say what to expect, to be far off is no contradiction.
            let mut rest = NormalEquations::new(part.n_features(), part.n_targets());
            let other = parts.iter().enumerate().filter(|(other, _)| *other != at);
            other.for_each(|(_, part)| rest.add(part));
            let columns: Vec<usize> = (0..part.n_features()).collect();
            let known = Information::of(&rest, &columns);
            let is_known = |own: Information| own.leverage(part) <= part.n_samples() as f64;
            if known.is_some_and(is_known) {
                found.push(OddRecording { recording: self.name_of_part(at), axis, error, others });
            }
        }
        found
    }

    /// What the training recordings of a part are called.
    fn name_of_part(&self, part: usize) -> String {
        let entries = self.entries.iter().zip(self.pieces());
        let own = entries.filter(|(entry, pieces)| {
            entry.role == Role::Train && pieces.iter().any(|piece| piece.fold == part)
        });
        first(1, own.map(|(entry, _)| entry.recording.name()))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::FitSettings;
    use crate::features::FeatureSettings;
    use crate::progress::Progress;
    use crate::questions::errors::query::analyse;
    use crate::questions::request::Request;
    use crate::random::Random;
    use crate::recording::{Axis, Entry, Recording, RecordingSet, Source};

    /// Four gauges that show three forces, which stand in the reference turned by so many degrees about z, times a factor.
    fn recording(name: &str, turned: f64, factor: f64) -> Recording {
        let mut random = Random::new(5, &[name.len() as u64, name.as_bytes()[0].into()]);
        let (mut gauges, mut loads) = (Vec::new(), Vec::new());
        let (sin, cos) = turned.to_radians().sin_cos();
        for k in 0..600 {
            let t = 0.05 * f64::from(k) + f64::from(name.as_bytes()[0]);
            let [x, y, z] = [(0.9 * t).sin(), (1.3 * t).cos(), (0.7 * t + 1.0).sin()]
                .map(|load| 10.0 * factor * load);
            for (a, b, c) in [(1.0, 0.3, 0.5), (-0.5, 1.0, 0.5), (-0.5, -1.0, 0.5), (0.1, 0.2, 1.0)]
            {
                gauges.push(a * x + b * y + c * z + 0.05 * random.normal());
            }
            loads.extend([cos * x - sin * y, sin * x + cos * y, z]);
        }
        let times = (0..600).map(|k| 0.01 * f64::from(k)).collect();
        let names = ["S1", "S2", "S3", "S4"].map(str::to_owned).to_vec();
        let axes = vec![Axis::Fx, Axis::Fy, Axis::Fz];
        Recording::new(name, Source::Simulated, times, names, gauges, axes, loads).unwrap()
    }

    fn odd(recordings: Vec<Recording>) -> Vec<OddRecording> {
        let mut set = RecordingSet::default();
        for recording in recordings {
            set.push(Entry::new(recording, Role::Train)).unwrap();
        }
        let settings =
            FitSettings { features: FeatureSettings::present(), ..FitSettings::default() };
        let request = Request::fit(Arc::new(set), settings);
        let analysis = analyse(&request, &Progress::default()).unwrap();
        analysis.calibration.quality.odd.clone()
    }

    #[test]
    fn a_recording_of_another_mounting_is_named_and_none_of_one() {
        let good = |name: &str| recording(name, 0.0, 1.0);
        assert_eq!(odd(["a", "b", "c", "d"].map(good).to_vec()), []);
        let found = odd(vec![good("a"), good("b"), recording("c", 20.0, 1.0), good("d")]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].recording, "c");
        assert!(found[0].error > 4.0 * found[0].others);
        // Larger loads are predicted as well; with two nobody can say which is wrong.
        assert_eq!(odd(vec![good("a"), good("b"), recording("c", 0.0, 3.0)]), []);
        assert_eq!(odd(vec![good("a"), recording("b", 20.0, 1.0)]), []);
    }
}
