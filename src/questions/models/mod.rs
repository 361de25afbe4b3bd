//! Models: search and comparison of candidates, their table, and the training of networks and kernels.

pub mod asked;
pub(crate) mod best;
pub(crate) mod cross_validated;
mod folds;
pub(crate) mod learning;
pub(crate) mod recipes;
mod side;
pub(crate) mod table;
pub(crate) mod training;
