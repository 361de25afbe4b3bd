//! Modal questions of the window to the user.

use std::path::Path;

use crate::engine::{Action, Doubt, Engine, FileContent, Leaving, LeftSession, Session};
use crate::finding::Face;
use crate::questions::page::utc;
use crate::shown::first;
use crate::ui::command::Command;
use crate::ui::controls::Controls as _;
use crate::ui::numbers::{elided, file_size};

const LIST_HEIGHT: f32 = 320.0;
/// Number of characters of a missing file's path that fit.
const LOST_CHARS: usize = 70;
/// Maximum number of file names listed for each unsaved session.
const LEFT_FILES: usize = 4;

struct Naming {
    content: FileContent,
    path: String,
    /// True until the field was drawn once.
    is_new: bool,
}

#[derive(Default)]
pub struct Questions {
    naming: Option<Naming>,
    /// Folder that now holds the files of the session.
    found: String,
}

impl Questions {
    pub fn ask_path(&mut self, content: FileContent) {
        self.naming = Some(Naming { path: content.usual_name().to_owned(), content, is_new: true });
    }

    /// Takes the content that waits for a path, which ends the question.
    pub fn take_content(&mut self) -> Option<FileContent> {
        Some(self.naming.take()?.content)
    }

    pub fn show(&mut self, context: &egui::Context, engine: &Engine, out: &mut Vec<Command>) {
        naming(context, &mut self.naming, out);
        replacing(context, engine, out);
        leaving(context, engine, self.naming.is_some(), out);
        recovering(context, engine, out);
        lost(context, engine, &mut self.found, out);
    }
}

/// Asks before a file is replaced, and before a calibration is exported that is undetermined or differs from the screen.
fn replacing(context: &egui::Context, engine: &Engine, out: &mut Vec<Command>) {
    let Some((_, path, doubt)) = &engine.replacing else {
        return;
    };
    let (title, reason, yes) = match doubt {
        Doubt::IsThere => (
            "The file already exists",
            None,
            ("Replace it", "The present contents of the file are lost"),
        ),
        Doubt::Undetermined(undetermined, _) => (
            "The samples do not determine this calibration",
            Some(undetermined.finding().text(Face::Window)),
            ("Export anyway", "The errors of its loads are unknown"),
        ),
    };
    let no = ("Leave it", "Nothing is written");
    let modal = egui::Modal::new(egui::Id::unique("replace")).show(context, |ui| {
        ui.set_width(420.0);
        ui.strong(title);
        ui.label(path.display().to_string());
        if let Some(reason) = reason {
            ui.label(reason);
        }
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            for ((label, explanation), answer) in [(yes, true), (no, false)] {
                if ui.press(label, explanation) {
                    out.push(Action::Replace(answer).into());
                }
            }
        });
    });
    if modal.should_close() {
        out.push(Action::Replace(false).into());
    }
}

/// Lets the user type a path if the machine has no file dialog.
fn naming(context: &egui::Context, naming: &mut Option<Naming>, out: &mut Vec<Command>) {
    let Some(Naming { path, is_new, .. }) = naming else {
        return;
    };
    let is_new = std::mem::take(is_new);
    let modal = egui::Modal::new(egui::Id::unique("naming")).show(context, |ui| {
        ui.set_width(420.0);
        let label = ui.strong("Save as");
        let field = egui::TextEdit::singleline(path).desired_width(f32::INFINITY);
        let field = ui.add(field).labelled_by(label.id);
        let field = field.on_hover_text("Path of the file; its ending chooses the format");
        if is_new {
            field.request_focus();
        }
        let entered = ui.entered(&field);
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let chosen = path.trim();
            if (ui.press("Save", "Writes this file; Enter does too") || entered)
                && !chosen.is_empty()
            {
                out.push(Command::PathTyped(Some(chosen.into())));
            }
            if ui.press("Cancel", "Nothing is written") {
                out.push(Command::PathTyped(None));
            }
        });
    });
    if modal.should_close() {
        out.push(Command::PathTyped(None));
    }
}

/// Asks whether to save before the window closes or another session is opened.
fn leaving(context: &egui::Context, engine: &Engine, is_naming: bool, out: &mut Vec<Command>) {
    let Some(leaving) = &engine.leaving else {
        return;
    };
    // The session is already being saved.
    if is_naming || engine.replacing.is_some() {
        return;
    }
    let (save, discard, cancel) = match leaving {
        Leaving::Close => (
            "Saves the session, then closes; asks for a path if it has no file yet",
            "Closes; changes since the last save are lost",
            "The window stays open",
        ),
        Leaving::Open(_) | Leaving::Restore(..) => (
            "Saves, then opens the other session; asks for a path if this one has no file yet",
            "Opens the other session; changes since the last save are lost",
            "The other session is not opened",
        ),
    };
    let mut say = |command: Command| out.push(command);
    let modal = egui::Modal::new(egui::Id::unique("leaving")).show(context, |ui| {
        ui.set_width(420.0);
        ui.strong("The session is not saved");
        ui.label("The session holds the list of files, their roles and all settings. The recordings themselves are not changed.");
        if !matches!(leaving, Leaving::Close) {
            ui.label("Another session is about to be opened in its place.");
        }
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            for (label, explanation, command) in [
                ("Save", save, Command::SaveSession),
                ("Discard", discard, Action::Discard.into()),
                ("Cancel", cancel, Action::Stay.into()),
            ] {
                if ui.press(label, explanation) {
                    say(command);
                }
            }
        });
    });
    if modal.should_close() {
        say(Action::Stay.into());
    }
}

