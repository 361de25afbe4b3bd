//! Cross-validation of linear fits: with one ridge for all columns, or with one ridge for each block of feature columns.

mod by_block;
mod fits;
mod lanes;

pub use crate::scoring::left_out::by_block::shares_of_blocks;
pub(crate) use crate::scoring::left_out::fits::summed_by_target;
pub use crate::scoring::left_out::fits::{LeftOut, too_short};
