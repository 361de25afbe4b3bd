//! Puts results of background work into the document.

use super::Engine;
use crate::{
    engine::{
        notice::Level,
        project::Edit,
        query::{Background as _, LaneEvent},
    },
    questions::{models::asked::TryModels, question::Unanswered, thresholds::asked::ChooseBlock},
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

    fn take_tasks(&mut self) {
        for ended in self.tasks.take() {
            match ended {
                Ok(change) => change(self),
                Err(Unanswered::Because(problem)) => self.notice(Level::Error, problem),
                Err(Unanswered::Cancelled) => {}
            }
        }
        self.begin_next();
    }
}
