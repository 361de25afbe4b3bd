//! Prepares datasets, and keeps them in a cache. A dataset contains the recordings of a fit, and results that do not depend
//! on the features of the fit, such as the loads of the conventional calibration.
//!
//! Guarantees: a dataset never changes, so requests that run on several threads share it. Each dataset is prepared only once.

pub(crate) mod applied;
pub(crate) mod auxiliary_inputs;
pub(crate) mod fit;
pub(crate) mod history;
pub(crate) mod travels;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, TryLockError};
use std::time::Duration;

use rayon::prelude::*;

use crate::{
    calibration::{
        Calibration, Conventional, CrossValidation, FORMAT, FitSettings, LARGEST, LinearMap,
        NormalEquations, Past, PresentLoads, Quality, Scores, VERSION, history_step_by_rate,
        loads_from_gauges, past_samples,
    },
    features::{Auxiliary, Block, Design, FeatureSettings, FixedLag, LoadPath, Play},
    finding::Finding,
    panicked::locked,
    progress::{Cancelled, Progress},
    questions::{
        dataset::{applied::Applied, auxiliary_inputs::AuxiliaryInputs, history::CoarseHistory},
        error::AnalysisError,
    },
    recording::{
        Axis, Entry, Groups, Identity, Missing, Recording, RecordingSet, Role, ValidRange,
        full_scale_of, gap::gap_by_rate, in_role, load_ranges, median,
    },
    same::same_where,
    scoring::{
        MANY_SAMPLES,
        coverage::Coverage,
        cross_validation::{FEWEST_RECORDINGS, Folds},
        faults::{Faults, faults, faults_of},
        metrics,
        rig::{RigReport, lag},
    },
};

/// RMSE of the conventional and of the compensated calibration in one recording, for each axis.
pub(crate) type Errors = (Vec<f64>, Vec<f64>);

#[derive(Clone, Debug)]
pub(crate) struct Key {
    pub recordings: Arc<RecordingSet>,
    pub offset: bool,
    pub decimation: usize,
    /// Calibration that is applied to the recordings; `None` if one is fitted.
    pub calibration: Option<Arc<Calibration>>,
}

same_where!(Key: shared(recordings, calibration) value(offset, decimation) besides());

/// Largest load for which a calibration is valid, as a multiple of the largest training load, if no rated load was entered.
const BEYOND_TRAINING: f64 = 1.2;

/// Paths of the conventional loads of all recordings, in which the look-back searches earlier gauge values. They are for one
/// set of axis weights and one history step.
pub(crate) type Paths = Arc<Vec<LoadPath>>;

/// Sums for the least-squares fit, one for each part of each recording that cross-validation can leave out.
pub(crate) type SumsOfPieces = Arc<Vec<Vec<NormalEquations>>>;

/// Recordings of a fit after decimation, with their conventional loads.
#[derive(Debug)]
pub(crate) struct Dataset {
    key: Key,
    pub entries: Vec<Entry>,
    /// Groups of recordings. Cross-validation leaves out whole groups.
    pub groups: Groups,
    pub folds: Folds,
    pub auxiliary: AuxiliaryInputs,
    /// Conventional calibration, fitted to the training recordings; `None` if a calibration is applied instead of fitted.
    pub conventional: Option<Conventional>,
    pub map: LinearMap,
    /// Loads by the conventional calibration for each recording; `None` if they would need too much memory.
    loads: Option<Vec<Arc<Vec<f64>>>>,
    /// Full scale of each axis, derived from the training loads. It is used for axes without a rated load.
    full_scale: Vec<f64>,
    /// Largest magnitude of the training loads on each axis (N, N·m).
    largest: Vec<f64>,
    /// Shortest time (s) between two samples that counts as a pause, from the training recordings; `None` if no recording
    /// determines it.
    gap_secs: Option<f64>,
    pub derived: Derived,
}

/// A result that is computed when it is first needed. Other threads that need it meanwhile wait, and can be cancelled.
#[derive(Debug)]
struct Once<T> {
    found: OnceLock<T>,
    computing: Mutex<()>,
}

impl<T> Default for Once<T> {
    fn default() -> Self {
        Self { found: OnceLock::new(), computing: Mutex::default() }
    }
}

