//! Questions, and the one way in which they are answered off the window's thread.
//!
//! Guarantees: a result depends on its question alone (what a [`Lane`] remembers between questions only saves time); the newest
//! question wins; the previous answer stays until there is a newer one; a panic is an error of that question, and the next one
//! is answered again.

use std::any::Any;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

use crate::panicked::caught;
use crate::progress::Progress;
use crate::questions::question::{PATIENCE, Query, Unanswered, Work};

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

/// Called from another thread when there is something to take.
pub type Notify = Arc<dyn Fn() + Send + Sync>;

/// How far something is.
#[derive(Clone, Debug)]
pub struct Running {
    /// What it is.
    pub title: String,
    /// How far it is; cancel here.
    pub progress: Progress,
    /// When it began.
    pub since: Instant,
}

impl Running {
    /// How long the rest takes if it goes on as before; `None` while that cannot be told.
    pub fn time_left(&self) -> Option<Duration> {
        let fraction = f64::from(self.progress.fraction()?);
        let elapsed = self.since.elapsed();
        let tells = fraction > 0.01 && elapsed > Duration::from_secs(2);
        tells.then(|| elapsed.mul_f64((1.0 - fraction) / fraction))
    }
}

/// What a lane has heard of a question since it was looked at last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneEvent {
    /// A part of an answer.
    Part,
    /// An answer.
    Answer,
    /// The newest question has none, for the reason that [`Lane::problem`] tells.
    Problem,
    /// The newest question was cancelled.
    Cancelled,
}

/// A lane, whatever is asked on it.
pub trait Background: Any {
    /// Whether nothing runs or waits; all answers that will come can then be taken.
    fn is_idle(&self) -> bool;

    /// Drops what waits and asks what runs to stop; the same question again is not asked then.
    fn cancel(&self);

    /// What runs, or waits to.
    fn running(&self) -> Option<Running>;

    /// Takes what has been answered; returns what happened, in order, which [`Lane::happened`] keeps.
    fn hear_all(&mut self) -> &[LaneEvent];

    /// Why the newest question has no answer.
    fn problem(&self) -> Option<&str>;

    /// Stops, and forgets what was asked and answered; what is still answered of it is not heard.
    fn forget(&mut self);

    /// How a notice about a failure begins, where the user begins the work: see [`Query::BEGUN_BY_USER`].
    fn begun_by_user(&self) -> Option<&'static str>;
}

/// Answers one question after another, the newest first, on a thread that begins with the first.
pub struct Lane<Q: Query> {
    notify: Notify,
    shared: Arc<Shared<Q>>,
    inbox: Option<Receiver<Reply<Q>>>,
    asked: Option<Q>,
    newest: u64,
    /// Answers to questions up to this one are not wanted any more.
    forgotten: u64,
    shown: Option<Shown<Q>>,
    /// The whole answer before, while only a part is shown.
    before: Option<Shown<Q>>,
    problem: Option<String>,
    /// What was heard when it was looked at last.
    happened: Vec<LaneEvent>,
}

/// An answer with its question.
struct Shown<Q: Query> {
    question: Q,
    answer: Q::Answer,
    is_whole: bool,
}

struct Reply<Q: Query> {
    number: u64,
    question: Q,
    news: Payload<Q::Answer>,
}

enum Payload<A> {
    Part(A),
    End(Result<A, Unanswered>),
}

struct Shared<Q> {
    slot: Mutex<Slot<Q>>,
    wake: Condvar,
}

struct Slot<Q> {
    waiting: Option<(u64, Q, Running)>,
    running: Option<Running>,
    /// How long what runs is allowed to.
    patience: Duration,
    closed: bool,
}

impl<Q> Shared<Q> {
    /// The slot; a panic elsewhere cannot leave it half-changed, so poison means nothing here.
    fn lock(&self) -> MutexGuard<'_, Slot<Q>> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<Q: Query> Lane<Q> {
    /// A lane on which nothing has been asked.
    pub fn new(notify: &Notify) -> Self {
        Self {
            notify: Arc::clone(notify),
            shared: Arc::new(Shared {
                slot: Mutex::new(Slot {
                    waiting: None,
                    running: None,
                    patience: PATIENCE,
                    closed: false,
                }),
                wake: Condvar::new(),
            }),
            inbox: None,
            asked: None,
            newest: 0,
            forgotten: 0,
            shown: None,
            before: None,
            problem: None,
            happened: Vec::new(),
        }
    }

