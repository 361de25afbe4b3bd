//! All scores of one F_th over every t_th, from sums alone.

use crate::calibration::{
    AgedSums, LinearMap, NormalEquations, Ridge, RidgeChoice, Scores, Terms, fit, fit_targets,
};
use crate::features::{ColumnKind, Design};
use crate::progress::{Cancelled, Progress};
use crate::scoring::left_out::{LeftOut, summed_by_target};
use crate::scoring::metrics;

/// How a fit at one pair of thresholds does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointScores {
    /// RMSE per axis.
    pub scores: Scores,
    /// Sums of squared errors of each left-out part, `n_parts × n_axes` row-major; empty where nothing was left out.
    pub left_out_squares: Vec<f64>,
}

/// Scores fits that differ in the thresholds of the first look-back only.
#[derive(Clone, Debug)]
pub struct Scorer {
    /// The training sums, and those of each part and of the test recordings; the look-back is zero in all of them.
    train: NormalEquations,
    parts: Vec<NormalEquations>,
    /// What fits without a part are scored on, where that differs from it.
    cold: Option<Vec<NormalEquations>>,
    /// The training recordings, where an automatic ridge leaves them out whole rather than the parts.
    recordings: Option<Vec<NormalEquations>>,
    test: NormalEquations,
    /// What each column is.
    kinds: Vec<ColumnKind>,
    /// The conventional map, which the targets lack.
    known: Vec<f64>,
    ridge: RidgeChoice,
    conventional: PointScores,
    conventional_rank: usize,
}

impl Scorer {
    /// Takes the sums of the parts that are left out in turn, and of the test recordings, all with a first look-back that
    /// finds nothing, and the conventional map, which leaves over what they have as targets.
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
        // The targets are what the conventional map leaves over, so zero coefficients stand for that map.
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

    /// Chooses an automatic ridge by leaving these out in turn: the training recordings, where they are two, as a fit does.
    pub fn with_ridge_by(mut self, recordings: Option<Vec<NormalEquations>>) -> Self {
        self.recordings = recordings;
        self
    }

    /// How the conventional calibration does: the present alone.
    pub fn conventional(&self) -> &PointScores {
        &self.conventional
    }

    /// Whether fits without a part are scored on other sums than the part's.
    pub fn is_scored_cold(&self) -> bool {
        self.cold.is_some()
    }

    /// Test samples.
    pub fn n_test(&self) -> u64 {
        self.test.n_samples()
    }

    /// Samples of each part that is left out in turn.
    pub fn part_samples(&self) -> Vec<u64> {
        self.parts.iter().map(NormalEquations::n_samples).collect()
    }

    /// The scores at every t_th in turn.
    ///
    /// **Shapes** `aged_parts` holds what each piece of the training recordings adds to which part and which recording,
    /// `aged_cold` what it adds to what the part is scored on, `aged_test` what the test recordings add; `n_classes` is the number
    /// of t_th.
    ///
    /// # Errors
    /// [`Cancelled`] if somebody asked for it.
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
            // The past never differs: as in every fit, the conventional answer to the last bit.
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
