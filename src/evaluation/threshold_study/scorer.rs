//! All scores of one F_th over every t_th, from sums alone.

use crate::calibration::{AgedSums, NormalEquations, Ridge, RidgeChoice, Scores, fit, fit_targets};
use crate::evaluation::cross_validation::{RIDGE_STRENGTHS, left_out_squares, strongest_good};
use crate::evaluation::left_out::LeftOut;
use crate::evaluation::metrics;
use crate::features::Design;
use crate::progress::{Cancelled, Progress};

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
    /// The training recordings, where an automatic ridge leaves them out whole rather than the parts.
    recordings: Option<Vec<NormalEquations>>,
    test: NormalEquations,
    /// For each column, whether a block brought it.
    appended: Vec<bool>,
    ridge: RidgeChoice,
    conventional: PointScores,
    conventional_rank: usize,
}

impl Scorer {
    /// Takes the sums of the parts that are left out in turn, and of the test recordings, all with a first look-back that
    /// finds nothing.
    #[must_use]
    pub fn new(
        design: &Design,
        parts: Vec<NormalEquations>,
        test: NormalEquations,
        ridge: RidgeChoice,
    ) -> Self {
        let present = design.present();
        let mut train = NormalEquations::new(test.n_features(), test.n_targets());
        parts.iter().for_each(|part| train.add(part));
        let solve = |sums: &NormalEquations| fit(sums, &present, Ridge::None);
        // The targets are what the conventional map leaves over, so zero coefficients stand for that map.
        let none = vec![0.0; train.n_features() * train.n_targets()];
        let squares = left_out_squares(&train, &parts, solve).map(|squares| squares.concat());
        let conventional = point_scores(&train, &test, &none, squares);
        Self {
            conventional_rank: solve(&train).rank,
            train,
            parts,
            recordings: None,
            test,
            appended: design.appended(),
            ridge,
            conventional,
        }
    }

    /// Chooses an automatic ridge by leaving these out in turn: the training recordings, where they are two, as a fit does.
    #[must_use]
    pub fn with_ridge_by(mut self, recordings: Option<Vec<NormalEquations>>) -> Self {
        self.recordings = recordings;
        self
    }

    /// How the conventional calibration does: the present alone.
    #[must_use]
    pub fn conventional(&self) -> &PointScores {
        &self.conventional
    }

    /// Training samples.
    #[must_use]
    pub fn n_train(&self) -> u64 {
        self.train.n_samples()
    }

    /// Test samples.
    #[must_use]
    pub fn n_test(&self) -> u64 {
        self.test.n_samples()
    }

    /// Samples of each part that is left out in turn.
    #[must_use]
    pub fn part_samples(&self) -> Vec<u64> {
        self.parts.iter().map(NormalEquations::n_samples).collect()
    }

    /// The scores at every t_th in turn.
    ///
    /// **Shapes** `aged_parts` holds what each piece of the training recordings adds to which part and which recording,
    /// `aged_test` what the test recordings add; `n_classes` is the number of t_th.
    ///
    /// # Errors
    /// [`Cancelled`] if somebody asked for it.
    pub fn row(
        &self,
        aged_parts: &[(usize, usize, AgedSums)],
        aged_test: &[AgedSums],
        n_classes: usize,
        progress: &Progress,
    ) -> Result<Vec<PointScores>, Cancelled> {
        let Self {
            mut train,
            mut parts,
            mut recordings,
            mut test,
            ..
        } = self.clone();
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
                for aged in aged_test {
                    aged.add_class_to(class, &mut test);
                }
                Ok(self.point(&train, &parts, recordings.as_deref(), &test))
            })
            .collect()
    }

    fn point(
        &self,
        train: &NormalEquations,
        parts: &[NormalEquations],
        recordings: Option<&[NormalEquations]>,
        test: &NormalEquations,
    ) -> PointScores {
        let all: Vec<usize> = (0..train.n_features()).collect();
        let used: Vec<usize> = (all.iter().copied())
            .filter(|&column| train.feature_product(column, column) > 0.0)
            .collect();
        if !used.iter().any(|&column| self.appended[column]) {
            return self.conventional.clone();
        }
        let left_out = LeftOut {
            total: train,
            parts,
            used: &used,
            shrunk: &self.appended,
        };
        let (strengths, squares) = match (self.ridge, recordings) {
            (RidgeChoice::Auto, Some(recordings)) => {
                let whole = LeftOut {
                    parts: recordings,
                    ..left_out
                };
                let (strengths, _) = left_out_with_ridge(&whole, self.ridge);
                let squares = left_out.squares_by_target(&strengths);
                (strengths, (parts.len() > 1).then_some(squares))
            }
            _ => left_out_with_ridge(&left_out, self.ridge),
        };
        let mut found = fit_targets(train, &all, &self.appended, &strengths);
        if found.rank == self.conventional_rank {
            // The past never differs: as in every fit, the conventional answer to the last bit.
            found.coefficients.fill(0.0);
        }
        point_scores(train, test, &found.coefficients, squares)
    }
}

/// The strength of the ridge for each target, and the squared errors of each left-out part with it, `n_parts × n_targets`
/// row-major; none with fewer than two parts.
///
/// An automatic ridge is chosen anew for these very columns, as
/// [`choose_ridge`](crate::evaluation::cross_validation::choose_ridge) does for a fit.
pub(crate) fn left_out_with_ridge(
    left_out: &LeftOut<'_>,
    ridge: RidgeChoice,
) -> (Vec<f64>, Option<Vec<f64>>) {
    let q = left_out.total.n_targets();
    let enough = left_out.parts.len() > 1;
    match ridge {
        RidgeChoice::Strength(strength) => {
            let squares = enough.then(|| left_out.squares(strength));
            (vec![strength; q], squares)
        }
        RidgeChoice::Auto if !enough => (vec![0.0; q], None),
        RidgeChoice::Auto => {
            let tried: Vec<Vec<f64>> = RIDGE_STRENGTHS
                .iter()
                .map(|strength| left_out.squares(*strength))
                .collect();
            let n_parts = tried[0].len() / q;
            let chosen: Vec<usize> = (0..q)
                .map(|axis| strongest_good(n_parts, |at, part| tried[at][part * q + axis]))
                .collect();
            let squares = (0..n_parts * q)
                .map(|at| tried[chosen[at % q]][at])
                .collect();
            let strengths = chosen.iter().map(|at| RIDGE_STRENGTHS[*at]).collect();
            (strengths, Some(squares))
        }
    }
}

fn point_scores(
    train: &NormalEquations,
    test: &NormalEquations,
    coefficients: &[f64],
    squares: Option<Vec<f64>>,
) -> PointScores {
    let q = train.n_targets();
    let cv_rmse = squares.as_ref().and_then(|squares| {
        let sums: Vec<f64> = (0..q)
            .map(|target| squares.iter().skip(target).step_by(q).sum())
            .collect();
        metrics::root_mean(&sums, train.n_samples())
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

/// The fewest samples that are left to fit when a part is left out; `None` with fewer than two parts.
#[must_use]
pub fn fewest_samples_without_a_part(part_samples: &[u64]) -> Option<u64> {
    let total: u64 = part_samples.iter().sum();
    let largest = part_samples.iter().max()?;
    (part_samples.len() > 1).then(|| total - largest)
}
