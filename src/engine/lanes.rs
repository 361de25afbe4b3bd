//! All background requests about the document with their results: one [`Lane`] (worker thread with its newest request and
//! result) for each type. A lane is made at the first request of its type, so that a new type of request needs no line here.

use std::any::Any;

use crate::engine::query::{Background, Lane, Notify, Running};
use crate::questions::question::Query;

#[derive(Default)]
pub struct Lanes {
    pub notify: Option<Notify>,
    all: Vec<Box<dyn Background>>,
}

impl Lanes {
    pub fn new(notify: Notify) -> Self {
        Self { notify: Some(notify), all: Vec::new() }
    }

    pub fn of<Q: Query>(&self) -> &Lane<Q> {
        let own = self.all.iter().find_map(|lane| (&**lane as &dyn Any).downcast_ref());
        own.unwrap_or(Lane::EMPTY)
    }

    pub fn of_mut<Q: Query>(&mut self) -> &mut Lane<Q> {
        let own = self.all.iter().position(|lane| (&**lane as &dyn Any).is::<Lane<Q>>());
        let at = own.unwrap_or_else(|| {
            self.all.push(Box::new(Lane::<Q>::new(self.notify.clone())));
            self.all.len() - 1
        });
        let own = (&mut *self.all[at] as &mut dyn Any).downcast_mut();
        own.expect("this is the place of the lane")
    }

    /// Takes the finished results of all worker threads. Returns a message for each failed work that the user had started.
    pub fn take(&mut self) -> Vec<String> {
        self.all.iter_mut().filter_map(|lane| lane.take_failure()).collect()
    }

    pub fn are_idle(&self) -> bool {
        self.all.iter().all(|lane| lane.is_idle())
    }

    pub fn cancel(&self) {
        self.all.iter().for_each(|lane| lane.cancel());
    }

    /// Returns the running work that the user has started.
    pub fn running(&self) -> impl Iterator<Item = Running> {
        let begun = self.all.iter().filter(|lane| lane.is_begun_by_user());
        begun.filter_map(|lane| lane.running())
    }

    /// Removes the requests and results of the lanes that `is_meant` selects.
    pub fn forget(&mut self, is_meant: fn(&dyn Background) -> bool) {
        let meant = self.all.iter_mut().filter(|lane| is_meant(&***lane));
        meant.for_each(|lane| lane.forget());
    }
}
