//! What has to be known beside the scores: what the recordings cannot tell, each with its figure and the way out.
//!
//! Found once; window, command line and report show this list.

use std::collections::BTreeSet;

use crate::calibration::{Calibration, GridEdge, OddRecording, Undetermined};
use crate::features::{Auxiliary, AuxiliaryChannel};
use crate::progress::Progress;
use crate::questions::check::independent_loads::{is_far_outside, percent};
use crate::questions::dataset::Dataset;
use crate::questions::error::AnalysisError;
use crate::questions::request::Request;
use crate::recording::{Axis, LoneGroup, RECORDING, Role, UnusedGroups};
use crate::scoring::coverage::{Outside, largest};
use crate::scoring::cross_validation::{BLOCKS, FEWEST_RECORDINGS};
use crate::scoring::no_gauge::NoGauge;
use crate::scoring::numbers::significant;

/// An axis that moves by less than this share of its full scale, or of the axis of its unit that moves most, stands still.
pub(crate) const STANDS_STILL: f64 = 0.02;
/// Fewer load cases than so many for each feature leave the fit to chance.
const CASES_PER_FEATURE: usize = 2;

/// A test error so many times that of cross-validation says that the recordings are of another kind ...
const FAR_OFF: f64 = 4.0;
/// ... where it is more than this share of full scale.
const FAR_OFF_MATTERS: f64 = 0.02;
/// So many recordings that contradict the others are named.
const ODD_NAMED: usize = 3;
/// So many columns that are no gauges are named.
const NO_GAUGES_NAMED: usize = 6;

