//! Load cases: rows of a table without times that were taken under the same load.

use crate::recording::axis::Axis;

/// Two loads on an axis count as equal if they differ by at most this share of the largest force (for a moment axis: the
/// largest moment) in the table.
pub const SAME_LOAD_SHARE: f64 = 0.005;

/// Returns for each row the number of its load case, counted from 0. Rows with equal loads on every axis have the same
/// number.
///
/// **Shapes** `loads`: one row of `axes.len()` loads for each sample.
pub fn load_cases(loads: &[f64], axes: &[Axis]) -> Vec<usize> {
    let largest = largest_loads(loads, axes);
    let within = |axis: &Axis| SAME_LOAD_SHARE * largest[usize::from(axis.is_force())];
    let within: Vec<f64> = axes.iter().map(within).collect();
    let mut first: Vec<&[f64]> = Vec::new();
    let rows = loads.chunks_exact(axes.len().max(1));
    rows.map(|row| {
        let is_same = |known: &&[f64]| {
            let mut pairs = known.iter().zip(row).zip(&within);
            pairs.all(|((a, b), within)| (a - b).abs() <= *within)
        };
        first.iter().position(is_same).unwrap_or_else(|| {
            first.push(row);
            first.len() - 1
        })
    })
    .collect()
}

/// Returns the largest moment (N·m) and the largest force (N), in this order, among rows of loads. Both are magnitudes.
pub(super) fn largest_loads(loads: &[f64], axes: &[Axis]) -> [f64; 2] {
    [false, true].map(|is_force| {
        let all = loads.iter().zip(axes.iter().cycle());
        let of_kind = all.filter(|(_, axis)| axis.is_force() == is_force);
        of_kind.map(|(load, _)| load.abs()).fold(0.0, f64::max)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_within_half_a_percent_are_one_case() {
        let axes = [Axis::Fx, Axis::Fz, Axis::Mx];
        let loads = [
            [0.0, 20.0, 1.0],
            [20.0, 0.0, 0.0],
            [0.09, 19.95, 1.004], // repeats the first row
            [0.0, 20.0, 0.98],    // another moment
            [20.0, 0.05, 0.0],
        ];
        assert_eq!(load_cases(loads.as_flattened(), &axes), [0, 1, 0, 2, 1]);
        assert_eq!(load_cases(&[], &axes), [0; 0]);
        assert_eq!(load_cases(&[0.0; 3], &axes), [0]);
    }
}
