//! Reports findings about a fit that its errors do not show, such as properties of the sensor that the recordings do not
//! determine.
//!
//! Compares the number of load cases with the number of coefficients. The same rule is used in a fit and in a check of the
//! recordings.

use Verdict::{Doubtful, Enough, Insufficient};
use serde::Serialize;

use crate::{
    calibration::{Calibration, GridEdge},
    features::{Auxiliary, AuxiliaryChannel},
    finding::{Finding, Id, Verdict},
    min_max::MinMax,
    progress::Progress,
    questions::{
        dataset::{AuxiliaryInputs, Dataset, MOST_UNKNOWN, Travels},
        error::AnalysisError,
        errors::cold_start::worse_at_start,
        request::Request,
    },
    recording::{Axis, GroupedBy, LoneGroup, Role, in_role},
    scoring::{
        coverage::{Coverage, OUTSIDE_SHARE, largest},
        cross_validation::FEWEST_RECORDINGS,
        numbers::{percent, significant},
        rig::{lag_of_fit, same_samples},
    },
    shown::counted,
};

/// Maximum range of the load on an axis for which the load counts as constant. It is a share of the full range (twice the
/// full scale) of the axis, or of the largest range among the axes with the same unit if that is larger.
pub const STANDS_STILL: f64 = 0.02;

/// Returns the findings about a fit to the recordings of the request. If a calibration is applied instead of fitted, only
/// findings about its test recordings are returned.
///
/// # Errors
/// [`AnalysisError`] if there are no recordings.
pub fn findings(
    request: &Request,
    calibration: &Calibration,
    progress: &Progress,
) -> Result<Vec<Finding>, AnalysisError> {
    let data = request.datasets.get(&request.key(), progress)?;
    let fitted = request.calibration.is_none() || request.trained;
    let lag = if fitted { data.lag_as_hysteresis(&calibration.features, progress)? } else { None };
    Ok(findings_of_fit(&data, calibration, fitted)
        .into_iter()
        .chain(lag.map(|found| lag_of_fit(found, calibration)))
        .chain(if fitted { worse_at_start(&data, calibration)? } else { None })
        .collect())
}

pub fn findings_of_fit(data: &Dataset, calibration: &Calibration, fitted: bool) -> Vec<Finding> {
    let mut found = Vec::new();
    if in_role(&data.entries, Role::Test).is_empty() {
        found.push(Finding::new(Id::NoTest, Enough, "no recording has the role test"));
    }
    if fitted {
        found.extend(without_times(data, data.coverage(&calibration.axes)));
        found.extend(calibration.undetermined().map(|undetermined| undetermined.finding()));
        found.extend(auxiliary_unused(data, calibration));
    }
    found.extend(auxiliary_beyond(data, calibration, fitted));
    let no_cross_validation = calibration.no_cross_validation();
    found.extend(no_cross_validation.map(|why| {
        Finding::new(Id::NoCrossValidation, Doubtful, format!("no cross-validation: {why}"))
    }));
    if fitted {
        if no_cross_validation.is_none() {
            found.extend(few_recordings(data));
        }
        found.extend(of_groups(data));
        let roles =
            [Role::Train, Role::Test].into_iter().flat_map(|role| in_role(&data.entries, role));
        found.extend(same_samples(&roles.collect::<Vec<_>>()));
        let coverage = data.coverage(&calibration.axes);
        found.extend(of_loads(calibration, coverage));
        let count = LoadCount::of(calibration, coverage);
        if calibration.undetermined().is_none() {
            found.extend(count.finding());
        }
        found.extend(of_regressor(calibration));
        found.extend(unknown_state(data, calibration));
    }
    found.extend(worse_on_test(calibration));
    found
}

fn without_times(data: &Dataset, coverage: &Coverage) -> Option<Finding> {
    let training = in_role(&data.entries, Role::Train);
    let seen = if training.iter().any(|recording| recording.is_static()) {
        "the training recordings have no times"
    } else if data.has_no_history() {
        "the load rests in every training recording"
    } else {
        return None;
    };
    let n_cases = if training.iter().all(|recording| recording.is_table()) {
        coverage.cases.len()
    } else {
        data.training_groups().len()
    };
    let n_rows: usize = training.iter().map(|recording| recording.n_samples()).sum();
    let found = Finding::new(Id::NoTimes, Enough, seen);
    Some(found.with(format!("{} in {n_rows} rows", counted(n_cases, "load case"))))
}

