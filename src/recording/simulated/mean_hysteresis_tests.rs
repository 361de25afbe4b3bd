//! Mean hysteresis of the simulated sensor. It must equal the paper's figure.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

use super::sensor::{RATED_LOAD, Sensor};

/// Number of load steps from zero to the rated load. The two branches of a loop are compared at these loads.
const STEPS: i32 = 120;

/// Returns the mean hysteresis (N) of the simulated sensor after its rated load.
///
/// Each axis is loaded alone and slowly: zero, +rated, −rated, +rated (12 N, 0.25 N·m), without noise and creep. A linear
/// calibration, least squares with an offset over the six runs, turns the readings into loads. The result is
/// `|falling − rising|` at equal load, averaged over the load range and the three force axes.
///
/// **Source** Koike et al. 2019, section 4.2, measured 2.64 N "after rated output load was applied". The paper does not
/// define the figure; this definition is ours.
pub fn mean_hysteresis_newtons() -> f64 {
    let runs: Vec<Vec<[f64; 6]>> = (0..6).map(readings_of_axis).collect();
    let shares = load_shares();
    let n = shares.len();
    let design = Mat::from_fn(6 * n, 7, |row, column| {
        runs[row / n][row % n].get(column).copied().unwrap_or(1.0)
    });
    let loads = Mat::from_fn(6 * n, 3, |row, axis| {
        if row / n == axis {
            f64::from(shares[row % n]) / f64::from(STEPS) * RATED_LOAD[axis]
        } else {
            0.0
        }
    });
    let load_from_gauges = design.qr().solve_lstsq(&loads);
    let calibrated = &design * &load_from_gauges;
    let widths = (0..3).flat_map(|axis| {
        let calibrated = &calibrated;
        // Seen from the reversal, the falling branch lies before it, and the rising branch lies after it.
        let reversal = 3 * STEPS as usize;
        (0..=2 * STEPS as usize).map(move |away| {
            let falling = calibrated[(axis * n + reversal - away, axis)];
            let rising = calibrated[(axis * n + reversal + away, axis)];
            (falling - rising).abs()
        })
    });
    let count = 3 * (2 * STEPS + 1);
    widths.sum::<f64>() / f64::from(count)
}

/// Returns the loads in units of `1 / STEPS` of the rated load: 0 → +1 → −1 → +1.
fn load_shares() -> Vec<i32> {
    let up = 0..STEPS;
    let down = (-STEPS + 1..=STEPS).rev();
    up.chain(down).chain(-STEPS..=STEPS).collect()
}

fn readings_of_axis(axis: usize) -> Vec<[f64; 6]> {
    let mut sensor = Sensor::without_creep();
    load_shares()
        .into_iter()
        .map(|share| {
            let mut load = [0.0; 6];
            load[axis] = f64::from(share) / f64::from(STEPS) * RATED_LOAD[axis];
            sensor.read(&load)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_are_mirrored_around_the_reversal() {
        let shares = load_shares();
        let reversal = 3 * STEPS as usize;
        assert_eq!(shares[reversal], -STEPS);
        for away in 0..=2 * STEPS as usize {
            assert_eq!(shares[reversal - away], shares[reversal + away]);
        }
        assert_eq!(shares.len() - 1, reversal + 2 * STEPS as usize);
    }

    #[test]
    fn mean_hysteresis_is_the_papers() {
        let newtons = mean_hysteresis_newtons();
        assert!((newtons - 2.64).abs() < 0.1, "{newtons} N");
    }
}
