//! What only the window can do.

use crate::app::{Command, Level, Notice, Preferences, SessionCommand, Wish};
use crate::recording::Tare;
use crate::ui::picture::screen_part;
use crate::ui::shell::Shell;
use crate::ui::workspace::Workspace;

/// One step of the text's size.
const TEXT_STEP: f32 = 0.1;

impl Shell {
    pub(super) fn fulfil(&mut self, wish: Wish, ui: &egui::Ui) {
        match wish {
            Wish::ShowPane(pane) => self.workspace.bring(pane),
            Wish::ClosePane(pane) => self.workspace.close(pane),
            Wish::MovePane(pane, to) => self.workspace.move_pane(pane, to),
            Wish::Arrange(preset) => self.workspace = Workspace::preset(preset),
            Wish::Undo => {
                let before = self.state.history.undo();
                self.commands.extend(before.map(Command::Restore));
            }
            Wish::Redo => {
                let after = self.state.history.redo();
                self.commands.extend(after.map(Command::Restore));
            }
            Wish::ShowPalette => self.palette.open(),
            Wish::ToggleHelp => self.help.toggle(),
            Wish::Tour(true) => self.tour.begin(),
            Wish::Tour(false) => {
                self.tour.end();
                self.state.preferences.toured = true;
            }
            Wish::FitView => self.panes.fit(),
            Wish::ZoomBack => self.panes.go_back(),
            Wish::ZoomForward => self.panes.go_forward(),
            Wish::ZoomTime(factor) => self.panes.zoom_time(factor),
            Wish::MoveTime(share) => self.panes.move_time(share),
            Wish::TogglePlay => self.panes.toggle_play(),
            Wish::Step(samples) => self.panes.step(samples),
            Wish::PutCursor(which) => self.panes.put_cursor(which),
            Wish::PictureOfAll(to) => {
                let part = screen_part(ui.ctx().content_rect());
                self.pictures.ask(part, to);
            }
            Wish::TextScale(step) => {
                let preferences = &mut self.state.preferences;
                let (least, most) = (
                    *Preferences::TEXT_SCALES.start(),
                    *Preferences::TEXT_SCALES.end(),
                );
                preferences.text_scale = match step {
                    0 => 1.0,
                    _ => (preferences.text_scale + f32::from(step) * TEXT_STEP).clamp(least, most),
                };
            }
            Wish::Picture(part, to) => self.pictures.ask(part, to),
            Wish::TareBetweenCursors(at) => {
                let traces = self
                    .state
                    .analysis
                    .as_ref()
                    .map(|analysis| &analysis.traces);
                let span = traces.and_then(|traces| self.panes.span_in(at, traces));
                self.commands.push_back(match span {
                    Some((from, to)) => Command::Tare(vec![at], Tare::Stretch(from, to)),
                    None => Command::Tell(Notice::new(
                        Level::Error,
                        "Put this recording on screen, then cursor A by a click in a trace and cursor B by Shift and a click",
                    )),
                });
            }
            Wish::SaveTraces => {
                let visible = self.panes.visible_time();
                self.commands.push_back(Command::ChooseTraces(visible));
            }
            Wish::SaveSession(path) => {
                let layout = Some(self.workspace.to_value());
                let command = SessionCommand::SaveTo(path, layout);
                self.commands.push_back(Command::Session(command));
            }
            Wish::Layout(value) => {
                if let Some(workspace) = Workspace::from_value(&value) {
                    self.workspace = workspace;
                }
            }
            Wish::CloseNow => {
                self.closing = true;
                ui.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
    }
}