/// Returns the finding that the state of a play operator is unknown in too many samples of a group of recordings. The
/// play operator with the largest radius is examined.
fn unknown_state(data: &Dataset, calibration: &Calibration) -> Option<Finding> {
    let used = calibration.features.blocks.used();
    let radii = used.flat_map(|(block, values)| values.iter().map(move |radius| (block, *radius)));
    let radii = radii.filter(|(block, radius)| block.travel(*radius) > 0.0);
    let (block, radius) = radii.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let unknown = Travels::of(data, &calibration.gauge_scale).unknown(block.travel(radius));
    let seen = format!(
        "the state of the feature {} with radius {radius} σ is unknown at the start of a recording",
        block.name()
    );
    let figures =
        format!("unknown in {} of the samples of a group of recordings", percent(unknown));
    let found = Finding::new(Id::UnknownState, Doubtful, seen).with(figures);
    (unknown > MOST_UNKNOWN).then_some(found)
}

fn few_recordings(data: &Dataset) -> Option<Finding> {
    // Intervals of one recording count once: pauses and faulty samples divide it.
    let n = if data.groups.by == GroupedBy::Recording {
        data.training_groups().len()
    } else {
        in_role(&data.entries, Role::Train).len()
    };
    let seen = format!("only {}", counted(n, "independent training recording"));
    let figures =
        format!("cross-validation that leaves out whole recordings needs {FEWEST_RECORDINGS}");
    let found = Finding::new(Id::FewRecordings, Doubtful, seen).with(figures);
    (n < FEWEST_RECORDINGS).then_some(found)
}

fn of_groups(data: &Dataset) -> impl Iterator<Item = Finding> {
    let alone = |id: Id, lone: &LoneGroup| {
        let seen = format!("only the group {} has loads on {}", lone.group, lone.axis.symbol());
        Finding::new(id, Doubtful, seen)
    };
    let unused = data.groups.unused.iter().map(move |unused| match &unused.lone {
        Some(lone) => alone(Id::UnusedLoneGroup, lone),
        None => {
            let seen = format!("only {} for training", counted(unused.n, &unused.by.to_string()));
            Finding::new(Id::FewGroups, Doubtful, seen)
        }
    });
    unused.chain(data.groups.lone.iter().map(move |lone| alone(Id::LoneGroup, lone)))
}

/// Returns the finding that values of auxiliary channels lie outside their range in the training recordings.
fn auxiliary_beyond(data: &Dataset, calibration: &Calibration, fitted: bool) -> Option<Finding> {
    let shown = data.entries.iter().filter(|entry| entry.role != Role::Train || !fitted);
    let beyond = shown.flat_map(|entry| calibration.auxiliary_beyond(&entry.recording));
    let channels = calibration.features.auxiliary.iter();
    let beyond = beyond.chain(channels.filter_map(AuxiliaryChannel::reference_beyond));
    let beyond: Vec<String> = beyond.collect();
    let seen = "auxiliary channels outside the range of the training recordings";
    let found = Finding::new(Id::AuxiliaryBeyond, Enough, seen).with(beyond.join("; "));
    (!beyond.is_empty()).then_some(found)
}

/// Returns the finding that auxiliary channels are not used: by the choice of the user, or because they cannot be used.
fn auxiliary_unused(data: &Dataset, calibration: &Calibration) -> Option<Finding> {
    let AuxiliaryInputs { channels, unused } = &data.auxiliary;
    let is_wanted = !calibration.features.blocks.of(&Auxiliary).is_empty();
    let names: Vec<&str> = channels.iter().map(|channel| &*channel.name).collect();
    let (id, seen, figures) = match (is_wanted, names.is_empty(), unused.len()) {
        (false, false, _) => {
            let seen = "the calibration does not use the auxiliary channels";
            (Id::AuxiliaryLeft, format!("{seen} {}", names.join(", ")), String::new())
        }
        (true, true, 0) => {
            let seen = "no column of the recordings is an auxiliary channel";
            (Id::NoAuxiliary, seen.to_owned(), String::new())
        }
        (true, _, n @ 1..) => {
            let seen = format!("{} not used", counted(n, "auxiliary channel"));
            (Id::UnusedAuxiliary, seen, unused.join("; "))
        }
        _ => return None,
    };
    Some(Finding::new(id, Enough, seen).with(figures))
}

