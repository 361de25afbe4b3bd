//! Checks whether training recordings suffice for a model. The check needs only sums from one pass over the samples.

use std::ops::Range;
use std::sync::Arc;

use crate::calibration::{Calibration, NormalEquations, Regressor};
use crate::features::{Column, FeatureStream};
use crate::finding::{Finding, Id, Verdict};
use crate::min_max::MinMax;
use crate::progress::Progress;
use crate::questions::check::independent_loads::{AxisReach, NextLoad, Sufficiency};
use crate::questions::check::judgement::ONE_WAY;
use crate::questions::check::load_count::LoadCount;
use crate::questions::check::rig::{RigReport, lag_of_fit};
use crate::questions::dataset::Dataset;
use crate::questions::error::AnalysisError;
use crate::questions::expected_error::rule::{
    is_one_axis_at_a_time, is_one_programme, not_covered,
};
use crate::questions::question::{Answered, Query, Work};
use crate::questions::request::Request;
use crate::recording::kinetics::{STANDARD_GRAVITY, Weight, load_of_pull};
use crate::recording::{Axis, Recording, Role, ValidRange, in_role};
use crate::scoring::coverage::Coverage;
use crate::scoring::faults::{FaultKind, Faults};
use crate::scoring::information::Information;
use crate::scoring::load_spread::LoadSpread;
use crate::scoring::numbers::{percent, significant};
use crate::scoring::rig::{Rig, matters};
use crate::shown::{counted, first_clauses};

const PROPOSED: usize = 6;
/// Maximum number of recordings with faults whose names are shown.
const FAULTY: usize = 3;
/// Share of faulty training samples above which the finding makes the verdict doubtful even if the error is not smaller
/// without them.
const FAULTY_SHARE: f64 = 0.05;
/// Rotation matrix for the orientation in which the sensor's frame equals the world's.
const UPRIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

use Verdict::{Doubtful, Enough};

/// Weights that can hang from the sensor in any orientation, by which the proposed loads can be made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HangingMass {
    /// Available masses (kg).
    pub masses: Vec<f64>,
    /// Distances (m) from the origin of the sensor's frame at which the masses can hang, along each axis in both directions.
    pub arms: Vec<f64>,
}

/// Request to check training recordings: faults of the test rig, and whether the loads determine the model.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckData {
    /// Request for a fit. Its recordings and features are to be checked.
    pub request: Request,
    /// Limits of the gauges and loads that the user entered. Samples outside them are faulty.
    pub range: ValidRange,
    /// For each file that could not be used, the reason.
    pub unusable: Vec<String>,
    /// Masses and arms by which the proposed loads must be made. With `None`, any load within the rated loads is proposed.
    pub hanging: Option<HangingMass>,
}

impl CheckData {
    /// Returns the request to check the recordings of this fit.
    pub fn of(request: &Request, range: ValidRange, hanging: Option<HangingMass>) -> Self {
        Self { request: request.plain(), range, unusable: Vec::new(), hanging }
    }
}

impl Query for CheckData {
    type Answer = Sufficiency;
    type Cache = ();

    fn title(&self) -> String {
        "Checking the data".to_owned()
    }

    fn is_akin(&self, other: &Self) -> bool {
        self.request.recordings.layout() == other.request.recordings.layout()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        Ok(sufficiency(self, work.progress)?)
    }
}

