//! Cycles of a load, and the width of the hysteresis loop between the two branches of a cycle.
//!
//! Guarantees: the output along a branch ([`Curve`]) is finite for finite samples, even if the load turns back within the
//! branch. It is exact for an output that is linear in the load.

use crate::{min_max::MinMax, recording::median::white_noise, scoring::loops::turns::Branch};

/// Number of loads at which the two branches of a loop are compared: at every hundredth of the load range that both cover.
pub const LOADS: usize = 101;

/// Cycle of a load: two neighbouring branches of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    pub recording: usize,
    pub first: Branch,
    pub second: Branch,
}

impl Cycle {
    pub fn rising(&self) -> &Branch {
        if self.first.rising { &self.first } else { &self.second }
    }

    pub fn falling(&self) -> &Branch {
        if self.first.rising { &self.second } else { &self.first }
    }

    /// Returns the range of loads that both branches cover.
    pub fn loads(&self) -> MinMax {
        MinMax::common([self.first.loads, self.second.loads].into_iter())
    }

    pub fn span(&self) -> f64 {
        self.loads().span()
    }
}

/// Maximum noise of a loop's width after smoothing, as a share of the largest width.
const MAX_NOISE: f64 = 0.02;
/// Maximum number of neighbouring widths on each side for smoothing a loop's widths. With this number, smoothing lowers the
/// largest width of a loop with a sharp maximum by at most an eighth, and that of an ellipse by a hundredth.
const MAX_NEIGHBOURS: usize = 12;
/// Number of standard deviations by which a smoothed width may differ from a less smoothed width, so that a narrow peak of the
/// width keeps its size where it stands out of the noise.
const SURE: f64 = 3.0;

/// Hysteresis loop of one output: [`LOADS`] values on each branch, at loads in equal steps over `range`.
#[derive(Debug, PartialEq)]
pub struct Loop {
    /// Range of loads that both branches cover.
    pub range: MinMax,
    /// Output while the load rises.
    pub rising: Vec<f64>,
    /// Output while the load falls.
    pub falling: Vec<f64>,
}

impl Loop {
    /// Returns the loop of an output over a cycle. `output` returns the output of a sample. Panics if the cycle lies outside
    /// `loads`.
    pub fn of(cycle: &Cycle, loads: &[f64], output: impl Fn(usize) -> f64) -> Self {
        let range = cycle.loads();
        let on = |branch: &Branch| {
            let curve = Curve::of(branch, loads, &output);
            even_loads(range).map(|load| curve.at(load)).collect()
        };
        Self { range, rising: on(cycle.rising()), falling: on(cycle.falling()) }
    }

    /// Returns the mean of several loops over the loads that all of them cover; `None` if they have no load in common.
    pub fn mean(loops: &[Self]) -> Option<Self> {
        let range = MinMax::common(loops.iter().map(|one| one.range));
        let usable = range.span() > 0.0 && range.span().is_finite();
        let mean = |branch: fn(&Self) -> &[f64]| {
            let sum = |load| loops.iter().map(|one| one.at(branch(one), load)).sum::<f64>();
            even_loads(range).map(|load| sum(load) / loops.len() as f64).collect()
        };
        usable.then(|| Self {
            range,
            rising: mean(|one| &one.rising),
            falling: mean(|one| &one.falling),
        })
    }

    /// Returns the output of a branch of this loop at a load within the loop's range.
    fn at(&self, branch: &[f64], load: f64) -> f64 {
        let steps = (LOADS - 1) as f64;
        let position = ((load - self.range.min) / self.range.span() * steps).clamp(0.0, steps);
        let below = (position as usize).min(LOADS - 2);
        branch[below] + (branch[below + 1] - branch[below]) * (position - below as f64)
    }

    /// Returns the loads at which the branches are compared, in rising order.
    pub fn loads(&self) -> impl Iterator<Item = f64> + use<> {
        even_loads(self.range)
    }

