//! The state of the program and how it changes: no drawing, no files, no threads.
//!
//! Panels read [`AppState`] and push [`Command`]s; [`AppState::apply`] changes the state and says what else must happen
//! as [`Effect`]s, which the window carries out.

mod command;
mod comparison;
mod notice;
mod state;
mod study;
mod training;

pub use command::{Command, Effect, FileContent, Opened, OpenedFile};
pub use comparison::{Comparison, ComparisonCommand, Row};
pub use notice::{Level, Notice};
pub use state::{AppState, Applied, Pane};
pub use study::{StudyCommand, StudyNews, StudyRequest, ThresholdStudy};
pub use training::{Training, TrainingCommand};