/// One thing to know beside the scores.
#[derive(Clone, Debug, PartialEq)]
pub enum Caution {
    /// Nothing tests the calibration.
    NoTest,
    /// The training recordings have no times: so many load cases, of so many rows.
    LoadCases(usize, usize),
    /// The fit can go through every sample.
    Undetermined(Undetermined),
    /// Why there is no cross-validation.
    NotLeftOut(&'static str),
    /// Blocks of so many training recordings are left out, for want of more.
    Blocks(usize),
    /// Recordings that know each other are left out one by one.
    Groups(UnusedGroups),
    /// A group that was set and that alone loads an axis.
    Lone(LoneGroup),
    /// An axis that hardly moves, from where to where, and the most that one of its unit does.
    Still(Axis, (f64, f64), f64),
    /// Test loads on an axis that lie outside what was trained.
    Outside(Axis, (f64, f64), Outside),
    /// Features, and how many load cases there are for them.
    FewLoads(usize, usize),
    /// How many of so many features are independent.
    Rank(usize, usize),
    /// The kernel's ridge stands at an end of what is tried.
    KernelRidge(GridEdge, f64),
    /// The axes on which a second stage brings too little on left-out samples.
    LinearAlone(Vec<Axis>),
    /// Auxiliary channels were asked for and cannot be used, each with its reason.
    Auxiliary(Vec<String>),
    /// Auxiliary channels of recordings that were not trained show what was not trained.
    AuxiliaryBeyond(Vec<String>),
    /// The recordings have auxiliary channels that change, and the model does not use them.
    AuxiliaryLeft(Vec<String>),
    /// Columns that are taken for gauges and seem to be none.
    NoGauge(Vec<NoGauge>),
    /// Training recordings that contradict the others.
    Odd(Vec<OddRecording>),
    /// The axis on which the test errs far more than the cross-validation, by how much, and by how much that does.
    FarOff(Axis, f64, f64),
    /// The axes on which the test says that compensating does harm.
    Worse(Vec<Axis>),
}

/// What is to be known of a fit to these recordings beside its scores; of an applied calibration only what the test says.
///
/// # Errors
/// [`AnalysisError`] where there are no recordings to look at.
pub fn cautions(
    request: &Request,
    calibration: &Calibration,
    progress: &Progress,
) -> Result<Vec<Caution>, AnalysisError> {
    let data = request.datasets.get(&request.key(), progress)?;
    let fitted = request.calibration.is_none() || request.trained;
    Ok(data.cautions(calibration, fitted))
}

impl Dataset {
    /// See [`cautions`].
    pub(crate) fn cautions(&self, calibration: &Calibration, fitted: bool) -> Vec<Caution> {
        let mut found = Vec::new();
        let in_role = |role: Role| self.entries.iter().filter(move |entry| entry.role == role);
        if in_role(Role::Test).next().is_none() {
            found.push(Caution::NoTest);
        }
        if fitted && in_role(Role::Train).any(|entry| entry.recording.is_static()) {
            let mut cases: Vec<usize> = (self.entries.iter().zip(&self.groups.of))
                .filter(|(entry, _)| entry.role == Role::Train)
                .map(|(_, group)| *group)
                .collect();
            cases.sort_unstable();
            cases.dedup();
            let n_rows = in_role(Role::Train).map(|entry| entry.recording.n_samples()).sum();
            found.push(Caution::LoadCases(cases.len(), n_rows));
        }
        if fitted {
            found.extend(calibration.undetermined().map(Caution::Undetermined));
            found.extend(self.unused_auxiliary(calibration).map(Caution::Auxiliary));
            found.extend(self.left_auxiliary(calibration).map(Caution::AuxiliaryLeft));
        }
        let shown = self.entries.iter().filter(|entry| entry.role != Role::Train || !fitted);
        let channels = calibration.features.auxiliary.iter();
        let counted = channels.filter_map(AuxiliaryChannel::reference_beyond);
        let beyond: Vec<String> = shown
            .flat_map(|entry| calibration.auxiliary_beyond(&entry.recording))
            .chain(counted)
            .collect();
        found.extend((!beyond.is_empty()).then_some(Caution::AuxiliaryBeyond(beyond)));
        found.extend(calibration.why_not_left_out().map(Caution::NotLeftOut));
        if fitted {
            // The parts that are left of a recording are one.
            let n_training = match self.groups.by == RECORDING {
                true => self.training_groups().into_iter().collect::<BTreeSet<_>>().len(),
                false => in_role(Role::Train).count(),
            };
            if n_training < FEWEST_RECORDINGS && calibration.why_not_left_out().is_none() {
                found.push(Caution::Blocks(n_training));
            }
            found.extend(self.groups.unused.clone().map(Caution::Groups));
            found.extend(self.groups.lone.clone().map(Caution::Lone));
            let no_gauges = self.no_gauges();
            found.extend((!no_gauges.is_empty()).then(|| Caution::NoGauge(no_gauges.to_vec())));
            let odd = &calibration.quality.odd;
            found.extend((!odd.is_empty()).then(|| Caution::Odd(odd.clone())));
            self.note_loads(calibration, &mut found);
            found.extend(far_off(calibration, &found));
            let (rank, n_features) = (calibration.quality.rank, calibration.columns().len());
            if rank < n_features && calibration.learned.is_none() {
                found.push(Caution::Rank(rank, n_features));
            }
            let at_edge = calibration.kernel_ridge_at_edge();
            found.extend(at_edge.map(|(edge, strength)| Caution::KernelRidge(edge, strength)));
            let alone = calibration.linear_alone();
            found.extend((!alone.is_empty()).then_some(Caution::LinearAlone(alone)));
        }
        let quality = &calibration.quality;
        let scores = [&quality.conventional, &quality.compensated];
        if let [Some(before), Some(after)] = scores.map(|scores| &scores.test_rmse) {
            let axes = calibration.axes.iter().zip(before.iter().zip(after));
            let worse = axes.filter(|(_, (before, after))| after > before);
            let worse: Vec<Axis> = worse.map(|(axis, _)| *axis).collect();
            found.extend((!worse.is_empty()).then_some(Caution::Worse(worse)));
        }
        found
    }

    /// Auxiliary channels that change and that nobody asked for.
    fn left_auxiliary(&self, calibration: &Calibration) -> Option<Vec<String>> {
        if !calibration.features.blocks.of(&Auxiliary).is_empty() {
            return None;
        }
        let training = self.entries.iter().filter(|own| own.role == Role::Train);
        let ranges = training.map(|own| own.recording.auxiliary().ranges());
        let ranges: Vec<Vec<(f64, f64)>> = ranges.collect();
        let first = self.entries.iter().find(|own| own.role == Role::Train)?;
        let names = first.recording.auxiliary().names().iter();
        let changes = names.enumerate().filter(|(at, name)| {
            let own = ranges.iter().filter_map(|ranges| ranges.get(*at));
            let ends = own.fold((f64::INFINITY, f64::NEG_INFINITY), |all, own| {
                (all.0.min(own.0), all.1.max(own.1))
            });
            let is_usable = self.auxiliary.channels.iter().any(|own| own.name == **name);
            is_usable && ends.1 > ends.0
        });
        let names: Vec<String> = changes.map(|(_, name)| name.clone()).collect();
        (!names.is_empty()).then_some(names)
    }

