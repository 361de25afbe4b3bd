//! Linear fit by normal equations: one pass through all recordings computes the sums XᵀX and XᵀY, from which all results
//! follow. Before the fit, the history rate is chosen: the number of earlier samples per second that a controller stores.
//!
//! Guarantees: the rate depends only on the recordings and the settings, so every fit of a calibration chooses the same rate.

use std::fmt;
use std::ops::RangeInclusive;
use std::sync::Arc;

use rayon::prelude::*;

use crate::{
    calibration::{
        BlockRidge, Calibration, CoefficientErrors, FitSettings, LinearMap, MOST_FEATURES,
        NoCrossValidation, NormalEquations, Past, Quality, Ridge, RidgeChoice, Scores, Terms,
        condition_number, fit, fit_targets, look_back_sums, measured_fade, recording_sums,
    },
    export::Footprint,
    features::Design,
    panicked::locked,
    progress::{Cancelled, Progress},
    questions::{
        dataset::{Dataset, Errors},
        error::AnalysisError,
    },
    recording::{Entry, Role},
    scoring::{
        information::free_coefficients,
        left_out::{LeftOut, shares_of_blocks},
        metrics,
        part_squares::PartSquares,
    },
};

/// Maximum size (bytes) of the normal equations that are kept to make the next change of look-back thresholds fast.
const MOST_KEPT_BYTES: usize = 1 << 26;

#[derive(Clone, Debug)]
pub(crate) struct Sums {
    /// Normal equations of each piece of each recording. A piece is a range of samples that belongs to one part of the
    /// cross-validation.
    pub of_recordings: Vec<Vec<NormalEquations>>,
    pub train: NormalEquations,
    pub test: NormalEquations,
    /// Normal equations of each part of the training recordings that cross-validation leaves out. The history of the features
    /// starts anew in each part, for the fits as for the scores: no fit sees the gauges of the part that it leaves out.
    pub parts: Vec<NormalEquations>,
    /// Sum of `parts`, if parts are blocks of a recording and features have a memory; otherwise `train` is their sum.
    pub cold: Option<NormalEquations>,
}

impl Sums {
    /// Returns the cross-validation that leaves out one of the parts at a time.
    pub fn left_out<'a>(&'a self, terms: Terms<'a>) -> LeftOut<'a> {
        LeftOut::of(self.cold.as_ref().unwrap_or(&self.train), &self.parts, terms)
    }
}

pub(crate) struct LinearFit {
    pub errors: Vec<Option<Errors>>,
    pub shares: Vec<Vec<f64>>,
    /// Squared errors of each part of the training recordings, predicted by a fit to the other parts; `None` if the other
    /// parts do not determine a fit.
    pub left_out: Option<PartSquares>,
}

impl Dataset {
    /// Returns the normal equations of all recordings; incomplete if the work was cancelled.
    pub fn sums(&self, design: &Design, past: &[Past], n_axes: usize, progress: &Progress) -> Sums {
        self.fading_sums(design, past, n_axes, &[], progress)
    }

