//! Whether recordings carry a model: what they reach, how many loads they hold for its coefficients, which loads move together,
//! what rests on a single recording, and which load to add next.
//!
//! Guarantees: a figure that the data do not carry is missing; a verdict never stands without its reasons.

use serde::Serialize;

use crate::calibration::NormalEquations;
use crate::recording::Axis;
use crate::scoring::coverage::Outside;
use crate::scoring::numbers::significant;

/// Below so many load cases for a coefficient an error on new loads is five times that of the fit, by the count alone.
const FEWEST_CASES: f64 = 1.25;
/// Below so many it is twice.
const FEW_CASES: f64 = 2.0;
/// A left-out error so many times that of the fit is said ...
const RATIO_SAID: f64 = 2.0;
/// ... and one so many times says that the coefficients are made of noise, where it is more than [`ERROR_MATTERS`].
const RATIO_FAILS: f64 = 5.0;
/// Of full scale.
const ERROR_MATTERS: f64 = 0.01;
/// Of what a load varies by: a left-out error beyond it is no better than its mean.
const NO_BETTER: f64 = 0.9;
/// Two axes with this correlation are named.
const CORRELATED: f64 = 0.8;
/// The variance of what an axis does beside the others is this much smaller than its own: it is hard to tell from them.
const INFLATION_SAID: f64 = 5.0;
/// Loads that move along a direction with a smaller share than this of an axis' variance do not move along it.
const DIRECTION: f64 = 1e-3;
/// What a rated load is reached by.
const REACHED: f64 = 0.8;
/// A recording matters by more than this share of what determines the coefficients, one of a single load by that of what it can at most ...
const LEVERAGE_SHARE: f64 = 0.5;
/// ... and by so many times its share of the samples.
const LEVERAGE_TIMES: f64 = 3.0;
/// Of the test samples.
const OUTSIDE_SHARE: f64 = 0.05;
/// Of the training samples.
const FAULTY_SHARE: f64 = 0.05;
/// A condition number from which some combinations of features are hardly determined.
const CONDITION: f64 = 1e4;

/// What becomes of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing speaks against it.
    Enough,
    /// It may do, and there is something to know.
    Doubtful,
    /// The coefficients say more about noise than about the sensor.
    Insufficient,
}

impl Verdict {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Enough => "Enough: the data carry the model",
            Self::Doubtful => "Doubtful: the data carry the model only in part",
            Self::Insufficient => "Not enough: the data do not carry the model",
        }
    }
}

/// A sentence, and what it makes of the verdict at least.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reason {
    /// What it is about, in a word that stays the same.
    pub about: &'static str,
    /// What it makes of the verdict; what is only to be known leaves it at enough.
    pub verdict: Verdict,
    /// A sentence without its full stop.
    pub text: String,
}

/// What is known of recordings and a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sufficiency {
    /// The worst of its reasons.
    pub verdict: Verdict,
    /// Coefficients and load cases in words.
    pub summary: String,
    /// What is wrong with recordings, then the gravest first.
    pub reasons: Vec<Reason>,
    /// Training samples.
    pub n_samples: u64,
    /// Loads that can be told apart; with a past, how often the load becomes another one.
    pub load_cases: usize,
    /// Coefficients of an axis.
    pub coefficients: usize,
    /// How many of them are free, with the ridge, on the axis with most.
    pub free_coefficients: f64,
    /// How many features are independent.
    pub rank: usize,
    /// The condition number of the design.
    pub condition: Option<f64>,
    /// What each axis reaches.
    pub axes: Vec<AxisReach>,
    /// What each two axes reach together.
    pub pairs: Vec<Pair>,
    /// Combinations of features that nothing determines, or hardly anything.
    pub undetermined: Vec<String>,
    /// What rests on each training recording.
    pub leverage: Vec<Leverage>,
    /// Loads outside those of the others.
    pub outside: Vec<OutsideOf>,
    /// What is wrong with channels, for each training recording in words.
    pub faults: Vec<String>,
    /// What to record next, the best first.
    pub next: Vec<NextLoad>,
    /// What is to be known of these, or why there are none.
    pub next_note: String,
    /// One load of each case, for pictures.
    #[serde(skip)]
    pub cases: Vec<Vec<f64>>,
}

