//! Faults of a rig as corrections: each is refitted, and named only where the error that is left out becomes smaller with it by an amount
//! that matters and that chance does not make.

use faer::Mat;
use faer::linalg::solvers::Solve as _;
use rayon::prelude::*;

use crate::recording::Axis;
use crate::scoring::rig::fits::{self, Forward, Shape};
use crate::scoring::rig::{Rig, Unit, chance};

/// A correction is named where it leaves this share of the left-out error at most. Of a fault that adds a quarter the true
/// correction leaves 0.8, and an estimated one up to a twentieth more.
const MATTERS: f64 = 0.84;
/// Smallest change of the load by a tare, as a share of the change that takes as much off the error as matters. An estimated
/// change is smaller by chance.
const SHIFT: f64 = 0.8;
/// Share of full scale that the left-out error must fall by, too: one step of a reference with 16 bits.
const FALLS: f64 = 1.5e-5;
/// Chance that one of all corrections that are tried is found in units that have no fault.
const BY_CHANCE: f64 = 0.005;
/// The same over whole recordings, where there are enough to tell how far sound ones differ.
const BY_CHANCE_OF_RUNS: f64 = 0.1;
/// Fewest runs for that.
const ENOUGH_RUNS: usize = 4;
/// Corrections that explain most by one step, which are refitted and left out.
const REFITTED: usize = 40;
/// Steps of a refit.
const STEPS: usize = 6;
/// Weight of a parameter against a smaller error: half the logarithm of the number of units, over twice that number.
const PARAMETER: f64 = 0.033;
/// Ratio of the noise of a gauge in one run to that in every other. Of four runs that one makes the error a quarter larger, its mean square is
/// 3.25 times as large, and the noise, which is a part of it, more than that.
const NOISIER: f64 = 1.8;
/// How much of an exchange of two columns is found, where it is one.
const EXCHANGED: std::ops::RangeInclusive<f64> = 0.7..=1.3;

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The zeros of the gauges differ.
    Tare,
    /// The zeros of the gauges follow the time.
    Drift,
    /// One gauge has another sensitivity.
    Gauge(usize),
    /// All gauges have another sensitivity by one factor, or the reference another scale.
    AllGauges,
    /// These axes of the reference, by their positions among those that move, have another scale.
    Axes(Vec<usize>),
    /// The frame of the reference is turned.
    Rotation,
    /// The columns of two gauges are exchanged.
    SwappedGauges(usize, usize),
    /// The columns of two axes are exchanged.
    SwappedAxes(usize, usize),
    /// These gauges have more noise.
    Noise(Vec<usize>),
    /// It contradicts the others without a pattern.
    Unlike,
}

/// Where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Where {
    /// From a run on, against those before it.
    From(usize),
    /// In one run.
    One(usize),
    /// In all of them.
    All,
}

/// A fault that explains what contradicts the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// What is wrong.
    pub cause: Cause,
    /// Where it is.
    pub place: Where,
    /// A factor of the sensitivity or of the reference's scale, or an angle (rad); with a tare or a drift the change of each load by it,
    /// as a share of full scale.
    pub values: Vec<f64>,
    /// Left-out error with the fault, as a share of full scale.
    pub with: f64,
    /// Left-out error once it is corrected.
    pub without: f64,
}

/// How a run's sums are corrected: `gauge ← (gauge − shift) / gain`, `load ← turn · load`.
#[derive(Clone, Debug)]
struct Correction {
    shift: Vec<f64>,
    gain: Vec<f64>,
    swap: Option<(usize, usize)>,
    turn: Mat<f64>,
}

/// What is tried of one set of runs.
struct Trial {
    place: Where,
    is_here: Vec<bool>,
    cause: Cause,
    /// Sum of squares over variance that one step explains.
    gain: f64,
}

/// A refitted trial.
struct Refit {
    trial: usize,
    parameters: f64,
    values: Vec<f64>,
    error: f64,
    /// Chance over units, and over runs.
    chances: [f64; 2],
}

/// Zeros of the gauges that have another sensitivity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Zeros {
    /// As those of the others: the gain was set about the zero, or the reference is wrong.
    Kept,
    /// Any, since the recording was tared anew.
    Free,
    /// The raw signal times the gain, zero included.
    Scaled,
}

/// Sums about a mean of one side: of loads, and of what the fit leaves of gauges with loads.
struct Moments {
    loads: Mat<f64>,
    rest: Mat<f64>,
}

