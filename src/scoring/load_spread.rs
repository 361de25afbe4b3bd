//! Spread of the loads on each axis, and correlation of the axes.

use crate::min_max::MinMax;

#[derive(Debug)]
pub struct LoadSpread {
    pub deviations: Vec<f64>,
    /// Correlation coefficient of the loads on each pair of axes, `n_axes × n_axes`; `None` if the load of an axis is
    /// constant.
    pub correlations: Vec<Option<f64>>,
    /// Variance of the load on each axis, divided by the part of it that the loads on the other axes do not explain. It is 1
    /// for an independent axis.
    pub inflations: Vec<Option<f64>>,
}

impl LoadSpread {
    pub fn of<'a>(loads: impl Iterator<Item = &'a [f64]> + Clone, ranges: &[MinMax]) -> Self {
        let n_axes = ranges.len();
        let n = loads.clone().count().max(1) as f64;
        let mut mean = vec![0.0; n_axes];
        for load in loads.clone() {
            mean.iter_mut().zip(load).for_each(|(sum, load)| *sum += load / n);
        }
        let mut products = vec![0.0; n_axes * n_axes];
        for load in loads {
            for i in 0..n_axes {
                for j in 0..=i {
                    products[i * n_axes + j] += (load[i] - mean[i]) * (load[j] - mean[j]) / n;
                }
            }
        }
        let moves = |axis: usize| ranges[axis].span() > 0.0;
        let deviations: Vec<f64> = (0..n_axes)
            .map(|axis| if moves(axis) { products[axis * n_axes + axis].sqrt() } else { 0.0 })
            .collect();
        let correlation = |i: usize, j: usize| {
            let both = deviations[i] * deviations[j];
            let product = products[i.max(j) * n_axes + i.min(j)];
            (both > 0.0).then(|| if i == j { 1.0 } else { (product / both).clamp(-1.0, 1.0) })
        };
        let correlations: Vec<Option<f64>> =
            (0..n_axes * n_axes).map(|at| correlation(at / n_axes, at % n_axes)).collect();
        let moving: Vec<usize> = (0..n_axes).filter(|axis| deviations[*axis] > 0.0).collect();
        let n_moving = moving.len();
        let among = faer::Mat::from_fn(n_moving, n_moving, |i, j| {
            correlations[moving[i] * n_axes + moving[j]].unwrap_or(0.0)
        });
        let mut inflations = vec![None; n_axes];
        let parts = (n_moving > 0).then(|| among.self_adjoint_eigen(faer::Side::Lower));
        if let Some(Ok(parts)) = parts {
            let (squares, directions) = (parts.S().column_vector(), parts.U());
            for (at, axis) in moving.iter().enumerate() {
                let parts =
                    (0..n_moving).map(|k| directions[(at, k)].powi(2) / squares[k].max(1e-12));
                inflations[*axis] = Some(parts.sum());
            }
        }
        Self { deviations, correlations, inflations }
    }
}

/// Share of the loads' variance within recordings, below which each recording holds one load.
const HELD: f64 = 0.1;

/// Returns true if each of several recordings holds nearly one load. A zero or a sensitivity of its own then explains whatever
/// a calibration does not follow. `loads` are those of each recording, `n_samples × n_axes` row-major.
pub fn hold_one_load<'a>(loads: impl Iterator<Item = &'a [f64]>, n_axes: usize) -> bool {
    let loads: Vec<&[f64]> = loads.filter(|own| !own.is_empty()).collect();
    let n = loads.iter().map(|own| own.len()).sum::<usize>() / n_axes.max(1);
    if loads.len() < 2 || n == loads.len() {
        return false;
    }
    let share = |axis: usize| {
        let of = |own: &'a [f64]| own[axis..].iter().step_by(n_axes);
        let whole = loads.iter().flat_map(|own| of(own)).sum::<f64>() / n as f64;
        let (mut within, mut all) = (0.0, 0.0);
        for own in &loads {
            let mean = of(own).sum::<f64>() / of(own).count() as f64;
            within += of(own).map(|load| (load - mean).powi(2)).sum::<f64>();
            all += of(own).map(|load| (load - whole).powi(2)).sum::<f64>();
        }
        (all > 0.0).then(|| within / all)
    };
    let shares: Vec<f64> = (0..n_axes).filter_map(share).collect();
    !shares.is_empty() && shares.iter().sum::<f64>() < HELD * shares.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference values from NumPy 2: `std`, `corrcoef`, the diagonal of the inverse of the correlations.
    #[test]
    fn spread_is_that_of_numpy() {
        let load = |k: usize| {
            let k = k as f64;
            let (a, b, c) = ((0.1 * k).sin(), (0.23 * k).cos(), (0.71 * k).sin());
            [a, b + 0.5 * a, a - 0.8 * b + 0.1 * c]
        };
        let loads: Vec<[f64; 3]> = (0..200).map(load).collect();
        let range = |axis: usize| loads.iter().map(|load| load[axis]).collect::<MinMax>();
        let ranges = [0, 1, 2].map(range);
        let spread = LoadSpread::of(loads.iter().map(|load| &load[..]), &ranges);
        let close = |actual: f64, expected: f64| {
            assert!((actual / expected - 1.0).abs() < 1e-6, "{actual} for {expected}")
        };
        close(spread.deviations[2], 0.89315314);
        close(spread.correlations[1].unwrap(), 0.45625773);
        close(spread.correlations[5].unwrap(), -0.20904261);
        close(spread.inflations[0].unwrap(), 193.67488842);
        close(spread.inflations[1].unwrap(), 81.83309821);
    }
}
