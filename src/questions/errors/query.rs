//! Fits or applies a calibration, and computes its errors and traces.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::{
    calibration::{Calibration, FactoryScores, Past},
    finding::Finding,
    progress::{Cancelled, Progress},
    questions::{
        dataset::{Dataset, Errors, Key},
        error::AnalysisError,
        errors::{
            factory::Factory,
            findings::findings_of_fit,
            traces::{FixedTraces, TraceSet},
        },
        question::{Answered, Query, Work},
        request::{Request, View},
    },
    recording::Entry,
    same::Shared as _,
    scoring::MANY_SAMPLES,
};

/// Result of fitting or applying a calibration.
#[derive(Debug)]
pub struct Analysis {
    /// Fitted or applied calibration. The `quality` of an applied calibration is measured on the loaded recordings.
    pub calibration: Arc<Calibration>,
    /// True if the calibration was fitted to these recordings, false if an existing calibration was applied to them.
    pub fitted: bool,
    /// Results of all recordings, in the order of the recording set.
    pub recordings: Vec<RecordingResult>,
    /// Errors of the factory calibration; `None` without a factory calibration.
    pub factory: Option<FactoryScores>,
    /// Findings about the recordings and the fit.
    pub findings: Vec<Finding>,
    /// Traces of loads and errors that the window draws.
    pub traces: Arc<TraceSet>,
    /// Computing time of the analysis.
    pub elapsed: Duration,
    /// For a preview, the number n if every n-th sample is used; `None` for a complete analysis.
    pub preview_of: Option<usize>,
}

/// Result of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingResult {
    /// Number of samples of the recording after decimation.
    pub n_samples: usize,
    /// Name of the recording's group; `None` for an ungrouped recording.
    pub group: Option<String>,
    /// RMSE of the uncompensated load for each axis (N or N·m); `None` without a reference load.
    pub conventional_rmse: Option<Vec<f64>>,
    /// RMSE of the compensated load for each axis (N or N·m); `None` without a reference load.
    pub compensated_rmse: Option<Vec<f64>>,
}

/// Fits or applies a calibration as requested, and computes its errors and traces.
///
/// # Errors
/// [`AnalysisError`] if the recordings or settings allow no analysis, or if the work was cancelled.
pub fn analyse(request: &Request, progress: &Progress) -> Result<Analysis, AnalysisError> {
    Analyst::default().analyse(request, progress)
}

/// Computes one analysis after another, and keeps the data that do not depend on the look-back thresholds for the next one.
#[derive(Debug, Default)]
pub struct Analyst {
    data: Option<Arc<Dataset>>,
    factory: Option<(Arc<Calibration>, Factory)>,
    fixed_traces: Option<FixedTraces>,
    /// Decimated data from which previews are computed, if there are many samples.
    thinned: Option<Dataset>,
}

/// Approximate maximum number of samples in a preview.
const PREVIEW_SAMPLES: usize = 100_000;

impl Analyst {
    /// Fits or applies a calibration, and computes its errors and traces.
    ///
    /// # Errors
    /// Those of [`analyse`]. The kept data stay valid after an error.
    pub fn analyse(
        &mut self,
        request: &Request,
        progress: &Progress,
    ) -> Result<Analysis, AnalysisError> {
        self.analyse_showing(request, progress, None)
    }

    /// Analyses like [`Self::analyse`]. If there are many samples, `show` first receives a preview that uses every n-th
    /// sample.
    ///
    /// # Errors
    /// As [`Self::analyse`].
    pub fn analyse_showing(
        &mut self,
        request: &Request,
        progress: &Progress,
        show: Option<&dyn Fn(Analysis)>,
    ) -> Result<Analysis, AnalysisError> {
        let start = Instant::now();
        request.settings.validate()?;
        if request.recordings.entries().is_empty() {
            return Err(AnalysisError::NoRecordings);
        }
        progress.add_total(2 * request.recordings.entries().len() as u64);
        if let Some(show) = show
            && let Some(preview) = self.first_preview(request, progress)
        {
            show(preview);
        }
        let data = self.data(request, progress)?;
        if let Some(show) = show
            && let Some(preview) = self.preview(&data, request, progress)
        {
            show(preview);
        }
        let exact = self.exactly(&data, request, progress)?;
        Ok(Analysis { elapsed: start.elapsed(), ..exact })
    }