fn load(axis: Axis, value: f64) -> String {
    format!("{} {}", significant(value, 3), axis.unit())
}

/// Returns findings about axes whose training loads do not determine the calibration: axes on which the load hardly moves,
/// and test loads outside the training range.
fn of_loads(calibration: &Calibration, coverage: &Coverage) -> Vec<Finding> {
    let axes = &calibration.axes;
    let spans: Vec<f64> = (0..axes.len()).map(|axis| coverage.span(axis)).collect();
    let mut found = Vec::new();
    for (at, &axis) in axes.iter().enumerate() {
        let (symbol, MinMax { min: low, max: high }) = (axis.symbol(), coverage.trained[at]);
        // Full scale is half of the range of a load, so it is doubled here.
        let most = largest(axes, &spans, axis).max(2.0 * calibration.full_scale[at]);
        if spans[at] <= STANDS_STILL * most {
            let (severity, figures) = if low == high {
                (Insufficient, format!("the load is always {}", load(axis, low)))
            } else {
                let [moves, of] = [high - low, most].map(|value| load(axis, value));
                let share = percent((high - low) / most);
                (
                    Doubtful,
                    format!(
                        "the load moves by {moves}, which is {share} of {of}, the full range of this axis or of a similar one"
                    ),
                )
            };
            let seen = format!("{symbol} hardly moves in the training recordings");
            found.push(Finding::new(Id::Still, severity, seen).with(figures));
        }
        if let Some(outside) = coverage.outside[at] {
            let share = percent(outside.share);
            let seen = format!(
                "{share} of the test loads on {symbol} are outside the range of the training loads"
            );
            let low = significant(low, 3);
            let [high, farthest] = [high, outside.farthest].map(|value| load(axis, value));
            let figures = format!(
                "the training loads are {low} to {high}, which test loads exceed by up to {farthest}"
            );
            let severity = if outside.share > OUTSIDE_SHARE { Doubtful } else { Enough };
            found.push(Finding::new(Id::OutsideTrained, severity, seen).with(figures));
        }
    }
    found
}

/// Returns findings about the rank of the features, and about the ridge and the axes of the network or kernel.
fn of_regressor(calibration: &Calibration) -> Vec<Finding> {
    let mut found = Vec::new();
    let (rank, n_features) = (calibration.quality.rank, calibration.columns().len());
    if rank < n_features && calibration.learned.is_none() {
        let seen = format!("only {rank} of the {n_features} features of the fit are independent");
        found.push(Finding::new(Id::Rank, Enough, seen));
    }
    let at_edge = calibration.kernel_ridge_at_edge();
    found.extend(at_edge.map(|(edge, strength)| {
        let (id, which) = match edge {
            GridEdge::Weakest => (Id::WeakestKernelRidge, "weakest"),
            GridEdge::Strongest => (Id::StrongestKernelRidge, "strongest"),
        };
        let seen = format!(
            "the automatic choice of the kernel's ridge gave the {which} of all candidates"
        );
        Finding::new(id, Enough, seen).with(format!("{strength:e}"))
    }));
    let alone = calibration.linear_alone();
    let seen = format!("the network or kernel is not used on {}", Axis::symbols(&alone).join(", "));
    found.extend((!alone.is_empty()).then(|| Finding::new(Id::LinearAlone, Enough, seen)));
    found
}

