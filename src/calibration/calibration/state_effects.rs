//! After a start, the states of the feature blocks are not known exactly. Computes how much each state counts, and when the
//! error by this is small beside the expected error, so that the status becomes `ok`.

use crate::{
    calibration::{
        calibration::{Calibration, NEVER_REACHED},
        entries::check_length,
        error::CalibrationError,
    },
    features::{Block, FeatureStream},
};

/// Feature block with its values and the effect of each of its states.
type Effects<'a> = (&'static dyn Block, &'a [f64], Vec<f64>);

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
        let (blocks, is_linear) = self.effects_beside(&self.expected_errors());
        let allowed = if is_linear { SHARE * SHARE } else { 0.0 } + self.usually_missing(&blocks);
        let scaled = |effect: f64| (effect / allowed.max(f64::MIN_POSITIVE)).min(NEVER_REACHED);
        blocks.into_iter().map(|(.., effects)| effects.into_iter().map(scaled).collect()).collect()
    }

    fn usually_missing(&self, blocks: &[Effects<'_>]) -> f64 {
        let of_block = |(block, values, effects): &Effects<'_>| {
            block.usually_missing(values, effects, &self.gauge_scale)
        };
        blocks.iter().map(of_block).sum()
    }

    /// Returns the factors of a fade with equal strength for equal effects on the load, beside full scale: the unknown part
    /// with all states unknown is 1. Empty if no state is ever unknown. The second result is the unknown part in the middle of
    /// the training samples.
    pub(crate) fn fade_factors(&self) -> (Vec<Vec<f64>>, f64) {
        let beside = |scale: &f64| if *scale > 0.0 { *scale } else { f64::INFINITY };
        let beside: Vec<f64> = self.full_scale.iter().map(beside).collect();
        let (blocks, _) = self.effects_beside(&beside);
        let usual = self.usually_missing(&blocks);
        let mut factors: Vec<Vec<f64>> = blocks.into_iter().map(|(.., effects)| effects).collect();
        let all = FeatureStream::new(&self.design()).missing(&factors);
        if !(all > 0.0 && all.is_finite()) {
            return (Vec::new(), 0.0);
        }
        factors.iter_mut().flatten().for_each(|factor| *factor /= all);
        (factors, usual / all)
    }

    /// Returns [`Self::fade`] with one entry for each feature block with columns; empty without a fade.
    pub(crate) fn fade_of_states(&self) -> Vec<Vec<f64>> {
        if self.fade.is_empty() {
            return Vec::new();
        }
        let of_block = |key: &'static str| self.fade.get(key).cloned().unwrap_or_default();
        self.design().keys_with_columns().into_iter().map(of_block).collect()
    }

    /// Checks that the fade has a factor for each state of each feature block that it names.
    pub(crate) fn check_fade(&self) -> Result<(), CalibrationError> {
        let (blocks, _) = self.effects_beside(&[]);
        for (block, _, effects) in blocks {
            if let Some(factors) = self.fade.get(block.setting().key) {
                check_length(
                    &format!("fade.{}", block.setting().key),
                    effects.len(),
                    factors.len(),
                )?;
            }
        }
        Ok(())
    }

    /// Sets [`Self::fade`] to these factors of each feature block with columns.
    pub(crate) fn set_fade(&mut self, factors: Vec<Vec<f64>>) {
        let keys = self.design().keys_with_columns().into_iter().map(str::to_owned);
        self.fade = keys.zip(factors).filter(|(_, factors)| !factors.is_empty()).collect();
    }

    /// Returns for each feature block with columns its values and the effects of its states, see [`Block::effects`], as shares
    /// of these loads of the axes. If the effects on the load are not known, all states get the same effect, and the second
    /// result is false.
    fn effects_beside(&self, loads: &[f64]) -> (Vec<Effects<'_>>, bool) {
        let n_gauges = self.gauges.len();
        let map = self.compensated.as_ref().filter(|_| self.learned.is_none());
        let map = map.filter(|_| loads.iter().any(|load| load.is_finite()));
        let mut first = n_gauges * (1 + self.features.look_backs.len());
        let blocks = self.features.blocks.used().filter_map(|(block, values)| {
            let n_columns = self.features.n_columns_of(block, values, n_gauges);
            let square = |column: usize| match map {
                Some(map) => {
                    let rows = map.matrix.iter().zip(loads);
                    let shares = rows.map(|(row, load)| row[first + column].abs() / load);
                    shares.fold(0.0, f64::max).powi(2)
                }
                None => self.gauge_scale.inverse_deviation(column % n_gauges).powi(2),
            };
            let squares: Vec<f64> = (0..n_columns).map(square).collect();
            first += n_columns;
            (n_columns > 0)
                .then(|| (block, values, block.effects(values, &squares, &self.gauge_scale)))
        });
        (blocks.collect(), map.is_some())
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
