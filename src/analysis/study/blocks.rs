//! Play radii and creep time constants by cross-validation: every candidate's columns in one pass, any choice of them from
//! the sums.

use rayon::prelude::*;
use serde::Serialize;

use super::{Study, check_parts};
use crate::analysis::AnalysisError;
use crate::analysis::fit::Sums;
use crate::calibration::{Terms, past_samples};
use crate::evaluation::left_out::LeftOut;
use crate::evaluation::threshold_study::{Measure, NoSuggestion, paired};
use crate::features::{Column, ColumnKind, Design, FeatureSettings, History};
use crate::progress::Progress;
use crate::recording::{Recording, Role};

/// A block with a list of numbers that nobody knows beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HistoryBlock {
    /// Play operators: radii in standard deviations of the gauge.
    Play,
    /// Creep: time constants (s).
    Creep,
}

impl HistoryBlock {
    /// Whether the block brings this column.
    fn has(self, column: Column) -> bool {
        let Column::Past { history, .. } = column else {
            return false;
        };
        match self {
            Self::Play => matches!(history, History::Play(_)),
            Self::Creep => matches!(history, History::Creep(_)),
        }
    }
}

/// Radii that are tried: each about 1.46 times the one before, from hardly any play to a gauge's whole range.
const RADII: [f64; 12] = [
    0.05, 0.073, 0.11, 0.16, 0.23, 0.33, 0.49, 0.71, 1.0, 1.5, 2.2, 3.2,
];
/// Lists of radii have from three to eight of them, evenly spaced in the list above.
const LIST_LENGTHS: std::ops::RangeInclusive<usize> = 3..=8;
/// Time constants that are tried, as far as the recordings can show them (s).
const TAUS_SECS: [f64; 12] = [
    0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0,
];
/// At most so many time constants are taken.
const MOST_TAUS: usize = 3;

/// A list for one block.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BlockSuggestion {
    /// Which block.
    pub block: HistoryBlock,
    /// The list, rising; empty if none predicts left-out parts better than no such block, beyond one standard error.
    pub values: Vec<f64>,
    /// The cross-validation measure with it.
    pub left_out: f64,
    /// The cross-validation measure without the block, everything else unchanged.
    pub left_out_without: f64,
    /// How many lists were tried.
    pub n_tried: usize,
}

/// Any choice of the candidates, scored.
struct Bench {
    sums: Sums,
    kinds: Vec<ColumnKind>,
    /// The conventional map, which the targets lack.
    known: Vec<f64>,
    /// The columns that are not the block's.
    others: Vec<usize>,
    /// The columns of each candidate.
    own: Vec<Vec<usize>>,
    weights: Vec<f64>,
    ridge: crate::calibration::RidgeChoice,
    part_samples: Vec<u64>,
}

/// A choice with the squared errors of the left-out parts.
#[derive(Clone)]
struct Tried {
    chosen: Vec<usize>,
    squares: Vec<f64>,
    mean_square: f64,
}

impl Study {
    /// The list for a block that left-out parts are predicted best with, the others staying as the settings say.
    ///
    /// Radii: every evenly spaced list of three to eight out of twelve; of those within one standard error of the best,
    /// the shortest. Time constants: the best one first, then the best beside it, up to three, as long as each gains more
    /// than one standard error. Standard errors are of [`paired`] differences.
    ///
    /// # Errors
    /// [`AnalysisError`] where nothing can be left out, no axis counts, or somebody asked to stop.
    pub fn suggest_block(
        &self,
        block: HistoryBlock,
        measure: Measure,
        progress: &Progress,
    ) -> Result<BlockSuggestion, AnalysisError> {
        let candidates = self.candidates(block);
        let bench = Bench::lay(self, block, &candidates, measure)?;
        progress.check()?;
        let without = bench.try_one(Vec::new())?;
        let (best, n_tried) = match block {
            HistoryBlock::Play => bench.shortest_good_list(candidates.len(), &without, progress)?,
            HistoryBlock::Creep => bench.one_after_another(candidates.len(), &without, progress)?,
        };
        Ok(BlockSuggestion {
            block,
            values: best.chosen.iter().map(|at| candidates[*at]).collect(),
            left_out: best.mean_square.sqrt(),
            left_out_without: without.mean_square.sqrt(),
            n_tried,
        })
    }

    /// What these recordings can show, and as many as there is room for columns.
    fn candidates(&self, block: HistoryBlock) -> Vec<f64> {
        let mut candidates = match block {
            HistoryBlock::Play => RADII.to_vec(),
            HistoryBlock::Creep => {
                let training = || {
                    let entries = self.data.entries.iter();
                    let own = entries.filter(|entry| entry.role == Role::Train);
                    own.map(|entry| &*entry.recording)
                };
                let step = training()
                    .filter_map(Recording::rate_hz)
                    .map(|rate| 1.0 / rate);
                let shortest = step.fold(f64::INFINITY, f64::min);
                let longest = training().map(Recording::duration_secs).fold(0.0, f64::max);
                let visible = |tau: &f64| *tau >= shortest && *tau <= longest;
                TAUS_SECS.into_iter().filter(visible).collect()
            }
        };
        let n_gauges = self.blank.gauges.len();
        let fits = |candidates: &[f64]| {
            let features = with_values(&self.blank.features, block, candidates);
            features.check_columns(n_gauges).is_ok()
        };
        // Every second one goes, so that the range stays.
        while candidates.len() > 1 && !fits(&candidates) {
            candidates = candidates.into_iter().step_by(2).collect();
        }
        candidates
    }
}