impl Rig {
    /// The one fault that explains most of what is left out, if one does.
    pub fn contradiction(&self) -> Option<Contradiction> {
        let errors = fits::left_out(&self.units, &self.shape, true, false);
        let with = fits::mean_error(&errors, &self.units, |_| true);
        let places = self.places();
        let trials: Vec<Trial> =
            places.par_iter().flat_map_iter(|place| self.trials(*place)).collect();
        let n_tried = trials.len() + 1;
        let mut order: Vec<usize> = (0..trials.len()).collect();
        order.sort_by(|a, b| trials[*b].gain.total_cmp(&trials[*a].gain));
        order.truncate(REFITTED);
        let refits = order.par_iter().flat_map_iter(|at| {
            let zeros: &[Zeros] = match trials[*at].cause {
                Cause::Tare | Cause::SwappedGauges(..) | Cause::SwappedAxes(..) => &[Zeros::Free],
                Cause::Gauge(_) | Cause::AllGauges => &[Zeros::Kept, Zeros::Free, Zeros::Scaled],
                _ => &[Zeros::Kept, Zeros::Free],
            };
            zeros.iter().filter_map(|zeros| self.refit(&trials, *at, *zeros)).collect::<Vec<_>>()
        });
        let mut refits: Vec<Refit> = refits.collect();
        refits.push(self.drift(trials.len()));
        let is_shift = |own: &Refit| {
            let trial = trials.get(own.trial).filter(|trial| trial.cause == Cause::Tare);
            let squares: f64 = own.values.iter().map(|value| value * value).sum();
            let shift = (squares / own.values.len() as f64).sqrt();
            trial.is_none_or(|trial| shift > self.smallest_shift(&trial.is_here) * own.error)
        };
        let is_found = |own: &&Refit| {
            let of_runs = if own.trial < trials.len() { places.len() } else { 1 };
            matters(with, own.error)
                && is_shift(own)
                && own.chances[0] < BY_CHANCE / n_tried as f64
                && own.chances[1] < BY_CHANCE_OF_RUNS / of_runs as f64
        };
        let score =
            |own: &Refit| own.error.max(f64::MIN_POSITIVE).ln() + PARAMETER * own.parameters;
        let best = refits.iter().filter(is_found).min_by(|a, b| score(a).total_cmp(&score(b)));
        match best {
            Some(own) => {
                let trial = trials.get(own.trial);
                Some(Contradiction {
                    cause: trial.map_or(Cause::Drift, |trial| trial.cause.clone()),
                    place: trial.map_or(Where::All, |trial| trial.place),
                    values: own.values.clone(),
                    with,
                    without: own.error,
                })
            }
            None => self.noisy(with).or_else(|| self.unlike(&errors, with)),
        }
    }

    /// Every way in which some runs can differ from the others: from one on, or one alone.
    fn places(&self) -> Vec<Where> {
        let n = self.n_runs();
        let alone = if n > 2 { 1..n.saturating_sub(1) } else { 0..0 };
        (1..n).map(Where::From).chain(alone.map(Where::One)).collect()
    }

    /// The runs that are corrected: the fewer.
    fn corrected(&self, place: Where) -> (Vec<bool>, bool) {
        let n = self.n_runs();
        let is_in = |run: usize| match place {
            Where::From(first) if 2 * (n - first) <= n => run >= first,
            Where::From(first) => run < first,
            Where::One(own) => run == own,
            Where::All => true,
        };
        let is_before = matches!(place, Where::From(first) if 2 * (n - first) > n);
        (self.units.iter().map(|unit| is_in(unit.run)).collect(), is_before)
    }

    fn side(&self, units: &[Unit], is_here: &[bool], side: bool) -> Mat<f64> {
        let own = units.iter().zip(is_here).filter(|(_, here)| **here == side);
        fits::sum(own.map(|(own, _)| own), &self.shape)
    }

    /// The fit to those that are not corrected; what they don't load it takes from the others.
    fn first_fit(&self, others: &Mat<f64>, own: &Mat<f64>) -> Forward {
        let shape = &self.shape;
        let loads = |sums: &Mat<f64>| -> f64 {
            (0..shape.axes.len()).map(|axis| sums[(shape.load(axis), shape.load(axis))]).sum()
        };
        let share = 1e-6 * loads(others) / loads(own).max(f64::MIN_POSITIVE);
        Forward::of(&(others + faer::Scale(share) * own), shape)
    }

    fn trials(&self, place: Where) -> Vec<Trial> {
        let shape = &self.shape;
        let (is_here, _) = self.corrected(place);
        let [own, others] = [true, false].map(|side| self.side(&self.units, &is_here, side));
        // Fewer load cases than coefficients follow any correction.
        if own[(0, 0)] < (shape.n_gauges + 2) as f64 {
            return Vec::new();
        }
        let fit = self.first_fit(&others, &own);
        let variances = fit.variances(&others, shape);
        let mean = column_means(&own);
        let moments = Moments::about(&own, &mean, &fit, shape);
        let trial =
            |cause: Cause, gain: f64| Trial { place, is_here: is_here.clone(), cause, gain };
        let n = own[(0, 0)] * others[(0, 0)] / (own[(0, 0)] + others[(0, 0)]);
        let zeros = fit.zeros(&own, shape);
        let explained: f64 =
            zeros.iter().zip(&variances).map(|(zero, variance)| n * zero * zero / variance).sum();
        let mut all = vec![trial(Cause::Tare, explained)];
        for cause in self.causes() {
            let Some((step, gain)) = moments.step(&self.ways(&cause, &fit), &variances) else {
                continue;
            };
            let scaled = self.scaled_gauges(&cause);
            let gain = gain.max(self.scaled_step(&own, &fit, &scaled, &variances).gain());
            let is_swap = matches!(cause, Cause::SwappedGauges(..) | Cause::SwappedAxes(..));
            if !is_swap || EXCHANGED.contains(&step[0]) {
                all.push(trial(cause, gain));
            }
        }
        all
    }

