//! The file dialogs of the desktop, which run outside the window's thread. If the desktop has no dialog, or a dialog fails, the
//! user can type a path.

use std::path::PathBuf;
use std::sync::mpsc::Sender;

use crate::{
    engine::{Action, Existing, FileContent, ImportCommand, Level, query::Notify},
    export::TARGETS,
    formats,
    logged::take_dialog_error,
    ui::command::Command,
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

/// Returns the command that writes content to the chosen file. The dialog has already asked before it chose an existing file.
pub fn save_to(content: FileContent, path: PathBuf) -> Command {
    // For a new file, the dialog asked nothing. But an export may also write further files, which may exist.
    let existing = if path.exists() { Existing::Replace } else { Existing::Ask };
    write(content, path, existing)
}

pub fn write(content: FileContent, path: PathBuf, existing: Existing) -> Command {
    let action = match content {
        // The export itself checks that the file's ending belongs to an export format.
        FileContent::Calibration(..) => Action::Export(vec![path], existing),
        content => Action::Save(content, path, existing),
    };
    action.into()
}

/// Ways to ask the user for files. Tests replace the desktop's dialogs.
pub trait Dialogs {
    /// Asks which files to open.
    fn open_files(&mut self, reply: Reply);
    /// Asks which file to import.
    fn import(&mut self, reply: Reply);
    /// Asks for a growing log file, whose new rows the program reads.
    fn follow(&mut self, reply: Reply) {
        one_file(reply, "Choose a log file that is being written", |path| {
            Action::Follow(path).into()
        });
    }
    /// Asks for the folder that now holds the files of the session.
    fn locate(&mut self, reply: Reply) {
        let dialog = rfd::AsyncFileDialog::new()
            .set_title("Choose the folder that now holds the session's files");
        asked(reply, no_dialog(), || {
            let folder = pollster::block_on(dialog.pick_folder())?;
            Some(Action::Locate(folder.path().to_owned()).into())
        });
    }
    /// Asks for the file to which the content is written.
    fn save(&mut self, content: FileContent, reply: Reply);
}

/// The file dialogs of the desktop.
#[derive(Debug, Default)]
pub struct NativeDialogs;

impl Dialogs for NativeDialogs {
    fn open_files(&mut self, reply: Reply) {
        let calibrations = TARGETS.iter().filter(|target| target.reader.is_some());
        let calibrations = calibrations.flat_map(|target| target.endings.iter().copied());
        let endings: Vec<&str> = formats::endings().chain(calibrations).collect();
        let dialog = rfd::AsyncFileDialog::new()
            .set_title("Open recordings, a calibration or a session")
            .add_filter("Recordings, calibrations, sessions", &endings)
            .add_filter("All files", &["*"]);
        asked(reply, no_dialog(), || {
            let files = pollster::block_on(dialog.pick_files())?;
            let paths = files.iter().map(|file| file.path().to_owned()).collect();
            Some(Action::Open(paths).into())
        });
    }

    fn import(&mut self, reply: Reply) {
        one_file(reply, "Import a recording", |path| ImportCommand::Open(path).into());
    }

    fn save(&mut self, content: FileContent, reply: Reply) {
        let mut dialog =
            rfd::AsyncFileDialog::new().set_title("Save").set_file_name(content.usual_name());
        for (name, endings) in content.formats() {
            dialog = dialog.add_filter(name, &endings);
        }
        let none = Command::TypePathFor(content.clone());
        asked(reply, none, || {
            let file = pollster::block_on(dialog.save_file())?;
            Some(save_to(content, file.path().to_owned()))
        });
    }
}

fn one_file(reply: Reply, title: &str, chosen: fn(PathBuf) -> Command) {
    let dialog = rfd::AsyncFileDialog::new().set_title(title);
    asked(reply, no_dialog(), move || {
        let file = pollster::block_on(dialog.pick_file())?;
        Some(chosen(file.path().to_owned()))
    });
}

fn no_dialog() -> Command {
    Command::tell(
        Level::Warning,
        "This computer has no file dialog; type a path in the field instead, or drop files on the window",
    )
}

fn asked(
    reply: Reply,
    without_dialogs: Command,
    ask: impl FnOnce() -> Option<Command> + Send + 'static,
) {
    std::thread::spawn(move || {
        let _ = take_dialog_error();
        match ask() {
            Some(command) => reply.send(command),
            None if take_dialog_error().is_some() => reply.send(without_dialogs),
            None => {}
        }
    });
}
