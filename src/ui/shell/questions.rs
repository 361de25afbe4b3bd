//! Modal questions of the window to the user.

use std::borrow::Cow;

use egui::Context;

use crate::{
    engine::{Action, Doubt, Engine, Existing, Leaving, LeftSession, Session},
    finding::Face,
    questions::page::utc,
    shown::{file_name, first},
    ui::{
        command::{Command, Out, PathFor},
        controls::Controls as _,
        numbers::{elided, file_size},
    },
};

const WIDTH: f32 = 420.0;
const LIST_HEIGHT: f32 = 320.0;
/// Maximum number of characters shown of a missing file's path.
const LOST_CHARS: usize = 70;
/// Maximum number of file names listed for each unsaved session.
const LEFT_FILES: usize = 4;

struct Naming {
    what: PathFor,
    path: String,
    /// True until the path field has been drawn for the first time and has the focus.
    is_new: bool,
}

#[derive(Default)]
pub struct Questions {
    naming: Option<Naming>,
}

impl Questions {
    pub fn ask_path(&mut self, what: PathFor) {
        let path = match &what {
            PathFor::Save(content) => content.usual_name().to_owned(),
            _ => String::new(),
        };
        self.naming = Some(Naming { what, path, is_new: true });
    }

    pub fn show(&mut self, context: &Context, engine: &Engine, out: &mut Out) {
        naming(context, &mut self.naming, out);
        replacing(context, engine, out);
        leaving(context, engine, self.naming.is_some(), out);
        recovering(context, engine, out);
        lost(context, engine, out);
    }
}

/// Draws a modal question. Each answer has a label, an explanation and a command. Escape chooses the last answer.
fn ask(
    context: &Context,
    id: &str,
    [title, text]: [&str; 2],
    answers: &[(&str, &str, Command)],
    out: &mut Out,
) {
    let modal = egui::Modal::new(egui::Id::unique(id)).show(context, |ui| {
        ui.set_width(WIDTH);
        ui.strong(title);
        ui.label(text);
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            for (label, explanation, command) in answers {
                if ui.press(*label, *explanation) {
                    out.send(command.clone());
                }
            }
        });
    });
    if modal.should_close() {
        out.0.extend(answers.last().map(|(.., command)| command.clone()));
    }
}

/// Asks before an existing file is replaced, and before a calibration is exported that the samples do not determine.
fn replacing(context: &Context, engine: &Engine, out: &mut Out) {
    let Some((output, doubt)) = &engine.replacing else {
        return;
    };
    let paths = output.paths.iter().map(|path| path.display().to_string());
    let paths: Vec<String> = paths.collect();
    let mut text = paths.join("\n");
    let (title, yes, about) = match doubt {
        Doubt::IsThere => (
            if paths.len() > 1 { "These files already exist" } else { "The file already exists" },
            "Replace it",
            "Overwrites what is there; the present contents are lost",
        ),
        Doubt::Undetermined(undetermined) => {
            text += "\n";
            text += &undetermined.finding().text(Face::Window);
            (
                "The samples do not determine this calibration",
                "Export anyway",
                "Writes the calibration, although the errors of its loads are unknown",
            )
        }
    };
    let answers = [
        (yes, about, Action::Replace(true).into()),
        ("Do not write", "Nothing is written", Action::Replace(false).into()),
    ];
    ask(context, "replace", [title, &text], &answers, out);
}

/// Lets the user type a path.
fn naming(context: &Context, naming: &mut Option<Naming>, out: &mut Out) {
    let Some(Naming { what, path, is_new }) = naming else {
        return;
    };
    let is_new = std::mem::take(is_new);
    let (button, about) = match what {
        PathFor::Save(_) => ("Save", "Path of the file; its ending chooses the format"),
        _ => ("Open", "Path of a file or of a folder"),
    };
    let mut is_answered = false;
    let modal = egui::Modal::new(egui::Id::unique("naming")).show(context, |ui| {
        ui.set_width(WIDTH);
        let label = ui.strong(what.title());
        let field = egui::TextEdit::singleline(path).desired_width(f32::INFINITY);
        let field = ui.add(field).labelled_by(label.id).on_hover_text(about);
        if is_new {
            field.request_focus();
        }
        let entered = ui.entered(&field);
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let chosen = path.trim();
            if (ui.press(button, "Enter does the same") || entered) && !chosen.is_empty() {
                out.0.extend(what.clone().answer(vec![chosen.into()], Existing::Ask));
                is_answered = true;
            }
            is_answered |= ui.press("Cancel", "Nothing is done");
        });
    });
    if is_answered || modal.should_close() {
        *naming = None;
    }
}