/// Returns findings about the test rig and the linear model, and the loads that should be recorded next.
///
/// # Errors
/// [`AnalysisError`] if there is nothing to fit.
pub fn sufficiency(asked: &CheckData, progress: &Progress) -> Result<Sufficiency, AnalysisError> {
    let Request { settings, recordings, datasets, .. } = &asked.request;
    settings.validate()?;
    if recordings.entries().is_empty() {
        return Err(AnalysisError::NoRecordings);
    }
    let data = datasets.get(&asked.request.key(), progress)?;
    let mut calibration = data.blank_calibration(settings)?;
    let past = data.past(&calibration, progress)?;
    let design = calibration.design();
    let sums = data.sums(&design, &past, calibration.axes.len(), progress);
    progress.check()?;
    data.fit_sums(settings.ridge, &sums, &mut calibration);

    let coverage = data.coverage(&calibration.axes);
    let training = in_role(&data.entries, Role::Train);
    let loads = training.iter().flat_map(|own| own.loads().chunks_exact(calibration.axes.len()));
    let spread = LoadSpread::of(loads, &coverage.trained);
    let axes = reaches(&calibration, coverage, &spread);
    let (n_samples, count) = (sums.train.n_samples(), LoadCount::of(&calibration, coverage));
    let axes_n = calibration.axes.len();
    let mut reasons = data.findings(&calibration, true);
    let unusable = asked.unusable.iter();
    reasons.extend(unusable.map(|why| Finding::new(Id::Unusable, Doubtful, why.as_str())));
    if let Some(lag) = data.lag(progress)? {
        reasons.push(lag_of_fit(lag, &calibration));
        // A recording with faster loads has a larger error of the same lag.
        reasons.retain(|own| own.id != Id::Odd);
    }
    reasons.extend(of_programmes(&data, axes_n));
    reasons.extend(data.worse_at_start(&calibration)?);
    let faults = faulty(asked, &calibration.full_scale, &mut reasons, progress)?;
    if settings.regressor != Regressor::Linear {
        let seen = "this check judges the linear model of these features, not the network or kernel of the fit";
        reasons.push(Finding::new(Id::LinearOnly, Enough, seen));
    }
    let usual = sums.train.n_samples() as f64 / coverage.cases.len().max(1) as f64;
    let (next, next_note, unreached) =
        proposals(&calibration, &axes, &sums.train, usual, asked.hanging.as_ref(), data.rig());
    reasons.extend(unreached);
    let how = calibration.quality.cross_validation.as_ref().map(ToString::to_string);
    let not_covered = not_covered(&data.entries, axes_n, data.groups.by);
    let found = Sufficiency {
        verdict: Verdict::Enough,
        summary: format!("{}, {}", count.words(), counted(n_samples as usize, "sample")),
        reasons,
        n_samples,
        count,
        rank: calibration.quality.rank,
        condition: calibration.quality.condition,
        faults,
        next,
        next_note,
        rig: data.rig().cloned().unwrap_or_default(),
        holds_for: shown_for(&axes, training.len(), how.as_deref(), &not_covered),
        axes,
    };
    Ok(found.judged(how.as_deref()))
}

/// Returns for each training recording with faulty samples a text about its faulty channels. Adds the finding of these samples,
/// with the held-out error with and without them.
fn faulty(
    asked: &CheckData,
    full_scale: &[f64],
    reasons: &mut Vec<Finding>,
    progress: &Progress,
) -> Result<Vec<String>, AnalysisError> {
    let found =
        (asked.request.datasets).faults(&asked.request.recordings, &asked.range, progress)?;
    let all = asked.request.recordings.entries().iter().zip(found.iter());
    let (training, found): (Vec<&Recording>, Vec<&Arc<Faults>>) = all
        .filter(|(entry, _)| entry.role == Role::Train)
        .map(|(entry, found)| (&*entry.recording, found))
        .unzip();
    let words = training.iter().zip(&found).filter(|(_, faults)| !faults.found.is_empty());
    let words =
        words.map(|(own, faults)| format!("{}: {}", own.name(), faults.in_words(own).join(", ")));
    let words: Vec<String> = words.collect();
    let n: usize = training.iter().map(|own| own.n_samples()).sum();
    let share = found.iter().map(|own| own.n_samples()).sum::<usize>() as f64 / n.max(1) as f64;
    if share == 0.0 {
        return Ok(words);
    }
    let is_faulty: Vec<Vec<Range<usize>>> = found.iter().map(|own| own.samples()).collect();
    let is_sound = |at: usize, k: usize| {
        let next = is_faulty[at].partition_point(|own| own.end <= k);
        is_faulty[at].get(next).is_none_or(|own| k < own.start)
    };
    let errors = Rig::of(&training, full_scale)
        .map(|rig| [rig.left_out_error(), rig.error_of(&training, 0, |_, _| (), is_sound)]);
    let matter = errors.is_some_and(|[with, without]| matters(with, without));
    let severity = if matter || share > FAULTY_SHARE { Doubtful } else { Enough };
    let seen = format!("{} of the training samples are faulty", percent(share));
    let mut figures = first_clauses(FAULTY, &words);
    let mut cost = share;
    if let Some([with, without]) = errors.filter(|_| matter) {
        let shown = [with, without].map(|own| significant(100.0 * own, 2));
        figures += &format!(
            "; the held-out error is {} % of full scale, and {} % without these samples",
            shown[0], shown[1]
        );
        cost = with - without;
    }
    reasons.push(Finding::new(Id::Faults, severity, seen).with(figures).costing(cost));
    // A saturated gauge also seems nonlinear.
    let is_saturated =
        |own: &&Arc<Faults>| own.found.iter().any(|own| own.kind == FaultKind::Saturated);
    if found.iter().any(is_saturated) {
        reasons.retain(|own| own.id != Id::Bent);
    }
    Ok(words)
}