/// What an axis reaches.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisReach {
    /// Which.
    pub axis: Axis,
    /// The least training load.
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// The full scale, 0 where the load does not move.
    pub full_scale: f64,
    /// Whether somebody entered it.
    pub rated: bool,
    /// From where to where loads are to be expected: the rated ones, or those that there are.
    pub region: (f64, f64),
    /// The standard deviation of the training loads.
    pub deviation: f64,
    /// How much smaller the variance is of what the axis does beside the others; 1 where it goes alone.
    pub inflation: Option<f64>,
    /// The error on the training samples.
    pub train_rmse: Option<f64>,
    /// The error where recordings, groups or blocks are left out.
    pub left_out_rmse: Option<f64>,
    /// The error where load cases are left out.
    pub load_left_out_rmse: Option<f64>,
}

/// What two axes reach together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Which.
    pub axes: [Axis; 2],
    /// The correlation of their training loads; `None` where one does not move.
    pub correlation: Option<f64>,
    /// The share of the rectangle of both [regions](AxisReach::region) that the training loads enclose.
    pub covered: Option<f64>,
}

/// What rests on a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Leverage {
    /// Its name.
    pub recording: String,
    /// Its share of the training samples.
    pub sample_share: f64,
    /// How much of what determines the coefficients comes from it: over all recordings it adds up to the rank.
    pub leverage: f64,
    /// The same as a share.
    pub share: f64,
    /// What it can be at most: the rank, or one where the recording holds a single load.
    pub most: f64,
}

/// Loads of a recording or group outside those of the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutsideOf {
    /// The test recordings, or a group that is left out.
    pub of: String,
    /// Whether it is the test.
    pub is_test: bool,
    /// Which axis.
    pub axis: Axis,
    /// The share of its samples.
    pub share: f64,
    /// How far the farthest lies beyond.
    pub farthest: f64,
}

impl OutsideOf {
    /// Of a recording or a group.
    pub fn new(of: impl Into<String>, is_test: bool, axis: Axis, outside: Outside) -> Self {
        let Outside { share, farthest } = outside;
        Self { of: of.into(), is_test, axis, share, farthest }
    }
}

/// A load that is worth recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextLoad {
    /// One number per axis.
    pub load: Vec<f64>,
    /// How it is made of a hanging mass, in words.
    pub how: Option<String>,
    /// By how much the logarithm of the determinant of the design grows.
    pub gain: f64,
    /// What is left of the variance of predictions, with it and those before it.
    pub variance_left: f64,
}

/// Mean and spread of loads, and how they go together.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadSpread {
    /// The standard deviation of each axis.
    pub deviations: Vec<f64>,
    /// `n_axes × n_axes`; `None` where one does not move.
    pub correlations: Vec<Option<f64>>,
    /// See [`AxisReach::inflation`].
    pub inflations: Vec<Option<f64>>,
    /// The combination of axes that moves least, each in its standard deviations, and the standard deviation of it; `None`
    /// with fewer than two that move.
    pub stiffest: Option<(Vec<f64>, f64)>,
    /// In how many independent directions the loads move.
    pub n_directions: usize,
}

