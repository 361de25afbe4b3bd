//! Rounding of bounds to single precision, which halves their memory. The rounded bounds always include the exact ones.

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