    /// Returns the loop's width at each load: falling minus rising output, positive if the output lags behind the load.
    pub fn widths(&self) -> impl Iterator<Item = f64> {
        self.falling.iter().zip(&self.rising).map(|(falling, rising)| falling - rising)
    }

    /// Returns the magnitude of the smoothed width at each load, and the standard deviation of its noise, see [`quiet`].
    fn quiet_widths(&self) -> (Vec<f64>, f64) {
        let (widths, noise) = quiet(&self.widths().collect::<Vec<f64>>(), MAX_NOISE, SURE);
        (widths.into_iter().map(f64::abs).collect(), noise)
    }

    /// Returns the largest magnitude of the loop's width, in the unit of the output.
    ///
    /// **Source** OIML R 60-1, 3.7: the difference at one load between loading from the minimum and unloading from the maximum.
    pub fn largest_width(&self) -> f64 {
        // At the ends, single samples are compared.
        self.quiet_widths().0[1..LOADS - 1].iter().copied().fold(0.0, f64::max)
    }

    /// Returns the standard deviation of the noise of the smoothed width.
    pub fn width_noise(&self) -> f64 {
        self.quiet_widths().1
    }

    /// Returns the mean magnitude of the loop's width over the loop's load range, in the unit of the output.
    pub fn mean_width(&self) -> f64 {
        mean_by_trapezoids(self.quiet_widths().0.into_iter())
    }

    /// Returns the area of the loop: the integral of the width's magnitude over the load. It also holds for open loops and
    /// crossing branches.
    pub fn area(&self) -> f64 {
        self.mean_width() * self.range.span()
    }

    /// Returns the integral of the signed width over the load: positive if the output lags behind the load, else negative.
    pub fn work(&self) -> f64 {
        mean_by_trapezoids(self.widths()) * self.range.span()
    }
}

/// Smooths differences at evenly spaced loads by least-squares lines through neighbouring differences. The number of
/// neighbours is the smallest that makes two standard deviations of the noise at most a `share` of the largest difference.
/// Without smoothing, noise would increase the largest and the mean magnitude. A line is not used at a load where it differs
/// from a line through fewer neighbours by more than `sure` standard deviations of both. Also returns the standard deviation
/// of the noise that is left at the ends, where it is largest.
///
/// **Source** of the limit `sure`, the intersection of confidence intervals: V. Katkovnik, *A new method for varying adaptive
/// bandwidth selection*, IEEE Transactions on Signal Processing 47, 1999.
pub fn quiet(values: &[f64], share: f64, sure: f64) -> (Vec<f64>, f64) {
    let noise = white_noise(values);
    let mut smooth = values.to_vec();
    let mut intervals = vec![MinMax { min: f64::NEG_INFINITY, max: f64::INFINITY }; values.len()];
    let mut half = 0;
    loop {
        for (at, (smooth, interval)) in smooth.iter_mut().zip(&mut intervals).enumerate() {
            let (value, noise_left) = on_line(values, at, half);
            let margin = sure * noise * noise_left;
            interval.min = interval.min.max(value - margin);
            interval.max = interval.max.min(value + margin);
            if interval.min <= interval.max {
                *smooth = value;
            }
        }
        let largest = smooth.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let is_quiet = 2.0 * noise <= share * largest * ((2 * half + 1) as f64).sqrt();
        if is_quiet || half == MAX_NEIGHBOURS {
            break;
        }
        half += 1;
    }
    // The variance at the end of a line through n values is about 4/n of the variance of one value.
    let left = noise * (4.0 / (half as f64 + 4.0)).sqrt();
    (smooth, left)
}

/// Returns [`LOADS`] loads in equal steps from the minimum to the maximum of a range.
fn even_loads(range: MinMax) -> impl Iterator<Item = f64> {
    (0..LOADS).map(move |step| {
        let share = step as f64 / (LOADS - 1) as f64;
        range.min * (1.0 - share) + range.max * share
    })
}

