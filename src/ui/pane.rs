//! Interface of a pane. A pane asks the engine questions, draws the answers and sends commands. A pane computes nothing.

use crate::engine::Engine;
use crate::questions::question::Query;
use crate::ui::command::Out;
use crate::ui::time_view::TimeView;

/// Question to the engine, which is asked after all panes are drawn.
pub type Asked = Box<dyn FnOnce(&mut Engine)>;

pub struct Cx<'a> {
    pub engine: &'a Engine,
    /// Interval of time that all panes show.
    pub time: &'a mut TimeView,
    pub out: &'a mut Out,
    /// Queue of questions, filled by [`Self::ask`].
    pub asked: &'a mut Vec<Asked>,
}

impl Cx<'_> {
    /// Asks the engine a question. The engine ignores a question that equals the previous one.
    pub fn ask<Q: Query>(&mut self, question: Q) {
        self.asked.push(Box::new(|engine| engine.ask(question)));
    }
}

pub trait PaneView {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>);
}