impl LoadSpread {
    /// Of these loads.
    pub fn of<'a>(loads: impl Iterator<Item = &'a [f64]> + Clone, ranges: &[(f64, f64)]) -> Self {
        let n_axes = ranges.len();
        let n = loads.clone().count().max(1) as f64;
        let mut mean = vec![0.0; n_axes];
        for load in loads.clone() {
            mean.iter_mut().zip(load).for_each(|(sum, load)| *sum += load / n);
        }
        let mut products = vec![0.0; n_axes * n_axes];
        for load in loads {
            for i in 0..n_axes {
                for j in 0..=i {
                    products[i * n_axes + j] += (load[i] - mean[i]) * (load[j] - mean[j]) / n;
                }
            }
        }
        let moves = |axis: usize| ranges[axis].1 > ranges[axis].0;
        let deviations: Vec<f64> = (0..n_axes)
            .map(|axis| if moves(axis) { products[axis * n_axes + axis].sqrt() } else { 0.0 })
            .collect();
        let correlation = |i: usize, j: usize| {
            let both = deviations[i] * deviations[j];
            let product = products[i.max(j) * n_axes + i.min(j)];
            (both > 0.0).then(|| if i == j { 1.0 } else { (product / both).clamp(-1.0, 1.0) })
        };
        let correlations: Vec<Option<f64>> =
            (0..n_axes * n_axes).map(|at| correlation(at / n_axes, at % n_axes)).collect();
        let moving: Vec<usize> = (0..n_axes).filter(|axis| deviations[*axis] > 0.0).collect();
        let (mut inflations, mut stiffest, mut n_directions) = (vec![None; n_axes], None, 0);
        let n_moving = moving.len();
        let among = faer::Mat::from_fn(n_moving, n_moving, |i, j| {
            correlations[moving[i] * n_axes + moving[j]].unwrap_or(0.0)
        });
        let parts = (n_moving > 0).then(|| among.self_adjoint_eigen(faer::Side::Lower));
        if let Some(Ok(parts)) = parts {
            let (squares, directions) = (parts.S().column_vector(), parts.U());
            n_directions = (0..n_moving).filter(|at| squares[*at] > DIRECTION).count();
            let least = (0..n_moving).min_by(|a, b| squares[*a].total_cmp(&squares[*b]));
            for (at, axis) in moving.iter().enumerate() {
                let parts =
                    (0..n_moving).map(|k| directions[(at, k)].powi(2) / squares[k].max(1e-12));
                inflations[*axis] = Some(parts.sum());
            }
            if let Some(least) = least.filter(|_| n_moving > 1) {
                let mut direction = vec![0.0; n_axes];
                for (at, axis) in moving.iter().enumerate() {
                    direction[*axis] = directions[(at, least)];
                }
                stiffest = Some((direction, squares[least].max(0.0).sqrt()));
            }
        }
        Self { deviations, correlations, inflations, stiffest, n_directions }
    }
}

/// The share of a rectangle that points enclose: their convex hull within it. `None` where the rectangle has no area.
pub fn enclosed(
    points: impl Iterator<Item = [f64; 2]>,
    across: (f64, f64),
    up: (f64, f64),
) -> Option<f64> {
    let (width, height) = (across.1 - across.0, up.1 - up.0);
    if width <= 0.0 || height <= 0.0 {
        return None;
    }
    let scaled = |[x, y]: [f64; 2]| {
        [((x - across.0) / width).clamp(0.0, 1.0), ((y - up.0) / height).clamp(0.0, 1.0)]
    };
    let mut points: Vec<[f64; 2]> = points.map(scaled).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    // Lower hull from left to right, upper hull back: each turns left only (Andrew 1979).
    let cross = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let mut hull: Vec<[f64; 2]> = Vec::new();
    let mut half = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let start = hull.len();
        for point in points {
            while hull.len() >= start + 2
                && cross(hull[hull.len() - 2], hull[hull.len() - 1], *point) <= 0.0
            {
                hull.pop();
            }
            hull.push(*point);
        }
        hull.pop();
    };
    half(&mut points.iter());
    half(&mut points.iter().rev());
    let twice: f64 = (0..hull.len())
        .map(|at| {
            let ([x, y], [u, v]) = (hull[at], hull[(at + 1) % hull.len()]);
            x * v - u * y
        })
        .sum();
    Some(0.5 * twice)
}

/// A share in percent; a small one is not called none.
pub fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 2))
}

