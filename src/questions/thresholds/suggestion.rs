//! Suggests the thresholds of a look-back with the lowest cross-validation error, and the range of equally good thresholds.

use serde::Serialize;

use crate::{
    calibration::{CrossValidation, ErrorBlocks, NoCrossValidation, weighed},
    features::{Distance, Thresholds},
    questions::{
        error::AnalysisError,
        thresholds::{map::ThresholdMap, measure::Measure, saved::ShownFTh, scorer::PointScores},
    },
    scoring::{metrics::percent_change, numbers::significant, score_set::ScoreSet},
};

/// Range of one threshold in which the cross-validation error is as low as the minimum: it is nowhere above the minimum with
/// 90 % confidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FlatRange {
    pub from: f64,
    pub to: f64,
    /// True if `from`, the lower end of the range, is the smallest tried value. Smaller values may then be as good.
    pub from_is_first_tried: bool,
    /// True if `to`, the upper end of the range, is the largest tried value. Larger values may then be as good.
    pub to_is_last_tried: bool,
}

impl FlatRange {
    pub fn in_words(&self, text: impl Fn(f64) -> String) -> String {
        let first = if self.from_is_first_tried { " (the first tried)" } else { "" };
        let last = if self.to_is_last_tried { " (the last tried)" } else { "" };
        if self.from == self.to {
            return text(self.from) + first + last;
        }
        format!("{}{first} to {}{last}", text(self.from), text(self.to))
    }
}

/// Pair of thresholds with the lowest cross-validation error in the map. Test recordings are not used.
///
/// A pair is as good as the minimum if its error is not above the minimum with 90 % confidence (see
/// [`ErrorBlocks::is_below`]). A range is the run of equally good values around the minimum, with the other threshold fixed.
/// Within the ranges, the choice hardly matters.
///
/// The error at the minimum is lower than the error on new samples, because the pair is chosen among many.
#[derive(Debug, PartialEq, Serialize)]
pub struct Suggestion {
    pub thresholds: Thresholds,
    /// Row and column of the minimum in the map.
    pub at: (usize, usize),
    /// Cross-validation error at the minimum.
    pub left_out: f64,
    pub conventional: f64,
    /// True if the error of the conventional calibration is above the minimum with 90 % confidence.
    pub beats_conventional: bool,
    /// Range of F_th that is as good as the suggested F_th, with t_th as suggested.
    pub f_th_range: FlatRange,
    /// Range of t_th that is as good as the suggested t_th, with F_th as suggested (s).
    pub t_th_range: FlatRange,
    pub n_parts: usize,
    /// True if cross-validation leaves out contiguous blocks of samples, because there are fewer than three training
    /// recordings.
    pub parts_are_blocks: bool,
    pub cross_validation: CrossValidation,
}

impl ThresholdMap {
    /// Returns the suggested thresholds for this measure of error, or an error if the map has no cross-validation
    /// errors of it.
    pub fn suggestion(&self, measure: Measure) -> Result<Suggestion, AnalysisError> {
        let weights = measure.weights(&self.scale).ok_or(AnalysisError::NoSuchAxis)?;
        let conventional = self
            .conventional_value(ScoreSet::LeftOut, measure)
            .ok_or(NoCrossValidation::FewSamples)?;
        let (at, left_out) =
            self.minimum(ScoreSet::LeftOut, measure).ok_or(AnalysisError::EmptyMap)?;
        let best = self.point(at.0, at.1).ok_or(AnalysisError::EmptyMap)?;
        let parts = ErrorBlocks::of_parts(&self.part_samples);
        let lowest = weighed(&best.left_out_squares, &weights);
        let is_worse = |point: &PointScores| {
            parts.is_below(&lowest, &weighed(&point.left_out_squares, &weights), 1.0)
        };
        let is_flat = |f_at: usize, t_at: usize| Some(!is_worse(self.point(f_at, t_at)?));
        Ok(Suggestion {
            thresholds: self.thresholds(at.0, at.1),
            at,
            left_out,
            conventional,
            beats_conventional: is_worse(&self.conventional),
            f_th_range: flat_range(&self.grid.f_ths, at.0, |f_at| is_flat(f_at, at.1)),
            t_th_range: flat_range(&self.grid.t_ths_secs, at.1, |t_at| is_flat(at.0, t_at)),
            n_parts: self.part_samples.len(),
            parts_are_blocks: self.cross_validation.is_by_block(),
            cross_validation: self.cross_validation.clone(),
        })
    }
}

impl Suggestion {
    /// Returns the suggested thresholds and their errors as a clause.
    pub fn in_words(&self, map: &ThresholdMap, measure: Measure) -> String {
        let (label, unit) = (measure.label(&map.scale), measure.unit(&map.scale));
        let [error, conventional] =
            [self.left_out, self.conventional].map(|rmse| significant(rmse, 4));
        let change = percent_change(self.conventional, self.left_out)
            .map_or_else(String::new, |change| format!(", {change:+.1} %"));
        let f_th = ShownFTh::of(map.distance).text(self.thresholds.f_th);
        let (t_th, how) = (self.thresholds.t_th_secs, &self.cross_validation);
        let doubt = if self.beats_conventional {
            ""
        } else {
            "; this is not below the uncompensated error with 90 % confidence"
        };
        format!(
            "cross-validation minimum of {label} at F_th {f_th} and t_th {t_th} s: error {error} {unit} (uncompensated: {conventional} \
             {unit}{change}; {how}){doubt}"
        )
    }