    /// Returns the normal equations of all recordings like [`Self::sums`]; with factors of a `fade`, those of loads that fade in,
    /// see [`recording_sums`].
    fn fading_sums(
        &self,
        design: &Design,
        past: &[Past],
        n_axes: usize,
        fade: &[Vec<f64>],
        progress: &Progress,
    ) -> Sums {
        let of_recordings = self.sums_of_recordings(design, past, fade, progress);
        let empty = NormalEquations::new(design.n_columns(), n_axes);
        let cold = self.cold_parts(design, past, n_axes, fade, progress);
        let mut parts = vec![empty.clone(); self.folds.n_parts];
        let (mut train, mut test) = (empty.clone(), empty.clone());
        let entries = self.entries.iter().zip(&self.folds.pieces);
        for ((entry, pieces), sums) in entries.zip(&of_recordings) {
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
        let cold = cold.map(|cold| {
            parts = cold;
            let mut all = empty;
            parts.iter().for_each(|part| all.add(part));
            all
        });
        Sums { of_recordings, train, test, parts, cold }
    }

    fn cold_parts(
        &self,
        design: &Design,
        past: &[Past],
        n_axes: usize,
        fade: &[Vec<f64>],
        progress: &Progress,
    ) -> Option<Vec<NormalEquations>> {
        let has_memory = design.features.has_memory() || !design.features.look_backs.is_empty();
        if !has_memory || self.folds.are_whole {
            return None;
        }
        let empty = NormalEquations::new(design.n_columns(), n_axes);
        let mut parts = vec![empty; self.folds.n_parts];
        for (at, entry) in self.entries.iter().enumerate() {
            if entry.role == Role::Train {
                let (loads, pieces) = (self.present_loads(at), &self.folds.pieces[at]);
                let sums = recording_sums(design, loads, &past[at], pieces, true, fade, progress);
                pieces.iter().zip(sums).for_each(|(piece, sums)| parts[piece.fold].add(&sums));
            }
        }
        Some(parts)
    }

    /// Returns the normal equations of each piece of each recording. If only look-back thresholds changed, only the columns
    /// of the look-backs are summed again. The result is then bitwise identical to that of summing all columns.
    fn sums_of_recordings(
        &self,
        design: &Design,
        past: &[Past],
        fade: &[Vec<f64>],
        progress: &Progress,
    ) -> Vec<Vec<NormalEquations>> {
        let key = design.with_any_thresholds();
        let known = match &*locked(&self.derived.unmoved) {
            Some((known, sums)) if *known == key && fade.is_empty() => Some(Arc::clone(sums)),
            _ => None,
        };
        let of_recording = |(at, entry): (usize, &Entry)| {
            if !entry.recording.has_reference() {
                return Vec::new();
            }
            let (loads, past, pieces) = (self.present_loads(at), &past[at], &self.folds.pieces[at]);
            let Some(known) = &known else {
                return recording_sums(design, loads, past, pieces, false, fade, progress);
            };
            let moved = look_back_sums(design, loads, past, pieces, progress).into_iter();
            let moved = moved.zip(&known[at]).map(|(moved, known)| {
                let mut sums = known.clone();
                moved.add_class_to(0, &mut sums);
                sums
            });
            moved.collect()
        };
        let sums: Vec<Vec<_>> = (self.entries.par_iter().enumerate()).map(of_recording).collect();
        let bytes: usize = sums.iter().flatten().map(NormalEquations::size_bytes).sum();
        if known.is_none()
            && fade.is_empty()
            && bytes <= MOST_KEPT_BYTES
            && !progress.is_cancelled()
        {
            let look_backs = design.look_backs();
            let without = |sums: &NormalEquations| sums.without(look_backs.clone());
            let unmoved = sums.iter().map(|pieces| pieces.iter().map(without).collect());
            let unmoved = (key, Arc::new(unmoved.collect()));
            *locked(&self.derived.unmoved) = Some(unmoved);
        }
        sums
    }

    /// Returns the normal equations of each training recording if there are exactly two: the ridge is then chosen by leaving
    /// out one of them, because the blocks of a single recording are too similar. With more recordings, the parts of
    /// cross-validation are whole recordings already.
    pub fn recordings_left_out(
        &self,
        sums: &[Vec<NormalEquations>],
    ) -> Option<Vec<NormalEquations>> {
        let training = self.entries.iter().zip(sums).filter(|(entry, _)| entry.role == Role::Train);
        let whole: Vec<_> = training.filter_map(|(_, pieces)| total(pieces)).collect();
        (whole.len() == 2).then_some(whole)
    }

    pub fn fit(
        &self,
        ridge: RidgeChoice,
        past: &[Past],
        calibration: &mut Calibration,
        progress: &Progress,
    ) -> Result<LinearFit, Cancelled> {
        let design = calibration.design();
        let sums = self.sums(&design, past, calibration.axes.len(), progress);
        progress.check()?;
        self.fit_sums(ridge, &sums, past, calibration, progress)
    }

    /// Fits the calibration to `sums`, measures its fade after cold starts, and scores the loads with this fade.
    pub fn fit_sums(
        &self,
        ridge: RidgeChoice,
        sums: &Sums,
        past: &[Past],
        calibration: &mut Calibration,
        progress: &Progress,
    ) -> Result<LinearFit, Cancelled> {
        let n_axes = calibration.axes.len();
        let design = calibration.design();
        let Sums { of_recordings, train, test, parts, .. } = sums;
        let (kinds, known) = (design.kinds(), self.map.standardised(&design));
        let (all, present) = (design.all(), design.present());
        // Only an automatic ridge needs the normal equations of whole recordings. Computing them at every step of a threshold
        // slider would take too long.
        let whole = match ridge {
            RidgeChoice::Strength(_) => None,
            RidgeChoice::Auto | RidgeChoice::ByBlock => self.recordings_left_out(of_recordings),
        };
        let terms = |used| Terms { used, kinds: &kinds, known: &known };
        let left_out_all = sums.left_out(terms(&all));
        let chooses = match &whole {
            Some(whole) => LeftOut::of(train, whole, terms(&all)),
            None => left_out_all,
        };
        let Chosen { strengths, by_block, shares, squares } = Chosen::of(&chooses, &design, ridge);
        let squares = squares.filter(|_| whole.is_none());
        // The fit predicts the residuals of the conventional map, so zero coefficients reproduce the conventional map.
        let none = vec![0.0; design.n_columns() * n_axes];
        let mut found = fit_targets(train, terms(&all), &shares);
        if found.rank == fit(train, terms(&present), Ridge::None).rank {
            // If the history adds no independent column, because no earlier sample differs from the present one, the
            // compensated map is the conventional map, to the bit.
            found.coefficients.clone_from(&none);
        }
        let matrix = self.map.corrected(&design, &found.coefficients);
        calibration.compensated = Some(LinearMap::new(design.columns(), matrix));
        let is_determined = left_out_all.is_determined(&strengths);
        let is_small = design.n_columns() <= MOST_FEATURES;
        let maps: Vec<LinearMap> = if is_determined && (is_small || design.features.has_memory()) {
            let each = left_out_all.coefficients(&shares).into_iter();
            each.map(|coefficients| self.map_of(&design, &coefficients)).collect()
        } else {
            Vec::new()
        };
        self.measure_fade(calibration, &maps, progress)?;
        let fade = calibration.fade_of_states();
        let fading =
            (!fade.is_empty()).then(|| self.fading_sums(&design, past, n_axes, &fade, progress));
        progress.check()?;
        let scored = fading.as_ref().unwrap_or(sums);
        let (squares, left_out_all) = match &fading {
            Some(fading) => (None, left_out_all.scored_on(&fading.parts)),
            None => (squares, left_out_all),
        };
        let scores = |coefficients: &[f64], cv_rmse| Scores {
            train_rmse: metrics::rmse(&scored.train, coefficients),
            test_rmse: metrics::rmse(&scored.test, coefficients),
            cv_rmse,
        };
        let left_out_squares = is_determined.then(|| PartSquares {
            part_samples: parts.iter().map(NormalEquations::n_samples).collect(),
            squares: squares.unwrap_or_else(|| left_out_all.squares_by_target(&shares)),
        });
        let compensated_cv = left_out_squares.as_ref().and_then(PartSquares::rmse);
        let coefficients = if is_small { &maps[..] } else { &[] };
        let coefficients = CoefficientErrors::of(self.cross_validation(), coefficients);
        let left_out_present = sums.left_out(terms(&present));
        let conventional_cv =
            left_out_present.rmse(&vec![0.0; n_axes], || left_out_present.squares(0.0));
        calibration.quality = Quality {
            n_train: train.n_samples(),
            n_test: test.n_samples(),
            conventional: scores(&none, conventional_cv),
            compensated: scores(&found.coefficients, compensated_cv),
            rank: found.rank,
            condition: condition_number(train, &all, found.rank),
            ridge: if by_block.is_empty() { strengths } else { Vec::new() },
            ridge_by_block: by_block,
            cross_validation: (parts.len() > 1).then(|| self.cross_validation()),
            coefficients,
            free_coefficients: free(train, &shares),
            ..Quality::default()
        };
        let errors = |pieces: &Vec<NormalEquations>| {
            let whole = total(pieces)?;
            let before = metrics::rmse(&whole, &none)?;
            Some((before, metrics::rmse(&whole, &found.coefficients)?))
        };
        let errors = scored.of_recordings.iter().map(errors).collect();
        Ok(LinearFit { errors, shares, left_out: left_out_squares })
    }

    /// Measures the fade of a calibration after cold starts in the training recordings, and sets it. `left_out` is as in
    /// [`measured_fade`].
    pub fn measure_fade(
        &self,
        calibration: &mut Calibration,
        left_out: &[LinearMap],
        progress: &Progress,
    ) -> Result<(), Cancelled> {
        calibration.fade.clear();
        let training = self.entries.iter().zip(&self.folds.pieces);
        let training = training.filter(|(entry, _)| entry.role == Role::Train);
        let training = training.map(|(entry, pieces)| (&*entry.recording, &pieces[..]));
        let fade = measured_fade(calibration, training, left_out, progress)?;
        calibration.set_fade(fade);
        Ok(())
    }

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
            shares.iter().map(|shares| shares.iter().copied().fold(0.0, f64::max)).collect();
        let left_out = sums.left_out(terms);
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
    let blocks: Vec<Vec<usize>> = design.blocks().into_iter().map(|block| block.columns).collect();
    let of_axis = |axis: usize| {
        let strengths = quality.ridge_by_block.iter().map(|block| block.strengths[axis]);
        shares_of_blocks(design.n_columns(), &blocks, &strengths.collect::<Vec<_>>())
    };
    (0..calibration.axes.len()).map(of_axis).collect()
}

fn total(pieces: &[NormalEquations]) -> Option<NormalEquations> {
    let (first, others) = pieces.split_first()?;
    let mut whole = first.clone();
    others.iter().for_each(|piece| whole.add(piece));
    Some(whole)
}

/// Returns the effective number of coefficients under the ridge, for the axis on which this number is largest.
fn free(train: &NormalEquations, shares: &[Vec<f64>]) -> Option<f64> {
    let mut different: Vec<&Vec<f64>> = Vec::new();
    for shares_of_axis in shares {
        if !different.contains(&shares_of_axis) {
            different.push(shares_of_axis);
        }
    }
    let free =
        different.into_iter().filter_map(|shares_of_axis| free_coefficients(train, shares_of_axis));
    free.max_by(f64::total_cmp)
}

struct Chosen {
    /// Smallest ridge strength of any feature block, for each axis; infinite if all blocks are left out.
    strengths: Vec<f64>,
    by_block: Vec<BlockRidge>,
    /// Ridge penalty of each feature column for each axis, as a share of the column's squared length (its diagonal element of
    /// XᵀX).
    shares: Vec<Vec<f64>>,
    /// Squared cross-validation errors of the parts with these ridge strengths; `None` if the choice did not compute them.
    squares: Option<Vec<f64>>,
}

impl Chosen {
    fn of(left_out: &LeftOut<'_>, design: &Design, ridge: RidgeChoice) -> Self {
        match ridge {
            RidgeChoice::ByBlock => {
                let groups: Vec<_> =
                    design.blocks().into_iter().map(|block| block.columns).collect();
                Self::by_group(left_out, design, &groups)
            }
            // Coefficients of auxiliary channels and of features with memory differ in magnitude, so each group of feature
            // blocks has its own ridge strength.
            RidgeChoice::Auto if design.ridge_groups().len() > 1 => {
                Self::by_group(left_out, design, &design.ridge_groups())
            }
            _ => Self::alike(left_out, ridge),
        }
    }

