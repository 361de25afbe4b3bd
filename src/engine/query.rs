//! Background computation of results. A [`Lane`] has a worker thread that computes the requests of one type, the newest
//! first.
//!
//! Guarantees: a result depends only on its request; the cache of a lane only saves time. A new request replaces a waiting
//! one. The previous result stays until there is a newer one. A panic counts as an error of its request, and the thread
//! computes the next request.

use std::any::Any;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

use crate::{
    panicked::{caught, locked},
    progress::Progress,
    questions::question::{PATIENCE, Query, Unanswered, Work},
};

/// Priority of background threads, from 0 to 99. It is so low that a busy processor draws the window first. It is a niceness
/// of 10 on Linux.
const BACKGROUND_PRIORITY: u8 = 25;

/// Gives the threads of the shared rayon pool the priority of background work. Must be called before the pool is first used.
pub fn let_window_go_first() {
    let pool = rayon::ThreadPoolBuilder::new().start_handler(|_| stand_back());
    if let Err(error) = pool.build_global() {
        log::debug!("the thread pool had already been created: {error}");
    }
}

/// Lowers the priority of the present thread to that of background work, if the system permits.
pub fn stand_back() {
    let lower = ThreadPriorityValue::try_from(BACKGROUND_PRIORITY)
        .map(ThreadPriority::Crossplatform)
        .map(set_current_thread_priority);
    if !matches!(lower, Ok(Ok(()))) {
        log::debug!("background work keeps the window's priority: {lower:?}");
    }
}

/// Function that a background thread calls when there are new results.
pub type Notify = Arc<dyn Fn() + Send + Sync>;

#[derive(Clone, Debug)]
pub struct Running {
    pub title: String,
    pub progress: Progress,
    pub since: Instant,
}

impl Running {
    pub fn time_left(&self) -> Option<Duration> {
        let fraction = f64::from(self.progress.fraction()?);
        let elapsed = self.since.elapsed();
        let is_known = fraction > 0.01 && elapsed > Duration::from_secs(2);
        is_known.then(|| elapsed.mul_f64((1.0 - fraction) / fraction))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneEvent {
    /// A partial result of the newest request arrived.
    Part,
    Answer,
    /// The computation of the newest request failed; [`Lane::problem`] gives the reason.
    Problem,
    /// The computation of the newest request was cancelled.
    Cancelled,
}

/// Methods of a [`Lane`] that do not depend on the type of its requests.
pub trait Background: Any {
    /// Returns true if no request is running or waiting. All results can then be taken.
    fn is_idle(&self) -> bool;

    /// Removes the waiting request and cancels the running one.
    fn cancel(&self);

    fn running(&self) -> Option<Running>;

    /// Takes new results from the worker thread. Returns what happened (such as a result or a failure), in order.
    fn take_events(&mut self) -> &[LaneEvent];

    /// Takes new results from the worker thread. Returns a message if work that the user started has failed.
    fn take_failure(&mut self) -> Option<String>;

    /// Cancels the work, and removes the request and its result. A result that still arrives is ignored.
    fn forget(&mut self);

    /// Returns true if the user starts this work; see [`Query::BEGUN_BY_USER`].
    fn is_begun_by_user(&self) -> bool;

    /// Returns true if the requests are about the newest analysis; see [`Query::ON_ANALYSIS`].
    fn is_on_analysis(&self) -> bool;
}

/// Newest request of one type and its result, with a worker thread that starts with the first request.
pub struct Lane<Q: Query> {
    notify: Option<Notify>,
    worker: Option<Worker<Q>>,
    asked: Option<Q>,
    newest: u64,
    /// Number of the last removed request. Results of this and of earlier requests are ignored.
    forgotten: u64,
    shown: Option<Shown<Q>>,
    /// Previous complete result, kept while `shown` is a partial result.
    before: Option<Shown<Q>>,
    problem: Option<String>,
    happened: Vec<LaneEvent>,
}

struct Shown<Q: Query> {
    question: Q,
    answer: Q::Answer,
    is_whole: bool,
}

struct Reply<Q: Query> {
    number: u64,
    question: Q,
    payload: Payload<Q::Answer>,
}

enum Payload<A> {
    Part(A),
    End(Result<A, Unanswered>),
}

/// Worker thread that computes the requests of a lane.
struct Worker<Q: Query> {
    shared: Arc<Shared<Q>>,
    inbox: Receiver<Reply<Q>>,
}

struct Shared<Q> {
    slot: Mutex<Slot<Q>>,
    wake: Condvar,
}

struct Slot<Q> {
    waiting: Option<(u64, Q, Running)>,
    running: Option<Running>,
    /// Minimum running time after which a newer request cancels the running one.
    patience: Duration,
    closed: bool,
}

impl<Q: Query> Worker<Q> {
    fn start(notify: Option<Notify>) -> Self {
        let slot = Slot { waiting: None, running: None, patience: PATIENCE, closed: false };
        let shared = Arc::new(Shared { slot: Mutex::new(slot), wake: Condvar::new() });
        let (replies, inbox) = channel();
        let of_thread = Arc::clone(&shared);
        thread::Builder::new()
            .spawn(move || answer_questions(&of_thread, &replies, notify))
            .expect("the system can start a thread");
        Self { shared, inbox }
    }

    fn slot(&self) -> MutexGuard<'_, Slot<Q>> {
        locked(&self.shared.slot)
    }
}

impl<Q: Query> Drop for Worker<Q> {
    fn drop(&mut self) {
        let mut slot = self.slot();
        slot.closed = true;
        if let Some(running) = &slot.running {
            running.progress.cancel();
        }
        self.shared.wake.notify_one();
    }
}

impl<Q: Query> Default for Lane<Q> {
    fn default() -> Self {
        Self::UNASKED
    }
}

impl<Q: Query> Lane<Q> {
    const UNASKED: Self = Self {
        notify: None,
        worker: None,
        asked: None,
        newest: 0,
        forgotten: 0,
        shown: None,
        before: None,
        problem: None,
        happened: Vec::new(),
    };
    /// Lane without a request, for types that were never requested.
    pub const EMPTY: &'static Self = &Self::UNASKED;

