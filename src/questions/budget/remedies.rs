//! Remedies for the causes of an error, each with the error that cross-validation gives with it.

use std::sync::Arc;

use serde::Serialize;
use strum::IntoEnumIterator as _;

use crate::{
    calibration::{Calibration, ErrorBlocks, FitSettings, HARM, Regressor},
    dot::dot,
    features::{Auxiliary, Block, Creep, FeatureSettings, FixedLag, Play, Polynomial, Thresholds},
    progress::Progress,
    questions::{
        budget::{
            query::{ErrorBudget, pools},
            shown::Row,
        },
        dataset::Dataset,
        error::AnalysisError,
        request::Request,
    },
    recording::{Entry, RecordingSet, Role, Tare},
    scoring::{
        budget::{Cause, Shares},
        numbers::significant,
        rig::{RigReport, Run},
    },
};

/// Approximate maximum number of training samples with which features are compared. Of more samples, every n-th is used.
const ENOUGH_SAMPLES: usize = 60_000;
/// Smallest share of the mean squared error for which a remedy is searched.
const LEAST: f64 = 0.1;
/// Smallest share of slow changes, or of the unexplained error, from which the remedy is a measurement or another model.
const LARGE: f64 = 0.25;
/// Ratio of RMS errors up to which the features of a cause alone are preferred to the present features with them.
const NEARLY: f64 = 1.02;
/// Intervals of short lags, and length of a mean, in units of the time in which the load changes by a tenth of its variance.
const LAGS: [f64; 2] = [0.1, 0.4];
const MEAN: f64 = 0.1;

/// What removes a cause.
#[derive(Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Fit with these features.
    Features(Box<FeatureSettings>),
    /// Tare each recording over an interval without load.
    Tare,
    /// Set the reference to zero before each recording.
    ZeroReference,
    /// Leave out or mend the recording with this name.
    LeaveOut(String),
    /// Record a temperature with the gauges.
    RecordTemperature,
    /// Take the mean over this number of samples.
    Mean(usize),
    /// Try all models.
    TryModels,
}

/// Remedy for a cause.
#[derive(Debug, Serialize)]
pub struct Remedy {
    /// Cause that it removes; `None` for the unexplained error.
    pub cause: Option<Cause>,
    pub action: Action,
    /// RMS error that is left in each pool of axes (full scale); empty if it is unknown.
    pub errors: Vec<f64>,
}

impl Action {
    /// Returns the remedy in words.
    pub fn words(&self) -> String {
        match self {
            Self::Features(features) => format!("fit with {}", features.describe()),
            Self::Tare => "tare each recording".to_owned(),
            Self::ZeroReference => "set the reference to zero before each recording".to_owned(),
            Self::LeaveOut(name) => format!("leave out or mend {name}"),
            Self::RecordTemperature => "record a temperature".to_owned(),
            Self::Mean(n) => format!("mean over {n} samples"),
            Self::TryModels => "try all models".to_owned(),
        }
    }
}

impl Remedy {
    /// Returns the cause, the remedy in the words of `action`, and the error that it leaves.
    pub fn text(&self, action: &str, budget: &ErrorBudget) -> String {
        let cause = match (&self.action, self.cause) {
            (_, Some(cause)) => cause.name(budget.uncompensated.are_segments),
            (Action::Mean(_), None) => "noise",
            (_, None) => "unexplained",
        };
        let errors = self.errors.iter().zip(&budget.pools).map(|(error, pool)| {
            format!("{} {} % FS", pool.to_lowercase(), significant(100.0 * error, 3))
        });
        let errors: Vec<String> = errors.collect();
        let arrow = if errors.is_empty() { "" } else { " → " };
        format!("{cause}: {action}{arrow}{}", errors.join(", "))
    }
}

/// Squared errors of each held-out part in each pool of axes, in full scales.
#[derive(Clone)]
struct Errors {
    blocks: ErrorBlocks,
    of_pools: Vec<Vec<f64>>,
}

