//! What the window asks a person, in front of everything else.

use std::path::Path;

use crate::engine::{Action, Doubt, Engine, FileContent, Leaving, LeftSession, Session};
use crate::export::utc;
use crate::finding::Face;
use crate::shown::first;
use crate::ui::command::Command;
use crate::ui::controls::Controls as _;
use crate::ui::numbers::{elided, file_size};

/// Height of a list of sessions or files.
const LIST_HEIGHT: f32 = 320.0;
/// Of the path of a file that is lost so many characters have room.
const LOST_CHARS: usize = 70;
/// So many files of each are named.
const LEFT_FILES: usize = 4;

/// A path that is being typed for what waits to be saved.
struct Naming {
    content: FileContent,
    path: String,
    /// Whether it was not drawn yet.
    is_new: bool,
}

/// What is typed into the answers.
#[derive(Default)]
pub struct Questions {
    naming: Option<Naming>,
    /// Where files of the session are now.
    found: String,
}

impl Questions {
    /// Asks where to write this.
    pub fn ask_path(&mut self, content: FileContent) {
        self.naming = Some(Naming { path: content.usual_name().to_owned(), content, is_new: true });
    }

    /// What waits for a path; it waits no longer.
    pub fn take_content(&mut self) -> Option<FileContent> {
        Some(self.naming.take()?.content)
    }

    /// Draws what is asked now.
    pub fn show(&mut self, context: &egui::Context, engine: &Engine, out: &mut Vec<Command>) {
        naming(context, &mut self.naming, out);
        replacing(context, engine, out);
        leaving(context, engine, self.naming.is_some(), out);
        recovering(context, engine, out);
        lost(context, engine, &mut self.found, out);
    }
}

/// Asks before a file is written that is there already, that holds a fit which says nothing, or less than is shown.
fn replacing(context: &egui::Context, engine: &Engine, out: &mut Vec<Command>) {
    let Some((_, path, doubt)) = &engine.replacing else {
        return;
    };
    let (title, reason, yes) = match doubt {
        Doubt::IsThere => {
            ("The file is there already", None, ("Replace it", "What is in the file now is lost"))
        }
        Doubt::Undetermined(undetermined, _) => (
            "The samples do not determine this calibration",
            Some(undetermined.finding().text(Face::Window)),
            ("Export anyway", "Nobody can tell how wrong its loads are"),
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

/// Lets a path be typed where there is no dialog to choose one.
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
        let field =
            field.on_hover_text("The path of the file; its ending says as what it is written");
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

/// Asks what becomes of what is not saved before the window closes or something else takes its place.
fn leaving(context: &egui::Context, engine: &Engine, is_naming: bool, out: &mut Vec<Command>) {
    let Some(leaving) = &engine.leaving else {
        return;
    };
    // It is just being saved.
    if is_naming || engine.replacing.is_some() {
        return;
    }
    let (save, discard, cancel) = match leaving {
        Leaving::Close => (
            "Saves, then closes; asks where, if it has no file yet",
            "Closes; what was chosen since is lost",
            "The window stays open",
        ),
        Leaving::Open(_) | Leaving::Restore(..) => (
            "Saves, then opens the other session; asks where, if it has no file yet",
            "Opens the other session; what was chosen since is lost",
            "The other session is not opened",
        ),
    };
    let mut say = |command: Command| out.push(command);
    let modal = egui::Modal::new(egui::Id::unique("leaving")).show(context, |ui| {
        ui.set_width(420.0);
        ui.strong("The session is not saved");
        ui.label("It names the files, their roles and every setting; the recordings themselves are not changed.");
        if !matches!(leaving, Leaving::Close) {
            ui.label("Another session takes its place.");
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

/// Offers what windows left that did not close as they should, the newest first.
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
            ui.label("LoopScope did not close as it should. What was not saved then was written down, and stays until it is discarded.");
            egui::ScrollArea::vertical().max_height(LIST_HEIGHT).show(ui, |ui| {
                for (at, left) in engine.recoverable.iter().enumerate().rev() {
                    ui.separator();
                    ui.push_id(at, |ui| one_left(ui, left, &mut say));
                }
            });
            ui.separator();
            if ui.press("Later", "They stay; File > Recover sessions lists them again") {
                say(Action::ShowLeft(false).into());
            }
        });
    if !open {
        say(Action::ShowLeft(false).into());
    }
}

/// When it was written, how large it is, its files, and what can be done with it.
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
            .on_hover_text("Opens its files with every choice of then; the others stay listed")
            .on_disabled_hover_text("There is nothing in it that can be read");
        if restore.clicked() {
            say(Action::Restore(left.path.clone()).into());
        }
        if ui.press("Discard", "It is lost; the recordings stay") {
            say(Action::DropLeft(left.path.clone()).into());
        }
    });
}

/// The names of a session's files, as many as have room.
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

/// Asks where files of the session are that are not where they were.
fn lost(context: &egui::Context, engine: &Engine, found: &mut String, out: &mut Vec<Command>) {
    let lost = &engine.project().lost;
    if lost.is_empty() {
        return;
    }
    let title = match lost.len() {
        1 => "A file of the session is not there".to_owned(),
        n => format!("{n} files of the session are not there"),
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
                    "The folder that they are in now, or one of them: the others are found by their names, and by the folders \
                     that they had among each other",
                );
                let entered =
                    ui.entered(&field);
                let look = ui.press("Look there", "Reads those that are found; Enter does the same");
                let path = found.trim().to_owned();
                if (look || entered) && !path.is_empty() {
                    out.push(Action::Locate(path.into()).into());
                }
            });
            ui.horizontal(|ui| {
                if ui.press("Choose a folder…", "Asks for the folder, and looks there") {
                    out.push(Command::ChooseLost);
                }
                if ui.press("Go on without", "The session goes on without what is not found") {
                    out.extend(lost.iter().map(|_| Action::Forget(0).into()));
                }
            });
        });
}

/// Where a file was, and going on without it.
fn one_lost(ui: &mut egui::Ui, at: usize, path: &Path, out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        if ui.press_small("×", "Goes on without this file") {
            out.push(Action::Forget(at).into());
        }
        let path = path.display().to_string();
        ui.label(elided(&path, LOST_CHARS)).on_hover_text(path);
    });
}