impl<T> Once<T> {
    fn get(
        &self,
        progress: &Progress,
        compute: impl FnOnce() -> Result<T, Cancelled>,
    ) -> Result<&T, Cancelled> {
        if self.found.get().is_none() {
            let _computing = waited_for(&self.computing, progress)?;
            if self.found.get().is_none() {
                let found = compute()?;
                return Ok(self.found.get_or_init(|| found));
            }
        }
        Ok(self.found.get().expect("the result was found above"))
    }
}

/// Results for a dataset that are computed when they are first needed.
#[derive(Debug, Default)]
pub(crate) struct Derived {
    coverage: OnceLock<Coverage>,
    rig: Once<Option<RigReport>>,
    lag: Once<Option<Finding>>,
    /// Paths for the look-back of the newest requests, with the axis weights and the history step for which they were
    /// computed.
    paths: Mutex<Vec<(Vec<f64>, Paths)>>,
    /// Histories that were chosen for the newest settings.
    pub histories: Mutex<Vec<(FitSettings, Option<CoarseHistory>)>>,
    /// Design of the features of the newest fit, and its sums as if the look-back found no earlier sample. Such sums are the
    /// same at all thresholds.
    pub unmoved: Mutex<Option<(Design, SumsOfPieces)>>,
}

/// Place of one dataset in the cache. It is locked while the dataset is prepared, so that other threads wait.
type Place = Arc<Mutex<Option<Arc<Dataset>>>>;

/// Cache of the datasets that several requests about the same recordings share.
#[derive(Clone, Debug, Default)]
pub struct Datasets {
    /// Places of the datasets, newest first.
    places: Arc<Mutex<Vec<(Key, Place)>>>,
    /// Faulty samples of the recordings of the newest request.
    faults: Arc<Mutex<Vec<FaultsOf>>>,
    /// Loads of the newest calibration.
    applied: Arc<Mutex<Option<Arc<Applied>>>>,
}

#[derive(Debug)]
struct FaultsOf {
    recording: Arc<Recording>,
    range: ValidRange,
    faults: Arc<Faults>,
}

impl FaultsOf {
    fn is(&self, recording: &Arc<Recording>, range: &ValidRange) -> bool {
        Arc::ptr_eq(&self.recording, recording) && self.range == *range
    }
}

/// Maximum range of a load that rests, as a share of the range over all recordings.
const RESTS: f64 = 0.02;

/// Maximum number of datasets in the cache: one for a fit, and one for an applied calibration. Also the maximum number of sets of
/// paths in a dataset: with all samples, and with the chosen history rate.
const KEPT: usize = 2;

/// Interval at which a waiting thread checks whether the user has cancelled its request.
const LOOK_AGAIN: Duration = Duration::from_millis(5);

/// Waits until no other thread is preparing the shared data, and locks them.
///
/// # Errors
/// [`Cancelled`] if the request is cancelled before the data are ready.
fn waited_for<'a, T>(
    shared: &'a Mutex<T>,
    progress: &Progress,
) -> Result<MutexGuard<'a, T>, Cancelled> {
    loop {
        progress.check()?;
        match shared.try_lock() {
            Ok(guard) => return Ok(guard),
            Err(TryLockError::Poisoned(guard)) => return Ok(guard.into_inner()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(LOOK_AGAIN),
        }
    }
}

impl Datasets {
    /// Returns the dataset for this key, and prepares it if it is not in the cache. Other threads that need the same dataset
    /// wait.
    pub(crate) fn get(
        &self,
        key: &Key,
        progress: &Progress,
    ) -> Result<Arc<Dataset>, AnalysisError> {
        progress.check()?;
        let place = self.place(key);
        let mut dataset = waited_for(&place, progress)?;
        if dataset.is_none() {
            *dataset = Some(Arc::new(Dataset::prepare(key, progress)?));
        }
        Ok(Arc::clone(dataset.as_ref().expect("the dataset was prepared above")))
    }

