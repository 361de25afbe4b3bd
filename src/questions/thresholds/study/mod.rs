//! Chooses the memory of a fit: thresholds, and the values of feature blocks. A [`Study`] is prepared once; it answers each
//! question from one pass over the samples. Guarantees: suggestions depend on the training recordings alone, and test
//! recordings are only scored.

mod blocks;
mod parts;
mod prepared;
mod thresholds;

pub(crate) use blocks::BlockSuggestion;
pub use blocks::HistoryBlock;
pub use prepared::Study;
pub(crate) use thresholds::StudyEvent;

#[cfg(test)]
mod tests;