    /// The gauges whose raw signal a cause may multiply; none where a zero is larger than the range, since a tare looks the same then.
    fn scaled_gauges(&self, cause: &Cause) -> Vec<usize> {
        let gauges: Vec<usize> = match cause {
            Cause::Gauge(gauge) => vec![*gauge],
            Cause::AllGauges => (0..self.shape.n_gauges).collect(),
            _ => Vec::new(),
        };
        let is_large = |gauge: &usize| {
            let (mean, scale) = self.scales[*gauge];
            (mean / scale).abs() > self.spans[*gauge]
        };
        if gauges.iter().any(is_large) { Vec::new() } else { gauges }
    }

    /// By which share the raw signals of some gauges are larger than the fit says.
    fn scaled_step(
        &self,
        sums: &Mat<f64>,
        fit: &Forward,
        gauges: &[usize],
        variances: &[f64],
    ) -> ScaledStep {
        let shape = &self.shape;
        let mut all = ScaledStep::default();
        for &gauge in gauges {
            let offset = self.scales[gauge].0 / self.scales[gauge].1;
            // The fitted signal about its raw zero, and what is left of the gauge.
            let mut signal = vec![0.0; shape.width()];
            signal[0] = fit.zero[gauge] + offset;
            for axis in 0..shape.axes.len() {
                signal[shape.load(axis)] = fit.slopes[(gauge, axis)];
            }
            let mut rest: Vec<f64> = signal.iter().map(|own| -own).collect();
            rest[0] += offset;
            rest[shape.gauge(gauge)] = 1.0;
            let along = |other: &[f64]| -> f64 {
                let row =
                    |i: usize| -> f64 { (0..other.len()).map(|j| sums[(i, j)] * other[j]).sum() };
                let parts = (0..signal.len()).filter(|i| signal[*i] != 0.0);
                parts.map(|i| signal[i] * row(i)).sum()
            };
            all.weight += along(&signal) / variances[gauge];
            all.product += along(&rest) / variances[gauge];
        }
        all
    }

    fn causes(&self) -> Vec<Cause> {
        let (n_gauges, axes) = (self.shape.n_gauges, &self.shape.axes);
        let n_axes = axes.len();
        let pairs = |n: usize| (0..n).flat_map(move |a| (a + 1..n).map(move |b| (a, b)));
        let mut all: Vec<Cause> = (0..n_gauges).map(Cause::Gauge).collect();
        if n_gauges > 1 {
            all.push(Cause::AllGauges);
        }
        all.extend(pairs(n_gauges).map(|(a, b)| Cause::SwappedGauges(a, b)));
        if n_axes > 1 {
            all.extend((0..n_axes).map(|axis| Cause::Axes(vec![axis])));
            for force in [true, false] {
                let own: Vec<usize> =
                    (0..n_axes).filter(|axis| axes[*axis].is_force() == force).collect();
                if own.len() > 1 && own.len() < n_axes {
                    all.push(Cause::Axes(own));
                }
            }
            all.extend(pairs(n_axes).map(|(a, b)| Cause::SwappedAxes(a, b)));
        }
        if !turns(axes).is_empty() {
            all.push(Cause::Rotation);
        }
        all
    }

    /// How what the gauges show changes with each parameter of a cause, by load.
    fn ways(&self, cause: &Cause, fit: &Forward) -> Vec<Mat<f64>> {
        let shape = &self.shape;
        let (n, m) = (shape.n_gauges, shape.axes.len());
        let slope = |gauge: usize, axis: usize| fit.slopes[(gauge, axis)];
        let of = |factor: &dyn Fn(usize, usize) -> f64| Mat::from_fn(n, m, factor);
        match cause {
            Cause::Gauge(own) => {
                vec![of(&|gauge, axis| if gauge == *own { slope(gauge, axis) } else { 0.0 })]
            }
            Cause::AllGauges => vec![fit.slopes.clone()],
            Cause::Axes(own) => {
                vec![of(&|gauge, axis| if own.contains(&axis) { slope(gauge, axis) } else { 0.0 })]
            }
            Cause::Rotation => {
                let turned = turns(&shape.axes).into_iter();
                turned.map(|about| &fit.slopes * generator(shape, about)).collect()
            }
            Cause::SwappedGauges(a, b) => vec![of(&|gauge, axis| {
                let other = match gauge {
                    own if own == *a => *b,
                    own if own == *b => *a,
                    _ => return 0.0,
                };
                slope(other, axis) * self.scales[other].1 / self.scales[gauge].1
                    - slope(gauge, axis)
            })],
            Cause::SwappedAxes(a, b) => {
                let turn = exchanged(shape, *a, *b);
                vec![&fit.slopes * turn - &fit.slopes]
            }
            Cause::Tare | Cause::Drift | Cause::Noise(_) | Cause::Unlike => Vec::new(),
        }
    }

