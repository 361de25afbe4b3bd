//! Computes the map over F_th and t_th: one search and one pass per F_th give the errors at all t_th.

use rayon::prelude::*;

use crate::calibration::{AgedSums, ThresholdAges, aged_sums};
use crate::features::{Design, FeatureSettings, Thresholds};
use crate::progress::{Cancelled, Progress};
use crate::questions::error::AnalysisError;
use crate::questions::errors::fit::Sums;
use crate::questions::thresholds::grid::ThresholdGrid;
use crate::questions::thresholds::map::ThresholdMap;
use crate::questions::thresholds::scorer::{PointScores, Scorer};
use crate::questions::thresholds::study::parts::{check_parts, takes_part};
use crate::questions::thresholds::study::prepared::Study;
use crate::recording::Role;

/// Maximum memory (bytes) for the sums of two F_th, which are computed at the same time.
const MAX_BYTES: usize = 2 << 30;
const AT_ONCE: usize = 2;

#[derive(Clone, Copy, Debug)]
pub enum StudyEvent<'a> {
    /// The map without rows: axes, and the scores of the conventional calibration.
    Begun(&'a ThresholdMap),
    Row {
        /// Position of the F_th.
        f_at: usize,
        /// Scores at each t_th.
        points: &'a [PointScores],
    },
}

struct Rows<'a> {
    study: &'a Study,
    grid: &'a ThresholdGrid,
    design: Design,
    /// Past samples of the other look-backs of each recording.
    further: Vec<Vec<Vec<u32>>>,
    scorer: Scorer,
}