    fn alike(left_out: &LeftOut<'_>, ridge: RidgeChoice) -> Self {
        let (strengths, squares) = match ridge {
            RidgeChoice::Strength(strength) => (vec![strength; left_out.total.n_targets()], None),
            RidgeChoice::Auto | RidgeChoice::ByBlock => left_out.with_ridge(ridge),
        };
        Self {
            shares: left_out.terms.of_targets(&strengths),
            by_block: Vec::new(),
            strengths,
            squares,
        }
    }

    /// Chooses a ridge strength for each group of feature blocks. If cross-validation cannot compare the groups, chooses one
    /// strength for all, as [`Self::alike`].
    fn by_group(left_out: &LeftOut<'_>, design: &Design, groups: &[Vec<usize>]) -> Self {
        let described =
            design.blocks().into_iter().map(|described| (described.description, described.columns));
        let (names, blocks): (Vec<String>, Vec<Vec<usize>>) = described.unzip();
        let Some(chosen) = left_out.by_block(groups) else {
            return Self::alike(left_out, RidgeChoice::ByBlock);
        };
        let group_of =
            |block: &Vec<usize>| groups.iter().position(|group| group.contains(&block[0]));
        let of_blocks = |strengths: &Vec<Option<f64>>| -> Vec<Option<f64>> {
            let groups = blocks.iter().map(group_of);
            groups
                .map(|group| {
                    strengths[group.expect("every feature block belongs to a ridge group")]
                })
                .collect()
        };
        let chosen: Vec<Vec<Option<f64>>> = chosen.iter().map(of_blocks).collect();
        let shares = |strengths: &Vec<_>| shares_of_blocks(design.n_columns(), &blocks, strengths);
        let weakest = |strengths: &Vec<Option<f64>>| {
            let taken = strengths.iter().flatten().copied();
            taken.min_by(f64::total_cmp).unwrap_or(f64::INFINITY)
        };
        let of_block = |(at, block)| BlockRidge {
            block,
            strengths: chosen.iter().map(|strengths| strengths[at]).collect(),
        };
        Self {
            strengths: chosen.iter().map(weakest).collect(),
            by_block: names.into_iter().enumerate().map(of_block).collect(),
            shares: chosen.iter().map(shares).collect(),
            squares: None,
        }
    }
}

/// History rates to try, ascending (Hz).
const RATES_HZ: RangeInclusive<u16> = 1..=1000;
/// Maximum error of a fit with a lower history rate on each axis, as a multiple of the error with all samples in the history.
const LARGEST_COST: f64 = 1.02;

/// History that stores fewer samples per second than the recordings have.
#[derive(Clone, Copy, Debug)]
pub struct CoarseHistory {
    pub rate_hz: f64,
    /// Memory on a controller (bytes): with this history, and with all samples.
    memory: [usize; 2],
    /// Factor by which the error of the linear fit grows, on the axis on which it grows most.
    cost: f64,
}

impl fmt::Display for CoarseHistory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [coarse, whole] = self.memory.map(|bytes| bytes as f64 / 1000.0);
        write!(
            f,
            "with {} stored samples per second of history, a controller needs {coarse:.1} kB instead of {whole:.1} kB; this changes the error \
             of the linear fit by at most {:+.1} % on every axis",
            self.rate_hz,
            100.0 * (self.cost - 1.0)
        )
    }
}

