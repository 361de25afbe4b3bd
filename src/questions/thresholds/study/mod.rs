//! Chooses the thresholds of a look-back, and the values of other feature blocks. A [`Study`] is prepared once, and then
//! answers each request with one pass over the samples.
//!
//! In the map of errors, one search for earlier samples and one pass over the samples give the sums of each F_th. The errors
//! at all t_th follow from these sums.
//!
//! Guarantees: suggestions depend on the training recordings alone. Test recordings are only scored.

mod blocks;

use std::fmt;
use std::sync::{Arc, Mutex};

use rayon::prelude::*;
use serde::Serialize;

use crate::{
    calibration::{
        AgedSums, Calibration, FitSettings, LinearMap, NoCrossValidation, NormalEquations, Past,
        Ridge, RidgeChoice, Scores, Terms, ThresholdAges, aged_sums, fit, fit_targets,
    },
    features::{ColumnKind, Design, Thresholds},
    finding::Finding,
    panicked::locked,
    progress::{Cancelled, Progress},
    questions::{
        dataset::{Dataset, Key, Paths, fit::Sums},
        error::AnalysisError,
        request::Request,
        thresholds::map::{MeasureScale, ThresholdGrid, ThresholdMap},
    },
    recording::{Entry, Role},
    scoring::{
        left_out::{LeftOut, summed_by_target, too_short},
        mean_hysteresis::{HysteresisRun, MeanHysteresis, mean_hysteresis},
        metrics,
        numbers::significant,
    },
};

pub(crate) use crate::questions::thresholds::study::blocks::BlockSuggestion;

pub use crate::questions::thresholds::study::blocks::HistoryBlock;

/// Number of histogram bins for the ages of earlier samples up to t_th. Ages above t_th have as many bins.
const AGE_BINS: usize = 30;

/// Recordings and settings of a fit, prepared for studies of the look-back's thresholds.
#[derive(Debug)]
pub struct Study {
    pub(crate) data: Arc<Dataset>,
    pub(crate) paths: Paths,
    /// Calibration without coefficients: axes, full scales and gauge scales.
    pub(crate) blank: Calibration,
    pub(crate) settings: FitSettings,
}

impl Study {
    /// Fits the conventional calibration, and prepares the look-back's search for earlier samples.
    ///
    /// # Errors
    /// [`AnalysisError`] if the recordings cannot be fitted, or the work was cancelled.
    pub fn prepare(request: &Request, progress: &Progress) -> Result<Self, AnalysisError> {
        let settings = request.settings.clone();
        settings.validate()?;
        if request.recordings.entries().is_empty() {
            return Err(AnalysisError::NoRecordings);
        }
        if request.recordings.is_static() {
            return Err(AnalysisError::NoTimes);
        }
        let key = Key { calibration: None, ..request.key() };
        // The caller's progress does not count the steps of this preparation.
        let data = request.datasets.get(&key, &progress.part())?;
        let blank = data.blank_calibration(&settings)?;
        let paths = data.paths(&blank);
        progress.check()?;
        Ok(Self { data, paths, blank, settings })
    }

    /// Returns a finding if the recordings have a time lag that a look-back would describe as hysteresis.
    pub fn lag(&self, progress: &Progress) -> Result<Option<Finding>, Cancelled> {
        let mut features = self.settings.features.clone();
        features.look_backs = vec![Thresholds::default_for(features.distance)];
        Ok(self.data.lag_as_hysteresis(&features, progress)?.cloned())
    }

    /// Returns the axes whose errors are measured, with their full scales.
    pub fn scale(&self) -> MeasureScale {
        MeasureScale { axes: self.blank.axes.clone(), full_scale: self.blank.full_scale.clone() }
    }

    /// Returns the largest full scale of the axes whose loads are compared with the force threshold F_th, in the unit of
    /// F_th.
    pub fn largest_distance(&self) -> f64 {
        let weights = self.blank.distance_weights();
        let scaled = weights.iter().zip(&self.blank.full_scale);
        scaled.map(|(weight, full)| weight * full).fold(0.0, f64::max)
    }

