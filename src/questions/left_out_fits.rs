//! Fits without each part of the training recordings: their predictions, and the spread of their coefficients.

use crate::calibration::{Calibration, LinearMap, NoCrossValidation, Terms};
use crate::features::Design;
use crate::questions::dataset::Dataset;
use crate::questions::errors::fit::Sums;
use crate::scoring::left_out::{LeftOut, shares_of_blocks};

impl Dataset {
    /// Returns the fits of a linear calibration's model without each part, with its ridge.
    pub fn fits_left_out(
        &self,
        calibration: &Calibration,
        sums: &Sums,
    ) -> Result<Vec<LinearMap>, NoCrossValidation> {
        if sums.parts.len() < 2 {
            return Err(NoCrossValidation::FewGroups { found: sums.parts.len(), needed: 2 });
        }
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

    /// Returns the linear map with these coefficients on top of the conventional ones.
    pub fn map_of(&self, design: &Design, coefficients: &[f64]) -> LinearMap {
        LinearMap::new(design.columns(), self.map.corrected(design, coefficients))
    }
}

/// Returns the ridge of each column of a fit, as a share of its squared length.
fn shares_of(calibration: &Calibration, terms: Terms<'_>, design: &Design) -> Vec<Vec<f64>> {
    let quality = &calibration.quality;
    match quality.ridge_by_block.is_empty() {
        true => terms.of_targets(&quality.ridge),
        false => {
            let blocks: Vec<Vec<usize>> =
                design.blocks().into_iter().map(|own| own.columns).collect();
            let of_axis = |axis: usize| {
                let strengths: Vec<Option<f64>> =
                    quality.ridge_by_block.iter().map(|own| own.strengths[axis]).collect();
                shares_of_blocks(design.n_columns(), &blocks, &strengths)
            };
            (0..calibration.axes.len()).map(of_axis).collect()
        }
    }
}
