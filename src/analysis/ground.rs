//! All that does not depend on the blocks: laid once for a set of recordings, used for every slider step.

use std::sync::Arc;
use std::time::Duration;

use rayon::prelude::*;

use crate::analysis::factory::Factory;
use crate::analysis::traces::{FixedTraces, TraceSet, View};
use crate::analysis::{Analysis, AnalysisError, RecordingResult, Request};
use crate::calibration::{
    Calibration, Conventional, FORMAT, FitSettings, LinearMap, Past, Quality, Scores, VERSION,
    loads_from_gauges, past_samples,
};
use crate::evaluation::metrics;
use crate::features::LoadPath;
use crate::progress::{Cancelled, Progress};
use crate::recording::{Entry, Recording, RecordingSet, Role};

/// RMSE per axis of one recording: conventional, compensated.
pub(super) type Errors = (Vec<f64>, Vec<f64>);

#[derive(Debug)]
pub(super) struct Ground {
    /// What it was laid for.
    recordings: Arc<RecordingSet>,
    offset: bool,
    decimation: usize,
    calibration: Option<Arc<Calibration>>,
    factory_calibration: Option<Arc<Calibration>>,
    /// What the factory's matrix gives.
    factory: Option<Factory>,
    /// The recordings as they are used.
    pub entries: Vec<Entry>,
    /// What the sums need; `None` where a calibration is applied.
    pub conventional: Option<Conventional>,
    pub map: LinearMap,
    /// Conventional loads of each recording.
    pub loads: Vec<Vec<f64>>,
    /// Half the peak-to-peak reference over the training recordings.
    half_ranges: Vec<f64>,
    /// The search of each recording, with the weights it was laid out for.
    paths: Vec<LoadPath>,
    path_weights: Vec<f64>,
    fixed_traces: Option<FixedTraces>,
}

impl Ground {
    pub fn holds(&self, request: &Request) -> bool {
        Arc::ptr_eq(&self.recordings, &request.recordings)
            && self.offset == request.settings.offset
            && self.decimation == request.settings.decimation
            && is_same(&self.calibration, &request.calibration)
            && is_same(&self.factory_calibration, &request.factory)
    }

