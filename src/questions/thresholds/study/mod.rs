//! Choosing what a fit remembers: thresholds, and the values of blocks.
//!
//! A [`Study`] is prepared once for recordings and settings; then it answers each question from one pass over the samples.
//! Guarantees: what it suggests rests on the training recordings alone; recordings in the test role are only scored.

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
