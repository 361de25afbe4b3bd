//! Training samples of a network in single precision, and their standardisation.
//!
//! Guarantees: every stored value is finite and needs four bytes. Values are stored relative to the first sample, so a large
//! offset costs no precision.

use crate::{
    calibration::error::{CalibrationError, Column},
    progress::{Cancelled, Progress},
};

/// Maximum difference of a value from that of the first sample. Larger differences could overflow single precision.
const FARTHEST: f64 = 1e30;
/// Minimum standard deviation of a varying column, as a share of its largest value. A smaller deviation is rounding noise, so
/// the column counts as constant.
const CONSTANT_BELOW: f64 = 1e-13;
/// Minimum standard deviation of a varying column. Single precision could not represent a smaller one.
const SMALLEST_SPREAD: f64 = 1e-30;
/// Number of rows processed between two checks for cancellation.
const ROWS_PER_CHECK: usize = 8192;

/// Training samples of a network with inputs and targets. Two million samples with 60 inputs and 6 targets need 0.5 GB.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    pub(super) inputs: Table,
    pub(super) targets: Table,
}

impl Samples {
    /// Creates an empty list of samples.
    pub fn new(n_inputs: usize, n_targets: usize) -> Self {
        Self { inputs: Table::new(n_inputs), targets: Table::new(n_targets) }
    }

    /// Reserves memory for `n_samples` more samples.
    pub fn reserve(&mut self, n_samples: usize) {
        for table in [&mut self.inputs, &mut self.targets] {
            table.values.reserve_exact(n_samples * table.width);
        }
    }

    /// Appends m samples, given as `m × n_inputs` inputs and `m × n_targets` targets. On an error, none is appended.
    ///
    /// # Errors
    /// [`CalibrationError::NotFinite`], [`CalibrationError::TooLarge`] and [`CalibrationError::NoColumns`].
    ///
    /// # Panics
    /// If a row is not complete, or inputs and targets have different numbers of rows.
    pub fn push_rows(&mut self, inputs: &[f64], targets: &[f64]) -> Result<(), CalibrationError> {
        let (n_inputs, n_targets) = (self.n_inputs(), self.n_targets());
        if n_inputs == 0 || n_targets == 0 {
            return Err(CalibrationError::NoColumns);
        }
        let m = inputs.len() / n_inputs;
        assert_eq!(inputs.len(), m * n_inputs, "each input row must have n_inputs numbers");
        assert_eq!(targets.len(), m * n_targets, "there must be one target row per input row");
        let n = self.n_samples();
        let pushed = self
            .inputs
            .push(inputs, Column::Input)
            .and_then(|()| self.targets.push(targets, Column::Target));
        if pushed.is_err() {
            self.inputs.values.truncate(n * n_inputs);
            self.targets.values.truncate(n * n_targets);
        }
        pushed
    }

    /// Returns the number of samples.
    pub fn n_samples(&self) -> usize {
        self.targets.n_rows()
    }

    /// Returns the number of inputs.
    pub fn n_inputs(&self) -> usize {
        self.inputs.width
    }

    /// Returns the number of targets.
    pub fn n_targets(&self) -> usize {
        self.targets.width
    }
}

/// Rows of numbers, stored as differences from the first row. Of n samples, none, not even the first, is more than √n
/// standard deviations from the mean. So the error of single precision is below `√n · 6e-8` standard deviations.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    width: usize,
    origin: Vec<f64>,
    values: Vec<f32>,
}

impl Table {
    fn new(width: usize) -> Self {
        Self { width, origin: Vec::new(), values: Vec::new() }
    }

    fn n_rows(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    fn push(&mut self, rows: &[f64], column: fn(usize) -> Column) -> Result<(), CalibrationError> {
        if self.values.is_empty() {
            self.origin = rows.iter().copied().take(self.width).collect();
        }
        for row in rows.chunks_exact(self.width) {
            for (at, (&value, origin)) in row.iter().zip(&self.origin).enumerate() {
                let difference = value - origin;
                if difference.abs() <= FARTHEST {
                    self.values.push(difference as f32);
                    continue;
                }
                let (column, sample) = (column(at), self.n_rows());
                return Err(if value.is_finite() {
                    CalibrationError::TooLarge { column, sample, value }
                } else {
                    CalibrationError::NotFinite { column, sample, value }
                });
            }
        }
        Ok(())
    }

    /// Returns mean and standard deviation of each column.
    pub fn measure(&self, progress: &Progress) -> Result<Scale, Cancelled> {
        let n = self.n_rows().max(1) as f64;
        let mut mean = vec![0.0; self.width];
        self.for_each_row(progress, |row| {
            for (sum, &value) in mean.iter_mut().zip(row) {
                *sum += f64::from(value);
            }
        })?;
        for sum in &mut mean {
            *sum /= n;
        }
        let mut squares = vec![0.0; self.width];
        let mut largest = vec![0.0_f32; self.width];
        self.for_each_row(progress, |row| {
            let columns = squares.iter_mut().zip(&mut largest).zip(&mean);
            for (((square, largest), mean), &value) in columns.zip(row) {
                *square += (f64::from(value) - mean).powi(2);
                *largest = largest.max(value.abs());
            }
        })?;
        let spread = |column: usize| {
            let spread = (squares[column] / n).sqrt();
            let largest = self.origin[column].abs() + f64::from(largest[column]);
            let constant = spread <= (CONSTANT_BELOW * largest).max(SMALLEST_SPREAD);
            if constant { 0.0 } else { spread }
        };
        Ok(Scale {
            shift: (mean.iter().zip(&self.origin)).map(|(mean, origin)| mean + origin).collect(),
            spread: (0..self.width).map(spread).collect(),
        })
    }

    fn for_each_row(
        &self,
        progress: &Progress,
        mut visit: impl FnMut(&[f32]),
    ) -> Result<(), Cancelled> {
        for block in self.values.chunks(ROWS_PER_CHECK * self.width) {
            progress.check()?;
            block.chunks_exact(self.width).for_each(&mut visit);
        }
        Ok(())
    }

    pub fn standardised(&self, scale: &Scale) -> Standardised<'_> {
        let inverse = scale.inverse_spread();
        Standardised {
            table: self,
            offset: (self.origin.iter().zip(&scale.shift).zip(&inverse))
                .map(|((origin, shift), inverse)| ((origin - shift) * inverse) as f32)
                .collect(),
            factor: inverse.iter().map(|&inverse| inverse as f32).collect(),
        }
    }
}

