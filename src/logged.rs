//! Writes the program's log to standard error, filtered by the environment variable `RUST_LOG`. Errors of file dialogs are
//! also kept, so that the window can show them. The library of the dialogs reports errors only in the log: a dialog that
//! failed returns the same as a cancelled one.

use std::sync::Mutex;

use log::{Level, LevelFilter, Log, Metadata, Record};

use crate::panicked::locked;

const DIALOGS: &str = "rfd";

static DIALOG_ERROR: Mutex<Option<String>> = Mutex::new(None);

struct Logger(env_logger::Logger);

fn is_dialog_error(metadata: &Metadata<'_>) -> bool {
    let target = metadata.target();
    metadata.level() == Level::Error && target.split("::").next() == Some(DIALOGS)
}

impl Log for Logger {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        is_dialog_error(metadata) || self.0.enabled(metadata)
    }

    fn log(&self, record: &Record<'_>) {
        if is_dialog_error(record.metadata()) {
            let mut kept = locked(&DIALOG_ERROR);
            *kept = Some(record.args().to_string());
        }
        self.0.log(record);
    }

    fn flush(&self) {
        self.0.flush();
    }
}

/// Starts the log. Nothing is logged before this call.
pub fn start() {
    let logger = env_logger::Builder::from_default_env().build();
    let level = logger.filter().max(LevelFilter::Error);
    if log::set_boxed_logger(Box::new(Logger(logger))).is_ok() {
        log::set_max_level(level);
    }
}

/// Returns the newest error of a file dialog, and forgets it.
pub fn take_dialog_error() -> Option<String> {
    let mut kept = locked(&DIALOG_ERROR);
    kept.take()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_errors_of_dialogs_are_kept() {
        let logger = Logger(env_logger::Builder::new().filter_level(LevelFilter::Off).build());
        let log = |target: &str, level: Level, text: &str| {
            let arguments = format_args!("{text}");
            let record = Record::builder().target(target).level(level).args(arguments).build();
            logger.log(&record);
        };
        log("rfd::backend::zenity", Level::Warn, "Using zenity fallback");
        log("rfdx", Level::Error, "other");
        assert_eq!(take_dialog_error(), None);
        log("rfd::backend::portal", Level::Error, "OpenFile failed");
        assert_eq!(take_dialog_error().as_deref(), Some("OpenFile failed"));
        assert_eq!(take_dialog_error(), None);
    }
}