/// Offers the unsaved sessions of windows that did not close properly, newest first.
fn recovering(context: &egui::Context, engine: &Engine, out: &mut Vec<Command>) {
    if engine.recoverable.is_empty() || !engine.shows_left {
        return;
    }
    let mut say = |command: Command| out.push(command);
    let mut open = true;
    egui::Window::new("Recover")
        .open(&mut open)
        .anchor(egui::Align2::CENTER_TOP, [0.0, 60.0])
        .collapsible(false)
        .resizable(false)
        .show(context, |ui| {
            ui.set_width(460.0);
            ui.label("LoopScope did not close properly. Its unsaved work was stored, and stays stored until you discard it.");
            egui::ScrollArea::vertical().max_height(LIST_HEIGHT).show(ui, |ui| {
                for (at, left) in engine.recoverable.iter().enumerate().rev() {
                    ui.separator();
                    ui.push_id(at, |ui| one_left(ui, left, &mut say));
                }
            });
            ui.separator();
            if ui.press("Later", "Keeps the unsaved sessions; File > Recover sessions lists them again") {
                say(Action::ShowLeft(false).into());
            }
        });
    if !open {
        say(Action::ShowLeft(false).into());
    }
}

fn one_left(ui: &mut egui::Ui, left: &LeftSession, say: &mut impl FnMut(Command)) {
    ui.horizontal(|ui| {
        ui.strong(utc(left.written));
        ui.weak(file_size(left.bytes));
    });
    match &left.session {
        Ok(session) => {
            let paths = session.files.iter().map(|file| &file.absolute);
            let paths = paths.map(|path| path.display().to_string());
            let paths = paths.collect::<Vec<_>>().join("\n");
            ui.label(files_of(session)).on_hover_text(paths);
        }
        Err(reason) => {
            let reason = format!("It cannot be read: {reason}");
            ui.warn(reason).on_hover_text(left.path.display().to_string());
        }
    }
    ui.horizontal(|ui| {
        let restore = ui.add_enabled(left.session.is_ok(), egui::Button::new("Restore"));
        let restore = restore
            .on_hover_text("Opens its files with all settings; the other sessions stay listed")
            .on_disabled_hover_text("The stored session cannot be read");
        if restore.clicked() {
            say(Action::Restore(left.path.clone()).into());
        }
        if ui.press("Discard", "Deletes this unsaved session; the recordings stay") {
            say(Action::DropLeft(left.path.clone()).into());
        }
    });
}

/// Returns the names of a session's files, as many as fit.
fn files_of(session: &Session) -> String {
    let names = session.files.iter().map(|file| {
        let path = &file.absolute;
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    });
    let built_in = session.built_in.then(|| "built-in sensor".to_owned());
    let max = LEFT_FILES + usize::from(session.built_in);
    match first(max, built_in.into_iter().chain(names)) {
        none if none.is_empty() => "no files".to_owned(),
        names => names,
    }
}

/// Asks for the folder of the session's files that were moved.
fn lost(context: &egui::Context, engine: &Engine, found: &mut String, out: &mut Vec<Command>) {
    let lost = &engine.project().lost;
    if lost.is_empty() {
        return;
    }
    let title = match lost.len() {
        1 => "A file of the session was not found".to_owned(),
        n => format!("{n} files of the session were not found"),
    };
    egui::Window::new(title)
        .id(egui::Id::unique("lost"))
        .anchor(egui::Align2::CENTER_TOP, [0.0, 60.0])
        .collapsible(false)
        .resizable(false)
        .show(context, |ui| {
            ui.set_width(520.0);
            let list = egui::ScrollArea::vertical().max_height(LIST_HEIGHT);
            list.show(ui, |ui| {
                for (at, file) in lost.iter().enumerate() {
                    ui.push_id(at, |ui| one_lost(ui, at, &file.absolute, out));
                }
            });
            ui.separator();
            ui.horizontal(|ui| {
                let field = egui::TextEdit::singleline(found).desired_width(380.0);
                let field = ui.field(
                    "Now in the folder",
                    field,
                    "Present folder of the files, or of one of them; the others are found by their names and \
                     relative folders",
                );
                let entered =
                    ui.entered(&field);
                let look = ui.press("Look there", "Reads the files found in this folder; Enter does the same");
                let path = found.trim().to_owned();
                if (look || entered) && !path.is_empty() {
                    out.push(Action::Locate(path.into()).into());
                }
            });
            ui.horizontal(|ui| {
                if ui.press("Choose a folder…", "Chooses the folder to search") {
                    out.push(Command::ChooseLost);
                }
                if ui.press("Go on without", "Opens the session without the missing files") {
                    out.extend(lost.iter().map(|_| Action::Forget(0).into()));
                }
            });
        });
}

fn one_lost(ui: &mut egui::Ui, at: usize, path: &Path, out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        if ui.press_small("×", "Removes this file from the session") {
            out.push(Action::Forget(at).into());
        }
        let path = path.display().to_string();
        ui.label(elided(&path, LOST_CHARS)).on_hover_text(path);
    });
}
