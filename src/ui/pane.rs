//! What a pane is: it asks questions, draws answers, and pushes what somebody asks for. It computes nothing.

use crate::engine::Engine;
use crate::questions::question::Query;
use crate::ui::command::Command;
use crate::ui::time_view::TimeView;

/// A question that is asked of the engine once the panes are drawn.
pub type Asked = Box<dyn FnOnce(&mut Engine)>;

/// What a pane is drawn from.
pub struct Cx<'a> {
    /// The document, and the answers to questions about it.
    pub engine: &'a Engine,
    /// The part of time on screen, which all panes share.
    pub time: &'a mut TimeView,
    /// Where it pushes what somebody asks for.
    pub out: &'a mut Vec<Command>,
    /// Where [`Self::ask`] puts questions.
    pub asked: &'a mut Vec<Asked>,
}

impl Cx<'_> {
    /// Asks a question, unless it was asked last; a pane that is not on screen asks nothing.
    pub fn ask<Q: Query>(&mut self, question: Q) {
        self.asked.push(Box::new(|engine| engine.ask(question)));
    }
}

/// What is in a pane, with what it remembers between frames.
pub trait PaneView {
    /// Draws it.
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>);
}
