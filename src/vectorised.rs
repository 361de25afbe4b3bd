//! Loops that are compiled for several instruction sets. At run time, the program uses the best set that its processor
//! supports.

struct Work<F>(F);

impl<F: FnMut()> pulp::WithSimd for Work<F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        (self.0)();
    }
}

/// Runs `work` with the best instruction set of this processor. The closure must be `#[inline(always)]`. The closure is
/// called by reference, because a closure that [`pulp::Arch::dispatch`] calls by value becomes a separate function in which
/// each `mul_add` is a call.
#[inline(always)]
pub(crate) fn vectorised(work: impl FnMut()) {
    pulp::Arch::new().dispatch(Work(work));
}
