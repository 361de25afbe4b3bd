//! Computes the reference load at the times of the gauge samples if the two have different clocks. Outside the times of the
//! reference, and farther from its samples than a limit, there is no value.

use super::map::JoinMethod;

/// Rows of `width` values each, with the times (s) of the rows. The times never decrease.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a> {
    pub times: &'a [f64],
    pub values: &'a [f64],
    pub width: usize,
}

/// Returns the values of a reference at other times. What `limit_secs` limits depends on the method: the time step between
/// two interpolated samples, the distance in time of the nearest sample, or the age of a held value.
///
/// **Shapes** The first list has one entry for each of `times`: true if the reference has a value at this time. The second
/// list has `width` values for each true entry.
pub fn at_times(
    times: &[f64],
    reference: Series,
    method: JoinMethod,
    limit_secs: f64,
) -> (Vec<bool>, Vec<f64>) {
    let mut values = Vec::with_capacity(times.len() * reference.width);
    let has_value = times
        .iter()
        .map(|&time| {
            let n_before = values.len();
            if let Some((first, second, share)) =
                blend_at(time, reference.times, method, limit_secs)
            {
                let row = |k: usize| &reference.values[k * reference.width..][..reference.width];
                let between = |(a, b): (&f64, &f64)| {
                    if share == 0.0 { *a } else { a + (b - a) * share }
                };
                values.extend(row(first).iter().zip(row(second)).map(between));
            }
            // Interpolation takes the difference of two values, which may be infinite for very large numbers. Such a result
            // is left out.
            if values[n_before..].iter().any(|value| !value.is_finite()) {
                values.truncate(n_before);
            }
            values.len() > n_before
        })
        .collect();
    (has_value, values)
}

/// Returns the indices of the two samples of the reference between which the value at this time lies, and the weight (0 to 1)
/// of the second one.
fn blend_at(
    time: f64,
    known: &[f64],
    method: JoinMethod,
    limit_secs: f64,
) -> Option<(usize, usize, f64)> {
    let next = known.partition_point(|other| *other <= time);
    let before = next.checked_sub(1);
    let distance = |index: usize| (time - known[index]).abs();
    let near = |index: usize| (distance(index) <= limit_secs).then_some((index, index, 0.0));
    match (method, before) {
        (JoinMethod::Hold, _) => near(before?),
        (JoinMethod::Nearest, Some(before)) if next == known.len() => near(before),
        (JoinMethod::Nearest, Some(before)) if distance(before) <= distance(next) => near(before),
        (JoinMethod::Nearest, _) => (next < known.len()).then(|| near(next)).flatten(),
        (JoinMethod::Interpolate, _) => {
            let first = before?;
            if time == known[first] {
                return Some((first, first, 0.0));
            }
            let step = known.get(next)? - known[first];
            (step <= limit_secs).then(|| (first, next, (time - known[first]) / step))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: [f64; 4] = [1.0, 2.0, 4.0, 10.0];
    const VALUES: [f64; 4] = [10.0, 20.0, 40.0, 0.0];

    fn joined(times: &[f64], method: JoinMethod, limit_secs: f64) -> Vec<Option<f64>> {
        let reference = Series { times: &TIMES, values: &VALUES, width: 1 };
        let (has_value, values) = at_times(times, reference, method, limit_secs);
        let mut values = values.into_iter();
        let joined = has_value.iter().map(|has| has.then(|| values.next().unwrap()));
        joined.collect()
    }

    #[test]
    fn interpolation_never_leaves_the_reference_nor_bridges_a_long_step() {
        let times = [0.9, 1.0, 1.5, 2.0, 3.5, 4.0, 5.0, 10.0, 10.1];
        let of = |limit| joined(&times, JoinMethod::Interpolate, limit);
        let near = [None, Some(10.0), Some(15.0), Some(20.0), Some(35.0), Some(40.0)];
        assert_eq!(of(3.0)[..6], near);
        assert_eq!(of(3.0)[6..], [None, Some(0.0), None]);
        assert!((of(6.0)[6].unwrap() - 40.0 * 5.0 / 6.0).abs() < 1e-12);
        assert_eq!(of(0.5)[2..4], [None, Some(20.0)]);
    }

    #[test]
    fn the_nearest_sample_must_be_near() {
        let times = [0.4, 0.5, 1.4, 1.6, 3.0, 3.1, 6.0, 10.5];
        let values = joined(&times, JoinMethod::Nearest, 0.5);
        let expected = [None, Some(10.0), Some(10.0), Some(20.0), None, None, None, Some(0.0)];
        assert_eq!(values, expected);
        // Halfway between two samples, the earlier sample is used.
        assert_eq!(joined(&[3.0], JoinMethod::Nearest, 1.0), [Some(20.0)]);
    }

    #[test]
    fn a_held_value_expires() {
        let times = [0.9, 1.0, 1.9, 5.0, 6.1, 12.0];
        let values = joined(&times, JoinMethod::Hold, 2.0);
        assert_eq!(values, [None, Some(10.0), Some(10.0), Some(40.0), None, Some(0.0)]);
    }

    #[test]
    fn all_values_at_a_time_are_joined() {
        let reference = Series { times: &[0.0, 1.0], values: &[1.0, -1.0, 2.0, -2.0], width: 2 };
        let (has_value, values) =
            at_times(&[0.5, 2.0, 1.0], reference, JoinMethod::Interpolate, 1.0);
        assert_eq!(has_value, [true, false, true]);
        assert_eq!(values, [1.5, -1.5, 2.0, -2.0]);
    }

    #[test]
    fn without_a_reference_there_is_no_value() {
        let none = Series { times: &[], values: &[], width: 3 };
        for method in [JoinMethod::Interpolate, JoinMethod::Nearest, JoinMethod::Hold] {
            assert_eq!(at_times(&[1.0], none, method, 9.0), (vec![false], vec![]));
        }
    }
}