impl Errors {
    fn rms(&self) -> Vec<f64> {
        let n: f64 = self.blocks.samples.iter().sum();
        self.of_pools.iter().map(|own| (own.iter().sum::<f64>() / n).sqrt()).collect()
    }

    /// Returns true if the errors of a pool are lower beyond chance, and no pool is harmed.
    fn are_better_than(&self, other: &Self) -> bool {
        let mut pools = self.of_pools.iter().zip(&other.of_pools);
        let is_harmed = self.rms().iter().zip(other.rms()).any(|(own, other)| *own > HARM * other);
        !is_harmed && pools.any(|(own, other)| self.blocks.is_below(own, other, 1.0))
    }
}

struct Search<'a> {
    request: &'a Request,
    /// Settings of the linear fit whose error is to be lowered.
    settings: FitSettings,
    data: &'a Dataset,
    /// Step by which the samples are thinned.
    step: usize,
    calibration: &'a Calibration,
    change_samples: f64,
    progress: &'a Progress,
}

/// Returns the remedies for what is left of the error, those of the largest causes first.
///
/// # Errors
/// [`AnalysisError`] if the work was cancelled.
pub fn remedies(
    request: &Request,
    calibration: &Calibration,
    rig: &RigReport,
    budget: &ErrorBudget,
    progress: &Progress,
) -> Result<Vec<Remedy>, AnalysisError> {
    let data = request.datasets.get(&request.key(), progress)?;
    let left = budget.compensated.as_ref().unwrap_or(&budget.uncompensated);
    let pools: Vec<&Shares> = left.pools.iter().flatten().collect();
    // Largest part of the mean squared error in a pool of axes.
    let largest = |square: &dyn Fn(&Shares) -> f64| {
        pools.iter().map(|pool| square(pool) / pool.total).fold(0.0, f64::max)
    };
    // Errors that are left without a part of the mean square, if all pools have a budget.
    let without = |square: &dyn Fn(&Shares) -> f64| -> Vec<f64> {
        let error = |own: &&Shares| (own.total - square(own)).max(0.0).sqrt();
        let has_all = pools.len() == left.pools.len();
        pools.iter().filter(|_| has_all).map(error).collect()
    };
    let part = |cause: Cause| largest(&|pool| Row::Cause(cause).square(pool));
    let mut causes: Vec<Cause> = Cause::iter().filter(|cause| part(*cause) >= LEAST).collect();
    causes.sort_by(|a, b| part(*b).total_cmp(&part(*a)));
    let n: usize = data.training().iter().map(|own| own.n_samples()).sum();
    let mut settings = FitSettings { regressor: Regressor::Linear, ..request.settings.clone() };
    if budget.compensated.is_none() {
        let distance = settings.features.distance;
        settings.features = FeatureSettings { distance, ..FeatureSettings::present() };
    }
    let search = Search {
        request,
        settings,
        data: &data,
        step: n.div_ceil(ENOUGH_SAMPLES).max(1),
        calibration,
        change_samples: left.change_samples,
        progress,
    };
    let thinned = (search.step > 1 && !causes.is_empty()).then(|| data.thinned(search.step));
    let thin = thinned.as_ref().unwrap_or(&data);
    let before = if causes.is_empty() { None } else { search.errors(thin, &search.settings)? };
    let [zeros, drift, creep] = [Cause::Zeros, Cause::Drift, Cause::Creep].map(part);
    // Creep of all gauges alike leaves zeros that look like loads, too.
    let is_of_reference = rig.are_zeros_of_reference && creep < zeros;
    let mut found: Vec<Remedy> = Vec::new();
    for cause in causes {
        let Some(before) = &before else { break };
        let remedy = match cause {
            Cause::Zeros if is_of_reference => {
                Some((Action::ZeroReference, without(&|own| Row::Cause(cause).square(own))))
            }
            Cause::Zeros | Cause::Drift => search.tare(before)?,
            Cause::Sensitivity => search.leave_out(thin, rig, before)?,
            _ => search.features(thin, cause, before)?,
        };
        let remedy = remedy.map(|(action, errors)| Remedy { cause: Some(cause), action, errors });
        found.extend(remedy.filter(|own| found.iter().all(|other| other.action != own.action)));
    }
    let is_of_gauges = !is_of_reference && zeros.max(drift) >= LARGE;
    if is_of_gauges && !left.tested.contains(&Cause::Temperature) {
        let cause = Some(if zeros < drift { Cause::Drift } else { Cause::Zeros });
        found.push(Remedy { cause, action: Action::RecordTemperature, errors: Vec::new() });
    }
    let n_mean = (MEAN * left.change_samples) as usize;
    if n_mean > 1 && largest(&|pool| pool.noise) >= LEAST {
        let kept = 1.0 / n_mean as f64;
        let errors = without(&|own| (1.0 - kept) * own.noise);
        found.push(Remedy { cause: None, action: Action::Mean(n_mean), errors });
    }
    if largest(&|pool| pool.unexplained) >= LARGE {
        found.push(Remedy { cause: None, action: Action::TryModels, errors: Vec::new() });
    }
    Ok(found)
}

