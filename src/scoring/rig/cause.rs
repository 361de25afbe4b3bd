//! Searches for the fault of the measuring rig that explains why recordings disagree. Each possible fault has a correction of
//! the data. A fault is reported only if its fitted correction reduces the held-out error by enough ([`MATTERS`]), and by
//! more than chance explains.

use faer::Mat;
use rayon::prelude::*;

use crate::{
    recording::{Axis, Recording},
    scoring::rig::{
        Rig, Unit, chance,
        fits::{self, Forward, Moments, Shape, column_means},
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
/// Number of corrections that are fitted completely and cross-validated. They are those that reduce the residuals most in a
/// first linear step.
const REFITTED: usize = 40;
/// Size of a fault's parameter for the numerical derivative of its correction.
const SMALL: f64 = 1e-7;
/// Number of Gauss-Newton steps in the fit of a correction.
const STEPS: usize = 6;
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
    /// The data columns of two gauges are exchanged.
    SwappedGauges(usize, usize),
    /// The data columns of two load axes are exchanged.
    SwappedAxes(usize, usize),
}

impl Cause {
    fn is_exchange(&self) -> bool {
        matches!(self, Self::SwappedGauges(..) | Self::SwappedAxes(..))
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
    /// Size of the fault: factor of the sensitivity or of the reference's scale, or angle of the turned frame (rad). For a
    /// tare or a drift, it is the change of the load on each axis, as a share of full scale.
    pub values: Vec<f64>,
    /// Held-out error of the uncorrected data, as a share of full scale.
    pub with: f64,
    /// Held-out error after the correction of the fault, as a share of full scale.
    pub without: f64,
}

/// Possible fault in a set of runs. Its correction is tried.
struct Trial {
    place: Where,
    is_here: Vec<bool>,
    cause: Cause,
    /// Amount by which one linear step of the correction reduces the sum of the gauges' squared residuals, each divided by
    /// the variance of its gauge.
    gain: f64,
}

/// Possible fault with its fitted correction.
struct Refit<'a> {
    trial: &'a Trial,
    parameters: f64,
    values: Vec<f64>,
    error: f64,
    /// True if the fault changes the sensitivity and the correction also fits new zeros.
    frees_zeros: bool,
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

impl Rig {
    /// Returns the fault that explains most of the held-out error, or `None` if no fault explains enough.
    pub fn contradiction(&self) -> Option<Contradiction> {
        // A single recording is not judged: hysteresis that builds up looks like a drift of the zeros.
        if self.n_runs() < 2 {
            return None;
        }
        let errors = fits::left_out(&self.units, &self.shape);
        let with = fits::mean_error(&errors, &self.units, |_| true);
        let places = self.places();
        let mut trials: Vec<Trial> =
            places.par_iter().flat_map_iter(|place| self.trials(*place)).collect();
        let is_here = vec![true; self.units.len()];
        trials.push(Trial { place: Where::All, is_here, cause: Cause::Drift, gain: f64::INFINITY });
        let mut order: Vec<&Trial> = trials.iter().collect();
        order.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        order.truncate(REFITTED);
        let refits = order.par_iter().flat_map_iter(|own| self.refits(own));
        let refits: Vec<Refit<'_>> = refits.collect();
        // A changed sensitivity with new zeros must explain more than new zeros alone, which are a tare. A factor of nearly
        // one must, too, because it mostly shifts large zeros.
        let exceeds_tare = |own: &Refit<'_>| {
            let is_tare =
                |tried: &&Trial| tried.place == own.trial.place && tried.cause == Cause::Tare;
            let tare = trials.iter().find(is_tare).map(|tare| self.refit_zeros(tare));
            tare.is_some_and(|tare| matters(tare.error, own.error))
        };
        let is_small = |own: &Refit<'_>| {
            let is_gain = matches!(own.trial.cause, Cause::Gauge(_) | Cause::AllGauges);
            is_gain && (own.values[0].abs() - 1.0).abs() < SMALLEST_GAIN
        };
        let explains = |own: &&Refit<'_>| {
            matters(with, own.error)
                && self.is_shift(own)
                && (!(own.frees_zeros || is_small(own)) || exceeds_tare(own))
        };
        let explaining: Vec<&Refit<'_>> = refits.iter().filter(explains).collect();
        let is_significant = |own: &&&Refit<'_>| {
            let n_places = if own.trial.place == Where::All { 1 } else { places.len() };
            own.chances[0] < BY_CHANCE / trials.len() as f64
                && own.chances[1] < BY_CHANCE_OF_RUNS / n_places as f64
        };
        // Chance decides whether something changes between these runs, and the error decides which fault it is.
        let significant = explaining.iter().filter(is_significant);
        let changed: Vec<Where> = significant.map(|own| own.trial.place).collect();
        let score =
            |own: &Refit<'_>| own.error.max(f64::MIN_POSITIVE).ln() + PARAMETER * own.parameters;
        let possible = explaining.into_iter().filter(|own| changed.contains(&own.trial.place));
        let best = possible.min_by(|a, b| score(a).total_cmp(&score(b)));
        let found = |own: &Refit<'_>| Contradiction {
            cause: own.trial.cause.clone(),
            place: own.trial.place,
            values: own.values.clone(),
            with,
            without: own.error,
        };
        best.map(found)
    }

    /// Returns false if the fault is a tare whose change of the load is too small to be reported. If `m` of `n` held-out
    /// parts are tared, the squared error grows by `m (n − m) / (n − 1)²` times the squared change of the load.
    fn is_shift(&self, own: &Refit<'_>) -> bool {
        if own.trial.cause != Cause::Tare {
            return true;
        }
        let by_unit = self.n_runs() < fits::FEWEST_RUNS;
        let n = if by_unit { self.units.len() } else { self.n_runs() } as f64;
        let is_here = &own.trial.is_here;
        let m = n * is_here.iter().filter(|here| **here).count() as f64 / is_here.len() as f64;
        let added = m * (n - m) / (n - 1.0).powi(2);
        let smallest = ((MATTERS.powi(-2) - 1.0) / added).sqrt() * SHIFT * own.error;
        let squares: f64 = own.values.iter().map(|value| value * value).sum();
        squares > own.values.len() as f64 * smallest * smallest
    }

    /// Returns the sets of runs that may have a common fault: all runs from one run on, or one run alone.
    fn places(&self) -> Vec<Where> {
        let n = self.n_runs();
        let alone = if n > 2 { 1..n.saturating_sub(1) } else { 0..0 };
        (1..n).map(Where::From).chain(alone.map(Where::One)).collect()
    }

    /// Returns true for each unit to which a correction is applied, and true if these units come before the runs of `place`.
    /// The side of a change with fewer runs is corrected, because the fit to the other side is more accurate.
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

    fn trials(&self, place: Where) -> Vec<Trial> {
        let shape = &self.shape;
        let (is_here, _) = self.corrected(place);
        let [own, others] = [true, false].map(|side| self.side(&self.units, &is_here, side));
        // With fewer samples than coefficients, any correction would fit, so none is tried.
        if own[(0, 0)] < (shape.n_gauges + 2) as f64 {
            return Vec::new();
        }
        let fit = Forward::of(&others, shape);
        let variances = fit.variances(&others, shape);
        let [centred, raw] = [column_means(&own), vec![0.0; shape.width()]]
            .map(|mean| Moments::about(&own, &mean, &fit, shape));
        let trial =
            |cause: Cause, gain: f64| Trial { place, is_here: is_here.clone(), cause, gain };
        let n = own[(0, 0)] * others[(0, 0)] / (own[(0, 0)] + others[(0, 0)]);
        let zeros = fit.zeros(&own, shape);
        let explained: f64 =
            zeros.iter().zip(&variances).map(|(zero, variance)| n * zero * zero / variance).sum();
        let mut all = vec![trial(Cause::Tare, explained)];
        for cause in self.causes() {
            let Some((step, gain)) =
                centred.step(&self.ways(&cause, &fit, Zeros::Free), &variances)
            else {
                continue;
            };
            let scaled = self
                .zeros_of(&cause)
                .contains(&Zeros::Scaled)
                .then(|| raw.step(&self.ways(&cause, &fit, Zeros::Scaled), &variances));
            let gain = scaled.flatten().map_or(gain, |(_, scaled)| gain.max(scaled));
            if !cause.is_exchange() || EXCHANGED.contains(&step[0]) {
                all.push(trial(cause, gain));
            }
        }
        all
    }

    /// Returns the assumptions about zeros that are tried in the correction of a fault. With a single gauge whose zero is
    /// larger than its range, a gain that also scales the zero looks like a tare. [`Zeros::Scaled`] is then not tried.
    fn zeros_of(&self, cause: &Cause) -> Vec<Zeros> {
        let is_ambiguous = self.shape.n_gauges == 1 && self.offset(0).abs() > self.spans[0];
        match cause {
            own if own.is_exchange() => vec![Zeros::Free],
            Cause::Gauge(_) | Cause::AllGauges if !is_ambiguous => {
                vec![Zeros::Kept, Zeros::Free, Zeros::Scaled]
            }
            _ => vec![Zeros::Kept, Zeros::Free],
        }
    }

    fn offset(&self, gauge: usize) -> f64 {
        self.scales[gauge].0 / self.scales[gauge].1
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

    /// Returns the change of the gauges by each parameter of a fault, as coefficients of a constant and of the loads. It is
    /// minus the change of the residuals when the fault is corrected, for gauges that follow the fit exactly.
    fn ways(&self, cause: &Cause, fit: &Forward, zeros: Zeros) -> Vec<Mat<f64>> {
        let (shape, n_gauges) = (&self.shape, self.shape.n_gauges);
        let n_parameters = match cause {
            Cause::Rotation => turns(&shape.axes).len(),
            _ => 1,
        };
        let way = |parameter: usize| {
            // An exchange of columns has no size. Exchanging two gauges again undoes the exchange, so the correction equals
            // the fault.
            let size = match cause {
                Cause::SwappedGauges(..) => -1.0,
                Cause::SwappedAxes(..) => 1.0,
                _ => SMALL,
            };
            let mut step = vec![0.0; n_parameters];
            step[parameter] = size;
            let change = self.change(cause, &step, zeros, fit);
            let gauges = change.subrows(shape.gauge(0), n_gauges);
            let loads = change.subrows(shape.load(0), shape.axes.len());
            let mut left = gauges - fit.map.subcols(1, shape.axes.len()) * loads;
            for gauge in 0..n_gauges {
                left[(gauge, 0)] -= fit.map[(gauge, 0)];
            }
            let followed = left.subcols(shape.gauge(0), n_gauges) * &fit.map;
            Mat::from_fn(n_gauges, 1 + shape.axes.len(), |gauge, input| {
                let column = if input > 0 { shape.load(input - 1) } else { 0 };
                -(left[(gauge, column)] + followed[(gauge, input)]) / size
            })
        };
        (0..n_parameters).map(way).collect()
    }

    fn refits<'a>(&self, trial: &'a Trial) -> Vec<Refit<'a>> {
        match trial.cause {
            Cause::Tare | Cause::Drift => vec![self.refit_zeros(trial)],
            _ => {
                let zeros = self.zeros_of(&trial.cause).into_iter();
                zeros.filter_map(|zeros| self.refit_gains(trial, zeros)).collect()
            }
        }
    }

    /// Fits the correction of a drift of the zeros in time, or of a tare. For a tare, the column of times is
    /// replaced by a column that is 1 in the runs to be corrected and 0 in the others.
    fn refit_zeros<'a>(&self, trial: &'a Trial) -> Refit<'a> {
        let shape = &self.shape;
        let in_step = |(own, here): (&Unit, &bool)| {
            let mut change = shape.unchanged();
            if trial.cause == Cause::Tare {
                change[(1, 1)] = 0.0;
                change[(1, 0)] = if *here { 1.0 } else { 0.0 };
            }
            own.changed(&change)
        };
        let mut units: Vec<Unit> = self.units.iter().zip(&trial.is_here).map(in_step).collect();
        let x = units.iter().map(|own| own.sums[(0, 1)] / own.sums[(0, 0)]).collect();
        let fit = Forward::with_drift(&fits::sum(units.iter(), shape), shape);
        let mut change = shape.unchanged();
        (0..shape.n_gauges).for_each(|gauge| change[(shape.gauge(gauge), 1)] = -fit.drift[gauge]);
        units.iter_mut().for_each(|own| *own = own.changed(&change));
        let back = fits::backward(&fits::sum(units.iter(), shape), shape);
        let zeros = |own: &Unit| loads_of(&back, &fit.zeros(&own.sums, shape));
        let weights = self.units.iter().map(|own| own.sums[(0, 0)]).collect();
        Refit {
            trial,
            parameters: shape.axes.len() as f64,
            values: loads_of(&back, &fit.drift),
            error: error(&units, &self.shape),
            frees_zeros: false,
            chances: self.chances(self.units.iter().map(zeros).collect(), weights, x),
        }
    }

    fn refit_gains<'a>(&self, trial: &'a Trial, zeros: Zeros) -> Option<Refit<'a>> {
        let (shape, Trial { is_here, cause, place, .. }) = (&self.shape, trial);
        let [own, others] = [true, false].map(|side| self.side(&self.units, is_here, side));
        let mut fit = Forward::of(&others, shape);
        let mut variances = fit.variances(&others, shape);
        let (mut factor, mut angles) = (1.0, vec![0.0; turns(&shape.axes).len()]);
        let steps = if cause.is_exchange() { 0 } else { STEPS };
        let mut change = match steps {
            0 => self.change(cause, &[], zeros, &fit),
            _ => shape.unchanged(),
        };
        for _ in 0..steps {
            let now = fits::changed(&own, &change);
            let mean =
                if zeros == Zeros::Free { column_means(&now) } else { vec![0.0; shape.width()] };
            let moments = Moments::about(&now, &mean, &fit, shape);
            let mut step = moments.step(&self.ways(cause, &fit, zeros), &variances)?.0;
            if *cause == Cause::Rotation {
                let length = step.iter().map(|own| own * own).sum::<f64>().sqrt();
                step.iter_mut().for_each(|own| *own *= (0.4 / length).min(1.0));
                angles.iter_mut().zip(&step).for_each(|(all, own)| *all += own);
            } else {
                factor *= 1.0 + step[0];
                let most = if matches!(cause, Cause::Gauge(_)) { MOST_OF_GAUGE } else { 1e4 };
                if !(1.0 / most..most).contains(&factor.abs()) {
                    return None;
                }
            }
            change = self.change(cause, &step, zeros, &fit) * change;
            if zeros == Zeros::Free {
                let left = fit.zeros(&fits::changed(&own, &change), shape);
                left.iter().enumerate().for_each(|(at, zero)| change[(shape.gauge(at), 0)] -= zero);
            }
            let all = fits::changed(&own, &change) + &others;
            fit = Forward::of(&all, shape);
            variances = fit.variances(&all, shape);
        }
        // Gains and axes cannot be compared between runs that load different axes. Only another unit makes the loads of an axis
        // much larger than those of the other runs: millimetres, or centimetres.
        let is_loaded = |own: &Mat<f64>| fits::is_loaded(own, &others, shape);
        let is_unit = [0.01, 0.001].iter().any(|unit| (factor.abs() / unit - 1.0).abs() < 0.1);
        if !is_loaded(&fits::changed(&own, &change)) || !(is_loaded(&own) || is_unit) {
            return None;
        }
        let corrected = self
            .units
            .iter()
            .zip(is_here)
            .map(|(own, here)| if *here { own.changed(&change) } else { own.clone() });
        let units: Vec<Unit> = corrected.collect();
        // For an exchange of columns, its share is estimated from the uncorrected data of each unit.
        let shown = if steps == 0 { &self.units } else { &units };
        let ways = self.ways(cause, &fit, zeros);
        let means = [false, true].map(|side| match zeros {
            Zeros::Scaled => vec![0.0; shape.width()],
            _ => column_means(&self.side(shown, is_here, side)),
        });
        let effect = match cause {
            Cause::Rotation => angles.clone(),
            _ => vec![factor - 1.0],
        };
        // Returns the parameters of the fault as estimated from one unit, and the weight of this estimate.
        let of_unit = |(own, here): (&Unit, &bool)| {
            let moments = Moments::about(&own.sums, &means[usize::from(*here)], &fit, shape);
            let Some((mut step, _)) = moments.step(&ways, &variances) else {
                return (vec![0.0; ways.len()], 0.0);
            };
            if *here {
                step.iter_mut().zip(&effect).for_each(|(value, effect)| *value += effect);
            }
            (step, ways.iter().map(|way| moments.square(way, way, &variances)).sum())
        };
        let (values, weights) = shown.iter().zip(is_here).map(of_unit).unzip();
        let is_before = self.corrected(*place).1;
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
            error: error(&units, &self.shape),
            frees_zeros: n_zeros > 0,
            chances: self.chances(
                values,
                weights,
                is_here.iter().map(|own| f64::from(u8::from(*own))).collect(),
            ),
        })
    }

    /// Returns the matrix that applies one step of a correction to the columns `[1, time, gauges, loads]` of a sample.
    fn change(&self, cause: &Cause, step: &[f64], zeros: Zeros, fit: &Forward) -> Mat<f64> {
        let (shape, n_axes) = (&self.shape, self.shape.axes.len());
        let load = |axis: usize| shape.load(axis);
        let mut change = shape.unchanged();
        match cause {
            Cause::Gauge(gauge) => {
                let (at, factor) = (shape.gauge(*gauge), 1.0 / (1.0 + step[0]));
                let zero = match zeros {
                    Zeros::Scaled => -self.offset(*gauge),
                    _ => fit.map[(*gauge, 0)],
                };
                change[(at, at)] = factor;
                change[(at, 0)] = zero * (1.0 - factor);
            }
            // A factor of all gauges is corrected in the loads, so that errors remain shares of the same full scale.
            Cause::AllGauges => {
                for gauge in (0..shape.n_gauges).filter(|_| zeros == Zeros::Scaled) {
                    let zero = fit.map[(gauge, 0)] + self.offset(gauge);
                    change[(shape.gauge(gauge), 0)] = -step[0] * zero;
                }
                (0..n_axes).map(load).for_each(|at| change[(at, at)] += step[0]);
            }
            Cause::SwappedGauges(a, b) => {
                for (to, from) in [(*a, *b), (*b, *a)] {
                    let [own, other] = [to, from].map(|at| self.scales[at]);
                    let [to, from] = [to, from].map(|at| shape.gauge(at));
                    change[(to, to)] = 0.0;
                    change[(to, from)] = other.1 / own.1;
                    change[(to, 0)] = (other.0 - own.0) / own.1;
                }
            }
            Cause::Axes(own) => {
                own.iter().for_each(|axis| change[(load(*axis), load(*axis))] += step[0]);
            }
            // Loads are shares of full scale, but the columns of the file are in N or N·m.
            Cause::SwappedAxes(a, b) => {
                for (to, from) in [(*a, *b), (*b, *a)] {
                    let ratio = shape.full_scale[from] / shape.full_scale[to];
                    change[(load(to), load(to))] = 0.0;
                    change[(load(to), load(from))] = ratio;
                }
            }
            Cause::Rotation => {
                let turn = turned(shape, step);
                change.submatrix_mut(load(0), load(0), n_axes, n_axes).copy_from(&turn);
            }
            _ => {}
        }
        change
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
        let columns = |gauges: &[f64], row: &mut Vec<f64>| row.extend(self.standard(gauges));
        error(&units(recordings, &self.runs, &self.shape, columns, is_used), &self.shape)
    }

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

    /// Returns the probability that the values of units follow a straight line in `x` by chance: once from the scatter of
    /// units, once from that of runs.
    fn chances(&self, values: Vec<Vec<f64>>, weights: Vec<f64>, x: Vec<f64>) -> [f64; 2] {
        let of_units = chance::of_slope(&values, &weights, &x);
        if self.n_runs() < ENOUGH_RUNS {
            return [of_units, 0.0];
        }
        let x: Vec<Vec<f64>> = x.into_iter().map(|own| vec![own]).collect();
        let x = self.by_run(&x, &weights).0.concat();
        let (values, weights) = self.by_run(&values, &weights);
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

/// Returns the loads, as shares of full scale, that a calibration computes from these zeros of the gauges.
fn loads_of(back: &Mat<f64>, zeros: &[f64]) -> Vec<f64> {
    let of_axis =
        |axis: usize| zeros.iter().enumerate().map(|(at, zero)| back[(axis, at)] * zero).sum();
    (0..back.nrows()).map(of_axis).collect()
}

/// Returns the directions (0 for x, 1 for y, 2 for z) about which a turn of the frame mixes measured axes.
fn turns(axes: &[Axis]) -> Vec<usize> {
    let has = |at: usize| axes.contains(&Axis::ALL[at]);
    let others = |about: usize| [(about + 1) % 3, (about + 2) % 3];
    let mixes = |about: &usize| {
        let [a, b] = others(*about);
        (has(a) && has(b)) || (has(a + 3) && has(b + 3))
    };
    (0..3).filter(mixes).collect()
}

/// Returns the matrix that changes loads, as shares of full scale, by a small turn about a direction: `about × load`.
fn generator(shape: &Shape, about: usize) -> Mat<f64> {
    let n = shape.axes.len();
    Mat::from_fn(n, n, |i, j| {
        let (to, from) = (shape.axes[i], shape.axes[j]);
        let ratio = shape.full_scale[j] / shape.full_scale[i];
        match (3 + to as usize % 3 - about) % 3 * 3 + (3 + from as usize % 3 - about) % 3 {
            _ if to.is_force() != from.is_force() => 0.0,
            7 => ratio,
            5 => -ratio,
            _ => 0.0,
        }
    })
}

/// Returns the matrix of a turn by angles (rad) about the directions of [`turns`], by the exponential series. The angles must
/// be below one.
fn turned(shape: &Shape, angles: &[f64]) -> Mat<f64> {
    let n = shape.axes.len();
    let all = turns(&shape.axes).into_iter().zip(angles);
    let turn = all.fold(Mat::<f64>::zeros(n, n), |all, (about, angle)| {
        all + faer::Scale(*angle) * generator(shape, about)
    });
    let series = (1..10).rev();
    series.fold(Mat::identity(n, n), |inner, k| {
        Mat::<f64>::identity(n, n) + faer::Scale(1.0 / f64::from(k)) * (&turn * inner)
    })
}