    /// Returns the thresholds of the first look-back in the settings, or the default thresholds.
    pub fn present_thresholds(&self) -> Thresholds {
        let first = self.settings.features.look_backs.first();
        first.copied().unwrap_or_else(|| Thresholds::default_for(self.blank.features.distance))
    }

    /// Returns the ages of the earlier samples that a look-back with these thresholds finds in the training recordings.
    pub fn past_ages(&self, thresholds: Thresholds) -> PastAges {
        let unlimited = Thresholds { t_th_secs: f64::INFINITY, ..thresholds };
        let mut past_ages = PastAges::new(thresholds.t_th_secs, AGE_BINS);
        for (entry, path) in self.data.entries.iter().zip(&*self.paths) {
            if entry.role == Role::Train {
                let times = entry.recording.times();
                let past = path.past_samples(times, unlimited);
                past_ages.count(times, &past, thresholds.t_th_secs);
            }
        }
        past_ages
    }

    /// Returns the mean hysteresis of the training recordings.
    pub fn mean_hysteresis(&self) -> MeanHysteresis {
        let training = self.data.entries.iter().enumerate();
        let training: Vec<_> = training
            .filter(|(_, entry)| entry.role == Role::Train)
            .map(|(at, entry)| {
                let loads = self.data.present_loads(at);
                (entry.recording.loads(), move |axis| loads.column(axis))
            })
            .collect();
        let runs: Vec<HysteresisRun<'_>> = (training.iter())
            .map(|(reference, conventional)| HysteresisRun { reference, conventional })
            .collect();
        mean_hysteresis(&runs, &self.blank.axes, &self.blank.distance_weights())
    }
}

/// Maximum memory for the sums of all map rows that are computed at the same time (bytes).
const MAX_BYTES: usize = 2 << 30;
/// Number of map rows (one for each F_th) that are computed at the same time.
const AT_ONCE: usize = 2;

struct Rows<'a> {
    study: &'a Study,
    grid: &'a ThresholdGrid,
    design: Design,
    /// Earlier samples that the look-backs find in each recording, with a first look-back that finds none.
    unmoved: Vec<Past>,
    scorer: Scorer,
}

impl Study {
    /// Computes the errors at every pair of the grid for the first look-back, with all other settings unchanged. If the
    /// settings have no look-back, one is added.
    ///
    /// Rows (one for each F_th) are computed from coarse to fine. Rows of `begun`, an incomplete map of the same grid, are
    /// not computed again. `show` receives the map before the first row and after each row, from several threads. An
    /// automatic ridge is chosen anew at each pair, as in a fit. `progress` counts rows.
    ///
    /// # Errors
    /// [`AnalysisError`] if the training recordings are too short for cross-validation, the map would not fit in memory, or
    /// the work was cancelled.
    pub fn threshold_map(
        &self,
        begun: Option<&ThresholdMap>,
        grid: &ThresholdGrid,
        progress: &Progress,
        show: &(dyn Fn(&ThresholdMap) + Sync),
    ) -> Result<ThresholdMap, AnalysisError> {
        progress.add_total(grid.f_ths.len() as u64);
        let rows = Rows::prepare(self, grid, progress)?;
        let scorer = &rows.scorer;
        let mut map = ThresholdMap::new(
            grid.clone(),
            self.blank.features.distance,
            self.scale(),
            scorer.conventional.clone(),
            scorer.part_samples(),
        );
        map.n_test = scorer.sums.test.n_samples();
        map.cross_validation = self.data.cross_validation();
        if let Some(begun) = begun.filter(|begun| begun.grid == *grid) {
            map.clone_from(begun);
        }
        progress.advance(map.n_rows_done() as u64);
        show(&map);
        for level in grid.coarse_to_fine() {
            let missing = level.into_iter().filter(|at| map.rows[*at].is_none());
            let missing: Vec<usize> = missing.collect();
            let so_far = Mutex::new(&mut map);
            missing.into_par_iter().try_for_each(|f_at| {
                let points = rows.row(grid.f_ths[f_at], progress)?;
                let mut map = locked(&so_far);
                map.set_row(f_at, points);
                show(&map);
                progress.advance(1);
                Ok::<_, Cancelled>(())
            })?;
        }
        Ok(map)
    }