    /// Asks, unless this is what was asked last; an answer to a question that is not akin goes.
    pub fn ask(&mut self, question: Q) {
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

    /// Asks, whatever was asked before; what waits goes.
    ///
    /// # Panics
    /// If the system gives no thread.
    pub fn ask_again(&mut self, question: Q) {
        log::debug!("asked: {}", question.title());
        self.problem = None;
        self.newest += 1;
        self.asked = Some(question.clone());
        let begins = Running {
            title: question.title(),
            progress: Progress::default(),
            since: Instant::now(),
        };
        let mut slot = self.shared.lock();
        slot.waiting = Some((self.newest, question, begins));
        if let Some(running) = &slot.running
            && running.since.elapsed() > slot.patience
        {
            running.progress.cancel();
        }
        self.shared.wake.notify_one();
        drop(slot);
        if self.inbox.is_none() {
            let (replies, inbox) = channel();
            self.inbox = Some(inbox);
            let (shared, notify) = (Arc::clone(&self.shared), Arc::clone(&self.notify));
            thread::Builder::new()
                .spawn(move || answer_questions(&shared, &replies, &notify))
                .expect("the system gives a thread");
        }
    }

    /// Takes an answer that was found elsewhere, as if the question had been asked here.
    pub fn put(&mut self, question: Q, answer: Q::Answer) {
        self.forget();
        self.asked = Some(question.clone());
        self.shown = Some(Shown { question, answer, is_whole: true });
    }

    /// Why the newest question has no answer.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// What was heard when it was looked at last, in order.
    pub fn happened(&self) -> &[LaneEvent] {
        &self.happened
    }

    fn hear(&mut self, reply: Reply<Q>) -> Option<LaneEvent> {
        if reply.number <= self.forgotten {
            return None;
        }
        let is_newest = reply.number == self.newest;
        let (answer, is_whole) = match reply.news {
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
        } else {
            self.before = whole;
        }
        Some(match is_whole {
            true => LaneEvent::Answer,
            false => LaneEvent::Part,
        })
    }

    /// What was asked last.
    pub fn asked(&self) -> Option<&Q> {
        self.asked.as_ref()
    }

    /// The newest answer that there is, whole or in part.
    pub fn answer(&self) -> Option<&Q::Answer> {
        self.shown.as_ref().map(|shown| &shown.answer)
    }

    /// The question that [`Self::answer`] is of.
    pub fn answered(&self) -> Option<&Q> {
        self.shown.as_ref().map(|shown| &shown.question)
    }

    /// The newest whole answer with its question.
    pub fn whole(&self) -> Option<(&Q, &Q::Answer)> {
        let shown = self.shown.as_ref().filter(|shown| shown.is_whole);
        let whole = shown.or(self.before.as_ref())?;
        Some((&whole.question, &whole.answer))
    }

    /// The answer, if it is whole; it is nowhere else then.
    pub fn take_whole(&mut self) -> Option<Q::Answer> {
        let shown = self.shown.take_if(|shown| shown.is_whole)?;
        Some(shown.answer)
    }

    /// Whether the answer that is shown is whole, and of the newest question.
    pub fn is_current(&self) -> bool {
        let shown = self.shown.as_ref().filter(|shown| shown.is_whole);
        let both = shown.zip(self.asked.as_ref());
        both.is_some_and(|(shown, asked)| shown.question == *asked)
    }
}

impl<Q: Query> Background for Lane<Q> {
    fn is_idle(&self) -> bool {
        let slot = self.shared.lock();
        slot.waiting.is_none() && slot.running.is_none()
    }

    fn cancel(&self) {
        let mut slot = self.shared.lock();
        slot.waiting = None;
        if let Some(running) = &slot.running {
            running.progress.cancel();
        }
    }

    fn running(&self) -> Option<Running> {
        let slot = self.shared.lock();
        let waiting = slot.waiting.as_ref().map(|(_, _, waiting)| waiting);
        slot.running.as_ref().or(waiting).cloned()
    }

    fn hear_all(&mut self) -> &[LaneEvent] {
        let replies = self.inbox.iter().flat_map(Receiver::try_iter);
        let replies: VecDeque<Reply<Q>> = replies.collect();
        self.happened = replies.into_iter().filter_map(|reply| self.hear(reply)).collect();
        &self.happened
    }

    fn problem(&self) -> Option<&str> {
        Lane::problem(self)
    }

    fn forget(&mut self) {
        self.cancel();
        self.forgotten = self.newest;
        (self.asked, self.shown, self.before, self.problem) = (None, None, None, None);
    }

    fn begun_by_user(&self) -> Option<&'static str> {
        Q::BEGUN_BY_USER
    }
}

impl<Q: Query> Drop for Lane<Q> {
    fn drop(&mut self) {
        let mut slot = self.shared.lock();
        slot.closed = true;
        if let Some(running) = &slot.running {
            running.progress.cancel();
        }
        self.shared.wake.notify_one();
    }
}

/// Gives back the memory of what is not needed any more, elsewhere: for gigabytes the window would stand still.
fn let_go(answer: impl Send + 'static) {
    rayon::spawn(|| drop(answer));
}

