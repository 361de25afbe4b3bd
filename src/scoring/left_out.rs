//! Cross-validation of linear fits: with one ridge for all columns, or with one ridge for each block of feature columns.

mod fits;
mod lanes;

pub(crate) use fits::summed_by_target;
pub use fits::{LeftOut, shares_of_blocks, too_short};