    pub fn new(notify: Option<Notify>) -> Self {
        Self { notify, ..Self::UNASKED }
    }

    /// Computes a request, unless it equals the last one. The shown result is removed if it must not stay on screen until the
    /// new result; see [`Query::is_akin`].
    pub fn ask(&mut self, question: Q)
    where
        Q: PartialEq,
    {
        if let Some(asked) = &self.asked {
            if *asked == question {
                return;
            }
            if !question.is_akin(asked) {
                self.forget();
            }
        }
        self.ask_again(question);
    }

    /// Computes a request, even if it equals the last one. A waiting request is removed.
    ///
    /// # Panics
    /// If the system cannot start a thread.
    pub fn ask_again(&mut self, question: Q) {
        let title = question.title();
        log::debug!("asked: {title}");
        self.problem = None;
        self.newest += 1;
        self.asked = Some(question.clone());
        let begins = Running { title, progress: Progress::default(), since: Instant::now() };
        let worker = self.worker.get_or_insert_with(|| Worker::start(self.notify.clone()));
        let mut slot = worker.slot();
        slot.waiting = Some((self.newest, question, begins));
        if let Some(running) = &slot.running
            && running.since.elapsed() > slot.patience
        {
            running.progress.cancel();
        }
        worker.shared.wake.notify_one();
    }

    /// Stores a result that was computed elsewhere as the result of this request.
    pub fn put(&mut self, question: Q, answer: Q::Answer) {
        self.forget();
        self.asked = Some(question.clone());
        self.shown = Some(Shown { question, answer, is_whole: true });
    }

    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// Returns the events (such as a result or a failure) that the last [`Background::take_events`] took, in order.
    pub fn happened(&self) -> &[LaneEvent] {
        &self.happened
    }

    fn take_reply(&mut self, reply: Reply<Q>) -> Option<LaneEvent> {
        if reply.number <= self.forgotten {
            return None;
        }
        let is_newest = reply.number == self.newest;
        let (answer, is_whole) = match reply.payload {
            Payload::Part(answer) if is_newest => (answer, false),
            Payload::End(Ok(answer)) => (answer, true),
            Payload::End(Err(Unanswered::Because(reason))) if is_newest => {
                self.problem = Some(reason);
                return Some(LaneEvent::Problem);
            }
            Payload::End(Err(Unanswered::Cancelled)) if is_newest => {
                return Some(LaneEvent::Cancelled);
            }
            _ => return None,
        };
        let last = self.shown.replace(Shown { question: reply.question, answer, is_whole });
        let (whole, part) = match last {
            Some(last) if last.is_whole => (Some(last), None),
            part => (self.before.take(), part),
        };
        let_go(part);
        if is_whole {
            let_go(whole);
            return Some(LaneEvent::Answer);
        }
        self.before = whole;
        Some(LaneEvent::Part)
    }

    pub fn asked(&self) -> Option<&Q> {
        self.asked.as_ref()
    }

    /// Returns the newest result, be it complete or partial.
    pub fn answer(&self) -> Option<&Q::Answer> {
        self.shown.as_ref().map(|shown| &shown.answer)
    }

    /// Returns the request to which [`Self::answer`] is the result.
    pub fn answered(&self) -> Option<&Q> {
        self.shown.as_ref().map(|shown| &shown.question)
    }

