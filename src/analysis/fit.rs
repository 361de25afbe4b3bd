//! The linear fit: one pass over every recording, then everything from the sums.

use rayon::prelude::*;

use crate::analysis::ground::{Errors, Ground, Past, in_role};
use crate::calibration::{
    Calibration, LinearMap, NormalEquations, Piece, Quality, Ridge, RidgeChoice, Scores,
    condition_number, fit, fit_targets, recording_sums,
};
use crate::evaluation::cross_validation::{choose_ridge, cross_validate, folds};
use crate::evaluation::metrics;
use crate::features::Design;
use crate::recording::Role;

/// The sums of all recordings on the columns of one design.
pub(super) struct Sums {
    /// One list per recording, one entry per piece.
    pub of_recordings: Vec<Vec<NormalEquations>>,
    pub train: NormalEquations,
    pub test: NormalEquations,
    /// The training sums in the parts that cross-validation leaves out.
    pub parts: Vec<NormalEquations>,
}

impl Ground {
    /// How each recording is cut: those in the train role into the parts that are left out in turn, others not at all.
    pub fn pieces(&self) -> Vec<Vec<Piece>> {
        let lengths: Vec<usize> = in_role(&self.entries, Role::Train)
            .iter()
            .map(|recording| recording.n_samples())
            .collect();
        let mut training_pieces = folds(&lengths).into_iter();
        self.entries
            .iter()
            .map(|entry| match entry.role {
                Role::Train => training_pieces.next().expect("one list per recording"),
                Role::Test | Role::Off => vec![Piece {
                    samples: 0..entry.recording.n_samples(),
                    fold: 0,
                }],
            })
            .collect()
    }

    /// The one pass.
    pub fn sums(&self, design: &Design, past: &[Past], n_axes: usize) -> Sums {
        let pieces = self.pieces();
        let of_recordings: Vec<Vec<NormalEquations>> = self
            .entries
            .par_iter()
            .enumerate()
            .map(|(at, entry)| {
                if !entry.recording.has_reference() {
                    return Vec::new();
                }
                recording_sums(
                    &entry.recording,
                    design,
                    &self.loads[at],
                    &past[at],
                    &pieces[at],
                )
            })
            .collect();
        let empty = || NormalEquations::new(design.n_columns(), n_axes);
        let (mut train, mut test) = (empty(), empty());
        let n_folds = pieces.iter().flatten().map(|piece| piece.fold + 1).max();
        let mut parts = vec![empty(); n_folds.unwrap_or(0)];
        for ((entry, pieces), sums) in self.entries.iter().zip(&pieces).zip(&of_recordings) {
            for (piece, sums) in pieces.iter().zip(sums) {
                match entry.role {
                    Role::Train => {
                        parts[piece.fold].add(sums);
                        train.add(sums);
                    }
                    Role::Test => test.add(sums),
                    Role::Off => {}
                }
            }
        }
        Sums {
            of_recordings,
            train,
            test,
            parts,
        }
    }

    /// The training sums by recording, where there are two: blocks of the same recordings would know too much of each
    /// other to say how strong a ridge a third one needs.
    pub fn recordings_left_out(
        &self,
        sums: &[Vec<NormalEquations>],
    ) -> Option<Vec<NormalEquations>> {
        let training = self
            .entries
            .iter()
            .zip(sums)
            .filter(|(entry, _)| entry.role == Role::Train);
        let whole: Vec<NormalEquations> = training
            .filter_map(|(_, pieces)| {
                let (first, others) = pieces.split_first()?;
                let mut whole = first.clone();
                others.iter().for_each(|piece| whole.add(piece));
                Some(whole)
            })
            .collect();
        (whole.len() == 2).then_some(whole)
    }

    /// Fits the compensated map from sums alone; returns each recording's errors (conventional, compensated).
    pub fn fit(
        &self,
        ridge: RidgeChoice,
        past: &[Past],
        calibration: &mut Calibration,
    ) -> Vec<Option<Errors>> {
        let n_axes = calibration.axes.len();
        let design = calibration.design();
        let Sums {
            of_recordings,
            train,
            test,
            parts,
        } = self.sums(&design, past, n_axes);
        let (all, present, appended) = (design.all(), design.present(), design.appended());
        // The targets are what the conventional map leaves over, so zero coefficients stand for that map.
        let none = vec![0.0; design.n_columns() * n_axes];
        let strengths = match ridge {
            RidgeChoice::Strength(strength) => vec![strength; n_axes],
            RidgeChoice::Auto => {
                let parts = self
                    .recordings_left_out(&of_recordings)
                    .unwrap_or_else(|| parts.clone());
                choose_ridge(&train, &parts, &all, &appended)
            }
        };
        let mut found = fit_targets(&train, &all, &appended, &strengths);
        if found.rank == fit(&train, &present, Ridge::None).rank {
            // The past never differs: the compensated map is the conventional one, to the last bit.
            found.coefficients.clone_from(&none);
        }
        calibration.compensated = Some(LinearMap {
            columns: design.columns(),
            matrix: self.map.corrected(&design, &found.coefficients),
        });
        let scores = |coefficients: &[f64], cv_rmse| Scores {
            train_rmse: metrics::rmse(&train, coefficients),
            test_rmse: metrics::rmse(&test, coefficients),
            cv_rmse,
        };
        let solve_present = |sums: &NormalEquations| fit(sums, &present, Ridge::None);
        let solve_all = |sums: &NormalEquations| fit_targets(sums, &all, &appended, &strengths);
        calibration.quality = Quality {
            n_train: train.n_samples(),
            n_test: test.n_samples(),
            conventional: scores(&none, cross_validate(&train, &parts, solve_present)),
            compensated: scores(
                &found.coefficients,
                cross_validate(&train, &parts, solve_all),
            ),
            rank: found.rank,
            condition: condition_number(&train, &all, found.rank),
            ridge: strengths,
        };
        of_recordings
            .iter()
            .map(|pieces| {
                let mut whole = NormalEquations::new(design.n_columns(), n_axes);
                pieces.iter().for_each(|piece| whole.add(piece));
                let before = metrics::rmse(&whole, &none)?;
                Some((before, metrics::rmse(&whole, &found.coefficients)?))
            })
            .collect()
    }
}
