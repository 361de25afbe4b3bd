//! Chooses the memory of a fit: thresholds, and the values of feature blocks.
//!
//! A [`Study`] is prepared once for recordings and settings. It then answers each question from one pass over the samples.
//! Guarantees: suggestions depend on the training recordings alone. Test recordings are only scored.

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
