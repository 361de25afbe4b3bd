//! Interface of a pane. A pane requests results from the engine, draws the results and sends commands. The pane itself
//! computes nothing.

use crate::{
    engine::{ANYONE, Asked, Asker, Engine},
    questions::question::Query,
    ui::{command::Out, scope::Scope, time_view::TimeView},
};

pub struct Cx<'a> {
    pub engine: &'a Engine,
    /// Interval of time that all panes show.
    pub time: &'a mut TimeView,
    /// Axes and samples whose errors all panes show.
    pub scope: &'a mut Scope,
    /// True in presenter mode, in which panes draw their plots without controls.
    pub presents: bool,
    pub out: &'a mut Out,
    /// Requests for results, which are sent to the engine after all panes are drawn. [`Self::ask`] adds a request.
    pub asked: &'a mut Vec<Asked>,
}

impl Cx<'_> {
    /// Requests a result from the engine. The engine ignores a request that equals the previous one.
    pub fn ask<Q: Query + PartialEq>(&mut self, question: Q) {
        self.ask_as(ANYONE, question);
    }

    /// Requests a result as a pane whose requests of this type do not replace those of other panes.
    pub fn ask_as<Q: Query + PartialEq>(&mut self, asker: Asker, question: Q) {
        self.asked.push(Asked::of(asker, question));
    }
}

pub trait PaneView {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>);
}
