//! Loops compiled for each instruction set, of which one is chosen when the program runs.

struct Work<F>(F);

impl<F: FnMut()> pulp::WithSimd for Work<F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        (self.0)();
    }
}

/// Runs `work` with the instructions of this processor. The closure must be `#[inline(always)]`. It is called by reference:
/// called by value, as [`pulp::Arch::dispatch`] does, it would be a separate function in which each `mul_add` is a call.
#[inline(always)]
pub(crate) fn vectorised(work: impl FnMut()) {
    pulp::Arch::new().dispatch(Work(work));
}