/// Mean and standard deviation of each column.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scale {
    pub shift: Vec<f64>,
    /// Standard deviation; zero for a constant column.
    pub spread: Vec<f64>,
}

impl Scale {
    /// Returns the inverse standard deviation of each column; zero for a constant column.
    pub fn inverse_spread(&self) -> Vec<f64> {
        let inverse = |&spread: &f64| if spread > 0.0 { 1.0 / spread } else { 0.0 };
        self.spread.iter().map(inverse).collect()
    }
}

/// Table whose rows are standardised when they are read.
#[derive(Clone, Debug)]
pub(super) struct Standardised<'a> {
    table: &'a Table,
    factor: Vec<f32>,
    offset: Vec<f32>,
}

impl Standardised<'_> {
    pub fn n_rows(&self) -> usize {
        self.table.n_rows()
    }

    /// Reads the first and the last number of each row before they are used, so that the waits for memory overlap.
    #[inline]
    pub fn prefetch(&self, rows: impl Iterator<Item = usize>) {
        let width = self.table.width;
        let ends =
            |k: usize| self.table.values[k * width] + self.table.values[k * width + width - 1];
        std::hint::black_box(rows.map(ends).sum::<f32>());
    }

    /// Writes the standardised numbers of row `k` into `out`. A constant column gives zero.
    #[inline]
    pub fn write_row(&self, k: usize, out: &mut [f32]) {
        let row = &self.table.values[k * self.table.width..][..self.table.width];
        let columns = row.iter().zip(&self.factor).zip(&self.offset);
        for (out, ((value, factor), offset)) in out.iter_mut().zip(columns) {
            *out = value * factor + offset;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(samples: &Samples) -> (Scale, Vec<Vec<f32>>) {
        let scale = samples.inputs.measure(&Progress::default()).unwrap();
        let standardised = samples.inputs.standardised(&scale);
        let rows = (0..samples.n_samples())
            .map(|k| {
                let mut row = vec![0.0; samples.n_inputs()];
                standardised.write_row(k, &mut row);
                row
            })
            .collect();
        (scale, rows)
    }

    /// 1 and 3 have the mean 2 and the deviation 1. An offset of 1e9, too large for single precision, changes nothing.
    #[test]
    fn a_large_offset_costs_no_digits() {
        for offset in [0.0, 1e9] {
            let mut samples = Samples::new(1, 1);
            samples.push_rows(&[offset + 1.0, offset + 3.0], &[0.0, 0.0]).unwrap();
            let (scale, rows) = measured(&samples);
            assert_eq!((scale.shift[0], scale.spread[0]), (offset + 2.0, 1.0));
            assert_eq!(rows, [[-1.0], [1.0]]);
        }
    }

    #[test]
    fn a_constant_column_gives_zero_and_keeps_its_value() {
        let mut samples = Samples::new(2, 1);
        samples.push_rows(&[0.1, 1e-40, 0.1, 2e-40, 0.1, 0.0], &[0.0; 3]).unwrap();
        let (scale, rows) = measured(&samples);
        assert_eq!((scale.shift[0], scale.spread[0]), (0.1, 0.0));
        assert_eq!(scale.inverse_spread(), [0.0, 0.0]);
        assert!(rows.iter().flatten().all(|z| *z == 0.0));
    }

    #[test]
    fn rows_with_non_finite_numbers_are_named_and_not_stored() {
        let mut samples = Samples::new(2, 1);
        samples.push_rows(&[1.0, 2.0], &[3.0]).unwrap();
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = samples.push_rows(&[1.0, 2.0, 1.0, wrong], &[0.0; 2]);
            let Err(CalibrationError::NotFinite { column, sample, .. }) = error else {
                panic!("{error:?}");
            };
            assert_eq!((column, sample), (Column::Input(1), 2));
            let error = samples.push_rows(&[1.0, 2.0], &[wrong]).unwrap_err();
            assert!(error.to_string().starts_with("target column 1 is"));
        }
        let error = samples.push_rows(&[1.0, 1e200], &[0.0]);
        assert!(matches!(error, Err(CalibrationError::TooLarge { .. })));
        assert_eq!(samples.n_samples(), 1);
        assert_eq!(samples.inputs.values.len(), 2);
    }

    #[test]
    fn a_non_finite_first_sample_is_refused_and_leaves_no_origin() {
        let mut samples = Samples::new(1, 1);
        assert!(samples.push_rows(&[f64::NAN], &[0.0]).is_err());
        samples.push_rows(&[5.0], &[0.0]).unwrap();
        assert_eq!(measured(&samples).0.shift, [5.0]);
    }

    #[test]
    fn measuring_can_be_cancelled() {
        let mut samples = Samples::new(1, 1);
        samples.push_rows(&[1.0], &[1.0]).unwrap();
        let progress = Progress::default();
        progress.cancel();
        assert_eq!(samples.inputs.measure(&progress), Err(Cancelled));
        assert_eq!(Samples::new(0, 1).push_rows(&[], &[]), Err(CalibrationError::NoColumns));
    }
}
