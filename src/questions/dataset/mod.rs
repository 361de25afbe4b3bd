//! Prepares datasets, and keeps them in a cache. A dataset contains the recordings of a fit, and results that do not depend
//! on the features of the fit, such as the loads of the conventional calibration.
//!
//! Guarantees: a dataset never changes, so requests that run on several threads share it. Each dataset is prepared only once.
//!
//! Finds the auxiliary channels (such as temperature) that a fit can use.
//!
//! Range of readings that a gauge has covered since the start of a recording. Once it is large enough, the state of a play
//! operator (hysteresis element) driven by the gauge is known.

pub(crate) mod applied;
pub(crate) mod fit;

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, TryLockError};
use std::time::Duration;

use rayon::prelude::*;

use crate::{
    calibration::{
        Calibration, Conventional, CrossValidation, FORMAT, FitSettings, LARGEST, LinearMap,
        NormalEquations, Past, PresentLoads, Quality, Scores, VERSION, history_step_by_rate,
        loads_from_gauges, past_samples,
    },
    features::{
        Auxiliary, AuxiliaryChannel, Block, Design, FeatureSettings, FixedLag, GaugeScale,
        LoadPath, Play,
    },
    finding::Finding,
    min_max::MinMax,
    panicked::locked,
    progress::{Cancelled, Progress},
    questions::{
        dataset::{applied::Applied, fit::CoarseHistory},
        error::AnalysisError,
    },
    recording::{
        Axis, Entry, Groups, Missing, Recording, RecordingSet, Role, ValidRange, full_scale_of,
        gap::gap_by_rate, in_role, load_ranges, median,
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
#[derive(Clone, Debug)]
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
    pub derived: Arc<Derived>,
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
    fn get<E: From<Cancelled>>(
        &self,
        progress: &Progress,
        compute: impl FnOnce() -> Result<T, E>,
    ) -> Result<&T, E> {
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

/// Place of one dataset in the cache.
type Place = Arc<Once<Arc<Dataset>>>;

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

/// Faulty samples of a recording, with the range of valid loads by which they were found.
type FaultsOf = (Arc<Recording>, ValidRange, Arc<Faults>);

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
        place.get(progress, || Dataset::prepare(key, progress).map(Arc::new)).cloned()
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
        let is_of =
            |known: &FaultsOf, recording| Arc::ptr_eq(&known.0, recording) && known.1 == *range;
        let are_known = before.len() == all.len()
            && before.iter().zip(&all).all(|(known, recording)| is_of(known, recording));
        // Load cases without times are compared with each other, so all their recordings are searched together.
        let mut of_tables = if !are_known && all.iter().any(|recording| recording.is_static()) {
            faults_of(&all.iter().map(|recording| &***recording).collect::<Vec<_>>(), range)
        } else {
            Vec::new()
        }
        .into_iter();
        for recording in all {
            progress.check()?;
            let known = before.iter().find(|known| is_of(known, recording));
            let found = match (of_tables.next(), known) {
                (Some(found), _) => Arc::new(found),
                (None, Some((.., known))) => Arc::clone(known),
                (None, None) => Arc::new(faults(recording, range)),
            };
            kept.push((Arc::clone(recording), range.clone(), found));
        }
        Ok(kept.iter().map(|(.., found)| Arc::clone(found)).collect())
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
            derived: Arc::default(),
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
            folds: folds(&entries, &self.groups),
            loads: Some(loads.collect()),
            entries,
            derived: Arc::default(),
            ..self.clone()
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
            gauges: layout.gauge_names.clone(),
            axes: layout.axes.clone(),
            units: layout.axes.iter().map(|axis| axis.unit().to_owned()).collect(),
            full_scale: full_scale.collect(),
            rated,
            offset: settings.offset,
            decimation: settings.decimation,
            gap_secs: self.gap_secs.unwrap_or_else(|| gap_by_rate(rate_hz)),
            history_step_secs,
            limits: limits.collect(),
            gauge_limits: gauge_limits(&training),
            features,
            gauge_scale: conventional.scale.clone(),
            conventional: self.map.clone(),
            trained_on: training.iter().map(|recording| recording.name().to_owned()).collect(),
            rate_hz: self.key.recordings.rate_hz(Role::Train),
            tare: self.key.recordings.tare(),
            frame: self.key.recordings.frame().flatten(),
            tool: self.key.recordings.tool(),
            ..Calibration::default()
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

#[derive(Clone, Debug, Default)]
pub(crate) struct AuxiliaryInputs {
    pub channels: Vec<AuxiliaryChannel>,
    /// For each auxiliary channel that the fit cannot use, a sentence with the reason.
    pub unused: Vec<String>,
}

impl AuxiliaryInputs {
    /// Finds the auxiliary channels of the recordings that a fit can use, and removes the others from the recordings. A
    /// channel is removed if a recording lacks it, or if it hardly varies in the training recordings. Afterwards all
    /// recordings have the same channels in the same order.
    pub fn prepare(entries: &mut [Entry]) -> Self {
        let mut inputs = Self::default();
        let channels = |entry: &Entry| -> Vec<(String, String)> {
            let table = entry.recording.auxiliary();
            table.names().iter().cloned().zip(table.units().iter().cloned()).collect()
        };
        let mut all = Vec::new();
        for channel in entries.iter().flat_map(channels) {
            if !all.contains(&channel) {
                all.push(channel);
            }
        }
        let mut kept: Vec<String> = Vec::new();
        for channel in all {
            let lacks = entries.iter().find(|entry| !channels(entry).contains(&channel));
            let (name, unit) = channel;
            if let Some(entry) = lacks {
                let of_unit = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
                inputs.unused.push(format!(
                    "the recording {} has no auxiliary channel {name}{of_unit}, so the fit cannot use this channel; record the channel in all recordings, or close this recording",
                    entry.recording.name(),
                ));
                continue;
            }
            match AuxiliaryChannel::measure(&in_role(entries, Role::Train), &name) {
                Ok(channel) => {
                    kept.push(name);
                    inputs.channels.push(channel);
                }
                Err(reason) => inputs.unused.push(reason),
            }
        }
        for entry in entries {
            if entry.recording.auxiliary().names() != kept
                && let Ok(picked) = entry.recording.with_auxiliary_of(&kept)
            {
                entry.recording = Arc::new(picked);
            }
        }
        inputs
    }
}

/// Maximum share of a group's samples in which the state of a play operator (hysteresis element) may be unknown.
pub(crate) const MOST_UNKNOWN: f64 = 0.1;

/// Range of readings that each gauge has covered from the start of a recording to each sample.
pub(crate) struct Travels {
    /// One list per group of recordings, with an entry for each recording and gauge: the covered range up to each sample, in
    /// standard deviations σ of the gauge, and the weight of the gauge.
    groups: Vec<Vec<(Vec<f32>, f64)>>,
}

impl Travels {
    /// Measures the range that every gauge has covered up to each sample of the training recordings.
    pub fn of(data: &Dataset, scale: &GaugeScale) -> Self {
        let n_groups = data.groups.of.iter().max().map_or(0, |last| last + 1);
        let mut groups = vec![Vec::new(); n_groups];
        let training = data.entries.iter().zip(&data.groups.of);
        for (entry, group) in training.filter(|(entry, _)| entry.role == Role::Train) {
            let recording = &entry.recording;
            for (gauge, deviation) in scale.deviation.iter().enumerate() {
                let mut range = MinMax::NONE;
                let (mut sum, mut squares) = (0.0, 0.0);
                let travel = (0..recording.n_samples()).map(|k| {
                    let reading = recording.gauges_at(k)[gauge] / deviation.max(f64::MIN_POSITIVE);
                    range = range.with(reading);
                    (sum, squares) = (sum + reading, squares + reading * reading);
                    range.span() as f32
                });
                let travel: Vec<f32> = travel.collect();
                let moved = squares - sum * sum / travel.len().max(1) as f64;
                groups[*group].push((travel, moved.max(0.0)));
            }
        }
        Self { groups }
    }

    /// Returns the share of samples at which a gauge has not yet covered the range `travel` (σ), for the group with the
    /// largest share. Gauges are weighted by the sum of their squared deviations.
    pub fn unknown(&self, travel: f64) -> f64 {
        let of_group = |gauges: &Vec<(Vec<f32>, f64)>| {
            let (mut unknown, mut all) = (0.0, 0.0);
            for (travels, moved) in gauges {
                let before = travels.partition_point(|covered| f64::from(*covered) < travel);
                unknown += moved * before as f64 / travels.len().max(1) as f64;
                all += moved;
            }
            if all > 0.0 { unknown / all } else { 0.0 }
        };
        self.groups.iter().map(of_group).fold(0.0, f64::max)
    }
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
        let preparing = place.computing.lock().unwrap();
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
        let _preparing = place.computing.lock().unwrap();
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

#[cfg(test)]
mod auxiliary_inputs_tests {
    use std::sync::Arc;

    use faer::Mat;
    use faer::linalg::solvers::SolveLstsq as _;

    use crate::calibration::{Calibration, Estimator, FitSettings, Regressor, RidgeChoice, Status};
    use crate::features::{Auxiliary, Blocks, Column, Creep, FeatureSettings, Polynomial};
    use crate::finding::Face;
    use crate::progress::Progress;
    use crate::questions::errors::query::{Analysis, analyse};
    use crate::questions::models::training::train;
    use crate::questions::request::Request;
    use crate::random::Random;
    use crate::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

    const NOISE: f64 = 0.02;
    const N: usize = 400;

    /// Returns the temperature of recording `at` at sample `k`. The temperature varies by about `moves` degrees between the
    /// recordings.
    fn temperature(at: usize, k: usize, moves: f64) -> f64 {
        let within = (k as f64 / 70.0 + at as f64).sin();
        20.0 + moves * (0.2 * at as f64 + 0.1 * within)
    }

    /// Returns a recording of two gauges with the load `3 s₁ − 2 s₂ + (T − 20) (0.4 + 0.02 s₁)` plus noise: zero and
    /// sensitivity drift with temperature.
    fn recording(at: usize, moves: f64) -> Recording {
        let mut random = Random::new(11, &[at as u64]);
        let (mut gauges, mut loads, mut auxiliary) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..N {
            let [a, b, noise] = [(); 3].map(|()| random.normal());
            let (a, b) = (50.0 + 4.0 * a, 0.5 * b);
            let warm = temperature(at, k, moves);
            gauges.extend([a, b]);
            auxiliary.extend([5.0, warm]);
            loads.push(3.0 * a - 2.0 * b + (warm - 20.0) * (0.4 + 0.02 * a) + NOISE * noise);
        }
        let recording = Recording::new(
            format!("r{at}"),
            Source::Simulated,
            (0..N).map(|k| k as f64 * 0.05).collect(),
            vec!["S1".into(), "S2".into()],
            gauges,
            vec![Axis::Fz],
            loads,
        );
        let (names, units) = (["U", "T"], ["V", "°C"]);
        let [names, units] = [names, units].map(|texts| texts.map(str::to_owned).to_vec());
        recording.unwrap().with_auxiliary(names, units, auxiliary).unwrap()
    }

    fn set(recordings: Vec<Recording>) -> Arc<RecordingSet> {
        let last = recordings.len() - 1;
        let mut set = RecordingSet::default();
        for (at, recording) in recordings.into_iter().enumerate() {
            let role = if at < last { Role::Train } else { Role::Test };
            set.push(Entry::new(recording, role)).unwrap();
        }
        Arc::new(set)
    }

    fn drifting(moves: f64) -> Vec<Recording> {
        [0, 2, 4, 1, 3].map(|at| recording(at, moves)).to_vec()
    }

    fn asked(recordings: &Arc<RecordingSet>, change: impl Fn(&mut FitSettings)) -> Request {
        let mut settings = FitSettings {
            features: FeatureSettings {
                blocks: Blocks::default().with(&Auxiliary, &[0.0]),
                ..FeatureSettings::present()
            },
            ..FitSettings::default()
        };
        change(&mut settings);
        Request::fit(Arc::clone(recordings), settings)
    }

    fn fitted(recordings: &Arc<RecordingSet>, change: impl Fn(&mut FitSettings)) -> Analysis {
        analyse(&asked(recordings, change), &Progress::default()).unwrap()
    }

    fn test_rmse(calibration: &Calibration) -> f64 {
        calibration.quality.compensated.test_rmse.as_ref().unwrap()[0]
    }

    /// The temperature T shifts the load by 0.4 N per degree and scales it by 0.02 per degree. A fit without T therefore errs by up
    /// to 0.02 · 50 N + 0.4 N per degree.
    #[test]
    fn temperature_drift_is_removed_down_to_the_noise() {
        let recordings = set(drifting(30.0));
        let with = fitted(&recordings, |_| {});
        let without = fitted(&recordings, |settings| {
            settings.features.blocks = Blocks::default();
        });
        assert!(test_rmse(&with.calibration) < 1.1 * NOISE);
        assert!(test_rmse(&without.calibration) > 50.0 * NOISE);
        let cv = with.calibration.quality.compensated.cv_rmse.as_ref().unwrap();
        assert!(cv[0] < 1.15 * NOISE, "{cv:?}");
        // The supply voltage U is constant, so the fit does not use it and reports the reason.
        let channels = &with.calibration.features.auxiliary;
        assert_eq!((channels.len(), &*channels[0].name), (1, "T"));
        assert!((channels[0].min - 17.0).abs() < 0.1 && channels[0].max > 40.0);
        let texts: Vec<String> =
            with.findings.iter().map(|finding| finding.text(Face::Page)).collect();
        assert!(texts.iter().any(|text| text.contains("channel U left out")), "{texts:?}");
    }

    /// At 30 °C the load is `(3 + 0.02 · 10) s₁ − 2 s₂ + 0.4 · 10`.
    #[test]
    fn matrix_and_offset_are_those_at_the_reference_that_was_entered() {
        let recordings = set(drifting(30.0));
        let with = |reference: Option<f64>| {
            fitted(&recordings, |settings| {
                let entered = reference.map(|value| ("T".to_owned(), value));
                settings.auxiliary_references = entered.into_iter().collect();
            })
        };
        let (mean, entered) = (with(None), with(Some(30.0)));
        let map = entered.calibration.compensated.as_ref().unwrap();
        let of = |kind: &dyn Fn(&Column) -> bool| {
            let at = map.columns.iter().position(kind).unwrap();
            map.matrix[0][at]
        };
        assert!((of(&|column| *column == Column::Gauge(0)) - 3.2).abs() < 1e-3);
        assert!((of(&|column| *column == Column::Offset) - 4.0).abs() < 0.1);
        let tested = &recordings.entries()[4].recording;
        let [a, b] = [&mean, &entered]
            .map(|analysis| analysis.calibration.apply(tested).unwrap().compensated);
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-7));
        assert!(entered.findings.len() == mean.findings.len());
        let far = with(Some(-20.0));
        let texts: Vec<String> =
            far.findings.iter().map(|finding| finding.text(Face::Page)).collect();
        assert!(
            texts.iter().any(|text| text.contains("T: the reference value is -20 °C")),
            "{texts:?}"
        );
    }

    /// Expected values come from the same least squares by QR on `[s₁, s₂, 1, T, T s₁, T s₂]`.
    #[test]
    fn predictions_are_those_of_a_qr_solution() {
        let recordings = set(drifting(30.0));
        let calibration = fitted(&recordings, |_| {}).calibration;
        let training: Vec<_> =
            recordings.entries()[..4].iter().map(|entry| &entry.recording).collect();
        let row = |recording: &Recording, k: usize| {
            let (s, t) = (recording.gauges_at(k), recording.auxiliary().at(k)[1]);
            [s[0], s[1], 1.0, t, t * s[0], t * s[1]]
        };
        let n = 4 * N;
        let x = Mat::from_fn(n, 6, |i, j| row(training[i / N], i % N)[j]);
        let y = Mat::from_fn(n, 1, |i, _| training[i / N].loads()[i % N]);
        let solution = x.col_piv_qr().solve_lstsq(&y);
        let tested = &recordings.entries()[4].recording;
        let loads = calibration.apply(tested).unwrap().compensated;
        for (k, load) in loads.iter().enumerate() {
            let expected: f64 =
                row(tested, k).iter().enumerate().map(|(j, x)| x * solution[(j, 0)]).sum();
            assert!((load - expected).abs() < 1e-7, "sample {k}: {load} instead of {expected}");
        }
    }

    /// A temperature noise of a few hundredths of a degree must not cause corrections at another temperature.
    #[test]
    fn a_temperature_that_hardly_moved_is_left_out_and_reported() {
        let mut recordings = drifting(0.5);
        recordings[4] = recording(3, 30.0);
        let analysis = fitted(&set(recordings), |_| {});
        let quality = &analysis.calibration.quality;
        assert_eq!(quality.compensated, quality.conventional);
        assert!(analysis.calibration.features.auxiliary.is_empty());
        let texts: Vec<String> =
            analysis.findings.iter().map(|finding| finding.text(Face::Page)).collect();
        let about = texts.iter().find(|text| text.contains("channel T left out")).unwrap();
        assert!(about.contains("at least 1 °C"), "{about}");
    }

    #[test]
    fn a_channel_that_one_recording_lacks_is_reported_and_not_used() {
        let mut recordings = drifting(30.0);
        let bare = &recordings[1];
        let only = ["U".to_owned()];
        recordings[1] = bare.with_auxiliary_of(&only).unwrap();
        let analysis = fitted(&set(recordings), |_| {});
        let texts: Vec<String> =
            analysis.findings.iter().map(|finding| finding.text(Face::Page)).collect();
        assert!(
            texts
                .iter()
                .any(|text| text.contains("the recording r2 has no auxiliary channel T in °C")),
            "{texts:?}"
        );
        assert!(analysis.calibration.features.auxiliary.is_empty());
    }

    #[test]
    fn a_recording_without_the_channel_is_refused_by_name() {
        let recordings = set(drifting(30.0));
        let calibration = fitted(&recordings, |_| {}).calibration;
        let only = ["U".to_owned()];
        let bare = recordings.entries()[4].recording.with_auxiliary_of(&only);
        let error = calibration.apply(&bare.unwrap()).unwrap_err().to_string();
        assert!(
            error.starts_with(
                "r3 has no auxiliary channel T [°C], which the calibration needs (its channels: U [V])"
            ),
            "{error}"
        );
    }

    #[test]
    fn a_file_and_an_estimator_give_the_numbers_of_a_whole_recording() {
        let recordings = set(drifting(30.0));
        for regressor in [Regressor::Linear, Regressor::HybridKernel, Regressor::Network] {
            let request = asked(&recordings, |settings| {
                settings.regressor = regressor;
                settings.network.epochs = 2;
                settings.kernel.landmarks = 20;
                settings.features.blocks = Blocks::default()
                    .with(&Auxiliary, &[0.0, 4.0])
                    .with(&Creep, &[1.0])
                    .with(&Polynomial, &[2.0]);
            });
            let calibration = train(&request, &Progress::default(), &mut |_| {}).unwrap();
            let text = serde_json::to_vec(&calibration.in_file()).unwrap();
            let read = Calibration::from_json(&text).unwrap();
            // A calibration file does not store values that only the fit knows.
            let mut kept = calibration.clone();
            kept.quality.free_coefficients = None;
            assert_eq!(read, kept);
            let names = read.feature_names();
            assert!(names.contains(&"aux1".to_owned()) && names.contains(&"aux1_4s*S2".to_owned()));
            let (first, rest) = recordings.entries()[4].recording.split(0.4).unwrap();
            let design = read.design();
            for part in [&first, &rest] {
                let mut estimator = Estimator::new(&read, &design).unwrap();
                let expected = read.apply(part).unwrap().compensated;
                for (k, expected) in expected.iter().enumerate() {
                    let warm = [part.auxiliary().at(k)[1]];
                    let updated = estimator.update_with(part.times()[k], part.gauges_at(k), &warm);
                    let load = updated.unwrap().1[0];
                    assert!(
                        (load - expected).abs() < 1e-9,
                        "{regressor:?}, sample {k}: {load} {expected}"
                    );
                }
            }
            let mut estimator = Estimator::new(&read, &design).unwrap();
            let (time, gauges) = (1e2, [50.0, 0.0]);
            assert!(estimator.update(time, &gauges).is_err());
            assert!(estimator.update_with(time, &gauges, &[f64::NAN]).is_err());
            let (status, _) = estimator.update_with(time, &gauges, &[90.0]).unwrap();
            assert!(status.has(Status::BEYOND));
        }
    }

    /// Without the drift, creep could only learn noise, which the ridge shrinks away.
    #[test]
    fn an_automatic_ridge_is_chosen_for_the_channels_by_themselves() {
        let recordings = set(drifting(30.0));
        let calibration = fitted(&recordings, |settings| {
            settings.ridge = RidgeChoice::Auto;
            settings.features.blocks.set(&Creep, vec![1.0]);
        })
        .calibration;
        let blocks = &calibration.quality.ridge_by_block;
        let names: Vec<&str> = blocks.iter().map(|ridge| ridge.block.as_str()).collect();
        assert_eq!(names, ["creep 1 s", "auxiliary T, 0 s"]);
        assert!(blocks[1].strengths[0].unwrap() < 1e-3);
        assert!(test_rmse(&calibration) < 1.2 * NOISE);
    }
}
