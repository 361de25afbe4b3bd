//! Bounds in single precision, rounded outwards: half the memory, and never inside the exact bounds.

#[inline(always)]
pub(crate) fn rounded_down(value: f64) -> f32 {
    let nearest = value as f32;
    match f64::from(nearest) > value {
        true => nearest.next_down(),
        false => nearest,
    }
}

#[inline(always)]
pub(crate) fn rounded_up(value: f64) -> f32 {
    -rounded_down(-value)
}
