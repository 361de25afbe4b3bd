//! The program without its window: the document, the results computed from the document, and work with files.
//!
//! A [`Project`](project::Project) is everything that a session saves. An [`Edit`] is one change of it and one step of undo. A
//! result is the answer to a background request ([`Query`](crate::questions::question::Query)). It is computed on the thread of a
//! [`Lane`](query::Lane), so that the window never waits. The [`Engine`] keeps the document, requests the results, and reads
//! and writes files.

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
mod tasks;
#[cfg(test)]
mod tests;
mod undo;

pub(crate) use engine::Leaving;
pub use engine::{Action, Engine};
pub(crate) use files::is_calibration;
pub use importing::ImportCommand;
pub(crate) use importing::Importing;
pub(crate) use lanes::{ANYONE, Asked, Asker};
pub(crate) use live::{Followed, LiveTraces};
pub use models::Models;
pub(crate) use models::{Row, SEARCH_MINUTES};
pub use notice::{Level, Notice};
#[cfg(feature = "gui")]
pub(crate) use preferences::PreferencesFile;
pub use preferences::{Preferences, Theme};
pub use project::{Edit, Split};
pub(crate) use recovery::LeftSession;
pub use saving::FileContent;
pub(crate) use saving::{Doubt, Existing};
pub(crate) use session::Session;
