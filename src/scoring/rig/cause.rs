//! Searches for the fault of the measuring rig that explains why recordings disagree. Each possible fault has a correction of
//! the data. A fault is reported only if its fitted correction reduces the held-out error by enough ([`MATTERS`]), and by
//! more than chance explains.

use faer::Mat;
use faer::linalg::solvers::Solve as _;
use rayon::prelude::*;

use crate::{
    recording::{Axis, Recording},
    scoring::rig::{
        Rig, Unit, chance,
        fits::{self, Fit, Moments, Shape, column_means},
        units,
    },
};

/// Maximum held-out error after the correction of a reported fault, as a share of the error before. If a fault adds a quarter
/// to the error, its true correction leaves 1 / 1.25 = 0.8 of the error. An estimated correction leaves up to a twentieth
/// more.
const MATTERS: f64 = 0.84;
/// Minimum change of the load by a reported tare (changed zeros), as a share of the change that would reduce the error by
/// [`MATTERS`]. The share is below one, because noise can make an estimated change smaller than the true one.
const SHIFT: f64 = 0.8;
/// Minimum reduction of the held-out error by the correction of a reported fault, as a share of full scale. It is one step of
/// a reference with 16 bits.
const FALLS: f64 = 1.5e-5;
/// Maximum probability that any of the tried corrections reduces the error by chance. It is estimated from the scatter of
/// units (parts of recordings).
const BY_CHANCE: f64 = 0.005;
/// Maximum probability that a correction reduces the error by chance, as estimated from the scatter of whole runs. It is used
/// with at least [`ENOUGH_RUNS`] runs.
const BY_CHANCE_OF_RUNS: f64 = 0.1;
/// Minimum number of runs (recordings) for an estimate of chance from the scatter of whole runs.
const ENOUGH_RUNS: usize = 4;
/// Number of corrections that are cross-validated. They are those that reduce the residuals most.
const REFITTED: usize = 120;
/// Penalty for each parameter when corrections are compared by the logarithm of their error. The Bayesian information
/// criterion gives `ln n / (2 n)` for n independent errors. This fixed value belongs to n = 60, such as 15 units (parts of
/// recordings) with four axes each.
const PARAMETER: f64 = 0.033;
/// Maximum fitted factor of one gauge's sensitivity; its inverse is the minimum. Beyond these limits, the gauge would have no
/// weight in the fit.
const MOST_OF_GAUGE: f64 = 20.0;
/// Changes of a sensitivity that are smaller than this are reported only if they explain more of the error than a tare.
/// Amplifiers keep their gain to about this share.
const SMALLEST_GAIN: f64 = 0.002;
/// Two columns are suspected of being exchanged if the estimated share of the exchange is within this range. If they are
/// exchanged completely, the share is 1.
const EXCHANGED: std::ops::RangeInclusive<f64> = 0.7..=1.3;

/// Kind of a fault of the measuring rig.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// The zeros of the gauges differ from those of the other runs.
    Tare,
    /// The zero of the reference differs from that in the other runs.
    ReferenceZero,
    /// The zeros of the gauges change in proportion to time.
    Drift,
    /// The sensitivity of the gauge with this index is different.
    Gauge(usize),
    /// The sensitivity of all gauges differs by one factor, or the reference has another scale.
    AllGauges,
    /// On these axes, the scale of the reference load differs from that in the other runs. The numbers are indices among the
    /// axes on which the load moves.
    Axes(Vec<usize>),
    /// The coordinate frame of the reference loads is turned.
    Rotation,
    /// The point about which the moments of the reference are given is moved.
    Moved,
    /// The data columns of two gauges are exchanged.
    SwappedGauges(usize, usize),
    /// The data columns of two load axes are exchanged.
    SwappedAxes(usize, usize),
}

impl Cause {
    fn is_exchange(&self) -> bool {
        matches!(self, Self::SwappedGauges(..) | Self::SwappedAxes(..))
    }

    /// True for a turn or a move, which has a parameter for each direction.
    fn is_of_frame(&self) -> bool {
        matches!(self, Self::Rotation | Self::Moved)
    }
}

/// Runs (recordings) that have a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Where {
    /// The run with this index and all later runs.
    From(usize),
    /// Only the run with this index.
    One(usize),
    /// All runs.
    All,
}

