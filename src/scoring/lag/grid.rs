//! Regression columns for measuring the time lag between reference and outputs: smoothed and thinned loads, with terms for
//! hysteresis, creep and curvature.
//!
//! Guarantees: reference and outputs are smoothed by the same symmetric window, so neither is shifted in time. No row is
//! computed from samples on both sides of a pause.

use std::f64::consts::PI;
use std::ops::Range;

use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

use super::{
    LagRun, NoLag,
    kind::{filtered, low_pass},
};
use crate::{
    column::column,
    dot::{dot, dot_of_long},
    min_max::MinMax,
    recording::{
        gap::{median_step, pause_by_step},
        median::{median, white_noise as noise, white_noise_by as noise_by},
    },
    vectorised::vectorised,
};

/// Radii of the play operators, as shares of half the range of their input. The first is raised to the smallest radius, and
/// describes hysteresis that reverses at once.
const RADII: [f64; 13] =
    [0.0, 0.008, 0.012, 0.02, 0.03, 0.045, 0.06, 0.085, 0.12, 0.17, 0.25, 0.4, 0.6];
/// Smallest radius that is used, as a share of half the range of the input. A play operator with a smaller radius is the sign
/// of the load's rate.
const SMALLEST_RADIUS: f64 = 0.003;
/// Smallest radius that is used, in standard deviations of the smoothed noise. A play operator with a smaller radius would
/// follow the noise.
const RADIUS_IN_NOISE: f64 = 4.0;
/// Time constants of the slow creep terms, as multiples of the load's time scale. Shorter time constants count as lag.
const CREEP: [f64; 3] = [3.0, 12.0, 48.0];
/// Time constant of the quick creep term, which looks like a lag, as a multiple of the load's time scale.
const QUICK_CREEP: f64 = 1.0;
/// Maximum number of gauges with which play operators are also driven by the strain of each gauge.
const MOST_DRIVERS: usize = 12;
/// Half width of the narrowest smoothing window, in samples. Interpolation reduces noise most in the middle between two
/// samples, which would shift a lag towards half a sample. After smoothing by this window, the effect is below 0.1 %.
const NARROWEST: usize = 3;
const WIDEST: usize = 400;
/// Maximum change of the noise-free load by the smoothing window, as a share of the load's standard deviation.
const MOST_SMOOTHED: f64 = 0.005;
/// Maximum number of rows of the regression. Of longer recordings, only parts spread over each interval become rows. Play
/// operators and creep are computed from the whole interval, because they depend on earlier loads.
const MOST_ROWS: usize = 8_000;
const PARTS: usize = 8;
/// Number of samples at each end of an interval that are not used, because play operators and creep settle there.
const MARGIN: usize = 20;
/// Play operators no longer depend on their first states once their input has moved by this multiple of the largest radius.
/// Twice the radius is enough except for rounding.
const FORGOTTEN: f64 = 2.001;
/// A creep term no longer depends on its first state after this multiple of its time constant, because e⁻⁴⁰ of a state is
/// less than its rounding.
const SETTLED: f64 = 40.0;
/// Minimum number of blocks of consecutive samples into which each recording is cut.
const BLOCKS_A_RUN: usize = 4;
const BLOCKS: usize = 12;
/// Minimum ratio of a step of the load to the mean of its two neighbouring steps for it to count as a jump. Jumps are not
/// used, because their time between two samples is unknown.
const JUMP: f64 = 4.0;
const JUMP_IN_NOISE: f64 = 8.0;
/// Number of samples before and after a jump that are not used.
pub const AROUND_JUMP: usize = 30;

/// Rows of the regression from an interval without a gap in the sample times, or from a part of the interval.
#[derive(Debug)]
pub struct Part {
    pub run: usize,
    /// Samples of the recording from which the rows are computed.
    samples: Range<usize>,
    pub times: Vec<f64>,
    /// True for each row that the fit uses.
    pub used: Vec<bool>,
    /// Share of the jumps in the sum of the reference's squared steps, on the axis where this share is largest.
    jumps: f64,
}