/// Maximum number of choices that a dataset keeps.
const KEPT: usize = 64;

impl Dataset {
    /// Returns the calibration before the fit, with the history rate of the settings or the one that is chosen for them.
    pub fn unfitted(
        &self,
        settings: &FitSettings,
        progress: &Progress,
    ) -> Result<Calibration, AnalysisError> {
        let coarse = self.coarse_history(settings, progress)?;
        let chosen = coarse.map(|coarse| coarse.rate_hz).or(settings.history_rate_hz);
        self.blank_calibration(&FitSettings { history_rate_hz: chosen, ..settings.clone() })
    }

    /// Returns the history with the highest rate that needs at most 64 kB on a controller.
    ///
    /// Returns `None` if all samples fit into 64 kB, if a history rate is set, or if the error of an axis grows by more than 2 %
    /// with this rate. All samples are then stored.
    pub fn coarse_history(
        &self,
        settings: &FitSettings,
        progress: &Progress,
    ) -> Result<Option<CoarseHistory>, AnalysisError> {
        if settings.history_rate_hz.is_some() || !settings.features.has_history() {
            return Ok(None);
        }
        // Only the linear fit is compared: it has the same history as the other regressors, and is the fastest.
        let key = FitSettings {
            features: settings.features.clone(),
            ridge: settings.ridge,
            offset: settings.offset,
            decimation: settings.decimation,
            full_scale: settings.full_scale.clone(),
            auxiliary_references: settings.auxiliary_references.clone(),
            ..FitSettings::default()
        };
        let known = locked(&self.derived.histories);
        if let Some((_, known)) = known.iter().find(|(known, _)| *known == key) {
            return Ok(*known);
        }
        drop(known);
        let found = self.searched_history(&key, &progress.part())?;
        let mut known = locked(&self.derived.histories);
        known.insert(0, (key, found));
        known.truncate(KEPT);
        Ok(found)
    }

