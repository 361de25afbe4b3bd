//! Work off the window's thread: one worker that answers the newest request, and jobs that run once.
//!
//! Guarantees: the caller never waits; a request that was overtaken is dropped unseen, or cancelled once it has run for
//! longer than [`PATIENCE`]; a panic becomes an answer that says so, and the next request works again. All of it
//! [stands back](let_window_go_first) behind the window's thread where processors are few.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

use crate::panicked::caught;
use crate::progress::Progress;

pub use crate::panicked::{Panicked, panic_message};

/// A run this young is allowed to finish when a newer request arrives, so that a slider on the move shows something.
pub const PATIENCE: Duration = Duration::from_millis(150);

/// Of 0 to 99; an idle processor works as fast as ever, a busy one draws the window first (niceness 10 on Linux).
const BACKGROUND_PRIORITY: u8 = 25;

/// Gives the shared pool of threads the priority of background work. Only before its first use, and best before anything else.
pub fn let_window_go_first() {
    let pool = rayon::ThreadPoolBuilder::new().start_handler(|_| stand_back());
    if let Err(error) = pool.build_global() {
        log::debug!("the pool of threads was there already: {error}");
    }
}

/// Lowers the priority of this thread; where the system refuses, everything works as before.
fn stand_back() {
    let lower = ThreadPriorityValue::try_from(BACKGROUND_PRIORITY)
        .map(ThreadPriority::Crossplatform)
        .map(set_current_thread_priority);
    if !matches!(lower, Ok(Ok(()))) {
        log::debug!("background work keeps the window's priority: {lower:?}");
    }
}

/// Called from the worker's thread when there is something to fetch.
pub type Notify = Arc<dyn Fn() + Send + Sync>;

/// What a worker answers: the request's number and its result.
#[derive(Debug)]
pub struct Answer<A> {
    /// The number that [`Worker::request`] gave out.
    pub generation: u64,
    /// The result.
    pub result: Result<A, Panicked>,
}

/// One named thread that answers the newest request.
pub struct Worker<Q, A> {
    shared: Arc<Shared<Q>>,
    answers: Receiver<Answer<A>>,
    newest: u64,
}

struct Shared<Q> {
    slot: Mutex<Slot<Q>>,
    wake: Condvar,
}

struct Slot<Q> {
    waiting: Option<(u64, Q)>,
    running: Option<Running>,
    closed: bool,
}

#[derive(Clone)]
struct Running {
    progress: Progress,
    since: Instant,
}

impl<Q> Shared<Q> {
    /// The slot; a panic elsewhere cannot leave it half-changed, so poison means nothing here.
    fn lock(&self) -> MutexGuard<'_, Slot<Q>> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<Q: Send + 'static, A: Send + 'static> Worker<Q, A> {
    /// Starts the thread. `make` builds the state that answers requests, at the start and again after a panic.
    ///
    /// # Panics
    /// If the system gives no thread.
    pub fn start<H>(name: &str, notify: Notify, make: impl Fn() -> H + Send + 'static) -> Self
    where
        H: FnMut(Q, &Progress) -> A,
    {
        let shared = Arc::new(Shared {
            slot: Mutex::new(Slot {
                waiting: None,
                running: None,
                closed: false,
            }),
            wake: Condvar::new(),
        });
        let (sender, answers) = channel();
        let theirs = Arc::clone(&shared);
        thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || answer_requests(&theirs, &sender, &notify, &make))
            .expect("the system gives a thread");
        Self {
            shared,
            answers,
            newest: 0,
        }
    }

    /// Asks for an answer to `request` instead of any that is waiting; returns its number.
    pub fn request(&mut self, request: Q) -> u64 {
        self.newest += 1;
        let mut slot = self.shared.lock();
        slot.waiting = Some((self.newest, request));
        if let Some(running) = &slot.running
            && running.since.elapsed() > PATIENCE
        {
            running.progress.cancel();
        }
        self.shared.wake.notify_one();
        self.newest
    }

    /// The next answer, if one is there.
    pub fn answer(&mut self) -> Option<Answer<A>> {
        self.answers.try_recv().ok()
    }

    /// The number of the newest request.
    #[must_use]
    pub fn newest(&self) -> u64 {
        self.newest
    }

    /// The progress of what runs now, with how long it has.
    #[must_use]
    pub fn running(&self) -> Option<(Progress, Duration)> {
        let slot = self.shared.lock();
        let running = slot.running.as_ref()?;
        Some((running.progress.clone(), running.since.elapsed()))
    }

    /// Whether nothing runs or waits; all answers that will come can then be fetched.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let slot = self.shared.lock();
        slot.waiting.is_none() && slot.running.is_none()
    }

    /// Drops what waits and asks what runs to stop.
    pub fn cancel(&self) {
        let mut slot = self.shared.lock();
        slot.waiting = None;
        if let Some(running) = &slot.running {
            running.progress.cancel();
        }
    }
}

impl<Q, A> Drop for Worker<Q, A> {
    fn drop(&mut self) {
        let mut slot = self.shared.lock();
        slot.closed = true;
        if let Some(running) = &slot.running {
            running.progress.cancel();
        }
        self.shared.wake.notify_one();
    }
}