type Found = Result<Option<(Action, Vec<f64>)>, AnalysisError>;

impl Search<'_> {
    /// Returns the held-out errors of a fit; `None` if there is no such fit.
    fn errors(
        &self,
        data: &Dataset,
        settings: &FitSettings,
    ) -> Result<Option<Errors>, AnalysisError> {
        self.progress.check()?;
        let Ok(mut calibration) = data.blank_calibration(settings) else { return Ok(None) };
        let past = data.past(&calibration, self.progress)?;
        let fit = data.fit(settings.ridge, &past, &mut calibration, self.progress)?;
        let full_scale = &self.calibration.full_scale;
        Ok(fit.left_out.map(|own| {
            let of_pool = |axes: &Vec<usize>| {
                let weight = |axis| {
                    let is_in = axes.contains(&axis);
                    if is_in { full_scale[axis].powi(-2) / axes.len() as f64 } else { 0.0 }
                };
                let weights: Vec<f64> = (0..full_scale.len()).map(weight).collect();
                own.squares.chunks_exact(weights.len()).map(|row| dot(row, &weights)).collect()
            };
            let blocks = ErrorBlocks::of_parts(&own.part_samples);
            Errors { blocks, of_pools: pools(self.calibration).1.iter().map(of_pool).collect() }
        }))
    }

    /// Returns the features that describe a cause, if they lower the error.
    fn features(&self, thin: &Dataset, cause: Cause, before: &Errors) -> Found {
        let present = &self.settings.features;
        let secs = |share: f64| -> f64 {
            let rate = self.calibration.rate_hz.unwrap_or(1.0) / self.settings.decimation as f64;
            let secs = (share * self.change_samples).max(1.0).round() / rate;
            significant(secs, 3).parse().unwrap_or(secs)
        };
        let default = |block: &'static dyn Block| (block, block.setting().default.to_vec());
        let tried: Vec<(&'static dyn Block, Vec<f64>)> = match cause {
            Cause::Curvature => vec![(&Polynomial, vec![2.0]), (&Polynomial, vec![3.0])],
            Cause::Hysteresis => vec![default(&Play)],
            Cause::Creep => vec![default(&Creep)],
            Cause::Lag => {
                let mut lags = LAGS.map(secs).to_vec();
                lags.dedup();
                vec![(&FixedLag, lags)]
            }
            _ => vec![default(&Auxiliary)],
        };
        // Every n-th sample does not contain short lags.
        let (data, all_before) = if cause == Cause::Lag && self.step > 1 {
            (self.data, self.errors(self.data, &self.settings)?)
        } else {
            (thin, None)
        };
        let before = all_before.as_ref().unwrap_or(before);
        let alone = FeatureSettings { distance: present.distance, ..FeatureSettings::present() };
        let mut candidates: Vec<FeatureSettings> = Vec::new();
        for (block, values) in tried {
            for base in [&alone, present] {
                let mut features = base.clone();
                features.blocks.set(block, values.clone());
                candidates.push(features);
            }
        }
        if cause == Cause::Hysteresis && present.look_backs.is_empty() {
            let look_backs = vec![Thresholds::default_for(present.distance)];
            candidates.push(FeatureSettings { look_backs, ..present.clone() });
        }
        candidates.dedup();
        let mut best: Option<(FeatureSettings, Errors)> = None;
        for features in candidates.into_iter().filter(|own| own != present) {
            let settings = FitSettings { features, ..self.settings.clone() };
            let Some(errors) = self.errors(data, &settings)? else { continue };
            let sum = |own: &Errors| own.rms().iter().sum::<f64>();
            let is_less = best.as_ref().is_none_or(|(_, best)| NEARLY * sum(&errors) < sum(best));
            if is_less && errors.are_better_than(before) {
                best = Some((settings.features, errors));
            }
        }
        Ok(best.map(|(features, errors)| (Action::Features(Box::new(features)), errors.rms())))
    }

    /// Returns the errors of a fit to changed recordings; `None` if a recording cannot be changed like this.
    fn with_recordings(
        &self,
        change: impl Fn(&Entry) -> Option<Entry>,
    ) -> Result<Option<Errors>, AnalysisError> {
        let mut set = RecordingSet::default();
        let step = self.step * self.settings.decimation;
        for entry in self.request.recordings.entries() {
            self.progress.check()?;
            let Some(changed) = change(entry) else { return Ok(None) };
            let recording = Arc::new(changed.recording.decimated(step));
            if set.push(Entry { recording, ..changed }).is_err() {
                return Ok(None);
            }
        }
        let settings = FitSettings { decimation: 1, ..self.settings.clone() };
        let request = Request::fit(Arc::new(set), settings);
        let data = request.datasets.get(&request.key(), self.progress)?;
        self.errors(&data, &request.settings)
    }

    fn tare(&self, before: &Errors) -> Found {
        let tared = |entry: &Entry| {
            let recording = &*entry.recording;
            if entry.role != Role::Train {
                return Some(Entry { role: Role::Off, ..entry.clone() });
            }
            let tared = recording.tare().is_none().then(|| recording.clone().tared(Tare::Auto));
            Some(Entry { recording: Arc::new(tared?.ok()?.0), ..entry.clone() })
        };
        let after = self.with_recordings(tared)?.filter(|own| own.are_better_than(before));
        Ok(after.map(|own| (Action::Tare, own.rms())))
    }

    /// Returns the recording whose sensitivities differ most from the others, if the error of the others is lower without it.
    fn leave_out(&self, thin: &Dataset, rig: &RigReport, before: &Errors) -> Found {
        let differs = |run: &Run| {
            let all = run.sensitivities.iter().flatten();
            let all = all.map(|(value, error)| (value - 1.0).abs() - 2.0 * error);
            all.fold(0.0, f64::max)
        };
        let runs = rig.names.iter().zip(&rig.runs);
        let worst = runs.max_by(|a, b| differs(a.1).total_cmp(&differs(b.1)));
        let name = worst.map_or("", |(name, _)| name.as_str());
        let at = thin.entries.iter().position(|own| own.recording.name() == name);
        let (Some(at), true) = (at, thin.folds.are_whole) else { return Ok(None) };
        let is_out = |own: &Entry| own.recording.name() == name;
        let role = |own: &Entry| if is_out(own) { Role::Off } else { own.role };
        let others = self.with_recordings(|own| Some(Entry { role: role(own), ..own.clone() }))?;
        let mut before = before.clone();
        let part = thin.folds.pieces[at][0].fold;
        before.blocks.samples.remove(part);
        before.blocks.groups.pop();
        for squares in &mut before.of_pools {
            squares.remove(part);
        }
        let is_same = |own: &Errors| own.blocks.samples.len() == before.blocks.samples.len();
        let others = others.filter(|own| is_same(own) && own.are_better_than(&before));
        Ok(others.map(|own| (Action::LeaveOut(name.to_owned()), own.rms())))
    }
}
