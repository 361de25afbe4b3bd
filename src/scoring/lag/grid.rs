//! Regression columns for measuring the time lag between reference and outputs: smoothed and thinned loads, with terms for
//! hysteresis, creep and curvature.
//!
//! Guarantees: reference and outputs are smoothed by the same symmetric window, so neither is shifted in time. No row is
//! computed from samples on both sides of a pause.

use std::f64::consts::PI;
use std::ops::Range;

use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

use super::kind::{LagKind, Late};
use super::{LagRun, NoLag};
use crate::{
    dot::dot,
    min_max::MinMax,
    recording::{
        gap::{median_step, pause_by_step},
        median::{median, white_noise as noise},
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
/// Minimum ratio of a step of the load to the mean of its two neighbouring steps for it to count as a jump. Jumps are not
/// used, because their time between two samples is unknown.
const JUMP: f64 = 4.0;
const JUMP_IN_NOISE: f64 = 8.0;
/// Number of samples before and after a jump that are not used.
pub(super) const AROUND_JUMP: usize = 30;

/// Rows of the regression from an interval without a gap in the sample times, or from a part of the interval.
pub(super) struct Grid {
    pub(super) run: usize,
    pub(super) times: Vec<f64>,
    /// Position of each row in its recording, from 0 (start) to 1 (end).
    pub(super) places: Vec<f64>,
    /// True for each row that the fit uses.
    pub(super) used: Vec<bool>,
    /// Share of the jumps in the sum of the reference's squared steps, on the axis where this share is largest.
    pub(super) jumps: f64,
    /// Columns of the regression, in this order: loads, terms of hysteresis and curvature, terms of slow creep, a constant,
    /// terms of quick creep.
    pub(super) columns: Vec<Vec<f64>>,
    pub(super) outputs: Vec<Vec<f64>>,
}

/// Inputs of the play operators that describe hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drivers {
    /// Load of each axis, to describe friction and backlash of the structure.
    Axes,
    /// Strain of each gauge, which is a mixture of the loads, to describe hysteresis of a gauge or of its mounting place.
    Gauges,
}

/// Rows of the regression from all recordings.
pub(super) struct Grids {
    pub(super) parts: Vec<Grid>,
    pub(super) n_axes: usize,
    /// Number of columns before the terms of quick creep.
    pub(super) n_usual: usize,
    /// True for each column that is left out when hysteresis is described with fewer radii.
    pub(super) finer: Vec<bool>,
    /// Median time between samples (s).
    pub(super) step_secs: f64,
    /// Time scale of the load (s): its standard deviation divided by the root mean square of its rate.
    pub(super) slow_secs: f64,
}

/// Interval of a recording without pause.
struct Piece<'a> {
    run: usize,
    n_run: usize,
    samples: Range<usize>,
    times: &'a [f64],
    loads: Vec<Vec<f64>>,
    data: &'a LagRun<'a>,
}

