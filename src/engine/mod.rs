//! The program without its window: a document, questions about it, and what is done with files.
//!
//! A [`Project`] is everything that a session saves, an [`Edit`] every change of it and one step of undo. A result is the answer
//! to a [`Query`](crate::questions::question::Query), a pure function of what it carries, found on a [`Lane`](query::Lane) off the window's thread.
//! The [`Engine`] keeps the document, asks what follows from it, and does what takes files; no drawing happens here.

#[expect(clippy::module_inception, reason = "the room's centre bears its name")]
mod engine;
mod files;
mod importing;
#[cfg(all(test, feature = "gui"))]
mod killed_tests;
mod lanes;
mod live;
mod lost;
mod models;
mod notice;
mod preferences;
mod project;
pub(crate) mod query;
mod recovery;
mod saving;
mod session;
mod task;
#[cfg(test)]
mod tests;
mod undo;

pub(crate) use engine::Leaving;
pub use engine::{Action, Engine};
pub(crate) use files::is_calibration;
pub use importing::ImportCommand;
pub(crate) use importing::Importing;
pub use live::{Followed, LiveTraces};
pub use models::{ModelChange, Models, Row, SEARCH_MINUTES};
pub use notice::{Level, Notice};
#[cfg(feature = "gui")]
pub(crate) use preferences::PreferencesFile;
pub use preferences::{Preferences, Theme};
pub(crate) use project::Project;
pub use project::{Edit, Split};
pub(crate) use recovery::LeftSession;
pub use saving::FileContent;
pub(crate) use saving::{Doubt, Existing};
pub(crate) use session::Session;