    fn exactly(
        &mut self,
        data: &Dataset,
        request: &Request,
        progress: &Progress,
    ) -> Result<Analysis, AnalysisError> {
        let mut calibration = match &request.calibration {
            Some(applied) => Calibration::clone(applied),
            None => data.unfitted(&request.settings, progress)?,
        };
        let past = data.past(&calibration, progress)?;
        let errors = if request.calibration.is_some() {
            let measured = calibration.quality.clone();
            let errors = data.score_applied(&past, &mut calibration);
            if request.trained {
                calibration.quality = measured;
            }
            errors
        } else {
            data.fit(request.settings.ridge, &past, &mut calibration, progress)?.errors
        };
        progress.check()?;
        let recordings = results(data, errors);
        let traces = self.traces(data, request.view, &calibration, &Arc::new(past), progress)?;
        let fitted = request.calibration.is_none() || request.trained;
        Ok(self.analysis(data, calibration, fitted, recordings, traces))
    }

    /// Returns a preview that uses every n-th sample. Returns `None` if there are few samples, if the samples were not
    /// analysed before, or if a calibration is applied, because a preview would then take as long as the analysis.
    fn preview(
        &mut self,
        data: &Dataset,
        request: &Request,
        progress: &Progress,
    ) -> Option<Analysis> {
        let view = request.view.within(data.entries.len());
        let fixed = self.fixed_traces.as_ref().filter(|fixed| fixed.view == view)?;
        if data.kept_loads().is_some() || request.calibration.is_some() {
            return None;
        }
        let each = n_samples(&data.entries).div_ceil(PREVIEW_SAMPLES);
        let thinned = self.thinned.get_or_insert_with(|| data.thinned(each));
        let (calibration, past, recordings) =
            fit_of_thinned(thinned, &data.entries, request, progress)?;
        let traces = fixed.preview(thinned, &calibration, &Arc::new(past), each);
        let analysis = self.analysis(data, calibration, true, recordings, traces);
        Some(Analysis { preview_of: Some(each), ..analysis })
    }

    /// Returns a preview that uses every n-th sample, if there are many samples and they were not analysed before. It is
    /// computed before all samples are prepared for the fit, which takes much longer.
    fn first_preview(&self, request: &Request, progress: &Progress) -> Option<Analysis> {
        let entries = request.recordings.entries();
        let is_known = self.data.as_ref().is_some_and(|data| data.is_of(&request.recordings));
        let n_samples = n_samples(entries);
        let is_thinned = request.settings.decimation > 1 || request.recordings.is_static();
        let is_fitted = request.calibration.is_none() && !is_thinned;
        if is_known || !is_fitted || n_samples <= MANY_SAMPLES {
            return None;
        }
        let each = n_samples.div_ceil(PREVIEW_SAMPLES);
        let key = Key { decimation: each, ..request.key() };
        let thinned = Dataset::prepare(&key, &progress.part()).ok()?;
        let (calibration, past, recordings) = fit_of_thinned(&thinned, entries, request, progress)?;
        let view = request.view.within(entries.len());
        let fixed = FixedTraces::held(view, entries, &thinned, &calibration, each);
        let traces = fixed.preview(&thinned, &calibration, &Arc::new(past), each);
        let analysis = Self::default().analysis(&thinned, calibration, true, recordings, traces);
        Some(Analysis { preview_of: Some(each), ..analysis })
    }

    fn analysis(
        &self,
        data: &Dataset,
        calibration: Calibration,
        fitted: bool,
        recordings: Vec<RecordingResult>,
        traces: TraceSet,
    ) -> Analysis {
        let factory = self.factory.as_ref();
        Analysis {
            findings: findings_of_fit(data, &calibration, fitted),
            factory: factory.map(|(_, factory)| factory.scores(&data.entries, &calibration.axes)),
            calibration: Arc::new(calibration),
            fitted,
            recordings,
            traces: Arc::new(traces),
            elapsed: Duration::ZERO,
            preview_of: None,
        }
    }

