//! Recordings and settings in, everything that is shown out.
//!
//! [`Analyst::analyse`] is the one function; an [`Analyst`] only remembers, between calls, what does not depend on the
//! thresholds (the conventional calibration and its loads, the boxes of the search, the traces that stay).

mod traces;

use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::calibration::{
    Calibration, CalibrationError, Columns, Conventional, FORMAT, FitSettings, LinearMap,
    NormalEquations, Piece, Quality, Scores, SettingsError, VERSION, condition_number, fit,
    loads_from_gauges, loads_from_history, recording_sums,
};
use crate::evaluation::cross_validation::{cross_validate, folds};
use crate::evaluation::metrics;
use crate::features::{Distance, LoadPath};
use crate::progress::{Cancelled, Progress};
use crate::recording::{Entry, Recording, RecordingSet, Role};

use traces::FixedTraces;
pub use traces::{AxisTraces, Segment, TraceSet, View};

/// What is to be analysed.
#[derive(Clone, Debug)]
pub struct Request {
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// The choices of the fit.
    pub settings: FitSettings,
    /// The recordings to make traces of.
    pub view: View,
    /// Where present, this is applied instead of fitting, and `settings` only gives the decimation.
    pub calibration: Option<Arc<Calibration>>,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The calibration, fitted or applied. Of an applied one, `quality` says how it does on the loaded recordings.
    pub calibration: Arc<Calibration>,
    /// Whether it was fitted to these recordings rather than applied.
    pub fitted: bool,
    /// One entry per recording of the set, in its order.
    pub recordings: Vec<RecordingResult>,
    /// What the panes draw.
    pub traces: Arc<TraceSet>,
    /// How long it took.
    pub elapsed: Duration,
}

/// How one recording came out.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingResult {
    /// Samples after decimation.
    pub n_samples: usize,
    /// RMSE per axis with the present alone; `None` without a reference.
    pub conventional_rmse: Option<Vec<f64>>,
    /// RMSE per axis with the past; `None` without a reference.
    pub compensated_rmse: Option<Vec<f64>>,
    /// The share of samples whose past sample is another one.
    pub share_with_past: f64,
}

