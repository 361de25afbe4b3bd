//! Least squares of values in rows that belong to groups, and the best step in the order of the rows.

use crate::dot::dot;

/// Share of a column's length that must be independent of the known columns.
const INDEPENDENT: f64 = 1e-3;

/// Mean values over successive samples at one load.
pub struct Row {
    /// Rows that are compared have the same group.
    pub group: usize,
    n: f64,
    /// Mean time, and times or numbers of the first and the last sample.
    pub time: f64,
    pub first: usize,
    pub last: usize,
    pub values: Vec<f64>,
}

impl Row {
    pub fn new(group: usize, n_values: usize) -> Self {
        Self { group, n: 0.0, time: 0.0, first: 0, last: 0, values: vec![0.0; n_values] }
    }

    /// Adds a sample to the means. In a table, the time is the number of the row.
    pub fn add(&mut self, time: f64, values: impl Iterator<Item = f64>) {
        self.n += 1.0;
        self.time += (time - self.time) / self.n;
        self.last = time as usize;
        self.first = if self.n > 1.0 { self.first } else { self.last };
        let means = self.values.iter_mut().zip(values);
        means.for_each(|(mean, value)| *mean += (value - *mean) / self.n);
    }
}

/// Values of rows in order, after subtraction of the mean of each group of rows and of all that known columns explain.
#[derive(Clone)]
pub struct Steps {
    groups: Vec<usize>,
    sizes: Vec<f64>,
    /// Orthogonal columns of length one.
    known: Vec<Vec<f64>>,
    /// What is left of each column of values.
    left: Vec<Vec<f64>>,
}

impl Steps {
    /// Creates the rows from the group of each row, counted from 0, and the columns of values.
    pub fn new(groups: Vec<usize>, values: &[Vec<f64>]) -> Self {
        let mut sizes = vec![0.0; groups.iter().max().map_or(0, |last| last + 1)];
        groups.iter().for_each(|group| sizes[*group] += 1.0);
        let mut steps = Self { groups, sizes, known: Vec::new(), left: Vec::new() };
        steps.left = values.iter().map(|column| steps.centred(column)).collect();
        steps
    }

    fn centred(&self, column: &[f64]) -> Vec<f64> {
        let mut means = vec![0.0; self.sizes.len()];
        self.groups.iter().zip(column).for_each(|(group, value)| means[*group] += value);
        means.iter_mut().zip(&self.sizes).for_each(|(mean, size)| *mean /= size.max(1.0));
        self.groups.iter().zip(column).map(|(group, value)| value - means[*group]).collect()
    }

    /// Returns the part of a column that is independent of groups and known columns, at length one. `None` if nothing is left.
    pub fn independent(&self, column: &[f64]) -> Option<Vec<f64>> {
        let mut part = self.centred(column);
        // Compared with the whole column, because a column that is constant in each group leaves rounding errors.
        let length = column.iter().map(|value| (value - column[0]).powi(2)).sum::<f64>().sqrt();
        // The second round removes rounding errors.
        for known in self.known.iter().chain(&self.known) {
            let factor = dot(known, &part);
            part.iter_mut().zip(known).for_each(|(value, known)| *value -= factor * known);
        }
        let rest = dot(&part, &part).sqrt();
        part.iter_mut().for_each(|value| *value /= rest);
        (rest > INDEPENDENT * length).then_some(part)
    }

    /// Subtracts from the values what a column explains. Returns false if it is not independent.
    pub fn explain(&mut self, column: &[f64]) -> bool {
        let Some(part) = self.independent(column) else { return false };
        for left in &mut self.left {
            let factor = dot(&part, left);
            left.iter_mut().zip(&part).for_each(|(value, part)| *value -= factor * part);
        }
        self.known.push(part);
        true
    }

    /// Returns the number of rows minus the number of groups and known columns.
    pub fn freedom(&self) -> usize {
        let n_groups = self.sizes.iter().filter(|size| **size > 0.0).count();
        self.groups.len().saturating_sub(n_groups + self.known.len())
    }

    pub fn n_rows(&self) -> usize {
        self.groups.len()
    }

    /// Returns the sum of squares that is left of each column of values.
    pub fn squares(&self) -> Vec<f64> {
        self.left.iter().map(|left| dot(left, left)).collect()
    }

    /// Returns by how much a column reduces the squares of each column of values, if at least this share of its length is
    /// independent.
    pub fn gains(&self, column: &[f64], least: f64) -> Option<Vec<f64>> {
        let part = self.independent(column)?;
        let centred = self.centred(column);
        let is_free = dot(&part, column) > least * dot(&centred, &centred).sqrt();
        is_free.then(|| self.left.iter().map(|left| dot(&part, left).powi(2)).collect())
    }

    /// Returns by how much a column reduces the squares of the first column of values.
    pub fn gain(&self, column: &[f64]) -> f64 {
        self.gains(column, 0.0).map_or(0.0, |gains| gains[0])
    }

    /// Returns the size of a column in the first of these values, if it is independent.
    pub fn size(&self, column: &[f64]) -> Option<f64> {
        let part = self.independent(column)?;
        Some(dot(&part, &self.left[0]) / dot(&part, column))
    }

    /// Calls `visit` for each step, from the last row on, with its first row and the reduction of each column's squares. Steps
    /// with less than `least` independent squares are omitted.
    pub fn steps(&self, least: f64, mut visit: impl FnMut(usize, &[f64])) {
        let mut along = vec![0.0; self.known.len()];
        let mut sums = vec![0.0; self.left.len()];
        let mut counts = vec![0.0; self.sizes.len()];
        let mut squares = 0.0;
        let mut gains = sums.clone();
        for row in (1..self.groups.len()).rev() {
            let group = self.groups[row];
            squares += 1.0 - (2.0 * counts[group] + 1.0) / self.sizes[group];
            counts[group] += 1.0;
            along.iter_mut().zip(&self.known).for_each(|(sum, known)| *sum += known[row]);
            sums.iter_mut().zip(&self.left).for_each(|(sum, left)| *sum += left[row]);
            let independent = squares - dot(&along, &along);
            if independent >= least {
                let all = gains.iter_mut().zip(&sums);
                all.for_each(|(gain, sum)| *gain = sum * sum / independent);
                visit(row, &gains);
            }
        }
    }
}

/// Returns the column of a step at a row.
pub fn step_at(row: usize, n: usize) -> Vec<f64> {
    (0..n).map(|k| if k >= row { 1.0 } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_found_between_rows_of_groups() {
        let groups = [0, 1, 0, 1, 0, 1, 0, 1];
        let of_group: Vec<f64> = groups.iter().map(|group| 0.3 + 0.1 * *group as f64).collect();
        let step = step_at(5, groups.len());
        let values = of_group.iter().zip(&step).map(|(group, step)| 100.0 * group + 2.0 * step);
        let mut steps = Steps::new(groups.to_vec(), &[values.collect()]);
        assert!(!steps.explain(&of_group), "it is constant in each group");
        assert_eq!(steps.freedom(), 6);
        let mut best = (0, 0.0);
        steps.steps(0.5, |row, gains| {
            if gains[0] > best.1 {
                best = (row, gains[0]);
            }
        });
        assert_eq!(best.0, 5);
        assert!((steps.size(&step).unwrap() - 2.0).abs() < 1e-9);
        assert!((steps.gain(&step) - steps.squares()[0]).abs() < 1e-9);
        assert!(steps.explain(&step) && steps.squares()[0] < 1e-12);
    }
}
