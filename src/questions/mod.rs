//! Questions about recordings. Each has a folder with its numbers, the question (`query.rs`), and its tables and figures
//! (`shown.rs`). Code that several questions share lies beside the folders.

mod auxiliary_inputs;
pub mod check;
mod cross_validated;
mod dataset;
pub(crate) mod error;
pub mod errors;
pub mod expected_error;
pub mod history;
mod left_out_fits;
pub mod loops;
pub mod metrology;
pub mod models;
pub mod page;
pub mod question;
pub(crate) mod request;
pub mod thresholds;
mod travels;

pub use check::cautions::findings;
pub use check::query::{HangingMass, sufficiency};
pub(crate) use cross_validated::cross_validation_cost;
pub use dataset::Datasets;
pub use error::AnalysisError;
pub(crate) use errors::factory::read_factory;
pub use errors::intervals::OnScreen;
pub(crate) use errors::intervals::intervals_within;
pub use errors::query::{Analysis, Analyst, RecordingResult, analyse};
pub(crate) use errors::trace_values::Segment;
pub(crate) use errors::traces::{AxisTraces, TraceSet};
pub use errors::view::View;
pub use expected_error::query::{expected_error, handed_over};
pub use models::best::{Best, Search, Tried, WITHIN, find_best};
pub(crate) use models::comparison::{Candidate, paper_candidates};
pub use models::comparison::{Comparison, compare};
pub use models::learning::TrainingStep;
pub use models::table::{Cost, Mark, Model, ModelRow, RELATIVE, model_table};
pub use models::training::{Scored, train, train_and_score};
pub use page::{check_limits, report};
pub use request::Request;
pub(crate) use thresholds::study::{BlockSuggestion, StudyEvent};
pub use thresholds::study::{HistoryBlock, Study};
