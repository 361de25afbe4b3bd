//! Rounds lower bounds down and upper bounds up to single precision, which halves their memory. So the rounded interval
//! always contains the exact one.

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
