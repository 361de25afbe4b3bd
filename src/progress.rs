//! Progress of slow work, such as reading a file or a fit. The work reports its progress, and another thread can cancel it.
//! [`processor_time`] is what the work costs.
//!
//! Guarantees: all clones of a [`Progress`] share one state, no function waits for another thread, and a cancelled
//! [`Progress`] stays cancelled.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Progress and cancellation of one computation. All clones share one state.
#[derive(Clone, Debug, Default)]
pub struct Progress(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    cancelled: Arc<AtomicBool>,
    done: AtomicU64,
    total: AtomicU64,
}

/// Error of a computation that was cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

impl Progress {
    /// Cancels the computation, which stops at its next call of [`Progress::check`].
    pub fn cancel(&self) {
        self.0.cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns the progress of a part of the work. The part counts its own steps, and is cancelled together with the whole
    /// work.
    pub fn part(&self) -> Self {
        Self(Arc::new(Inner { cancelled: Arc::clone(&self.0.cancelled), ..Inner::default() }))
    }

    /// Returns true if the work was cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.0.cancelled.load(Ordering::Relaxed)
    }

    /// Returns an error if the work was cancelled, so that `?` leaves a loop.
    ///
    /// # Errors
    /// [`Cancelled`] after [`Progress::cancel`].
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Adds to the total number of steps of the work. A step can be a byte, a sample or any other unit.
    pub fn add_total(&self, steps: u64) {
        self.0.total.fetch_add(steps, Ordering::Relaxed);
    }

    /// Adds to the number of steps of the work that are done.
    pub fn advance(&self, steps: u64) {
        self.0.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Returns the share of steps that are done, 0 to 1; `None` as long as the total number is unknown.
    pub fn fraction(&self) -> Option<f32> {
        let total = self.0.total.load(Ordering::Relaxed);
        let done = self.0.done.load(Ordering::Relaxed);
        (total > 0).then(|| (done as f64 / total as f64).min(1.0) as f32)
    }
}

/// Returns the processor time that all threads of this program have used since its start.
#[cfg(unix)]
pub fn processor_time() -> Duration {
    let used = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::new(used.tv_sec as u64, used.tv_nsec as u32)
}

/// Returns an upper limit of the processor time that this program has used since the first call: the time multiplied by the
/// number of processors. Measured processor times need code that the compiler cannot check on this system.
#[cfg(not(unix))]
pub fn processor_time() -> Duration {
    static START: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    let processors = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
    START.elapsed() * processors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_cancel_and_fraction() {
        let work = Progress::default();
        let watcher = work.clone();
        assert_eq!(watcher.fraction(), None);
        work.add_total(4);
        work.advance(1);
        assert_eq!(watcher.fraction(), Some(0.25));
        watcher.cancel();
        assert_eq!(work.check(), Err(Cancelled));
    }

    #[test]
    fn a_part_is_cancelled_with_the_whole_and_counts_for_itself() {
        let whole = Progress::default();
        let part = whole.part();
        part.add_total(2);
        assert_eq!((whole.fraction(), part.fraction()), (None, Some(0.0)));
        whole.cancel();
        assert!(part.is_cancelled());
    }
}
