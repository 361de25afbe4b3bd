//! Map of errors over both thresholds of a look-back: one row for each force threshold F_th, one column for each time
//! threshold t_th.
//!
//! Guarantees: rows may arrive in any order. A missing row is `None`, and every function accepts missing rows.

use crate::{
    calibration::CrossValidation,
    features::{Distance, Thresholds},
    min_max::MinMax,
    questions::thresholds::{
        grid::ThresholdGrid,
        measure::{Measure, MeasureScale},
        scorer::PointScores,
    },
    scoring::score_set::ScoreSet,
};

/// Threshold that varies along a curve of errors, while the other one is fixed.
#[derive(Clone, Copy, Debug)]
pub enum Along {
    F,
    T,
}

impl Along {
    pub fn of(self, pair: Thresholds) -> f64 {
        match self {
            Self::F => pair.f_th,
            Self::T => pair.t_th_secs,
        }
    }

    /// Returns the pair with another threshold.
    pub fn with(self, pair: Thresholds, value: f64) -> Thresholds {
        match self {
            Self::F => Thresholds { f_th: value, ..pair },
            Self::T => Thresholds { t_th_secs: value, ..pair },
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdMap {
    pub grid: ThresholdGrid,
    pub distance: Distance,
    pub scale: MeasureScale,
    /// Number of training samples.
    pub n_train: u64,
    pub n_test: u64,
    /// Number of samples of each part of the training recordings that cross-validation leaves out.
    pub part_samples: Vec<u64>,
    pub cross_validation: CrossValidation,
    pub conventional: PointScores,
    pub rows: Vec<Option<Vec<PointScores>>>,
}

impl ThresholdMap {
    pub fn new(
        grid: ThresholdGrid,
        distance: Distance,
        scale: MeasureScale,
        conventional: PointScores,
        part_samples: Vec<u64>,
    ) -> Self {
        Self {
            rows: vec![None; grid.f_ths.len()],
            n_train: part_samples.iter().sum(),
            n_test: 0,
            cross_validation: CrossValidation::default(),
            grid,
            distance,
            scale,
            part_samples,
            conventional,
        }
    }

    /// Stores the scores of one row: those of the F_th with index `f_at`, one for each t_th.
    ///
    /// # Panics
    /// If the grid has no such row, or if `points` does not have one entry for each t_th.
    pub fn set_row(&mut self, f_at: usize, points: Vec<PointScores>) {
        assert_eq!(points.len(), self.grid.t_ths_secs.len(), "one per t_th");
        self.rows[f_at] = Some(points);
    }

    pub fn is_complete(&self) -> bool {
        self.rows.iter().all(Option::is_some)
    }

    pub fn n_rows_done(&self) -> usize {
        self.rows.iter().flatten().count()
    }

    /// Returns the scores at row `f_at` and column `t_at` of the grid; `None` for a missing row.
    pub fn point(&self, f_at: usize, t_at: usize) -> Option<&PointScores> {
        self.rows.get(f_at)?.as_ref()?.get(t_at)
    }

    /// Returns the thresholds and the scores of all points that are computed, with t_th running faster.
    pub fn points(&self) -> impl Iterator<Item = (Thresholds, &PointScores)> {
        let n_t = self.grid.t_ths_secs.len();
        let all = (0..self.rows.len() * n_t).map(move |at| (at / n_t, at % n_t));
        all.filter_map(|(f_at, t_at)| Some((self.thresholds(f_at, t_at), self.point(f_at, t_at)?)))
    }

    /// Returns the thresholds at row `f_at` and column `t_at` of the grid. Panics if there is no such row or column.
    pub fn thresholds(&self, f_at: usize, t_at: usize) -> Thresholds {
        Thresholds { f_th: self.grid.f_ths[f_at], t_th_secs: self.grid.t_ths_secs[t_at] }
    }

    /// Returns the row and the column of the pair that is nearest to these thresholds.
    pub fn nearest(&self, thresholds: Thresholds) -> (usize, usize) {
        let nearest = |values: &[f64], wanted: f64| {
            let distance = |at: &usize| (values[*at] - wanted).abs();
            let all = 0..values.len();
            all.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
        };
        (
            nearest(&self.grid.f_ths, thresholds.f_th),
            nearest(&self.grid.t_ths_secs, thresholds.t_th_secs),
        )
    }

    pub fn value(&self, set: ScoreSet, measure: Measure, f_at: usize, t_at: usize) -> Option<f64> {
        let scores = &self.point(f_at, t_at)?.scores;
        measure.of_rmse(&self.scale, set.rmse(scores)?)
    }

    pub fn conventional_value(&self, set: ScoreSet, measure: Measure) -> Option<f64> {
        measure.of_rmse(&self.scale, set.rmse(&self.conventional.scores)?)
    }

    /// Returns the errors of all pairs of thresholds, `n_f_th × n_t_th` row-major.
    pub fn values(&self, set: ScoreSet, measure: Measure) -> Vec<Option<f64>> {
        let n_t = self.grid.t_ths_secs.len();
        (0..self.rows.len() * n_t).map(|at| self.value(set, measure, at / n_t, at % n_t)).collect()
    }

    /// Returns the smallest and the largest error of the colour scale; `None` without any error. The few largest errors lie
    /// above the scale, because a look-back that finds hardly any earlier sample can have a far larger error.
    pub fn shades(&self, set: ScoreSet, measure: Measure) -> Option<(f64, f64)> {
        let known = self.values(set, measure);
        let (least, greatest) = known.iter().flatten().collect::<MinMax>().ends()?;
        let without = self.conventional_value(set, measure).unwrap_or(greatest);
        Some((least, if without > least { without } else { greatest }))
    }

    /// Returns the points `(threshold, error)` of the curve along one threshold through this pair, ascending. Pairs without
    /// an error are left out.
    pub fn curve(
        &self,
        along: Along,
        set: ScoreSet,
        measure: Measure,
        (f_at, t_at): (usize, usize),
    ) -> Vec<(f64, f64)> {
        let thresholds = match along {
            Along::F => &self.grid.f_ths,
            Along::T => &self.grid.t_ths_secs,
        };
        let value = |at: usize| match along {
            Along::F => self.value(set, measure, at, t_at),
            Along::T => self.value(set, measure, f_at, at),
        };
        let thresholds = thresholds.iter().enumerate();
        thresholds.filter_map(|(at, threshold)| Some((*threshold, value(at)?))).collect()
    }

    /// Returns the row, the column and the value of the lowest error. Of several equal errors, the one with the smallest
    /// thresholds is returned.
    pub fn minimum(&self, set: ScoreSet, measure: Measure) -> Option<((usize, usize), f64)> {
        let n_t = self.grid.t_ths_secs.len();
        let values = self.values(set, measure).into_iter().enumerate();
        let known = values.filter_map(|(at, value)| Some(((at / n_t, at % n_t), value?)));
        known.min_by(|(_, a), (_, b)| a.total_cmp(b))
    }
}
