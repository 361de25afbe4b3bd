//! Computations that several kinds of results need: cross-validation, loops, intervals of constant load, lag, faults of the
//! rig, traces to draw.

pub mod budget;
pub(crate) mod coverage;
pub(crate) mod cross_validation;
pub(crate) mod faults;
pub(crate) mod holds;
pub(crate) mod information;
mod inverse;
pub mod lag;
pub(crate) mod left_out;
pub(crate) mod load_spread;
pub mod loops;
pub(crate) mod mean_hysteresis;
pub(crate) mod metrics;
pub mod numbers;
pub(crate) mod part_squares;
#[cfg(test)]
pub(crate) mod pixels;
pub(crate) mod quantile;
pub mod rig;
pub(crate) mod score_set;
pub(crate) mod series;
pub(crate) mod straight_lines;

pub(crate) use series::Series;

/// Maximum number of samples whose computed loads are kept in memory. With more samples, the loads are computed again at each
/// use.
pub const MANY_SAMPLES: usize = 2_000_000;

/// Share of the loads' variance within recordings, below which each recording holds one load.
const HELD: f64 = 0.1;

/// Returns true if each of several recordings holds nearly one load. A zero or a sensitivity of its own then explains whatever
/// a calibration does not follow. `loads` are those of each recording, `n_samples × n_axes` row-major.
pub(crate) fn hold_one_load<'a>(
    loads: impl Iterator<Item = &'a [f64]> + Clone,
    n_axes: usize,
) -> bool {
    let n: usize = loads.clone().map(<[f64]>::len).sum::<usize>() / n_axes.max(1);
    let n_recordings = loads.clone().filter(|own| !own.is_empty()).count();
    if n_recordings < 2 || n == n_recordings {
        return false;
    }
    let share = |axis: usize| {
        let of = |own: &'a [f64]| own[axis.min(own.len())..].iter().step_by(n_axes);
        let mean = |own: &'a [f64]| of(own).sum::<f64>() / of(own).count().max(1) as f64;
        let whole = loads.clone().flat_map(of).sum::<f64>() / n as f64;
        let (mut within, mut all) = (0.0, 0.0);
        for own in loads.clone() {
            let mean = mean(own);
            within += of(own).map(|load| (load - mean).powi(2)).sum::<f64>();
            all += of(own).map(|load| (load - whole).powi(2)).sum::<f64>();
        }
        (all > 0.0).then(|| within / all)
    };
    let shares: Vec<f64> = (0..n_axes).filter_map(share).collect();
    !shares.is_empty() && shares.iter().sum::<f64>() < HELD * shares.len() as f64
}