/// The settings with this list for the block.
fn with_values(features: &FeatureSettings, block: HistoryBlock, values: &[f64]) -> FeatureSettings {
    let mut features = features.clone();
    match block {
        HistoryBlock::Play => features.play_radii = values.to_vec(),
        HistoryBlock::Creep => features.creep_secs = values.to_vec(),
    }
    features
}

impl Bench {
    fn lay(
        study: &Study,
        block: HistoryBlock,
        candidates: &[f64],
        measure: Measure,
    ) -> Result<Self, AnalysisError> {
        let (data, blank) = (&study.data, &study.blank);
        let weights = measure
            .weights(&study.scale())
            .ok_or(NoSuggestion::NoAxis)?;
        let features = with_values(&blank.features, block, candidates);
        features
            .check_columns(blank.gauges.len())
            .map_err(crate::calibration::SettingsError::from)?;
        let past: Vec<_> = (data.entries.par_iter().zip(&*study.paths))
            .map(|(entry, path)| past_samples(&features, path, &entry.recording))
            .collect();
        let design = Design {
            features,
            ..blank.design()
        };
        let sums = data.sums(&design, &past, blank.axes.len());
        let others = design.where_column(|column| !block.has(column));
        let own = design.where_column(|column| block.has(column));
        let own = own.chunks(design.n_gauges()).map(<[usize]>::to_vec);
        let part_samples: Vec<u64> = sums.parts.iter().map(|part| part.n_samples()).collect();
        let kinds = design.kinds();
        let kept = others.iter().map(|column| kinds[*column]);
        check_parts(&part_samples, kept, study.settings.ridge)?;
        Ok(Self {
            sums,
            others,
            own: own.collect(),
            weights,
            ridge: study.settings.ridge,
            part_samples,
            kinds,
            known: data.map.standardised(&design),
        })
    }

    fn try_one(&self, chosen: Vec<usize>) -> Result<Tried, NoSuggestion> {
        let own = chosen.iter().flat_map(|at| &self.own[*at]);
        let train = &self.sums.train;
        let used: Vec<usize> = self.others.iter().chain(own).copied().collect();
        let left_out = LeftOut {
            total: train,
            parts: &self.sums.parts,
            terms: Terms {
                used: &used,
                kinds: &self.kinds,
                known: &self.known,
            },
        };
        let (_, squares) = left_out.with_ridge(self.ridge);
        let squares = squares.ok_or(NoSuggestion::NothingLeftOut)?;
        let weights = self.weights.iter().cycle();
        let sum: f64 = squares
            .iter()
            .zip(weights)
            .map(|(square, w)| w * square)
            .sum();
        Ok(Tried {
            chosen,
            squares,
            mean_square: sum / train.n_samples().max(1) as f64,
        })
    }

    fn try_all(
        &self,
        lists: Vec<Vec<usize>>,
        progress: &Progress,
    ) -> Result<Vec<Tried>, AnalysisError> {
        progress.add_total(lists.len() as u64);
        let tried = lists.into_par_iter().map(|list| {
            progress.check()?;
            let tried = self.try_one(list)?;
            progress.advance(1);
            Ok(tried)
        });
        tried.collect()
    }

    /// Whether `one` is worse than `other` by more than luck.
    fn is_worse(&self, one: &Tried, other: &Tried) -> bool {
        paired(
            &one.squares,
            &other.squares,
            &self.part_samples,
            &self.weights,
        )
        .is_some_and(|paired| !paired.is_within_one_standard_error())
    }

    fn shortest_good_list(
        &self,
        n_candidates: usize,
        without: &Tried,
        progress: &Progress,
    ) -> Result<(Tried, usize), AnalysisError> {
        let tried = self.try_all(even_lists(n_candidates), progress)?;
        let n_tried = tried.len();
        let least = |a: &&Tried, b: &&Tried| a.mean_square.total_cmp(&b.mean_square);
        let Some(best) = tried.iter().min_by(least) else {
            return Ok((without.clone(), 0));
        };
        let good = tried.iter().filter(|one| !self.is_worse(one, best));
        let shortest = good.min_by(|a, b| {
            let lengths = a.chosen.len().cmp(&b.chosen.len());
            lengths.then(a.mean_square.total_cmp(&b.mean_square))
        });
        let taken = shortest.filter(|taken| self.is_worse(without, taken));
        Ok((taken.unwrap_or(without).clone(), n_tried))
    }

    fn one_after_another(
        &self,
        n_candidates: usize,
        without: &Tried,
        progress: &Progress,
    ) -> Result<(Tried, usize), AnalysisError> {
        let mut taken = without.clone();
        let mut n_tried = 0;
        while taken.chosen.len() < MOST_TAUS {
            let left = (0..n_candidates).filter(|at| !taken.chosen.contains(at));
            let lists = left
                .map(|at| {
                    let mut list = [&taken.chosen[..], &[at]].concat();
                    list.sort_unstable();
                    list
                })
                .collect();
            let tried = self.try_all(lists, progress)?;
            n_tried += tried.len();
            let best = (tried.into_iter()).min_by(|a, b| a.mean_square.total_cmp(&b.mean_square));
            match best {
                Some(best) if self.is_worse(&taken, &best) => taken = best,
                _ => break,
            }
        }
        Ok((taken, n_tried))
    }
}

/// Every list of evenly spaced positions.
fn even_lists(n: usize) -> Vec<Vec<usize>> {
    let mut lists = Vec::new();
    for length in LIST_LENGTHS {
        for stride in 1.. {
            let span = (length - 1) * stride;
            if span >= n {
                break;
            }
            for start in 0..n - span {
                lists.push((start..=start + span).step_by(stride).collect());
            }
        }
    }
    lists
}
