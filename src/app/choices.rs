//! What undo and redo go back and forward over: every setting and role, which recordings are open, and which calibration is
//! applied or compared with.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::app::{AppState, Applied, Effect, FactoryCalibration};
use crate::calibration::{Calibration, FitSettings};
use crate::recording::{Axis, RecordingSet};

/// The choices of one moment. Recordings are shared, not copied.
#[derive(Clone, Debug)]
pub struct Choices {
    settings: FitSettings,
    recordings: Arc<RecordingSet>,
    unsplit: Option<Arc<RecordingSet>>,
    cut: f64,
    hidden_axes: Vec<Axis>,
    applied: Option<Applied>,
    factory: Option<FactoryCalibration>,
}

impl PartialEq for Choices {
    /// Whether nothing was chosen in between; recordings are not compared number by number.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.recordings, &other.recordings)
            && self.unsplit.as_ref().map(Arc::as_ptr) == other.unsplit.as_ref().map(Arc::as_ptr)
            && self.settings == other.settings
            && self.hidden_axes == other.hidden_axes
            && self.calibrations() == other.calibrations()
    }
}

impl Choices {
    /// Which calibrations they are; equal ones that were opened twice count as two.
    fn calibrations(&self) -> [Option<*const Calibration>; 2] {
        [
            self.applied.as_ref().map(|one| &one.calibration),
            self.factory.as_ref().map(|one| &one.calibration),
        ]
        .map(|calibration| calibration.map(Arc::as_ptr))
    }
}

/// More steps than this are forgotten, oldest first.
const MOST_STEPS: usize = 100;

/// The choices of before and after, step by step.
#[derive(Clone, Debug, Default)]
pub struct History {
    before: VecDeque<Choices>,
    now: Option<Choices>,
    /// The last one is the next.
    after: Vec<Choices>,
    /// What the last step was made with.
    gesture: Option<u64>,
}