/// Why there is no analysis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum AnalysisError {
    #[error("no recording is loaded; open a file, or the built-in sensor")]
    NoRecordings,
    #[error(
        "no recording is in the train role; give one the role Train, or open a calibration to apply"
    )]
    NoTraining,
    #[error("{given} full scales are given for {axes} axes")]
    FullScales { given: usize, axes: usize },
    #[error(transparent)]
    Settings(#[from] SettingsError),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Analyses once, remembering nothing.
///
/// # Errors
/// [`AnalysisError`] where the request cannot be met.
pub fn analyse(request: &Request, progress: &Progress) -> Result<Analysis, AnalysisError> {
    Analyst::default().analyse(request, progress)
}

/// Analyses again and again, keeping what a moved threshold does not change.
#[derive(Debug, Default)]
pub struct Analyst {
    ground: Option<Ground>,
}

impl Analyst {
    /// Fits (or applies) a calibration, scores it, and makes the traces.
    ///
    /// # Errors
    /// [`AnalysisError`] where the request cannot be met; what was remembered stays good.
    pub fn analyse(
        &mut self,
        request: &Request,
        progress: &Progress,
    ) -> Result<Analysis, AnalysisError> {
        let start = Instant::now();
        request.settings.validate()?;
        if request.recordings.entries().is_empty() {
            return Err(AnalysisError::NoRecordings);
        }
        progress.add_total(2 * request.recordings.entries().len() as u64);
        if !self
            .ground
            .as_ref()
            .is_some_and(|ground| ground.holds(request))
        {
            // Taken away first: two sets of loads need not fit in memory at once.
            self.ground = None;
            self.ground = Some(Ground::lay(request, progress)?);
        }
        let ground = self.ground.as_mut().expect("was just laid");
        let mut analysis = ground.analyse(request, progress)?;
        analysis.elapsed = start.elapsed();
        Ok(analysis)
    }
}

/// All that does not depend on thresholds.
#[derive(Debug)]
struct Ground {
    /// What it was laid for.
    recordings: Arc<RecordingSet>,
    offset: bool,
    decimation: usize,
    calibration: Option<Arc<Calibration>>,
    /// The recordings as they are used.
    entries: Vec<Entry>,
    /// What the sums need; `None` where a calibration is applied.
    conventional: Option<Conventional>,
    map: LinearMap,
    /// Conventional loads of each recording.
    loads: Vec<Vec<f64>>,
    /// Half the peak-to-peak reference over the training recordings.
    half_ranges: Vec<f64>,
    /// The search of each recording, with the weights it was laid out for.
    paths: Vec<LoadPath>,
    path_weights: Vec<f64>,
    fixed_traces: Option<FixedTraces>,
}

impl Ground {
    fn holds(&self, request: &Request) -> bool {
        Arc::ptr_eq(&self.recordings, &request.recordings)
            && self.offset == request.settings.offset
            && self.decimation == request.settings.decimation
            && match (&self.calibration, &request.calibration) {
                (None, None) => true,
                (Some(own), Some(asked)) => Arc::ptr_eq(own, asked),
                _ => false,
            }
    }

    fn lay(request: &Request, progress: &Progress) -> Result<Self, AnalysisError> {
        let FitSettings {
            offset, decimation, ..
        } = request.settings;
        let entries: Vec<Entry> = request
            .recordings
            .entries()
            .iter()
            .map(|entry| match decimation {
                1 => entry.clone(),
                step => Entry {
                    recording: Arc::new(entry.recording.decimated(step)),
                    role: entry.role,
                },
            })
            .collect();
        let training = in_role(&entries, Role::Train);
        let (conventional, map) = match &request.calibration {
            Some(calibration) => {
                for entry in &entries {
                    calibration.check_gauges(&entry.recording)?;
                }
                (None, calibration.conventional.clone())
            }
            None if training.is_empty() => return Err(AnalysisError::NoTraining),
            None => {
                let conventional = Conventional::fit(&training, offset);
                let map = conventional.map.clone();
                (Some(conventional), map)
            }
        };
        progress.check()?;
        let loads = entries
            .par_iter()
            .map(|entry| {
                progress.check()?;
                let loads = loads_from_gauges(&map, &entry.recording);
                progress.advance(1);
                Ok(loads)
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(Self {
            recordings: Arc::clone(&request.recordings),
            offset,
            decimation,
            calibration: request.calibration.clone(),
            half_ranges: half_ranges(&training),
            entries,
            conventional,
            map,
            loads,
            paths: Vec::new(),
            path_weights: Vec::new(),
            fixed_traces: None,
        })
    }

    fn analyse(
        &mut self,
        request: &Request,
        progress: &Progress,
    ) -> Result<Analysis, AnalysisError> {
        let mut calibration = match &request.calibration {
            Some(applied) => Calibration::clone(applied),
            None => self.blank_calibration(&request.settings)?,
        };
        self.lay_paths(&calibration);
        let past = self
            .entries
            .par_iter()
            .zip(&self.paths)
            .map(|(entry, path)| {
                progress.check()?;
                let past = path.past_samples(entry.recording.times(), calibration.thresholds);
                progress.advance(1);
                Ok(past)
            })
            .collect::<Result<Vec<_>, Cancelled>>()?;
        let errors = match &self.conventional {
            Some(conventional) => self.fit(conventional, &past, &mut calibration),
            None => self.score_applied(&past, &mut calibration),
        };
        progress.check()?;
        let recordings = self
            .entries
            .iter()
            .zip(&past)
            .zip(errors)
            .map(|((entry, past), errors)| {
                let n_samples = entry.recording.n_samples();
                let with_past = (0..).zip(past).filter(|(k, past)| k != *past).count();
                let (conventional_rmse, compensated_rmse) = errors.unzip();
                RecordingResult {
                    n_samples,
                    conventional_rmse,
                    compensated_rmse,
                    share_with_past: with_past as f64 / n_samples as f64,
                }
            })
            .collect();
        let traces = self.traces(request.view, &calibration, &past);
        Ok(Analysis {
            calibration: Arc::new(calibration),
            fitted: request.calibration.is_none(),
            recordings,
            traces: Arc::new(traces),
            elapsed: Duration::ZERO,
        })
    }

    /// A calibration with everything but the compensated map and its quality.
    fn blank_calibration(&self, settings: &FitSettings) -> Result<Calibration, AnalysisError> {
        let layout = self.recordings.layout();
        if settings.full_scale.len() > layout.axes.len() {
            return Err(AnalysisError::FullScales {
                given: settings.full_scale.len(),
                axes: layout.axes.len(),
            });
        }
        let full_scale = self
            .half_ranges
            .iter()
            .enumerate()
            .map(|(axis, measured)| {
                let entered = settings.full_scale.get(axis).copied().flatten();
                entered.unwrap_or(*measured)
            })
            .collect();
        Ok(Calibration {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: concat!("LoopScope ", env!("CARGO_PKG_VERSION")).to_owned(),
            simulated: self.recordings.is_simulated(),
            gauges: layout.gauge_names.clone(),
            axes: layout.axes.clone(),
            units: layout
                .axes
                .iter()
                .map(|axis| axis.unit().to_owned())
                .collect(),
            full_scale,
            offset: settings.offset,
            decimation: settings.decimation,
            thresholds: settings.thresholds,
            distance: settings.distance.effective(&layout.axes),
            conventional: self.map.clone(),
            compensated: LinearMap::default(),
            quality: Quality::default(),
            trained_on: in_role(&self.entries, Role::Train)
                .iter()
                .map(|recording| recording.name().to_owned())
                .collect(),
        })
    }

    fn lay_paths(&mut self, calibration: &Calibration) {
        let Calibration {
            distance,
            axes,
            full_scale,
            ..
        } = calibration;
        let weights = Distance::weights(*distance, axes, full_scale);
        if self.paths.is_empty() || self.path_weights != weights {
            self.paths = self
                .loads
                .par_iter()
                .map(|loads| LoadPath::new(loads, &weights))
                .collect();
            self.path_weights = weights;
        }
    }

    /// Fits the compensated map from sums alone; returns each recording's errors (conventional, compensated).
    fn fit(
        &self,
        conventional: &Conventional,
        past: &[Vec<u32>],
        calibration: &mut Calibration,
    ) -> Vec<Option<(Vec<f64>, Vec<f64>)>> {
        let n_axes = calibration.axes.len();
        let columns = Columns {
            n_gauges: calibration.gauges.len(),
            with_past: true,
            offset: calibration.offset,
        };
        let lengths: Vec<usize> = in_role(&self.entries, Role::Train)
            .iter()
            .map(|recording| recording.n_samples())
            .collect();
        let mut training_pieces = folds(&lengths).into_iter();
        let pieces: Vec<Vec<Piece>> = self
            .entries
            .iter()
            .map(|entry| match entry.role {
                Role::Train => training_pieces.next().expect("one list per recording"),
                Role::Test | Role::Off => vec![Piece {
                    samples: 0..entry.recording.n_samples(),
                    fold: 0,
                }],
            })
            .collect();
        let sums: Vec<Vec<NormalEquations>> = self
            .entries
            .par_iter()
            .enumerate()
            .map(|(at, entry)| {
                if !entry.recording.has_reference() {
                    return Vec::new();
                }
                recording_sums(
                    &entry.recording,
                    &conventional.scale,
                    columns,
                    &self.loads[at],
                    &past[at],
                    &pieces[at],
                )
            })
            .collect();
        let empty = || NormalEquations::new(columns.count(), n_axes);
        let (mut train, mut test) = (empty(), empty());
        let n_folds = pieces.iter().flatten().map(|piece| piece.fold + 1).max();
        let mut parts = vec![empty(); n_folds.unwrap_or(0)];
        for ((entry, pieces), sums) in self.entries.iter().zip(&pieces).zip(&sums) {
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
        let (all, present) = (columns.all(), columns.present());
        // The targets are what the conventional map leaves over, so zero coefficients stand for that map.
        let none = vec![0.0; columns.count() * n_axes];
        let mut found = fit(&train, &all);
        if found.rank == fit(&train, &present).rank {
            // The past never differs: the compensated map is the conventional one, to the last bit.
            found.coefficients.clone_from(&none);
        }
        calibration.compensated = columns.raw_map(
            &calibration.gauges,
            &self.map,
            &conventional.scale,
            &found.coefficients,
        );
        let scores = |coefficients: &[f64], used: &[usize]| Scores {
            train_rmse: metrics::rmse(&train, coefficients),
            test_rmse: metrics::rmse(&test, coefficients),
            cv_rmse: cross_validate(&train, &parts, used),
        };
        calibration.quality = Quality {
            n_train: train.n_samples(),
            n_test: test.n_samples(),
            conventional: scores(&none, &present),
            compensated: scores(&found.coefficients, &all),
            rank: found.rank,
            condition: condition_number(&train, &all, found.rank),
        };
        sums.iter()
            .map(|pieces| {
                let mut whole = empty();
                pieces.iter().for_each(|piece| whole.add(piece));
                let before = metrics::rmse(&whole, &none)?;
                Some((before, metrics::rmse(&whole, &found.coefficients)?))
            })
            .collect()
    }

    /// Scores an applied calibration on the recordings whose reference has its axes.
    fn score_applied(
        &self,
        past: &[Vec<u32>],
        calibration: &mut Calibration,
    ) -> Vec<Option<(Vec<f64>, Vec<f64>)>> {
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
                let compensated =
                    loads_from_history(&calibration.compensated, recording, &past[at]);
                let rmse = |loads: &[f64]| metrics::rmse_of_loads(loads, recording.loads(), n_axes);
                Some((rmse(&self.loads[at])?, rmse(&compensated)?))
            })
            .collect();
        let pooled = |role: Role, pick: PickErrors| {
            let mut squares = vec![0.0; n_axes];
            let mut n = 0;
            for (entry, errors) in self.entries.iter().zip(&errors) {
                if let Some(errors) = errors
                    && entry.role == role
                {
                    let samples = entry.recording.n_samples();
                    for (square, rmse) in squares.iter_mut().zip(pick(errors)) {
                        *square += rmse * rmse * samples as f64;
                    }
                    n += samples as u64;
                }
            }
            (metrics::root_mean(&squares, n), n)
        };
        let scores = |pick: PickErrors| Scores {
            train_rmse: pooled(Role::Train, pick).0,
            test_rmse: pooled(Role::Test, pick).0,
            cv_rmse: None,
        };
        calibration.quality = Quality {
            n_train: pooled(Role::Train, |errors| &errors.0).1,
            n_test: pooled(Role::Test, |errors| &errors.0).1,
            conventional: scores(|errors| &errors.0),
            compensated: scores(|errors| &errors.1),
            ..calibration.quality
        };
        errors
    }

    fn traces(&mut self, view: View, calibration: &Calibration, past: &[Vec<u32>]) -> TraceSet {
        let view = view.within(self.entries.len());
        let fixed = match self.fixed_traces.take() {
            Some(fixed) if fixed.view() == view => fixed,
            _ => FixedTraces::new(view, &self.entries, &self.loads, &calibration.axes),
        };
        let traces = fixed.with_past(&self.entries, calibration, past);
        self.fixed_traces = Some(fixed);
        traces
    }
}

/// Of a recording's errors per axis, those of the conventional or those of the compensated map.
type PickErrors = fn(&(Vec<f64>, Vec<f64>)) -> &Vec<f64>;

fn in_role(entries: &[Entry], role: Role) -> Vec<&Recording> {
    entries
        .iter()
        .filter(|entry| entry.role == role)
        .map(|entry| &*entry.recording)
        .collect()
}

/// Half the peak-to-peak reference load of each axis.
fn half_ranges(recordings: &[&Recording]) -> Vec<f64> {
    let n_axes = recordings
        .first()
        .map_or(0, |recording| recording.axes().len());
    (0..n_axes)
        .map(|axis| {
            let (low, high) = recordings
                .iter()
                .flat_map(|recording| recording.loads().iter().skip(axis).step_by(n_axes))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                    (low.min(*value), high.max(*value))
                });
            0.5 * (high - low)
        })
        .collect()
}
