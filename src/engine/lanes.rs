//! All background requests about the document with their results: one [`Lane`] (worker thread with its newest request and
//! result) for each type of request, and for each pane that asks requests of this type. A lane is made at its first request, so
//! that a new type of request needs no line here.

use std::any::Any;

use crate::{
    engine::query::{Background, Lane, Notify, Running},
    questions::question::Query,
};

/// Name of the pane that asks. Answers to different askers do not replace each other. Most types of requests have only one
/// asker, [`ANYONE`].
pub type Asker = &'static str;

pub const ANYONE: Asker = "";

/// Request for a result that waits until the engine takes it, such as a request of a pane.
pub struct Asked(Box<dyn FnOnce(&mut Lanes)>);

impl Asked {
    pub fn of<Q: Query + PartialEq>(asker: Asker, question: Q) -> Self {
        Self(Box::new(move |lanes| lanes.of_mut(asker).ask(question)))
    }
}

#[derive(Default)]
pub struct Lanes {
    notify: Option<Notify>,
    all: Vec<(Asker, Box<dyn Background>)>,
}

impl Lanes {
    pub fn new(notify: Notify) -> Self {
        Self { notify: Some(notify), all: Vec::new() }
    }

    pub fn of<Q: Query>(&self, asker: Asker) -> &Lane<Q> {
        let mut lanes = self.all.iter().filter(|(of, _)| *of == asker);
        let found = lanes.find_map(|(_, lane)| (&**lane as &dyn Any).downcast_ref());
        found.unwrap_or(Lane::EMPTY)
    }

    pub fn of_mut<Q: Query>(&mut self, asker: Asker) -> &mut Lane<Q> {
        let is_meant = |(of, lane): &(Asker, Box<dyn Background>)| {
            *of == asker && (&**lane as &dyn Any).is::<Lane<Q>>()
        };
        let at = self.all.iter().position(is_meant).unwrap_or_else(|| {
            self.all.push((asker, Box::new(Lane::<Q>::new(self.notify.clone()))));
            self.all.len() - 1
        });
        let lane = (&mut *self.all[at].1 as &mut dyn Any).downcast_mut();
        lane.expect("this is the place of the lane")
    }

    fn lanes(&self) -> impl Iterator<Item = &dyn Background> {
        self.all.iter().map(|(_, lane)| &**lane)
    }

    pub fn ask(&mut self, asked: Asked) {
        (asked.0)(self);
    }

    /// Takes the finished results of all worker threads. Returns a message for each failed work that the user had started.
    pub fn take(&mut self) -> Vec<String> {
        self.all.iter_mut().filter_map(|(_, lane)| lane.take_failure()).collect()
    }

    pub fn are_idle(&self) -> bool {
        self.lanes().all(|lane| lane.is_idle())
    }

    pub fn cancel(&self) {
        self.lanes().for_each(|lane| lane.cancel());
    }

    /// Returns the running work that the user has started.
    pub fn running(&self) -> impl Iterator<Item = Running> {
        let begun = self.lanes().filter(|lane| lane.is_begun_by_user());
        begun.filter_map(|lane| lane.running())
    }

    /// Removes the requests and results of the lanes that `is_meant` selects.
    pub fn forget(&mut self, is_meant: fn(&dyn Background) -> bool) {
        let meant = self.all.iter_mut().filter(|(_, lane)| is_meant(&**lane));
        meant.for_each(|(_, lane)| lane.forget());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::questions::question::{Answered, Work};

    #[derive(Clone, PartialEq)]
    struct Doubled(u32);

    impl Query for Doubled {
        type Answer = u32;
        type Cache = ();

        fn title(&self) -> String {
            "a test".to_owned()
        }

        fn compute(&self, _work: Work<'_, Self>) -> Answered<Self> {
            Ok(2 * self.0)
        }
    }

    #[test]
    fn answers_to_different_askers_do_not_replace_each_other() {
        let mut lanes = Lanes::default();
        for (asker, number) in [(ANYONE, 1), ("loops", 2), ("metrology", 3)] {
            lanes.of_mut(asker).ask(Doubled(number));
        }
        while !lanes.are_idle() {
            std::thread::yield_now();
        }
        lanes.take();
        let answers = [ANYONE, "loops", "metrology", "nobody"];
        let answers = answers.map(|asker| lanes.of::<Doubled>(asker).answer().copied());
        assert_eq!(answers, [Some(2), Some(4), Some(6), None]);
    }
}