    fn data(
        &mut self,
        request: &Request,
        progress: &Progress,
    ) -> Result<Arc<Dataset>, AnalysisError> {
        // The kept data of the previous request are dropped first, because the data of two requests may not fit in memory.
        let before = self.data.take().map(|data| Arc::downgrade(&data));
        let data = request.datasets.get(&request.key(), progress)?;
        let is_other = before.is_none_or(|before| before.as_ptr() != Arc::as_ptr(&data));
        let known = self.factory.as_ref().map(|(known, _)| Arc::clone(known));
        if is_other || known.place() != request.factory.place() {
            (self.factory, self.fixed_traces) = (None, None);
            if is_other {
                self.thinned = None;
            }
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
        past: &Arc<Vec<Past>>,
        progress: &Progress,
    ) -> Result<TraceSet, Cancelled> {
        let view = view.within(data.entries.len());
        let fixed = match self.fixed_traces.take() {
            Some(fixed) if fixed.view == view => fixed,
            _ => {
                let factory = self.factory.as_ref().map(|(_, factory)| factory);
                FixedTraces::new(view, data, calibration, factory, progress)?
            }
        };
        let fixed = self.fixed_traces.insert(fixed);
        fixed.with_past(data, calibration, past, progress)
    }
}

/// Fits the settings of a request to thinned recordings. `entries` contains all their samples.
fn fit_of_thinned(
    thinned: &Dataset,
    entries: &[Entry],
    request: &Request,
    progress: &Progress,
) -> Option<(Calibration, Vec<Past>, Vec<RecordingResult>)> {
    let mut calibration = thinned.blank_calibration(&request.settings).ok()?;
    let progress = progress.part();
    let past = thinned.past(&calibration, &progress).ok()?;
    let fit = thinned.fit(request.settings.ridge, &past, &mut calibration, &progress);
    let mut recordings = results(thinned, fit.ok()?.errors);
    for (result, entry) in recordings.iter_mut().zip(entries) {
        result.n_samples = entry.recording.n_samples();
    }
    Some((calibration, past, recordings))
}

fn n_samples(entries: &[Entry]) -> usize {
    entries.iter().map(|entry| entry.recording.n_samples()).sum()
}

fn results(data: &Dataset, errors: Vec<Option<Errors>>) -> Vec<RecordingResult> {
    let entries = data.entries.iter().zip(errors).enumerate();
    let results = entries.map(|(at, (entry, errors))| {
        let n_samples = entry.recording.n_samples();
        let (conventional_rmse, compensated_rmse) = errors.unzip();
        RecordingResult {
            n_samples,
            group: data.groups.name_of(at).map(str::to_owned),
            conventional_rmse,
            compensated_rmse,
        }
    });
    results.collect()
}

/// Request to fit or apply a calibration, and to compute its errors and load traces in the background.
#[derive(Clone, Debug, PartialEq)]
pub struct Analyse(pub Request);

impl Query for Analyse {
    type Answer = Arc<Analysis>;
    type Cache = Analyst;
    const PATIENCE_ONCE_SHOWN: Duration = Duration::ZERO;

