//! The expected error of a calibration: for each axis, the value within which 95 % of the errors on further recordings of the
//! same kind should lie.
//!
//! Held-out errors are those of groups of training recordings, each predicted by a fit to the other groups, and those of test
//! recordings. If there are both, the larger of the two values is the expected error. The value of the cross-validation is
//! wider than 95 % of its errors as far as few groups say little.
//!
//! Guarantees: with fewer than [`MIN_GROUPS`](rule::MIN_GROUPS) groups, or a table of fewer than
//! [`MIN_CASES`](rule::MIN_CASES) load cases, a reason takes the place of the value. Each value
//! comes with the range of loads and the numbers of groups and samples that it is based on, and with a list of conditions
//! that the recordings do not cover.

pub(crate) mod limits;
pub mod query;
pub(crate) mod rule;
pub(crate) mod shown;

pub(crate) use shown::{expected_error_table, limits_table};