fn answer_requests<Q, A, H: FnMut(Q, &Progress) -> A>(
    shared: &Shared<Q>,
    answers: &Sender<Answer<A>>,
    notify: &Notify,
    make: &impl Fn() -> H,
) {
    stand_back();
    let mut handle = make();
    loop {
        let progress = Progress::default();
        let (generation, request) = {
            let mut slot = shared.lock();
            loop {
                if slot.closed {
                    return;
                }
                if let Some(waiting) = slot.waiting.take() {
                    slot.running = Some(Running {
                        progress: progress.clone(),
                        since: Instant::now(),
                    });
                    break waiting;
                }
                slot = shared
                    .wake
                    .wait(slot)
                    .unwrap_or_else(PoisonError::into_inner);
            }
        };
        let result = caught(|| handle(request, &progress));
        if result.is_err() {
            handle = make();
        }
        // In this order, so that whoever finds the worker idle also finds the answer.
        let sent = answers.send(Answer { generation, result });
        shared.lock().running = None;
        if sent.is_err() {
            return;
        }
        notify();
    }
}

/// Something that runs once on a thread of its own.
pub struct Job<A> {
    /// What people see of it.
    pub title: String,
    /// How far it is; cancel here.
    pub progress: Progress,
    /// When it began.
    pub since: Instant,
    result: Receiver<Result<A, Panicked>>,
}

impl<A> Job<A> {
    /// How long the rest takes if it goes on as before; `None` while that cannot be told.
    #[must_use]
    pub fn time_left(&self) -> Option<Duration> {
        let fraction = f64::from(self.progress.fraction()?);
        let elapsed = self.since.elapsed();
        let tells = fraction > 0.01 && elapsed > Duration::from_secs(2);
        tells.then(|| elapsed.mul_f64((1.0 - fraction) / fraction))
    }
}

impl<A: Send + 'static> Job<A> {
    /// Starts it.
    ///
    /// # Panics
    /// If the system gives no thread.
    pub fn start(
        title: impl Into<String>,
        notify: Notify,
        work: impl FnOnce(&Progress) -> A + Send + 'static,
    ) -> Self {
        let title = title.into();
        let progress = Progress::default();
        let (sender, result) = channel();
        let theirs = progress.clone();
        thread::Builder::new()
            .name(title.chars().take(15).collect())
            .spawn(move || {
                stand_back();
                let done = caught(|| work(&theirs));
                // Nobody listens any more when the window has closed.
                let _ = sender.send(done);
                notify();
            })
            .expect("the system gives a thread");
        Self {
            title,
            progress,
            since: Instant::now(),
            result,
        }
    }

    /// The result, once it is there.
    pub fn result(&self) -> Option<Result<A, Panicked>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(Panicked {
                message: "its thread ended without an answer".to_owned(),
            })),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn silent() -> Notify {
        Arc::new(|| {})
    }

    fn wait<A: Send + 'static, Q: Send + 'static>(worker: &mut Worker<Q, A>) -> Answer<A> {
        worker
            .answers
            .recv_timeout(Duration::from_secs(20))
            .expect("an answer")
    }

    #[test]
    fn the_newest_request_is_answered_last_and_waiting_ones_are_dropped() {
        let (start, started) = channel();
        let (go, gate) = channel::<()>();
        let gate = Arc::new(Mutex::new(gate));
        let mut worker = Worker::start("test", silent(), move || {
            let (start, gate) = (start.clone(), Arc::clone(&gate));
            move |request: u32, _: &Progress| {
                start.send(request).unwrap();
                gate.lock().unwrap().recv().unwrap();
                request
            }
        });
        worker.request(1);
        assert_eq!(started.recv().unwrap(), 1);
        for request in 2..=30 {
            worker.request(request);
        }
        go.send(()).unwrap();
        go.send(()).unwrap();
        assert_eq!(wait(&mut worker).result, Ok(1));
        let last = wait(&mut worker);
        assert_eq!((last.generation, last.result), (30, Ok(30)));
    }

    #[test]
    fn cancel_reaches_what_runs() {
        let mut worker = Worker::start("test", silent(), || {
            |(): (), progress: &Progress| {
                while !progress.is_cancelled() {
                    thread::sleep(Duration::from_millis(1));
                }
                "stopped"
            }
        });
        worker.request(());
        assert!(!worker.is_idle());
        while worker.running().is_none() {
            thread::sleep(Duration::from_millis(1));
        }
        worker.cancel();
        assert_eq!(wait(&mut worker).result, Ok("stopped"));
    }

    #[test]
    fn a_panic_is_an_answer_and_the_next_request_works() {
        let mut worker = Worker::start("test", silent(), || {
            |request: u32, _: &Progress| {
                assert_ne!(request, 1, "one is one too many");
                request
            }
        });
        worker.request(1);
        let panicked = wait(&mut worker).result.unwrap_err();
        assert!(panicked.message.contains("one is one too many"));
        worker.request(2);
        assert_eq!(wait(&mut worker).result, Ok(2));
    }

    #[test]
    fn a_job_gives_its_result_once_and_reports_a_panic() {
        let finished = |job: &Job<u32>| {
            let deadline = Instant::now() + Duration::from_secs(20);
            loop {
                if let Some(result) = job.result() {
                    return result;
                }
                assert!(Instant::now() < deadline);
                thread::sleep(Duration::from_millis(1));
            }
        };
        assert_eq!(finished(&Job::start("seven", silent(), |_| 7)), Ok(7));
        let broken = Job::start("broken", silent(), |_| panic!("no"));
        assert_eq!(finished(&broken).unwrap_err().message, "no");
    }
}