impl Sufficiency {
    /// Adds what follows from its figures to the reasons that are there, and settles the verdict.
    pub fn judged(mut self, spread: &LoadSpread, cross_validation: Option<&str>) -> Self {
        let mut found = std::mem::take(&mut self.reasons);
        let mut say = |about, verdict, text: String| found.push(Reason { about, verdict, text });
        use Verdict::{Doubtful, Enough};
        self.summary = self.count(&mut say);
        self.say_errors(cross_validation, &mut say);
        for own in &self.axes {
            own.say_reach(&mut say);
        }
        self.say_coupling(spread, &mut say);
        if self.condition.is_some_and(|condition| condition > CONDITION) {
            let condition = significant(self.condition.unwrap_or(0.0), 2);
            say(
                "undetermined",
                Doubtful,
                format!(
                    "some combinations of features are hardly determined (condition number {condition}): their coefficients are \
                     large, and cancel on loads like these alone; a ridge, fewer blocks or other loads",
                ),
            );
        }
        let grave = |own: &&Leverage| {
            own.leverage > LEVERAGE_SHARE * own.most
                && own.share > LEVERAGE_TIMES * own.sample_share
                && self.leverage.len() > 2
        };
        if let Some(own) = self.leverage.iter().find(grave) {
            say(
                "leverage",
                Doubtful,
                match own.most < self.rank as f64 {
                    true => format!(
                        "{} of what the fit says of {} comes from it alone: no other load is like it, and an error in it goes straight \
                         into the matrix; repeat such loads",
                        percent((own.leverage / own.most).min(1.0)),
                        own.recording,
                    ),
                    false => format!(
                        "{} of what determines the coefficients rests on {} alone, with {} of the samples: an error in it goes \
                         straight into the matrix; repeat such loads",
                        percent(own.share),
                        own.recording,
                        percent(own.sample_share),
                    ),
                },
            );
        }
        let far = |own: &&OutsideOf| !own.is_test && own.share > OUTSIDE_SHARE;
        let groups: Vec<&OutsideOf> = self.outside.iter().filter(far).collect();
        if let Some(worst) = groups.iter().max_by(|a, b| a.share.total_cmp(&b.share)) {
            let others = groups.iter().filter(|own| own.of != worst.of);
            let others: std::collections::BTreeSet<&str> = others.map(|own| &*own.of).collect();
            let others = match others.len() {
                0 => String::new(),
                1 => ", and so does one other".to_owned(),
                n => format!(", and so do {n} others"),
            };
            let text = format!(
                "{} of the samples of {} load {} beyond all other training recordings{others}: left out, it is predicted by an \
                 extrapolation",
                percent(worst.share),
                worst.of,
                worst.axis.symbol(),
            );
            say("outside", Enough, text);
        }
        // What is wrong with a recording comes before what that makes of the errors.
        let is_cause = |reason: &Reason| matches!(reason.about, "no_gauge" | "odd" | "faults");
        found.sort_by_key(|reason| {
            let grave = reason.verdict > Enough;
            (!(grave && is_cause(reason)), std::cmp::Reverse(reason.verdict))
        });
        self.verdict = found.iter().map(|own| own.verdict).max().unwrap_or(Enough);
        self.reasons = found;
        self
    }

    /// The reasons, and the count where it is none of them.
    pub fn sentences(&self) -> impl Iterator<Item = &str> {
        let counts = self.reasons.iter().any(|reason| reason.about == "load_cases");
        let summary = (!counts).then_some(&*self.summary);
        self.reasons.iter().map(|reason| &*reason.text).chain(summary)
    }

    /// Rank and condition of the design in words.
    pub fn rank_in_words(&self) -> String {
        let rank = format!("Rank {} of {} features", self.rank, self.coefficients);
        let rank = match self.rank < self.coefficients {
            true => format!("{rank}, the others repeating these or never changing"),
            false => rank,
        };
        let Some(condition) = self.condition else {
            return format!("{rank}.");
        };
        if self.rank < 2 {
            return format!("{rank}.");
        }
        let words = match condition {
            ..30.0 => "each feature says something of its own",
            ..1e3 => "some features nearly repeat each other",
            ..CONDITION => "some combinations of features are far less certain than others",
            _ => "some combinations of features are hardly determined",
        };
        format!("{rank}, condition number {}: {words}.", significant(condition, 3))
    }