/// Returns the finding that the compensated calibration has a larger test error than the conventional one on some axes.
fn worse_on_test(calibration: &Calibration) -> Option<Finding> {
    let quality = &calibration.quality;
    let before = quality.conventional.test_rmse.as_ref()?;
    let after = quality.compensated.test_rmse.as_ref()?;
    let worse = (0..calibration.axes.len()).filter(|at| after[*at] > before[*at]);
    let worse: Vec<usize> = worse.collect();
    let axes: Vec<Axis> = worse.iter().map(|at| calibration.axes[*at]).collect();
    let seen = format!(
        "the test error of the compensated calibration exceeds that of the conventional one on {}",
        Axis::symbols(&axes).join(", ")
    );
    let figures = worse.iter().zip(&axes).map(|(at, axis)| {
        let [before, after] = [before[*at], after[*at]].map(|rmse| significant(rmse, 3));
        format!("{}: {after} instead of {before} {}", axis.symbol(), axis.unit())
    });
    let figures = figures.collect::<Vec<_>>().join("; ");
    (!worse.is_empty()).then(|| Finding::new(Id::WorseOnTest, Doubtful, seen).with(figures))
}

/// Number of load cases per free coefficient below which a finding is grave. With so few load cases, the errors on other
/// loads are expected to be five times those of the fit, even if the model is right.
const FEWEST_CASES: f64 = 1.25;
/// Number of load cases per free coefficient below which a finding is reported. With so few load cases, the errors on other
/// loads are expected to be twice those of the fit, even if the model is right.
const FEW_CASES: f64 = 2.0;
/// Largest expected ratio of errors that is shown. A larger ratio tells no more than that there are too few loads.
const TIMES: f64 = 100.0;

#[derive(Clone, Copy, Debug, Serialize)]
pub struct LoadCount {
    /// Number of different loads. If features use earlier gauge values, number of changes of the load.
    pub load_cases: usize,
    /// True if the count of different loads stopped at `load_cases`, because more of them would change no finding.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub more_load_cases: bool,
    pub coefficients: usize,
    /// Effective number of coefficients, which the data determine instead of the ridge, on the axis with the largest such number.
    pub free_coefficients: f64,
}

impl LoadCount {
    pub fn of(calibration: &Calibration, coverage: &Coverage) -> Self {
        let columns = calibration.columns();
        let coefficients = columns.len();
        let free = calibration.quality.free_coefficients;
        let (load_cases, more_load_cases) = coverage.n_cases(&columns);
        Self {
            load_cases,
            more_load_cases,
            coefficients,
            free_coefficients: free.unwrap_or(coefficients as f64),
        }
    }

    pub fn words(&self) -> String {
        let Self { load_cases, more_load_cases, coefficients, free_coefficients } = self;
        let few = free_coefficients.ceil();
        let free = if few < *coefficients as f64 {
            format!(" ({few:.0} of which the data determine)")
        } else {
            String::new()
        };
        let cases = if *more_load_cases {
            "more than 1,000 load cases".to_owned()
        } else {
            counted(*load_cases, "load case")
        };
        format!("{coefficients} coefficients per axis{free} are fitted to {cases}")
    }