/// Returns a text about the loads with which the calibration was tested, and about conditions that the recordings do not
/// cover.
fn shown_for(axes: &[AxisReach], n: usize, how: Option<&str>, not_covered: &str) -> String {
    let axis = |own: &AxisReach| {
        let [low, high] = [own.low, own.high].map(|end| significant(end, 3));
        format!("{} {low} to {high} {}", own.axis.symbol(), own.axis.unit())
    };
    let loads: Vec<String> = axes.iter().map(axis).collect();
    let how = how.unwrap_or("not cross-validated");
    format!(
        "The calibration was tested with loads {} in {} ({how}). {not_covered}",
        loads.join(", "),
        counted(n, "training recording")
    )
}

fn reaches(calibration: &Calibration, coverage: &Coverage, spread: &LoadSpread) -> Vec<AxisReach> {
    let scores = &calibration.quality.compensated;
    let of = |errors: &Option<Vec<f64>>, at: usize| errors.as_ref().map(|errors| errors[at]);
    let axes = calibration.axes.iter().enumerate().map(|(at, axis)| {
        let MinMax { min: low, max: high } = coverage.trained[at];
        let (full_scale, rated) =
            (calibration.full_scale[at], calibration.rated.get(at) == Some(&true));
        let (up, down) = (high.max(0.0), (-low).max(0.0));
        let region = match rated {
            false => (low, high),
            true if down <= ONE_WAY * up => (0.0, full_scale),
            true if up <= ONE_WAY * down => (-full_scale, 0.0),
            true => (-full_scale, full_scale),
        };
        AxisReach {
            axis: *axis,
            low,
            high,
            full_scale,
            rated,
            region,
            deviation: spread.deviations[at],
            inflation: spread.inflations[at],
            train_rmse: of(&scores.train_rmse, at),
            left_out_rmse: of(&scores.cv_rmse, at),
            moves_with: (calibration.axes.iter().enumerate())
                .filter(|(other, _)| *other != at)
                .filter_map(|(other, axis)| {
                    Some((*axis, spread.correlations[at * calibration.axes.len() + other]?))
                })
                .max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs())),
        }
    });
    axes.collect()
}

/// Returns findings about recordings that load one axis at a time, or that all repeat one sequence of loads.
fn of_programmes(data: &Dataset, n_axes: usize) -> impl Iterator<Item = Finding> {
    let training = in_role(&data.entries, Role::Train);
    let separate = (n_axes > 1 && is_one_axis_at_a_time(&data.entries, n_axes)).then(|| {
        let seen = "in the training recordings, the axes are loaded one at a time";
        Finding::new(Id::OneAxisAtATime, Doubtful, seen)
    });
    let repeated = is_one_programme(&training).then(|| {
        let n = training.len();
        let all = if n == 2 { "both".to_owned() } else { format!("all {n}") };
        let seen = format!("{all} training recordings repeat the same sequence of loads");
        Finding::new(Id::OneProgramme, Doubtful, seen)
    });
    separate.into_iter().chain(repeated)
}

