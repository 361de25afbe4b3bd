//! The window: menus above, the status line below, the panes between, and what floats over them.

use crate::app::{AppState, Command, Doubt, Leaving, LeftSession, Pane, SessionCommand, Wish};
use crate::export::utc;
use crate::ui::fields::Fields;
use crate::ui::shell::Shell;
use crate::ui::trace_panes::trace_panes;
use crate::ui::{
    actions, calibration_pane, compare_pane, errors_pane, import_window, menu, notices_panel,
    recordings_panel, settings_panel, status_line, thresholds_pane,
};

/// Height of the list of sessions that windows left.
const LEFT_HEIGHT: f32 = 320.0;
/// So many files of each are named.
const LEFT_FILES: usize = 4;

impl Shell {
    pub(super) fn draw(&mut self, ui: &mut egui::Ui, out: &mut Vec<Command>) {
        let can = self.can_go();
        let state = &self.state;
        actions::listen(ui.ctx(), state, can, out);
        egui::Panel::top("menu").show(ui, |ui| {
            menu::menu_bar(ui, state, &self.workspace, can, out);
        });
        egui::Panel::bottom("status").show(ui, |ui| {
            let jobs = self.jobs.running();
            status_line::status_line(ui, state, jobs, self.analysis.running(), out);
        });
        if !state.notices.is_empty() {
            egui::Panel::bottom("notices")
                .resizable(true)
                .default_size(90.0)
                .show(ui, |ui| notices_panel::notices_panel(ui, state, out));
        }
        let ground = egui::Frame::NONE.fill(ui.visuals().panel_fill);
        egui::CentralPanel::default().frame(ground).show(ui, |ui| {
            self.workspace.show(ui, &mut |ui, pane| match pane {
                Pane::Recordings => {
                    recordings_panel::recordings_panel(ui, state, &mut self.fields, out);
                }
                Pane::Settings => {
                    egui::ScrollArea::vertical()
                        .auto_shrink([false, false])
                        .show(ui, |ui| settings_panel::settings_panel(ui, state, out));
                }
                Pane::Traces => trace_panes(ui, state, &mut self.panes, out),
                Pane::Thresholds => {
                    let (fields, map) = (&mut self.fields, &mut self.map);
                    thresholds_pane::thresholds_pane(ui, state, fields, map, out);
                }
                Pane::Compare => compare_pane::compare_pane(ui, state, &mut self.fields, out),
                Pane::Loops => self.loops.show(ui, state, &self.looking[0], out),
                Pane::Metrology => self.metrology.show(ui, state, &self.looking[1], out),
                Pane::Notes => notes(ui, state, out),
                Pane::Errors => errors_pane::errors_pane(ui, state),
                Pane::Calibration => {
                    calibration_pane::calibration_pane(ui, state, &mut self.fields, out);
                }
            });
        });
        import_window::import_window(ui.ctx(), state, &mut self.import_fields, out);
        self.help.show(ui.ctx(), &|| actions::all(state, can));
        self.palette.show(ui.ctx(), state, can, out);
        if self.tour.show(ui.ctx()) {
            out.push(Command::Wish(Wish::Tour(false)));
        }
        naming(ui.ctx(), state, &mut self.fields, out);
        replacing(ui.ctx(), state, out);
        leaving(ui.ctx(), state, out);
        recovering(ui.ctx(), state, out);
        lost(ui.ctx(), state, &mut self.fields, out);
    }
}

/// Asks before a file is written that is there already, or that holds a fit which says nothing.
fn replacing(context: &egui::Context, state: &AppState, out: &mut Vec<Command>) {
    let Some((_, path, doubt)) = &state.replacing else {
        return;
    };
    let (title, reason, yes) = match doubt {
        Doubt::IsThere => (
            "The file is there already",
            None,
            ("Replace it", "What is in the file now is lost"),
        ),
        Doubt::Undetermined(undetermined, _) => (
            "The samples do not determine this calibration",
            Some(undetermined.to_string()),
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
                if ui.button(label).on_hover_text(explanation).clicked() {
                    out.push(Command::Replace(answer));
                }
            }
        });
    });
    if modal.should_close() {
        out.push(Command::Replace(false));
    }
}

/// Lets a path be typed where there is no dialog to choose one.
fn naming(context: &egui::Context, state: &AppState, fields: &mut Fields, out: &mut Vec<Command>) {
    let Some((_, name)) = &state.naming else {
        fields.name = None;
        return;
    };
    let is_new = fields.name.is_none();
    let path = fields.name.get_or_insert_with(|| name.clone());
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
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let chosen = path.trim();
            let save = ui
                .button("Save it")
                .on_hover_text("Writes this file; Enter does too");
            if (save.clicked() || entered) && !chosen.is_empty() {
                out.push(Command::PathTyped(Some(chosen.into())));
            }
            let leave = ui.button("Never mind").on_hover_text("Nothing is written");
            if leave.clicked() {
                out.push(Command::PathTyped(None));
            }
        });
    });
    if modal.should_close() {
        out.push(Command::PathTyped(None));
    }
}

