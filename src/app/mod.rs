//! The state of the program and how it changes: no drawing, no files, no threads.
//!
//! Panels read [`AppState`] and push [`Command`]s; [`AppState::apply`] changes the state and says what else must happen
//! as [`Effect`]s, which the window carries out.

mod choices;
mod command;
mod comparison;
mod file_content;
mod importing;
mod notice;
mod pane;
mod preferences;
mod reference;
mod session;
mod state;
mod study;
mod training;
mod wish;

pub use choices::{Choices, History};
pub use command::{Command, Effect, Opened, OpenedFile};
pub use comparison::{Comparison, ComparisonCommand, Row};
pub use file_content::{Doubt, Existing, FileContent, TracesToWrite};
pub use importing::{ImportCommand, Importing, KnownOf};
pub use notice::{Level, Notice};
pub use pane::Pane;
pub use preferences::{Preferences, Theme};
pub use reference::FactoryCalibration;
pub use session::{
    Leaving, LeftSession, Mark, OpenedSession, Session, SessionCommand, SessionError, SessionFile,
    SessionPart,
};
pub use state::{AppState, Applied};
pub use study::{StudyCommand, StudyNews, StudyRequest, ThresholdStudy};
pub use training::{Training, TrainingCommand};
pub use wish::{PaneMove, PictureTo, Preset, ScreenPart, Wish};