    fn searched_history(
        &self,
        settings: &FitSettings,
        progress: &Progress,
    ) -> Result<Option<CoarseHistory>, AnalysisError> {
        let blank = |rate_hz| {
            self.blank_calibration(&FitSettings {
                history_rate_hz: Some(rate_hz),
                ..settings.clone()
            })
        };
        let whole = Footprint::of(&blank(0.0)?);
        if !whole.is_large() {
            return Ok(None);
        }
        let fits = |rate: &u16| {
            blank(f64::from(*rate)).is_ok_and(|found| !Footprint::of(&found).is_large())
        };
        let rate_hz = RATES_HZ.collect::<Vec<_>>().partition_point(fits) as f64;
        if rate_hz == 0.0 {
            return Ok(None);
        }
        let errors = |rate_hz| {
            let mut calibration = blank(rate_hz)?;
            let past = self.past(&calibration, progress)?;
            self.fit(settings.ridge, &past, &mut calibration, progress)?;
            Ok::<_, AnalysisError>(errors_of(&calibration))
        };
        let (coarse, all) = (errors(rate_hz)?, errors(0.0)?);
        let costs = coarse.iter().zip(&all).map(|(coarse, all)| coarse / all);
        let cost = costs.fold(f64::NEG_INFINITY, f64::max);
        let memory = [Footprint::of(&blank(rate_hz)?).memory, whole.memory];
        Ok((cost <= LARGEST_COST).then_some(CoarseHistory { rate_hz, memory, cost }))
    }
}

