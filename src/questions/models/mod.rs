//! Models: search and comparison of candidates, their table, and the training of networks and kernels.

pub mod asked;
pub(crate) mod best;
pub(crate) mod recipes;
pub(crate) mod table;
pub(crate) mod training;