fn answer_questions<Q: Query>(shared: &Shared<Q>, replies: &Sender<Reply<Q>>, notify: &Notify) {
    stand_back();
    let mut cache = Q::Cache::default();
    loop {
        let (number, question, progress) = {
            let mut slot = shared.lock();
            loop {
                if slot.closed {
                    return;
                }
                if let Some((number, question, begins)) = slot.waiting.take() {
                    let progress = begins.progress.clone();
                    let since = Instant::now();
                    slot.running = Some(Running { since, ..begins });
                    slot.patience = PATIENCE;
                    break (number, question, progress);
                }
                slot = (shared.wake.wait(slot)).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let reply = |news| {
            let question = question.clone();
            // Nobody listens any more when the window has closed.
            let _ = replies.send(Reply { number, question, news });
        };
        let told = Mutex::new(None::<Instant>);
        let show = |answer| {
            reply(Payload::Part(answer));
            shared.lock().patience = Q::PATIENCE_ONCE_SHOWN;
            let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
            if told.is_none_or(|told| told.elapsed() >= Q::PARTS_INTERVAL) {
                *told = Some(Instant::now());
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
        // In this order, so that whoever finds the lane idle also finds the answer.
        reply(Payload::End(found));
        let ended = shared.lock().running.take();
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
            assert_ne!(self.number, 13, "thirteen is one too many");
            (work.show)(self.number + 100);
            self.started.send(self.number).unwrap();
            self.gate.lock().unwrap().recv().unwrap();
            work.progress.check()?;
            *work.cache += 1;
            Ok(self.number + 1000 * *work.cache)
        }
    }

    /// A lane, what makes questions for it, what has started, and what opens the gate.
    fn lane() -> (Lane<Gated>, impl Fn(u32) -> Gated, Receiver<u32>, Sender<()>) {
        let (start, started) = channel();
        let (open, gate) = channel();
        let gate = Arc::new(Mutex::new(gate));
        let question =
            move |number| Gated { number, started: start.clone(), gate: Arc::clone(&gate) };
        let silent: Notify = Arc::new(|| {});
        (Lane::new(&silent), question, started, open)
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
        lane.hear_all().to_vec()
    }

    #[test]
    fn the_newest_question_is_answered_last_and_waiting_ones_are_dropped() {
        let (mut lane, question, started, open) = lane();
        lane.ask(question(1));
        assert_eq!(started.recv().unwrap(), 1);
        (2..=30).for_each(|number| lane.ask(question(number)));
        open.send(()).unwrap();
        assert_eq!(started.recv().unwrap(), 30);
        lane.hear_all();
        assert_eq!(lane.answer(), Some(&130), "a part of the newest answer");
        assert!(!lane.is_current());
        open.send(()).unwrap();
        wait(&mut lane);
        assert_eq!(lane.answer(), Some(&2030), "what was ready was used");
        assert!(lane.is_current());
        lane.ask(question(30));
        assert!(lane.is_idle(), "it is answered already");
    }

    #[test]
    fn cancel_reaches_what_runs_and_the_last_answer_stays() {
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
        assert!(lane.is_idle(), "nobody wants it any more");
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
        lane.hear_all();
        assert_eq!(lane.answer(), Some(&102));
        assert_eq!(whole(&lane), Some((1, 1001)));
        lane.cancel();
        open.send(()).unwrap();
        wait(&mut lane);
        assert_eq!(whole(&lane), Some((1, 1001)), "the other one never came");
        open.send(()).unwrap();
        lane.ask(question(3));
        wait(&mut lane);
        assert_eq!(whole(&lane), Some((3, 2003)));
        assert_eq!(lane.take_whole(), Some(2003));
        assert_eq!(whole(&lane), None);
    }

    #[test]
    fn what_was_forgotten_is_not_answered_any_more() {
        let (mut lane, question, _started, open) = lane();
        open.send(()).unwrap();
        lane.ask(question(1));
        settle(&lane);
        lane.forget();
        assert_eq!(lane.hear_all().to_vec(), [], "it had ended, but nobody had looked");
        assert_eq!(lane.answer(), None);
        open.send(()).unwrap();
        lane.ask(question(2));
        assert_eq!(wait(&mut lane), [LaneEvent::Part, LaneEvent::Answer]);
        assert_eq!(lane.answered().unwrap().number, 2);
    }

    #[test]
    fn a_panic_is_a_problem_of_its_question_and_the_next_is_answered() {
        let (mut lane, question, _started, open) = lane();
        lane.ask(question(13));
        assert_eq!(wait(&mut lane), [LaneEvent::Problem]);
        assert!(lane.problem().unwrap().contains("thirteen is one too many"));
        open.send(()).unwrap();
        lane.ask(question(2));
        assert_eq!(lane.problem(), None, "another question");
        wait(&mut lane);
        assert_eq!(lane.answer(), Some(&1002));
        lane.forget();
        assert_eq!(lane.answer(), None);
    }
}
