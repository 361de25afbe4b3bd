//! The error budget: where the errors of the uncompensated and of the compensated calibration come from, by cause.

pub(crate) mod query;
pub(crate) mod remedies;
pub(crate) mod sentence;
pub(crate) mod shown;

pub(crate) use query::{ErrorBudget, error_budget};
pub(crate) use remedies::{Action, Remedy, remedies};
#[cfg(feature = "gui")]
pub(crate) use shown::Row;
pub(crate) use shown::budget_table;
