//! Models: search and comparison of candidates, their table, and the training of networks and kernels.

pub mod asked;
pub(crate) mod best;
mod folds;
pub(crate) mod recipes;
pub(crate) mod table;
pub(crate) mod training;
