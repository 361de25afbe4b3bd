//! Scores of one F_th at every t_th, from sums alone.

use crate::calibration::{
    AgedSums, LinearMap, NormalEquations, Ridge, RidgeChoice, Scores, Terms, fit, fit_targets,
};
use crate::features::{ColumnKind, Design};
use crate::progress::{Cancelled, Progress};
use crate::scoring::left_out::{LeftOut, summed_by_target};
use crate::scoring::metrics;

#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointScores {
    pub scores: Scores,
    /// Sums of squared errors of each held-out part, `n_parts × n_axes` row-major; empty if nothing is held out.
    pub left_out_squares: Vec<f64>,
}

/// Scores fits that differ only in the thresholds of the first look-back.
#[derive(Clone, Debug)]
pub struct Scorer {
    /// Sums of all training samples, of each part, and of the test recordings. The first look-back finds no past sample.
    train: NormalEquations,
    parts: Vec<NormalEquations>,
    /// Cold-start sums on which fits without a part are scored, if they differ from the part's own.
    cold: Option<Vec<NormalEquations>>,
    /// Sums of the training recordings, if an automatic ridge leaves out recordings rather than the parts.
    recordings: Option<Vec<NormalEquations>>,
    test: NormalEquations,
    kinds: Vec<ColumnKind>,
    /// Conventional map. The targets are its residuals.
    known: Vec<f64>,
    ridge: RidgeChoice,
    conventional: PointScores,
    conventional_rank: usize,
}

impl Scorer {
    /// Returns a scorer from the sums of the parts and of the test recordings, with a first look-back that finds no past
    /// sample. The targets are the residuals of the conventional map.
    pub fn new(
        design: &Design,
        conventional: &LinearMap,
        parts: Vec<NormalEquations>,
        cold: Option<Vec<NormalEquations>>,
        test: NormalEquations,
        ridge: RidgeChoice,
    ) -> Self {
        let present = design.present();
        let mut train = NormalEquations::new(test.n_features(), test.n_targets());
        parts.iter().for_each(|part| train.add(part));
        let (kinds, known) = (design.kinds(), conventional.standardised(design));
        let terms = Terms { used: &present, kinds: &kinds, known: &known };
        // The targets are the residuals of the conventional map, so zero coefficients mean that map.
        let none = vec![0.0; train.n_features() * train.n_targets()];
        let left_out = LeftOut::of(&train, &parts, terms).scored_on(cold.as_deref());
        let squares = (parts.len() > 1).then(|| left_out.squares(0.0));
        let conventional = point_scores(&train, &test, &none, squares);
        Self {
            conventional_rank: fit(&train, terms, Ridge::None).rank,
            train,
            parts,
            cold,
            recordings: None,
            test,
            kinds,
            known,
            ridge,
            conventional,
        }
    }

    /// Chooses an automatic ridge by leaving out these training recordings in turn, as a fit to two recordings does.
    pub fn with_ridge_by(mut self, recordings: Option<Vec<NormalEquations>>) -> Self {
        self.recordings = recordings;
        self
    }

    pub fn conventional(&self) -> &PointScores {
        &self.conventional
    }

    /// Returns true if fits without a part are scored on cold-start sums.
    pub fn is_scored_cold(&self) -> bool {
        self.cold.is_some()
    }

    pub fn n_test(&self) -> u64 {
        self.test.n_samples()
    }

    pub fn part_samples(&self) -> Vec<u64> {
        self.parts.iter().map(NormalEquations::n_samples).collect()
    }

    /// Returns the scores at each of `n_classes` t_th.
    ///
    /// **Shapes** `aged_parts` holds the contribution of each training piece to its part and recording, `aged_cold` to the sums
    /// that the part is scored on. `aged_test` holds that of the test recordings.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn row(
        &self,
        aged_parts: &[(usize, usize, AgedSums)],
        aged_cold: &[(usize, AgedSums)],
        aged_test: &[AgedSums],
        n_classes: usize,
        progress: &Progress,
    ) -> Result<Vec<PointScores>, Cancelled> {
        let Self { mut train, mut parts, mut cold, mut recordings, mut test, .. } = self.clone();
        (0..n_classes)
            .map(|class| {
                progress.check()?;
                for (part, recording, aged) in aged_parts {
                    if let Some(recordings) = &mut recordings {
                        aged.add_class_to(class, &mut recordings[*recording]);
                    }
                    aged.add_class_to(class, &mut parts[*part]);
                    aged.add_class_to(class, &mut train);
                }
                for (part, aged) in aged_cold {
                    if let Some(cold) = &mut cold {
                        aged.add_class_to(class, &mut cold[*part]);
                    }
                }
                for aged in aged_test {
                    aged.add_class_to(class, &mut test);
                }
                let parts = [&parts, cold.as_ref().unwrap_or(&parts)];
                Ok(self.point(&train, parts, recordings.as_deref(), &test))
            })
            .collect()
    }

    fn point(
        &self,
        train: &NormalEquations,
        [parts, scored]: [&Vec<NormalEquations>; 2],
        recordings: Option<&[NormalEquations]>,
        test: &NormalEquations,
    ) -> PointScores {
        let all: Vec<usize> = (0..train.n_features()).collect();
        let used = train.present_among(&all);
        if !used.iter().any(|&column| self.kinds[column] == ColumnKind::Appended) {
            return self.conventional.clone();
        }
        let terms = Terms { used: &used, kinds: &self.kinds, known: &self.known };
        let left_out = LeftOut::of(train, parts, terms).scored_on(Some(scored));
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
            // If no past sample differs, the answer is the conventional one, to the bit.
            found.coefficients.fill(0.0);
        }
        point_scores(train, test, &found.coefficients, squares)
    }
}

fn point_scores(
    train: &NormalEquations,
    test: &NormalEquations,
    coefficients: &[f64],
    squares: Option<Vec<f64>>,
) -> PointScores {
    let q = train.n_targets();
    let cv_rmse = squares
        .as_ref()
        .and_then(|squares| metrics::root_mean(&summed_by_target(squares, q), train.n_samples()));
    PointScores {
        scores: Scores {
            train_rmse: metrics::rmse(train, coefficients),
            test_rmse: metrics::rmse(test, coefficients),
            cv_rmse,
        },
        left_out_squares: squares.unwrap_or_default(),
    }
}
