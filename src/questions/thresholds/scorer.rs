//! Computes the errors at one force threshold F_th and all time thresholds t_th from sums over the samples. No further pass
//! over the samples is needed.

use crate::{
    calibration::{
        AgedSums, LinearMap, NormalEquations, Ridge, RidgeChoice, Scores, Terms, fit, fit_targets,
    },
    features::{ColumnKind, Design},
    progress::{Cancelled, Progress},
    questions::dataset::fit::Sums,
    scoring::{
        left_out::{LeftOut, summed_by_target},
        metrics,
    },
};

#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointScores {
    pub scores: Scores,
    /// Sum of squared errors of each part that cross-validation leaves out, `n_parts × n_axes` row-major; empty without
    /// cross-validation.
    pub left_out_squares: Vec<f64>,
}

/// Sums over the samples of a fit. The errors of fits with other thresholds of the first look-back follow from these sums.
pub struct Scorer {
    /// Sums for the case that the first of the look-backs finds no earlier sample. The targets of the fit are the residuals
    /// of the conventional calibration.
    pub sums: Sums,
    /// Sums of each recording if there are exactly two training recordings. An automatic ridge then leaves out recordings,
    /// while cross-validation leaves out blocks of samples.
    recordings: Option<Vec<NormalEquations>>,
    kinds: Vec<ColumnKind>,
    /// Coefficients of the conventional calibration.
    known: Vec<f64>,
    ridge: RidgeChoice,
    pub conventional: PointScores,
    conventional_rank: usize,
}

/// Changes of the sums from each t_th to the next larger one, for one F_th.
#[derive(Default)]
pub struct AgedRow {
    /// Changes by each block of a training recording, with the numbers of the cross-validation part and of the recording that
    /// contain the block.
    pub parts: Vec<(usize, usize, AgedSums)>,
    /// Changes of the sums in which the history starts anew with each left-out part, with the number of the part.
    pub cold: Vec<(usize, AgedSums)>,
    pub test: Vec<AgedSums>,
}

impl Scorer {
    /// Creates a scorer from sums that were computed as if no sample had an earlier sample to look back to. The changes by each
    /// pair of thresholds are added later.
    pub fn new(
        design: &Design,
        conventional: &LinearMap,
        sums: Sums,
        recordings: Option<Vec<NormalEquations>>,
        ridge: RidgeChoice,
    ) -> Self {
        let present = design.present();
        let (kinds, known) = (design.kinds(), conventional.standardised(design));
        let terms = Terms { used: &present, kinds: &kinds, known: &known };
        let Sums { train, parts, cold, .. } = &sums;
        // The targets are the residuals of the conventional calibration, so zero coefficients stand for that calibration.
        let none = vec![0.0; train.n_features() * train.n_targets()];
        let left_out = LeftOut::of(train, parts, terms).scored_on(cold.as_deref());
        let squares = (parts.len() > 1).then(|| left_out.squares(0.0));
        Self {
            conventional: point_scores(&sums, &none, squares),
            conventional_rank: fit(train, terms, Ridge::None).rank,
            sums,
            recordings,
            kinds,
            known,
            ridge,
        }
    }

    pub fn part_samples(&self) -> Vec<u64> {
        self.sums.parts.iter().map(NormalEquations::n_samples).collect()
    }

    /// Returns the scores at the F_th of this row, one for each of `n_classes` time thresholds t_th.
    pub fn row(
        &self,
        row: &AgedRow,
        n_classes: usize,
        progress: &Progress,
    ) -> Result<Vec<PointScores>, Cancelled> {
        let (mut sums, mut recordings) = (self.sums.clone(), self.recordings.clone());
        (0..n_classes)
            .map(|class| {
                progress.check()?;
                for (part, recording, aged) in &row.parts {
                    if let Some(recordings) = &mut recordings {
                        aged.add_class_to(class, &mut recordings[*recording]);
                    }
                    aged.add_class_to(class, &mut sums.parts[*part]);
                    aged.add_class_to(class, &mut sums.train);
                }
                for (part, aged) in &row.cold {
                    if let Some(cold) = &mut sums.cold {
                        aged.add_class_to(class, &mut cold[*part]);
                    }
                }
                for aged in &row.test {
                    aged.add_class_to(class, &mut sums.test);
                }
                Ok(self.point(&sums, recordings.as_deref()))
            })
            .collect()
    }

    fn point(&self, sums: &Sums, recordings: Option<&[NormalEquations]>) -> PointScores {
        let Sums { train, parts, cold, .. } = sums;
        let all: Vec<usize> = (0..train.n_features()).collect();
        let used = train.present_among(&all);
        if !used.iter().any(|&column| self.kinds[column] == ColumnKind::Appended) {
            return self.conventional.clone();
        }
        let terms = Terms { used: &used, kinds: &self.kinds, known: &self.known };
        let left_out = LeftOut::of(train, parts, terms).scored_on(cold.as_deref());
        let (strengths, squares) = match (self.ridge, recordings) {
            (RidgeChoice::Auto | RidgeChoice::ByBlock, Some(recordings)) => {
                let whole = LeftOut::of(train, recordings, terms);
                let (strengths, _) = whole.with_ridge(self.ridge);
                let squares = left_out.squares_by_target(&left_out.terms.of_targets(&strengths));
                (strengths, (parts.len() > 1).then_some(squares))
            }
            _ => left_out.with_ridge(self.ridge),
        };
        let mut found = fit_targets(train, terms, &terms.of_targets(&strengths));
        if found.rank == self.conventional_rank {
            // If the look-back finds no earlier sample for any sample, the result is exactly that of the conventional
            // calibration.
            found.coefficients.fill(0.0);
        }
        point_scores(sums, &found.coefficients, squares)
    }
}

fn point_scores(sums: &Sums, coefficients: &[f64], squares: Option<Vec<f64>>) -> PointScores {
    let Sums { train, test, .. } = sums;
    let cv_rmse = squares.as_ref().and_then(|squares| {
        metrics::root_mean(&summed_by_target(squares, train.n_targets()), train.n_samples())
    });
    PointScores {
        scores: Scores {
            train_rmse: metrics::rmse(train, coefficients),
            test_rmse: metrics::rmse(test, coefficients),
            cv_rmse,
        },
        left_out_squares: squares.unwrap_or_default(),
    }
}