    fn refit(&self, trials: &[Trial], at: usize, zeros: Zeros) -> Option<Refit> {
        let Trial { is_here, cause, place, .. } = &trials[at];
        match cause {
            Cause::Tare => Some(self.refit_tare(at, is_here)),
            _ => self.refit_gains(at, is_here, cause, *place, zeros),
        }
    }

    fn refit_tare(&self, trial: usize, is_here: &[bool]) -> Refit {
        let shape = &self.shape;
        let [own, others] = [true, false].map(|side| self.side(&self.units, is_here, side));
        let mut correction = Correction::none(shape);
        let mut fit = self.first_fit(&others, &own);
        for _ in 0..STEPS {
            let zeros = [&own, &others].map(|sums| fit.zeros(sums, shape));
            correction.shift =
                zeros[0].iter().zip(&zeros[1]).map(|(own, other)| own - other).collect();
            fit = Forward::of(&(correction.of(&own, self) + &others), shape);
        }
        let units = self.with(is_here, &correction);
        let back = fits::backward(&fits::sum(units.iter(), shape), shape);
        let (values, weights) = self.zeros_as_loads(&fit, &back);
        Refit {
            trial,
            parameters: shape.axes.len() as f64,
            values: loads_of(&back, &correction.shift),
            error: self.error(&units),
            chances: self.chances(&values, &weights, is_here),
        }
    }

    fn refit_gains(
        &self,
        trial: usize,
        is_here: &[bool],
        cause: &Cause,
        place: Where,
        zeros: Zeros,
    ) -> Option<Refit> {
        let shape = &self.shape;
        let [own, others] = [true, false].map(|side| self.side(&self.units, is_here, side));
        let mut correction = Correction::none(shape);
        let mut fit = self.first_fit(&others, &own);
        let mut variances = fit.variances(&others, shape);
        let (mut factor, mut angles) = (1.0, vec![0.0; turns(&shape.axes).len()]);
        let scaled = self.scaled_gauges(cause);
        let steps = match cause {
            Cause::SwappedGauges(a, b) => {
                correction.swap = Some((*a, *b));
                0
            }
            Cause::SwappedAxes(a, b) => {
                correction.turn = exchanged(shape, *a, *b);
                0
            }
            _ => STEPS,
        };
        for _ in 0..steps {
            let now = correction.of(&own, self);
            let mut step = match zeros {
                Zeros::Scaled => vec![self.scaled_step(&now, &fit, &scaled, &variances).step()?],
                _ => {
                    let is_free = zeros == Zeros::Free;
                    let mean = if is_free { column_means(&now) } else { origin(&fit, shape) };
                    let moments = Moments::about(&now, &mean, &fit, shape);
                    moments.step(&self.ways(cause, &fit), &variances)?.0
                }
            };
            if *cause == Cause::Rotation {
                let length = step.iter().map(|own| own * own).sum::<f64>().sqrt();
                step.iter_mut().for_each(|own| *own *= (0.4 / length).min(1.0));
                angles.iter_mut().zip(&step).for_each(|(all, own)| *all += own);
            } else {
                factor *= 1.0 + step[0];
                if factor.abs() < 1e-4 {
                    return None;
                }
            }
            match zeros {
                Zeros::Scaled => correction.scale(&scaled, factor, &self.scales),
                _ => {
                    correction.take(cause, &step, shape);
                    correction.settle(cause, &fit, &own, shape, zeros == Zeros::Free);
                }
            }
            let all = correction.of(&own, self) + &others;
            fit = Forward::of(&all, shape);
            variances = fit.variances(&all, shape);
        }
        let units = self.with(is_here, &correction);
        let of_units = |units: &[Unit]| {
            self.of_units(units, is_here, &self.ways(cause, &fit), &fit, &variances)
        };
        let (values, weights) = match steps {
            // How much of the exchange the units show before it.
            0 => of_units(&self.units),
            _ => {
                let (mut values, weights) = match zeros {
                    Zeros::Scaled => {
                        let of_unit = |own: &Unit| {
                            let own = self.scaled_step(&own.sums, &fit, &scaled, &variances);
                            (vec![own.step().unwrap_or(0.0)], own.weight)
                        };
                        units.iter().map(of_unit).unzip()
                    }
                    _ => of_units(&units),
                };
                let effect =
                    if *cause == Cause::Rotation { angles.clone() } else { vec![factor - 1.0] };
                for (own, _) in values.iter_mut().zip(is_here).filter(|(_, here)| **here) {
                    own.iter_mut().zip(&effect).for_each(|(value, effect)| *value += effect);
                }
                (values, weights)
            }
        };
        let is_before = self.corrected(place).1;
        let n_zeros = if zeros == Zeros::Free && steps > 0 { shape.axes.len() } else { 0 };
        let own_parameters = if *cause == Cause::Rotation { angles.len() } else { steps.min(1) };
        let turned = angles.iter().map(|own| own * own).sum::<f64>().sqrt();
        Some(Refit {
            trial,
            parameters: (n_zeros + own_parameters) as f64,
            values: match cause {
                Cause::Rotation => vec![turned],
                _ if is_before => vec![1.0 / factor],
                _ => vec![factor],
            },
            error: self.error(&units),
            chances: self.chances(&values, &weights, is_here),
        })
    }

