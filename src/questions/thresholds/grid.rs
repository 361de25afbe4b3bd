//! Grid of the pairs of a force threshold F_th and a time threshold t_th that are tried for a look-back, and the order in
//! which they are tried.
//!
//! Guarantees: the thresholds of a [`ThresholdGrid`] are finite, not negative, and ascending. There is at least one F_th and
//! one t_th.

use crate::{
    questions::error::AnalysisError,
    scoring::numbers::{decimals, round_step},
};

/// Maximum number of values of one threshold. A plot could not distinguish more values.
pub const MAX_VALUES: usize = 2000;
/// Maximum number of pairs of thresholds. The errors of more pairs would fill the memory.
const MAX_PAIRS: usize = 250_000;
/// Approximate number of force thresholds F_th in the coarsest level of [`ThresholdGrid::coarse_to_fine`], which spans the
/// whole range.
const COARSEST: usize = 5;

/// All pairs of the listed force thresholds F_th and time thresholds t_th.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdGrid {
    /// Force thresholds F_th, ascending (N, or share of full scale).
    pub(crate) f_ths: Vec<f64>,
    /// Time thresholds t_th, ascending (s).
    pub(crate) t_ths_secs: Vec<f64>,
}

#[derive(Debug, thiserror::Error)]
pub enum GridError {
    #[error(
        "{what} has no values; enter start:stop:step, or ascending numbers separated by commas"
    )]
    Empty { what: &'static str },
    #[error("the step of {what} is {step}; enter a number above zero")]
    Step { what: &'static str, step: f64 },
    #[error("the range of {what} goes from {start} down to {stop}; enter the smaller value first")]
    Reversed { what: &'static str, start: f64, stop: f64 },
    #[error(
        "the values of {what} are not ascending: {next} comes after {before}; enter ascending values"
    )]
    Order { what: &'static str, before: f64, next: f64 },
    #[error("{value} is not a possible value of {what}; enter numbers from zero up")]
    Value { what: &'static str, value: f64 },
    #[error("{what} has {count} values, but at most {MAX_VALUES} can be tried; use a larger step")]
    TooMany { what: &'static str, count: f64 },
    #[error(
        "{f_ths} values of F_th and {t_ths} values of t_th make more pairs than the {MAX_PAIRS} that can be tried; use larger steps"
    )]
    TooManyPairs { f_ths: usize, t_ths: usize },
}

impl From<GridError> for AnalysisError {
    fn from(error: GridError) -> Self {
        Self::Because(error.to_string())
    }
}

/// Returns the values from `start` to `stop` in steps of `step`. `stop` is included if a step reaches it.
///
/// # Errors
/// [`GridError`] for a step that is not positive, a reversed range, or too many values.
pub fn even_values(
    what: &'static str,
    start: f64,
    stop: f64,
    step: f64,
) -> Result<Vec<f64>, GridError> {
    for value in [start, stop] {
        check_value(what, value)?;
    }
    if !(step > 0.0 && step.is_finite()) {
        return Err(GridError::Step { what, step });
    }
    if start > stop {
        return Err(GridError::Reversed { what, start, stop });
    }
    // Steps like 0.1 are not exact in binary numbers. Without the tolerance, rounding could lose the last value.
    let steps = ((stop - start) / step + 1e-9).floor();
    if steps >= MAX_VALUES as f64 {
        let count = steps + 1.0;
        return Err(GridError::TooMany { what, count });
    }
    let decimals = decimals_of(start).max(decimals_of(step));
    Ok((0..=steps as usize).map(|at| rounded(start + at as f64 * step, decimals)).collect())
}

fn rounded(value: f64, decimals: Option<usize>) -> f64 {
    let written = decimals.map(|decimals| format!("{value:.decimals$}"));
    written.and_then(|text| text.parse().ok()).unwrap_or(value)
}

/// Returns the number of decimal places of a value; `None` for more than nine.
fn decimals_of(value: f64) -> Option<usize> {
    Some(decimals(value)).filter(|decimals| *decimals <= 9)
}

fn check_value(what: &'static str, value: f64) -> Result<(), GridError> {
    if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(GridError::Value { what, value }) }
}

impl ThresholdGrid {
    /// Creates the grid of all pairs of these thresholds.
    ///
    /// **Units** F_th in N or as a share of full scale; t_th in s.
    ///
    /// # Errors
    /// [`GridError`] for the first invalid value.
    pub fn new(f_ths: Vec<f64>, t_ths_secs: Vec<f64>) -> Result<Self, GridError> {
        for (what, values) in [("F_th", &f_ths), ("t_th", &t_ths_secs)] {
            if values.is_empty() {
                return Err(GridError::Empty { what });
            }
            if values.len() > MAX_VALUES {
                let count = values.len() as f64;
                return Err(GridError::TooMany { what, count });
            }
            values.iter().try_for_each(|&value| check_value(what, value))?;
            if let Some(pair) = values.windows(2).find(|pair| pair[0] >= pair[1]) {
                let (before, next) = (pair[0], pair[1]);
                return Err(GridError::Order { what, before, next });
            }
        }
        if f_ths.len() * t_ths_secs.len() > MAX_PAIRS {
            return Err(GridError::TooManyPairs { f_ths: f_ths.len(), t_ths: t_ths_secs.len() });
        }
        Ok(Self { f_ths, t_ths_secs })
    }

