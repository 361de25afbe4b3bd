//! Undo and redo.

use std::collections::{HashSet, VecDeque};
use std::sync::Arc;

use crate::{engine::project::Project, recording::Recording};

const MAX_STEPS: usize = 100;
/// Maximum amount of memory for undo, as a count of numbers (8 bytes each, so 2 GB) in recordings that only undo steps use.
/// Above it, the oldest undo steps are removed, but never the newest.
const MAX_NUMBERS: usize = 1 << 28;

/// Documents before and after the present one, to which undo and redo return.
#[derive(Clone, Debug, Default)]
pub struct History {
    before: VecDeque<Project>,
    /// Documents to which redo returns. The last one is the next to be restored.
    after: Vec<Project>,
    gesture: Option<u64>,
}

impl History {
    /// Adds the document before an edit as an undo step. The edits of one gesture, such as a drag of a slider, are one step.
    /// Opening the first recordings is no step.
    pub fn step(&mut self, before: Project, now: &Project, gesture: Option<u64>) {
        if before == *now {
            return;
        }
        let goes_on = gesture.is_some()
            && gesture == self.gesture
            && Arc::ptr_eq(&before.recordings, &now.recordings);
        let begins = self.before.is_empty() && before.recordings.entries().is_empty();
        if !goes_on && !begins {
            self.before.push_back(before);
            let surplus = self.before.len().saturating_sub(MAX_STEPS);
            self.before.drain(..surplus);
            self.forget_beyond(MAX_NUMBERS, now);
        }
        self.after.clear();
        self.gesture = gesture;
    }

    fn forget_beyond(&mut self, numbers: usize, now: &Project) {
        while self.before.len() > 1 && self.numbers_beside(now) > numbers {
            self.before.pop_front();
        }
    }

    /// Returns the count of numbers in those recordings that only undo steps use.
    fn numbers_beside(&self, now: &Project) -> usize {
        let recordings = |project: &Project| -> Vec<Arc<Recording>> {
            let whole = project.split.iter().map(|split| &split.whole);
            let sets = whole.chain([&project.recordings]);
            let entries = sets.flat_map(|set| set.entries());
            entries.map(|entry| Arc::clone(&entry.recording)).collect()
        };
        let mut counted: HashSet<_> = recordings(now).iter().map(Arc::as_ptr).collect();
        let earlier = self.before.iter().flat_map(recordings);
        let other = earlier.filter(|recording| counted.insert(Arc::as_ptr(recording)));
        let width = |recording: &Recording| {
            1 + recording.n_gauges()
                + recording.axes().len()
                + recording.auxiliary().len()
                + recording.others().len()
        };
        other.map(|recording| recording.n_samples() * width(&recording)).sum()
    }

    pub fn can_undo(&self) -> bool {
        !self.before.is_empty()
    }

    pub fn can_redo(&self) -> bool {
        !self.after.is_empty()
    }

    pub fn undo(&mut self, project: &mut Project) {
        if let Some(before) = self.before.pop_back() {
            let before = project.with_edits_of(before);
            self.after.push(std::mem::replace(project, before));
            self.gesture = None;
        }
    }

