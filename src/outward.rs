//! Bounds in single precision: half the memory, and never inside of what they bound.

/// The greatest single number that is not above.
#[inline(always)]
pub(crate) fn rounded_down(value: f64) -> f32 {
    let nearest = value as f32;
    match f64::from(nearest) > value {
        true => nearest.next_down(),
        false => nearest,
    }
}

/// The least single number that is not below.
#[inline(always)]
pub(crate) fn rounded_up(value: f64) -> f32 {
    -rounded_down(-value)
}
