//! Computes how far the states of the feature blocks must have come after a start, so that what is still missing of the load is
//! small beside the expected error, or is already part of it.

use crate::calibration::calibration::Calibration;

/// Largest error by unknown states for the status `ok`, as a share of the expected error.
const SHARE: f64 = 0.1;
/// Ratio of the expected error, within which 95 % of the errors lie, to the root mean square. It stands for the expected error
/// if that is not known.
const EXPECTED_BY_RMSE: f64 = 2.0;

impl Calibration {
    /// Returns for each feature block with columns how far the state of its columns must have come, see
    /// [`Block::needed`](crate::features::Block::needed). Half of the allowed squared error is for the columns with the least
    /// effect, which need nothing then. The others share the other half evenly.
    pub(crate) fn needed_states(&self) -> Vec<Vec<f64>> {
        let (n_gauges, deviation) = (self.gauges.len(), &self.gauge_scale.deviation);
        let expected = self.expected_errors();
        let matrix = self.compensated.as_ref().filter(|_| self.learned.is_none());
        let mut first = n_gauges * (1 + self.features.look_backs.len());
        // For each block: the standard error at the start of each column in the unit of its gauge, and its largest effect on an
        // axis as a share of the expected error.
        let blocks = self.features.blocks.used().filter_map(|(block, values)| {
            let n_columns = self.features.n_columns_of(block, values, n_gauges);
            let unknown = values.iter().flat_map(|value| {
                deviation.iter().map(|deviation| block.unknown_at_start(*value) * deviation)
            });
            let unknown: Vec<f64> = unknown.take(n_columns).collect();
            let effect = |(at, error): (usize, &f64)| {
                let rows = matrix.into_iter().flat_map(|map| &map.matrix).zip(&expected);
                let shares = rows.map(|(row, expected)| row[first + at].abs() * error / expected);
                shares.fold(0.0, f64::max)
            };
            let effects: Vec<f64> = unknown.iter().enumerate().map(effect).collect();
            first += n_columns;
            (n_columns > 0).then_some((block, values, unknown, effects))
        });
        let blocks: Vec<_> = blocks.collect();
        let mut all: Vec<f64> = blocks.iter().flat_map(|(.., effects)| effects).copied().collect();
        all.sort_unstable_by(f64::total_cmp);
        let half = 0.5 * SHARE * SHARE;
        let squares = all.iter().scan(0.0, |sum, effect| {
            *sum += effect * effect;
            Some(*sum)
        });
        let n_small = squares.take_while(|sum| *sum <= half).count();
        let largest_small = n_small.checked_sub(1).map_or(0.0, |at| all[at]);
        let each = (half / (all.len() - n_small).max(1) as f64).sqrt();
        let is_known = matrix.is_some() && expected.iter().any(|error| error.is_finite());
        let needed = blocks.into_iter().map(|(block, values, unknown, effects)| {
            let tolerance = unknown.iter().zip(&effects).map(|(unknown, effect)| match *effect {
                _ if !is_known => 0.0,
                effect if effect <= largest_small => f64::INFINITY,
                effect => unknown * each / effect,
            });
            block.needed(values, &tolerance.collect::<Vec<_>>(), &self.gauge_scale)
        });
        needed.collect()
    }

    /// Returns the expected error of each axis, or a multiple of its RMSE; infinite for an axis without any.
    fn expected_errors(&self) -> Vec<f64> {
        let scores = &self.quality.compensated;
        let rmse = scores.cv_rmse.as_ref().or(scores.train_rmse.as_ref());
        let of_axis = |(at, axis)| {
            let expected = self.quality.expected_error.as_ref();
            let expected = expected.and_then(|expected| expected.of_axis(axis).ok());
            let by_rmse = rmse.and_then(|rmse| rmse.get(at)).map(|rmse| EXPECTED_BY_RMSE * rmse);
            expected.or(by_rmse).filter(|error| *error > 0.0).unwrap_or(f64::INFINITY)
        };
        self.axes.iter().copied().enumerate().map(of_axis).collect()
    }
}