    /// Checks that enough samples remain for the fit when cross-validation leaves out a part. An automatic ridge counts as
    /// zero, because the strength zero may be chosen.
    pub(crate) fn check_parts(
        &self,
        part_samples: &[u64],
        kinds: impl Iterator<Item = ColumnKind>,
    ) -> Result<(), NoCrossValidation> {
        let strength = match self.settings.ridge {
            RidgeChoice::Strength(strength) => strength,
            RidgeChoice::Auto | RidgeChoice::ByBlock => 0.0,
        };
        match too_short(part_samples.iter().copied(), kinds, &[strength]) {
            Some((samples, columns)) => Err(NoCrossValidation::FewSamplesFor { samples, columns }),
            None => Ok(()),
        }
    }
}

/// Returns true if the recording is used: it has a reference load, and its role is train or test.
fn takes_part(entry: &Entry) -> bool {
    entry.role != Role::Off && entry.recording.has_reference()
}

impl<'a> Rows<'a> {
    fn prepare(
        study: &'a Study,
        grid: &'a ThresholdGrid,
        progress: &Progress,
    ) -> Result<Self, AnalysisError> {
        let (data, blank) = (&study.data, &study.blank);
        let mut design = blank.design();
        if design.features.look_backs.is_empty() {
            design.features.look_backs = vec![study.present_thresholds()];
        }
        design.features.check_columns(blank.gauges.len())?;
        let n_axes = blank.axes.len();
        let lists = data.entries.iter().zip(&data.folds.pieces);
        let n_lists: usize =
            lists.filter(|(entry, _)| takes_part(entry)).map(|(_, pieces)| pieces.len()).sum();
        let n_t = grid.t_ths_secs.len();
        let bytes = AT_ONCE * n_lists * AgedSums::size_bytes(&design, n_axes, n_t);
        if bytes > MAX_BYTES {
            return Err(AnalysisError::MapTooLarge {
                t_ths: n_t,
                columns: design.n_columns(),
                parts: n_lists,
            });
        }
        let unmoved = (data.entries.par_iter().zip(&*study.paths)).map(|(entry, path)| {
            progress.check()?;
            let times = entry.recording.times();
            let further = design.features.look_backs[1..].iter();
            let further =
                further.map(|thresholds| path.past_samples_until(times, *thresholds, progress));
            Ok(std::iter::once((0..times.len() as u32).collect()).chain(further).collect())
        });
        let unmoved = unmoved.collect::<Result<Vec<Past>, Cancelled>>()?;
        progress.check()?;
        let mut sums = data.sums(&design, &unmoved, n_axes, progress);
        progress.check()?;
        let recordings = data.recordings_left_out(&std::mem::take(&mut sums.of_recordings));
        let scorer = Scorer::new(&design, &data.map, sums, recordings, study.settings.ridge);
        study.check_parts(&scorer.part_samples(), design.kinds().into_iter())?;
        Ok(Self { study, grid, design, unmoved, scorer })
    }