    fn place(&self, key: &Key) -> Place {
        let mut kept = locked(&self.places);
        // Datasets of other recordings are dropped first, because both may not fit in memory.
        kept.retain(|(known, _)| Arc::ptr_eq(&known.recordings, &key.recordings));
        locked(&self.applied).take_if(|known| !known.is_of(&key.recordings));
        let newest = match kept.iter().position(|(known, _)| known == key) {
            Some(at) => kept.remove(at),
            None => (key.clone(), Place::default()),
        };
        let place = Arc::clone(&newest.1);
        kept.insert(0, newest);
        kept.truncate(KEPT);
        place
    }

    /// Returns the loads of a calibration in these recordings, which all requests share. The loads of another calibration are
    /// dropped first, because two sets of loads may not fit in memory.
    pub(crate) fn applied(
        &self,
        recordings: &Arc<RecordingSet>,
        decimation: usize,
        calibration: &Arc<Calibration>,
    ) -> Arc<Applied> {
        let mut newest = locked(&self.applied);
        let before = newest.take();
        let known =
            before.as_ref().filter(|applied| applied.is(recordings, decimation, calibration));
        let applied = match known {
            Some(known) => Arc::clone(known),
            None => Arc::new(Applied::new(recordings, decimation, calibration, before)),
        };
        *newest = Some(Arc::clone(&applied));
        applied
    }

    /// Returns the faulty samples of each recording. They are searched only once: while one thread searches, other threads
    /// wait.
    ///
    /// # Errors
    /// [`Cancelled`] if the request is cancelled. Faults that were found until then stay in the cache.
    pub fn faults(
        &self,
        recordings: &RecordingSet,
        range: &ValidRange,
        progress: &Progress,
    ) -> Result<Vec<Arc<Faults>>, Cancelled> {
        let mut kept = waited_for(&self.faults, progress)?;
        let before = std::mem::take(&mut *kept);
        let all: Vec<&Arc<Recording>> =
            (recordings.entries().iter()).map(|entry| &entry.recording).collect();
        let are_known = before.len() == all.len()
            && before.iter().zip(&all).all(|(known, of)| known.is(of, range));
        // Load cases without times are compared with each other, so all their recordings are searched together.
        let mut of_tables = if !are_known && all.iter().any(|recording| recording.is_static()) {
            faults_of(&all.iter().map(|recording| &***recording).collect::<Vec<_>>(), range)
        } else {
            Vec::new()
        }
        .into_iter();
        for recording in all {
            progress.check()?;
            let known = before.iter().find(|known| known.is(recording, range));
            let found = match (of_tables.next(), known) {
                (Some(found), _) => Arc::new(found),
                (None, Some(known)) => Arc::clone(&known.faults),
                (None, None) => Arc::new(faults(recording, range)),
            };
            kept.push(FaultsOf {
                recording: Arc::clone(recording),
                range: range.clone(),
                faults: found,
            });
        }
        Ok(kept.iter().map(|found| Arc::clone(&found.faults)).collect())
    }
}

impl Dataset {
    pub fn prepare(key: &Key, progress: &Progress) -> Result<Self, AnalysisError> {
        // A calibration can be applied to recordings without a load.
        let missing = key.recordings.missing();
        let hinders = |missing: &Missing| key.calibration.is_none() || *missing == Missing::Gauges;
        if let Some(missing) = missing.filter(hinders) {
            return Err(missing.into());
        }
        let mut entries = decimated(key.recordings.entries(), key.decimation);
        entries.par_iter().try_for_each(|entry| check_size(&entry.recording))?;
        let auxiliary = match &key.calibration {
            Some(calibration) => {
                for entry in &mut entries {
                    if let Cow::Owned(prepared) = calibration.prepared(&entry.recording)? {
                        entry.recording = Arc::new(prepared);
                    }
                }
                AuxiliaryInputs::default()
            }
            None => AuxiliaryInputs::prepare(&mut entries),
        };
        let training = in_role(&entries, Role::Train);
        let (conventional, map) = match &key.calibration {
            Some(calibration) => (None, calibration.conventional.clone()),
            None if training.is_empty() => return Err(AnalysisError::NoTraining),
            None => {
                let conventional = Conventional::fit(&training, key.offset, progress);
                let map = conventional.map.clone();
                (Some(conventional), map)
            }
        };
        progress.check()?;
        let kept = |entry: &Entry| {
            progress.check()?;
            let loads = loads_from_gauges(&map, &entry.recording);
            progress.advance(1);
            Ok(Arc::new(loads))
        };
        let n_axes = training.first().map_or(0, |recording| recording.axes().len());
        let ranges = load_ranges(training.iter().copied(), n_axes);
        let n_samples = entries.iter().map(|entry| entry.recording.n_samples());
        let loads = (n_samples.sum::<usize>() <= MANY_SAMPLES)
            .then(|| entries.par_iter().map(kept).collect::<Result<_, Cancelled>>());
        let loads = loads.transpose()?;
        let groups = key.recordings.groups();
        Ok(Self {
            key: key.clone(),
            folds: folds(&entries, &groups),
            groups,
            full_scale: ranges.iter().copied().map(full_scale_of).collect(),
            largest: (ranges.iter()).map(|range| range.magnitude()).collect(),
            gap_secs: gap_secs(&training),
            entries,
            auxiliary,
            conventional,
            map,
            loads,
            derived: Derived::default(),
        })
    }

