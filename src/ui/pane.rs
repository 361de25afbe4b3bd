//! Interface of a pane: it asks questions, draws answers, and pushes actions. It computes nothing.

use crate::engine::Engine;
use crate::questions::question::Query;
use crate::ui::command::Command;
use crate::ui::time_view::TimeView;

/// Question that is asked of the engine once the panes are drawn.
pub type Asked = Box<dyn FnOnce(&mut Engine)>;

/// Context that a pane is drawn in.
pub struct Cx<'a> {
    /// The document, and the answers to questions about it.
    pub engine: &'a Engine,
    /// Visible interval of time, which all panes share.
    pub time: &'a mut TimeView,
    /// Queue of the user's actions.
    pub out: &'a mut Vec<Command>,
    /// Queue of questions, filled by [`Self::ask`].
    pub asked: &'a mut Vec<Asked>,
}

impl Cx<'_> {
    /// Asks a question, unless it was asked last. A pane that is not on screen asks nothing.
    pub fn ask<Q: Query>(&mut self, question: Q) {
        self.asked.push(Box::new(|engine| engine.ask(question)));
    }
}

/// Contents of a pane with its view state.
pub trait PaneView {
    /// Draws the pane.
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>);
}