    pub fn finding(&self) -> Option<Finding> {
        let (n, p) = (self.load_cases as f64, self.free_coefficients);
        if n > p.ceil() && n >= FEW_CASES * p {
            return None;
        }
        let is_grave = n <= p.ceil() || n < FEWEST_CASES * p;
        let severity = if is_grave { Verdict::Insufficient } else { Verdict::Doubtful };
        // For random loads, p free coefficients and n load cases: `E[test MSE] / E[train MSE] = (1 + p/(n−p−1)) / (1 − p/n)`.
        let times = (n > p + 1.0).then(|| ((n - 1.0) / (n - p - 1.0) * n / (n - p)).sqrt());
        let figures = match times {
            _ if n <= p.ceil() => {
                "the number of load cases must be larger than the number of free coefficients"
                    .to_owned()
            }
            Some(times) if times < TIMES => format!(
                "with so few loads, errors on other loads are expected to be about {} times those of the fit",
                significant(times, 2)
            ),
            _ => String::new(),
        };
        Some(Finding::new(Id::FewLoads, severity, self.words()).with(figures))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::FitSettings;
    use crate::features::{Blocks, Creep, FeatureSettings, FixedLag, Play, Polynomial};
    use crate::finding::Face;
    use crate::questions::errors::query::analyse;
    use crate::random::Random;
    use crate::recording::simulated::{Late, late_set};
    use crate::recording::{Entry, Recording, RecordingSet, Source, simulated};

    /// Returns the findings on a fit to recordings with these names and loads on two axes; `t` in a name means the test role.
    fn of(recordings: &[(&str, Vec<[f64; 2]>)], features: FeatureSettings) -> Vec<Finding> {
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
        analyse(&request, &Progress::default()).unwrap().findings
    }

    /// Returns a run whose axes move by these amplitudes.
    fn swing(fx: f64, fz: f64) -> Vec<[f64; 2]> {
        let at = |k: i32| [fx * (0.31 * f64::from(k)).sin(), fz * (0.23 * f64::from(k)).cos()];
        (0..200).map(at).collect()
    }

    #[test]
    fn recordings_that_tell_enough_are_followed_by_nothing() {
        // Each begins at another phase, so none contains the samples of another.
        let recordings = [("a", 0), ("b", 20), ("c", 40), ("test", 60)].map(|(name, first)| {
            let mut loads = swing(5.0, 9.0);
            loads.rotate_left(first);
            (name, loads)
        });
        let found = of(&recordings, FeatureSettings::present());
        assert!(found.iter().all(|finding| finding.id == Id::WorseOnTest), "{found:?}");
        let simulated = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
        let settings = FitSettings { decimation: 10, ..FitSettings::default() };
        let request = Request::fit(simulated, settings);
        let found = analyse(&request, &Progress::default()).unwrap().findings;
        assert!(found.iter().all(|finding| finding.id == Id::OutsideTrained), "{found:?}");
    }

    /// The gauges move by about three standard deviations.
    #[test]
    fn a_radius_whose_state_stays_unknown_is_found() {
        let recordings = ["a", "b", "c", "test"].map(|name| (name, swing(5.0, 9.0)));
        let has = |radius| {
            let blocks = Blocks::default().with(&Play, &[radius]);
            let found = of(&recordings, FeatureSettings { blocks, ..FeatureSettings::present() });
            found.iter().any(|finding| finding.id == Id::UnknownState)
        };
        assert!(has(2.0) && !has(0.05));
    }

    #[test]
    fn one_recording_a_still_axis_and_a_test_beyond_are_told_with_their_figures() {
        let still = swing(0.0, 9.0);
        let found = of(&[("a", still), ("test", swing(5.0, 18.0))], FeatureSettings::present());
        let all = |id: Id| found.iter().filter(move |finding| finding.id == id);
        assert_eq!(all(Id::FewRecordings).count(), 1, "{found:?}");
        let still = all(Id::Still).find(|finding| finding.seen.starts_with("Fx")).unwrap();
        assert_eq!((still.severity, &*still.figures), (Insufficient, "the load is always 0 N"));
        let outside: Vec<&str> = all(Id::OutsideTrained).map(|finding| &*finding.figures).collect();
        assert_eq!(
            outside,
            [
                "the training loads are 0 to 0 N, which test loads exceed by up to 5.00 N",
                "the training loads are -9.00 to 9.00 N, which test loads exceed by up to 9.00 N"
            ]
        );
        for finding in &found {
            let text = finding.text(Face::Page);
            assert!(text.len() > finding.seen.len() && !text.ends_with('.'), "{text}");
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
        let recordings = ["a", "b", "c", "test"].map(|name| (name, held(0.0)));
        let squares = FeatureSettings {
            blocks: Blocks::default().with(&Polynomial, &[2.0]),
            ..FeatureSettings::present()
        };
        let found = of(&recordings, squares.clone());
        let few = found.iter().find(|finding| finding.id == Id::FewLoads).unwrap();
        assert_eq!(few.seen, "6 coefficients per axis are fitted to 7 load cases");
        let other = [("a", held(0.0)), ("b", held(0.3)), ("c", held(0.6)), ("test", held(0.0))];
        let found = of(&other, squares);
        assert!(!found.iter().any(|finding| finding.id == Id::FewLoads), "{found:?}");
    }

    /// Thresholds and play would describe the lag; a fixed lag, and a fit without a past, would not.
    #[test]
    fn a_lag_is_found_only_where_features_take_it_for_hysteresis() {
        let listed = |blocks| FeatureSettings { blocks, ..FeatureSettings::present() };
        let play = listed(Blocks::default().with(&Play, &[0.3]));
        let fixed = Blocks::default().with(&FixedLag, &[0.013]);
        let fixed = FeatureSettings { blocks: fixed, ..FeatureSettings::default() };
        for (late, features, is_found) in [
            (Late::Lag, FeatureSettings::default(), true),
            (Late::Both, FeatureSettings::default(), true),
            (Late::Hysteresis, FeatureSettings::default(), false),
            (Late::Lag, play.clone(), true),
            (Late::Hysteresis, play, false),
            (Late::Lag, fixed, false),
            (Late::Lag, FeatureSettings::present(), false),
        ] {
            let settings = FitSettings { features, ..FitSettings::default() };
            let request = Request::fit(Arc::new(late_set(5, late)), settings);
            let progress = Progress::default();
            let calibration = analyse(&request, &progress).unwrap().calibration;
            let found = findings(&request, &calibration, &progress).unwrap();
            let n = found.iter().filter(|finding| finding.id == Id::Lag).count();
            assert_eq!(n, usize::from(is_found), "{late:?}: {found:?}");
            let still = Calibration { full_scale: vec![0.0], ..(*calibration).clone() };
            assert!(found.iter().all(|finding| lag_of_fit(finding, &still).cost == 0.0));
        }
    }

    /// A new load every two seconds. The gauge creeps by as much as the load, or not at all. A creep state is unknown at a
    /// start, and half of the load is missing. A fade in from the conventional load mends the start.
    #[test]
    fn a_cold_start_that_is_worse_is_found() {
        let found = |creeps: f64, blocks, fades: bool| {
            let mut set = RecordingSet::default();
            for at in 0..4 {
                let mut random = Random::new(3, &[at]);
                let (mut gauges, mut loads, mut slow, mut load) = (vec![], vec![], 0.0, 0.0);
                for k in 0..1200 {
                    if k % 20 == 0 {
                        load = 10.0 * random.normal();
                    }
                    slow += (load - slow) * 0.01;
                    if k >= 200 {
                        loads.push(load);
                        gauges.push(load + creeps * slow + 0.02 * random.normal());
                    }
                }
                let recording = Recording::new(
                    format!("r{at}"),
                    Source::Simulated,
                    (0..1000).map(|k| 0.1 * f64::from(k)).collect(),
                    vec!["S1".to_owned()],
                    gauges,
                    vec![Axis::Fz],
                    loads,
                );
                set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
            }
            let features = FeatureSettings { blocks, ..FeatureSettings::present() };
            let settings = FitSettings { features, ..FitSettings::default() };
            let request = Request::fit(Arc::new(set), settings);
            let progress = Progress::default();
            let mut calibration =
                Calibration::clone(&analyse(&request, &progress).unwrap().calibration);
            if !fades {
                calibration.fade.clear();
            }
            let found = findings(&request, &calibration, &progress).unwrap();
            found.into_iter().find(|finding| finding.id == Id::ColdStart)
        };
        let creep = || Blocks::default().with(&Creep, &[10.0]);
        let plain = found(1.0, creep(), false);
        assert!(plain.is_some_and(|finding| finding.seen.contains("in the first ")));
        assert_eq!(found(1.0, creep(), true), None);
        assert_eq!(found(0.0, creep(), false), None);
        assert_eq!(found(1.0, Blocks::default(), true), None);
    }

    #[test]
    fn recordings_of_one_programme_are_told() {
        let recordings =
            ["path1_a", "path1_b", "path1_c", "test_path1"].map(|name| (name, swing(5.0, 9.0)));
        let found = of(&recordings, FeatureSettings::present());
        let told = found.iter().find(|finding| finding.id == Id::FewGroups);
        assert!(told.unwrap().seen.contains("only 1 path"), "{found:?}");
    }
}