    /// The parameters of a cause that each unit shows beside a fit, and their weights.
    fn of_units(
        &self,
        units: &[Unit],
        is_here: &[bool],
        ways: &[Mat<f64>],
        fit: &Forward,
        variances: &[f64],
    ) -> (Vec<Vec<f64>>, Vec<f64>) {
        let means = [false, true].map(|side| column_means(&self.side(units, is_here, side)));
        let of_unit = |(own, here): (&Unit, &bool)| {
            let moments = Moments::about(&own.sums, &means[usize::from(*here)], fit, &self.shape);
            let weight: f64 = ways.iter().map(|way| moments.square(way, way, variances)).sum();
            let step = moments.step(ways, variances).map(|(step, _)| step);
            let weight = if step.is_some() { weight } else { 0.0 };
            (step.unwrap_or_else(|| vec![0.0; ways.len()]), weight)
        };
        units.iter().zip(is_here).map(of_unit).unzip()
    }

    /// Returns the zeros of each unit beside a fit as loads, and the weights of the units.
    fn zeros_as_loads(&self, fit: &Forward, back: &Mat<f64>) -> (Vec<Vec<f64>>, Vec<f64>) {
        let of_unit =
            |own: &Unit| (loads_of(back, &fit.zeros(&own.sums, &self.shape)), own.sums[(0, 0)]);
        self.units.iter().map(of_unit).unzip()
    }

    /// Zeros that follow the time; left out, each part is predicted by what the others say of the drift.
    fn drift(&self, trial: usize) -> Refit {
        let shape = &self.shape;
        let all = self.total(|_| true);
        let fit = Forward::with_drift(&all, shape);
        let back = fits::backward(&all, shape);
        let (zeros, weights) = self.zeros_as_loads(&fit, &back);
        let times: Vec<f64> =
            self.units.iter().map(|own| own.sums[(0, 1)] / own.sums[(0, 0)]).collect();
        let (run_zeros, run_weights) = self.by_run(&zeros, &weights);
        let whole: Vec<Vec<f64>> = times.iter().map(|own| vec![*own]).collect();
        let run_times: Vec<f64> = self.by_run(&whole, &weights).0.concat();
        let of_units = |with_time: bool| {
            let errors = fits::left_out(&self.units, shape, false, with_time);
            fits::mean_error(&errors, &self.units, |_| true)
        };
        let of_runs = match self.n_runs() >= ENOUGH_RUNS {
            true => chance::of_slope(&run_zeros, &run_weights, &run_times),
            false => 0.0,
        };
        Refit {
            trial,
            parameters: shape.axes.len() as f64,
            values: loads_of(&back, &fit.drift),
            // By units, as no recording alone says how a drift goes on; on the scale of the others' errors.
            error: of_units(true) / of_units(false).max(f64::MIN_POSITIVE) * self.left_out_error(),
            chances: [chance::of_slope(&zeros, &weights, &times), of_runs],
        }
    }

    /// The run that has more noise than each of the others; of fewer than four it says little how much noise is usual.
    fn noisy(&self, with: f64) -> Option<Contradiction> {
        let n = self.n_runs();
        let of_run = |run: usize| {
            let ratio = |gauge: usize| {
                let others = self.noise.iter().enumerate().filter(|(own, _)| *own != run);
                let most = others.map(|(_, own)| own.0[gauge]).fold(0.0, f64::max);
                self.noise[run].0[gauge] / most.max(f64::MIN_POSITIVE)
            };
            let ratios: Vec<f64> = (0..self.shape.n_gauges).map(ratio).collect();
            let gauges: Vec<usize> =
                (0..ratios.len()).filter(|gauge| ratios[*gauge] > NOISIER).collect();
            let largest = ratios.into_iter().fold(0.0, f64::max);
            let without = if gauges.is_empty() { with } else { self.error_without(run) };
            let is_static = self.noise[run].1;
            matters(with, without).then(|| Contradiction {
                cause: if is_static { Cause::Unlike } else { Cause::Noise(gauges) },
                place: Where::One(run),
                values: vec![largest],
                with,
                without,
            })
        };
        if n < ENOUGH_RUNS { None } else { (0..n).find_map(of_run) }
    }

    /// Left-out error without one run.
    fn error_without(&self, run: usize) -> f64 {
        let others = self.units.iter().filter(|unit| unit.run != run);
        let others = others
            .map(|own| Unit { run: own.run - usize::from(own.run > run), sums: own.sums.clone() });
        self.error(&others.collect::<Vec<_>>())
    }