    fn title(&self) -> String {
        "Updating".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { cache: analyst, progress, show } = work;
        let show = |preview| show(Arc::new(preview));
        let analysis = analyst.analyse_showing(&self.0, progress, Some(&show))?;
        Ok(Arc::new(analysis))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::calibration::FitSettings;
    use crate::features::{Blocks, Creep, FeatureSettings, Polynomial, Thresholds};
    use crate::recording::{Axis, Recording, RecordingSet, Role, Source, simulated};
    use crate::scoring::Series;

    fn request(features: FeatureSettings) -> Request {
        let settings = FitSettings { features, ..FitSettings::default() };
        Request { view: View::All, ..Request::fit(Arc::new(simulated::recordings(5)), settings) }
    }

    /// Returns an analysis that computes loads again at each use, as for very many samples.
    fn of_many(request: &Request) -> (Analyst, Dataset, Analysis) {
        let progress = Progress::default();
        let data = Dataset::prepare(&request.key(), &progress).unwrap();
        let data = data.with_loads_made();
        let mut analyst = Analyst::default();
        let analysis = analyst.exactly(&data, request, &progress);
        (analyst, data, analysis.unwrap())
    }

    fn values(series: &Series) -> Vec<f64> {
        let mut values = Vec::new();
        series.each(0..series.len(), |value| values.push(value));
        values
    }

    #[test]
    fn a_moved_threshold_gives_the_same_bits_as_a_new_fit() {
        let two = FeatureSettings {
            look_backs: vec![Thresholds::default(); 2],
            ..FeatureSettings::present()
        };
        let creeping = FeatureSettings {
            blocks: Blocks::default().with(&Creep, &[4.0]).with(&Polynomial, &[2.0]),
            ..FeatureSettings::default()
        };
        for features in [two, creeping] {
            let mut request = request(features);
            let mut analyst = Analyst::default();
            for f_th in [1.0, 5.0, 0.0, 3.0] {
                request.settings.features.look_backs[0].f_th = f_th;
                let moved = analyst.analyse(&request, &Progress::default()).unwrap();
                let anew = analyse(&request, &Progress::default()).unwrap();
                assert_eq!(moved.calibration, anew.calibration);
                assert_eq!(moved.recordings, anew.recordings);
            }
        }
    }

    #[test]
    fn computed_loads_equal_stored_loads() {
        let two = FeatureSettings {
            look_backs: vec![Thresholds::default(); 2],
            blocks: Blocks::default().with(&Polynomial, &[2.0]),
            ..FeatureSettings::present()
        };
        let creeping = FeatureSettings {
            blocks: Blocks::default().with(&Creep, &[4.0]),
            ..FeatureSettings::default()
        };
        for features in [two, creeping] {
            let request = request(features);
            let kept = analyse(&request, &Progress::default()).unwrap();
            let (_, _, made) = of_many(&request);
            assert_eq!(made.calibration, kept.calibration);
            assert_eq!(made.recordings, kept.recordings);
            for (made, kept) in made.traces.axes.iter().zip(&kept.traces.axes) {
                assert_eq!(values(&made.conventional), values(&kept.conventional));
                assert_eq!(values(&made.compensated), values(&kept.compensated));
                let errors = [made, kept].map(|axis| axis.compensated_error.as_ref().unwrap());
                assert_eq!(values(errors[0]), values(errors[1]));
                let part = 8_000..9_001;
                assert_eq!(errors[0].min_max(part.clone()), errors[1].min_max(part));
            }
        }
    }

    #[test]
    fn a_preview_has_the_exact_traces_of_the_present_and_nearly_those_of_the_past() {
        let mut request = request(FeatureSettings::default());
        let (mut analyst, data, before) = of_many(&request);
        request.settings.features.look_backs[0].f_th = 5.0;
        let progress = Progress::default();
        let preview = analyst.preview(&data, &request, &progress);
        let preview = preview.expect("the samples were analysed before");
        assert_eq!(preview.preview_of, Some(3));
        let exact = analyst.exactly(&data, &request, &progress);
        let exact = exact.unwrap();
        let rmse = |of: &Analysis| {
            let quality = &of.calibration.quality;
            quality.compensated.test_rmse.clone().unwrap()
        };
        let all = rmse(&preview).into_iter().zip(rmse(&exact)).zip(rmse(&before));
        for ((preview, exact), before) in all {
            let moved = (exact - before).abs();
            let off = (preview - exact).abs();
            assert!(off < 0.02 * exact + 0.5 * moved, "{preview} for {exact}");
        }
        let (shown, traces) = (&preview.traces, &exact.traces);
        assert!(Arc::ptr_eq(&shown.times, &traces.times), "the zoomed range stays");
        let n = shown.times.len();
        for (shown, traces) in shown.axes.iter().zip(&traces.axes) {
            assert!(Arc::ptr_eq(&shown.conventional, &traces.conventional));
            assert_eq!(shown.compensated.len(), n);
            let values = values(&shown.compensated);
            let is_held = |held: &[f64]| held.iter().all(|value| *value == held[0]);
            assert!(values.chunks(3).all(is_held));
        }
        let agree = (0..n).filter(|k| shown.past_of(*k).abs_diff(traces.past_of(*k)) <= 6);
        let agree = agree.count();
        assert!(agree > n * 8 / 10, "{agree} of {n}");
    }
    #[test]
    fn many_samples_are_shown_before_the_first_fit() {
        let n = MANY_SAMPLES + 7;
        let load = |k: usize| 10.0 * (1e-3 * k as f64).sin();
        let recording = Recording::new(
            "r",
            Source::Simulated,
            (0..n).map(|k| 1e-3 * k as f64).collect(),
            vec!["S1".to_owned()],
            (0..n).map(|k| 2.0 * load(k) + 0.1 * (0.3 * k as f64).cos()).collect(),
            vec![Axis::Fz],
            (0..n).map(load).collect(),
        );
        let mut set = RecordingSet::default();
        set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
        let settings =
            FitSettings { features: FeatureSettings::present(), ..FitSettings::default() };
        let request = Request::fit(Arc::new(set), settings);
        let shown = Mutex::new(Vec::new());
        let mut analyst = Analyst::default();
        let show = |preview| shown.lock().unwrap().push(preview);
        let exact = analyst.analyse_showing(&request, &Progress::default(), Some(&show)).unwrap();
        let shown = shown.into_inner().unwrap();
        let [preview] = &shown[..] else { panic!("one preview: {}", shown.len()) };
        let each = preview.preview_of.unwrap();
        assert_eq!((preview.traces.times.len(), preview.recordings[0].n_samples), (n, n));
        let axis = |of: &Analysis| of.traces.axes[0].clone();
        let truth = [&exact, preview].map(|of| axis(of).calculated.unwrap());
        for k in [0, 1000, n - 1] {
            assert_eq!(truth[1].value(k), truth[0].value(k - k % each));
        }
        let [a, b] = [&exact, preview]
            .map(|of| of.calibration.quality.conventional.train_rmse.as_ref().unwrap()[0]);
        assert!((a - b).abs() < 0.05 * a, "{a} {b}");
    }
}