/// Returns the loads that should be recorded next, a text about their choice, and a finding about axes that none of them
/// loads. In the computation, each proposed load counts as `weight` samples.
fn proposals(
    calibration: &Calibration,
    axes: &[AxisReach],
    sums: &NormalEquations,
    weight: f64,
    hanging: Option<&HangingMass>,
    rig: Option<&RigReport>,
) -> (Vec<NextLoad>, String, Option<Finding>) {
    let design = calibration.design();
    let columns = calibration.columns();
    let is_past = |at: &usize| matches!(columns[*at], Column::Past { .. });
    let memoryless: Vec<usize> = design.all().into_iter().filter(|at| !is_past(at)).collect();
    let (Some(rig), Some(information)) = (rig, Information::of(sums, &memoryless)) else {
        let note = "No load moves, so the effect of another load cannot be predicted.".to_owned();
        return (Vec::new(), note, None);
    };
    let moves: Vec<bool> = axes.iter().map(|own| rig.axes.contains(&own.axis)).collect();
    let row = |load: &[f64]| {
        let position = |axis: Axis| axes.iter().position(|own| own.axis == axis);
        let gauges = rig.gauges_under(|axis| position(axis).map_or(0.0, |at| load[at]));
        let mut row = vec![0.0; design.n_columns()];
        let channels = design.features.auxiliary.iter();
        let usual: Vec<f64> = channels.map(|channel| channel.reference).collect();
        FeatureStream::new(&design).raw_row(0.0, &gauges, &usual, |_| &gauges, &mut row);
        design.standardise(&mut row);
        row
    };
    let region = within(axes, &moves);
    let loads: Vec<(Vec<f64>, Option<String>)> = match hanging {
        None => region.iter().map(|load| (load.clone(), None)).collect(),
        Some(hanging) => hung(hanging, axes),
    };
    let rows: Vec<Vec<f64>> = loads.iter().map(|(load, _)| row(load)).collect();
    let of_region: Vec<Vec<f64>> = region.iter().map(|load| row(load)).collect();
    let found = information.next_best(&rows, &of_region, weight, PROPOSED);
    let next: Vec<NextLoad> = found
        .into_iter()
        .map(|own| NextLoad {
            load: loads[own.at].0.clone(),
            how: loads[own.at].1.clone(),
            gain: own.gain,
            variance_left: own.left,
        })
        .collect();
    let mut note = match (hanging, loads.is_empty()) {
        (Some(_), true) => {
            "Every available mass and arm makes a load that exceeds the largest load of an axis."
                .to_owned()
        }
        _ => format!(
            "Each load is chosen for the largest increase of the determinant of the information matrix, given the loads before it (D-optimal). In this computation it counts as {} \
             samples, the mean number for a recorded load case. The gauge values under the load are predicted by a linear model of the same data.",
            significant(weight, 2)
        ),
    };
    if memoryless.len() < columns.len() {
        note.push_str(" Features that use earlier gauge values are ignored in this choice, because their values depend on how a load is reached.");
    }
    if axes.iter().zip(&moves).any(|(axis, moves)| *moves && !axis.rated) {
        note.push_str(
            " On axes without a rated load, the proposed loads stay within the recorded range.",
        );
    }
    // No available mass and arm make a load on the other axes. For example, without an arm there is no moment.
    let reached = |axis: usize| loads.iter().any(|(load, _)| load[axis] != 0.0);
    let unreached = (0..axes.len()).filter(|axis| !reached(*axis));
    let unreached: Vec<&str> = unreached.map(|axis| axes[axis].axis.symbol()).collect();
    let unreached = (hanging.is_some() && !loads.is_empty() && !unreached.is_empty()).then(|| {
        let seen =
            format!("the available masses and arms make no load on {}", unreached.join(", "));
        Finding::new(Id::Unreached, Enough, seen)
    });
    if moves.contains(&false) {
        note.push_str(
            " First record loads on the axes on which the load never changes. These axes are not in the list.",
        );
    }
    (next, note, unreached)
}