    /// Creates a grid for a sensor. `largest_distance` is the largest full scale of its axes, in the unit of F_th. The `n_f`
    /// force thresholds F_th go from zero to at least 1.2 times this full scale, in equal, round steps. The `n_t` time
    /// thresholds t_th go from half a second to a minute, each in the same ratio to the one before.
    ///
    /// # Errors
    /// [`GridError`] if `n_f` or `n_t` is zero or too large.
    pub fn covering(largest_distance: f64, n_f: usize, n_t: usize) -> Result<Self, GridError> {
        let reach = if largest_distance > 0.0 && largest_distance.is_finite() {
            1.2 * largest_distance
        } else {
            1.0
        };
        let step = round_step(reach / n_f.saturating_sub(1).max(1) as f64);
        let decimals = decimals_of(step);
        let f_ths = (0..n_f).map(|at| rounded(at as f64 * step, decimals)).collect();
        let (shortest, longest) = (0.5_f64, 60.0_f64);
        let ratio = (longest / shortest).powf(1.0 / n_t.saturating_sub(1).max(1) as f64);
        let t_ths_secs =
            (0..n_t).map(|at| rounded(shortest * ratio.powi(at as i32), Some(3))).collect();
        Self::new(f_ths, t_ths_secs)
    }

    /// Returns the row numbers of the grid (one row for each F_th) in levels from coarse to fine. Each level halves the
    /// distances between the rows so far. A map of errors computed in this order shows the whole range of F_th from the first
    /// level on.
    pub fn coarse_to_fine(&self) -> Vec<Vec<usize>> {
        let n = self.f_ths.len();
        let mut stride = 1;
        while n.div_ceil(stride) > COARSEST {
            stride *= 2;
        }
        let mut levels = vec![(0..n).step_by(stride).collect::<Vec<_>>()];
        if !(n - 1).is_multiple_of(stride) {
            levels[0].push(n - 1);
        }
        while stride > 1 {
            let half = stride / 2;
            let between = (half..n).step_by(stride);
            levels.push(between.filter(|at| !levels[0].contains(at)).collect());
            stride = half;
        }
        levels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_values_are_written_as_people_write_them() {
        assert_eq!(
            even_values("F_th", 0.0, 0.6, 0.1).unwrap(),
            [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
        );
        assert_eq!(even_values("t_th", 1.0, 6.0, 2.0).unwrap(), [1.0, 3.0, 5.0]);
        assert_eq!(even_values("t_th", 3.0, 3.0, 1.0).unwrap(), [3.0]);
    }

    #[test]
    fn invalid_grids_are_refused_with_a_remedy() {
        let even = |start, stop, step| even_values("F_th", start, stop, step);
        assert!(matches!(even(0.0, 1.0, 0.0), Err(GridError::Step { .. })));
        assert!(matches!(even(0.0, 1.0, f64::NAN), Err(GridError::Step { .. })));
        assert!(matches!(even(2.0, 1.0, 0.1), Err(GridError::Reversed { .. })));
        assert!(matches!(even(0.0, 1.0, 1e-9), Err(GridError::TooMany { .. })));
        assert!(matches!(even(-1.0, 1.0, 0.1), Err(GridError::Value { .. })));
        let lists = |f: &[f64], t: &[f64]| ThresholdGrid::new(f.to_vec(), t.to_vec());
        assert!(matches!(lists(&[], &[1.0]), Err(GridError::Empty { what: "F_th" })));
        assert!(matches!(lists(&[1.0], &[]), Err(GridError::Empty { what: "t_th" })));
        assert!(matches!(lists(&[1.0], &[5.0, 3.0]), Err(GridError::Order { .. })));
        assert!(matches!(lists(&[1.0, 1.0], &[5.0]), Err(GridError::Order { .. })));
        assert!(matches!(lists(&[1.0], &[f64::INFINITY]), Err(GridError::Value { .. })));
    }

    #[test]
    fn a_grid_that_would_fill_the_memory_is_refused() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        let error = ThresholdGrid::new(values.clone(), values.clone()).unwrap_err();
        assert!(error.to_string().contains("1000 values of F_th"), "{error}");
        assert!(ThresholdGrid::new(values, vec![1.0, 2.0]).is_ok());
    }

    #[test]
    fn coarse_to_fine_visits_all_and_halves_the_gaps() {
        for n in [1, 2, 3, 5, 6, 40, 41, 97] {
            let f_ths = (0..n).map(f64::from).collect();
            let grid = ThresholdGrid::new(f_ths, vec![1.0]).unwrap();
            let mut seen = Vec::new();
            let mut widest = n as usize;
            for level in grid.coarse_to_fine() {
                seen.extend(level);
                seen.sort_unstable();
                assert!(seen.contains(&0) && seen.contains(&(n as usize - 1)));
                let gap = seen.windows(2).map(|pair| pair[1] - pair[0]).max();
                assert!(gap.unwrap_or(1) <= widest.div_ceil(2), "{n}: {seen:?}");
                widest = gap.unwrap_or(1);
            }
            assert_eq!(seen, (0..n as usize).collect::<Vec<_>>());
        }
    }

    /// 12 N plus a fifth, in 39 steps, is 0.369 N per step. The next round step is 0.5 N.
    #[test]
    fn a_grid_covers_the_sensor_in_round_steps() {
        let grid = ThresholdGrid::covering(12.0, 40, 40).unwrap();
        assert_eq!(grid.f_ths[..3], [0.0, 0.5, 1.0]);
        assert_eq!((grid.f_ths.len(), grid.t_ths_secs.len()), (40, 40));
        assert_eq!((grid.t_ths_secs[0], grid.t_ths_secs[39]), (0.5, 60.0));
        let small = ThresholdGrid::covering(3e-4, 21, 1).unwrap();
        assert_eq!(small.f_ths[1], 2e-5);
        assert!(ThresholdGrid::covering(f64::NAN, 3, 3).is_ok());
        assert!(ThresholdGrid::covering(1.0, 0, 3).is_err());
    }
}