/// Returns the mean of a function by the trapezoidal rule, from its [`LOADS`] values at equal steps.
fn mean_by_trapezoids(values: impl Iterator<Item = f64>) -> f64 {
    let last = LOADS - 1;
    let weighted = values.enumerate().map(|(at, value)| {
        let is_end = at == 0 || at == last;
        if is_end { value / 2.0 } else { value }
    });
    weighted.sum::<f64>() / last as f64
}

/// Returns the value at index `at` of the least-squares line through this value and up to `half` neighbours on each side, and
/// its noise as a multiple of the noise of one value.
fn on_line(values: &[f64], at: usize, half: usize) -> (f64, f64) {
    let from = at.saturating_sub(half);
    let near = &values[from..(at + half + 1).min(values.len())];
    let middle = 0.5 * (near.len() - 1) as f64;
    let n = near.len() as f64;
    let mean = near.iter().sum::<f64>() / n;
    let places = || (0..near.len()).map(|place| place as f64 - middle);
    let squares: f64 = places().map(|place| place * place).sum();
    if squares == 0.0 {
        return (mean, 1.0);
    }
    let slope = places().zip(near).map(|(place, value)| place * value).sum::<f64>() / squares;
    let place = (at - from) as f64 - middle;
    (mean + slope * place, (1.0 / n + place * place / squares).sqrt())
}

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
    use crate::scoring::loops::Loops;

    /// Returns `cycles` cycles from −1 to 1 and back, in `steps` steps each way, starting and ending at −1.
    fn triangle(cycles: usize, steps: usize) -> Vec<f64> {
        (0..=2 * cycles * steps)
            .map(|k| {
                let phase = (k % (2 * steps)) as f64 / steps as f64;
                if phase <= 1.0 { 2.0 * phase - 1.0 } else { 3.0 - 2.0 * phase }
            })
            .collect()
    }

    /// Play operator that starts at its lower end.
    fn play(loads: &[f64], radius: f64) -> Vec<f64> {
        let mut state = loads[0] + radius;
        let follow = |&load: &f64| {
            state = state.clamp(load - radius, load + radius);
            state
        };
        loads.iter().map(follow).collect()
    }

    /// A play operator of radius r under ±A rises along `x − r` and falls along `x + r`. It needs a load of 2r to cross from
    /// one to the other, so its loop is a parallelogram of width 2r and area `4 r (A − r)`.
    #[test]
    fn a_play_operator_has_its_known_width_and_area() {
        for (radius, steps) in [(0.1, 2000), (0.25, 333), (0.04, 150)] {
            let loads = triangle(3, steps);
            let found = Loops::of([&loads[..]], 0.05);
            let output = play(&loads, radius);
            let one = Loop::of(&found.largest().unwrap(), &loads, |k| output[k]);
            let area = 4.0 * radius * (1.0 - radius);
            assert!((one.largest_width() / (2.0 * radius) - 1.0).abs() < 0.01);
            assert!((one.area() / area - 1.0).abs() < 0.01, "{}", one.area());
            assert!((one.mean_width() / (area / 2.0) - 1.0).abs() < 0.01);
        }
    }

    /// Noise of 1 % makes neither a width nor an area without hysteresis, and hardly changes those of play.
    #[test]
    fn noise_is_no_hysteresis() {
        let mut random = crate::random::Random::new(3, &[]);
        for radius in [0.0, 0.03] {
            let loads = triangle(3, 400);
            let noisy: Vec<f64> =
                play(&loads, radius).iter().map(|output| output + 0.01 * random.normal()).collect();
            let cycle = Loops::of([&loads[..]], 0.05).largest().unwrap();
            let one = Loop::of(&cycle, &loads, |k| noisy[k]);
            assert!((one.largest_width() - 2.0 * radius).abs() < 0.006, "{}", one.largest_width());
            let mean = 2.0 * radius * (1.0 - radius); // mean width of the parallelogram
            assert!((one.mean_width() - mean).abs() < 0.003, "{}", one.mean_width());
        }
    }

    /// The branches are apart by a peak of height 0.1 over a sixth of the load, and noise of 0.005 leaves its height.
    #[test]
    fn a_narrow_peak_of_the_width_is_no_noise() {
        let mut random = crate::random::Random::new(4, &[]);
        let loads = triangle(1, 800);
        let apart = |load: f64| (0.1 - 0.6 * (load - 0.7).abs()).max(0.0);
        let outputs: Vec<f64> = (loads.iter().enumerate())
            .map(|(k, load)| if k > 800 { apart(*load) } else { 0.0 } + 0.005 * random.normal())
            .collect();
        let cycle = Loops::of([&loads[..]], 0.05).largest().unwrap();
        let one = Loop::of(&cycle, &loads, |k| outputs[k]);
        assert!((one.largest_width() - 0.1).abs() < 0.01, "{}", one.largest_width());
    }

    /// The load wiggles by less than the reversal threshold, so the branches visit a load several times. The sizes stay.
    #[test]
    fn a_wiggling_load_does_not_change_the_loop() {
        let wiggle = |(k, load): (usize, &f64)| load * 0.98 + 0.02 * (k as f64 * 1.3).sin();
        let loads: Vec<f64> = triangle(2, 5000).iter().enumerate().map(wiggle).collect();
        let found = Loops::of([&loads[..]], 0.05);
        assert_eq!(found.branches()[0].len(), 4);
        let output: Vec<f64> = loads.iter().map(|load| 5.0 + 2.0 * load).collect();
        let one = Loop::of(&found.largest().unwrap(), &loads, |k| output[k]);
        assert!(one.largest_width() < 1e-9);
    }

    #[test]
    fn an_output_that_leads_has_negative_work_and_a_positive_area_and_width() {
        let loads = triangle(2, 500);
        let leading: Vec<f64> = loads
            .iter()
            .zip(play(&loads, 0.1))
            .map(|(load, lagging)| 2.0 * load - lagging)
            .collect();
        let cycle = Loops::of([&loads[..]], 0.05).largest().unwrap();
        let one = Loop::of(&cycle, &loads, |k| leading[k]);
        assert!(one.work() < 0.0 && (one.area() + one.work()).abs() < 1e-12);
        assert!((one.largest_width() - 0.2).abs() < 1e-3);
    }

    /// A figure of eight with the width x over −1..1: each half encloses 1/2, and the dissipated work cancels.
    #[test]
    fn branches_that_cross_enclose_an_area_and_do_no_work() {
        let one = Loop {
            range: MinMax { min: -1.0, max: 1.0 },
            rising: vec![0.0; LOADS],
            falling: even_loads(MinMax { min: -1.0, max: 1.0 }).collect(),
        };
        assert!((one.area() - 1.0).abs() < 1e-4, "{}", one.area());
        assert!(one.work().abs() < 1e-12);
    }

    /// Widths 1 and 3 over 0..10 and 2..12 have the mean 2 over 2..10.
    #[test]
    fn loops_are_averaged_over_the_loads_they_share() {
        let flat = |low: f64, width: f64| Loop {
            range: MinMax { min: low, max: low + 10.0 },
            rising: vec![0.0; LOADS],
            falling: vec![width; LOADS],
        };
        let mean = Loop::mean(&[flat(0.0, 1.0), flat(2.0, 3.0)]).unwrap();
        assert_eq!(mean.range.ends(), Some((2.0, 10.0)));
        assert!((mean.area() - 16.0).abs() < 1e-12);
        assert_eq!(Loop::mean(&[flat(0.0, 1.0), flat(20.0, 3.0)]), None);
        assert_eq!(Loop::mean(&[]), None);
    }
}

#[cfg(test)]
mod curve_tests {
    use crate::scoring::loops::cycle::*;
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
