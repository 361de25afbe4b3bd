//! Background work that runs once, such as reading and writing files. Work that creates or replaces recordings runs one at a
//! time, because each begins with the recordings that the previous one left. Several at once would also need too much memory.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::Instant;

use crate::{
    engine::query::{Notify, Running, stand_back},
    import::map::ColumnMap,
    panicked::caught,
    progress::Progress,
    questions::question::Unanswered,
};

/// Files to read, each with the column map by which it is read; `None` if the columns are detected.
pub type Files = Vec<(PathBuf, Option<ColumnMap>)>;

/// Change of the engine `E` by the result of a task.
type Change<E> = Box<dyn FnOnce(&mut E) + Send>;

/// The change by a task that has ended, or the reason why there is none.
pub type Ended<E> = Result<Change<E>, Unanswered>;

/// Work on a thread.
type Run<E> = Box<dyn FnOnce(&Progress) -> Ended<E> + Send>;

/// Function that makes the task of a turn.
type Begin<E> = Box<dyn FnOnce(&mut E) -> Task<E>>;

pub struct Task<E> {
    title: String,
    /// True if the status line shows this work, so that the user can cancel it.
    is_seen: bool,
    run: Run<E>,
}

/// Work on recordings that waits for its turn.
pub struct Turn<E> {
    /// Files that the work reads.
    pub files: Files,
    /// Returns the task for the recordings that are loaded when the turn comes.
    pub begin: Begin<E>,
}

struct Begun<E> {
    running: Running,
    is_seen: bool,
    /// Files that work on recordings reads; `None` for other work.
    files: Option<Files>,
    inbox: Receiver<Ended<E>>,
}

pub struct Tasks<E> {
    notify: Option<Notify>,
    begun: Vec<Begun<E>>,
    waiting: VecDeque<Turn<E>>,
}

impl<E: 'static> Task<E> {
    /// Returns work whose result, which `run` computes on a thread, is given to `take`.
    pub fn new<R: Send + 'static>(
        title: impl Into<String>,
        run: impl FnOnce(&Progress) -> Result<R, Unanswered> + Send + 'static,
        take: impl FnOnce(&mut E, R) + Send + 'static,
    ) -> Self {
        let run = |progress: &Progress| {
            let found = run(progress)?;
            Ok(Box::new(|engine: &mut E| take(engine, found)) as Change<E>)
        };
        Self { title: title.into(), is_seen: true, run: Box::new(run) }
    }

    /// Shows the work in the status line only if `is_seen`.
    pub fn seen_if(self, is_seen: bool) -> Self {
        Self { is_seen, ..self }
    }
}

impl<E> Default for Tasks<E> {
    fn default() -> Self {
        Self { notify: None, begun: Vec::new(), waiting: VecDeque::new() }
    }
}

impl<E: 'static> Tasks<E> {
    pub fn new(notify: Notify) -> Self {
        Self { notify: Some(notify), ..Self::default() }
    }

    /// Starts a task. `files` are those that work on recordings reads; `None` for other work.
    ///
    /// # Panics
    /// If the system cannot start a thread.
    pub fn begin(&mut self, task: Task<E>, files: Option<Files>) {
        let Task { title, is_seen, run } = task;
        let running = Running { title, progress: Progress::default(), since: Instant::now() };
        let (sender, inbox) = channel();
        let (of_thread, notify) = (running.clone(), self.notify.clone());
        let work = move || {
            stand_back();
            let ended = caught(|| run(&of_thread.progress));
            let ended = ended.unwrap_or_else(|error| Err(Unanswered::Because(error.to_string())));
            log::info!("{}: {:.3} s", of_thread.title, of_thread.since.elapsed().as_secs_f64());
            // Sending a result fails only if the work was dropped, so the failure is ignored.
            let _ = sender.send(ended);
            notify.iter().for_each(|notify| notify());
        };
        thread::Builder::new().spawn(work).expect("the system can start a thread");
        self.begun.push(Begun { running, is_seen, files, inbox });
    }

    pub fn wait(&mut self, turn: Turn<E>) {
        self.waiting.push_back(turn);
    }

    /// Returns the work that is next, unless other work on recordings still runs.
    pub fn next_turn(&mut self) -> Option<Turn<E>> {
        let is_taken = self.begun.iter().any(|task| task.files.is_some());
        if is_taken { None } else { self.waiting.pop_front() }
    }

    /// Returns true if this file is being read or waits to be read.
    pub fn reads(&self, file: &(PathBuf, Option<ColumnMap>)) -> bool {
        let waiting = self.waiting.iter().flat_map(|turn| &turn.files);
        self.begun
            .iter()
            .flat_map(|task| &task.files)
            .flatten()
            .chain(waiting)
            .any(|read| read == file)
    }

    /// Returns the results of the tasks that have ended.
    pub fn take(&mut self) -> Vec<Ended<E>> {
        let mut ended = Vec::new();
        self.begun.retain(|task| match task.inbox.try_recv() {
            Err(TryRecvError::Empty) => true,
            found => {
                ended.extend(found);
                false
            }
        });
        ended
    }

    pub fn is_empty(&self) -> bool {
        self.begun.is_empty()
    }

    fn seen(&self) -> impl Iterator<Item = &Running> {
        self.begun.iter().filter(|task| task.is_seen).map(|task| &task.running)
    }

    /// Returns the tasks that the status line shows.
    pub fn running(&self) -> impl Iterator<Item = Running> {
        self.seen().cloned()
    }

    /// Cancels the tasks that the status line shows, and drops all waiting work. The user did not start the other tasks.
    pub fn cancel(&mut self) {
        self.seen().for_each(|running| running.progress.cancel());
        self.waiting.clear();
    }

    /// Drops all running and waiting work on recordings.
    pub fn drop_turns(&mut self) {
        for dropped in self.begun.extract_if(.., |task| task.files.is_some()) {
            dropped.running.progress.cancel();
        }
        self.waiting.clear();
    }
}
