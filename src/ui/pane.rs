//! What a pane is: it asks questions, draws answers, and pushes what somebody asks for. It computes nothing.

use crate::engine::Engine;
use crate::ui::command::Command;
use crate::ui::time_view::TimeView;

/// What a pane is drawn from.
pub struct Cx<'a> {
    /// The document, and the answers to questions about it.
    pub engine: &'a mut Engine,
    /// The part of time on screen, which all panes share.
    pub time: &'a mut TimeView,
    /// Where it pushes what somebody asks for.
    pub out: &'a mut Vec<Command>,
}

/// What is in a pane, with what it remembers between frames.
pub trait PaneView {
    /// Draws it.
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>);
}