    /// Returns the newest complete result with its request.
    pub fn whole(&self) -> Option<(&Q, &Q::Answer)> {
        let shown = self.shown.as_ref().filter(|shown| shown.is_whole);
        let whole = shown.or(self.before.as_ref())?;
        Some((&whole.question, &whole.answer))
    }

    /// Returns true if the shown result is complete and belongs to the newest request.
    pub fn is_current(&self) -> bool
    where
        Q: PartialEq,
    {
        let shown = self.shown.as_ref().filter(|shown| shown.is_whole);
        shown.is_some_and(|shown| self.asked.as_ref() == Some(&shown.question))
    }
}

impl<Q: Query> Background for Lane<Q> {
    fn is_idle(&self) -> bool {
        self.running().is_none()
    }

    fn cancel(&self) {
        if let Some(worker) = &self.worker {
            let mut slot = worker.slot();
            slot.waiting = None;
            if let Some(running) = &slot.running {
                running.progress.cancel();
            }
        }
    }

    fn running(&self) -> Option<Running> {
        let slot = self.worker.as_ref()?.slot();
        let waiting = slot.waiting.as_ref().map(|(_, _, waiting)| waiting);
        slot.running.as_ref().or(waiting).cloned()
    }

    fn take_events(&mut self) -> &[LaneEvent] {
        let replies = self.worker.iter().flat_map(|worker| worker.inbox.try_iter());
        let replies: Vec<Reply<Q>> = replies.collect();
        self.happened = replies.into_iter().filter_map(|reply| self.take_reply(reply)).collect();
        &self.happened
    }

    fn take_failure(&mut self) -> Option<String> {
        let has_failed = self.take_events().contains(&LaneEvent::Problem);
        let (begins, problem) = (Q::BEGUN_BY_USER?, self.problem()?);
        has_failed.then(|| format!("{begins}{problem}"))
    }

    fn forget(&mut self) {
        self.cancel();
        self.forgotten = self.newest;
        (self.asked, self.shown, self.before, self.problem) = (None, None, None, None);
    }

    fn is_begun_by_user(&self) -> bool {
        Q::BEGUN_BY_USER.is_some()
    }