/// Returns the error of each axis: in cross-validation, or if there is none, on the training recordings.
fn errors_of(calibration: &Calibration) -> Vec<f64> {
    let scores = &calibration.quality.compensated;
    scores.cv_rmse.clone().or_else(|| scores.train_rmse.clone()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use crate::calibration::{Calibration, CrossValidation, FitSettings};
    use crate::features::{Blocks, FeatureSettings, Polynomial};
    use crate::progress::Progress;
    use crate::questions::errors::query::analyse;
    use crate::questions::request::Request;
    use crate::random::Random;
    use crate::recording::{Axis, Entry, GroupedBy, Recording, RecordingSet, Role, Source};

    /// `n` samples of three gauges in every recording. The last gauge is 0.7 except in the recordings listed in `moves`.
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

    fn fitted(recordings: &[Arc<Recording>], tested: Option<usize>) -> Arc<Calibration> {
        let is_tested = |at: usize| Some(at) == tested;
        fitted_in_groups(recordings, &is_tested, &vec![None; recordings.len()])
    }

    fn fitted_in_groups(
        recordings: &[Arc<Recording>],
        is_tested: &dyn Fn(usize) -> bool,
        groups: &[Option<&str>],
    ) -> Arc<Calibration> {
        let mut set = RecordingSet::default();
        for (at, recording) in recordings.iter().enumerate() {
            let role = if is_tested(at) { Role::Test } else { Role::Train };
            let recording = Arc::clone(recording);
            set.push(Entry { recording, role, group: groups[at].map(str::to_owned) }).unwrap();
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
            for (square, scores) in
                squares.iter_mut().zip([&quality.conventional, &quality.compensated])
            {
                let rmse = scores.test_rmse.as_ref().unwrap()[0];
                *square += rmse * rmse * recording.n_samples() as f64;
            }
        }
        let n: usize = lengths.iter().sum();
        let quality = &whole.quality;
        for (square, scores) in squares.iter().zip([&quality.conventional, &quality.compensated]) {
            let explicit = (square / n as f64).sqrt();
            let cross_validated = scores.cv_rmse.as_ref().unwrap()[0];
            assert!(
                (cross_validated / explicit - 1.0).abs() < 1e-8,
                "{lengths:?}, moving in {moves:?}: {cross_validated} instead of {explicit}"
            );
        }
    }

    /// A gauge that moves only in the left-out recording has no effect on the recording's prediction.
    #[test]
    fn errors_of_left_out_recordings_are_those_of_fits_without_them() {
        assert_as_refits(&[60, 50, 70], &[0, 1, 2]);
        assert_as_refits(&[60, 50, 70], &[1]);
        assert_as_refits(&[60, 50, 70, 40, 55], &[4]);
        assert_as_refits(&[8, 7, 9], &[0, 1, 2]);
    }

    #[test]
    fn errors_of_left_out_groups_are_those_of_fits_without_them() {
        let recordings = recordings(&[60, 50, 70, 40, 55], &[0, 1, 2, 3, 4]);
        for groups in [["a", "b", "a", "c", "b"], ["a", "b", "b", "a", "a"]] {
            let set = groups.map(Some);
            let whole = fitted_in_groups(&recordings, &|_| false, &set);
            let mut squares = 0.0;
            let mut names = groups.to_vec();
            names.sort_unstable();
            names.dedup();
            for name in &names {
                let rest = fitted_in_groups(&recordings, &|at| groups[at] == *name, &[None; 5]);
                let rmse = rest.quality.compensated.test_rmse.as_ref().unwrap()[0];
                squares += rmse * rmse * rest.quality.n_test as f64;
            }
            let explicit = (squares / 275.0).sqrt();
            let quality = &whole.quality;
            let cross_validated = quality.compensated.cv_rmse.as_ref().unwrap()[0];
            assert!((cross_validated / explicit - 1.0).abs() < 1e-8, "{groups:?}");
            let expected =
                CrossValidation { by: GroupedBy::Group, groups: names.len(), parts: names.len() };
            assert_eq!(quality.cross_validation, Some(expected));
        }
    }

    #[test]
    fn an_undetermined_fit_is_reported_and_has_no_held_out_errors() {
        let thin = fitted(&recordings(&[3, 3, 3], &[0, 1, 2]), None);
        let undetermined = thin.undetermined().unwrap();
        assert_eq!((undetermined.samples, undetermined.coefficients), (9, 10));
        assert_eq!(thin.quality.compensated.cv_rmse, None);
        assert!(thin.quality.conventional.cv_rmse.is_some());
        assert!(thin.no_cross_validation().is_some());
        assert_eq!(fitted(&recordings(&[30, 30, 30], &[0]), None).undetermined(), None);
    }
}

#[cfg(test)]
mod history_tests {
    use std::sync::Arc;

    use crate::questions::dataset::fit::*;
    use crate::questions::{Request, analyse, train};
    use crate::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

    /// Three runs of a gauge with hysteresis at 400 Hz. A history of 15 s with all samples needs more than 64 kB.
    #[test]
    fn every_fit_chooses_the_same_history() {
        let mut set = RecordingSet::default();
        for at in 0..3 {
            let load = |k: usize| (0.002 * k as f64 + f64::from(at)).sin();
            let mut play = 0.0;
            let gauge = |k| {
                play = f64::clamp(play, load(k) - 0.1, load(k) + 0.1);
                10.0 * load(k) + play
            };
            let gauges: Vec<f64> = (0..12_000).map(gauge).collect();
            let recording = Recording::new(
                format!("r{at}"),
                Source::Simulated,
                (0..12_000).map(|k| f64::from(k) / 400.0).collect(),
                vec!["S1".to_owned()],
                gauges,
                vec![Axis::Fz],
                (0..12_000).map(|k| 10.0 * load(k)).collect(),
            );
            set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
        }
        let set = Arc::new(set);
        let request = |history_rate_hz| {
            let settings = FitSettings { history_rate_hz, ..FitSettings::default() };
            Request::fit(Arc::clone(&set), settings)
        };
        let (progress, chosen) = (Progress::default(), request(None));
        let trained = train(&chosen, &progress, &mut |_| {}).unwrap();
        let shown = analyse(&chosen, &progress).unwrap().calibration;
        assert_eq!(shown.history_step_secs, trained.history_step_secs);
        assert_eq!(shown.quality.compensated, trained.quality.compensated);
        assert!(!Footprint::of(&trained).is_large());
        let again = train(&request(trained.settings().history_rate_hz), &progress, &mut |_| {});
        assert_eq!(again.unwrap().quality.compensated, trained.quality.compensated);
        let whole = train(&request(Some(0.0)), &progress, &mut |_| {}).unwrap();
        assert!(Footprint::of(&whole).is_large());
        assert!(whole.history_step_secs < trained.history_step_secs);
    }
}
