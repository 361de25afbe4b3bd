//! Questions of the loop pane and the metrology pane, answered off the window's thread.
//!
//! The last answer of each kind stays on screen while the next is made; answers about other recordings go.

use std::sync::Arc;

use crate::analysis::Analysis;
use crate::analysis::loops::{
    CrossPicture, Look, LookError, LookRequest, LoopPicture, Question, RestPicture, TableQuestion,
    Viewer,
};
use crate::app::AppState;
use crate::evaluation::metrology::Metrology;
use crate::progress::Progress;
use crate::recording::RecordingSet;
use crate::engine::query::{Notify, Worker};

/// The worker, with what it was asked last and what it has answered.
pub struct Looking {
    worker: Worker<LookRequest, Result<Look, LookError>>,
    asked: Option<Asked>,
    /// The first request about the recordings of now.
    since: u64,
    /// The last answers.
    pub seen: Seen,
}

/// The last answer of each kind.
#[derive(Default)]
pub struct Seen {
    /// Loops of one axis.
    pub loops: Option<LoopPicture>,
    /// A cross-plot.
    pub cross: Option<CrossPicture>,
    /// Rests.
    pub rests: Option<RestPicture>,
    /// The table, with its question.
    pub table: Option<(Arc<Metrology>, TableQuestion)>,
    /// Why the newest question has no answer.
    pub problem: Option<String>,
}

/// What a question was about; the same again needs no second answer.
struct Asked {
    analysis: Arc<Analysis>,
    recordings: Arc<RecordingSet>,
    visible: Option<(f64, f64)>,
    question: Question,
}

impl Looking {
    /// Starts the thread.
    pub fn start(notify: Notify) -> Self {
        let worker = Worker::start("loops", notify, || {
            let mut viewer = Viewer::default();
            move |request: LookRequest, progress: &Progress| viewer.look(&request, progress)
        });
        Self {
            worker,
            asked: None,
            since: 0,
            seen: Seen::default(),
        }
    }

    /// Whether all that was asked is answered.
    pub fn is_idle(&self) -> bool {
        self.worker.is_idle()
    }

    /// Stops what runs.
    pub fn cancel(&self) {
        self.worker.cancel();
    }

    /// Asks, unless this is what was asked last.
    pub fn ask(
        &mut self,
        state: &AppState,
        visible: Option<(f64, f64)>,
        question: Option<Question>,
    ) {
        let (Some(analysis), Some(question)) = (&state.analysis, question) else {
            return;
        };
        let visible = visible.filter(|_| question.follows_screen());
        let recordings = &state.recordings;
        if let Some(asked) = &self.asked
            && Arc::ptr_eq(&asked.analysis, analysis)
            && Arc::ptr_eq(&asked.recordings, recordings)
            && (asked.visible, &asked.question) == (visible, &question)
        {
            return;
        }
        let generation = self.worker.request(LookRequest {
            calibration: Arc::clone(&analysis.calibration),
            recordings: Arc::clone(recordings),
            decimation: state.settings.decimation,
            traces: Arc::clone(&analysis.traces),
            visible,
            question: question.clone(),
        });
        let same = |asked: &Asked| Arc::ptr_eq(&asked.recordings, recordings);
        if !self.asked.as_ref().is_some_and(same) {
            self.since = generation;
            self.seen = Seen::default();
        }
        self.asked = Some(Asked {
            analysis: Arc::clone(analysis),
            recordings: Arc::clone(recordings),
            visible,
            question,
        });
    }

    /// Takes what has been answered.
    pub fn take_answers(&mut self) {
        while let Some(answer) = self.worker.answer() {
            if answer.generation < self.since {
                continue; // the recordings are others now
            }
            let seen = &mut self.seen;
            match answer.result {
                Ok(Ok(look)) => {
                    seen.problem = None;
                    match look {
                        Look::Loops(picture) => seen.loops = Some(picture),
                        Look::Cross(picture) => seen.cross = Some(picture),
                        Look::Rests(picture) => seen.rests = Some(picture),
                        Look::Table(table, question) => seen.table = Some((table, question)),
                    }
                }
                Ok(Err(LookError::Cancelled(_))) => {}
                Ok(Err(error)) => seen.problem = Some(error.to_string()),
                Err(panicked) => seen.problem = Some(panicked.to_string()),
            }
        }
    }
}
