//! A panic is a defect of ours; whoever waits for the work hears of it as of any other error.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The work panicked; the message is the panic's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("internal error, please report it: {message}")]
pub struct Panicked {
    /// What the panic said.
    pub message: String,
}

/// Does the work; a panic becomes an error.
///
/// # Errors
/// [`Panicked`] with what the panic said.
pub fn caught<A>(work: impl FnOnce() -> A) -> Result<A, Panicked> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| Panicked {
        message: panic_message(&*payload),
    })
}

/// What a panic said.
#[must_use]
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
    fn a_panic_becomes_its_message() {
        assert_eq!(caught(|| 7), Ok(7));
        let error = caught(|| -> u32 { panic!("no {}", 8) }).unwrap_err();
        assert_eq!(error.message, "no 8");
    }
}