/// Inputs of the play operators that describe hysteresis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drivers {
    /// Load of each axis, to describe friction and backlash of the structure.
    Axes,
    /// Strain of each gauge, which is a mixture of the loads, to describe hysteresis of a gauge or of its mounting place.
    Gauges,
}

/// Columns of the regression in all parts, in this order: loads, terms of hysteresis and curvature, terms of slow creep, a
/// constant, terms of quick creep.
#[derive(Debug)]
pub struct Columns {
    /// Values of each part, row-major.
    pub rows: Vec<Vec<f64>>,
    /// Number of columns.
    pub n: usize,
    /// Number of columns before the terms of quick creep.
    pub n_usual: usize,
    /// Columns that are kept when hysteresis is described with fewer radii.
    pub coarse: Vec<usize>,
}

/// Rows of the regression from all recordings.
#[derive(Debug)]
pub struct Grids {
    pub parts: Vec<Part>,
    pub n_axes: usize,
    /// Median time between samples (s).
    pub step_secs: f64,
    /// Time scale of the load (s): its standard deviation divided by the root mean square of its rate.
    pub slow_secs: f64,
    /// Block of consecutive samples to which each used row belongs.
    pub blocks: Vec<usize>,
    pub n_blocks: usize,
    window: Window,
}

/// Interval of a recording without pause.
struct Piece<'a> {
    run: usize,
    samples: Range<usize>,
    times: &'a [f64],
    loads: Vec<Vec<f64>>,
    data: &'a LagRun<'a>,
}