/// Fault that explains why runs contradict each other.
#[derive(Debug)]
pub struct Contradiction {
    /// Kind of the fault.
    pub cause: Cause,
    /// Runs that have the fault.
    pub place: Where,
    /// Size of the fault: factor of the sensitivity or of the reference's scale, angle of the turned frame (rad), distance of the
    /// moved point (m), RMS change of the load by changed zeros as a share of full scale; 1 for an exchange.
    pub value: f64,
    /// Held-out error of the uncorrected data, as a share of full scale.
    pub with: f64,
    /// Held-out error after the correction of the fault, as a share of full scale.
    pub without: f64,
}

/// Possible fault in a set of runs, and its correction.
struct Trial {
    place: Where,
    cause: Cause,
    zeros: Zeros,
    /// Size of each parameter of the correction; empty for changed zeros.
    sizes: Vec<f64>,
    /// Amount by which the correction reduces the sum of the gauges' squared residuals, each divided by the variance of its
    /// gauge.
    gain: f64,
}

/// Possible fault with the held-out error after its correction.
struct Refit<'a> {
    trial: &'a Trial,
    cause: Cause,
    n_parameters: usize,
    value: f64,
    error: f64,
    /// Probabilities that the correction reduces the error by chance, from the scatter of parts of recordings (units)
    /// and from that of whole recordings (runs).
    chances: [f64; 2],
}

/// What the correction of a changed sensitivity assumes about the gauges' zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Zeros {
    /// The zeros are those of the other runs: only the gain was changed, or the reference is wrong.
    Kept,
    /// The zeros are fitted anew, because the recording may have been tared again.
    Free,
    /// The zeros are multiplied by the gain like the signal, because the gain acts on the raw signal.
    Scaled,
}

/// Change of the columns of a sample in proportion to a parameter: changed column, column that is added to it, and factor.
type Direction = Vec<(usize, usize, f64)>;

