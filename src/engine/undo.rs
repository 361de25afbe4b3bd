//! Going back and forward over the edits of a document.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::engine::Project;

/// More steps than this are forgotten, oldest first.
const MOST_STEPS: usize = 100;

/// The documents of before and after, step by step.
#[derive(Clone, Debug, Default)]
pub struct History {
    before: VecDeque<Project>,
    /// The last one is the next.
    after: Vec<Project>,
    /// What the last step was made with.
    gesture: Option<u64>,
}

impl History {
    /// Keeps what a document was before an edit. What changes with one and the same gesture, as while a slider is dragged, is
    /// one step; what opened the first recordings is none.
    pub fn step(&mut self, before: Project, now: &Project, gesture: Option<u64>) {
        if before.is_same(now) {
            return;
        }
        let goes_on = gesture.is_some()
            && gesture == self.gesture
            && Arc::ptr_eq(&before.recordings, &now.recordings);
        let begins = self.before.is_empty() && before.recordings.entries().is_empty();
        if !goes_on && !begins {
            self.before.push_back(before);
            let surplus = self.before.len().saturating_sub(MOST_STEPS);
            self.before.drain(..surplus);
        }
        self.after.clear();
        self.gesture = gesture;
    }

    /// Whether there is a step to take back.
    #[must_use]
    pub fn can_undo(&self) -> bool {
        !self.before.is_empty()
    }

    /// Whether there is a step to make again.
    #[must_use]
    pub fn can_redo(&self) -> bool {
        !self.after.is_empty()
    }

    /// Takes the last step back.
    pub fn undo(&mut self, project: &mut Project) {
        if let Some(before) = self.before.pop_back() {
            let before = project.with_edits_of(before);
            self.after.push(std::mem::replace(project, before));
            self.gesture = None;
        }
    }

    /// Makes the step again that was taken back last.
    pub fn redo(&mut self, project: &mut Project) {
        if let Some(after) = self.after.pop() {
            let after = project.with_edits_of(after);
            self.before.push_back(std::mem::replace(project, after));
            self.gesture = None;
        }
    }
}
