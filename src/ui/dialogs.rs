//! The file dialogs of the desktop, which run outside the window's thread. If the desktop has no dialog, or a dialog fails, the
//! user can type a path.

use std::path::PathBuf;
use std::sync::mpsc::Sender;

use crate::{
    engine::{Action, Existing, FileContent, ImportCommand, query::Notify},
    export::TARGETS,
    formats,
    logged::take_dialog_error,
    ui::command::{Command, PathFor},
};

/// Way by which a file dialog answers the window.
#[derive(Clone)]
pub struct Reply {
    /// Channel for the command that uses the chosen file.
    pub commands: Sender<Command>,
    /// Wakes the window, so that it handles the command.
    pub notify: Notify,
}

impl Reply {
    /// Sends a command and wakes the window.
    pub fn send(&self, command: Command) {
        // Sending fails only if the window has closed.
        let _ = self.commands.send(command);
        (self.notify)();
    }
}

impl PathFor {
    /// Returns the title of the dialog that asks for the path.
    pub fn title(&self) -> &'static str {
        match self {
            Self::Open => "Open recordings, a calibration or a session",
            Self::Import => "Import a recording",
            Self::Follow => "Choose a log file that is being written",
            Self::Locate => "Choose the folder that now holds the session's files",
            Self::Save(_) => "Save as",
        }
    }

    /// Returns the command that uses the chosen paths. `existing` says whether a chosen file may be replaced.
    pub fn answer(self, mut paths: Vec<PathBuf>, existing: Existing) -> Option<Command> {
        let last = paths.pop()?;
        Some(match self {
            Self::Open => {
                paths.push(last);
                Action::Open(paths).into()
            }
            Self::Import => ImportCommand::Open(last).into(),
            Self::Follow => Action::Follow(last).into(),
            Self::Locate => Action::Locate(last).into(),
            // The export itself checks that the file's ending belongs to an export format.
            Self::Save(FileContent::Calibration(..)) => Action::Export(vec![last], existing).into(),
            Self::Save(content) => Action::Save(content, last, existing).into(),
        })
    }
}

/// Returns the command that uses the paths that a dialog has chosen. A dialog asks before it chooses an existing file.
pub fn chosen(what: PathFor, paths: Vec<PathBuf>) -> Option<Command> {
    // For a new file, the dialog asked nothing. But an export may also write further files, which may exist.
    let exists = paths.iter().any(|path| path.exists());
    what.answer(paths, if exists { Existing::Replace } else { Existing::Ask })
}

/// Way to ask the user for files. Tests replace the desktop's dialogs.
pub trait Dialogs {
    /// Asks for one path or several.
    fn ask(&mut self, what: PathFor, reply: Reply);
}

/// The file dialogs of the desktop.
#[derive(Debug, Default)]
pub struct NativeDialogs;

impl Dialogs for NativeDialogs {
    fn ask(&mut self, what: PathFor, reply: Reply) {
        let mut dialog = rfd::AsyncFileDialog::new().set_title(what.title());
        match &what {
            PathFor::Open => {
                let calibrations = TARGETS.iter().filter(|target| target.reader.is_some());
                let calibrations = calibrations.flat_map(|target| target.endings.iter().copied());
                let endings: Vec<&str> = formats::endings().chain(calibrations).collect();
                dialog = dialog.add_filter("Recordings, calibrations, sessions", &endings);
                dialog = dialog.add_filter("All files", &["*"]);
            }
            PathFor::Save(content) => {
                dialog = dialog.set_file_name(content.usual_name());
                for (name, endings) in content.formats() {
                    dialog = dialog.add_filter(name, &endings);
                }
            }
            _ => {}
        }
        std::thread::spawn(move || {
            let _ = take_dialog_error();
            let files = pollster::block_on(async {
                match &what {
                    PathFor::Open => return dialog.pick_files().await,
                    PathFor::Locate => dialog.pick_folder().await,
                    PathFor::Save(_) => dialog.save_file().await,
                    _ => dialog.pick_file().await,
                }
                .map(|file| vec![file])
            });
            let paths = files.into_iter().flatten().map(|file| file.path().to_owned());
            match chosen(what.clone(), paths.collect()) {
                Some(command) => reply.send(command),
                None if take_dialog_error().is_some() => reply.send(Command::TypePath(what)),
                None => {}
            }
        });
    }
}
