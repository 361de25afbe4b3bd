//! Computes the map of errors over the force threshold F_th and the time threshold t_th of a look-back. For each F_th, one
//! search for earlier samples and one pass over the samples give the errors at all t_th.

use std::sync::Mutex;

use rayon::prelude::*;

use crate::{
    calibration::{AgedSums, NoCrossValidation, Past, RidgeChoice, ThresholdAges, aged_sums},
    features::{ColumnKind, Design, Thresholds},
    panicked::locked,
    progress::{Cancelled, Progress},
    questions::{
        error::AnalysisError,
        thresholds::{
            grid::ThresholdGrid,
            map::ThresholdMap,
            scorer::{AgedRow, PointScores, Scorer},
            study::prepared::Study,
        },
    },
    recording::{Entry, Role},
    scoring::left_out::too_short,
};

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
                let is_scored_cold = self.scorer.sums.cold.is_some() && entry.role == Role::Train;
                let both = [aged(false), if is_scored_cold { aged(true) } else { Vec::new() }];
                progress.check()?;
                Ok(both)
            })
            .collect::<Result<_, Cancelled>>()?;
        let (mut row, mut n_training) = (AgedRow::default(), 0);
        for ((entry, pieces), [aged, cold]) in data.entries.iter().zip(&data.folds.pieces).zip(aged)
        {
            match entry.role {
                Role::Train => {
                    row.cold.extend(pieces.iter().map(|piece| piece.fold).zip(cold));
                    let pieces = pieces.iter().zip(aged);
                    row.parts.extend(pieces.map(|(piece, aged)| (piece.fold, n_training, aged)));
                    n_training += 1;
                }
                Role::Test => row.test.extend(aged),
                Role::Off => {}
            }
        }
        self.scorer.row(&row, t_ths_secs.len(), progress)
    }
}
