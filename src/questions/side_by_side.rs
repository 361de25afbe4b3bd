//! Runs several fits at the same time on two threads, because the fit of a neural network uses only one processor core.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use crate::progress::Progress;

const N_THREADS: usize = 2;

/// Calls `job` with each number of `0..n` on two threads, and returns the results in no particular order. After a
/// cancellation, no further job starts.
pub(crate) fn side_by_side<T: Send>(
    n: usize,
    progress: &Progress,
    job: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let work = || {
        let jobs = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        let jobs = jobs.take_while(|at| *at < n && !progress.is_cancelled());
        jobs.map(&job).collect::<Vec<T>>()
    };
    thread::scope(|scope| {
        let threads: Vec<_> = (0..N_THREADS.min(n)).map(|_| scope.spawn(work)).collect();
        let results = threads.into_iter().map(|own| own.join());
        results.flat_map(|own| own.unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}