    /// Why auxiliary channels that were asked for are not used.
    fn unused_auxiliary(&self, calibration: &Calibration) -> Option<Vec<String>> {
        if calibration.features.blocks.of(&Auxiliary).is_empty() {
            return None;
        }
        let mut reasons = self.auxiliary.unused.clone();
        if reasons.is_empty() && self.auxiliary.channels.is_empty() {
            reasons.push("no column of the recordings is an auxiliary channel; say which is in the import window or a column map".to_owned());
        }
        (!reasons.is_empty()).then_some(reasons)
    }

    /// What the loads of the recordings cannot tell of this calibration.
    fn note_loads(&self, calibration: &Calibration, found: &mut Vec<Caution>) {
        let axes = &calibration.axes;
        let coverage = self.coverage(axes);
        let spans: Vec<f64> = (0..axes.len()).map(|axis| coverage.span(axis)).collect();
        for (at, axis) in axes.iter().enumerate() {
            // A full scale is half of what an axis spans.
            let most = largest(axes, &spans, *axis).max(2.0 * calibration.full_scale[at]);
            if spans[at] <= STANDS_STILL * most {
                found.push(Caution::Still(*axis, coverage.trained[at], most));
            }
            if let Some(outside) = coverage.outside[at] {
                found.push(Caution::Outside(*axis, coverage.trained[at], outside));
            }
        }
        let columns = calibration.columns();
        let n_cases = coverage.n_cases(&columns);
        if n_cases < CASES_PER_FEATURE * columns.len() && calibration.undetermined().is_none() {
            found.push(Caution::FewLoads(columns.len(), n_cases));
        }
    }
}

/// Where the test says that its recordings are of another kind, and they are not known to load what was not trained.
fn far_off(calibration: &Calibration, found: &[Caution]) -> Option<Caution> {
    let scores = &calibration.quality.compensated;
    let (test, left_out) = (scores.test_rmse.as_ref()?, scores.cv_rmse.as_ref()?);
    let is_outside = |axis: Axis| {
        let own = |caution: &Caution| matches!(caution, Caution::Outside(of, _, outside) if *of == axis && is_far_outside(outside));
        found.iter().any(own)
    };
    let axes = calibration.axes.iter().zip(&calibration.full_scale);
    let axes = axes.zip(test.iter().zip(left_out));
    let far = axes.filter(|((axis, full_scale), (test, left_out))| {
        **test > FAR_OFF * **left_out
            && **test > FAR_OFF_MATTERS * **full_scale
            && !is_outside(**axis)
    });
    let times = |own: &((&Axis, &f64), (&f64, &f64))| own.1.0 / own.1.1;
    let worst = far.max_by(|a, b| times(a).total_cmp(&times(b)));
    worst.map(|((axis, _), (test, left_out))| Caution::FarOff(*axis, *test, *left_out))
}

impl Caution {
    /// In a few words, for where there is little room.
    pub fn short(&self) -> String {
        match self {
            Self::NoTest => "no test recording".to_owned(),
            Self::LoadCases(cases, _) => format!("{cases} load cases, no times"),
            Self::Undetermined(found) => {
                let (samples, coefficients) = (found.samples, found.coefficients);
                format!("only {samples} samples for {coefficients} coefficients")
            }
            Self::NotLeftOut(reason) => format!("no cross-validation: {reason}"),
            Self::Blocks(n) => format!("only {}", counted(*n, "training recording")),
            Self::Groups(unused) => match unused.lone {
                Some(ref lone) => format!("only {} loads {}", lone.group, lone.axis.symbol()),
                None => format!("only {}", counted(unused.n, unused.by)),
            },
            Self::Lone(lone) => format!("only {} loads {}", lone.group, lone.axis.symbol()),
            Self::Still(axis, ..) => format!("{} hardly moves in training", axis.symbol()),
            Self::Outside(axis, _, outside) => {
                let share = percent(outside.share);
                format!("{share} of the test loads on {} not trained", axis.symbol())
            }
            Self::FewLoads(features, cases) => format!("{features} features for {cases} loads"),
            Self::Rank(rank, features) => format!("rank {rank} of {features}"),
            Self::KernelRidge(GridEdge::Weakest, _) => {
                "the kernel's ridge is the weakest".to_owned()
            }
            Self::KernelRidge(GridEdge::Strongest, _) => {
                "the kernel's ridge is the strongest".to_owned()
            }
            Self::LinearAlone(axes) => format!("no second stage on {}", symbols(axes)),
            Self::Auxiliary(reasons) => {
                format!("{} not used", counted(reasons.len(), "auxiliary channel"))
            }
            Self::AuxiliaryBeyond(_) => "auxiliary channels beyond what was trained".to_owned(),
            Self::AuxiliaryLeft(names) => format!("{} not used", names.join(", ")),
            Self::NoGauge(found) => found[0].short(),
            Self::Odd(odd) => format!("{} contradicts the others", odd[0].recording),
            Self::FarOff(axis, test, left_out) => format!(
                "{} on test {} times the cross-validation",
                axis.symbol(),
                significant(test / left_out, 2)
            ),
            Self::Worse(axes) => format!("worse on test: {}", symbols(axes)),
        }
    }
}

impl std::fmt::Display for Caution {
    /// A whole sentence without its full stop.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let load = |axis: &Axis, value: f64| format!("{} {}", significant(value, 3), axis.unit());
        match self {
            Self::NoTest => f.write_str(
                "no recording is in the test role, so nothing says how the calibration does on recordings it never saw, \
                 except cross-validation; keep one out of the fit, or split the recordings in time",
            ),
            Self::LoadCases(cases, rows) => write!(
                f,
                "the training recordings have no times, so look-backs and all else of the past are off, whatever the settings \
                 say; cross-validation leaves out whole load cases ({cases} of {rows} rows), never a row beside its repeats",
            ),
            Self::Undetermined(found) => found.fmt(f),
            Self::NotLeftOut(reason) => write!(f, "no cross-validation figures: {reason}"),
            Self::Blocks(n) => write!(
                f,
                "{} to train on: {BLOCKS} contiguous blocks take turns in cross-validation, and each knows the same run from \
                 its neighbours, so the error on another run can be far larger; record {FEWEST_RECORDINGS} or more",
                counted(*n, "recording"),
            ),
            Self::Groups(UnusedGroups { by, n, lone: None }) => write!(
                f,
                "the training recordings are of {} only, too few to leave out in turn: they are left out one by one, each \
                 known from those that repeat it, so the cross-validation error flatters; record more, or set the groups",
                counted(*n, by),
            ),
            Self::Groups(UnusedGroups {
                by,
                lone: Some(lone),
                ..
            }) => write!(
                f,
                "hardly anything loads {} without {}, so recordings are left out one by one rather than by {by}, and each is \
                 known from those that repeat it; load {0} in others, too, or set the groups",
                lone.axis.symbol(),
                lone.group,
            ),
            Self::Lone(lone) => write!(
                f,
                "hardly anything loads {} without the group {}: left out, it is predicted by fits that never saw such loads; \
                 load {0} in others, too, or group otherwise",
                lone.axis.symbol(),
                lone.group,
            ),
            Self::Still(axis, (low, high), most) => {
                match low == high {
                    true => write!(f, "{} is always {}", axis.symbol(), load(axis, *low))?,
                    false => write!(
                        f,
                        "{} moves by {}, {} of {},",
                        axis.symbol(),
                        load(axis, high - low),
                        percent((high - low) / most),
                        load(axis, *most),
                    )?,
                }
                f.write_str(
                    " in the training recordings: whatever its errors are, they say nothing of a load on it; record loads on \
                     it, or leave its column out",
                )
            }
            Self::Outside(axis, (low, high), outside) => write!(
                f,
                "{} of the test samples load {} outside the {} to {} that were trained, by up to {}: the test error there is \
                 that of an extrapolation; train on such loads, or test within",
                percent(outside.share),
                axis.symbol(),
                significant(*low, 3),
                load(axis, *high),
                load(axis, outside.farthest),
            ),
            Self::FewLoads(features, cases) => write!(
                f,
                "{features} features for {cases} different training loads: many fits do as well on these, and differ on \
                 others; record more loads, or take fewer blocks or a ridge",
            ),
            Self::Rank(rank, features) => write!(
                f,
                "only {rank} of {features} features are independent: some gauges or blocks repeat each other, or the past \
                 never differs from the present; leave such gauges or blocks out",
            ),
            Self::KernelRidge(GridEdge::Weakest, strength) => write!(
                f,
                "the kernel's ridge is the weakest that keeps its weights small ({strength:e}), and left-out parts ask for a \
                 weaker one: it may do worse on other data than its scores say; look at test recordings, or take fewer features",
            ),
            Self::KernelRidge(GridEdge::Strongest, strength) => write!(
                f,
                "the kernel's ridge is the strongest that is tried ({strength:e}): left-out parts learn next to nothing from \
                 the kernel; take another regressor",
            ),
            Self::LinearAlone(axes) => write!(
                f,
                "on {} the second stage does no better on left-out samples than within one standard error, so the linear part \
                 stands alone there; a linear calibration is as good, or record more",
                symbols(axes),
            ),
            Self::Auxiliary(reasons) => {
                write!(f, "auxiliary channels: {}", reasons.join("; "))
            }
            Self::AuxiliaryBeyond(beyond) => write!(
                f,
                "{}: the effect is carried on in a straight line there",
                beyond.join("; ")
            ),
            Self::AuxiliaryLeft(names) => write!(
                f,
                "{} changed meanwhile, and the model does not use it: where the sensor depends on it, add the auxiliary channels",
                names.join(", "),
            ),
            Self::NoGauge(found) => {
                let named = found.iter().take(NO_GAUGES_NAMED);
                let named: Vec<String> = named.map(NoGauge::to_string).collect();
                let more = match found.len().saturating_sub(NO_GAUGES_NAMED) {
                    0 => String::new(),
                    n_more => format!("; and {n_more} more"),
                };
                write!(
                    f,
                    "{}{more}: give such a column another role in the import window or a column map, as the sensor in use will not \
                     have it",
                    named.join("; "),
                )
            }
            Self::Odd(odd) => {
                let one = |own: &OddRecording| {
                    format!(
                        "{} ({} by {}, {} times what the same fit leaves on the others)",
                        own.recording,
                        own.axis.symbol(),
                        load(&own.axis, own.error),
                        significant(own.error / own.others, 2),
                    )
                };
                let all: Vec<String> = odd.iter().take(ODD_NAMED).map(one).collect();
                let more = match odd.len().saturating_sub(ODD_NAMED) {
                    0 => String::new(),
                    n_more => format!("; and {n_more} more"),
                };
                write!(
                    f,
                    "left out, the others do not predict {}{more}: another mounting or sensor, a wrong or late reference, a gauge that \
                     changed, or loads of another kind; look at it, or take it out of training",
                    all.join("; "),
                )
            }
            Self::FarOff(axis, test, left_out) => write!(
                f,
                "on the test recordings {} errs by {}, {} times the cross-validation error: they are of another mounting, sensor or \
                 reference, or of loads of another kind; find out which before you trust either figure",
                axis.symbol(),
                load(axis, *test),
                significant(test / left_out, 2),
            ),
            Self::Worse(axes) => write!(
                f,
                "on the test recordings the compensated load is worse than the conventional one on {}; take fewer blocks, a \
                 ridge, or more kinds of motion to train on",
                symbols(axes),
            ),
        }
    }
}

