//! Puts results of background work into the document.

use std::sync::Arc;

use super::{Engine, Leaving};
use crate::{
    engine::{
        files::Opened,
        notice::Level,
        project::Edit,
        query::{Background as _, LaneEvent},
        task::Done,
    },
    questions::{models::asked::TryModels, thresholds::asked::ChooseBlock},
};

impl Engine {
    /// Puts the finished results of background work into the document. The window calls this before each frame.
    pub fn take(&mut self) {
        // This is checked before the results are taken. If no search runs now, all results of the search have arrived.
        let have_ended = self.lane::<TryModels>().is_idle();
        for failed in self.lanes.take() {
            self.notice(Level::Error, failed);
        }
        self.take_models(have_ended);
        let choice = self.lane::<ChooseBlock>();
        if choice.happened().contains(&LaneEvent::Answer)
            && let Some(chosen) = choice.answer().cloned()
        {
            self.edit(Edit::Block(chosen));
        }
        self.following.take_events();
        self.take_preview();
        self.take_tasks();
        self.take_first_thresholds();
        self.list_present();
        self.follow();
    }

    pub(super) fn take_tasks(&mut self) {
        for (done, problem) in self.tasks.take() {
            problem.into_iter().for_each(|problem| self.notice(Level::Error, problem));
            done.into_iter().for_each(|done| self.finish(done));
        }
        self.begin_next();
    }

    pub(in crate::engine) fn finish(&mut self, done: Done) {
        match done {
            Done::Opened(files) => {
                let has_session =
                    files.iter().any(|(_, file)| matches!(file, Ok(Opened::Session(_))));
                if has_session {
                    self.leave_for(Leaving::Open(files));
                } else {
                    self.take_files(files);
                }
            }
            Done::Simulated(before, _) if !Arc::ptr_eq(&before, &self.project.recordings) => {}
            Done::Changed(before, ..) | Done::ReadAgain(before, _)
                if !Arc::ptr_eq(&before, &self.project.recordings) =>
            {
                let text = "The recordings changed while they were tared, read again or searched for faulty samples, so the \
                            result was discarded. Repeat the action.";
                self.notice(Level::Warning, text);
            }
            Done::Changed(_, changed, warnings) => {
                self.edit(Edit::Replace(Arc::new(changed)));
                warnings.into_iter().for_each(|text| self.notice(Level::Warning, text));
            }
            Done::ReadAgain(_, parts) => self.take_read_again(parts),
            Done::Simulated(_, set) => self.take_simulated(set),
            Done::Written(content, files) => self.take_written(content, files),
            Done::Map(map) => self.take_map(*map),
            Done::Weight(path, estimate) => self.take_weight(&path, &estimate),
            Done::Restored(path, opened) => self.leave_for(Leaving::Restore(path, opened)),
            Done::Located(place, found) => self.take_located(&place, found),
            Done::Proven(trained, recordings, proven) => {
                self.take_proven(trained, recordings, proven);
            }
            Done::Listed(recordings, model, true) => self.models.keep(*model, &recordings),
            Done::Listed(recordings, model, false) => {
                self.models.take_present(*model, &recordings);
            }
        }
    }
}
