//! Kernel ridge regression on landmarks, with an uncertainty band: the mean of a Gaussian process (references 20 and 21 of
//! the paper), and the least-squares support vector machine (reference 13).
//!
//! The kernel is `k(x, l) = e^(−|x − l|² / 2ℓ²)` between a sample and m landmarks. Whitened by the kernel matrix of the
//! landmarks (Nyström), it gives m columns of unit prior variance. The rest is ridge regression from sums, with one
//! [`NormalEquations`](crate::calibration::NormalEquations) per fold of the cross-validation. Samples are not stored.
//!
//! Guarantees: no randomness. Far from every landmark the prediction is the mean, and the band is wide.

mod fitting;
mod model;

pub use fitting::{LinearStage, RowBlock, Rows, TakeRows};
pub use model::{GridEdge, Kernel, KernelError, KernelScratch, KernelSettings, LANDMARKS};