    /// The run whose error is out of line with the others, though its loads are not; of fewer than four nobody can say which.
    fn unlike(&self, errors: &[f64], with: f64) -> Option<Contradiction> {
        let n = self.n_runs();
        if n < 4 {
            return None;
        }
        let error = |run: usize| fits::mean_error(errors, &self.units, |own| own == run);
        let worst = (0..n).max_by(|a, b| error(*a).total_cmp(&error(*b)))?;
        let logarithms = |errors: Vec<f64>| -> Vec<Vec<f64>> {
            errors.into_iter().map(|own| vec![own.max(1e-30).ln()]).collect()
        };
        let of_units =
            errors.iter().zip(&self.units).map(|(error, unit)| error / unit.sums[(0, 0)]);
        let is_here: Vec<bool> = self.units.iter().map(|unit| unit.run == worst).collect();
        let of_units = chance::of_difference(
            &logarithms(of_units.collect()),
            &vec![1.0; self.units.len()],
            &is_here,
        );
        let is_worst: Vec<bool> = (0..n).map(|run| run == worst).collect();
        let of_runs = chance::of_difference(
            &logarithms((0..n).map(error).collect()),
            &vec![1.0; n],
            &is_worst,
        );
        let without = self.error_without(worst);
        // Loads that the others do not reach are predicted by an extrapolation.
        let reach = |wanted: bool| {
            let sums = self.total(|run| (run == worst) == wanted);
            let squares = (0..self.shape.axes.len())
                .map(|axis| sums[(self.shape.load(axis), self.shape.load(axis))] / sums[(0, 0)]);
            squares.collect::<Vec<f64>>()
        };
        let is_inside =
            reach(true).iter().zip(reach(false)).all(|(own, others)| *own <= 2.0 * others);
        let is_found = matters(with, without)
            && of_units < BY_CHANCE / n as f64
            && of_runs < BY_CHANCE_OF_RUNS / n as f64
            && is_inside;
        is_found.then(|| Contradiction {
            cause: Cause::Unlike,
            place: Where::One(worst),
            values: Vec::new(),
            with,
            without,
        })
    }

    /// Left-out error over all axes, as a share of full scale.
    pub fn left_out_error(&self) -> f64 {
        self.error(&self.units)
    }

    fn error(&self, units: &[Unit]) -> f64 {
        let errors = fits::left_out(units, &self.shape, true, false);
        fits::mean_error(&errors, units, |_| true)
    }

    fn with(&self, is_here: &[bool], correction: &Correction) -> Vec<Unit> {
        let corrected = |(own, here): (&Unit, &bool)| match here {
            true => Unit { run: own.run, sums: correction.of(&own.sums, self) },
            false => own.clone(),
        };
        self.units.iter().zip(is_here).map(corrected).collect()
    }

    /// Means over the units of each run.
    fn by_run(&self, values: &[Vec<f64>], weights: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let width = values.first().map_or(0, Vec::len);
        let of_run = |run: usize| {
            let own = || (0..values.len()).filter(|at| self.units[*at].run == run);
            let weight: f64 = own().map(|at| weights[at]).sum();
            let mean = |i: usize| {
                own().map(|at| weights[at] * values[at][i]).sum::<f64>()
                    / weight.max(f64::MIN_POSITIVE)
            };
            ((0..width).map(mean).collect(), weight)
        };
        (0..self.n_runs()).map(of_run).unzip()
    }

    /// Returns for each run whether it has such units.
    fn runs_here(&self, is_here: &[bool]) -> Vec<bool> {
        let of_run =
            |run| self.units.iter().zip(is_here).any(|(unit, here)| unit.run == run && *here);
        (0..self.n_runs()).map(of_run).collect()
    }

    /// Returns the smallest change of the load by a tare that is named, over the error that is left without it. Where `n` parts
    /// are left out in turn and `m` have the tare, a change adds `m (n − m) / (n − 1)²` of its square.
    fn smallest_shift(&self, is_here: &[bool]) -> f64 {
        let parts = match self.n_runs() < fits::FEWEST_RUNS {
            true => is_here.to_vec(),
            false => self.runs_here(is_here),
        };
        let (n, m) = (parts.len() as f64, parts.iter().filter(|here| **here).count() as f64);
        let added = m * (n - m) / (n - 1.0).powi(2);
        ((MATTERS.powi(-2) - 1.0) / added).sqrt() * SHIFT
    }

    fn chances(&self, values: &[Vec<f64>], weights: &[f64], is_here: &[bool]) -> [f64; 2] {
        let of_units = chance::of_difference(values, weights, is_here);
        if self.n_runs() < ENOUGH_RUNS {
            return [of_units, 0.0];
        }
        let (values, weights) = self.by_run(values, weights);
        [of_units, chance::of_difference(&values, &weights, &self.runs_here(is_here))]
    }
}

/// Sums over samples: the fitted raw signal squared, and times what is left, each over the variance of its gauge.
#[derive(Clone, Copy, Debug, Default)]
struct ScaledStep {
    weight: f64,
    product: f64,
}

