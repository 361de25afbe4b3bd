//! The background tasks that run or wait. Tasks that create or replace recordings run one at a time, because each starts from
//! the recordings that the previous one left. Several at once would also need too much memory.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;

use crate::{
    engine::{
        query::{Background as _, Lane, Notify, Running},
        task::{Done, Task},
    },
    import::{ColumnChange, map::ColumnMap},
    recording::{Recording, Tare, simulated::Late},
};

/// Files to read, each with the column map by which it is read; `None` if the columns are detected.
pub type Files = Vec<(PathBuf, Option<ColumnMap>)>;

struct Begun {
    is_seen: bool,
    turn: Option<InTurn>,
    lane: Lane<Task>,
}

/// Work that creates or replaces recordings.
#[derive(Clone)]
pub enum InTurn {
    Read(Files),
    /// The recordings themselves are given, not their indices, because indices may change before this work starts.
    Tare(Vec<Arc<Recording>>, Tare),
    LeaveOutFaulty,
    /// Reads the files again with changed columns.
    ChangeColumns(ColumnChange),
    Simulate(Option<Late>),
}

#[derive(Default)]
pub struct Tasks {
    notify: Option<Notify>,
    begun: Vec<Begun>,
    waiting: VecDeque<InTurn>,
}

impl Tasks {
    pub fn new(notify: Notify) -> Self {
        Self { notify: Some(notify), ..Self::default() }
    }

    pub fn start(&mut self, task: Task) {
        self.begin(task, None);
    }

    /// Starts the task that does this work.
    pub fn begin(&mut self, task: Task, turn: Option<InTurn>) {
        let mut lane = Lane::new(self.notify.clone());
        let is_seen = task.is_seen;
        lane.ask_again(task);
        self.begun.push(Begun { is_seen, turn, lane });
    }

    pub fn wait(&mut self, turn: InTurn) {
        self.waiting.push_back(turn);
    }

    /// Returns the work that is next, unless other work on recordings still runs.
    pub fn next_turn(&mut self) -> Option<InTurn> {
        let is_taken = self.begun.iter().any(|task| task.turn.is_some());
        if is_taken { None } else { self.waiting.pop_front() }
    }

    /// Returns true if this file is being read or waits to be read.
    pub fn reads(&self, file: &(PathBuf, Option<ColumnMap>)) -> bool {
        let begun = self.begun.iter().filter_map(|task| task.turn.as_ref());
        begun.chain(&self.waiting).any(|turn| match turn {
            InTurn::Read(files) => files.contains(file),
            _ => false,
        })
    }

    /// Returns the results of the tasks that have ended, and the reasons why tasks failed.
    pub fn take(&mut self) -> Vec<(Option<Done>, Option<String>)> {
        let mut ended = Vec::new();
        self.begun.retain_mut(|Begun { lane, .. }| {
            let is_idle = lane.is_idle();
            lane.take_events();
            if is_idle {
                ended.push((lane.take_whole(), lane.problem().map(str::to_owned)));
            }
            !is_idle
        });
        ended
    }

    pub fn is_empty(&self) -> bool {
        self.begun.is_empty()
    }

    /// Returns the tasks that the status line shows.
    pub fn running(&self) -> impl Iterator<Item = Running> {
        let seen = self.begun.iter().filter(|task| task.is_seen);
        seen.filter_map(|task| task.lane.running())
    }

    /// Cancels the tasks that the status line shows, and drops all waiting work. The user did not start the other tasks.
    pub fn cancel(&mut self) {
        let seen = self.begun.iter().filter(|task| task.is_seen);
        seen.for_each(|task| task.lane.cancel());
        self.waiting.clear();
    }

    /// Drops all running and waiting work on recordings.
    pub fn drop_turns(&mut self) {
        self.begun.retain(|task| task.turn.is_none());
        self.waiting.clear();
    }
}
