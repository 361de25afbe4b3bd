//! Results that are computed from recordings, such as errors, loops, or the best model. Each kind of result has a folder with
//! its numbers, the request (`query.rs`), and its tables and figures (`shown.rs`). Code that several kinds share lies beside
//! the folders.
//!
//! A new kind of result is a folder with one `mod` line here. Its pane is a file with a line in `ui/mod.rs` and in
//! `ui/panes.rs`, and its batch job is a file with two lines in `cli.rs`. The engine, which computes requests in the
//! background, needs no change.

pub(crate) mod budget;
pub(crate) mod channels;
pub mod check;
mod dataset;
pub(crate) mod error;
pub(crate) mod errors;
pub(crate) mod expected_error;
pub(crate) mod history;
pub mod loops;
pub mod metrology;
pub(crate) mod models;
pub mod page;
pub(crate) mod question;
pub(crate) mod request;
pub mod thresholds;

pub use check::query::sufficiency;
pub use dataset::Datasets;
pub use error::AnalysisError;
pub(crate) use errors::factory::read_factory;
pub use errors::findings::findings;
pub use errors::intervals::OnScreen;
pub(crate) use errors::intervals::intervals_within;
pub(crate) use errors::query::RecordingResult;
pub use errors::query::{Analysis, Analyst, analyse};
pub(crate) use errors::trace_values::Segment;
pub(crate) use errors::traces::{AxisTraces, TraceSet};
pub use expected_error::query::expected_error;
pub(crate) use expected_error::query::{handed_over, training};
pub(crate) use models::best::Best;
pub use models::best::{Search, WITHIN, find_best};
pub use models::recipes::Candidates;
pub(crate) use models::table::{Mark, Model, ModelRow, RELATIVE, model_table};
pub use models::training::train;
pub(crate) use models::training::{TrainingStep, cross_validation_cost};
pub use page::report;
pub(crate) use page::{check_limits, settings_table};
pub use request::{Request, View};
pub(crate) use thresholds::study::BlockSuggestion;
pub use thresholds::study::{HistoryBlock, Study};

#[cfg(test)]
mod missing_tests;
