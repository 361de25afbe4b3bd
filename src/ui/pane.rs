//! Interface of a pane: it asks questions, draws answers, and pushes actions, but computes nothing.

use crate::engine::Engine;
use crate::questions::question::Query;
use crate::ui::command::Out;
use crate::ui::time_view::TimeView;

/// Question that is asked of the engine once the panes are drawn.
pub type Asked = Box<dyn FnOnce(&mut Engine)>;

pub struct Cx<'a> {
    pub engine: &'a Engine,
    /// Visible interval of time, which all panes share.
    pub time: &'a mut TimeView,
    pub out: &'a mut Out,
    /// Queue of questions, filled by [`Self::ask`].
    pub asked: &'a mut Vec<Asked>,
}

impl Cx<'_> {
    /// Asks a question, unless it was asked last. A pane that is not on screen asks nothing.
    pub fn ask<Q: Query>(&mut self, question: Q) {
        self.asked.push(Box::new(|engine| engine.ask(question)));
    }
}

pub trait PaneView {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>);
}
