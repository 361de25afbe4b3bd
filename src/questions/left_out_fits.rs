//! Fits that leave each part of the training recordings out: what they make of it, and how far their coefficients differ.

use crate::calibration::{Calibration, LinearMap, Terms};
use crate::features::Design;
use crate::questions::dataset::Dataset;
use crate::questions::errors::fit::Sums;
use crate::scoring::left_out::{LeftOut, shares_of_blocks};

/// Why no fit can do without a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotLeftOut {
    #[error("what a network or a kernel learned cannot be fitted from sums")]
    Learned,
    #[error("there is nothing to leave out")]
    OnePart,
    #[error("without some part too few samples would be left to fit")]
    TooFew,
}

/// The fits, by the part that each leaves out.
pub(crate) struct LeftOutFits {
    pub maps: Vec<LinearMap>,
}

impl Dataset {
    /// The fits of a linear calibration's model, with its ridge, to all parts but one.
    pub fn fits_left_out(
        &self,
        calibration: &Calibration,
        sums: &Sums,
    ) -> Result<LeftOutFits, NotLeftOut> {
        if calibration.learned.is_some() {
            return Err(NotLeftOut::Learned);
        }
        if sums.parts.len() < 2 {
            return Err(NotLeftOut::OnePart);
        }
        let design = calibration.design();
        let (kinds, known, all) = (design.kinds(), self.map.standardised(&design), design.all());
        let terms = Terms { used: &all, kinds: &kinds, known: &known };
        let shares = shares_of(calibration, terms, &design);
        let strengths: Vec<f64> =
            shares.iter().map(|own| own.iter().copied().fold(0.0, f64::max)).collect();
        let left_out = LeftOut::of(&sums.train, &sums.parts, terms);
        if !left_out.is_determined(&strengths) {
            return Err(NotLeftOut::TooFew);
        }
        let fits = left_out.coefficients(&shares);
        let maps = fits.iter().map(|found| self.map_of(&design, found));
        Ok(LeftOutFits { maps: maps.collect() })
    }

    /// The map with these coefficients beside the conventional ones.
    pub fn map_of(&self, design: &Design, coefficients: &[f64]) -> LinearMap {
        LinearMap::new(design.columns(), self.map.corrected(design, coefficients))
    }
}

/// The shares that the columns of a fit were shrunk by, as it says of itself.
fn shares_of(calibration: &Calibration, terms: Terms<'_>, design: &Design) -> Vec<Vec<f64>> {
    let quality = &calibration.quality;
    match quality.ridge_by_block.is_empty() {
        true => terms.of_targets(&quality.ridge),
        false => {
            let blocks: Vec<Vec<usize>> =
                design.blocks().into_iter().map(|(_, columns)| columns).collect();
            let of_axis = |axis: usize| {
                let strengths: Vec<Option<f64>> =
                    quality.ridge_by_block.iter().map(|own| own.strengths[axis]).collect();
                shares_of_blocks(design.n_columns(), &blocks, &strengths)
            };
            (0..calibration.axes.len()).map(of_axis).collect()
        }
    }
}
