//! Conventional calibration: the load from the present gauges alone (Eq. 3-8 of the paper of Koike et al., 2019).
//!
//! The conventional calibration is fitted first, because the look-back of the compensated calibration compares its loads.

use rayon::prelude::*;

use crate::{
    calibration::{
        linear::{Ridge, Terms, fit},
        linear_map::{LinearMap, PresentLoads},
        normal_equations::NormalEquations,
        sums::{Piece, recording_sums},
    },
    features::{Design, FeatureSettings, GaugeScale},
    progress::Progress,
    recording::Recording,
};

/// Conventional calibration, and the shift and scale that standardise the gauges.
#[derive(Clone, Debug, PartialEq)]
pub struct Conventional {
    /// Mean and standard deviation of each gauge over the training recordings.
    pub scale: GaugeScale,
    /// Matrix that computes the load from the raw gauges.
    pub map: LinearMap,
}

impl Conventional {
    /// Fits the training recordings, then fits the residuals once more to remove rounding errors. The result is not valid after
    /// cancellation. Panics without training recordings, or if their columns differ.
    pub fn fit(training: &[&Recording], offset: bool, progress: &Progress) -> Self {
        let first = training.first().expect("the fit needs a training recording");
        let n_axes = first.axes().len();
        let design = Design {
            features: FeatureSettings::present(),
            scale: GaugeScale::measure(training.iter().copied(), first.n_gauges(), offset),
            offset,
            history_step_secs: 0.0,
        };
        let n_columns = design.n_columns();
        let mut map = LinearMap::new(design.columns(), vec![vec![0.0; n_columns]; n_axes]);
        for _ in 0..2 {
            let parts: Vec<_> = training
                .par_iter()
                .map(|recording| {
                    let loads = PresentLoads { map: &map, recording, kept: None };
                    let whole = Piece { samples: 0..recording.n_samples(), fold: 0 };
                    recording_sums(&design, loads, &[], &[whole], false, &[], progress)
                })
                .collect();
            let mut total = NormalEquations::new(n_columns, n_axes);
            for part in parts.iter().flatten() {
                total.add(part);
            }
            let terms = Terms {
                used: &design.all(),
                kinds: &design.kinds(),
                known: &[], // the first fit has the same columns
            };
            let correction = fit(&total, terms, Ridge::None).coefficients;
            map.matrix = map.corrected(&design, &correction);
        }
        Self { scale: design.scale, map }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::linear_map::loads_from_gauges;
    use crate::recording::{Axis, Source};
    use faer::Mat;
    use faer::linalg::solvers::SolveLstsq as _;

    /// Returns a recording whose gauges are far from zero and on different scales, with nearly linear loads.
    fn recording() -> Recording {
        let n = 400;
        let mut gauges = Vec::new();
        let mut loads = Vec::new();
        for k in 0..n {
            let t = f64::from(k);
            let (a, b) = ((0.05 * t).sin(), (0.031 * t).cos());
            gauges.extend([1e5 + 20.0 * a + b, 3e-3 + 1e-4 * (b - 0.3 * a), 7.0 * a * b]);
            loads.extend([10.0 * a + 0.2 * b * b, b - a + 0.1 * a * a * a]);
        }
        Recording::new(
            "r",
            Source::Simulated,
            (0..n).map(f64::from).collect(),
            vec!["S1".into(), "S2".into(), "S3".into()],
            gauges,
            vec![Axis::Fz, Axis::Mx],
            loads,
        )
        .unwrap()
    }

    #[test]
    fn predictions_equal_those_of_a_qr_solution_with_and_without_offset() {
        let recording = recording();
        let n = recording.n_samples();
        for offset in [true, false] {
            let map = Conventional::fit(&[&recording], offset, &Progress::default()).map;
            let x = Mat::from_fn(n, 3 + usize::from(offset), |k, j| {
                recording.gauges_at(k).get(j).copied().unwrap_or(1.0)
            });
            let y = Mat::from_fn(n, 2, |k, j| recording.loads()[k * 2 + j]);
            let expected = &x * x.col_piv_qr().solve_lstsq(&y);
            let loads = loads_from_gauges(&map, &recording);
            for k in 0..n {
                for axis in 0..2 {
                    let difference = loads[k * 2 + axis] - expected[(k, axis)];
                    assert!(difference.abs() < 1e-8, "offset {offset}, sample {k}: {difference}");
                }
            }
        }
    }
}