    pub fn is_of(&self, recordings: &Arc<RecordingSet>) -> bool {
        Arc::ptr_eq(&self.key.recordings, recordings)
    }

    pub fn training(&self) -> Vec<&Recording> {
        in_role(&self.entries, Role::Train)
    }

    /// Returns true if the recordings say nothing about earlier samples: they have no times, or the load rests in each of them.
    pub fn has_no_history(&self) -> bool {
        let training = self.training();
        let rests = |own: &&Recording| {
            let mut axes = own.load_ranges().iter().zip(&self.full_scale);
            axes.all(|(range, full_scale)| range.span() <= 2.0 * RESTS * full_scale)
        };
        let all_rest = training.len() >= FEWEST_RECORDINGS && training.iter().all(rests);
        self.key.recordings.is_static() || all_rest
    }

    pub fn training_groups(&self) -> BTreeSet<usize> {
        let entries = self.entries.iter().zip(&self.groups.of);
        entries.filter(|(entry, _)| entry.role == Role::Train).map(|(_, group)| *group).collect()
    }

    pub fn cross_validation(&self) -> CrossValidation {
        self.folds.cross_validation(self.groups.by)
    }

    pub fn present_loads(&self, at: usize) -> PresentLoads<'_> {
        PresentLoads {
            map: &self.map,
            recording: &self.entries[at].recording,
            kept: self.loads.as_ref().map(|loads| loads[at].as_slice()),
        }
    }

    /// Returns the dataset without the stored loads of the conventional calibration, as if the recordings had too many samples
    /// to store them.
    #[cfg(test)]
    pub fn with_loads_made(self) -> Self {
        Self { loads: None, ..self }
    }

    pub fn kept_loads(&self) -> Option<&[Arc<Vec<f64>>]> {
        self.loads.as_deref()
    }

    /// Returns a dataset with only every `each`-th sample, but with the same conventional calibration and full scales.
    pub fn thinned(&self, each: usize) -> Self {
        let entries = decimated(&self.entries, each);
        let loads = entries.par_iter();
        let loads = loads.map(|entry| Arc::new(loads_from_gauges(&self.map, &entry.recording)));
        Self {
            key: self.key.clone(),
            groups: self.groups.clone(),
            folds: folds(&entries, &self.groups),
            conventional: self.conventional.clone(),
            map: self.map.clone(),
            loads: Some(loads.collect()),
            full_scale: self.full_scale.clone(),
            largest: self.largest.clone(),
            gap_secs: self.gap_secs,
            entries,
            auxiliary: self.auxiliary.clone(),
            derived: Derived::default(),
        }
    }

    pub fn coverage(&self, axes: &[Axis]) -> &Coverage {
        self.derived.coverage.get_or_init(|| Coverage::of(&self.entries, axes))
    }

    /// Returns the report on the test rig in the training recordings, such as changed zeros of the gauges; `None` if no load
    /// changes.
    pub fn rig(&self, progress: &Progress) -> Result<Option<&RigReport>, Cancelled> {
        let found = || RigReport::of(&self.training(), &self.full_scale, progress);
        Ok(self.derived.rig.get(progress, found)?.as_ref())
    }

    /// Returns the finding of a time lag between gauges and reference; `None` if the lag is too small to matter.
    pub fn lag(&self, progress: &Progress) -> Result<Option<&Finding>, Cancelled> {
        Ok(self.derived.lag.get(progress, || lag(&self.training(), progress))?.as_ref())
    }

    /// Returns the finding of a time lag between gauges and reference if the features of the fit would describe the lag as
    /// hysteresis. With a fixed-lag feature there is no finding, because this feature describes the lag correctly.
    pub fn lag_as_hysteresis(
        &self,
        features: &FeatureSettings,
        progress: &Progress,
    ) -> Result<Option<&Finding>, Cancelled> {
        let is_used = |block: &dyn Block| !features.blocks.of(block).is_empty();
        if !is_used(&FixedLag) && (!features.look_backs.is_empty() || is_used(&Play)) {
            self.lag(progress)
        } else {
            Ok(None)
        }
    }

    pub fn paths(&self, calibration: &Calibration) -> Paths {
        let weights = calibration.distance_weights();
        let step_secs = calibration.history_step_secs;
        let key = [weights.clone(), vec![step_secs]].concat();
        let mut newest = locked(&self.derived.paths);
        match newest.iter().find(|(known, _)| *known == key) {
            Some((_, paths)) => Arc::clone(paths),
            None => {
                let entries = self.entries.par_iter().enumerate();
                let paths = entries.map(|(at, entry)| {
                    let (times, loads) = (entry.recording.times(), self.present_loads(at));
                    let load = |k, axis| loads.at(k, axis);
                    LoadPath::with_history_step(times, &load, &weights, step_secs)
                });
                let paths: Paths = Arc::new(paths.collect());
                newest.insert(0, (key, Arc::clone(&paths)));
                newest.truncate(KEPT);
                paths
            }
        }
    }

    /// Returns the calibration before the fit. It stores all samples for look-backs and lags, unless the settings give another
    /// rate; see [`Self::unfitted`].
    pub fn blank_calibration(&self, settings: &FitSettings) -> Result<Calibration, AnalysisError> {
        let layout = self.key.recordings.layout();
        if settings.full_scale.len() > layout.axes.len() {
            return Err(AnalysisError::FullScales {
                given: settings.full_scale.len(),
                axes: layout.axes.len(),
            });
        }
        let mut features = if self.has_no_history() {
            // Load cases have no earlier samples, so features that use them are removed.
            settings.features.without_history()
        } else {
            settings.features.clone()
        };
        features.auxiliary = match features.blocks.of(&Auxiliary) {
            [] => Vec::new(),
            _ => self.auxiliary.channels.clone(),
        };
        for channel in &mut features.auxiliary {
            let entered = settings.auxiliary_references.get(&channel.name);
            channel.reference = entered.copied().unwrap_or(channel.reference);
        }
        features.check_columns(layout.gauge_names.len())?;
        let entered = |axis: usize| settings.full_scale.get(axis).copied().flatten();
        let full_scale = self.full_scale.iter().enumerate();
        let full_scale = full_scale.map(|(axis, measured)| entered(axis).unwrap_or(*measured));
        let rated: Vec<bool> = (0..layout.axes.len()).map(|axis| entered(axis).is_some()).collect();
        let rated = if rated.contains(&true) { rated } else { Vec::new() };
        let training = self.training();
        let rate_hz = median(training.iter().filter_map(|recording| recording.rate_hz()));
        let history_step_secs = match settings.history_rate_hz.unwrap_or_default() {
            0.0 => history_step_by_rate(rate_hz),
            // The history step is a little shorter than the sample interval, so that rounded times do not skip a sample.
            rate_hz => (1.0 - 1e-6) / rate_hz,
        };
        let limits = self.largest.iter().enumerate();
        let limits = limits.map(|(axis, largest)| match entered(axis) {
            Some(rated) => rated.max(*largest),
            None => BEYOND_TRAINING * largest,
        });
        features.distance = features.distance.effective(&layout.axes);
        let conventional =
            self.conventional.as_ref().expect("a fit prepares the conventional calibration");
        Ok(Calibration {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: concat!("LoopScope ", env!("CARGO_PKG_VERSION")).to_owned(),
            simulated: self.key.recordings.is_simulated(),
            identity: Identity::default(),
            gauges: layout.gauge_names.clone(),
            axes: layout.axes.clone(),
            units: layout.axes.iter().map(|axis| axis.unit().to_owned()).collect(),
            full_scale: full_scale.collect(),
            rated,
            offset: settings.offset,
            decimation: settings.decimation,
            gap_secs: self.gap_secs.unwrap_or_else(|| gap_by_rate(rate_hz)),
            keep_secs: BTreeMap::new(),
            history_step_secs,
            limits: limits.collect(),
            gauge_limits: gauge_limits(&training),
            features,
            gauge_scale: conventional.scale.clone(),
            regressor: crate::calibration::Regressor::Linear,
            conventional: self.map.clone(),
            compensated: None,
            learned: None,
            quality: Quality::default(),
            trained_on: training.iter().map(|recording| recording.name().to_owned()).collect(),
            rate_hz: self.key.recordings.rate_hz(Role::Train),
            sources: Vec::new(),
            tare: self.key.recordings.tare(),
            frame: self.key.recordings.frame().flatten(),
            tool: self.key.recordings.tool(),
        })
    }

    pub fn past(
        &self,
        calibration: &Calibration,
        progress: &Progress,
    ) -> Result<Vec<Past>, Cancelled> {
        let paths = self.paths(calibration);
        (self.entries.par_iter().zip(&*paths))
            .map(|(entry, path)| {
                progress.check()?;
                let past = past_samples(&calibration.features, path, &entry.recording, progress);
                progress.check()?;
                progress.advance(1);
                Ok(past)
            })
            .collect()
    }

    /// Computes the errors of a calibration by applying it sample by sample to the recordings with the same reference axes.
    pub fn score_applied(
        &self,
        past: &[Past],
        calibration: &mut Calibration,
    ) -> Vec<Option<Errors>> {
        let n_axes = calibration.axes.len();
        let errors: Vec<_> = self
            .entries
            .par_iter()
            .enumerate()
            .map(|(at, entry)| {
                let recording = &entry.recording;
                if *recording.axes() != calibration.axes {
                    return None;
                }
                let compensated = calibration.compensated_loads(recording, &past[at]);
                let rmse = |loads: &[f64]| metrics::rmse_of_loads(loads, recording.loads(), n_axes);
                let present = self.present_loads(at);
                let made = || loads_from_gauges(present.map, recording);
                let conventional = present.kept.map_or_else(|| made().into(), Cow::Borrowed);
                Some((rmse(&conventional)?, rmse(&compensated)?))
            })
            .collect();
        let scored = |role: Role| {
            let scored = self.entries.iter().zip(&errors);
            let scored = scored.filter(move |(entry, _)| entry.role == role);
            scored
                .filter_map(|(entry, errors)| Some((entry.recording.n_samples(), errors.as_ref()?)))
        };
        let n = |role| scored(role).map(|(n, _)| n as u64).sum::<u64>();
        let pooled = |role, pick: fn(&Errors) -> &Vec<f64>| {
            let mut squares = vec![0.0; n_axes];
            for (n, errors) in scored(role) {
                for (square, rmse) in squares.iter_mut().zip(pick(errors)) {
                    *square += rmse * rmse * n as f64;
                }
            }
            metrics::root_mean(&squares, n(role))
        };
        let scores = |pick: fn(&Errors) -> &Vec<f64>| Scores {
            train_rmse: pooled(Role::Train, pick),
            test_rmse: pooled(Role::Test, pick),
            cv_rmse: None,
        };
        calibration.quality = Quality {
            n_train: n(Role::Train),
            n_test: n(Role::Test),
            conventional: scores(|errors| &errors.0),
            compensated: scores(|errors| &errors.1),
            ..std::mem::take(&mut calibration.quality)
        };
        errors
    }
}