impl Grids {
    /// Returns the rows, and their columns for each input of the play operators that is worth trying.
    pub fn of(runs: &[LagRun<'_>]) -> Result<(Self, Vec<Columns>), NoLag> {
        let n_axes = runs.first().map_or(0, |run| run.n_axes());
        let steps: Vec<Option<f64>> = runs.iter().map(|run| median_step(run.times)).collect();
        let step_secs = median(steps.iter().flatten().copied()).ok_or(NoLag::TooShort)?;
        let whole = runs.iter().zip(steps).enumerate();
        let whole: Vec<Piece<'_>> =
            whole.flat_map(|(at, (run, step))| pieces(at, run, step)).collect();
        let half = half_width(&whole);
        let hop = (half / 3).max(1);
        let n: usize = whole.iter().map(|piece| piece.times.len()).sum();
        let share = (MOST_ROWS * hop) as f64 / n as f64;
        let shortest = 2 * (half + MARGIN) + 8 * hop;
        let pieces: Vec<_> =
            whole.into_iter().filter(|piece| piece.times.len() > shortest).collect();
        if pieces.is_empty() {
            return Err(NoLag::TooShort);
        }
        let window = Window::new(half, hop);
        let slow_secs = slow_secs(&pieces, &window).ok_or(NoLag::ConstantLoad)?;
        let longest = pieces.iter().map(|piece| piece.secs()).fold(0.0, f64::max);
        let mut creep = CREEP.map(|factor| factor * slow_secs).to_vec();
        creep.retain(|tau| *tau < 0.5 * longest);
        let n_slow = creep.len() * n_axes;
        creep.push(QUICK_CREEP * slow_secs);
        let of_pieces: Vec<Vec<Range<usize>>> =
            pieces.iter().map(|piece| piece.parts(share, shortest)).collect();
        let parts: Vec<Part> = (pieces.iter().zip(&of_pieces))
            .flat_map(|(piece, parts)| parts.iter().map(|part| piece.part(part, &window)))
            .collect();
        // Loads and creep are the same for all inputs of the play operators.
        let loads: Vec<Thinned> = thinned(&pieces, &of_pieces, &window, |piece, parts| {
            let loads = |part: &Range<usize>| -> Vec<Vec<f64>> {
                piece.loads.iter().map(|load| load[part.clone()].to_vec()).collect()
            };
            parts.iter().map(loads).collect()
        });
        let crept: Vec<Thinned> =
            thinned(&pieces, &of_pieces, &window, |piece, parts| piece.crept(&creep, parts));
        let per_driver = RADII.len() + 2;
        let inputs = runs.first().map_or(&[Drivers::Axes][..], Drivers::sensible);
        let columns = inputs.iter().map(|input| {
            let drivers = drivers(&pieces, n_axes, *input);
            let scale: Vec<_> =
                drivers.iter().map(|driver| range_and_noise(&pieces, driver)).collect();
            let driven: Vec<Thinned> = thinned(&pieces, &of_pieces, &window, |piece, parts| {
                piece.hysteresis(&drivers, &scale, &window, parts)
            });
            let n_driven = drivers.len() * per_driver;
            let is_finer = |column: usize| {
                let at = column.checked_sub(n_axes).filter(|at| *at < n_driven);
                at.map(|at| at % per_driver).is_some_and(|at| at < RADII.len() && at % 2 == 1)
            };
            let n_usual = n_axes + n_driven + n_slow + 1;
            let rows = parts.iter().enumerate().map(|(at, part)| {
                let constant = vec![1.0; part.times.len()];
                let (slow, quick) = crept[at].split_at(n_slow);
                let columns = loads[at].iter().chain(&driven[at]).chain(slow);
                let columns: Vec<&Vec<f64>> = columns.chain([&constant]).chain(quick).collect();
                let mut rows = Vec::with_capacity(columns.len() * constant.len());
                (0..constant.len())
                    .for_each(|row| rows.extend(columns.iter().map(|column| column[row])));
                rows
            });
            Columns {
                rows: rows.collect(),
                n: n_usual + n_axes,
                n_usual,
                coarse: (0..n_usual).filter(|column| !is_finer(*column)).collect(),
            }
        });
        let columns = columns.collect();
        let n_runs = parts.iter().map(|part| part.run).max().map_or(1, |last| last + 1);
        let per_run = BLOCKS.div_ceil(n_runs).max(BLOCKS_A_RUN);
        let blocks = parts.iter().flat_map(|part| {
            let place = |row: usize| {
                (part.samples.start + window.half + row * window.hop) as f64
                    / runs[part.run].times.len() as f64
            };
            let rows = (0..part.times.len()).filter(|row| part.used[*row]);
            rows.map(move |row| part.run * per_run + (place(row) * per_run as f64) as usize)
        });
        let blocks = blocks.collect();
        let n_blocks = n_runs * per_run;
        Ok((Self { blocks, n_blocks, parts, n_axes, step_secs, slow_secs, window }, columns))
    }

    /// Returns an output in the used rows.
    pub fn output(&self, runs: &[LagRun<'_>], output: usize) -> Vec<f64> {
        let rows = self.parts.iter().flat_map(|part| {
            let run = &runs[part.run];
            let n = run.n_outputs();
            let rows = &run.outputs[part.samples.start * n..part.samples.end * n];
            let values: Vec<f64> = column(rows, n, output).collect();
            part.kept(self.window.thinned(&values))
        });
        rows.collect()
    }

    /// Returns true if the reference load jumps anywhere in the rows.
    pub fn jumps(&self) -> bool {
        self.parts.iter().any(|part| part.jumps > 0.0)
    }

    /// Returns true if the load mostly moves in jumps. They then make up more than half of the sum of squared steps, on
    /// average over the intervals.
    pub fn moves_in_jumps(&self) -> bool {
        let shares = self.parts.iter().map(|part| part.jumps);
        shares.sum::<f64>() > 0.5 * self.parts.len() as f64
    }
}

impl Part {
    /// Returns the values of the used rows.
    pub fn kept(&self, values: Vec<f64>) -> impl Iterator<Item = f64> {
        values.into_iter().zip(&self.used).filter(|(_, used)| **used).map(|(value, _)| value)
    }
}

/// Columns of one part, smoothed and thinned.
type Thinned = Vec<Vec<f64>>;

/// Returns columns of all parts, smoothed and thinned. `of` returns the columns of each part of an interval.
fn thinned<'a>(
    pieces: &[Piece<'a>],
    parts: &[Vec<Range<usize>>],
    window: &Window,
    of: impl Fn(&Piece<'a>, &[Range<usize>]) -> Vec<Vec<Vec<f64>>>,
) -> Vec<Thinned> {
    let of_parts = pieces.iter().zip(parts).flat_map(|(piece, parts)| of(piece, parts));
    of_parts.map(|columns| columns.iter().map(|column| window.thinned(column)).collect()).collect()
}

impl Drivers {
    /// Returns the inputs of the play operators that are worth trying: gauge strains only if there are several axes and few
    /// gauges.
    fn sensible(run: &LagRun<'_>) -> &'static [Self] {
        if run.n_axes() > 1 && (1..=MOST_DRIVERS).contains(&run.n_gauges()) {
            &[Self::Axes, Self::Gauges]
        } else {
            &[Self::Axes]
        }
    }
}

impl Piece<'_> {
    fn secs(&self) -> f64 {
        self.times[self.times.len() - 1] - self.times[0]
    }

    /// Returns ranges of samples that are spread over the interval and together contain the share `share` of it. Each is
    /// longer than `shortest` samples.
    fn parts(&self, share: f64, shortest: usize) -> Vec<Range<usize>> {
        let n = self.times.len();
        let wanted = (share * n as f64) as usize;
        let length = (wanted / PARTS).max(shortest + 1);
        match (wanted / length).min(PARTS) {
            _ if wanted >= n => std::iter::once(0..n).collect(),
            0 | 1 => std::iter::once((n - length) / 2..(n + length) / 2).collect(),
            n_parts => {
                let start = |at: usize| at * (n - length) / (n_parts - 1);
                (0..n_parts).map(|at| start(at)..start(at) + length).collect()
            }
        }
    }

    /// Returns the strain of a gauge: the sum of the loads, each multiplied by the factor of its axis in `driver`.
    fn strain(&self, driver: &[f64], samples: Range<usize>) -> Vec<f64> {
        let mut strain = vec![0.0; samples.len()];
        for (share, load) in driver.iter().zip(&self.loads) {
            let load = &load[samples.clone()];
            strain.iter_mut().zip(load).for_each(|(strain, load)| *strain += share * load);
        }
        strain
    }

    /// Returns the strain of a gauge at one sample; see [`Self::strain`].
    fn strain_at(&self, driver: &[f64], k: usize) -> f64 {
        driver.iter().zip(&self.loads).fold(0.0, |strain, (share, load)| strain + share * load[k])
    }

    /// Returns the columns that describe hysteresis and curvature, for each part of the interval. Each gauge gives the output
    /// of a play operator for each radius, the square of its strain, and the cube.
    fn hysteresis(
        &self,
        drivers: &[Vec<f64>],
        scale: &[(MinMax, f64)],
        window: &Window,
        parts: &[Range<usize>],
    ) -> Vec<Vec<Vec<f64>>> {
        let mut columns = vec![Vec::new(); parts.len()];
        for (driver, (MinMax { min, max }, noise)) in drivers.iter().zip(scale) {
            let (half, middle) = (0.5 * (max - min), 0.5 * (max + min));
            // Only noisy strains are smoothed, because smoothing lowers the peaks at which play operators reverse.
            let is_noisy = RADIUS_IN_NOISE * noise > SMALLEST_RADIUS * half;
            let strain = |samples: Range<usize>| -> Vec<f64> {
                self.strain(driver, samples).iter().map(|strain| strain - middle).collect()
            };
            let smoothed = |samples| window.smoothed(self.times.len(), samples, strain);
            let floor = (SMALLEST_RADIUS * half).max(RADIUS_IN_NOISE * noise * window.gain());
            let radii = RADII.map(|radius| floor.max(radius * half));
            let beside = if is_noisy {
                beside_play(smoothed, radii, parts)
            } else {
                beside_play(strain, radii, parts)
            };
            for (columns, (strain, beside)) in columns.iter_mut().zip(beside) {
                columns.extend(beside);
                columns.extend(
                    [2, 3].map(|power| strain.iter().map(|strain| strain.powi(power)).collect()),
                );
            }
        }
        columns
    }

    /// Returns the terms of creep in each part: for each time constant, the load of each axis after a low-pass.
    fn crept(&self, taus: &[f64], parts: &[Range<usize>]) -> Vec<Vec<Vec<f64>>> {
        let mut columns = vec![Vec::new(); parts.len()];
        for tau in taus {
            let mut done = 0;
            let mut states: Vec<(f64, f64)> =
                self.loads.iter().map(|load| (load[0], load[0])).collect();
            for (columns, part) in columns.iter_mut().zip(parts) {
                let settled = self.times[part.start] - SETTLED * tau;
                let from = self.times.partition_point(|time| *time < settled);
                if from > done {
                    done = from;
                    states = self.loads.iter().map(|load| (load[from], load[from])).collect();
                }
                let before = &self.times[done.saturating_sub(1)..];
                let weights: Vec<[f64; 3]> =
                    low_pass(before[0], &self.times[done..part.end], *tau).collect();
                for (load, state) in self.loads.iter().zip(&mut states) {
                    let mut crept = filtered(state, weights.iter().copied(), &load[done..part.end]);
                    columns.push(crept.split_off(part.start - done));
                }
                done = part.end;
            }
        }
        columns
    }

    /// Returns the samples in the range `part`, smoothed and thinned.
    fn part(&self, part: &Range<usize>, window: &Window) -> Part {
        let start = self.samples.start;
        let times = window.thinned(&self.times[part.clone()]);
        let (used, jumps) = self.used(part, window, times.len());
        let samples = start + part.start..start + part.end;
        Part { run: self.run, samples, used, jumps, times }
    }

    /// Returns true for each row that is away from ends and jumps, and the share of jumps in the sum of the reference's
    /// squared steps.
    fn used(&self, part: &Range<usize>, window: &Window, n_rows: usize) -> (Vec<bool>, f64) {
        let n = part.len();
        let mut jumps = 0.0_f64;
        let mut blocked = vec![false; n];
        blocked[..MARGIN].fill(true);
        blocked[n - MARGIN..].fill(true);
        for load in self.loads.iter().map(|load| &load[part.clone()]) {
            let noise = noise(load);
            let steps: Vec<f64> = load.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
            let mut jumped = 0.0;
            for (at, around) in steps.windows(3).enumerate() {
                let usual = 0.5 * (around[0] + around[2]);
                if around[1] > JUMP * usual && around[1] > JUMP_IN_NOISE * noise {
                    let from = (at + 1).saturating_sub(window.half + AROUND_JUMP);
                    jumped += around[1] * around[1];
                    blocked[from..(at + window.half + AROUND_JUMP).min(n)].fill(true);
                }
            }
            let all: f64 = steps.iter().map(|step| step * step).sum();
            if all > 0.0 {
                jumps = jumps.max(jumped / all);
            }
        }
        let row = |row: usize| {
            let start = row * window.hop;
            !blocked[start] && !blocked[start + window.half] && !blocked[start + 2 * window.half]
        };
        ((0..n_rows).map(row).collect(), jumps)
    }
}

/// Symmetric smoothing window (raised cosine), and the number of samples from one row to the next.
#[derive(Debug)]
pub struct Window {
    half: usize,
    hop: usize,
    weights: Vec<f64>,
}

impl Window {
    fn new(half: usize, hop: usize) -> Self {
        let weight = |k: usize| 1.0 - (PI * (k + 1) as f64 / (half + 1) as f64).cos();
        let weights: Vec<f64> = (0..=2 * half).map(weight).collect();
        let sum: f64 = weights.iter().sum();
        Self { half, hop, weights: weights.iter().map(|weight| weight / sum).collect() }
    }

    /// Returns the factor by which the smoothing window changes the standard deviation of white noise.
    fn gain(&self) -> f64 {
        dot(&self.weights, &self.weights).sqrt()
    }

    fn mean(&self, values: &[f64]) -> f64 {
        dot_of_long(&self.weights, values)
    }

    fn thinned(&self, values: &[f64]) -> Vec<f64> {
        values.windows(2 * self.half + 1).step_by(self.hop).map(|near| self.mean(near)).collect()
    }

    /// Smooths the samples of a signal without thinning. The signal has `n` samples; `values` returns those in a range.
    /// Beyond its two ends, it is continued by point reflection at the end point.
    fn smoothed(
        &self,
        n: usize,
        samples: Range<usize>,
        values: impl Fn(Range<usize>) -> Vec<f64>,
    ) -> Vec<f64> {
        let last = n - 1;
        let from = samples.start.saturating_sub(self.half);
        let to = n.min(samples.end + self.half);
        let known = values(from..to);
        let at = |k: usize| known[k.min(last) - from];
        let n_before = self.half - (samples.start - from);
        let n_after = self.half - (to - samples.end);
        let before = (1..=n_before).rev().map(|k| 2.0 * at(0) - at(k));
        let after = (1..=n_after).map(|k| 2.0 * at(last) - at(last.saturating_sub(k)));
        let padded: Vec<f64> = before.chain(known.iter().copied()).chain(after).collect();
        padded.windows(2 * self.half + 1).map(|near| self.mean(near)).collect()
    }
}

/// Returns the strain in each part, and for each radius the strain minus the output of a play operator. `strain` returns the
/// strain in a range of samples. The parts must be in order and must not overlap.
fn beside_play<const N: usize>(
    strain: impl Fn(Range<usize>) -> Vec<f64>,
    radii: [f64; N],
    parts: &[Range<usize>],
) -> Vec<(Vec<f64>, [Vec<f64>; N])> {
    let forgotten = FORGOTTEN * radii.iter().copied().fold(0.0, f64::max);
    let mut known: Option<[f64; N]> = None;
    let mut done = 0;
    let of_part = |part: &Range<usize>| {
        let mut length = part.len();
        let (from, mut strains) = loop {
            let from = part.start.saturating_sub(length).max(done);
            let strains = strain(from..part.end);
            let before: MinMax = strains[..part.start - from].iter().collect();
            if from == done || before.span() >= forgotten {
                break (from, strains);
            }
            length *= 4;
        };
        let mut states = known.filter(|_| from == done).unwrap_or([strains[0]; N]);
        let mut beside = [(); N].map(|()| Vec::with_capacity(part.len()));
        vectorised(
            #[inline(always)]
            || {
                for (k, strain) in strains.iter().enumerate() {
                    for (state, radius) in states.iter_mut().zip(&radii) {
                        *state = state.max(strain - radius).min(strain + radius);
                    }
                    if from + k >= part.start {
                        for (beside, state) in beside.iter_mut().zip(&states) {
                            beside.push(strain - state);
                        }
                    }
                }
            },
        );
        (known, done) = (Some(states), part.end);
        (strains.split_off(part.start - from), beside)
    };
    parts.iter().map(of_part).collect()
}

/// Cuts a recording into intervals where samples are missing or times repeat.
fn pieces<'a>(run: usize, data: &'a LagRun<'a>, step_secs: Option<f64>) -> Vec<Piece<'a>> {
    let times = data.times;
    let pause = step_secs.map_or(0.0, pause_by_step);
    let is_cut = |k: &usize| {
        let step = times[*k] - times[*k - 1];
        step > pause || step <= 0.0
    };
    let cuts: Vec<usize> = (1..times.len()).filter(is_cut).collect();
    let starts = std::iter::once(0).chain(cuts.iter().copied());
    let ends = cuts.iter().copied().chain([times.len()]);
    let n_axes = data.n_axes();
    let piece = |(start, end): (usize, usize)| {
        let load = |axis| column(&data.loads[start * n_axes..end * n_axes], n_axes, axis).collect();
        Piece {
            run,
            samples: start..end,
            times: &times[start..end],
            loads: (0..n_axes).map(load).collect(),
            data,
        }
    };
    let long = starts.zip(ends).filter(|(start, end)| end - start > 2 * MARGIN);
    long.map(piece).collect()
}

fn mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (n, sum) = values.fold((0.0, 0.0), |(n, sum), value| (n + 1.0, sum + value * value));
    if n > 0.0 { sum / n } else { 0.0 }
}

fn variance(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    mean_square(values.iter().map(|value| value - mean))
}

/// Returns the half width of the widest smoothing window that hardly changes the load, in samples.
fn half_width(pieces: &[Piece<'_>]) -> usize {
    const LOOKED_AT: usize = 4000;
    let loads = || pieces.iter().flat_map(|piece| &piece.loads);
    let moving: Vec<(&Vec<f64>, f64, f64)> = loads()
        .map(|load| (load, variance(load), noise(load)))
        .filter(|(load, variance, _)| *variance > 0.0 && load.len() > 8 * NARROWEST)
        .collect();
    let largest = moving.iter().map(|(_, variance, _)| *variance).fold(0.0, f64::max);
    let fits = |half: usize| {
        let window = Window::new(half, 1);
        let kept = 1.0 - 2.0 * window.weights[half] + window.gain().powi(2);
        moving.iter().filter(|(_, variance, _)| *variance > 1e-3 * largest).all(
            |(load, variance, noise)| {
                let hop = (load.len() / LOOKED_AT).max(1);
                let centres = load.windows(2 * half + 1).step_by(hop);
                let change = mean_square(centres.map(|near| near[half] - window.mean(near)));
                let by_load = change - kept * noise * noise;
                load.len() > 8 * half && by_load < MOST_SMOOTHED.powi(2) * variance
            },
        )
    };
    let mut half = NARROWEST;
    loop {
        let wider = half + half.div_ceil(2);
        if wider > WIDEST || !fits(wider) {
            return half;
        }
        half = wider;
    }
}

/// Returns the time scale of the load over all axes together (s); `None` if no load changes.
fn slow_secs(pieces: &[Piece<'_>], window: &Window) -> Option<f64> {
    let (mut size, mut rate) = (0.0, 0.0);
    for piece in pieces {
        let times = window.thinned(piece.times);
        for load in &piece.loads {
            let load = window.thinned(load);
            size += variance(&load) * load.len() as f64;
            let steps = load.windows(2).zip(times.windows(2));
            let rates = steps.map(|(load, time)| (load[1] - load[0]) / (time[1] - time[0]));
            rate += mean_square(rates) * load.len() as f64;
        }
    }
    (rate > 0.0 && size > 0.0).then(|| (size / rate).sqrt())
}

/// Returns the inputs of the play operators. Each is given by one factor for the load of each axis.
fn drivers(pieces: &[Piece<'_>], n_axes: usize, by: Drivers) -> Vec<Vec<f64>> {
    let unit = |axis: usize| (0..n_axes).map(|other| f64::from(u8::from(other == axis))).collect();
    let n_gauges = pieces[0].data.n_gauges();
    if by == Drivers::Axes {
        return (0..n_axes).map(unit).collect();
    }
    let n: usize = pieces.iter().map(|piece| piece.times.len()).sum();
    let hop = (n / MOST_ROWS).max(1);
    let rows: Vec<(&Piece<'_>, usize)> = (pieces.iter())
        .flat_map(|piece| (0..piece.times.len()).step_by(hop).map(move |k| (piece, k)))
        .collect();
    let loads = Mat::from_fn(rows.len(), n_axes + 1, |row, axis| {
        let (piece, k) = rows[row];
        piece.loads.get(axis).map_or(1.0, |load| load[k])
    });
    let gauges = Mat::from_fn(rows.len(), n_gauges, |row, gauge| {
        let (piece, k) = rows[row];
        piece.data.gauges[(piece.samples.start + k) * n_gauges + gauge]
    });
    let solved = loads.col_piv_qr().solve_lstsq(&gauges);
    let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
    let strain = |gauge| (0..n_axes).map(|axis| finite(solved[(axis, gauge)])).collect();
    (0..n_gauges).map(strain).collect()
}

/// Returns the range and the noise of the strain of one gauge. `driver` holds the strain for a unit load on each axis.
fn range_and_noise(pieces: &[Piece<'_>], driver: &[f64]) -> (MinMax, f64) {
    const BLOCK: usize = 4096;
    let range = pieces.iter().flat_map(|piece| {
        let n = piece.times.len();
        let starts = (0..n).step_by(BLOCK);
        starts.map(move |start| -> MinMax {
            piece.strain(driver, start..n.min(start + BLOCK)).iter().collect()
        })
    });
    let noise = median(pieces.iter().map(|piece| {
        noise_by(piece.times.len(), |k| [k, k + 1, k + 2].map(|k| piece.strain_at(driver, k)))
    }));
    (range.collect(), noise.unwrap_or(0.0))
}
