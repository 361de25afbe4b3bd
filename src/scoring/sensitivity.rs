//! How gauges answer to loads: the other way round from a calibration.

use crate::calibration::{NormalEquations, Ridge, Terms, fit};
use crate::features::ColumnKind;
use crate::recording::Recording;

/// Rows that are filled before they are multiplied.
const BLOCK: usize = 128;

/// `gauges ≈ zero + C · load`, by least squares.
///
/// **Source** the C of the paper's `S = C L` (Eq. 3), with the zero that real gauges have.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// C: one row per gauge, one number per axis (per N or N·m); zero where the load never moves.
    pub slopes: Vec<Vec<f64>>,
    /// What each gauge shows without a load.
    pub zero: Vec<f64>,
    /// What each gauge shows beside that, root mean square.
    pub rest: Vec<f64>,
    /// The mean of each gauge.
    pub mean: Vec<f64>,
    /// Whether the load of each axis moves.
    pub moves: Vec<bool>,
    /// How many samples it is of.
    pub n_samples: u64,
}

impl Sensitivity {
    /// Of recordings with the same gauges and axes; `None` without a sample.
    pub fn of(recordings: &[&Recording]) -> Option<Self> {
        let first = recordings.first()?;
        let (n_axes, n_gauges) = (first.axes().len(), first.n_gauges());
        let rows = || {
            recordings.iter().flat_map(|own| {
                let loads = own.loads().chunks_exact(n_axes.max(1));
                loads.zip(own.gauges().chunks_exact(n_gauges))
            })
        };
        let n = rows().count() as f64;
        if n == 0.0 {
            return None;
        }
        let (mut mean_load, mut mean) = (vec![0.0; n_axes], vec![0.0; n_gauges]);
        let (mut low, mut high) = (vec![f64::INFINITY; n_axes], vec![f64::NEG_INFINITY; n_axes]);
        for (load, gauges) in rows() {
            for (sum, value) in
                (mean_load.iter_mut().chain(&mut mean)).zip(load.iter().chain(gauges))
            {
                *sum += value / n;
            }
            for (axis, value) in load.iter().enumerate() {
                (low[axis], high[axis]) = (low[axis].min(*value), high[axis].max(*value));
            }
        }
        let spans: Vec<f64> = low.iter().zip(&high).map(|(low, high)| high - low).collect();
        let scale = |axis: usize| {
            if spans[axis] > 0.0 { 1.0 / spans[axis] } else { 0.0 }
        };
        let mut sums = NormalEquations::new(n_axes + 1, n_gauges);
        let stride = sums.stride();
        let mut block = Vec::with_capacity(BLOCK * stride);
        for (load, gauges) in rows() {
            let start = block.len();
            block.extend(
                (load.iter().zip(&mean_load).enumerate())
                    .map(|(at, (load, mean))| (load - mean) * scale(at)),
            );
            block.push(1.0);
            block.extend(gauges.iter().zip(&mean).map(|(gauge, mean)| gauge - mean));
            block.resize(start + stride, 0.0);
            if block.len() == BLOCK * stride {
                sums.add_rows(&block);
                block.clear();
            }
        }
        sums.add_rows(&block);
        let mut kinds = vec![ColumnKind::Gauge; n_axes];
        kinds.push(ColumnKind::Offset);
        let used: Vec<usize> = (0..=n_axes).collect();
        let terms = Terms { used: &used, kinds: &kinds, known: &[] };
        let found = fit(&sums, terms, Ridge::None).coefficients;
        let slopes: Vec<Vec<f64>> = (0..n_gauges)
            .map(|gauge| {
                (0..n_axes).map(|axis| found[axis * n_gauges + gauge] * scale(axis)).collect()
            })
            .collect();
        let zero = (0..n_gauges).map(|gauge| {
            let at_mean: f64 =
                slopes[gauge].iter().zip(&mean_load).map(|(slope, load)| slope * load).sum();
            mean[gauge] + found[n_axes * n_gauges + gauge] - at_mean
        });
        Some(Self {
            zero: zero.collect(),
            rest: sums.squared_residuals(&found).iter().map(|square| (square / n).sqrt()).collect(),
            moves: spans.iter().map(|span| *span > 0.0).collect(),
            slopes,
            mean,
            n_samples: n as u64,
        })
    }

    /// What the gauges show under a load.
    pub fn gauges(&self, load: &[f64]) -> Vec<f64> {
        let gauges = self.slopes.iter().zip(&self.zero);
        let answer = |(slopes, zero): (&Vec<f64>, &f64)| {
            zero + slopes.iter().zip(load).map(|(slope, load)| slope * load).sum::<f64>()
        };
        gauges.map(answer).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Axis, Source};

    fn recording(load: impl Fn(usize) -> [f64; 3]) -> Recording {
        let loads: Vec<[f64; 3]> = (0..300).map(load).collect();
        let gauges = loads.iter().flat_map(|[a, b, _]| [100.0 + 2.0 * a - b, 1e-3 * b, 7.0]);
        let recording = Recording::new(
            "r",
            Source::Simulated,
            (0..300).map(|k| k as f64).collect(),
            ["S1", "S2", "S3"].map(str::to_owned).to_vec(),
            gauges.collect(),
            vec![Axis::Fx, Axis::Fz, Axis::Mz],
            loads.as_flattened().to_vec(),
        );
        recording.unwrap()
    }

    #[test]
    fn slopes_and_zeros_are_those_that_made_the_gauges() {
        let made = recording(|k| [(0.1 * k as f64).sin(), 50.0 + (0.07 * k as f64).cos(), 4.0]);
        let own = Sensitivity::of(&[&made]).unwrap();
        let expected = [[2.0, -1.0, 0.0], [0.0, 1e-3, 0.0], [0.0; 3]];
        for (slopes, expected) in own.slopes.iter().zip(expected) {
            slopes
                .iter()
                .zip(expected)
                .for_each(|(own, expected)| assert!((own - expected).abs() < 1e-9));
        }
        let zeros = [100.0, 0.0, 7.0];
        own.zero
            .iter()
            .zip(zeros)
            .for_each(|(own, zero)| assert!((own - zero).abs() < 1e-6, "{own} for {zero}"));
        assert_eq!(own.moves, [true, true, false]);
        let shown = own.gauges(&[1.0, 2.0, 4.0]);
        assert!((shown[0] - 100.0).abs() < 1e-6 && (shown[1] - 2e-3).abs() < 1e-6);
    }

    #[test]
    fn loads_that_stand_still_leave_the_zero_at_the_mean() {
        let own = Sensitivity::of(&[&recording(|_| [0.0; 3])]).unwrap();
        assert_eq!((own.zero[0], own.moves[0]), (100.0, false));
        assert_eq!(Sensitivity::of(&[]), None);
    }
}
