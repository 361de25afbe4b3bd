//! Reads files on threads that can be abandoned, because a crate that reads a damaged file, or a broken network drive, may
//! never return.

use std::panic::resume_unwind;
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::{import::error::ReadError, progress::Progress};

/// Time between two checks whether the work was cancelled.
const CHECK_EVERY: Duration = Duration::from_millis(20);
/// Time that a reader has to return after the work was cancelled, before its thread is abandoned.
const PATIENCE: Duration = Duration::from_secs(2);

/// Calls `read` on another thread and waits for its result. If the work is cancelled and `read` does not return, the thread is
/// abandoned: it keeps running, and its result is dropped.
pub fn abandonable<A: Send + 'static>(
    path: &Path,
    progress: &Progress,
    read: impl FnOnce(&Progress) -> Result<A, ReadError> + Send + 'static,
) -> Result<A, ReadError> {
    let (done, is_done) = channel();
    let of_thread = progress.clone();
    let thread = thread::spawn(move || {
        // Sending fails only if this thread was abandoned.
        let _ = done.send(read(&of_thread));
    });
    let mut cancelled_since = None;
    loop {
        match is_done.recv_timeout(CHECK_EVERY) {
            Ok(read) => return read,
            Err(RecvTimeoutError::Disconnected) => {
                resume_unwind(thread.join().expect_err("a thread without a result has panicked"))
            }
            Err(RecvTimeoutError::Timeout) if progress.is_cancelled() => {
                if cancelled_since.get_or_insert_with(Instant::now).elapsed() > PATIENCE {
                    let error = ReadError::Abandoned { path: path.to_owned() };
                    log::warn!("{error}");
                    return Err(error);
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panicked::caught_quietly;

    fn run<A: Send + 'static>(
        progress: &Progress,
        read: impl FnOnce(&Progress) -> Result<A, ReadError> + Send + 'static,
    ) -> Result<A, ReadError> {
        abandonable(Path::new("a"), progress, read)
    }

    #[test]
    fn a_reader_that_returns_is_waited_for_even_after_a_cancellation() {
        let progress = Progress::default();
        assert_eq!(run(&progress, |_| Ok(7)).unwrap(), 7);
        progress.cancel();
        assert_eq!(run(&progress, |_| Ok(7)).unwrap(), 7);
        let read = run(&progress, |progress| Ok(progress.check()?));
        assert!(matches!(read, Err(ReadError::Cancelled)));
    }

    #[test]
    fn a_panic_of_a_reader_goes_on_in_the_calling_thread() {
        let panics = || run::<()>(&Progress::default(), |_| resume_unwind(Box::new("no 7")));
        assert_eq!(caught_quietly(panics).unwrap_err().message, "no 7");
    }

    #[test]
    fn a_cancelled_reader_that_never_returns_is_abandoned() {
        let progress = Progress::default();
        progress.cancel();
        let read = run::<()>(&progress, |_| {
            loop {
                thread::park();
            }
        });
        assert!(matches!(read, Err(ReadError::Abandoned { .. })), "{read:?}");
    }
}