    /// Coefficients and load cases in words.
    fn count(&self, say: &mut impl FnMut(&'static str, Verdict, String)) -> String {
        let (n, p) = (self.load_cases as f64, self.free_coefficients);
        let few = format!("{:.0}", p.ceil());
        let coefficients = match (p.ceil() as usize) < self.coefficients {
            true => format!("{} coefficients an axis ({few} of them free)", self.coefficients),
            false => format!("{} coefficients an axis", self.coefficients),
        };
        let cases = match self.load_cases {
            1 => "1 load case".to_owned(),
            n => format!("{n} load cases"),
        };
        let from = format!("{coefficients} from {cases}");
        // Of random loads: `E[test MSE] / E[train MSE] = (1 + p/(n−p−1)) / (1 − p/n)`.
        let times = (n > p + 1.0).then(|| ((n - 1.0) / (n - p - 1.0) * n / (n - p)).sqrt());
        let times = times.filter(|times| *times < 100.0);
        let expected = times.map_or_else(String::new, |times| {
            format!(
                ": by the count alone, errors on other loads are about {} times those of the fit",
                significant(times, 2)
            )
        });
        // What loads that were left out say counts for more than how many there are.
        let times = |own: &AxisReach| Some(own.load_left_out_rmse? / own.train_rmse?);
        let known: Option<Vec<f64>> = self.axes.iter().map(times).collect();
        let bears_out = known.is_some_and(|times| times.iter().all(|times| *times <= RATIO_SAID));
        let fails = match bears_out {
            true => Verdict::Doubtful,
            false => Verdict::Insufficient,
        };
        let advice = match bears_out {
            true => "; left out one by one, though, these loads are predicted nearly as well",
            false => "; record more loads, or take fewer features or a ridge",
        };
        if n <= p.ceil() {
            let text = format!(
                "{from}: no more loads than coefficients, so some of these say nothing but noise"
            );
            say("load_cases", fails, format!("{text}{advice}"));
            text
        } else if n < FEW_CASES * p {
            let verdict = match n < FEWEST_CASES * p {
                true => fails,
                false => Verdict::Doubtful,
            };
            say("load_cases", verdict, format!("{from}{expected}{advice}"));
            format!("{from}{expected}")
        } else {
            format!("{from}, {} samples", self.n_samples)
        }
    }
}

impl Sufficiency {
    /// What the left-out errors say beside those of the fit.
    fn say_errors(&self, by: Option<&str>, say: &mut impl FnMut(&'static str, Verdict, String)) {
        type Error = fn(&AxisReach) -> Option<f64>;
        let ways: [(Error, Option<&str>); 2] =
            [(|own| own.left_out_rmse, by), (|own| own.load_left_out_rmse, Some("by load case"))];
        let is_lost =
            |own: &AxisReach, error: f64| own.deviation > 0.0 && error >= NO_BETTER * own.deviation;
        let mut worst: Option<(f64, Verdict, String)> = None;
        let mut is_said = false;
        for (error, by) in ways {
            let errors = self.axes.iter().filter_map(|own| Some((own, error(own)?)));
            let errors: Vec<(&AxisReach, f64)> = errors.collect();
            let Some(by) = by else {
                continue;
            };
            let lost = errors.iter().filter(|(own, error)| is_lost(own, *error));
            let lost: Vec<String> = lost
                .map(|(own, error)| {
                    format!(
                        "{} errs by {} (its mean alone by {})",
                        own.axis.symbol(),
                        own.load(*error),
                        own.load(own.deviation)
                    )
                })
                .collect();
            if !lost.is_empty() && !is_said {
                is_said = true;
                let text = format!("left out {by}, {}: no better than a guess", lost.join(", "));
                say("error", Verdict::Insufficient, text);
            }
            let times = errors
                .into_iter()
                .filter(|(own, error)| !is_lost(own, *error) && *error > 1e-9 * own.deviation);
            let times = times.filter_map(|(own, error)| {
                Some((own, error, error / own.train_rmse?.max(1e-9 * own.deviation)))
            });
            let mut times: Vec<(&AxisReach, f64, f64)> =
                times.filter(|(_, _, times)| *times > RATIO_SAID).collect();
            times.sort_by(|a, b| b.2.total_cmp(&a.2));
            let Some((own, error, most)) = times.first().copied() else {
                continue;
            };
            let fails = |(own, error, times): &(&AxisReach, f64, f64)| {
                *times > RATIO_FAILS && *error > ERROR_MATTERS * own.full_scale
            };
            let verdict =
                if times.iter().any(fails) { Verdict::Insufficient } else { Verdict::Doubtful };
            let others: Vec<String> = times[1..]
                .iter()
                .map(|(own, _, times)| format!("{} {}", own.axis.symbol(), significant(*times, 2)))
                .collect();
            let others = if others.is_empty() {
                String::new()
            } else {
                format!("; times for the others: {}", others.join(", "))
            };
            let text = format!(
                "left out {by}, {} errs by {}, {} times the {} of the fit{others}",
                own.axis.symbol(),
                own.load(error),
                significant(most, 2),
                own.load(own.train_rmse.unwrap_or(0.0)),
            );
            if worst.as_ref().is_none_or(|(before, ..)| most > *before) {
                worst = Some((most, verdict, text));
            }
        }
        if let Some((_, verdict, text)) = worst {
            say("error_ratio", verdict, text);
        }
    }

    /// Which axes move together.
    fn say_coupling(
        &self,
        spread: &LoadSpread,
        say: &mut impl FnMut(&'static str, Verdict, String),
    ) {
        let n_moving = spread.deviations.iter().filter(|own| **own > 0.0).count();
        if spread.n_directions < n_moving
            && let Some((direction, deviation)) = &spread.stiffest
        {
            let terms = direction.iter().zip(&self.axes).filter(|(part, _)| part.abs() > 0.2);
            let terms: Vec<String> =
                terms.map(|(part, own)| format!("{part:+.2} {}", own.axis.symbol())).collect();
            let text = format!(
                "the loads of {n_moving} axes move in {} independent directions only: along {} (each axis in its standard \
                 deviations) by {} of what an axis does, so what the matrix says there is not of these loads; load these axes one \
                 without the other",
                spread.n_directions,
                terms.join(" "),
                percent(*deviation),
            );
            say("correlation", Verdict::Insufficient, text);
        }
        let mut named = Vec::new();
        for pair in &self.pairs {
            if let Some(r) = pair.correlation.filter(|r| r.abs() >= CORRELATED) {
                let [a, b] = pair.axes.map(Axis::symbol);
                named.extend(pair.axes);
                let how = if r > 0.0 { "together" } else { "against each other" };
                let text = format!(
                    "{a} and {b} move {how} (correlation {r:.2}): what the gauges make of one can hardly be told from what they \
                     make of the other; load {a} without {b}, with a mass on another arm for instance"
                );
                say("correlation", Verdict::Doubtful, text);
            }
        }
        for own in &self.axes {
            if let Some(inflation) = own.inflation.filter(|inflation| *inflation >= INFLATION_SAID)
                && !named.contains(&own.axis)
                && spread.n_directions == n_moving
            {
                let (symbol, share) = (own.axis.symbol(), percent(1.0 - 1.0 / inflation));
                let text = format!(
                    "{share} of what {symbol} does follows from the other axes: it was hardly ever loaded on its own"
                );
                say("correlation", Verdict::Doubtful, text);
            }
        }
    }
}

impl AxisReach {
    fn load(&self, value: f64) -> String {
        format!("{} {}", significant(value, 3), self.axis.unit())
    }

    /// How much of a rated load was reached.
    fn say_reach(&self, say: &mut impl FnMut(&'static str, Verdict, String)) {
        if !self.rated || self.full_scale <= 0.0 || self.deviation == 0.0 {
            return;
        }
        let ends = [(self.region.0, self.low), (self.region.1, self.high)];
        let reached = ends.into_iter().filter(|(end, _)| *end != 0.0);
        let short: Vec<String> = reached
            .map(|(end, reached)| (end, (reached / end).max(0.0)))
            .filter(|(_, share)| *share < REACHED)
            .map(|(end, share)| format!("{} of {}", percent(share), self.load(end)))
            .collect();
        if !short.is_empty() {
            let text = format!(
                "{} reaches {} only: beyond that the matrix extrapolates; record larger loads",
                self.axis.symbol(),
                short.join(" and ")
            );
            say("reach", Verdict::Doubtful, text);
        }
    }
}

/// What each test recording axis lies outside by, in doubt from a share on.
pub fn is_far_outside(outside: &Outside) -> bool {
    outside.share > OUTSIDE_SHARE
}

/// What samples that cannot be trusted make of the verdict.
pub fn faults_verdict(share: f64) -> Verdict {
    match share > FAULTY_SHARE {
        true => Verdict::Doubtful,
        false => Verdict::Enough,
    }
}

/// What of a recording tells how much rests on it.
#[derive(Debug)]
pub struct Part {
    /// Its name.
    pub recording: String,
    /// Its sums.
    pub sums: NormalEquations,
    /// Whether it holds a single load.
    pub is_one_load: bool,
}

/// The leverages of recordings, by an [`Information`](crate::scoring::information::Information).
pub fn leverages(
    information: &crate::scoring::information::Information,
    recordings: &[Part],
) -> Vec<Leverage> {
    let n: u64 = recordings.iter().map(|own| own.sums.n_samples()).sum();
    let of: Vec<f64> = recordings.iter().map(|own| information.leverage(&own.sums)).collect();
    let all: f64 = of.iter().sum();
    let own = recordings.iter().zip(of).map(|(own, leverage)| Leverage {
        recording: own.recording.clone(),
        sample_share: own.sums.n_samples() as f64 / n.max(1) as f64,
        leverage,
        share: if all > 0.0 { leverage / all } else { 0.0 },
        most: if own.is_one_load { all.min(1.0) } else { all },
    });
    let mut found: Vec<Leverage> = own.collect();
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NumPy 2: `std`, `corrcoef`, the diagonal of the inverse of the correlations, `eigh`; SciPy: `ConvexHull`.
    #[test]
    fn spread_and_hull_are_those_of_numpy_and_scipy() {
        let load = |k: usize| {
            let k = k as f64;
            let (a, b, c) = ((0.1 * k).sin(), (0.23 * k).cos(), (0.71 * k).sin());
            [a, b + 0.5 * a, a - 0.8 * b + 0.1 * c]
        };
        let loads: Vec<[f64; 3]> = (0..200).map(load).collect();
        let range = |axis: usize| {
            let of = loads.iter().map(|load| load[axis]);
            (of.clone().fold(f64::INFINITY, f64::min), of.fold(f64::NEG_INFINITY, f64::max))
        };
        let ranges = [0, 1, 2].map(range);
        let spread = LoadSpread::of(loads.iter().map(|load| &load[..]), &ranges);
        let close = |own: f64, expected: f64| {
            assert!((own / expected - 1.0).abs() < 1e-6, "{own} for {expected}")
        };
        close(spread.deviations[2], 0.89315314);
        close(spread.correlations[1].unwrap(), 0.45625773);
        close(spread.correlations[5].unwrap(), -0.20904261);
        close(spread.inflations[0].unwrap(), 193.67488842);
        close(spread.inflations[1].unwrap(), 81.83309821);
        let (direction, deviation) = spread.stiffest.unwrap();
        close((direction[1] / direction[0]).abs(), 0.43221072 / 0.66712353);
        assert!((deviation.powi(2) - 0.00230162).abs() < 1e-7);
        assert_eq!(spread.n_directions, 3);
        let points = loads.iter().map(|load| [load[0], load[1]]);
        close(enclosed(points, ranges[0], ranges[1]).unwrap(), 0.6822455183690698);
    }

    #[test]
    fn a_line_encloses_nothing_a_cross_half_and_corners_all() {
        let square = |points: &[[f64; 2]]| {
            enclosed(points.iter().copied(), (-1.0, 1.0), (-1.0, 1.0)).unwrap()
        };
        assert_eq!(square(&[[-1.0, -1.0], [0.0, 0.0], [1.0, 1.0]]), 0.0);
        assert_eq!(square(&[[-1.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [0.0, 0.0]]), 0.5);
        assert_eq!(square(&[[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [9.0, 0.0]]), 1.0);
        assert_eq!(square(&[]), 0.0);
        assert_eq!(square(&[[0.3, 0.3]]), 0.0);
        assert_eq!(enclosed([].into_iter(), (1.0, 1.0), (0.0, 1.0)), None);
    }
}