impl History {
    /// Keeps the choices of now, which are a step if they are others than before. What changes with one and the same gesture,
    /// as while a slider is dragged, is one step; what opened the first recordings is none.
    pub fn follow(&mut self, choices: Choices, gesture: Option<u64>) {
        let Some(last) = &self.now else {
            self.now = Some(choices);
            return;
        };
        if *last == choices {
            return;
        }
        let goes_on = gesture.is_some()
            && gesture == self.gesture
            && Arc::ptr_eq(&last.recordings, &choices.recordings);
        let begins = self.before.is_empty() && last.recordings.entries().is_empty();
        let last = self.now.replace(choices);
        if !goes_on && !begins {
            self.before.extend(last);
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

    /// The choices of a step before, which are those of now from here on.
    pub fn undo(&mut self) -> Option<Choices> {
        let before = self.before.pop_back()?;
        self.after.extend(self.now.replace(before));
        self.gesture = None;
        self.now.clone()
    }

    /// The choices of the step that was taken back last, which are those of now from here on.
    pub fn redo(&mut self) -> Option<Choices> {
        let after = self.after.pop()?;
        self.before.extend(self.now.replace(after));
        self.gesture = None;
        self.now.clone()
    }
}

impl AppState {
    /// The choices of now.
    #[must_use]
    pub fn choices(&self) -> Choices {
        Choices {
            settings: self.settings.clone(),
            recordings: Arc::clone(&self.recordings),
            unsplit: self.unsplit.clone(),
            cut: self.cut,
            hidden_axes: self.hidden_axes.clone(),
            applied: self.applied.clone(),
            factory: self.factory.clone(),
        }
    }

    /// Goes to the choices of another moment.
    pub(super) fn restore(&mut self, choices: Choices) -> Vec<Effect> {
        let Choices {
            settings,
            recordings,
            unsplit,
            cut,
            hidden_axes,
            applied,
            factory,
        } = choices;
        let parts = |set: &RecordingSet| -> Vec<_> {
            set.entries()
                .iter()
                .map(|entry| Arc::as_ptr(&entry.recording))
                .collect()
        };
        let same_order = parts(&self.recordings) == parts(&recordings);
        let same_columns = self.recordings.layout() == recordings.layout();
        self.settings = settings;
        self.recordings = recordings;
        self.unsplit = unsplit;
        self.cut = cut;
        self.hidden_axes = hidden_axes;
        self.applied = applied;
        self.factory = factory;
        if !same_columns {
            self.analysis = None;
        }
        if !same_order {
            self.forget_results();
            self.view = self.view.within(self.recordings.entries().len());
        }
        self.analyse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{Command, Opened};
    use crate::import::Loaded;
    use crate::recording::{Recording, Role, Source};

    fn open(state: &mut AppState, name: &str, gauge: &str) {
        let values: Vec<f64> = (0..40).map(|k| f64::from(k * k % 17)).collect();
        let recording = Recording::new(
            name,
            Source::File(name.into()),
            (0..40).map(f64::from).collect(),
            vec![gauge.to_owned()],
            values.clone(),
            vec![Axis::Fz],
            values,
        );
        let loaded = Loaded {
            recordings: vec![recording.unwrap()],
            warnings: Vec::new(),
            map: None,
        };
        let opened = Ok(Opened::Recordings(loaded, None));
        state.apply(Command::FilesOpened(vec![(name.into(), opened)]));
        follow(state, None);
    }

    fn follow(state: &mut AppState, gesture: Option<u64>) {
        state.history.follow(state.choices(), gesture);
    }

    fn set_f_th(state: &mut AppState, f_th: f64, gesture: Option<u64>) {
        let mut settings = state.settings.clone();
        settings.features.look_backs[0].f_th = f_th;
        state.apply(Command::SetSettings(settings));
        follow(state, gesture);
    }

    fn f_th(state: &AppState) -> f64 {
        state.settings.features.look_backs[0].f_th
    }

    /// What the window does when it is asked to undo.
    #[track_caller]
    fn undo(state: &mut AppState) {
        let before = state.history.undo().expect("a step to take back");
        state.apply(Command::Restore(before));
        follow(state, None);
    }

    #[track_caller]
    fn redo(state: &mut AppState) {
        let after = state.history.redo().expect("a step to make again");
        state.apply(Command::Restore(after));
        follow(state, None);
    }

    fn names(state: &AppState) -> Vec<&str> {
        let entries = state.recordings.entries().iter();
        entries.map(|entry| entry.recording.name()).collect()
    }

    #[test]
    fn each_choice_is_a_step_and_a_gesture_is_one() {
        let mut state = AppState::default();
        follow(&mut state, None);
        open(&mut state, "a", "S1");
        assert!(!state.history.can_undo(), "nothing was there before");
        let first = f_th(&state);
        for (value, gesture) in [(1.0, None), (1.5, None), (2.0, Some(7)), (2.5, Some(8))] {
            set_f_th(&mut state, value, gesture);
        }
        for at in 1..20 {
            set_f_th(&mut state, 2.5 + f64::from(at), Some(8));
        }
        for expected in [2.0, 1.5, 1.0, first] {
            undo(&mut state);
            assert_eq!(f_th(&state), expected);
        }
        assert!(!state.history.can_undo());
        for expected in [1.0, 1.5, 2.0, 21.5] {
            redo(&mut state);
            assert_eq!(f_th(&state), expected);
        }
        undo(&mut state);
        set_f_th(&mut state, 9.0, Some(8));
        assert!(!state.history.can_redo(), "another way was taken");
    }

    #[test]
    fn opening_files_is_a_step_and_those_before_it_stay() {
        let mut state = AppState::default();
        follow(&mut state, None);
        open(&mut state, "a", "S1");
        let first = f_th(&state);
        set_f_th(&mut state, 1.5, None);
        state.apply(Command::SetRole(0, Role::Off));
        follow(&mut state, None);
        // While a slider is held, too.
        set_f_th(&mut state, 2.5, Some(1));
        open(&mut state, "b", "S1");
        state.apply(Command::CloseRecordings);
        follow(&mut state, None);
        open(&mut state, "other", "G1");
        undo(&mut state);
        undo(&mut state);
        assert_eq!((names(&state), f_th(&state)), (vec!["a", "b"], 2.5));
        undo(&mut state);
        undo(&mut state);
        assert_eq!((names(&state), f_th(&state)), (vec!["a"], 1.5));
        assert_eq!(state.recordings.entries()[0].role, Role::Off);
        undo(&mut state);
        assert_eq!(state.recordings.entries()[0].role, Role::Train);
        undo(&mut state);
        assert_eq!((names(&state), f_th(&state)), (vec!["a"], first));
        for _ in 0..6 {
            redo(&mut state);
        }
        assert_eq!(names(&state), ["other"]);
    }
}
