//! The program without its window: a document, questions about it, and what is done with files.
//!
//! A [`Project`] is everything that a session saves, an [`Edit`] every change of it and one step of undo. A result is the answer
//! to a [`Query`](query::Query), a pure function of what it carries, found on a [`Lane`](query::Lane) off the window's thread.
//! The [`Engine`] keeps the document, asks what follows from it, and does what takes files; no drawing happens here.

mod comparison;
#[expect(clippy::module_inception, reason = "the room's centre bears its name")]
mod engine;
mod files;
mod importing;
mod notice;
mod preferences;
mod project;
pub mod query;
mod questions;
mod recovery;
mod saving;
mod session;
mod task;
#[cfg(test)]
mod tests;
mod undo;

pub use comparison::{Comparison, Outcome, Row};
pub use engine::{Action, Engine, Leaving};
pub use files::{Opened, OpenedFile, is_calibration};
pub use importing::{ImportCommand, Importing, KnownOf};
pub use notice::{Level, Notice};
pub use preferences::{Preferences, Theme};
pub use project::{Edit, EditError, FromFile, Project, SessionFile, Split};
pub use questions::{StudyThresholds, ThresholdStudy, Trained};
pub use recovery::LeftSession;
pub use saving::{Doubt, Existing, FileContent, TracesToWrite};
pub use session::{OpenedSession, Session, SessionError, SessionPart};
pub use undo::History;