    fn row(&self, f_th: f64, progress: &Progress) -> Result<Vec<PointScores>, Cancelled> {
        let data = &self.study.data;
        let t_ths_secs = &self.grid.t_ths_secs;
        let longest = *t_ths_secs.last().expect("a threshold grid has at least one t_th");
        let thresholds = Thresholds { f_th, t_th_secs: longest };
        let aged: Vec<[Vec<AgedSums>; 2]> = (data.entries.par_iter().enumerate())
            .map(|(at, entry)| {
                progress.check()?;
                if !takes_part(entry) {
                    return Ok([Vec::new(), Vec::new()]);
                }
                let path = &self.study.paths[at];
                let past = path.past_samples_until(entry.recording.times(), thresholds, progress);
                progress.check()?;
                let ages =
                    ThresholdAges { past: &past, further: &self.unmoved[at][1..], t_ths_secs };
                let (loads, pieces) = (data.present_loads(at), &data.folds.pieces[at]);
                let aged =
                    |is_cold| aged_sums(&self.design, loads, ages, pieces, is_cold, progress);
                let has_cold_parts = self.scorer.sums.cold.is_some() && entry.role == Role::Train;
                let both = [aged(false), if has_cold_parts { aged(true) } else { Vec::new() }];
                progress.check()?;
                Ok(both)
            })
            .collect::<Result<_, Cancelled>>()?;
        let (mut row, mut n_training) = (AgedRow::default(), 0);
        for ((entry, pieces), [aged, cold]) in data.entries.iter().zip(&data.folds.pieces).zip(aged)
        {
            match entry.role {
                Role::Train => {
                    let parts = pieces.iter().map(|piece| piece.fold);
                    row.cold.extend(parts.clone().zip(cold));
                    row.train.extend(parts.zip(aged).map(|(part, aged)| (part, n_training, aged)));
                    n_training += 1;
                }
                Role::Test => row.test.extend(aged),
                Role::Off => {}
            }
        }
        self.scorer.row(&row, t_ths_secs.len(), progress)
    }
}

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
    pub train: Vec<(usize, usize, AgedSums)>,
    /// Changes of the parts whose history starts anew, with the number of the part; empty if the parts are whole recordings.
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
        let Sums { train, parts, .. } = &sums;
        // The targets are the residuals of the conventional calibration, so zero coefficients stand for that calibration.
        let none = vec![0.0; train.n_features() * train.n_targets()];
        let left_out = sums.left_out(terms);
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
                for (part, recording, aged) in &row.train {
                    if let Some(recordings) = &mut recordings {
                        aged.add_class_to(class, &mut recordings[*recording]);
                    }
                    if sums.cold.is_none() {
                        aged.add_class_to(class, &mut sums.parts[*part]);
                    }
                    aged.add_class_to(class, &mut sums.train);
                }
                for (part, aged) in &row.cold {
                    aged.add_class_to(class, &mut sums.parts[*part]);
                    sums.cold.iter_mut().for_each(|all| aged.add_class_to(class, all));
                }
                for aged in &row.test {
                    aged.add_class_to(class, &mut sums.test);
                }
                Ok(self.point(&sums, recordings.as_deref()))
            })
            .collect()
    }

    fn point(&self, sums: &Sums, recordings: Option<&[NormalEquations]>) -> PointScores {
        let Sums { train, parts, .. } = sums;
        let all: Vec<usize> = (0..train.n_features()).collect();
        let used = train.present_among(&all);
        if !used.iter().any(|&column| self.kinds[column] == ColumnKind::Appended) {
            return self.conventional.clone();
        }
        let terms = Terms { used: &used, kinds: &self.kinds, known: &self.known };
        let left_out = sums.left_out(terms);
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

/// Upper end of the histogram of ages, as a multiple of the time threshold t_th.
const REACH: usize = 2;

/// Bin of a histogram of the ages of earlier samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AgeBin {
    /// Lower limit of the ages in the bin (s). Only the first bin includes its lower limit.
    pub from_secs: f64,
    /// Upper limit of the ages in the bin, which the bin includes (s).
    pub to_secs: f64,
    pub count: u64,
}

/// Ages of the earlier samples that a look-back finds with one pair of thresholds F_th and t_th.
///
/// Each sample is in one of three classes:
/// * the look-back finds an earlier sample;
/// * the load differed by F_th, but longer ago than t_th;
/// * the load has not yet differed by F_th since the start of the recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PastAges {
    pub n_samples: u64,
    pub n_found: u64,
    /// Number of samples whose earlier sample is older than t_th, so that the look-back does not use it.
    pub n_cut_off: u64,
    /// Histogram of the ages from zero to twice t_th. A border between bins is at t_th. Empty if t_th is zero.
    pub ages: Vec<AgeBin>,
    /// Number of samples whose earlier sample is older than twice t_th, where the histogram ends.
    pub n_beyond: u64,
}