impl ScaledStep {
    fn step(self) -> Option<f64> {
        (self.weight > 0.0).then(|| self.product / self.weight)
    }

    /// Sum of squares over variance that the step explains.
    fn gain(self) -> f64 {
        self.step().map_or(0.0, |step| step * self.product)
    }
}

impl Correction {
    fn none(shape: &Shape) -> Self {
        let n_axes = shape.axes.len();
        Self {
            shift: vec![0.0; shape.n_gauges],
            gain: vec![1.0; shape.n_gauges],
            swap: None,
            turn: Mat::identity(n_axes, n_axes),
        }
    }

    /// One more step of a cause.
    fn take(&mut self, cause: &Cause, step: &[f64], shape: &Shape) {
        let n_axes = shape.axes.len();
        let mut scale = |axes: &mut dyn Iterator<Item = usize>| {
            for axis in axes {
                (0..n_axes).for_each(|j| self.turn[(axis, j)] *= 1.0 + step[0]);
            }
        };
        match cause {
            Cause::Gauge(gauge) => self.gain[*gauge] *= 1.0 + step[0],
            Cause::AllGauges => scale(&mut (0..n_axes)),
            Cause::Axes(own) => scale(&mut own.iter().copied()),
            Cause::Rotation => {
                let mut about = [0.0; 3];
                turns(&shape.axes).into_iter().zip(step).for_each(|(at, angle)| about[at] = *angle);
                self.turn = turned(shape, about) * &self.turn;
            }
            _ => {}
        }
    }

    /// Raw signals over a factor.
    fn scale(&mut self, gauges: &[usize], factor: f64, scales: &[(f64, f64)]) {
        for &gauge in gauges {
            let (mean, scale) = scales[gauge];
            self.gain[gauge] = factor;
            self.shift[gauge] = (factor - 1.0) * mean / scale;
        }
    }

    /// What remains of the zeros once the rest is corrected; about the fit's own zeros unless these are `free`.
    fn settle(&mut self, cause: &Cause, fit: &Forward, own: &Mat<f64>, shape: &Shape, free: bool) {
        let n_axes = shape.axes.len();
        let load = Mat::from_fn(n_axes, 1, |axis, _| own[(0, shape.load(axis))] / own[(0, 0)]);
        let said = &fit.slopes * (&self.turn * load);
        for gauge in 0..shape.n_gauges {
            let (zero, gain) = (fit.zero[gauge], self.gain[gauge]);
            let mean = own[(0, shape.gauge(gauge))] / own[(0, 0)];
            self.shift[gauge] = match (free, cause) {
                (true, _) => mean - gain * (zero + said[(gauge, 0)]),
                (false, Cause::Gauge(_)) => zero * (1.0 - gain),
                (false, _) => 0.0,
            };
        }
    }

    /// The sums of corrected samples.
    fn of(&self, sums: &Mat<f64>, rig: &Rig) -> Mat<f64> {
        let (shape, scales) = (&rig.shape, &rig.scales);
        let mut change = Mat::<f64>::identity(shape.width(), shape.width());
        for gauge in 0..shape.n_gauges {
            let row = shape.gauge(gauge);
            change[(row, row)] = 1.0 / self.gain[gauge];
            change[(row, 0)] = -self.shift[gauge] / self.gain[gauge];
        }
        if let Some((a, b)) = self.swap {
            for (to, from) in [(a, b), (b, a)] {
                let row = shape.gauge(to);
                change[(row, row)] = 0.0;
                change[(row, shape.gauge(from))] = scales[from].1 / scales[to].1;
                change[(row, 0)] = (scales[from].0 - scales[to].0) / scales[to].1;
            }
        }
        for i in 0..shape.axes.len() {
            for j in 0..shape.axes.len() {
                change[(shape.load(i), shape.load(j))] = self.turn[(i, j)];
            }
        }
        &change * sums * change.transpose()
    }
}

impl Moments {
    fn about(sums: &Mat<f64>, mean: &[f64], fit: &Forward, shape: &Shape) -> Self {
        let n_axes = shape.axes.len();
        let centred = |i: usize, j: usize| {
            sums[(i, j)] - sums[(i, 0)] * mean[j] - mean[i] * sums[(0, j)]
                + sums[(0, 0)] * mean[i] * mean[j]
        };
        let loads = Mat::from_fn(n_axes, n_axes, |i, j| centred(shape.load(i), shape.load(j)));
        let own =
            Mat::from_fn(shape.n_gauges, n_axes, |i, j| centred(shape.gauge(i), shape.load(j)));
        let rest = own - &fit.slopes * &loads;
        Self { loads, rest }
    }

    /// Product of two ways over the loads, by the variances of the gauges.
    fn square(&self, one: &Mat<f64>, other: &Mat<f64>, variances: &[f64]) -> f64 {
        over_variances(one, &(other * &self.loads), variances)
    }

