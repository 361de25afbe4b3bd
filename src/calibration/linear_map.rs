//! Calibration matrix, with the features that belong to its columns.

use serde::{Deserialize, Serialize};

use crate::{
    dot::dot,
    features::{Column, Design},
    recording::Recording,
    vectorised::vectorised,
};

/// Load as a linear function of features: `load = matrix · features`, with one row per axis and one column per feature.
///
/// **Source** the matrix is C⁻¹ of `S = C L` (Eq. 3 of the paper of Koike et al., 2019), written out in Eq. 6. The matrix is
/// fitted directly, so there may be as many gauges as axes (Eq. 4) or more (Eq. 5).
///
/// **Units** of the coefficients: N or N·m per unit of the gauge. Monomials have no unit, because they are products of
/// standardised gauges.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinearMap {
    #[serde(skip)]
    pub columns: Vec<Column>,
    /// Names of the matrix columns in a file; empty except in
    /// [`Calibration::in_file`](crate::calibration::Calibration::in_file).
    #[serde(rename = "features")]
    pub(super) names_in_file: Vec<String>,
    pub matrix: Vec<Vec<f64>>,
}

impl LinearMap {
    pub(crate) fn new(columns: Vec<Column>, matrix: Vec<Vec<f64>>) -> Self {
        Self { columns, matrix, names_in_file: Vec::new() }
    }

    pub fn names(&self, gauges: &[String]) -> Vec<String> {
        Column::names(&self.columns, gauges)
    }

    /// Computes the load of one sample (Eq. 7 of the paper of Koike et al., 2019). If `features` lacks the last column, the
    /// constant 1 of the offset column is added.
    #[inline]
    pub fn apply(&self, features: &[f64], load: &mut [f64]) {
        for (axis, load) in load.iter_mut().enumerate().take(self.matrix.len()) {
            *load = self.load(features, axis);
        }
    }

    /// Computes the load of each row of `n_features` numbers, as [`Self::apply`] does for one sample.
    pub fn apply_rows(&self, rows: &[f64], n_features: usize, loads: &mut [f64]) {
        vectorised(
            #[inline(always)]
            move || self.apply_lanes(rows, n_features, loads),
        );
    }

    #[inline(always)]
    fn apply_lanes(&self, rows: &[f64], width: usize, loads: &mut [f64]) {
        let n_axes = self.matrix.len();
        let mut columns = vec![[0.0; LANES]; width];
        let loads = loads.chunks_mut(LANES * n_axes);
        for (rows, loads) in rows.chunks(LANES * width).zip(loads) {
            if rows.len() < LANES * width {
                let each = rows.chunks_exact(width).zip(loads.chunks_exact_mut(n_axes));
                each.for_each(|(row, load)| self.apply(row, load));
                continue;
            }
            for (lane, row) in rows.chunks_exact(width).enumerate() {
                for (column, value) in columns.iter_mut().zip(row) {
                    column[lane] = *value;
                }
            }
            for (axis, row) in self.matrix.iter().enumerate() {
                let (slopes, offset) = row.split_at(width);
                let mut sums = [-0.0; LANES]; // as `Iterator::sum` starts
                for (slope, column) in slopes.iter().zip(&columns) {
                    for lane in 0..LANES {
                        sums[lane] += slope * column[lane];
                    }
                }
                let offset = offset.first().unwrap_or(&0.0);
                for (load, sum) in loads.chunks_exact_mut(n_axes).zip(sums) {
                    load[axis] = sum + offset;
                }
            }
        }
    }

    #[inline]
    pub fn load(&self, features: &[f64], axis: usize) -> f64 {
        let (slopes, offset) = self.matrix[axis].split_at(features.len());
        dot(slopes, features) + offset.first().unwrap_or(&0.0)
    }

    /// Returns the coefficients of this conventional calibration for the standardised columns of `design`, `n_columns ×
    /// n_axes` row-major.
    pub(crate) fn standardised(&self, design: &Design) -> Vec<f64> {
        let n_axes = self.matrix.len();
        let mut coefficients = vec![0.0; design.n_columns() * n_axes];
        for (axis, row) in self.matrix.iter().enumerate() {
            let standardised = design.standardised_coefficients(row);
            for (out, value) in coefficients.iter_mut().skip(axis).step_by(n_axes).zip(standardised)
            {
                *out = value;
            }
        }
        coefficients
    }

    /// Returns the matrix for the raw columns of `design`: this conventional matrix plus `coefficients`. The coefficients
    /// belong to standardised columns, `n_columns × n_axes` row-major.
    pub(crate) fn corrected(&self, design: &Design, coefficients: &[f64]) -> Vec<Vec<f64>> {
        let n_axes = self.matrix.len();
        let present = design.present();
        self.matrix
            .iter()
            .enumerate()
            .map(|(axis, base)| {
                let standardised: Vec<f64> =
                    coefficients.iter().skip(axis).step_by(n_axes).copied().collect();
                let mut row = design.raw_coefficients(&standardised);
                for (column, value) in present.iter().zip(base) {
                    row[*column] += value;
                }
                row
            })
            .collect()
    }
}

/// Number of feature rows whose loads are computed together.
const LANES: usize = 8;

/// Returns the conventional load of every sample, `n × n_axes` row-major.
pub(crate) fn loads_from_gauges(map: &LinearMap, recording: &Recording) -> Vec<f64> {
    let n_axes = map.matrix.len();
    let mut loads = vec![0.0; recording.n_samples() * n_axes];
    map.apply_rows(recording.gauges(), recording.n_gauges(), &mut loads);
    loads
}

/// Conventional loads of a recording, stored or computed on demand with identical results.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PresentLoads<'a> {
    pub map: &'a LinearMap,
    pub recording: &'a Recording,
    /// Stored loads, `n × n_axes` row-major; `None` if loads are computed on demand.
    pub kept: Option<&'a [f64]>,
}

impl PresentLoads<'_> {
    #[inline]
    pub fn at(&self, k: usize, axis: usize) -> f64 {
        match self.kept {
            Some(kept) => kept[k * self.map.matrix.len() + axis],
            None => self.map.load(self.recording.gauges_at(k), axis),
        }
    }

    #[inline]
    pub fn row(&self, k: usize, out: &mut [f64]) {
        match self.kept {
            Some(kept) => out.copy_from_slice(&kept[k * out.len()..][..out.len()]),
            None => self.map.apply(self.recording.gauges_at(k), out),
        }
    }

    pub fn column(&self, axis: usize) -> Vec<f64> {
        (0..self.recording.n_samples()).map(|k| self.at(k, axis)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn many_rows_and_single_rows_give_identical_bits() {
        let mut random = Random::new(3, &[1]);
        for (n_axes, width, is_offset) in [(6, 12, true), (1, 1, false), (3, 19, true)] {
            let row = |random: &mut Random| -> Vec<f64> {
                let n = width + usize::from(is_offset);
                (0..n).map(|_| random.normal()).collect()
            };
            let matrix = (0..n_axes).map(|_| row(&mut random)).collect();
            let map = LinearMap::new(Vec::new(), matrix);
            for n in [0, 1, 8, 21] {
                let rows: Vec<f64> = (0..n * width).map(|_| random.normal()).collect();
                let mut loads = vec![0.0; n * n_axes];
                map.apply_rows(&rows, width, &mut loads);
                let mut each = vec![0.0; n * n_axes];
                for (row, load) in rows.chunks_exact(width).zip(each.chunks_exact_mut(n_axes)) {
                    map.apply(row, load);
                }
                assert_eq!(loads, each, "{n} rows of {width}");
            }
        }
    }
}
