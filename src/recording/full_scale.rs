//! Full scale of an axis for which the user entered no rated load.

use crate::min_max::MinMax;

/// Largest ratio of the smaller to the larger extreme of a load (in magnitude) at which the load counts as one-sided.
const ONE_WAY: f64 = 0.1;

/// Returns the full scale (N or N·m) of an axis whose load has this range: half the peak-to-peak load. For a load in one
/// direction only, as in a press, it is the largest magnitude. For a constant load, it is 0.
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