    /// The step along some ways that explains most, and the squares over variance that it explains; `None` where the loads do not tell.
    fn step(&self, ways: &[Mat<f64>], variances: &[f64]) -> Option<(Vec<f64>, f64)> {
        let n = ways.len();
        let products = Mat::from_fn(n, n, |i, j| self.square(&ways[i], &ways[j], variances));
        let right = Mat::from_fn(n, 1, |i, _| over_variances(&ways[i], &self.rest, variances));
        let largest = (0..n).map(|i| products[(i, i)]).fold(0.0, f64::max);
        if n == 0 || largest.is_nan() || largest <= 1e-9 {
            return None;
        }
        let nearly =
            Mat::from_fn(n, n, |i, j| products[(i, j)] + if i == j { 1e-6 * largest } else { 0.0 });
        let step = nearly.llt(faer::Side::Lower).ok()?.solve(&right);
        let gain = (0..n).map(|i| step[(i, 0)] * right[(i, 0)]).sum();
        Some(((0..n).map(|i| step[(i, 0)]).collect(), gain))
    }
}

/// Returns true if a left-out error becomes smaller by enough without a fault.
fn matters(with: f64, without: f64) -> bool {
    without < MATTERS * with && with - without > FALLS
}

/// Returns the sum of the products of two matrices' entries, by the variances of the gauges.
fn over_variances(one: &Mat<f64>, other: &Mat<f64>, variances: &[f64]) -> f64 {
    let of_gauge = |gauge: usize| {
        let row = (0..one.ncols()).map(|axis| one[(gauge, axis)] * other[(gauge, axis)]);
        row.sum::<f64>() / variances[gauge]
    };
    (0..one.nrows()).map(of_gauge).sum()
}

/// Returns the loads that zeros of the gauges make, over full scale.
fn loads_of(back: &Mat<f64>, zeros: &[f64]) -> Vec<f64> {
    let of_axis =
        |axis: usize| zeros.iter().enumerate().map(|(at, zero)| back[(axis, at)] * zero).sum();
    (0..back.nrows()).map(of_axis).collect()
}

fn column_means(sums: &Mat<f64>) -> Vec<f64> {
    (0..sums.ncols()).map(|at| sums[(0, at)] / sums[(0, 0)].max(f64::MIN_POSITIVE)).collect()
}

/// No load, and the gauges as the fit says.
fn origin(fit: &Forward, shape: &Shape) -> Vec<f64> {
    let mut own = vec![0.0; shape.width()];
    (0..shape.n_gauges).for_each(|gauge| own[shape.gauge(gauge)] = fit.zero[gauge]);
    own
}

/// The directions (x, y, z) about which a turn mixes axes.
fn turns(axes: &[Axis]) -> Vec<usize> {
    let has = |at: usize| axes.contains(&Axis::ALL[at]);
    let others = |about: usize| [(about + 1) % 3, (about + 2) % 3];
    let mixes = |about: &usize| {
        let [a, b] = others(*about);
        (has(a) && has(b)) || (has(a + 3) && has(b + 3))
    };
    (0..3).filter(mixes).collect()
}

/// A matrix over x, y, z as one over loads that are shares of full scale.
fn over_loads(shape: &Shape, of: impl Fn(usize, usize) -> f64) -> Mat<f64> {
    let n = shape.axes.len();
    Mat::from_fn(n, n, |i, j| {
        let (to, from) = (shape.axes[i], shape.axes[j]);
        match to.is_force() == from.is_force() {
            true => {
                of(to as usize % 3, from as usize % 3) * shape.full_scale[j] / shape.full_scale[i]
            }
            false => 0.0,
        }
    })
}

/// `about × load`.
fn cross(about: [f64; 3], i: usize, j: usize) -> f64 {
    match (3 + j - i) % 3 {
        1 => -about[3 - i - j],
        2 => about[3 - i - j],
        _ => 0.0,
    }
}

fn generator(shape: &Shape, about: usize) -> Mat<f64> {
    let mut way = [0.0; 3];
    way[about] = 1.0;
    over_loads(shape, |i, j| cross(way, i, j))
}

/// A turn by an angle (rad) about a direction (Rodrigues).
fn turned(shape: &Shape, about: [f64; 3]) -> Mat<f64> {
    let angle = about.iter().map(|own| own * own).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    let way = about.map(|own| own / angle);
    let (sin, cos) = angle.sin_cos();
    over_loads(shape, |i, j| {
        let same = if i == j { cos } else { 0.0 };
        same + sin * cross(way, i, j) + (1.0 - cos) * way[i] * way[j]
    })
}

/// Two columns of loads exchanged, as they are in the file.
fn exchanged(shape: &Shape, a: usize, b: usize) -> Mat<f64> {
    let n = shape.axes.len();
    Mat::from_fn(n, n, |i, j| match (i, j) {
        (i, j) if (i, j) == (a, b) || (i, j) == (b, a) => shape.full_scale[j] / shape.full_scale[i],
        (i, j) if i == j && i != a && i != b => 1.0,
        _ => 0.0,
    })
}