/// Returns loads that could be recorded next: at the ends of the range of each axis that the recordings load, and halfway
/// to zero, on one axis or on two axes at a time.
fn within(axes: &[AxisReach], moves: &[bool]) -> Vec<Vec<f64>> {
    let none: Vec<f64> = axes.iter().map(|own| 0.0_f64.clamp(own.region.0, own.region.1)).collect();
    let moving: Vec<usize> = (0..axes.len()).filter(|axis| moves[*axis]).collect();
    let levels = |axis: usize| {
        let (low, high) = axes[axis].region;
        let zero = none[axis];
        let levels = [low, high, 0.5 * (low + zero), 0.5 * (high + zero)];
        levels.into_iter().filter(move |level| *level != zero)
    };
    let mut loads = vec![none.clone()];
    for (at, &a) in moving.iter().enumerate() {
        for one in levels(a) {
            let mut alone = none.clone();
            alone[a] = one;
            for &b in &moving[at + 1..] {
                for other in levels(b) {
                    let mut both = alone.clone();
                    both[b] = other;
                    loads.push(both);
                }
            }
            loads.push(alone);
        }
    }
    loads
}

/// Returns loads that could be recorded next: those of the available masses on the arms, with gravity along the axes of the sensor or halfway
/// between two. Loads that exceed the largest load of an axis are omitted.
fn hung(hanging: &HangingMass, axes: &[AxisReach]) -> Vec<(Vec<f64>, Option<String>)> {
    let steps = [-1.0, 0.0, 1.0];
    let ways = steps
        .into_iter()
        .flat_map(|x| steps.into_iter().flat_map(move |y| steps.map(|z| [x, y, z])));
    let ways: Vec<[f64; 3]> = ways.filter(|way| way.iter().any(|part| *part != 0.0)).collect();
    let axis_ways = |way: &&[f64; 3]| way.iter().filter(|part| **part != 0.0).count() == 1;
    let mut centres = vec![[0.0; 3]];
    for arm in hanging.arms.iter().filter(|arm| **arm != 0.0) {
        centres.extend(ways.iter().filter(axis_ways).map(|way| way.map(|part| part * arm)));
    }
    let named = |way: &[f64; 3]| -> String {
        let parts = way.iter().zip(["x", "y", "z"]).filter(|(part, _)| **part != 0.0);
        parts.map(|(part, name)| format!("{}{name}", if *part > 0.0 { "+" } else { "−" })).collect()
    };
    let mut loads = Vec::new();
    for mass in &hanging.masses {
        for centre in &centres {
            for way in &ways {
                let length = way.iter().map(|part| part * part).sum::<f64>().sqrt();
                let pull = way.map(|part| STANDARD_GRAVITY * part / length);
                let weight = Weight { mass_kg: *mass, centre_m: *centre };
                let wrench = load_of_pull(&UPRIGHT, &weight, pull);
                let load: Vec<f64> = axes.iter().map(|own| wrench[own.axis as usize]).collect();
                let limit = |own: &AxisReach| own.region.0.abs().max(own.region.1.abs());
                let fits = |(load, own): (&f64, _)| load.abs() <= limit(own) * (1.0 + 1e-9);
                if load.iter().zip(axes).all(fits) {
                    let arm = match centre.iter().find(|part| **part != 0.0) {
                        None => String::new(),
                        Some(part) => format!(" at {} m along {}", part.abs(), named(centre)),
                    };
                    loads.push((load, Some(format!("{mass} kg{arm}, down is {}", named(way)))));
                }
            }
        }
    }
    loads
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::calibration::{FitSettings, RidgeChoice};
    use crate::features::{Blocks, FeatureSettings, Polynomial};
    use crate::questions::errors::query::analyse;
    use crate::random::Random;
    use crate::recording::{Entry, GaugeRange, Recording, RecordingSet, Source, simulated};

    fn check_of(request: &Request, hanging: Option<HangingMass>) -> Sufficiency {
        sufficiency(&CheckData::of(request, ValidRange::default(), hanging), &Progress::default())
            .unwrap()
    }

    /// Returns static poses on three axes, each held for `held` samples, in recordings with this number of poses.
    fn poses(n: usize, held: usize, per_recording: usize) -> Arc<RecordingSet> {
        let mut random = Random::new(3, &[2]);
        let mut set = RecordingSet::default();
        let loads: Vec<[f64; 3]> =
            (0..n).map(|_| [(); 3].map(|()| 10.0 * random.normal())).collect();
        for (at, loads) in loads.chunks(per_recording).enumerate() {
            let loads: Vec<[f64; 3]> = loads.iter().flat_map(|load| vec![*load; held]).collect();
            let gauges = loads.iter().flat_map(|[x, y, z]| {
                let noise = [(); 4].map(|()| 0.05 * random.normal());
                [
                    x + noise[0],
                    y - 0.3 * x + noise[1],
                    z + 0.01 * x * z + noise[2],
                    x + y + z + noise[3],
                ]
            });
            let recording = Recording::new(
                format!("pose {at}"),
                Source::Simulated,
                (0..loads.len()).map(|k| k as f64).collect(),
                ["S1", "S2", "S3", "S4"].map(str::to_owned).to_vec(),
                gauges.collect(),
                vec![Axis::Fx, Axis::Fy, Axis::Fz],
                loads.as_flattened().to_vec(),
            );
            set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
        }
        Arc::new(set)
    }

    fn quadratic(ridge: f64) -> FitSettings {
        FitSettings {
            features: FeatureSettings {
                blocks: Blocks::default().with(&Polynomial, &[2.0]),
                ..FeatureSettings::present()
            },
            ridge: RidgeChoice::Strength(ridge),
            ..FitSettings::default()
        }
    }

    fn of(set: Arc<RecordingSet>, settings: FitSettings) -> Sufficiency {
        check_of(&Request::fit(set, settings), None)
    }

    fn abouts(found: &Sufficiency, verdict: Verdict) -> Vec<Id> {
        let of = found.reasons.iter().filter(|reason| reason.severity == verdict);
        of.map(|reason| reason.id).collect()
    }

    #[test]
    fn as_many_poses_as_coefficients_do_not_carry_the_model_and_many_do() {
        let few = of(poses(16, 20, 4), quadratic(0.0));
        assert_eq!(
            (few.verdict, few.count.coefficients, few.count.load_cases),
            (Verdict::Insufficient, 15, 16)
        );
        assert!(abouts(&few, Verdict::Insufficient).contains(&Id::FewLoads), "{:#?}", few.reasons);
        let many = of(poses(200, 20, 50), quadratic(0.0));
        assert_eq!(many.verdict, Verdict::Enough, "{:#?}", many.reasons);
        assert!(abouts(&many, Verdict::Doubtful).is_empty());
        let shrunk = of(poses(16, 20, 4), quadratic(1.0));
        let free = shrunk.count.free_coefficients;
        assert!(free < 13.0, "{free}");
    }

    /// 15 columns, of which a strong ridge leaves fewer than 13 free: 28 loads are enough for them.
    #[test]
    fn fit_and_check_judge_the_number_of_loads_alike() {
        let is_few = |own: &Finding| own.id == Id::FewLoads;
        for (n, ridge) in [(16, 0.0), (28, 0.0), (28, 1.0), (40, 0.0)] {
            let request = Request::fit(poses(n, 20, 4), quadratic(ridge));
            let fitted = analyse(&request, &Progress::default()).unwrap().findings;
            let checked = of(request.recordings, request.settings).reasons;
            let few = [fitted, checked].map(|found| found.iter().any(is_few));
            let expected = ridge == 0.0 && n < 30;
            assert_eq!(few, [expected; 2], "{n} loads, ridge {ridge}");
        }
    }

    #[test]
    fn entered_limits_of_gauges_count_and_faults_are_looked_for_once() {
        let set = poses(40, 20, 4);
        let limited = |high: f64| {
            let request = Request::fit(Arc::clone(&set), quadratic(0.0));
            let gauges = Some(GaugeRange::All((-100.0, high)));
            CheckData::of(&request, ValidRange { gauges, ..ValidRange::default() }, None)
        };
        let told = |asked: &CheckData| {
            let found = sufficiency(asked, &Progress::default()).unwrap();
            let about = found.reasons.iter().find(|reason| reason.id == Id::Faults);
            about.map(|reason| reason.severity)
        };
        let asked = limited(5.0);
        assert_eq!(told(&limited(100.0)), None);
        assert_eq!(told(&asked), Some(Verdict::Doubtful));
        let again = || {
            let found = asked.request.datasets.faults(&set, &asked.range, &Progress::default());
            found.unwrap()
        };
        assert!(Arc::ptr_eq(&again()[0], &again()[0]));
    }

    #[test]
    fn what_is_proposed_is_within_the_loads_or_hangs() {
        let rated = FitSettings { full_scale: vec![Some(20.0); 3], ..quadratic(0.0) };
        let request = Request::fit(poses(40, 5, 10), rated);
        let free = check_of(&request, None);
        assert_eq!(free.next.len(), PROPOSED);
        assert!(free.next.iter().all(|own| own.load.iter().all(|load| load.abs() <= 20.0)));
        assert!(
            free.next.is_sorted_by(|a, b| a.gain >= b.gain && a.variance_left >= b.variance_left)
        );
        let hanging = HangingMass { masses: vec![1.5, 30.0], arms: vec![0.1] };
        let hung = check_of(&request, Some(hanging));
        assert!(hung.reasons.iter().all(|own| own.id != Id::Unreached), "{:#?}", hung.reasons);
        for own in &hung.next {
            let force = own.load.iter().map(|load| load * load).sum::<f64>().sqrt();
            assert!(
                (force - 1.5 * STANDARD_GRAVITY).abs() < 1e-9,
                "30 kg are beyond what is rated"
            );
            assert!(own.how.as_ref().unwrap().starts_with("1.5 kg"));
        }
    }

    #[test]
    fn recordings_that_say_little_are_told_so_without_a_panic() {
        let one =
            |n: usize, gauges: &dyn Fn(usize) -> [f64; 3], loads: &dyn Fn(usize) -> [f64; 2]| {
                let recording = Recording::new(
                    "r",
                    Source::Simulated,
                    (0..n).map(|k| k as f64 * 0.1).collect(),
                    ["S1", "S2", "S3"].map(str::to_owned).to_vec(),
                    (0..n).flat_map(gauges).collect(),
                    vec![Axis::Fx, Axis::My],
                    (0..n).flat_map(loads).collect(),
                );
                let mut set = RecordingSet::default();
                set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
                of(Arc::new(set), FitSettings::default())
            };
        let noise = |k: usize, of: u64| Random::new(9, &[k as u64, of]).normal();
        let gauges = |k| [1, 2, 3].map(|at| noise(k, at));
        let worst = |found: &Sufficiency| abouts(found, Verdict::Insufficient);
        let zero = one(50, &gauges, &|_| [0.0; 2]);
        assert_eq!(worst(&zero), [Id::Still, Id::FewLoads]);
        assert!(zero.reasons[0].seen.contains("Fx") && zero.reasons[0].seen.contains("My"));
        assert!(zero.next.is_empty() && zero.axes[0].moves_with.is_none());
        let single = one(1, &gauges, &|_| [1.0, 2.0]);
        assert!(worst(&single).contains(&Id::Undetermined));
        let unlike = one(300, &gauges, &|k| [noise(k, 4), noise(k, 5)]);
        assert_eq!(worst(&unlike), [Id::NoBetterThanMean]);
        // A mass on one arm: the effects of both axes together are determined, but not each of them.
        let load = |k: usize| 10.0 * (0.1 * k as f64).sin();
        let hung = one(
            300,
            &|k| [1.0, 2.0, -0.5].map(|slope| slope * load(k) + 0.01 * noise(k, 1)),
            &|k| [load(k), 0.1 * load(k)],
        );
        assert_eq!(worst(&hung), [Id::MovesTogether], "{:#?}", hung.reasons);
        assert_eq!(hung.axes[0].moves_with, Some((Axis::My, 1.0)));
        let dead = one(300, &|k| [load(k), 5.0, load(k)], &|k| [load(k), load(k + 40)]);
        for found in [&zero, &single, &unlike, &hung, &dead] {
            let text = serde_json::to_string(found).unwrap();
            assert!(!text.contains("NaN"));
        }
    }

    #[test]
    fn the_built_in_sensor_has_enough() {
        let set = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
        let settings = FitSettings { decimation: 10, ..FitSettings::default() };
        let found = of(set, settings);
        assert_eq!(found.verdict, Verdict::Enough, "{:#?}", found.reasons);
        assert!(found.rig.findings.is_empty(), "{:?}", found.rig.findings);
    }
}