impl Grids {
    pub(super) fn of(runs: &[LagRun<'_>], driven_by: Drivers) -> Result<Self, NoLag> {
        let n_axes = runs.first().map_or(0, |run| run.n_axes());
        let steps = runs.iter().filter_map(|run| median_step(run.times));
        let step_secs = median(steps).ok_or(NoLag::TooShort)?;
        let whole: Vec<Piece<'_>> =
            runs.iter().enumerate().flat_map(|(at, run)| pieces(at, run)).collect();
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
        let drivers = drivers(&pieces, n_axes, driven_by);
        let slow_secs = slow_secs(&pieces, &window).ok_or(NoLag::ConstantLoad)?;
        let longest = pieces.iter().map(|piece| piece.secs()).fold(0.0, f64::max);
        let mut creep = CREEP.map(|factor| factor * slow_secs).to_vec();
        creep.retain(|tau| *tau < 0.5 * longest);
        let creep = [&creep[..], &[QUICK_CREEP * slow_secs]];
        let scale: Vec<_> = drivers.iter().map(|driver| range_and_noise(&pieces, driver)).collect();
        let parts: Vec<Grid> = (pieces.iter())
            .flat_map(|piece| {
                piece.grids(&piece.parts(share, shortest), &window, &drivers, &scale, creep)
            })
            .collect();
        let per_driver = RADII.len() + 2;
        let finer = |column: usize| {
            let at = column.checked_sub(n_axes).filter(|at| *at < drivers.len() * per_driver);
            at.map(|at| at % per_driver).is_some_and(|at| at < RADII.len() && at % 2 == 1)
        };
        let finer = (0..parts[0].columns.len()).map(finer).collect();
        let n_usual = parts[0].columns.len() - n_axes;
        Ok(Self { parts, n_axes, n_usual, finer, step_secs, slow_secs })
    }

    /// Returns true if the reference load jumps anywhere in the rows.
    pub(super) fn jumps(&self) -> bool {
        self.parts.iter().any(|part| part.jumps > 0.0)
    }

    /// Returns true if the load mostly moves in jumps. They then make up more than half of the sum of squared steps, on
    /// average over the intervals.
    pub(super) fn moves_in_jumps(&self) -> bool {
        let shares = self.parts.iter().map(|part| part.jumps);
        shares.sum::<f64>() > 0.5 * self.parts.len() as f64
    }
}

impl Drivers {
    /// Returns the inputs of the play operators that are worth trying: gauge strains only if there are several axes and few
    /// gauges.
    pub(super) fn sensible(run: &LagRun<'_>) -> &'static [Self] {
        match run.n_axes() > 1 && (1..=MOST_DRIVERS).contains(&run.n_gauges()) {
            true => &[Self::Axes, Self::Gauges],
            false => &[Self::Axes],
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
    fn strain(&self, driver: &[f64]) -> Vec<f64> {
        let mut strain = vec![0.0; self.times.len()];
        for (share, load) in driver.iter().zip(&self.loads) {
            strain.iter_mut().zip(load).for_each(|(strain, load)| *strain += share * load);
        }
        strain
    }

    /// Returns the rows of each part. Play operators and creep are computed from the start of the interval.
    fn grids(
        &self,
        parts: &[Range<usize>],
        window: &Window,
        drivers: &[Vec<f64>],
        scale: &[(MinMax, f64)],
        [slow, quick]: [&[f64]; 2],
    ) -> Vec<Grid> {
        let mut grids: Vec<Grid> = parts.iter().map(|part| self.bare_grid(part, window)).collect();
        let mut push = |column: &dyn Fn(usize, Range<usize>) -> Vec<f64>| {
            for (at, (grid, part)) in grids.iter_mut().zip(parts).enumerate() {
                grid.columns.push(window.thinned(&column(at, part.clone())));
            }
        };
        self.loads.iter().for_each(|load| push(&|_, part| load[part].to_vec()));
        for (driver, (MinMax { min, max }, noise)) in drivers.iter().zip(scale) {
            let (half, middle) = (0.5 * (max - min), 0.5 * (max + min));
            let strain: Vec<f64> = self.strain(driver).iter().map(|own| own - middle).collect();
            // Only noisy strains are smoothed, because smoothing lowers the peaks at which play operators reverse.
            let is_noisy = RADIUS_IN_NOISE * noise > SMALLEST_RADIUS * half;
            let strain = if is_noisy { window.smoothed(&strain) } else { strain };
            let floor = (SMALLEST_RADIUS * half).max(RADIUS_IN_NOISE * noise * window.gain());
            let beside = beside_play(&strain, RADII.map(|radius| floor.max(radius * half)), parts);
            (0..RADII.len()).for_each(|radius| push(&|at, _| beside[at][radius].clone()));
            for power in [2, 3] {
                push(&|_, part| strain[part].iter().map(|own| own.powi(power)).collect());
            }
        }
        for (is_quick, taus) in [(false, slow), (true, quick)] {
            if is_quick {
                push(&|_, part| vec![1.0; part.len()]);
            }
            for tau in taus {
                let late = Late::of(LagKind::FirstOrder, self.times, *tau);
                for load in &self.loads {
                    let crept = late.of_values(load);
                    push(&|_, part| crept[part].to_vec());
                }
            }
        }
        grids
    }

    /// Returns the times, positions and outputs of a part of the interval, still without columns.
    fn bare_grid(&self, part: &Range<usize>, window: &Window) -> Grid {
        let n_outputs = self.data.n_outputs();
        let start = self.samples.start + part.start;
        let output = |at: usize| {
            let rows = self.data.outputs.chunks_exact(n_outputs).skip(start).take(part.len());
            window.thinned(&rows.map(|row| row[at]).collect::<Vec<_>>())
        };
        let times = window.thinned(&self.times[part.clone()]);
        let place =
            |row: usize| (start + window.half + row * window.hop) as f64 / self.n_run as f64;
        let (used, jumps) = self.used(part, window, times.len());
        Grid {
            run: self.run,
            places: (0..times.len()).map(place).collect(),
            used,
            jumps,
            columns: Vec::new(),
            outputs: (0..n_outputs).map(output).collect(),
            times,
        }
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
pub(super) struct Window {
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
        dot(&self.weights, values)
    }

    fn thinned(&self, values: &[f64]) -> Vec<f64> {
        values.windows(2 * self.half + 1).step_by(self.hop).map(|own| self.mean(own)).collect()
    }

    /// Smooths a signal without thinning. Beyond its two ends, the signal is continued by point reflection at the end point.
    fn smoothed(&self, values: &[f64]) -> Vec<f64> {
        let last = values.len() - 1;
        let before = (1..=self.half).rev().map(|k| 2.0 * values[0] - values[k.min(last)]);
        let after = (1..=self.half).map(|k| 2.0 * values[last] - values[last.saturating_sub(k)]);
        let padded: Vec<f64> = before.chain(values.iter().copied()).chain(after).collect();
        padded.windows(2 * self.half + 1).map(|own| self.mean(own)).collect()
    }
}

/// Returns for each part and each radius the load minus the output of a play operator that starts at the first load. The parts
/// must be in order and must not overlap.
fn beside_play<const N: usize>(
    load: &[f64],
    radii: [f64; N],
    parts: &[Range<usize>],
) -> Vec<[Vec<f64>; N]> {
    let mut beside: Vec<[Vec<f64>; N]> =
        parts.iter().map(|part| [(); N].map(|()| Vec::with_capacity(part.len()))).collect();
    let mut states = [load[0]; N];
    let mut next = 0;
    vectorised(
        #[inline(always)]
        || {
            for (part, beside) in parts.iter().zip(&mut beside) {
                for (k, load) in load[..part.end].iter().enumerate().skip(next) {
                    for (state, radius) in states.iter_mut().zip(&radii) {
                        *state = state.max(load - radius).min(load + radius);
                    }
                    if k >= part.start {
                        for (beside, state) in beside.iter_mut().zip(&states) {
                            beside.push(load - state);
                        }
                    }
                }
                next = part.end;
            }
        },
    );
    beside
}

/// Cuts a recording into intervals where samples are missing or times repeat.
fn pieces<'a>(run: usize, data: &'a LagRun<'a>) -> Vec<Piece<'a>> {
    let times = data.times;
    let pause = median_step(times).map_or(0.0, pause_by_step);
    let is_cut = |k: &usize| {
        let step = times[*k] - times[*k - 1];
        step > pause || step <= 0.0
    };
    let cuts: Vec<usize> = (1..times.len()).filter(is_cut).collect();
    let starts = std::iter::once(0).chain(cuts.iter().copied());
    let ends = cuts.iter().copied().chain([times.len()]);
    let n_axes = data.n_axes();
    let piece = |(start, end): (usize, usize)| {
        let load = |axis: usize| {
            let rows = data.loads[start * n_axes..end * n_axes].chunks_exact(n_axes);
            rows.map(|row| row[axis]).collect()
        };
        Piece {
            run,
            n_run: times.len(),
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
                let change = mean_square(centres.map(|own| own[half] - window.mean(own)));
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
    let unit = |axis: usize| (0..n_axes).map(|own| f64::from(u8::from(own == axis))).collect();
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
    let finite = |own: f64| if own.is_finite() { own } else { 0.0 };
    let strain = |gauge| (0..n_axes).map(|axis| finite(solved[(axis, gauge)])).collect();
    (0..n_gauges).map(strain).collect()
}

fn range_and_noise(pieces: &[Piece<'_>], driver: &[f64]) -> (MinMax, f64) {
    let strains: Vec<Vec<f64>> = pieces.iter().map(|piece| piece.strain(driver)).collect();
    let noise = median(strains.iter().map(|strain| noise(strain))).unwrap_or(0.0);
    (strains.iter().flatten().collect(), noise)
}