impl Rig {
    /// Returns the fault that explains most of the held-out error, or `None` if no fault explains enough.
    pub fn contradiction(&self) -> Option<Contradiction> {
        // A single recording is not judged: hysteresis that builds up looks like a drift of the zeros.
        if self.n_runs() < 2 || self.hold_one_load {
            return None;
        }
        let with = self.left_out_error();
        let n = self.n_runs();
        // A fault begins at one run, or one run alone has it.
        let alone = if n > 2 { 1..n - 1 } else { 0..0 };
        let places: Vec<Where> = (1..n).map(Where::From).chain(alone.map(Where::One)).collect();
        let mut trials: Vec<Trial> =
            places.par_iter().flat_map_iter(|place| self.trials(*place)).collect();
        trials.push(Trial {
            place: Where::All,
            cause: Cause::Drift,
            zeros: Zeros::Free,
            sizes: Vec::new(),
            gain: f64::INFINITY,
        });
        let mut order: Vec<&Trial> = trials.iter().collect();
        order.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        order.truncate(REFITTED);
        let refits = order.par_iter().filter_map(|trial| match trial.sizes[..] {
            [] => Some(self.refit_zeros(trial)),
            _ => self.refit_gains(trial),
        });
        let refits: Vec<Refit<'_>> = refits.collect();
        // A changed sensitivity with new zeros must explain more than new zeros alone, which are a tare. A factor of nearly
        // one must, too, because it mostly shifts large zeros.
        let exceeds_tare = |refit: &Refit<'_>| {
            let Trial { place, cause, zeros, sizes, .. } = refit.trial;
            let is_gain = matches!(cause, Cause::Gauge(_) | Cause::AllGauges);
            let is_small = is_gain && (refit.value.abs() - 1.0).abs() < SMALLEST_GAIN;
            let frees_zeros = *zeros == Zeros::Free && !sizes.is_empty() && !cause.is_exchange();
            let is_tare = |tried: &&Trial| tried.place == *place && tried.cause == Cause::Tare;
            let tare = trials.iter().find(is_tare).filter(|_| frees_zeros || is_small);
            tare.is_none_or(|tare| matters(self.refit_zeros(tare).error, refit.error))
        };
        let explains = |refit: &&Refit<'_>| {
            matters(with, refit.error) && self.is_shift(refit) && exceeds_tare(refit)
        };
        let explaining: Vec<&Refit<'_>> = refits.iter().filter(explains).collect();
        let is_significant = |refit: &&&Refit<'_>| {
            let n_places = if refit.trial.place == Where::All { 1 } else { places.len() };
            refit.chances[0] < BY_CHANCE / trials.len() as f64
                && refit.chances[1] < BY_CHANCE_OF_RUNS / n_places as f64
        };
        // Chance decides whether something changes between these runs, and the error decides which fault it is.
        let significant = explaining.iter().filter(is_significant);
        let changed: Vec<Where> = significant.map(|refit| refit.trial.place).collect();
        let score = |refit: &Refit<'_>| {
            refit.error.max(f64::MIN_POSITIVE).ln() + PARAMETER * refit.n_parameters as f64
        };
        let possible = explaining.into_iter().filter(|own| changed.contains(&own.trial.place));
        let best = possible.min_by(|a, b| score(a).total_cmp(&score(b)))?;
        let (cause, place) = (best.cause.clone(), best.trial.place);
        Some(Contradiction { cause, place, value: best.value, with, without: best.error })
    }

    /// Returns false if the fault is a tare whose change of the load is too small to be reported. If `m` of `n` held-out
    /// parts are tared, the squared error grows by `m (n − m) / (n − 1)²` times the squared change of the load.
    fn is_shift(&self, refit: &Refit<'_>) -> bool {
        let Trial { place, cause, .. } = refit.trial;
        let by_unit = self.n_runs() < fits::FEWEST_RUNS;
        let n = if by_unit { self.units.len() } else { self.n_runs() } as f64;
        let here = self.units.iter().filter(|unit| self.is_here(*place, unit.run)).count();
        let m = n * here as f64 / self.units.len() as f64;
        let added = m * (n - m) / (n - 1.0).powi(2);
        let smallest = ((MATTERS.powi(-2) - 1.0) / added).sqrt() * SHIFT * refit.error;
        *cause != Cause::Tare || refit.value > smallest
    }

    /// Returns true if the side of a change that is corrected comes before its place. It is the side with fewer runs, because
    /// the fit to the other side is more accurate.
    fn is_before(&self, place: Where) -> bool {
        matches!(place, Where::From(first) if first < self.n_runs() - first)
    }

    /// Returns true if the correction of a fault is applied to a run.
    fn is_here(&self, place: Where, run: usize) -> bool {
        match place {
            Where::From(first) => (run < first) == self.is_before(place),
            Where::One(one) => run == one,
            Where::All => true,
        }
    }

    fn trials(&self, place: Where) -> Vec<Trial> {
        let shape = &self.shape;
        let [here, others] =
            [true, false].map(|side| self.total(|run| self.is_here(place, run) == side));
        // With fewer samples than coefficients, any correction would fit, so none is tried.
        if here[(0, 0)] < (shape.n_gauges + 2) as f64 {
            return Vec::new();
        }
        let fit = Fit::forward(&others, shape);
        let variances = fit.variances(&others);
        let [centred, raw] = [column_means(&here), vec![0.0; shape.width()]]
            .map(|mean| Moments::about(&here, &mean, &fit, shape));
        let n = here[(0, 0)] * others[(0, 0)] / (here[(0, 0)] + others[(0, 0)]);
        let zeros = fit.means(&here).into_iter().zip(&variances);
        let tare = zeros.map(|(zero, variance)| n * zero * zero / variance).sum();
        let trial = |cause, zeros, sizes, gain| Trial { place, cause, zeros, sizes, gain };
        let mut all = vec![trial(Cause::Tare, Zeros::Free, Vec::new(), tare)];
        for cause in self.causes() {
            for zeros in self.zeros_of(&cause) {
                let moments = if zeros == Zeros::Free { &centred } else { &raw };
                let ways = self.ways(&self.directions(&cause, zeros, &fit), &fit);
                let Some((sizes, gain, _)) = moments.step(&ways, &variances) else { continue };
                if !cause.is_exchange() {
                    all.push(trial(cause.clone(), zeros, sizes, gain));
                } else if EXCHANGED.contains(&sizes[0]) {
                    all.push(trial(cause.clone(), zeros, vec![1.0], gain));
                }
            }
        }
        all
    }

    /// Returns the assumptions about zeros that are tried in the correction of a fault. With a single gauge whose zero is
    /// larger than its range, a gain that also scales the zero looks like a tare. [`Zeros::Scaled`] is then not tried.
    fn zeros_of(&self, cause: &Cause) -> Vec<Zeros> {
        let is_ambiguous = self.shape.n_gauges == 1 && self.offset(0).abs() > self.spans[0];
        match cause {
            cause if cause.is_exchange() => vec![Zeros::Free],
            Cause::Gauge(_) | Cause::AllGauges if !is_ambiguous => {
                vec![Zeros::Kept, Zeros::Free, Zeros::Scaled]
            }
            _ => vec![Zeros::Kept, Zeros::Free],
        }
    }

    fn offset(&self, gauge: usize) -> f64 {
        self.scales[gauge].0 / self.scales[gauge].1
    }

    /// Returns the faults whose size follows from a comparison of sensitivities.
    fn causes(&self) -> Vec<Cause> {
        let (n_gauges, axes) = (self.shape.n_gauges, &self.shape.axes);
        let n_axes = axes.len();
        let pairs = |n: usize| (0..n).flat_map(move |a| (a + 1..n).map(move |b| (a, b)));
        let mut all: Vec<Cause> = (0..n_gauges).map(Cause::Gauge).collect();
        all.extend((n_gauges > 1).then_some(Cause::AllGauges));
        all.extend(pairs(n_gauges).map(|(a, b)| Cause::SwappedGauges(a, b)));
        all.extend(pairs(n_axes).map(|(a, b)| Cause::SwappedAxes(a, b)));
        let of =
            |wanted: &dyn Fn(usize) -> bool| (0..n_axes).filter(|axis| wanted(*axis)).collect();
        let single = (0..n_axes).map(|axis| vec![axis]);
        let kinds = [true, false].map(|is_force| of(&|axis| axes[axis].is_force() == is_force));
        let kinds = kinds.into_iter().filter(|own: &Vec<usize>| own.len() > 1);
        // A factor of all axes is one of all gauges.
        let groups = single.chain(kinds).filter(|own| own.len() < n_axes);
        all.extend(groups.map(Cause::Axes));
        let frames = [Cause::Rotation, Cause::Moved].into_iter();
        all.extend(frames.filter(|cause| !of_frame(&self.shape, cause).is_empty()));
        all
    }

    /// Returns the change of the columns by the correction of a fault, for each of its parameters and a small size. The size of
    /// an exchange is one.
    fn directions(&self, cause: &Cause, zeros: Zeros, fit: &Fit) -> Vec<Direction> {
        let shape = &self.shape;
        let scaled = |axis: usize| {
            let at = shape.load(axis);
            (at, at, 1.0)
        };
        let direction = match cause {
            Cause::Gauge(gauge) => {
                let is_scaled = zeros == Zeros::Scaled;
                let zero = if is_scaled { -self.offset(*gauge) } else { fit.map[(*gauge, 0)] };
                let at = shape.gauge(*gauge);
                vec![(at, at, -1.0), (at, 0, zero)]
            }
            // A factor of all gauges is corrected in the loads, so that errors remain shares of the same full scale.
            Cause::AllGauges => {
                let scaled_zeros = (0..shape.n_gauges).filter(|_| zeros == Zeros::Scaled);
                let zero = |gauge: usize| -(fit.map[(gauge, 0)] + self.offset(gauge));
                let zeros = scaled_zeros.map(|gauge| (shape.gauge(gauge), 0, zero(gauge)));
                zeros.chain((0..shape.axes.len()).map(scaled)).collect()
            }
            Cause::SwappedGauges(a, b) => {
                let exchanged = exchange([*a, *b], shape.gauge(0), |at| self.scales[at]);
                exchanged.into_iter().map(|(to, from, factor)| (to, from, -factor)).collect()
            }
            Cause::Axes(axes) => axes.iter().copied().map(scaled).collect(),
            // Loads are shares of full scale, but the columns of the file are in N or N·m.
            Cause::SwappedAxes(a, b) => {
                exchange([*a, *b], shape.load(0), |at| (0.0, shape.full_scale[at]))
            }
            Cause::Rotation | Cause::Moved => return of_frame(shape, cause),
            Cause::Tare | Cause::ReferenceZero | Cause::Drift => Vec::new(),
        };
        vec![direction]
    }

    /// Returns minus the change of the gauges' residuals by each of these directions, as coefficients of a constant and of the
    /// loads, for gauges that follow the fit exactly.
    fn ways(&self, directions: &[Direction], fit: &Fit) -> Vec<Mat<f64>> {
        let inputs = self.shape.inputs();
        let way = |direction: &Direction| {
            let mut way = Mat::<f64>::zeros(self.shape.n_gauges, inputs.len());
            for &(to, from, factor) in direction {
                let predicted = |input: usize| match from.checked_sub(self.shape.gauge(0)) {
                    Some(gauge) if gauge < self.shape.n_gauges => fit.map[(gauge, input)],
                    _ => f64::from(u8::from(inputs[input] == from)),
                };
                way -= Mat::from_fn(self.shape.n_gauges, inputs.len(), |gauge, input| {
                    factor * fit.residual[(to, gauge)] * predicted(input)
                });
            }
            way
        };
        directions.iter().map(way).collect()
    }

    /// Returns the matrix that applies a correction of these sizes to the columns `[1, time, gauges, loads]` of a sample.
    fn change(&self, cause: &Cause, directions: &[Direction], sizes: &[f64]) -> Mat<f64> {
        let mut change = Mat::<f64>::zeros(self.shape.width(), self.shape.width());
        for (direction, size) in directions.iter().zip(sizes) {
            direction.iter().for_each(|(to, from, factor)| change[(*to, *from)] += size * factor);
        }
        let one = self.shape.unchanged();
        let inverse = |of: Mat<f64>| of.partial_piv_lu().solve(&one);
        match cause {
            // The fault is in the gauges, and the correction is its inverse.
            Cause::Gauge(_) | Cause::SwappedGauges(..) => inverse(&one - change),
            // The Cayley transform turns without a change of length.
            Cause::Rotation => {
                let half = faer::Scale(0.5) * change;
                inverse(&one - &half) * (&one + half)
            }
            _ => &one + change,
        }
    }

    /// Fits the correction of a drift of the zeros in time, or of a tare. For a tare, the column of times is
    /// replaced by a column that is 1 in the runs to be corrected and 0 in the others.
    fn refit_zeros<'a>(&self, trial: &'a Trial) -> Refit<'a> {
        let (shape, n_axes) = (&self.shape, self.shape.axes.len());
        let in_step = |unit: &Unit| {
            let mut change = shape.unchanged();
            if trial.cause == Cause::Tare {
                change[(1, 1)] = 0.0;
                change[(1, 0)] = f64::from(u8::from(self.is_here(trial.place, unit.run)));
            }
            unit.changed(&change)
        };
        let units: Vec<Unit> = self.units.iter().map(in_step).collect();
        let x: Vec<f64> = units.iter().map(|unit| unit.sums[(0, 1)] / unit.sums[(0, 0)]).collect();
        let fit = Fit::with_drift(&fits::sum(units.iter(), shape), shape);
        let drift = fit.map.col(1 + n_axes);
        let mut change = shape.unchanged();
        (0..shape.n_gauges).for_each(|gauge| change[(shape.gauge(gauge), 1)] = -drift[gauge]);
        let corrected: Vec<Unit> = units.iter().map(|unit| unit.changed(&change)).collect();
        let back = Fit::backward(&fits::sum(corrected.iter(), shape), shape);
        // Loads, as shares of full scale, that a calibration computes from zeros of the gauges.
        let loads = |zeros: &[f64]| -> Vec<f64> {
            let of_axis = |axis: usize| {
                (1..).zip(zeros).map(|(at, zero)| back.map[(axis, at)] * zero).sum::<f64>()
            };
            (0..n_axes).map(of_axis).collect()
        };
        let of_unit = |(unit, x): (&Unit, &f64)| {
            let zeros = fit.means(&unit.sums).into_iter().zip(drift.iter());
            loads(&zeros.map(|(mean, drift)| mean + drift * x).collect::<Vec<f64>>())
        };
        let zeros = units.iter().zip(&x).map(of_unit).collect();
        let shift = loads(&drift.iter().copied().collect::<Vec<f64>>());
        let square = shift.iter().map(|load| load * load).sum::<f64>() / n_axes as f64;
        let weights = self.units.iter().map(|unit| unit.sums[(0, 0)]).collect();
        let chances = self.chances(zeros, weights, x);
        let error = error(&corrected, shape);
        let zeros = vec![drift.iter().copied().collect()];
        let cause = match &trial.cause {
            Cause::Tare if fits::look_like_loads(&zeros, &fit, shape) => Cause::ReferenceZero,
            cause => cause.clone(),
        };
        Refit { trial, cause, n_parameters: n_axes, value: square.sqrt(), error, chances }
    }

    fn refit_gains<'a>(&self, trial: &'a Trial) -> Option<Refit<'a>> {
        let (shape, Trial { place, cause, zeros, sizes, .. }) = (&self.shape, trial);
        let is_here = |run: usize| self.is_here(*place, run);
        let [here, others] = [true, false].map(|side| self.total(|run| is_here(run) == side));
        let fit = Fit::forward(&others, shape);
        let mut change = self.change(cause, &self.directions(cause, *zeros, &fit), sizes);
        let frees_zeros = *zeros == Zeros::Free && !cause.is_exchange();
        if frees_zeros {
            let left = fit.means(&fits::changed(&here, &change));
            left.iter().enumerate().for_each(|(at, zero)| change[(shape.gauge(at), 0)] -= zero);
        }
        let is_gain = !cause.is_of_frame() && !cause.is_exchange();
        let factor = if is_gain { 1.0 + sizes[0] } else { 1.0 };
        let most = if matches!(cause, Cause::Gauge(_)) { MOST_OF_GAUGE } else { 1e4 };
        // Gains and axes cannot be compared between runs that load different axes. Only another unit makes the loads of an axis
        // much larger than those of the other runs: millimetres, or centimetres.
        let is_loaded = |sums: &Mat<f64>| fits::is_loaded(sums, &others, shape);
        let is_unit = [0.01, 0.001].iter().any(|unit| (factor.abs() / unit - 1.0).abs() < 0.1);
        if !(1.0 / most..most).contains(&factor.abs())
            || !is_loaded(&fits::changed(&here, &change))
            || !(is_loaded(&here) || is_unit)
        {
            return None;
        }
        let corrected = |unit: &Unit| {
            if is_here(unit.run) { unit.changed(&change) } else { unit.clone() }
        };
        let units: Vec<Unit> = self.units.iter().map(corrected).collect();
        let fit = Fit::forward(&fits::sum(units.iter(), shape), shape);
        let variances = fit.variances(&fits::sum(units.iter(), shape));
        // For an exchange of columns, its share is estimated from the uncorrected data of each unit.
        let shown = if cause.is_exchange() { &self.units } else { &units };
        let ways = self.ways(&self.directions(cause, *zeros, &fit), &fit);
        let means = [false, true].map(|side| match zeros {
            Zeros::Scaled => vec![0.0; shape.width()],
            _ => {
                let chosen = shown.iter().filter(|unit| is_here(unit.run) == side);
                column_means(&fits::sum(chosen, shape))
            }
        });
        // Returns the parameters of the fault as estimated from one unit, and the weight of this estimate.
        let of_unit = |unit: &Unit| {
            let here = is_here(unit.run);
            let moments = Moments::about(&unit.sums, &means[usize::from(here)], &fit, shape);
            let Some((mut step, _, weight)) = moments.step(&ways, &variances) else {
                return (vec![0.0; ways.len()], 0.0);
            };
            if here && !cause.is_exchange() {
                step.iter_mut().zip(sizes).for_each(|(value, size)| *value += size);
            }
            (step, weight)
        };
        let (values, weights) = shown.iter().map(of_unit).unzip();
        let n_zeros = if frees_zeros { shape.axes.len() } else { 0 };
        let n_sizes = if cause.is_exchange() { 0 } else { sizes.len() };
        let x = self.units.iter().map(|unit| f64::from(u8::from(is_here(unit.run)))).collect();
        let value = if cause.is_of_frame() {
            sizes.iter().map(|angle| angle * angle).sum::<f64>().sqrt()
        } else {
            factor.powi(if self.is_before(*place) { -1 } else { 1 })
        };
        let (error, chances) = (error(&units, shape), self.chances(values, weights, x));
        let (cause, n_parameters) = (cause.clone(), n_zeros + n_sizes);
        Some(Refit { trial, cause, n_parameters, value, error, chances })
    }

    /// Returns the held-out error over all axes, as a share of full scale.
    pub fn left_out_error(&self) -> f64 {
        error(&self.units, &self.shape)
    }

    /// Returns the held-out error of the samples for which `is_used` is true, given the index of the recording and of the
    /// sample.
    pub fn error_of(
        &self,
        recordings: &[&Recording],
        is_used: impl Fn(usize, usize) -> bool,
    ) -> f64 {
        error(&units(recordings, self, is_used), &self.shape)
    }

    /// Returns the probability that the values of units follow a straight line in `x` by chance: once from the scatter of
    /// units, once from that of runs.
    fn chances(&self, values: Vec<Vec<f64>>, weights: Vec<f64>, x: Vec<f64>) -> [f64; 2] {
        let of_units = chance::of_slope(&values, &weights, &x);
        if self.n_runs() < ENOUGH_RUNS {
            return [of_units, 0.0];
        }
        let mut of_runs = vec![(vec![0.0; values[0].len()], 0.0, 0.0); self.n_runs()];
        for (((unit, values), weight), x) in self.units.iter().zip(values).zip(weights).zip(x) {
            let (sums, of_run, x_sum) = &mut of_runs[unit.run];
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            (*of_run, *x_sum) = (*of_run + weight, *x_sum + weight * x);
        }
        let (mut values, mut weights, mut x) = (Vec::new(), Vec::new(), Vec::new());
        for (sums, weight, x_sum) in of_runs {
            let by = weight.max(f64::MIN_POSITIVE);
            values.push(sums.into_iter().map(|sum| sum / by).collect());
            weights.push(weight);
            x.push(x_sum / by);
        }
        [of_units, chance::of_slope(&values, &weights, &x)]
    }
}

