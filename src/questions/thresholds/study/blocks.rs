//! Chooses the values of a feature block, such as its time constants. One pass over the samples sums the columns of all
//! candidate values. The error with any of these values, or several of them, follows from the sums.

use std::ops::RangeInclusive;

use rayon::prelude::*;
use serde::{Serialize, Serializer};

use crate::{
    calibration::{
        ErrorBlocks, NEARLY, NoCrossValidation, RidgeChoice, Terms, past_samples, weighed,
    },
    features::{Block, ColumnKind, Design, FeatureSettings, Lists, Search, Unit},
    progress::Progress,
    questions::{
        dataset::{MOST_UNKNOWN, Travels, fit::Sums},
        error::AnalysisError,
        thresholds::{map::Measure, study::Study},
    },
};

/// Shortest time that is tried as a value, as a share of the sample interval.
const SHORTEST_TIME: f64 = 0.25;

/// Feature block (such as play or creep) whose values can be chosen by a [`search`](Block::search).
pub type HistoryBlock = &'static dyn Block;

fn by_option<S: Serializer>(block: &HistoryBlock, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(block.setting().option)
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BlockSuggestion {
    #[serde(serialize_with = "by_option")]
    pub block: HistoryBlock,
    /// Chosen values of the feature block, ascending. Empty if no list of values reduces the cross-validation error with 90 %
    /// confidence.
    pub values: Vec<f64>,
    /// Cross-validation error with the chosen values of the feature block.
    pub left_out: f64,
    /// Cross-validation error without the feature block, with all other settings unchanged.
    pub left_out_without: f64,
    /// Number of lists of values that were tried.
    pub n_tried: usize,
}

/// Sums over the columns of all candidate values. The error of each list of values follows from these sums.
struct Bench {
    sums: Sums,
    kinds: Vec<ColumnKind>,
    /// Coefficients of the conventional calibration, whose residuals are the targets of the fit.
    known: Vec<f64>,
    /// Indices of the feature columns that do not belong to the block.
    others: Vec<usize>,
    /// Indices of the feature columns of each candidate value.
    by_value: Vec<Vec<usize>>,
    weights: Vec<f64>,
    ridge: RidgeChoice,
    parts: ErrorBlocks,
}

#[derive(Clone)]
struct Tried {
    /// Indices of the tried values in the list of candidate values.
    chosen: Vec<usize>,
    /// Sum of squared errors of each part that cross-validation leaves out, weighted and added over all axes.
    squares: Vec<f64>,
}

impl Tried {
    fn sum(&self) -> f64 {
        self.squares.iter().sum()
    }
}

impl Study {
    /// Chooses the list of values with the lowest cross-validation error, with all other settings unchanged. The block's
    /// [`Lists`] define which lists are tried, and [`ErrorBlocks`] compares their errors.
    ///
    /// # Errors
    /// [`AnalysisError`] if the recordings are too short for cross-validation, if the measure has no axis, or after a
    /// cancellation.
    ///
    /// # Panics
    /// If the block has no [`search`](Block::search).
    pub fn suggest_block(
        &self,
        block: HistoryBlock,
        measure: Measure,
        progress: &Progress,
    ) -> Result<BlockSuggestion, AnalysisError> {
        let search =
            block.search().expect("a feature block is only offered if its values can be searched");
        let candidates = self.candidates(block, search);
        let bench = Bench::prepare(self, block, &candidates, measure, progress)?;
        progress.check()?;
        let without = bench.try_one(Vec::new())?;
        let (best, n_tried) = match search.lists {
            Lists::Even { min, max } => {
                let lists = even_lists(candidates.len(), min..=max);
                bench.shortest_good_list(lists, &without, progress)?
            }
            Lists::OneByOne(max) => {
                bench.one_after_another(candidates.len(), max, &without, progress)?
            }
        };
        Ok(BlockSuggestion {
            block,
            values: best.chosen.iter().map(|at| candidates[*at]).collect(),
            left_out: bench.measure(&best),
            left_out_without: bench.measure(&without),
            n_tried,
        })
    }

    /// Returns the values of a block to try for these recordings. They are thinned until their columns fit into the maximum
    /// number of columns.
    ///
    /// Times are between a quarter of the sample interval and the length of the longest recording. Time lags may be shorter
    /// than the interval, because gauges are interpolated between samples. A radius is only tried if the state of its play
    /// operator is known in 90 % of each group's samples.
    pub(crate) fn candidates(&self, block: HistoryBlock, search: Search) -> Vec<f64> {
        let mut candidates = search.candidates.to_vec();
        if block.setting().unit == Unit::SECONDS {
            let training = self.data.training();
            let step =
                training.iter().filter_map(|recording| recording.rate_hz()).map(|rate| 1.0 / rate);
            let shortest = step.fold(f64::INFINITY, f64::min);
            let longest =
                training.iter().map(|recording| recording.duration_secs()).fold(0.0, f64::max);
            candidates.retain(|secs| *secs >= SHORTEST_TIME * shortest && *secs <= longest);
        }
        if candidates.iter().any(|value| block.travel(*value) > 0.0) {
            let travels = Travels::of(&self.data, &self.blank.gauge_scale);
            candidates.retain(|value| travels.unknown(block.travel(*value)) <= MOST_UNKNOWN);
        }
        let n_gauges = self.blank.gauges.len();
        let fits = |candidates: &[f64]| {
            let features = with_values(&self.blank.features, block, candidates);
            features.check_columns(n_gauges).is_ok()
        };
        // Every second candidate is dropped, so that the candidates still span nearly the same range.
        while candidates.len() > 1 && !fits(&candidates) {
            candidates = candidates.into_iter().step_by(2).collect();
        }
        candidates
    }
}

fn with_values(features: &FeatureSettings, block: HistoryBlock, values: &[f64]) -> FeatureSettings {
    FeatureSettings { blocks: features.blocks.clone().with(block, values), ..features.clone() }
}

impl Bench {
    /// Returns the root mean squared error of the parts that cross-validation leaves out.
    fn measure(&self, tried: &Tried) -> f64 {
        (tried.sum() / self.sums.train.n_samples().max(1) as f64).sqrt()
    }

    fn prepare(
        study: &Study,
        block: HistoryBlock,
        candidates: &[f64],
        measure: Measure,
        progress: &Progress,
    ) -> Result<Self, AnalysisError> {
        let (data, blank) = (&study.data, &study.blank);
        let weights = measure.weights(&study.scale()).ok_or(AnalysisError::NoSuchAxis)?;
        let features = with_values(&blank.features, block, candidates);
        features.check_columns(blank.gauges.len())?;
        let past: Vec<_> = (data.entries.par_iter().zip(&*study.paths))
            .map(|(entry, path)| past_samples(&features, path, &entry.recording, progress))
            .collect();
        let design = Design { features, ..blank.design() };
        let sums = data.sums(&design, &past, blank.axes.len(), progress);
        progress.check()?;
        let by_value = design.sets_of(block);
        let is_other = |at: &usize| by_value.iter().all(|set| !set.contains(at));
        let others: Vec<usize> = design.all().into_iter().filter(is_other).collect();
        let part_samples: Vec<u64> = sums.parts.iter().map(|part| part.n_samples()).collect();
        let kinds = design.kinds();
        let kept = others.iter().map(|column| kinds[*column]);
        study.check_parts(&part_samples, kept)?;
        Ok(Self {
            sums,
            others,
            by_value,
            weights,
            ridge: study.settings.ridge,
            parts: ErrorBlocks::of_parts(&part_samples),
            kinds,
            known: data.map.standardised(&design),
        })
    }

    fn try_one(&self, chosen: Vec<usize>) -> Result<Tried, AnalysisError> {
        let by_value = chosen.iter().flat_map(|at| &self.by_value[*at]);
        let used: Vec<usize> = self.others.iter().chain(by_value).copied().collect();
        let terms = Terms { used: &used, kinds: &self.kinds, known: &self.known };
        let (_, squares) = self.sums.left_out(terms).with_ridge(self.ridge);
        let squares = squares.ok_or(NoCrossValidation::FewSamples)?;
        Ok(Tried { chosen, squares: weighed(&squares, &self.weights) })
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

    /// Tries all lists of values. Returns the shortest list whose error is near the lowest error, and the number of tried
    /// lists. Returns `without`, the empty list, if no list reduces the error with 90 % confidence.
    fn shortest_good_list(
        &self,
        lists: Vec<Vec<usize>>,
        without: &Tried,
        progress: &Progress,
    ) -> Result<(Tried, usize), AnalysisError> {
        let mut tried = self.try_all(lists, progress)?;
        let n_tried = tried.len();
        tried.sort_by(|a, b| {
            let lengths = a.chosen.len().cmp(&b.chosen.len());
            lengths.then(a.sum().total_cmp(&b.sum()))
        });
        tried.insert(0, without.clone());
        let found = self.parts.choose(tried.len(), NEARLY, |at| &tried[at].squares);
        Ok((tried.swap_remove(found.smallest), n_tried))
    }

    /// Starts from the empty list `without`, and adds the best further value while this reduces the error with 90 %
    /// confidence. Returns the list, and the number of tried lists.
    fn one_after_another(
        &self,
        n_candidates: usize,
        max: usize,
        without: &Tried,
        progress: &Progress,
    ) -> Result<(Tried, usize), AnalysisError> {
        let mut taken = without.clone();
        let mut n_tried = 0;
        while taken.chosen.len() < max {
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
            let best = (tried.into_iter()).min_by(|a, b| a.sum().total_cmp(&b.sum()));
            match best {
                Some(best) if self.parts.is_below(&best.squares, &taken.squares, 1.0) => {
                    taken = best;
                }
                _ => break,
            }
        }
        Ok((taken, n_tried))
    }
}

/// Returns all lists of evenly spaced indices below `n` that have one of these lengths.
fn even_lists(n: usize, lengths: RangeInclusive<usize>) -> Vec<Vec<usize>> {
    let mut lists = Vec::new();
    for length in lengths {
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