    pub fn redo(&mut self, project: &mut Project) {
        if let Some(after) = self.after.pop() {
            let after = project.with_edits_of(after);
            self.before.push_back(std::mem::replace(project, after));
            self.gesture = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::project::{Edit, FromFile};
    use crate::engine::tests::{
        FORCES, GAUGES, add, built_in, fitted, names, of_file, roles, with_files,
    };
    use crate::features::{Creep, Play, Thresholds};
    use crate::import::map::ColumnMap;
    use crate::questions::metrology::MetrologySettings;
    use crate::questions::{BlockSuggestion, View};
    use crate::recording::{Axis, GaugeRange, Identity, Item, Role, SensorFrame};

    #[test]
    fn steps_with_too_many_numbers_are_removed_except_the_newest() {
        let (mut project, mut history) = (with_files(), History::default());
        let of_one = project.recordings.entries()[0].recording.n_samples() * 7;
        for _ in 0..4 {
            let mut set = crate::recording::RecordingSet::clone(&project.recordings);
            let other = Recording::clone(&set.entries()[0].recording);
            set.replace(0, other);
            edit(&mut project, &mut history, Edit::Replace(Arc::new(set)), None);
        }
        assert_eq!(history.numbers_beside(&project), 4 * of_one);
        history.forget_beyond(3 * of_one, &project);
        assert_eq!((history.before.len(), history.numbers_beside(&project)), (3, 3 * of_one));
        history.forget_beyond(0, &project);
        assert_eq!(history.before.len(), 1);
    }

    /// Makes an edit as the engine does.
    #[track_caller]
    fn edit(project: &mut Project, history: &mut History, edit: Edit, gesture: Option<u64>) {
        let before = project.clone();
        project.edit(edit).unwrap();
        history.step(before, project, gesture);
    }

    #[track_caller]
    fn open(project: &mut Project, history: &mut History, name: &str, gauge: &str) {
        let before = project.clone();
        add(project, name, &[gauge], &[Axis::Fz]);
        history.step(before, project, None);
    }

    #[track_caller]
    fn undo(project: &mut Project, history: &mut History) {
        assert!(history.can_undo(), "a step can be undone");
        history.undo(project);
    }

    #[track_caller]
    fn redo(project: &mut Project, history: &mut History) {
        assert!(history.can_redo(), "a step can be redone");
        history.redo(project);
    }

    fn with_f_th(project: &Project, f_th: f64) -> Edit {
        let mut settings = project.settings.clone();
        settings.features.look_backs[0].f_th = f_th;
        Edit::Settings(settings)
    }

    fn f_th(project: &Project) -> f64 {
        project.settings.features.look_backs[0].f_th
    }

    #[test]
    fn each_choice_is_a_step_and_a_gesture_is_one() {
        let (mut project, mut history) = (Project::default(), History::default());
        open(&mut project, &mut history, "a", "S1");
        assert!(!history.can_undo(), "opening the first recordings is no step");
        let first = f_th(&project);
        let set = |project: &mut Project, history: &mut History, f_th, gesture| {
            let other = with_f_th(project, f_th);
            edit(project, history, other, gesture);
        };
        for (value, gesture) in [(1.0, None), (1.5, None), (2.0, Some(7)), (2.5, Some(8))] {
            set(&mut project, &mut history, value, gesture);
        }
        for at in 1..20 {
            set(&mut project, &mut history, 2.5 + f64::from(at), Some(8));
        }
        for expected in [2.0, 1.5, 1.0, first] {
            undo(&mut project, &mut history);
            assert_eq!(f_th(&project), expected);
        }
        assert!(!history.can_undo());
        for expected in [1.0, 1.5, 2.0, 21.5] {
            redo(&mut project, &mut history);
            assert_eq!(f_th(&project), expected);
        }
        undo(&mut project, &mut history);
        set(&mut project, &mut history, 9.0, Some(8));
        assert!(!history.can_redo(), "a new edit removes the redo steps");
        assert_eq!(history.before.len(), 4, "undo ends a gesture");
    }

    #[test]
    fn opening_files_is_a_step_and_earlier_steps_stay() {
        let (mut project, mut history) = (Project::default(), History::default());
        open(&mut project, &mut history, "a", "S1");
        let first = f_th(&project);
        let own = with_f_th(&project, 1.5);
        edit(&mut project, &mut history, own, None);
        edit(&mut project, &mut history, Edit::Roles(vec![0], Role::Off), None);
        let own = with_f_th(&project, 2.5);
        edit(&mut project, &mut history, own, Some(1));
        open(&mut project, &mut history, "b", "S1");
        edit(&mut project, &mut history, Edit::New, None);
        open(&mut project, &mut history, "other", "G1");
        undo(&mut project, &mut history);
        undo(&mut project, &mut history);
        assert_eq!((names(&project), f_th(&project)), (vec!["a", "b"], 2.5));
        undo(&mut project, &mut history);
        undo(&mut project, &mut history);
        assert_eq!((names(&project), f_th(&project)), (vec!["a"], 1.5));
        assert_eq!(roles(&project), [Role::Off]);
        undo(&mut project, &mut history);
        assert_eq!(roles(&project), [Role::Train]);
        undo(&mut project, &mut history);
        assert_eq!((names(&project), f_th(&project)), (vec!["a"], first));
        for _ in 0..6 {
            redo(&mut project, &mut history);
        }
        assert_eq!(names(&project), ["other"]);
    }

    #[test]
    fn undo_restores_roles_splits_and_closed_recordings() {
        let (mut project, mut history) = (with_files(), History::default());
        let before = project.clone();
        edit(&mut project, &mut history, Edit::Roles(vec![0], Role::Off), None);
        let mut settings = project.settings.clone();
        settings.offset = false;
        edit(&mut project, &mut history, Edit::Settings(settings), None);
        let off = project.clone();
        assert!(before != off);
        edit(&mut project, &mut history, Edit::Remove(vec![0]), None);
        edit(&mut project, &mut history, Edit::Split(0.5), None);
        undo(&mut project, &mut history);
        undo(&mut project, &mut history);
        assert_eq!(roles(&project), [Role::Off, Role::Train, Role::Test]);
        assert!(!project.request(None).settings.offset && project.split.is_none());
        assert!(project == off);
        undo(&mut project, &mut history);
        undo(&mut project, &mut history);
        assert!(project.settings.offset && project == before);
        assert_eq!(roles(&project), [Role::Train, Role::Train, Role::Test]);
    }

    /// Returns edits that all change [`with_files`], or its split if there is one.
    fn every_edit(project: &Project) -> Vec<Edit> {
        let mut settings = project.settings.clone();
        settings.offset = false;
        let calibration = || FromFile { path: "c.json".into(), calibration: fitted(project) };
        let block = |block, values: &[f64]| BlockSuggestion {
            block,
            values: values.to_vec(),
            left_out: 1.0,
            left_out_without: 2.0,
            n_tried: 1,
        };
        let with_others = || {
            let mut other = Project::default();
            add(&mut other, "c", &GAUGES, &FORCES);
            Arc::clone(&other.recordings)
        };
        vec![
            Edit::Model(Box::new(settings.clone())),
            Edit::Settings(settings),
            Edit::Thresholds(Thresholds { f_th: 0.125, t_th_secs: 9.0 }),
            Edit::Block(block(&Play, &[0.5])),
            Edit::Block(block(&Creep, &[0.5])),
            Edit::Roles(vec![0], Role::Test),
            Edit::AllRoles(Role::Train),
            Edit::Groups(vec![Some("monday".to_owned())]),
            Edit::Remove(vec![1]),
            Edit::New,
            Edit::Replace(with_others()),
            Edit::Split(0.25),
            Edit::Unsplit,
            Edit::Notes("oiled".to_owned()),
            Edit::Identity(identity()),
            Edit::Frame(Some(SensorFrame {
                turn_degrees: [0.0, 0.0, 90.0],
                ..SensorFrame::default()
            })),
            Edit::GaugeRange(Some(GaugeRange::All((-10.0, 10.0)))),
            Edit::OverloadTolerance(0.1),
            Edit::Apply(Some(calibration())),
            Edit::Apply(None),
            Edit::Compare(Some(calibration())),
            Edit::Compare(None),
            Edit::Measuring(MetrologySettings { hold_secs: 1.5, ..MetrologySettings::default() }),
        ]
    }

    fn identity() -> Identity {
        let mut identity = Identity::default();
        identity.set(Item::Serial, "4711");
        identity
    }

    /// Returns the index of an edit in the list. A new edit must be added to the test.
    fn place(edit: &Edit) -> usize {
        match edit {
            Edit::Settings(_) => 0,
            Edit::Thresholds(_) => 1,
            Edit::Block(_) => 2,
            Edit::Roles(..) => 3,
            Edit::AllRoles(_) => 4,
            Edit::Remove(_) => 5,
            Edit::New => 6,
            Edit::Replace(_) => 7,
            Edit::Split(_) => 8,
            Edit::Unsplit => 9,
            Edit::Notes(_) => 11,
            Edit::Apply(_) => 12,
            Edit::Compare(_) => 13,
            Edit::Groups(_) => 14,
            Edit::Measuring(_) => 15,
            Edit::Model(_) => 16,
            Edit::GaugeRange(_) => 17,
            Edit::OverloadTolerance(_) => 10,
            Edit::Identity(_) => 18,
            Edit::Frame(_) => 19,
        }
    }

    #[test]
    fn every_edit_is_undone_and_redone() {
        let own = with_files();
        let edits = every_edit(&own);
        for at in 0..=19 {
            let mut places = edits.iter().map(place);
            assert!(places.any(|place| place == at), "edit {at} is not tested");
        }
        for asked in edits {
            let (mut project, mut history) = (own.clone(), History::default());
            // Edits that remove something need it to exist first.
            let first = match asked {
                Edit::Unsplit => Some(Edit::Split(0.5)),
                Edit::Apply(None) | Edit::Compare(None) => {
                    let there = FromFile { path: "c.json".into(), calibration: fitted(&own) };
                    Some(match asked {
                        Edit::Apply(_) => Edit::Apply(Some(there)),
                        _ => Edit::Compare(Some(there)),
                    })
                }
                _ => None,
            };
            first.into_iter().for_each(|first| project.edit(first).unwrap());
            let before = project.clone();
            edit(&mut project, &mut history, asked.clone(), None);
            let after = project.clone();
            assert!(after != before, "{asked:?} changes something");
            for _ in 0..2 {
                undo(&mut project, &mut history);
                assert!(project == before, "{asked:?} is undone");
                assert!(!history.can_undo());
                redo(&mut project, &mut history);
                assert!(project == after, "{asked:?} is redone");
                assert!(!history.can_redo());
            }
        }
    }

    #[test]
    fn other_state_stays_and_the_view_shows_an_existing_recording() {
        let (mut project, mut history) = (Project::default(), History::default());
        for name in ["a", "b"] {
            open(&mut project, &mut history, name, "S1");
        }
        project.view = View::One(1);
        project.maps.insert("b".into(), ColumnMap::default());
        undo(&mut project, &mut history);
        assert_eq!((names(&project), project.view), (vec!["a"], View::One(0)));
        assert_eq!(project.maps.len(), 1);
        let before = project.clone();
        project.view = View::All;
        history.step(before, &project, None);
        assert!(history.can_redo(), "showing another recording is no step");
        redo(&mut project, &mut history);
        assert_eq!((names(&project), project.view), (vec!["a", "b"], View::All));
    }

    #[test]
    fn the_oldest_steps_are_forgotten() {
        let (mut project, mut history) = (Project::default(), History::default());
        project.take_set(built_in()).unwrap();
        for at in 0..MAX_STEPS + 5 {
            edit(&mut project, &mut history, Edit::Notes(at.to_string()), None);
        }
        for _ in 0..MAX_STEPS {
            undo(&mut project, &mut history);
        }
        assert!(!history.can_undo());
        assert_eq!(project.notes, "4");
        let before = project.clone();
        let refused = project.add(vec![vec![of_file("a", &["G1"], &[Axis::Fz])]]);
        assert!(refused.is_empty());
        history.step(before, &project, None);
        assert!(history.can_undo(), "replacing the built-in sensor is a step");
    }
}