fn check_size(recording: &Recording) -> Result<(), AnalysisError> {
    for (values, width) in
        [(recording.gauges(), recording.n_gauges()), (recording.loads(), recording.axes().len())]
    {
        if let Some(at) = values.iter().position(|value| value.abs() > LARGEST) {
            return Err(AnalysisError::TooLarge {
                recording: recording.name().to_owned(),
                sample: at / width + 1,
                value: values[at],
            });
        }
    }
    Ok(())
}

fn decimated(entries: &[Entry], step: usize) -> Vec<Entry> {
    let entries = entries.par_iter().map(|entry| match step {
        1 => entry.clone(),
        step => Entry { recording: Arc::new(entry.recording.decimated(step)), ..entry.clone() },
    });
    entries.collect()
}

fn folds(entries: &[Entry], groups: &Groups) -> Folds {
    let of = |(entry, group): (&Entry, &usize)| {
        (entry.recording.n_samples(), (entry.role == Role::Train).then_some(*group))
    };
    Folds::of(&entries.iter().zip(&groups.of).map(of).collect::<Vec<_>>(), groups.by)
}

fn gap_secs(training: &[&Recording]) -> Option<f64> {
    let gaps = training.iter().map(|recording| recording.gap_secs());
    gaps.filter(|gap| gap.is_finite()).reduce(f64::max)
}

