//! What counts as full scale where nobody entered the rated load.

use crate::min_max::MinMax;

/// Where the lesser side is below this share of the greater, a load goes one way only.
const ONE_WAY: f64 = 0.1;

/// The full scale of an axis whose load goes from the least to the greatest of `range`: half of what lies between them, or
/// the largest magnitude where the load goes one way only, as in a press. 0 where the load does not change.
///
/// **Units** that of the load.
pub fn full_scale_of(range: MinMax) -> f64 {
    let (up, down) = (range.max.max(0.0), (-range.min).max(0.0));
    let changes = range.max > range.min;
    if !changes {
        0.0
    } else if up.min(down) < ONE_WAY * up.max(down) {
        up.max(down)
    } else {
        0.5 * range.span()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_that_goes_one_way_has_its_largest_magnitude_as_full_scale() {
        for (range, expected) in [
            ((-10.0, 8.0), 9.0),
            ((0.0, 10.0), 10.0),
            ((-0.9, 10.0), 10.0),
            ((-1.0, 10.0), 5.5),
            ((-50.0, 2.0), 50.0),
            ((100.0, 110.0), 110.0),
            ((3.0, 3.0), 0.0),
            ((f64::NAN, f64::NAN), 0.0),
        ] {
            let loads: MinMax = [range.0, range.1].iter().collect();
            assert_eq!(full_scale_of(loads), expected, "{range:?}");
        }
    }
}
