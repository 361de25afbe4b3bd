//! Recordings and settings in, everything that is shown out.
//!
//! [`Analyst::analyse`] is the one function; an [`Analyst`] only remembers, between calls, what does not depend on the
//! blocks (the conventional calibration and its loads, the boxes of the search, the traces that stay). It always
//! answers at once, so what takes long is asked for apart: [`train`] for networks and kernels, [`compare`] for tables of
//! regressors, a [`Study`] for thresholds.

mod best;
mod cautions;
mod comparison;
mod cross_validated;
mod dataset;
mod factory;
mod fit;
mod intervals;
mod learning;
pub mod loops;
mod models;
mod report;
mod study;
mod traces;
mod training;

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::calibration::{
    Calibration, CalibrationError, FactoryScores, FitSettings, LearnedError, Past, SettingsError,
};
use crate::evaluation::metrology::MetrologySettings;
use crate::evaluation::threshold_study::{GridError, NoSuggestion};
use crate::panicked::Panicked;
use crate::progress::{Cancelled, Progress};
use crate::recording::RecordingSet;

use dataset::{Dataset, Key, is_same};
use factory::Factory;
use traces::FixedTraces;

pub use best::{Best, Search, Tried, find_best};
pub use cautions::{Caution, cautions};
pub use comparison::compare;
pub(crate) use comparison::{Candidate, ComparedRow, RowEvent, comparison_table, paper_candidates};
pub(crate) use cross_validated::cross_validation_cost;
pub use dataset::Datasets;
pub(crate) use factory::read_factory;
pub(crate) use intervals::{intervals_on_screen, intervals_within};
pub use learning::TrainingStep;
pub use models::{Cost, Mark, Model, ModelRow, RELATIVE, model_table};
pub use report::report;
pub(crate) use study::{BlockSuggestion, StudyEvent};
pub use study::{HistoryBlock, Study};
pub use traces::View;
pub(crate) use traces::{AxisTraces, Segment, TraceSet};
pub(crate) use training::train_unscored;
pub use training::{Scored, train, train_and_score};

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
    /// Whether that calibration was trained on these very recordings, so that its own scores stand.
    pub trained: bool,
    /// The calibration that the sensor came with: its conventional matrix gives one more trace, see [`read_factory`].
    pub factory: Option<Arc<Calibration>>,
    /// How loops and figures are measured, in a [`report`].
    pub measuring: MetrologySettings,
    /// What is shared with other questions about the same recordings.
    pub datasets: Datasets,
}

