//! The linear fit: one pass over every recording, then everything from the sums.

use rayon::prelude::*;

use crate::analysis::dataset::{Dataset, Errors, in_role};
use crate::calibration::{
    Calibration, LinearMap, NormalEquations, Past, Piece, Quality, Ridge, RidgeChoice, Scores,
    Terms, condition_number, fit, fit_targets, recording_sums,
};
use crate::evaluation::cross_validation::folds;
use crate::evaluation::left_out::LeftOut;
use crate::evaluation::metrics;
use crate::evaluation::part_squares::PartSquares;
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

impl Dataset {
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

    /// Fits the compensated map from sums alone; returns each recording's errors (conventional, compensated), and what the
    /// fits without each part leave over of it.
    pub fn fit(
        &self,
        ridge: RidgeChoice,
        past: &[Past],
        calibration: &mut Calibration,
    ) -> (Vec<Option<Errors>>, Option<PartSquares>) {
        let n_axes = calibration.axes.len();
        let design = calibration.design();
        let Sums {
            of_recordings,
            train,
            test,
            parts,
        } = self.sums(&design, past, n_axes);
        let (kinds, known) = (design.kinds(), self.map.standardised(&design));
        let (all, present) = (design.all(), design.present());
        // Only an automatic ridge asks for them: every slider step comes by here.
        let whole = match ridge {
            RidgeChoice::Strength(_) => None,
            RidgeChoice::Auto => self.recordings_left_out(&of_recordings),
        };
        let terms = |used| Terms {
            used,
            kinds: &kinds,
            known: &known,
        };
        let left_out = |parts, used| LeftOut {
            total: &train,
            parts,
            terms: terms(used),
        };
        let (strengths, squares) = match (ridge, &whole) {
            (RidgeChoice::Strength(strength), _) => (vec![strength; n_axes], None),
            (RidgeChoice::Auto, Some(whole)) => (left_out(whole, &all).with_ridge(ridge).0, None),
            (RidgeChoice::Auto, None) => left_out(&parts, &all).with_ridge(ridge),
        };
        // The targets are what the conventional map leaves over, so zero coefficients stand for that map.
        let none = vec![0.0; design.n_columns() * n_axes];
        let mut found = fit_targets(&train, terms(&all), &strengths);
        if found.rank == fit(&train, terms(&present), Ridge::None).rank {
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
        let left_out_all = left_out(&parts, &all);
        let left_out_squares = left_out_all.is_determined(&strengths).then(|| PartSquares {
            part_samples: parts.iter().map(NormalEquations::n_samples).collect(),
            squares: squares.unwrap_or_else(|| left_out_all.squares_by_target(&strengths)),
        });
        let compensated_cv = left_out_squares.as_ref().and_then(PartSquares::rmse);
        calibration.quality = Quality {
            n_train: train.n_samples(),
            n_test: test.n_samples(),
            conventional: scores(&none, left_out(&parts, &present).rmse(&vec![0.0; n_axes])),
            compensated: scores(&found.coefficients, compensated_cv),
            rank: found.rank,
            condition: condition_number(&train, &all, found.rank),
            ridge: strengths,
            ..Quality::default()
        };
        let errors = of_recordings
            .iter()
            .map(|pieces| {
                let mut whole = NormalEquations::new(design.n_columns(), n_axes);
                pieces.iter().for_each(|piece| whole.add(piece));
                let before = metrics::rmse(&whole, &none)?;
                Some((before, metrics::rmse(&whole, &found.coefficients)?))
            })
            .collect();
        (errors, left_out_squares)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use crate::analysis::{Request, analyse};
    use crate::calibration::{Calibration, FitSettings};
    use crate::features::{Blocks, FeatureSettings, Polynomial};
    use crate::progress::Progress;
    use crate::random::Random;
    use crate::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

    /// `n` samples of three gauges in every recording; the last gauge moves in those that `moves` names, and stands still at
    /// 0.7 in the others.
    fn recordings(lengths: &[usize], moves: &[usize]) -> Vec<Arc<Recording>> {
        let of_length = |(at, &n): (usize, &usize)| {
            let mut random = Random::new(5, &[at as u64]);
            let (mut gauges, mut loads) = (Vec::new(), Vec::new());
            for _ in 0..n {
                let [a, b, c, noise] = [(); 4].map(|()| random.normal());
                let c = if moves.contains(&at) { c } else { 0.7 };
                gauges.extend([100.0 + a, 1e-3 * b, c]);
                loads.push(3.0 * a - b + 2.0 * c + 0.4 * a * b + 0.2 * noise);
            }
            let recording = Recording::new(
                format!("r{at}"),
                Source::Simulated,
                (0..n).map(|k| k as f64 * 0.01).collect(),
                ["S1", "S2", "S3"].map(str::to_owned).to_vec(),
                gauges,
                vec![Axis::Fz],
                loads,
            );
            Arc::new(recording.unwrap())
        };
        lengths.iter().enumerate().map(of_length).collect()
    }

    /// The fit to all recordings but `tested`, which are tested on.
    fn fitted(recordings: &[Arc<Recording>], tested: Option<usize>) -> Arc<Calibration> {
        let mut set = RecordingSet::default();
        for (at, recording) in recordings.iter().enumerate() {
            let role = if Some(at) == tested {
                Role::Test
            } else {
                Role::Train
            };
            let recording = Arc::clone(recording);
            set.push(Entry { recording, role }).unwrap();
        }
        let settings = FitSettings {
            features: FeatureSettings {
                blocks: Blocks::default().with(&Polynomial, &[2.0]),
                ..FeatureSettings::present()
            },
            ..FitSettings::default()
        };
        let request = Request::fit(Arc::new(set), settings);
        analyse(&request, &Progress::default()).unwrap().calibration
    }

    #[track_caller]
    fn assert_as_refits(lengths: &[usize], moves: &[usize]) {
        let recordings = recordings(lengths, moves);
        let whole = fitted(&recordings, None);
        let mut squares = [0.0; 2];
        for (at, recording) in recordings.iter().enumerate() {
            let quality = &fitted(&recordings, Some(at)).quality;
            for (square, scores) in squares
                .iter_mut()
                .zip([&quality.conventional, &quality.compensated])
            {
                let rmse = scores.test_rmse.as_ref().unwrap()[0];
                *square += rmse * rmse * recording.n_samples() as f64;
            }
        }
        let n: usize = lengths.iter().sum();
        let quality = &whole.quality;
        for (square, scores) in squares
            .iter()
            .zip([&quality.conventional, &quality.compensated])
        {
            let explicit = (square / n as f64).sqrt();
            let cross_validated = scores.cv_rmse.as_ref().unwrap()[0];
            assert!(
                (cross_validated / explicit - 1.0).abs() < 1e-8,
                "{lengths:?}, moving in {moves:?}: {cross_validated} instead of {explicit}"
            );
        }
    }

    /// What only the recording that is left out could tell of a gauge, its prediction does not know.
    #[test]
    fn errors_of_left_out_recordings_are_those_of_fits_without_them() {
        assert_as_refits(&[60, 50, 70], &[0, 1, 2]);
        assert_as_refits(&[60, 50, 70], &[1]);
        assert_as_refits(&[60, 50, 70, 40, 55], &[4]);
        assert_as_refits(&[8, 7, 9], &[0, 1, 2]);
    }

    #[test]
    fn a_fit_through_every_sample_says_so_and_has_no_left_out_errors() {
        let thin = fitted(&recordings(&[3, 3, 3], &[0, 1, 2]), None);
        let undetermined = thin.undetermined().unwrap();
        assert_eq!((undetermined.samples, undetermined.coefficients), (9, 10));
        assert_eq!(thin.quality.compensated.cv_rmse, None);
        assert!(thin.quality.conventional.cv_rmse.is_some());
        assert!(thin.why_not_left_out().is_some());
        assert_eq!(
            fitted(&recordings(&[30, 30, 30], &[0]), None).undetermined(),
            None
        );
    }
}