/// Asks what becomes of what is not saved before the window closes or something else takes its place.
fn leaving(context: &egui::Context, state: &AppState, out: &mut Vec<Command>) {
    let Some(leaving) = &state.leaving else {
        return;
    };
    // It is just being saved.
    if state.naming.is_some() || state.replacing.is_some() {
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
    let mut say = |command| out.push(Command::Session(command));
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
                ("Save", save, SessionCommand::Save),
                ("Discard", discard, SessionCommand::Discard),
                ("Cancel", cancel, SessionCommand::Cancel),
            ] {
                if ui.button(label).on_hover_text(explanation).clicked() {
                    say(command);
                }
            }
        });
    });
    if modal.should_close() {
        say(SessionCommand::Cancel);
    }
}

/// Offers what windows left that did not close as they should, the newest first.
fn recovering(context: &egui::Context, state: &AppState, out: &mut Vec<Command>) {
    if state.recoverable.is_empty() {
        return;
    }
    let mut say = |command| out.push(Command::Session(command));
    let mut open = true;
    egui::Window::new("Recover")
        .open(&mut open)
        .anchor(egui::Align2::CENTER_TOP, [0.0, 60.0])
        .collapsible(false)
        .resizable(false)
        .show(context, |ui| {
            ui.set_width(460.0);
            ui.label("LoopScope did not close as it should. What was not saved then was written down; closing this keeps it for the next start.");
            egui::ScrollArea::vertical().max_height(LEFT_HEIGHT).show(ui, |ui| {
                for (at, left) in state.recoverable.iter().enumerate().rev() {
                    ui.separator();
                    ui.push_id(at, |ui| one_left(ui, left, &mut say));
                }
            });
        });
    if !open {
        say(SessionCommand::KeepLeft);
    }
}

/// When it was written, its files, and what can be done with it.
fn one_left(ui: &mut egui::Ui, left: &LeftSession, say: &mut impl FnMut(SessionCommand)) {
    ui.strong(utc(left.written));
    let names = left.files.iter().take(LEFT_FILES).map(|path| {
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    });
    let mut files = names.collect::<Vec<_>>().join(", ");
    match left.files.len() {
        0 => files.push_str("no files"),
        n if n > LEFT_FILES => files.push_str(&format!(" and {} more", n - LEFT_FILES)),
        _ => {}
    }
    let paths = left.files.iter().map(|path| path.display().to_string());
    ui.label(files)
        .on_hover_text(paths.collect::<Vec<_>>().join("\n"));
    ui.horizontal(|ui| {
        let restore = ui.button("Restore");
        let restore = restore.on_hover_text("Opens its files with every choice of then");
        if restore.clicked() {
            say(SessionCommand::Restore(left.path.clone()));
        }
        let discard = ui.button("Discard");
        let discard = discard.on_hover_text("It is lost; the recordings stay");
        if discard.clicked() {
            say(SessionCommand::DropLeft(left.path.clone()));
        }
    });
}

/// Asks where files of the session are that are not where they were.
fn lost(context: &egui::Context, state: &AppState, fields: &mut Fields, out: &mut Vec<Command>) {
    let Some(file) = state.lost.first() else {
        return;
    };
    egui::Window::new("A file of the session is not there")
        .anchor(egui::Align2::CENTER_TOP, [0.0, 60.0])
        .collapsible(false)
        .resizable(false)
        .show(context, |ui| {
            ui.set_width(460.0);
            ui.label(file.absolute.display().to_string());
            if state.lost.len() > 1 {
                ui.weak(format!("and {} more", state.lost.len() - 1));
            }
            ui.horizontal(|ui| {
                let label = ui.label("It is now at");
                let field = egui::TextEdit::singleline(&mut fields.found).desired_width(340.0);
                ui.add(field)
                    .labelled_by(label.id)
                    .on_hover_text("The path of the file that was moved");
            });
            ui.horizontal(|ui| {
                let path = fields.found.trim().to_owned();
                let read = ui.button("Read it there");
                let read = read.on_hover_text("Takes the file from this path");
                if read.clicked() && !path.is_empty() {
                    fields.found.clear();
                    out.push(Command::Session(SessionCommand::Found(0, path.into())));
                }
                let leave = ui.button("Go on without it");
                let leave = leave.on_hover_text("The session is opened without this file");
                if leave.clicked() {
                    out.push(Command::Session(SessionCommand::Forget(0)));
                }
            });
        });
}

/// Free text.
fn notes(ui: &mut egui::Ui, state: &AppState, out: &mut Vec<Command>) {
    let mut text = state.notes.clone();
    let field = egui::TextEdit::multiline(&mut text)
        .hint_text("What should be remembered of this calibration; it is saved with the session")
        .desired_width(f32::INFINITY);
    let response = ui.add_sized(ui.available_size(), field);
    let response = response.on_hover_text("Free text, saved with the session");
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::MultilineTextInput, true, "Notes"));
    if text != state.notes {
        out.push(Command::Session(SessionCommand::SetNotes(text)));
    }
}
