//! Output as a function of the load along one branch of a hysteresis loop.
//!
//! Guarantees: the curve is finite for finite samples, even if the load turns back within the branch. It is exact for an
//! output that is linear in the load.

use crate::scoring::loops::turns::Branch;

/// Number of intervals of equal width into which the load range of a branch is divided.
pub const CELLS: usize = 100;

/// Output along a branch, as straight lines between points `(load, output)`.
///
/// A branch can pass a load several times, because of noise or small reversals of the load. So load and output are averaged
/// over each hundredth of the branch's load range. The points are these averages, and the samples of minimum and maximum
/// load, which neighbouring branches share.
#[derive(Debug)]
pub struct Curve {
    /// Points `(load, output)` with rising, different loads.
    knots: Vec<(f64, f64)>,
    averages: Vec<(f64, f64)>,
}

impl Curve {
    /// Averages the samples of a branch, except those of smaller cycles within it. Panics if `loads` lacks samples of the
    /// branch. `output_of` returns the output of a sample.
    pub fn of(branch: &Branch, loads: &[f64], output_of: impl Fn(usize) -> f64) -> Self {
        let mut cells = [(0.0, 0.0, 0.0); CELLS];
        let per_load = CELLS as f64 / branch.span();
        let (mut lowest, mut highest) = (branch.samples.start, branch.samples.start);
        for k in branch.kept() {
            let (load, output) = (loads[k], output_of(k));
            if load < loads[lowest] {
                lowest = k;
            }
            if load > loads[highest] {
                highest = k;
            }
            let cell = (((load - branch.loads.min) * per_load) as usize).min(CELLS - 1);
            let (count, sum_of_loads, sum_of_outputs) = &mut cells[cell];
            *count += 1.0;
            *sum_of_loads += load;
            *sum_of_outputs += output;
        }
        let averages: Vec<(f64, f64)> = cells
            .iter()
            .filter(|(count, ..)| *count > 0.0)
            .map(|(count, load, output)| (load / count, output / count))
            .collect();
        let ends = [lowest, highest].map(|k| (loads[k], output_of(k)));
        let mut knots = vec![ends[0]];
        // An average is dropped if its load equals, except for rounding, that of an end of the branch.
        let least_gap = 1e-9 * branch.span();
        knots.extend(
            averages
                .iter()
                .filter(|(load, _)| load - ends[0].0 > least_gap && ends[1].0 - load > least_gap),
        );
        knots.push(ends[1]);
        Self { knots, averages }
    }

    /// Joins readings `(load, output)` of a branch at the ends of its steps by straight lines. Panics with fewer than two readings.
    pub fn through(mut readings: Vec<(f64, f64)>) -> Self {
        readings.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { knots: readings.clone(), averages: readings }
    }

    /// Returns the output at this load. Beyond an end of the branch, it is the output at this end.
    pub fn at(&self, load: f64) -> f64 {
        let next = self.knots.partition_point(|(knot, _)| *knot <= load);
        match (next.checked_sub(1), self.knots.get(next)) {
            (Some(last), Some((x1, y1))) => {
                let (x0, y0) = self.knots[last];
                y0 + (y1 - y0) * (load - x0) / (x1 - x0)
            }
            (Some(end), None) => self.knots[end].1,
            (None, Some((_, output))) => *output,
            (None, None) => unreachable!("a curve has a first and a last point"),
        }
    }

    /// Returns the averages as `(load, output)` with rising loads: one for each hundredth of the branch's load range that has
    /// samples.
    pub fn averages(&self) -> &[(f64, f64)] {
        &self.averages
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoring::loops::turns::branches;

    fn curve(loads: &[f64], output: impl Fn(f64) -> f64) -> Curve {
        Curve::of(&branches(loads, 0.3)[0], loads, |k| output(loads[k]))
    }

    /// The load rises from 0 to 10 and repeatedly falls by 0.2; a straight line stays straight.
    #[test]
    fn a_load_that_wiggles_does_not_bend_a_line() {
        let loads: Vec<f64> =
            (0..4000).map(|k| k as f64 / 400.0 + 0.1 * (k as f64 * 0.9).sin()).collect();
        let curve = curve(&loads, |load| 3.0 - 2.0 * load);
        for k in 0..=20 {
            let load = f64::from(k) / 2.0;
            assert!((curve.at(load) - (3.0 - 2.0 * load)).abs() < 1e-9, "{load}");
        }
        assert_eq!(curve.averages.len(), CELLS);
    }

    /// Fewer samples than cells: straight lines between the samples, and the end values beyond the ends.
    #[test]
    fn few_samples_are_joined() {
        let curve = curve(&[0.0, 4.0, 10.0], |load| load * load);
        for (load, expected) in [(-1.0, 0.0), (2.0, 8.0), (4.0, 16.0), (7.0, 58.0), (11.0, 100.0)] {
            assert!((curve.at(load) - expected).abs() < 1e-12, "{load}");
        }
        assert_eq!(curve.averages.len(), 3);
    }
}