impl Request {
    /// Fits `recordings`, showing the first.
    pub fn fit(recordings: Arc<RecordingSet>, settings: FitSettings) -> Self {
        Self {
            recordings,
            settings,
            view: View::One(0),
            calibration: None,
            trained: false,
            factory: None,
            measuring: MetrologySettings::default(),
            datasets: Datasets::default(),
        }
    }
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
    /// How the factory's matrix does; `None` without one.
    pub factory: Option<FactoryScores>,
    /// What is to be known beside the scores.
    pub cautions: Vec<Caution>,
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
    /// What its group is called; `None` where it stands for itself.
    pub group: Option<String>,
    /// RMSE per axis with the present alone; `None` without a reference.
    pub conventional_rmse: Option<Vec<f64>>,
    /// RMSE per axis with the past; `None` without a reference.
    pub compensated_rmse: Option<Vec<f64>>,
    /// The share of samples whose past sample, by the first look-back, is another one; `None` without a look-back.
    pub share_with_past: Option<f64>,
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
    #[error(
        "{recording}: sample {sample} holds {value:e}, too large to be squared; leave that row out, or take a larger unit"
    )]
    TooLarge {
        recording: String,
        sample: usize,
        value: f64,
    },
    #[error(
        "the training recordings repeat no programme, or only one, so there are no few trajectories (C) beside the many"
    )]
    OneProgramme,
    #[error("{given} full scales are given for {axes} axes")]
    FullScales { given: usize, axes: usize },
    #[error(
        "with a part left out, {samples} training samples remain for {columns} features, too few to cross-validate; \
         record longer, add recordings in the train role, decimate less, or take fewer blocks"
    )]
    TooShort { samples: u64, columns: usize },
    #[error(
        "{t_ths} values of t_th for {columns} features and {parts} parts would fill the memory; take fewer values of t_th, \
         or fewer blocks"
    )]
    MapTooLarge {
        t_ths: usize,
        columns: usize,
        parts: usize,
    },
    #[error(transparent)]
    Grid(#[from] GridError),
    #[error(transparent)]
    NoSuggestion(#[from] NoSuggestion),
    #[error(transparent)]
    Settings(#[from] SettingsError),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error(transparent)]
    Learned(#[from] LearnedError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Panicked(#[from] Panicked),
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
    data: Option<Arc<Dataset>>,
    /// What the factory's matrix gives on that data.
    factory: Option<(Arc<Calibration>, Factory)>,
    fixed_traces: Option<FixedTraces>,
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
        let data = self.data(request, progress)?;
        let mut calibration = match &request.calibration {
            Some(applied) => Calibration::clone(applied),
            None => data.blank_calibration(&request.settings)?,
        };
        let past = data.past(&calibration, progress)?;
        let errors = if request.calibration.is_some() {
            let own = calibration.quality.clone();
            let errors = data.score_applied(&past, &mut calibration);
            if request.trained {
                calibration.quality = own;
            }
            errors
        } else {
            let fit = data.fit(request.settings.ridge, &past, &mut calibration);
            fit.errors
        };
        progress.check()?;
        let recordings = data
            .entries
            .iter()
            .zip(&past)
            .zip(errors)
            .enumerate()
            .map(|(at, ((entry, past), errors))| {
                let n_samples = entry.recording.n_samples();
                let (conventional_rmse, compensated_rmse) = errors.unzip();
                RecordingResult {
                    n_samples,
                    group: data.groups.name_of(at).map(str::to_owned),
                    conventional_rmse,
                    compensated_rmse,
                    share_with_past: past.first().map(|past| {
                        let with_past = (0..).zip(past).filter(|(k, past)| k != *past).count();
                        with_past as f64 / n_samples as f64
                    }),
                }
            })
            .collect();
        let traces = self.traces(&data, request.view, &calibration, &past);
        let factory = self.factory.as_ref();
        let fitted = request.calibration.is_none() || request.trained;
        Ok(Analysis {
            cautions: data.cautions(&calibration, fitted),
            factory: factory.map(|(_, factory)| factory.scores(&data.entries, &calibration.axes)),
            calibration: Arc::new(calibration),
            fitted,
            recordings,
            traces: Arc::new(traces),
            elapsed: start.elapsed(),
        })
    }

    /// The data that a request needs; what was made of other data goes.
    fn data(
        &mut self,
        request: &Request,
        progress: &Progress,
    ) -> Result<Arc<Dataset>, AnalysisError> {
        // Let go first: two sets of loads need not fit in memory at once.
        let before = self.data.take().map(|data| Arc::downgrade(&data));
        let data = request.datasets.get(&Key::of(request), progress)?;
        let is_other = before.is_none_or(|before| before.as_ptr() != Arc::as_ptr(&data));
        let own = self.factory.as_ref().map(|(own, _)| Arc::clone(own));
        if is_other || !is_same(&own, &request.factory) {
            (self.factory, self.fixed_traces) = (None, None);
            if let Some(factory) = &request.factory {
                let loads = Factory::new(factory, &data.entries)?;
                self.factory = Some((Arc::clone(factory), loads));
            }
        }
        self.data = Some(Arc::clone(&data));
        Ok(data)
    }

    fn traces(
        &mut self,
        data: &Dataset,
        view: View,
        calibration: &Calibration,
        past: &[Past],
    ) -> TraceSet {
        let view = view.within(data.entries.len());
        let fixed = match self.fixed_traces.take() {
            Some(fixed) if fixed.view() == view => fixed,
            _ => {
                let factory = self.factory.as_ref().map(|(_, factory)| factory);
                FixedTraces::new(view, &data.entries, &data.loads, &calibration.axes, factory)
            }
        };
        let traces = fixed.with_past(&data.entries, calibration, past);
        self.fixed_traces = Some(fixed);
        traces
    }
}
