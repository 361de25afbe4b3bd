//! The one pass: a recording and its past samples become sums.
//!
//! Columns are `[z, z_past − z, 1]` (without offset the last is missing), targets are what the conventional calibration
//! leaves over, `L − L_conv`. The residual instead of the load: small numbers keep their digits in `YᵀY − …`, and
//! solving for a correction refines the conventional solution on the way.

use std::ops::Range;

use crate::calibration::{LinearMap, NormalEquations};
use crate::features::GaugeScale;
use crate::recording::Recording;

/// The columns of a fit, in order: standardised gauges, their past relative to the present, offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Columns {
    /// Number of gauges.
    pub n_gauges: usize,
    /// Whether the past takes part.
    pub with_past: bool,
    /// Whether there is an offset column.
    pub offset: bool,
}

impl Columns {
    /// How many columns there are.
    #[must_use]
    pub fn count(self) -> usize {
        self.n_gauges * if self.with_past { 2 } else { 1 } + usize::from(self.offset)
    }

    /// Every column.
    #[must_use]
    pub fn all(self) -> Vec<usize> {
        (0..self.count()).collect()
    }

    /// The columns that do not need the past.
    #[must_use]
    pub fn present(self) -> Vec<usize> {
        let offset = self.offset.then(|| self.count() - 1);
        (0..self.n_gauges).chain(offset).collect()
    }

    /// The matrix on raw gauges that corrects `base` by `coefficients` (`count × n_axes`, row-major) found on these
    /// columns. With the past, its columns stand for the past gauges themselves, not their difference.
    #[must_use]
    pub fn raw_map(
        self,
        gauge_names: &[String],
        base: &LinearMap,
        scale: &GaugeScale,
        coefficients: &[f64],
    ) -> LinearMap {
        let n_axes = base.matrix.len();
        let g = self.n_gauges;
        let row = |axis: usize| {
            let found = |column: usize| coefficients[column * n_axes + axis];
            let base_row = &base.matrix[axis];
            let past: Vec<f64> = (0..if self.with_past { g } else { 0 })
                .map(|gauge| found(g + gauge) * scale.inverse_scale[gauge])
                .collect();
            let slope = |gauge: usize| found(gauge) * scale.inverse_scale[gauge];
            let present = (0..g)
                .map(|gauge| base_row[gauge] + slope(gauge) - past.get(gauge).unwrap_or(&0.0));
            let offset = self.offset.then(|| {
                let moved: f64 = (0..g).map(|gauge| slope(gauge) * scale.shift[gauge]).sum();
                base_row[g] + found(self.count() - 1) - moved
            });
            present.chain(past.iter().copied()).chain(offset).collect()
        };
        LinearMap {
            features: crate::calibration::Calibration::feature_names(
                gauge_names,
                self.with_past,
                self.offset,
            ),
            matrix: (0..n_axes).map(row).collect(),
        }
    }
}

/// A run of samples whose sums are kept apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The samples, within one recording.
    pub samples: Range<usize>,
    /// The part that cross-validation leaves out with them.
    pub fold: usize,
}

/// The sums of each piece of a recording, in the order of `pieces`.
///
/// **Shapes** `conventional` is `n × n_axes` row-major, `past` one index per sample; targets are `L − conventional`.
///
/// # Panics
/// If the recording has no reference, or a piece reaches beyond it.
#[must_use]
pub fn recording_sums(
    recording: &Recording,
    scale: &GaugeScale,
    columns: Columns,
    conventional: &[f64],
    past: &[u32],
    pieces: &[Piece],
) -> Vec<NormalEquations> {
    let n_axes = recording.axes().len();
    let mut rows = Vec::new();
    pieces
        .iter()
        .map(|piece| {
            let mut sums = NormalEquations::new(columns.count(), n_axes);
            let stride = sums.stride();
            rows.resize(BLOCK * stride, 0.0);
            for start in piece.samples.clone().step_by(BLOCK) {
                let samples = start..(start + BLOCK).min(piece.samples.end);
                let rows = &mut rows[..samples.len() * stride];
                for (k, row) in samples.zip(rows.chunks_exact_mut(stride)) {
                    let past = columns.with_past.then(|| past[k] as usize);
                    fill_features(recording, scale, columns, k, past, row);
                    let targets = &mut row[columns.count()..][..n_axes];
                    let loads = &recording.loads()[k * n_axes..][..n_axes];
                    let known = &conventional[k * n_axes..][..n_axes];
                    for ((target, load), known) in targets.iter_mut().zip(loads).zip(known) {
                        *target = load - known;
                    }
                }
                sums.add_rows(rows);
            }
            sums
        })
        .collect()
}

/// Rows that are filled before they are multiplied.
const BLOCK: usize = 128;

#[inline]
fn fill_features(
    recording: &Recording,
    scale: &GaugeScale,
    columns: Columns,
    k: usize,
    past: Option<usize>,
    row: &mut [f64],
) {
    let g = columns.n_gauges;
    let present = recording.gauges_at(k);
    let (z, rest) = row.split_at_mut(g);
    scale.apply(present, z);
    let rest = match past {
        Some(past) => {
            let earlier = recording.gauges_at(past);
            let (differences, rest) = rest.split_at_mut(g);
            for gauge in 0..g {
                differences[gauge] = (earlier[gauge] - present[gauge]) * scale.inverse_scale[gauge];
            }
            rest
        }
        None => rest,
    };
    if columns.offset {
        rest[0] = 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn present_columns_are_the_gauges_and_the_offset() {
        let columns = Columns {
            n_gauges: 2,
            with_past: true,
            offset: true,
        };
        assert_eq!(columns.count(), 5);
        assert_eq!(columns.present(), [0, 1, 4]);
        let bare = Columns {
            offset: false,
            ..columns
        };
        assert_eq!(bare.present(), [0, 1]);
    }

    /// One gauge, z = (s − 10)·2: B = (3 on z, 5 on z_past − z, 7) is 7 + 3z + 5(z_past − z), that is
    /// 7 − 2·2·(s − 10) + 5·2·(s_past − 10) = −4 s + 10 s_past − 53.
    #[test]
    fn the_raw_matrix_undoes_the_scaling() {
        let columns = Columns {
            n_gauges: 1,
            with_past: true,
            offset: true,
        };
        let scale = GaugeScale {
            shift: vec![10.0],
            inverse_scale: vec![2.0],
        };
        let base = LinearMap {
            features: vec!["S1".into(), "offset".into()],
            matrix: vec![vec![0.0, 0.0]],
        };
        let map = columns.raw_map(&["S1".into()], &base, &scale, &[3.0, 5.0, 7.0]);
        assert_eq!(map.features, ["S1", "S1_past", "offset"]);
        assert_eq!(map.matrix, [[-4.0, 10.0, -53.0]]);
    }
}