/// Asks whether to save before the window closes or another session is opened.
fn leaving(context: &Context, engine: &Engine, is_naming: bool, out: &mut Out) {
    let Some(leaving) = &engine.leaving else {
        return;
    };
    // The user has already chosen to save, and is now choosing the path, or confirming that a file is replaced.
    if is_naming || engine.replacing.is_some() {
        return;
    }
    let what = match leaving {
        Leaving::Close => "The window is about to be closed.",
        Leaving::New => "The recordings are about to be closed.",
        Leaving::Open(_) | Leaving::Restore(..) => "Another session is about to be opened.",
    };
    let text = format!("{what} Files of recordings are not changed.");
    let save = "Saves the session first; asks for a path if it has no file yet";
    let discard = "Changes since the last save are lost";
    let cancel = "Everything stays open";
    let answers = [
        ("Save", save, Command::SaveSession),
        ("Discard", discard, Action::Discard.into()),
        ("Cancel", cancel, Action::Stay.into()),
    ];
    ask(context, "leaving", ["The session is not saved", &text], &answers, out);
}

/// Offers the unsaved sessions of windows that did not close properly, newest first.
fn recovering(context: &Context, engine: &Engine, out: &mut Out) {
    if engine.recoverable.is_empty() || !engine.shows_left {
        return;
    }
    let mut open = true;
    window("Recover").open(&mut open).show(context, |ui| {
        ui.set_width(460.0);
        ui.label(
            "LoopScope did not close properly. The unsaved work is stored until you discard it.",
        );
        egui::ScrollArea::vertical().max_height(LIST_HEIGHT).show(ui, |ui| {
            for (at, left) in engine.recoverable.iter().enumerate().rev() {
                ui.separator();
                ui.push_id(at, |ui| one_left(ui, left, out));
            }
        });
        ui.separator();
        if ui.press("Later", "Keeps the unsaved sessions; File > Recover sessions lists them again")
        {
            out.send(Action::ShowLeft(false));
        }
    });
    if !open {
        out.send(Action::ShowLeft(false));
    }
}

/// Returns a dialog of fixed size at the upper edge of the window.
fn window(title: impl Into<egui::WidgetText>) -> egui::Window<'static> {
    let window = egui::Window::new(title).anchor(egui::Align2::CENTER_TOP, [0.0, 60.0]);
    window.collapsible(false).resizable(false)
}

fn one_left(ui: &mut egui::Ui, left: &LeftSession, out: &mut Out) {
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
            let reason = format!("This session cannot be read: {reason}");
            ui.warn(reason).on_hover_text(left.path.display().to_string());
        }
    }
    ui.horizontal(|ui| {
        let restore = ui.add_enabled(left.session.is_ok(), egui::Button::new("Restore"));
        let restore = restore
            .on_hover_text(
                "Opens the files of this session with all settings; the other sessions stay listed",
            )
            .on_disabled_hover_text("The stored session cannot be read");
        if restore.clicked() {
            out.send(Action::Restore(left.path.clone()));
        }
        if ui.press("Discard", "Deletes this unsaved session; the recordings stay") {
            out.send(Action::DropLeft(left.path.clone()));
        }
    });
}

/// Returns the names of the first files of a session.
fn files_of(session: &Session) -> String {
    let names = session.files.iter().map(|file| file_name(&file.absolute));
    let built_in = session.built_in.then_some(Cow::Borrowed("built-in simulated sensor"));
    let max = LEFT_FILES + usize::from(session.built_in);
    let names = first(max, built_in.into_iter().chain(names));
    if names.is_empty() { "no files".to_owned() } else { names }
}

/// Asks for the folder to which the session's files were moved.
fn lost(context: &Context, engine: &Engine, out: &mut Out) {
    let lost = &engine.project().lost;
    if lost.is_empty() {
        return;
    }
    let title = match lost.len() {
        1 => "A file of the session was not found".to_owned(),
        n => format!("{n} files of the session were not found"),
    };
    window(title)
        .id(egui::Id::unique("lost"))
        .show(context, |ui| {
            ui.set_width(520.0);
            let list = egui::ScrollArea::vertical().max_height(LIST_HEIGHT);
            list.show(ui, |ui| {
                for (at, file) in lost.iter().enumerate() {
                    ui.horizontal(|ui| {
                        if ui.press_small("×", "Removes this file from the session") {
                            out.send(Action::Forget(at));
                        }
                        let path = file.absolute.display().to_string();
                        ui.label(elided(&path, LOST_CHARS)).on_hover_text(path);
                    });
                }
            });
            ui.separator();
            ui.horizontal(|ui| {
                let about = "Searches the missing files in a folder and in its subfolders, by their names";
                if ui.press("Choose a folder…", about) {
                    out.send(Command::Choose(PathFor::Locate));
                }
                let about = "Searches the missing files at a path. The path of one moved file finds the others, too";
                if ui.press("Type a path…", about) {
                    out.send(Command::TypePath(PathFor::Locate));
                }
                if ui.press("Continue without files", "Opens the session without the missing files") {
                    lost.iter().for_each(|_| out.send(Action::Forget(0)));
                }
            });
        });
}
