//! Loops compiled for each instruction set, of which one is chosen when the program runs.

struct Work<F>(F);

impl<F: FnMut()> pulp::WithSimd for Work<F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        (self.0)();
    }
}

/// Runs `work` with the instructions of this processor. The closure must be `#[inline(always)]`.
///
/// Called by reference, a closure is inlined. Called by value, as [`pulp::Arch::dispatch`] does, a closure that moves
/// nothing out is reached through a function of its own, without these instructions: each `mul_add` is then a call.
#[inline(always)]
pub(crate) fn vectorised(work: impl FnMut()) {
    pulp::Arch::new().dispatch(Work(work));
}
