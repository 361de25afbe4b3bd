//! Compares the errors of a compensated calibration with those of the conventional calibration after a cold start, when no
//! earlier gauge values are known.

use std::sync::Arc;

use crate::{
    calibration::{Calibration, ErrorBlocks, HARM},
    finding::{Finding, Id, Verdict},
    questions::{
        dataset::Dataset,
        error::AnalysisError,
        question::{Answered, Query, Work},
        request::Request,
    },
    recording::{Recording, Role, in_role},
    same::same_where,
    scoring::numbers::significant,
};

/// Number of simulated cold starts in each training recording, evenly distributed.
const STARTS: usize = 8;
/// The calibration is compared with the conventional one in an interval after a cold start, which is halved until the
/// calibration is worse there. This is the maximum number of halvings.
const HALVINGS: i32 = 6;

/// Returns the finding that the calibration errs more than the conventional one for some time after a cold start. To
/// measure this, the calibration is started anew at several samples of each training recording, as if a robot were
/// switched on under load.
///
/// # Errors
/// [`AnalysisError`] if the calibration cannot be applied.
pub fn worse_at_start(
    data: &Dataset,
    calibration: &Calibration,
) -> Result<Option<Finding>, AnalysisError> {
    if !calibration.features.has_memory() {
        return Ok(None);
    }
    let training = in_role(&data.entries, Role::Train).into_iter();
    let timed = training.filter(|recording| !recording.is_static());
    let runs: Vec<_> = timed.flat_map(|recording| recording.segments(STARTS)).collect();
    let longest = runs.iter().map(Recording::duration_secs).fold(0.0, f64::max);
    let n_axes = calibration.axes.len();
    let applied = runs.iter().map(|run| calibration.apply(run)).collect::<Result<Vec<_>, _>>()?;
    let worse = (0..=HALVINGS).find_map(|halvings| {
        let secs = longest * 0.5_f64.powi(halvings);
        let [mut samples, mut compensated, mut conventional] = [const { Vec::new() }; 3];
        for (run, applied) in runs.iter().zip(&applied) {
            let start = run.times().first().copied().unwrap_or_default();
            let n = run.times().iter().take_while(|time| *time - start <= secs).count();
            let square = |loads: &[f64]| -> f64 {
                let errors = loads.iter().zip(run.loads()).take(n * n_axes);
                let scaled = errors.zip(calibration.full_scale.iter().cycle());
                let scaled = scaled.filter(|(_, scale)| **scale > 0.0);
                scaled.map(|((computed, load), scale)| ((computed - load) / scale).powi(2)).sum()
            };
            samples.push(n as f64);
            compensated.push(square(&applied.compensated));
            conventional.push(square(&applied.conventional));
        }
        let blocks = ErrorBlocks { groups: vec![0; samples.len()], samples };
        let ratio = (compensated.iter().sum::<f64>() / conventional.iter().sum::<f64>()).sqrt();
        blocks.is_below(&conventional, &compensated, 1.0 / HARM).then_some((secs, ratio))
    });
    Ok(worse.map(|(secs, ratio)| {
        let [secs, ratio] = [secs, ratio].map(|value| significant(value, 2));
        let seen = format!(
            "the calibration is on average worse than the conventional one in the first {secs} s after a cold start"
        );
        let figures = format!("{ratio} times the error of the conventional calibration, in {} simulated starts", runs.len());
        Finding::new(Id::ColdStart, Verdict::Doubtful, seen).with(figures)
    }))
}

/// Request for the finding of [`worse_at_start`]: how long after a cold start a fitted calibration errs more than
/// the conventional one.
#[derive(Clone, Debug)]
pub struct AskColdStart {
    pub request: Request,
    pub calibration: Arc<Calibration>,
}

same_where!(AskColdStart: shared(calibration) value(request) besides());

impl Query for AskColdStart {
    type Answer = Option<Finding>;
    type Cache = ();

    fn title(&self) -> String {
        "Cold start".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let data = self.request.datasets.get(&self.request.key(), work.progress)?;
        Ok(worse_at_start(&data, &self.calibration)?)
    }
}
