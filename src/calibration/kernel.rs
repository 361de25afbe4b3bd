//! Kernel ridge regression on landmark samples, with an uncertainty band. The prediction is the mean of a Gaussian process
//! (references 20 and 21 of the paper of Koike et al., 2019). It is also that of a least-squares support vector machine
//! (reference 13).
//!
//! The kernel between a sample x and each of m landmarks l is `k(x, l) = e^(−|x − l|² / 2ℓ²)`. Whitened by the kernel matrix
//! of the landmarks (Nyström), these m numbers have unit prior variance. A ridge regression on them is solved from
//! [`NormalEquations`](crate::calibration::NormalEquations), with separate sums for each part of the cross-validation.
//!
//! Guarantees: the result does not depend on random numbers. Far from every landmark, the prediction is the mean load, and
//! the band is wide.

mod fitting;
mod model;

pub use fitting::{LinearStage, RowBlock, Rows, TakeRows};
pub use model::{GridEdge, Kernel, KernelScratch, KernelSettings, LANDMARKS};