/// Returns the held-out error over all axes, as a share of full scale.
fn error(units: &[Unit], shape: &Shape) -> f64 {
    fits::mean_error(&fits::left_out(units, shape), units, |_| true)
}

/// Returns true if the correction of a fault reduces the held-out error by enough for a finding.
pub fn matters(with: f64, without: f64) -> bool {
    without < MATTERS * with && with - without > FALLS
}

/// Returns the change of two columns that are exchanged. The columns are values minus a mean, divided by a scale.
fn exchange([a, b]: [usize; 2], first: usize, scaled: impl Fn(usize) -> (f64, f64)) -> Direction {
    let pairs = [(a, b), (b, a)].into_iter();
    let changes = pairs.flat_map(|(to, from)| {
        let [(mean, scale), (other_mean, other_scale)] = [to, from].map(&scaled);
        let [to, from] = [to, from].map(|at| first + at);
        [(to, to, -1.0), (to, from, other_scale / scale), (to, 0, (other_mean - mean) / scale)]
    });
    changes.collect()
}

/// Returns the changes of loads, as shares of full scale, by small turns of the frame about x, y and z, `about × load`, or by
/// moves of the reference point, `move × force`. Those that change no measured axis are left out.
fn of_frame(shape: &Shape, cause: &Cause) -> Vec<Direction> {
    let is_changed = |to: Axis, by: Axis| match cause {
        Cause::Rotation => to.is_force() == by.is_force(),
        _ => !to.is_force() && by.is_force(),
    };
    let along = |direction: usize| {
        let mut changes = Vec::new();
        for (i, to) in shape.axes.iter().enumerate() {
            for (j, by) in shape.axes.iter().enumerate().filter(|(_, by)| is_changed(*to, **by)) {
                let sign = match [*to, *by].map(|axis| (3 + axis as usize % 3 - direction) % 3) {
                    [2, 1] => 1.0,
                    [1, 2] => -1.0,
                    _ => continue,
                };
                let ratio = shape.full_scale[j] / shape.full_scale[i];
                changes.push((shape.load(i), shape.load(j), sign * ratio));
            }
        }
        changes
    };
    (0..3).map(along).filter(|own| !own.is_empty()).collect()
}