/// So many of something.
fn counted(n: usize, what: &str) -> String {
    match (n, what) {
        (1, _) | (_, "series") => format!("{n} {what}"),
        (_, "trajectory") => format!("{n} trajectories"),
        _ => format!("{n} {what}s"),
    }
}

fn symbols(axes: &[Axis]) -> String {
    let symbols: Vec<&str> = axes.iter().map(|axis| axis.symbol()).collect();
    symbols.join(", ")
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::FitSettings;
    use crate::features::{Blocks, FeatureSettings, Polynomial};
    use crate::questions::errors::query::analyse;
    use crate::recording::{Entry, Recording, RecordingSet, Source, simulated};

    /// What is to be known of a fit to recordings with these names and loads on two axes; `t` in a name makes it test.
    fn of(recordings: &[(&str, Vec<[f64; 2]>)], features: FeatureSettings) -> Vec<Caution> {
        let mut set = RecordingSet::default();
        for (name, loads) in recordings {
            let n = loads.len();
            let gauges = loads.iter().flat_map(|[a, b]| [a + 0.1 * b, b - 0.2 * a]);
            let recording = Recording::new(
                *name,
                Source::Simulated,
                (0..n).map(|k| k as f64 * 0.1).collect(),
                ["S1", "S2"].map(str::to_owned).to_vec(),
                gauges.collect(),
                vec![Axis::Fx, Axis::Fz],
                loads.as_flattened().to_vec(),
            );
            let role = if name.starts_with("test") { Role::Test } else { Role::Train };
            set.push(Entry::new(recording.unwrap(), role)).unwrap();
        }
        let settings = FitSettings { features, ..FitSettings::default() };
        let request = Request::fit(Arc::new(set), settings);
        analyse(&request, &Progress::default()).unwrap().cautions
    }

    /// A run whose axes swing so far.
    fn swing(fx: f64, fz: f64) -> Vec<[f64; 2]> {
        let at = |k: i32| [fx * (0.31 * f64::from(k)).sin(), fz * (0.23 * f64::from(k)).cos()];
        (0..200).map(at).collect()
    }

    #[test]
    fn recordings_that_tell_enough_are_followed_by_nothing() {
        let own = ["a", "b", "c", "test"].map(|name| (name, swing(5.0, 9.0)));
        let found = of(&own, FeatureSettings::present());
        let is_harmless = |caution: &Caution| matches!(caution, Caution::Worse(_));
        assert!(found.iter().all(is_harmless), "{found:?}");
        let simulated = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
        let settings = FitSettings { decimation: 10, ..FitSettings::default() };
        let request = Request::fit(simulated, settings);
        let found = analyse(&request, &Progress::default()).unwrap().cautions;
        let is_of_range = |caution: &Caution| matches!(caution, Caution::Outside(..));
        assert!(found.iter().all(is_of_range), "{found:?}");
    }

    #[test]
    fn one_recording_a_still_axis_and_a_test_beyond_are_told_with_their_figures() {
        let still = swing(0.0, 9.0);
        let found = of(&[("a", still), ("test", swing(5.0, 18.0))], FeatureSettings::present());
        assert!(found.contains(&Caution::Blocks(1)), "{found:?}");
        assert!(found.iter().any(
            |caution| matches!(caution, Caution::Still(Axis::Fx, (low, high), _) if low == high)
        ));
        let outside = |axis: Axis| {
            found.iter().find_map(|caution| match caution {
                Caution::Outside(own, _, outside) if *own == axis => Some(*outside),
                _ => None,
            })
        };
        assert!((outside(Axis::Fx).unwrap().farthest - 5.0).abs() < 0.01);
        assert!((outside(Axis::Fz).unwrap().farthest - 9.0).abs() < 0.01);
        for caution in &found {
            let (sentence, short) = (caution.to_string(), caution.short());
            assert!(sentence.len() > short.len() && !sentence.ends_with('.'), "{sentence}");
        }
    }

    /// Seven loads, each held: more than enough samples, but not for the squares of two gauges.
    #[test]
    fn few_held_loads_are_few_however_many_samples_there_are() {
        let held = |seed: f64| {
            let load = |k: i32| {
                let at = f64::from(k / 30) + seed;
                [5.0 * (1.3 * at).sin(), 9.0 * (0.7 * at).cos()]
            };
            (0..210).map(load).collect::<Vec<_>>()
        };
        let own = ["a", "b", "c", "test"].map(|name| (name, held(0.0)));
        let squares = FeatureSettings {
            blocks: Blocks::default().with(&Polynomial, &[2.0]),
            ..FeatureSettings::present()
        };
        assert!(of(&own, squares.clone()).contains(&Caution::FewLoads(6, 7)));
        let other = [("a", held(0.0)), ("b", held(0.3)), ("c", held(0.6)), ("test", held(0.0))];
        let found = of(&other, squares);
        let is_few = |caution: &Caution| matches!(caution, Caution::FewLoads(..));
        assert!(!found.iter().any(is_few), "{found:?}");
    }

    #[test]
    fn recordings_of_one_programme_are_told() {
        let own =
            ["path1_a", "path1_b", "path1_c", "test_path1"].map(|name| (name, swing(5.0, 9.0)));
        let found = of(&own, FeatureSettings::present());
        let told = found.iter().find(|caution| matches!(caution, Caution::Groups(_)));
        assert!(told.unwrap().to_string().contains("are of 1 path only"), "{found:?}");
    }
}