/// Returns, for each gauge, the range of tared values in which no training recording was clipped; empty if clipped samples
/// were not searched.
fn gauge_limits(training: &[&Recording]) -> Vec<(Option<f64>, Option<f64>)> {
    let mut limits: Vec<(Option<f64>, Option<f64>)> = Vec::new();
    for recording in training {
        let unclipped = recording.left_out().map_or(&[][..], |left_out| &left_out.unclipped);
        for (gauge, values) in unclipped.iter().enumerate() {
            limits.resize(limits.len().max(unclipped.len()), (None, None));
            let less = |end: Option<f64>| end.map(|end| end - recording.tared_by(gauge));
            let (low, high) = &mut limits[gauge];
            *low = [*low, less(values.0)].into_iter().flatten().reduce(f64::max);
            *high = [*high, less(values.1)].into_iter().flatten().reduce(f64::min);
        }
    }
    limits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::questions::request::Request;
    use crate::recording::simulated;

    #[test]
    fn who_waits_for_the_dataset_of_another_question_can_be_cancelled() {
        let datasets = Datasets::default();
        let request = Request::fit(Arc::default(), FitSettings::default());
        let progress = Progress::default();
        let place = datasets.place(&request.key());
        let preparing = place.lock().unwrap();
        std::thread::scope(|scope| {
            let waits = scope.spawn(|| datasets.get(&request.key(), &progress).err());
            std::thread::sleep(4 * LOOK_AGAIN);
            assert!(!waits.is_finished());
            progress.cancel();
            let answer = waits.join().unwrap();
            assert_eq!(answer, Some(AnalysisError::Cancelled(Cancelled)));
        });
        drop(preparing);
    }

    #[test]
    fn a_question_about_other_data_does_not_wait_for_a_preparation() {
        let datasets = Datasets::default();
        let request =
            |offset| Request::fit(Arc::default(), FitSettings { offset, ..FitSettings::default() });
        let place = datasets.place(&request(true).key());
        let _preparing = place.lock().unwrap();
        let answer = datasets.get(&request(false).key(), &Progress::default()).err();
        assert_eq!(answer, Some(AnalysisError::NoTraining));
        let progress = Progress::default();
        progress.cancel();
        let answer = datasets.get(&request(true).key(), &progress).err();
        assert_eq!(answer, Some(AnalysisError::Cancelled(Cancelled)));
    }

    #[test]
    fn a_cancelled_search_for_faults_of_the_rig_is_done_again() {
        let recordings = Arc::new(simulated::recordings(7));
        let settings = FitSettings { decimation: 50, ..FitSettings::default() };
        let key = Request::fit(recordings, settings).key();
        let data = Dataset::prepare(&key, &Progress::default()).unwrap();
        let cancelled = Progress::default();
        cancelled.cancel();
        assert_eq!(data.rig(&cancelled), Err(Cancelled));
        assert_eq!(data.lag(&cancelled), Err(Cancelled));
        let found = data.rig(&Progress::default()).unwrap().unwrap();
        assert!(!found.runs.is_empty());
        // The result is kept, so that the second request computes nothing that could be cancelled.
        assert!(std::ptr::eq(data.rig(&cancelled).unwrap().unwrap(), found));
    }
}
