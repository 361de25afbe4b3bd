//! Chooses the thresholds of a look-back, and the values of other feature blocks. A [`Study`] is prepared once, and then
//! answers each request with one pass over the samples.
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
