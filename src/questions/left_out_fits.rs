//! Cross-validation of a linear calibration: one fit without each part of the training recordings.

use crate::calibration::{Calibration, LinearMap, NoCrossValidation, Terms};
use crate::features::Design;
use crate::questions::dataset::Dataset;
use crate::questions::errors::fit::Sums;
use crate::scoring::left_out::{LeftOut, shares_of_blocks};

impl Dataset {
    /// Returns one linear fit for each part of the training recordings, made without this part, with the features and the
    /// ridge of `calibration`.
    pub fn fits_left_out(
        &self,
        calibration: &Calibration,
        sums: &Sums,
    ) -> Result<Vec<LinearMap>, NoCrossValidation> {
        let design = calibration.design();
        let (kinds, known, all) = (design.kinds(), self.map.standardised(&design), design.all());
        let terms = Terms { used: &all, kinds: &kinds, known: &known };
        let shares = shares_of(calibration, terms, &design);
        let strengths: Vec<f64> =
            shares.iter().map(|own| own.iter().copied().fold(0.0, f64::max)).collect();
        let left_out = LeftOut::of(&sums.train, &sums.parts, terms);
        if !left_out.is_determined(&strengths) {
            return Err(NoCrossValidation::FewSamples);
        }
        let fits = left_out.coefficients(&shares);
        Ok(fits.iter().map(|found| self.map_of(&design, found)).collect())
    }

    /// Returns the linear map whose coefficients are the sum of the conventional coefficients and `coefficients`, which are
    /// standardised.
    pub fn map_of(&self, design: &Design, coefficients: &[f64]) -> LinearMap {
        LinearMap::new(design.columns(), self.map.corrected(design, coefficients))
    }
}

/// Returns the ridge penalty for each axis and feature column, as a share of the column's squared length.
fn shares_of(calibration: &Calibration, terms: Terms<'_>, design: &Design) -> Vec<Vec<f64>> {
    let quality = &calibration.quality;
    if quality.ridge_by_block.is_empty() {
        return terms.of_targets(&quality.ridge);
    }
    let blocks: Vec<Vec<usize>> = design.blocks().into_iter().map(|own| own.columns).collect();
    let of_axis = |axis: usize| {
        let strengths = quality.ridge_by_block.iter().map(|own| own.strengths[axis]);
        shares_of_blocks(design.n_columns(), &blocks, &strengths.collect::<Vec<_>>())
    };
    (0..calibration.axes.len()).map(of_axis).collect()
}
