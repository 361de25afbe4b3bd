//! List of the questions about the document, each with its lane. A new question is one more line.

use std::any::Any;

use crate::engine::query::{Background, Lane, LaneEvent, Notify, Running};
use crate::questions::check::cold_start::AskColdStart;
use crate::questions::check::faulty::FindFaults;
use crate::questions::check::query::CheckData;
use crate::questions::errors::asked::Analyse;
use crate::questions::expected_error::asked::AskExpectedError;
use crate::questions::history::AskHistory;
use crate::questions::loops::asked::{AskFigures, AskLoops, AskPredicted, AskResidual, AskVerdict};
use crate::questions::models::asked::{Train, TryModels};
use crate::questions::question::Query;
use crate::questions::thresholds::asked::{ChooseBlock, StudyThresholds};

pub struct Lanes(Vec<Box<dyn Background>>);

impl Lanes {
    pub fn new(notify: &Notify) -> Self {
        Self(vec![
            Box::new(Lane::<Analyse>::new(notify)),
            Box::new(Lane::<FindFaults>::new(notify)),
            Box::new(Lane::<AskLoops>::new(notify)),
            Box::new(Lane::<AskFigures>::new(notify)),
            Box::new(Lane::<AskVerdict>::new(notify)),
            Box::new(Lane::<AskPredicted>::new(notify)),
            Box::new(Lane::<AskResidual>::new(notify)),
            Box::new(Lane::<StudyThresholds>::new(notify)),
            Box::new(Lane::<CheckData>::new(notify)),
            Box::new(Lane::<AskExpectedError>::new(notify)),
            Box::new(Lane::<AskHistory>::new(notify)),
            Box::new(Lane::<AskColdStart>::new(notify)),
            Box::new(Lane::<ChooseBlock>::new(notify)),
            Box::new(Lane::<Train>::new(notify)),
            Box::new(Lane::<TryModels>::new(notify)),
        ])
    }

    /// Returns the lane of a kind of question.
    ///
    /// # Panics
    /// If the list has no lane for this question.
    pub fn of<Q: Query>(&self) -> &Lane<Q> {
        let own = self.0.iter().find_map(|lane| (&**lane as &dyn Any).downcast_ref());
        own.expect("each question has a line in the list of lanes")
    }

    /// Returns the lane for asking questions; panics as [`Self::of`].
    pub fn of_mut<Q: Query>(&mut self) -> &mut Lane<Q> {
        let own = self.0.iter_mut().find_map(|lane| (&mut **lane as &mut dyn Any).downcast_mut());
        own.expect("each question has a line in the list of lanes")
    }

    /// Takes the answers of all lanes, and returns the failures of work that the user started.
    pub fn take(&mut self) -> Vec<String> {
        let taken = self.0.iter_mut().filter_map(|lane| {
            let failed = lane.take_events().contains(&LaneEvent::Problem);
            let (begins, problem) = (lane.begun_by_user()?, lane.problem()?);
            failed.then(|| format!("{begins}{problem}"))
        });
        taken.collect()
    }

    /// Returns true if nothing runs or waits.
    pub fn are_idle(&self) -> bool {
        self.0.iter().all(|lane| lane.is_idle())
    }

    pub fn cancel(&self) {
        self.0.iter().for_each(|lane| lane.cancel());
    }

    /// Returns running work that the user started.
    pub fn running(&self) -> impl Iterator<Item = Running> {
        let begun = self.0.iter().filter(|lane| lane.begun_by_user().is_some());
        begun.filter_map(|lane| lane.running())
    }

    /// Forgets the questions of panes when there are no recordings. Work that the user started continues.
    pub fn forget_shown(&mut self) {
        let asked = self.0.iter_mut().filter(|lane| lane.begun_by_user().is_none());
        asked.for_each(|lane| lane.forget());
    }
}
