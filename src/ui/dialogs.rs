//! The desktop's file dialogs, off the window's thread.
//!
//! Not every machine has them, and one that failed looks like one that was cancelled; so every dialog has a path field
//! as another way, and an answer that came faster than a person could give it is taken as a failure and said.

use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use crate::app::{Command, Level, Notice};
use crate::worker::Notify;

/// No person cancels a dialog this quickly.
const TOO_QUICK_FOR_A_PERSON: Duration = Duration::from_millis(150);

/// Where the answers go: commands, and a call that wakes the window.
#[derive(Clone)]
pub struct Reply {
    /// Takes the command that the answer means.
    pub commands: Sender<Command>,
    /// Wakes the window.
    pub notify: Notify,
}

impl Reply {
    /// Sends a command and wakes the window.
    pub fn send(&self, command: Command) {
        // Nobody listens any more when the window has closed.
        let _ = self.commands.send(command);
        (self.notify)();
    }
}

/// Ways to ask for files; a test puts its own in place of the desktop's.
pub trait Dialogs {
    /// Asks for files to open.
    fn open_files(&mut self, reply: Reply);
    /// Asks for a file to export a calibration to.
    fn export(&mut self, reply: Reply);
}

/// The desktop's own dialogs.
#[derive(Debug, Default)]
pub struct NativeDialogs;

impl Dialogs for NativeDialogs {
    fn open_files(&mut self, reply: Reply) {
        asked(reply, || {
            let dialog = rfd::AsyncFileDialog::new()
                .set_title("Open recordings or a calibration")
                .add_filter(
                    "Recordings and calibrations",
                    &[
                        "csv", "txt", "tsv", "dat", "npz", "npy", "mat", "parquet", "mcap", "json",
                    ],
                )
                .add_filter("All files", &["*"]);
            let files = pollster::block_on(dialog.pick_files())?;
            let paths = files.iter().map(|file| file.path().to_owned()).collect();
            Some(Command::OpenFiles(paths))
        });
    }

    fn export(&mut self, reply: Reply) {
        asked(reply, || {
            let dialog = rfd::AsyncFileDialog::new()
                .set_title("Export the calibration")
                .set_file_name("calibration.json")
                .add_filter("Calibration, complete (JSON)", &["json"])
                .add_filter("Calibration, matrices (CSV)", &["csv"]);
            let file = pollster::block_on(dialog.save_file())?;
            Some(Command::Export(file.path().to_owned()))
        });
    }
}

fn asked(reply: Reply, ask: impl FnOnce() -> Option<Command> + Send + 'static) {
    std::thread::spawn(move || {
        let start = Instant::now();
        match ask() {
            Some(command) => reply.send(command),
            None if start.elapsed() < TOO_QUICK_FOR_A_PERSON => {
                reply.send(Command::Tell(Notice::new(
                    Level::Warning,
                    "This machine offers no file dialog; type a path in the field instead, or drop files on the window",
                )));
            }
            None => {}
        }
    });
}