    pub fn lay(request: &Request, progress: &Progress) -> Result<Self, AnalysisError> {
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
        entries
            .par_iter()
            .try_for_each(|entry| check_size(&entry.recording))?;
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
        let factory = request.factory.as_ref();
        let factory = factory
            .map(|factory| Factory::new(factory, &entries))
            .transpose()?;
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
            factory_calibration: request.factory.clone(),
            factory,
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

    pub fn analyse(
        &mut self,
        request: &Request,
        progress: &Progress,
    ) -> Result<Analysis, AnalysisError> {
        let mut calibration = match &request.calibration {
            Some(applied) => Calibration::clone(applied),
            None => self.blank_calibration(&request.settings)?,
        };
        let past = self.past(&calibration, progress)?;
        let errors = if request.calibration.is_some() {
            let own = calibration.quality.clone();
            let errors = self.score_applied(&past, &mut calibration);
            if request.trained {
                calibration.quality = own;
            }
            errors
        } else {
            self.fit(request.settings.ridge, &past, &mut calibration)
        };
        progress.check()?;
        let recordings = self
            .entries
            .iter()
            .zip(&past)
            .zip(errors)
            .map(|((entry, past), errors)| {
                let n_samples = entry.recording.n_samples();
                let (conventional_rmse, compensated_rmse) = errors.unzip();
                RecordingResult {
                    n_samples,
                    conventional_rmse,
                    compensated_rmse,
                    share_with_past: past.first().map(|past| {
                        let with_past = (0..).zip(past).filter(|(k, past)| k != *past).count();
                        with_past as f64 / n_samples as f64
                    }),
                }
            })
            .collect();
        let traces = self.traces(request.view, &calibration, &past);
        let factory = self.factory.as_ref();
        Ok(Analysis {
            factory: factory.map(|factory| factory.scores(&self.entries, &calibration.axes)),
            calibration: Arc::new(calibration),
            fitted: request.calibration.is_none() || request.trained,
            recordings,
            traces: Arc::new(traces),
            elapsed: Duration::ZERO,
        })
    }

    /// A calibration with everything but the compensated map and its quality.
    pub fn blank_calibration(&self, settings: &FitSettings) -> Result<Calibration, AnalysisError> {
        let layout = self.recordings.layout();
        if settings.full_scale.len() > layout.axes.len() {
            return Err(AnalysisError::FullScales {
                given: settings.full_scale.len(),
                axes: layout.axes.len(),
            });
        }
        settings
            .features
            .check_columns(layout.gauge_names.len())
            .map_err(crate::calibration::SettingsError::from)?;
        let full_scale = self
            .half_ranges
            .iter()
            .enumerate()
            .map(|(axis, measured)| {
                let entered = settings.full_scale.get(axis).copied().flatten();
                entered.unwrap_or(*measured)
            })
            .collect();
        let mut features = settings.features.clone();
        features.distance = features.distance.effective(&layout.axes);
        let conventional = self.conventional.as_ref().expect("fitting has laid it");
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
            features,
            gauge_scale: conventional.scale.clone(),
            regressor: crate::calibration::Regressor::Linear,
            conventional: self.map.clone(),
            compensated: None,
            learned: None,
            quality: Quality::default(),
            trained_on: in_role(&self.entries, Role::Train)
                .iter()
                .map(|recording| recording.name().to_owned())
                .collect(),
            rate_hz: self.recordings.rate_hz(Role::Train),
            sources: Vec::new(),
            tare: self.recordings.tare(),
        })
    }

    /// The past samples of every recording.
    pub fn past(
        &mut self,
        calibration: &Calibration,
        progress: &Progress,
    ) -> Result<Vec<Past>, Cancelled> {
        self.lay_paths(&calibration.distance_weights());
        self.entries
            .par_iter()
            .zip(&self.paths)
            .map(|(entry, path)| {
                progress.check()?;
                let past = past_samples(&calibration.features, path, &entry.recording);
                progress.advance(1);
                Ok(past)
            })
            .collect()
    }

    /// Lays the searches out for these weights of the axes.
    pub fn lay_paths(&mut self, weights: &[f64]) {
        if self.paths.is_empty() || self.path_weights != weights {
            self.paths = self
                .loads
                .par_iter()
                .map(|loads| LoadPath::new(loads, weights))
                .collect();
            self.path_weights = weights.to_vec();
        }
    }

    /// The searches as they were laid last.
    pub fn paths(&self) -> &[LoadPath] {
        &self.paths
    }

    /// Scores a whole calibration on the recordings whose reference has its axes, sample by sample.
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
                Some((rmse(&self.loads[at])?, rmse(&compensated)?))
            })
            .collect();
        let pooled = |role: Role, pick: fn(&Errors) -> &Vec<f64>| {
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
        let scores = |pick: fn(&Errors) -> &Vec<f64>| Scores {
            train_rmse: pooled(Role::Train, pick).0,
            test_rmse: pooled(Role::Test, pick).0,
            cv_rmse: None,
        };
        calibration.quality = Quality {
            n_train: pooled(Role::Train, |errors| &errors.0).1,
            n_test: pooled(Role::Test, |errors| &errors.0).1,
            conventional: scores(|errors| &errors.0),
            compensated: scores(|errors| &errors.1),
            ..std::mem::take(&mut calibration.quality)
        };
        errors
    }

    fn traces(&mut self, view: View, calibration: &Calibration, past: &[Past]) -> TraceSet {
        let view = view.within(self.entries.len());
        let fixed = match self.fixed_traces.take() {
            Some(fixed) if fixed.view() == view => fixed,
            _ => FixedTraces::new(
                view,
                &self.entries,
                &self.loads,
                &calibration.axes,
                self.factory.as_ref(),
            ),
        };
        let traces = fixed.with_past(&self.entries, calibration, past);
        self.fixed_traces = Some(fixed);
        traces
    }
}

/// Whether both are the same calibration, or none.
fn is_same(own: &Option<Arc<Calibration>>, asked: &Option<Arc<Calibration>>) -> bool {
    match (own, asked) {
        (None, None) => true,
        (Some(own), Some(asked)) => Arc::ptr_eq(own, asked),
        _ => false,
    }
}

/// The largest number whose squares can be summed over any recording.
const LARGEST: f64 = 1e140;

fn check_size(recording: &Recording) -> Result<(), AnalysisError> {
    for (values, width) in [
        (recording.gauges(), recording.n_gauges()),
        (recording.loads(), recording.axes().len()),
    ] {
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

pub(super) fn in_role(entries: &[Entry], role: Role) -> Vec<&Recording> {
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