impl Study {
    /// Computes the errors at every pair of the grid for the first look-back, with all other settings unchanged. If the
    /// settings have no look-back, one is added.
    ///
    /// Rows are passed on as they are finished, coarse to fine, from several threads. An automatic ridge is chosen anew at
    /// every pair, as a fit at that pair would. `progress` counts rows.
    ///
    /// # Errors
    /// [`AnalysisError`] if the training recordings are too short to leave a part out, the map would not fit in memory, or
    /// the work was stopped.
    pub fn threshold_map(
        &self,
        grid: &ThresholdGrid,
        progress: &Progress,
        tell: &(dyn Fn(StudyEvent<'_>) + Sync),
    ) -> Result<ThresholdMap, AnalysisError> {
        self.rest_of_map(None, grid, progress, tell)
    }

    /// Continues [`threshold_map`](Self::threshold_map) from a part of the same map. The rows of that part are neither
    /// computed nor passed on again.
    ///
    /// # Errors
    /// See [`threshold_map`](Self::threshold_map).
    pub fn rest_of_map(
        &self,
        begun: Option<&ThresholdMap>,
        grid: &ThresholdGrid,
        progress: &Progress,
        tell: &(dyn Fn(StudyEvent<'_>) + Sync),
    ) -> Result<ThresholdMap, AnalysisError> {
        progress.add_total(grid.f_ths().len() as u64);
        let rows = Rows::prepare(self, grid, progress)?;
        let scorer = &rows.scorer;
        let mut map = ThresholdMap::new(
            grid.clone(),
            self.distance(),
            self.scale(),
            scorer.conventional().clone(),
            scorer.part_samples(),
        );
        map.n_test = scorer.n_test();
        map.cross_validation = self.data.cross_validation();
        if let Some(begun) = begun.filter(|begun| begun.grid == *grid) {
            map.clone_from(begun);
        }
        progress.advance(map.n_rows_done() as u64);
        tell(StudyEvent::Begun(&map));
        for level in grid.coarse_to_fine() {
            let missing: Vec<usize> = level.into_iter().filter(|at| !map.has_row(*at)).collect();
            let done: Vec<_> = missing
                .par_iter()
                .map(|&f_at| {
                    let points = rows.row(grid.f_ths()[f_at], progress)?;
                    let row = StudyEvent::Row { f_at, points: &points };
                    tell(row);
                    progress.advance(1);
                    Ok((f_at, points))
                })
                .collect::<Result<_, Cancelled>>()?;
            for (f_at, points) in done {
                map.set_row(f_at, points);
            }
        }
        Ok(map)
    }
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
        design
            .features
            .check_columns(blank.gauges.len())
            .map_err(crate::calibration::SettingsError::from)?;
        let n_axes = blank.axes.len();
        let lists = data.entries.iter().zip(&data.folds.pieces);
        let n_lists: usize =
            lists.filter(|(entry, _)| takes_part(entry)).map(|(_, pieces)| pieces.len()).sum();
        let n_t = grid.t_ths_secs().len();
        let bytes = AT_ONCE * n_lists * AgedSums::size_bytes(&design, n_axes, n_t);
        if bytes > MAX_BYTES {
            return Err(AnalysisError::MapTooLarge {
                t_ths: n_t,
                columns: design.n_columns(),
                parts: n_lists,
            });
        }
        let further = further_past(study, &design.features, progress)?;
        progress.check()?;
        let unmoved: Vec<Vec<Vec<u32>>> = (data.entries.iter().zip(&further))
            .map(|(entry, further)| {
                let own: Vec<u32> = (0..entry.recording.n_samples() as u32).collect();
                std::iter::once(own).chain(further.iter().cloned()).collect()
            })
            .collect();
        let Sums { parts, cold, test, of_recordings, .. } =
            data.sums(&design, &unmoved, n_axes, progress);
        progress.check()?;
        let scorer = Scorer::new(&design, &data.map, parts, cold, test, study.settings.ridge)
            .with_ridge_by(data.recordings_left_out(&of_recordings));
        check_parts(&scorer.part_samples(), design.kinds().into_iter(), study.settings.ridge)?;
        Ok(Self { study, grid, design, further, scorer })
    }

    fn row(&self, f_th: f64, progress: &Progress) -> Result<Vec<PointScores>, Cancelled> {
        let data = &self.study.data;
        let t_ths_secs = self.grid.t_ths_secs();
        let thresholds = Thresholds { f_th, t_th_secs: self.grid.longest_secs() };
        let aged: Vec<[Vec<AgedSums>; 2]> = (data.entries.par_iter().enumerate())
            .map(|(at, entry)| {
                progress.check()?;
                if !takes_part(entry) {
                    return Ok([Vec::new(), Vec::new()]);
                }
                let past = self.study.paths[at].past_samples_until(
                    entry.recording.times(),
                    thresholds,
                    progress,
                );
                progress.check()?;
                let ages = ThresholdAges { past: &past, further: &self.further[at], t_ths_secs };
                let loads = data.present_loads(at);
                let pieces = &data.folds.pieces[at];
                let aged = aged_sums(&self.design, loads, ages, pieces, false, progress);
                let cold = match self.scorer.is_scored_cold() && entry.role == Role::Train {
                    true => aged_sums(&self.design, loads, ages, pieces, true, progress),
                    false => Vec::new(),
                };
                progress.check()?;
                Ok([aged, cold])
            })
            .collect::<Result<_, Cancelled>>()?;
        let (mut parts, mut all_cold) = (Vec::new(), Vec::new());
        let (mut test, mut n_training) = (Vec::new(), 0);
        for ((entry, pieces), [aged, cold]) in data.entries.iter().zip(&data.folds.pieces).zip(aged)
        {
            match entry.role {
                Role::Train => {
                    all_cold.extend(pieces.iter().map(|piece| piece.fold).zip(cold));
                    let pieces = pieces.iter().zip(aged);
                    parts.extend(pieces.map(|(piece, aged)| (piece.fold, n_training, aged)));
                    n_training += 1;
                }
                Role::Test => test.extend(aged),
                Role::Off => {}
            }
        }
        self.scorer.row(&parts, &all_cold, &test, t_ths_secs.len(), progress)
    }
}

fn further_past(
    study: &Study,
    features: &FeatureSettings,
    progress: &Progress,
) -> Result<Vec<Vec<Vec<u32>>>, Cancelled> {
    let data = &study.data;
    (data.entries.par_iter().zip(&*study.paths))
        .map(|(entry, path)| {
            progress.check()?;
            let further = features.look_backs[1..].iter();
            Ok(further
                .map(|thresholds| {
                    path.past_samples_until(entry.recording.times(), *thresholds, progress)
                })
                .collect())
        })
        .collect()
}
