//! Kernel ridge regression on landmarks: the mean of a Gaussian process (references 20 and 21 of the paper), which is
//! also the least-squares support vector machine (reference 13), with its band.
//!
//! `k(x, l) = e^(−|x − l|² / 2ℓ²)` between a sample and m landmarks becomes, whitened by the landmarks' own kernel matrix
//! (Nyström), m columns of unit prior variance. From there on it is ridge regression from sums, one
//! [`NormalEquations`](crate::calibration::NormalEquations) for each part that cross-validation leaves out: samples are passed over, never stored.
//!
//! Guarantees: no randomness; far from every landmark the answer falls back to the mean, and the band says so.

mod fitting;
mod model;

pub use fitting::{KernelFit, LinearStage, RowBlock, Rows, TakeRows};
pub use model::{Band, GridEdge, Kernel, KernelError, KernelScratch, KernelSettings, LANDMARKS};