    fn is_on_analysis(&self) -> bool {
        Q::ON_ANALYSIS
    }
}

/// Frees the memory of a result on another thread, because freeing gigabytes would stop the window for a moment.
fn let_go(answer: impl Send + 'static) {
    rayon::spawn(|| drop(answer));
}

fn answer_questions<Q: Query>(
    shared: &Shared<Q>,
    replies: &Sender<Reply<Q>>,
    notify: Option<Notify>,
) {
    stand_back();
    let notify = || notify.iter().for_each(|notify| notify());
    let mut cache = Q::Cache::default();
    loop {
        let (number, question, progress) = {
            let mut slot = locked(&shared.slot);
            loop {
                if slot.closed {
                    return;
                }
                if let Some((number, question, begins)) = slot.waiting.take() {
                    let progress = begins.progress.clone();
                    slot.running = Some(Running { since: Instant::now(), ..begins });
                    slot.patience = PATIENCE;
                    break (number, question, progress);
                }
                slot = shared.wake.wait(slot).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let reply = |payload| {
            let question = question.clone();
            // Sending a result fails only after the window has closed, so the failure is ignored.
            let _ = replies.send(Reply { number, question, payload });
        };
        let last_part = Mutex::new(None::<Instant>);
        let show = |answer| {
            reply(Payload::Part(answer));
            locked(&shared.slot).patience = Q::PATIENCE_ONCE_SHOWN;
            let mut last_part = locked(&last_part);
            if last_part.is_none_or(|last_part| last_part.elapsed() >= Q::PARTS_INTERVAL) {
                *last_part = Some(Instant::now());
                notify();
            }
        };
        let found = caught(|| {
            question.compute(Work { cache: &mut cache, progress: &progress, show: &show })
        });
        let found = found.unwrap_or_else(|panicked| {
            cache = Q::Cache::default();
            Err(Unanswered::Because(panicked.to_string()))
        });
        // The result is sent before the request counts as ended. So once a lane is idle, all its results have arrived.
        reply(Payload::End(found));
        let ended = locked(&shared.slot).running.take();
        if let Some(Running { title, since, .. }) = ended {
            log::info!("{title}: {:.3} s", since.elapsed().as_secs_f64());
        }
        notify();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::questions::question::Answered;
    use crate::same::same_where;

    /// Answers with its number when its gate opens.
    #[derive(Clone)]
    struct Gated {
        number: u32,
        started: Sender<u32>,
        gate: Arc<Mutex<Receiver<()>>>,
    }

    same_where!(Gated: shared() value(number) besides(started, gate));

    impl Query for Gated {
        type Answer = u32;
        type Cache = u32;

        fn title(&self) -> String {
            "a test".to_owned()
        }

        fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
            assert_ne!(self.number, 13, "question 13 panics");
            (work.show)(self.number + 100);
            self.started.send(self.number).unwrap();
            self.gate.lock().unwrap().recv().unwrap();
            work.progress.check()?;
            *work.cache += 1;
            Ok(self.number + 1000 * *work.cache)
        }
    }

    /// Returns a lane, a function that creates questions, a receiver of started questions, and a sender that opens the gate.
    fn lane() -> (Lane<Gated>, impl Fn(u32) -> Gated, Receiver<u32>, Sender<()>) {
        let (start, started) = channel();
        let (open, gate) = channel();
        let gate = Arc::new(Mutex::new(gate));
        let question =
            move |number| Gated { number, started: start.clone(), gate: Arc::clone(&gate) };
        (Lane::new(None), question, started, open)
    }

    fn settle(lane: &Lane<Gated>) {
        let deadline = Instant::now() + Duration::from_secs(20);
        while !lane.is_idle() {
            assert!(Instant::now() < deadline, "an answer");
            thread::sleep(Duration::from_millis(1));
        }
    }

    fn wait(lane: &mut Lane<Gated>) -> Vec<LaneEvent> {
        settle(lane);
        lane.take_events().to_vec()
    }

    #[test]
    fn the_newest_question_is_answered_last_and_waiting_ones_are_dropped() {
        let (mut lane, question, started, open) = lane();
        lane.ask(question(1));
        assert_eq!(started.recv().unwrap(), 1);
        (2..=30).for_each(|number| lane.ask(question(number)));
        open.send(()).unwrap();
        assert_eq!(started.recv().unwrap(), 30);
        lane.take_events();
        assert_eq!(lane.answer(), Some(&130), "a part of the newest answer is shown");
        assert!(!lane.is_current());
        open.send(()).unwrap();
        wait(&mut lane);
        assert_eq!(lane.answer(), Some(&2030), "the cache was used");
        assert!(lane.is_current());
        lane.ask(question(30));
        assert!(lane.is_idle(), "the same question is not answered twice");
    }

    #[test]
    fn cancel_stops_the_running_question_and_keeps_the_last_answer() {
        let (mut lane, question, started, open) = lane();
        open.send(()).unwrap();
        lane.ask(question(1));
        wait(&mut lane);
        lane.ask(question(2));
        started.iter().find(|number| *number == 2).unwrap();
        lane.cancel();
        open.send(()).unwrap();
        assert_eq!(wait(&mut lane), [LaneEvent::Part, LaneEvent::Cancelled]);
        assert_eq!(lane.problem(), None);
        lane.ask(question(2));
        assert!(lane.is_idle(), "the cancelled question has ended");
    }

    #[test]
    fn the_last_whole_answer_stays_while_parts_of_the_next_are_shown() {
        let (mut lane, question, started, open) = lane();
        let whole = |lane: &Lane<Gated>| lane.whole().map(|(of, answer)| (of.number, *answer));
        open.send(()).unwrap();
        lane.ask(question(1));
        wait(&mut lane);
        lane.ask(question(2));
        assert_eq!((lane.answer(), lane.is_current()), (Some(&1001), false));
        started.iter().find(|number| *number == 2).unwrap();
        lane.take_events();
        assert_eq!(lane.answer(), Some(&102));
        assert_eq!(whole(&lane), Some((1, 1001)));
        lane.cancel();
        open.send(()).unwrap();
        wait(&mut lane);
        assert_eq!(whole(&lane), Some((1, 1001)), "the failed question has no answer");
        open.send(()).unwrap();
        lane.ask(question(3));
        wait(&mut lane);
        assert_eq!(whole(&lane), Some((3, 2003)));
    }

    #[test]
    fn forgotten_questions_are_not_answered() {
        let (mut lane, question, _started, open) = lane();
        open.send(()).unwrap();
        lane.ask(question(1));
        settle(&lane);
        lane.forget();
        assert_eq!(lane.take_events().to_vec(), [], "forgotten events are not taken");
        assert_eq!(lane.answer(), None);
        open.send(()).unwrap();
        lane.ask(question(2));
        assert_eq!(wait(&mut lane), [LaneEvent::Part, LaneEvent::Answer]);
        assert_eq!(lane.answered().unwrap().number, 2);
    }

    #[test]
    fn a_panic_fails_only_its_question() {
        let (mut lane, question, _started, open) = lane();
        lane.ask(question(13));
        assert_eq!(wait(&mut lane), [LaneEvent::Problem]);
        assert!(lane.problem().unwrap().contains("question 13 panics"));
        open.send(()).unwrap();
        lane.ask(question(2));
        assert_eq!(lane.problem(), None, "another question");
        wait(&mut lane);
        assert_eq!(lane.answer(), Some(&1002));
        lane.forget();
        assert_eq!(lane.answer(), None);
    }
}
