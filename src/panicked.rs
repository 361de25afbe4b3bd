//! Converts a panic to an error. A panic shows a defect of this program, or of a library that reads damaged files.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

thread_local! {
    /// True while the message of a panic on this thread must not be written to standard error.
    static IS_QUIET: Cell<bool> = const { Cell::new(false) };
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("internal error of the program, please report it: {message}")]
pub struct Panicked {
    pub message: String,
}

/// Locks a mutex, even if another thread panicked while it held the lock.
pub(crate) fn locked<T: ?Sized>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Calls `work`. If it panics, returns the panic as an error.
///
/// # Errors
/// [`Panicked`] with the message of the panic.
pub fn caught<A>(work: impl FnOnce() -> A) -> Result<A, Panicked> {
    catch_unwind(AssertUnwindSafe(work))
        .map_err(|payload| Panicked { message: panic_message(&*payload) })
}

/// Calls `work` as [`caught`] does, but without a message on standard error. It is for libraries that panic on damaged files.
pub fn caught_quietly<A>(work: impl FnOnce() -> A) -> Result<A, Panicked> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let tell = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if !IS_QUIET.get() {
                tell(info);
            }
        }));
    });
    let was_quiet = IS_QUIET.replace(true);
    let done = caught(work);
    IS_QUIET.set(was_quiet);
    done
}

pub fn panic_message(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_converted_to_its_message() {
        assert_eq!(caught(|| 7), Ok(7));
        let error = caught(|| -> u32 { panic!("no {}", 8) }).unwrap_err();
        assert_eq!(error.message, "no 8");
        let error = caught_quietly(|| -> u32 { panic!("no {}", 9) }).unwrap_err();
        assert_eq!((error.message.as_str(), IS_QUIET.get()), ("no 9", false));
    }
}
