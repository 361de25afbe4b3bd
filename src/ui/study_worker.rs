//! The thread that makes maps of thresholds; what no threshold changes is laid once.

use std::sync::Arc;

use crate::analysis::{AnalysisError, Study, StudyEvent};
use crate::app::{Command, StudyCommand, StudyNews, StudyRequest};
use crate::calibration::FitSettings;
use crate::evaluation::threshold_study::ThresholdGrid;
use crate::progress::Progress;
use crate::recording::RecordingSet;
use crate::ui::dialogs::Reply;
use crate::engine::query::Worker;

/// The map has so many F_th, and so many t_th.
const MAP_SIDE: usize = 40;

/// Starts the thread; what it finds goes to `reply` piece by piece.
pub fn start(reply: Reply) -> Worker<StudyRequest, ()> {
    let notify = Arc::clone(&reply.notify);
    Worker::start("thresholds", notify, move || {
        let reply = reply.clone();
        let mut laid = None;
        move |request: StudyRequest, progress: &Progress| {
            let run = request.run;
            let tell = |news| reply.send(Command::Study(StudyCommand::Heard(run, news)));
            match study(&request, &mut laid, progress, &tell) {
                Ok(()) | Err(AnalysisError::Cancelled(_)) => {}
                Err(error) => tell(StudyNews::Failed(error.to_string())),
            }
        }
    })
}

/// A study with what it was laid for.
type Laid = (Arc<RecordingSet>, FitSettings, Study);

fn study(
    request: &StudyRequest,
    laid: &mut Option<Laid>,
    progress: &Progress,
    tell: &(dyn Fn(StudyNews) + Sync),
) -> Result<(), AnalysisError> {
    let StudyRequest {
        recordings,
        settings,
        thresholds,
        ..
    } = request;
    let holds = |(own, of, _): &Laid| Arc::ptr_eq(own, recordings) && of == settings;
    if !laid.as_ref().is_some_and(holds) {
        *laid = None;
        let study = Study::lay(Arc::clone(recordings), settings.clone(), progress)?;
        *laid = Some((Arc::clone(recordings), settings.clone(), study));
    }
    let (_, _, study) = laid.as_ref().expect("was just laid");
    tell(StudyNews::Touched(
        study.touch(*thresholds),
        study.mean_hysteresis(),
    ));
    if request.with_map {
        let grid = ThresholdGrid::covering(study.largest_distance(), MAP_SIDE, MAP_SIDE)
            .expect("the grid of the window is neither empty nor too large");
        study.threshold_map(&grid, progress, &|event| match event {
            StudyEvent::Laid(map) => tell(StudyNews::Laid(Arc::new(map.clone()))),
            StudyEvent::Row { f_at, points } => tell(StudyNews::Row(f_at, points.to_vec())),
        })?;
    }
    Ok(())
}
