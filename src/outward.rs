//! Bounds in single precision, rounded outwards: half the memory, and never inside the exact bounds.

/// Returns the largest single-precision number that is not above a value.
#[inline(always)]
pub(crate) fn rounded_down(value: f64) -> f32 {
    let nearest = value as f32;
    match f64::from(nearest) > value {
        true => nearest.next_down(),
        false => nearest,
    }
}

/// Returns the smallest single-precision number that is not below a value.
#[inline(always)]
pub(crate) fn rounded_up(value: f64) -> f32 {
    -rounded_down(-value)
}
