//! After a start, the states of the feature blocks are not known exactly. Computes when the error by this is small beside the
//! expected error, so that the status becomes `ok`.

use crate::{
    calibration::calibration::{Calibration, NEVER_REACHED},
    features::Block,
};

/// Largest error by unknown states with the status `ok`, as a share of the expected error. The part that the expected error
/// contains already does not count.
const SHARE: f64 = 0.1;
/// Ratio of the expected error, within which 95 % of the errors lie, to the root mean square. It stands for the expected error
/// if that is not known.
const EXPECTED_BY_RMSE: f64 = 2.0;

impl Calibration {
    /// Returns for each feature block with columns the effects of its states, see [`Block::effects`]. They are scaled so that
    /// the sum over all blocks of what is missing is 1 where the status becomes `ok`: at a tenth of the expected error beyond
    /// what is missing in the middle of the training samples, whose errors are part of the expected error.
    ///
    /// How a state changes the output of a network or kernel is not known, so all its states get the same effect.
    pub(crate) fn state_effects(&self) -> Vec<Vec<f64>> {
        let n_gauges = self.gauges.len();
        let expected = self.expected_errors();
        let map = self.compensated.as_ref().filter(|_| self.learned.is_none());
        let map = map.filter(|_| expected.iter().any(|error| error.is_finite()));
        let mut first = n_gauges * (1 + self.features.look_backs.len());
        let blocks = self.features.blocks.used().filter_map(|(block, values)| {
            let n_columns = self.features.n_columns_of(block, values, n_gauges);
            let square = |column: usize| match map {
                Some(map) => {
                    let rows = map.matrix.iter().zip(&expected);
                    let shares = rows.map(|(row, expected)| row[first + column].abs() / expected);
                    shares.fold(0.0, f64::max).powi(2)
                }
                None => self.gauge_scale.inverse_deviation(column % n_gauges).powi(2),
            };
            let squares: Vec<f64> = (0..n_columns).map(square).collect();
            first += n_columns;
            (n_columns > 0)
                .then(|| (block, values, block.effects(values, &squares, &self.gauge_scale)))
        });
        let blocks: Vec<(&dyn Block, &[f64], Vec<f64>)> = blocks.collect();
        let usual = blocks.iter().map(|(block, values, effects)| {
            block.usually_missing(values, effects, &self.gauge_scale)
        });
        let allowed = map.map_or(0.0, |_| SHARE * SHARE) + usual.sum::<f64>();
        let scaled = |effect: f64| (effect / allowed.max(f64::MIN_POSITIVE)).min(NEVER_REACHED);
        blocks.into_iter().map(|(.., effects)| effects.into_iter().map(scaled).collect()).collect()
    }

    /// Returns the expected error of each axis, or else a multiple of its RMSE. An axis without an RMSE gets infinity.
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
