//! Requests that train a model, or fit and score several models, in the background.

use std::sync::Arc;

use crate::{
    calibration::{Calibration, EpochReport},
    questions::{
        models::{
            best::{Best, Search, find_best},
            training::{TrainingStep, train},
        },
        question::{Answered, Query, Work},
        request::Request,
    },
    same::same_where,
};

/// Request to train a network or a kernel, which takes too long to be repeated at every step of a slider. A network that the
/// user stops keeps its best epoch.
#[derive(Clone)]
pub struct Train {
    pub request: Request,
    /// Function that receives the trained calibration at once, even while the window is hidden.
    pub on_trained: OnTrained,
}

same_where!(Train: shared() value(request) besides(on_trained));

pub type OnTrained = Arc<dyn Fn(&Request, &Arc<Calibration>) + Send + Sync>;

#[derive(Clone, Debug, Default)]
pub struct Trained {
    /// Report of the last epoch of a network's training.
    pub epoch: Option<EpochReport>,
    pub step: Option<TrainingStep>,
    pub calibration: Option<Arc<Calibration>>,
}

impl Trained {
    pub fn is_cross_validated(&self) -> bool {
        let calibration = self.calibration.as_ref();
        calibration.is_some_and(|calibration| calibration.quality.compensated.cv_rmse.is_some())
    }
}

impl Query for Train {
    type Answer = Trained;
    type Cache = ();
    const BEGUN_BY_USER: Option<&'static str> = Some("Training: ");

    fn title(&self) -> String {
        "Training".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { progress, show, .. } = work;
        let mut trained = Trained::default();
        show(trained.clone());
        let calibration = train(&self.request, progress, &mut |step| {
            trained.step = Some(step);
            if let TrainingStep::Epoch(report) = step {
                trained.epoch = Some(report);
            }
            show(trained.clone());
        })?;
        let calibration = Arc::new(calibration);
        (self.on_trained)(&self.request, &calibration);
        trained.calibration = Some(calibration);
        Ok(trained)
    }
}

/// Request to fit and score several models.
#[derive(Clone, Debug)]
pub struct TryModels {
    /// Number that distinguishes this request from other requests.
    pub run: u64,
    pub search: Search,
}

same_where!(TryModels: shared() value(run) besides(search));

impl Query for TryModels {
    type Answer = Best;
    type Cache = ();
    const BEGUN_BY_USER: Option<&'static str> = Some("Trying models: ");

    fn title(&self) -> String {
        "Finding the best model".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { progress, show, .. } = work;
        Ok(find_best(&self.search, progress, &|best| show(best.clone()))?)
    }
}
