//! Chooses thresholds and the values of feature blocks. A [`Study`] is prepared once, and answers each question from one pass
//! over the samples.
//!
//! Guarantees: suggestions depend on the training recordings alone. Test recordings are only scored.

mod blocks;
mod prepared;
mod thresholds;

pub(crate) use blocks::BlockSuggestion;
pub use blocks::HistoryBlock;
pub use prepared::Study;

#[cfg(test)]
mod tests;