    /// Returns the ranges of equally good thresholds as a clause.
    pub fn ranges_in_words(&self, distance: Distance) -> String {
        let shown = ShownFTh::of(distance);
        let f_th = self.f_th_range.in_words(|f_th| shown.text(f_th));
        let t_th = self.t_th_range.in_words(|t_th_secs| format!("{t_th_secs} s"));
        format!("as good within the uncertainty: F_th {f_th}; t_th {t_th}")
    }
}

/// Returns the run of equally good values around the value with index `best`. Values without a result (`None`), from missing
/// rows of the map, are skipped.
fn flat_range(values: &[f64], best: usize, is_flat: impl Fn(usize) -> Option<bool>) -> FlatRange {
    let last_flat = |candidates: &mut dyn Iterator<Item = usize>| {
        let known = candidates.filter_map(|at| Some((at, is_flat(at)?)));
        let flat = known.take_while(|(_, flat)| *flat);
        flat.last().map_or(best, |(at, _)| at)
    };
    let from = last_flat(&mut (0..best).rev());
    let to = last_flat(&mut (best + 1..values.len()));
    FlatRange {
        from: values[from],
        to: values[to],
        from_is_first_tried: from == 0,
        to_is_last_tried: to + 1 == values.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::Scores;
    use crate::questions::thresholds::grid::ThresholdGrid;
    use crate::questions::thresholds::measure::MeasureScale;
    use crate::recording::Axis;

    /// Returns a point with these mean squared errors on four parts of ten samples.
    fn point(mean_squares: [f64; 4]) -> PointScores {
        let mean = mean_squares.iter().sum::<f64>() / 4.0;
        PointScores {
            scores: Scores {
                train_rmse: Some(vec![0.0]),
                test_rmse: None,
                cv_rmse: Some(vec![mean.sqrt()]),
            },
            left_out_squares: mean_squares.map(|square| 10.0 * square).to_vec(),
        }
    }

    fn map(rows: &[[f64; 4]]) -> ThresholdMap {
        let f_ths = (0..rows.len()).map(|at| at as f64).collect();
        let grid = ThresholdGrid::new(f_ths, vec![15.0]).unwrap();
        let scale = MeasureScale { axes: vec![Axis::Fz], full_scale: vec![10.0] };
        let mut map = ThresholdMap::new(grid, Distance::Force, scale, point(rows[0]), vec![10; 4]);
        for (at, row) in rows.iter().enumerate() {
            map.set_row(at, vec![point(*row)]);
        }
        map
    }

    /// The first row is without compensation, with an error of 3 N. The lowest error is 2 N. In the last row the look-back finds
    /// hardly any earlier sample.
    #[test]
    fn the_shades_reach_from_the_lowest_error_to_that_without_compensation() {
        let mut rows: Vec<[f64; 4]> = (0..40).map(|at| [4.0 + 0.01 * f64::from(at); 4]).collect();
        (rows[0], rows[1], rows[39]) = ([9.0; 4], [4.0; 4], [1e6; 4]);
        let map = map(&rows);
        let (set, measure) = (ScoreSet::LeftOut, Measure::Axis(0));
        assert_eq!(map.shades(set, measure), Some((2.0, 3.0)));
        assert!(map.value(set, measure, 39, 0).unwrap() > 3.0);
    }

    /// Row 3 is best. Row 2 alternates between better and worse: mean +0.05, far below its standard error. Row 4 is worse by
    /// 0.1 on every part, without spread. Row 5 would be as good, but lies beyond row 4. Row 1 is much worse.
    #[test]
    fn the_range_holds_neighbours_that_are_not_significantly_worse() {
        let map = map(&[
            [9.0, 9.0, 9.0, 9.1],
            [4.0, 4.1, 4.2, 4.0],
            [1.5, 0.6, 1.5, 0.6],
            [1.0, 1.0, 1.0, 1.0],
            [1.1, 1.1, 1.1, 1.1],
            [1.5, 0.6, 1.5, 0.6],
        ]);
        let found = map.suggestion(Measure::Forces).unwrap();
        assert_eq!((found.thresholds.f_th, found.left_out), (3.0, 1.0));
        assert_eq!((found.f_th_range.from, found.f_th_range.to), (2.0, 3.0));
        assert!(!found.f_th_range.from_is_first_tried && !found.f_th_range.to_is_last_tried);
        assert!(found.beats_conventional);
    }

    #[test]
    fn a_gain_that_may_be_luck_is_called_so() {
        let map = map(&[[1.5, 0.6, 1.5, 0.6], [1.0, 1.0, 1.0, 1.0]]);
        let found = map.suggestion(Measure::Forces).unwrap();
        assert!(!found.beats_conventional);
        assert!(found.f_th_range.from_is_first_tried && found.f_th_range.to_is_last_tried);
    }

    #[test]
    fn an_unfinished_map_suggests_among_its_computed_rows() {
        let full = map(&[[3.0; 4], [2.0; 4], [1.0; 4]]);
        let mut half = map(&[[3.0; 4], [2.0; 4], [1.0; 4]]);
        half.rows[2] = None;
        assert_eq!(full.suggestion(Measure::Forces).unwrap().thresholds.f_th, 2.0);
        assert_eq!(half.suggestion(Measure::Forces).unwrap().thresholds.f_th, 1.0);
        half.rows = vec![None; 3];
        assert_eq!(half.suggestion(Measure::Forces), Err(AnalysisError::EmptyMap));
        assert_eq!(half.suggestion(Measure::Moments), Err(AnalysisError::NoSuchAxis));
        half.conventional.scores.cv_rmse = None;
        assert_eq!(half.suggestion(Measure::Forces), Err(NoCrossValidation::FewSamples.into()));
    }
}
