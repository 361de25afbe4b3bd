//! Cross-validated linear fits: with one ridge for all columns, or with one for each feature block.

mod by_block;
mod fits;
mod lanes;

pub use crate::scoring::left_out::by_block::shares_of_blocks;
pub(crate) use crate::scoring::left_out::fits::summed_by_target;
pub use crate::scoring::left_out::fits::{LeftOut, too_short};