impl PastAges {
    /// Creates a histogram with counts of zero: `bins` bins up to t_th, and as many bins above t_th.
    pub fn new(t_th_secs: f64, bins: usize) -> Self {
        let edge = |at: usize| t_th_secs * at as f64 / bins as f64;
        let n_bins = if t_th_secs > 0.0 { REACH * bins } else { 0 };
        Self {
            ages: (0..n_bins)
                .map(|at| AgeBin { from_secs: edge(at), to_secs: edge(at + 1), count: 0 })
                .collect(),
            ..Self::default()
        }
    }

    /// Adds the samples of one recording to the counts. For each sample, `past` contains the index of the earlier sample that
    /// a look-back without the limit t_th finds. If it finds none, this is the sample's own index.
    pub fn count(&mut self, times: &[f64], past: &[u32], t_th_secs: f64) {
        self.n_samples += times.len() as u64;
        for (k, &past) in past.iter().enumerate() {
            if past as usize == k {
                continue;
            }
            let age = times[k] - times[past as usize];
            if age <= t_th_secs {
                self.n_found += 1;
            } else {
                self.n_cut_off += 1;
            }
            let bin = self.ages.partition_point(|bin| bin.to_secs < age);
            match self.ages.get_mut(bin) {
                Some(bin) => bin.count += 1,
                None => self.n_beyond += 1,
            }
        }
    }

    fn share(&self, count: u64) -> f64 {
        count as f64 / self.n_samples.max(1) as f64
    }

    /// Returns the age that the share `share` of the found earlier samples does not exceed, rounded up to the end of a bin
    /// (s). `None` if no earlier sample is found.
    pub fn age_quantile_secs(&self, share: f64) -> Option<f64> {
        let wanted = share * self.n_found as f64;
        let mut counted = 0;
        let mut bins = self.ages.iter().filter(|_| self.n_found > 0);
        bins.find(|bin| {
            counted += bin.count;
            counted as f64 >= wanted && counted > 0
        })
        .map(|bin| bin.to_secs)
    }
}

impl fmt::Display for PastAges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |count| significant(100.0 * self.share(count), 3);
        write!(f, "{} % of the training samples find an earlier sample", percent(self.n_found))?;
        let ages = [0.5, 0.95].map(|share| self.age_quantile_secs(share));
        if let [Some(half), Some(most)] = ages.map(|age| Some(significant(age?, 3))) {
            write!(f, " (half of these are at most {half} s old, 95 % at most {most} s)")?;
        }
        let beyond = percent(self.n_cut_off);
        write!(f, "; for {beyond} % the earlier sample is older than t_th")
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod past_ages_tests {
    use crate::questions::thresholds::study::*;

    /// The first sample has no earlier sample, and the other samples have earlier samples of age 1, 2, 3 and 7 s. t_th is 2
    /// s, in two bins of one second.
    #[test]
    fn every_sample_is_found_cut_off_or_never_differed() {
        let mut past_ages = PastAges::new(2.0, 2);
        past_ages.count(&[0.0, 1.0, 2.0, 3.0, 7.0], &[0, 0, 0, 0, 0], 2.0);
        assert_eq!((past_ages.n_samples, past_ages.n_found, past_ages.n_cut_off), (5, 2, 2));
        let counts: Vec<u64> = past_ages.ages.iter().map(|bin| bin.count).collect();
        assert_eq!((counts, past_ages.n_beyond), (vec![1, 1, 1, 0], 1));
        let shares = [past_ages.n_found, past_ages.n_cut_off].map(|n| past_ages.share(n));
        assert_eq!(shares, [0.4, 0.4]);
        assert_eq!(past_ages.age_quantile_secs(0.5), Some(1.0));
        assert_eq!(past_ages.age_quantile_secs(1.0), Some(2.0));
    }

    #[test]
    fn a_time_threshold_of_zero_cuts_all_off() {
        let mut past_ages = PastAges::new(0.0, 4);
        past_ages.count(&[0.0, 1.0], &[0, 0], 0.0);
        assert_eq!((past_ages.n_found, past_ages.n_cut_off, past_ages.n_beyond), (0, 1, 1));
        assert_eq!(past_ages.age_quantile_secs(0.5), None);
        assert_eq!(PastAges::default().share(0), 0.0);
    }
}
