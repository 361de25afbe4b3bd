//! Checks whether training recordings suffice for a model. The check needs only sums from one pass over the samples.

use std::ops::Range;
use std::sync::Arc;

use crate::{
    calibration::{Calibration, Regressor},
    finding::{Finding, Id, Verdict},
    min_max::MinMax,
    progress::Progress,
    questions::{
        budget::{error_budget, remedies},
        check::{
            independent_loads::{AxisReach, Sufficiency},
            judgement::ONE_WAY,
        },
        dataset::{Dataset, Datasets},
        error::AnalysisError,
        errors::{
            cold_start::worse_at_start,
            findings::{LoadCount, findings_of_fit},
        },
        expected_error::rule::{is_one_axis_at_a_time, is_one_programme, not_covered},
        question::{Answered, Query, Work},
        request::Request,
    },
    recording::{Entry, Recording, RecordingSet, Role, ValidRange, in_role},
    same::same_where,
    scoring::{
        coverage::Coverage,
        faults::Faults,
        load_spread::LoadSpread,
        numbers::{percent, significant},
        rig::{Rig, Suspicion, lag_of_fit, matters},
    },
    shown::{counted, first_clauses, joined},
};
use Verdict::{Doubtful, Enough};

/// Maximum number of recordings with faults whose names are shown.
const FAULTY: usize = 3;
/// Share of faulty training samples above which the finding makes the verdict doubtful even if the error is not smaller
/// without them.
const FAULTY_SHARE: f64 = 0.05;

/// Request to check training recordings: faults of the test rig, and whether the loads determine the model.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckData {
    /// Request for a fit. Its recordings and features are to be checked.
    pub request: Request,
    /// Limits of the gauges and loads that the user entered. Samples outside them are faulty.
    pub range: ValidRange,
    /// For each file that could not be used, the reason.
    pub unusable: Vec<String>,
}

impl CheckData {
    /// Returns the request to check the recordings of this fit.
    pub fn of(request: &Request, range: ValidRange) -> Self {
        Self { request: request.plain(), range, unusable: Vec::new() }
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

/// Returns findings about the test rig and the linear model.
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
    let mut calibration = data.unfitted(settings, progress)?;
    let past = data.past(&calibration, progress)?;
    let design = calibration.design();
    let sums = data.sums(&design, &past, calibration.axes.len(), progress);
    progress.check()?;
    data.fit_sums(settings.ridge, &sums, &past, &mut calibration, progress)?;

    let coverage = data.coverage(&calibration.axes);
    let training = in_role(&data.entries, Role::Train);
    let loads = training.iter().flat_map(|own| own.loads().chunks_exact(calibration.axes.len()));
    let spread = LoadSpread::of(loads, &coverage.trained);
    let axes = reaches(&calibration, coverage, &spread);
    let (n_samples, count) = (sums.train.n_samples(), LoadCount::of(&calibration, coverage));
    let axes_n = calibration.axes.len();
    let mut reasons = findings_of_fit(&data, &calibration, true);
    let rig = data.rig(progress)?;
    reasons.extend(rig.into_iter().flat_map(|rig| rig.findings.clone()));
    let unusable = asked.unusable.iter();
    reasons.extend(unusable.map(|why| Finding::new(Id::Unusable, Doubtful, why.as_str())));
    if let Some(lag) = data.lag(progress)? {
        reasons.push(lag_of_fit(lag, &calibration));
    }
    reasons.extend(of_programmes(&data, axes_n));
    reasons.extend(worse_at_start(&data, &calibration)?);
    let faults = faulty(asked, &calibration.full_scale, &mut reasons, progress)?;
    if settings.regressor != Regressor::Linear {
        let seen = "this check judges the linear model of these features, not the network or kernel of the fit";
        reasons.push(Finding::new(Id::LinearOnly, Enough, seen));
    }
    let how = calibration.quality.cross_validation.as_ref().map(ToString::to_string);
    let not_covered = not_covered(&data.entries, axes_n, data.groups.by);
    let budget = error_budget(&asked.request, &calibration, progress)?;
    let rig = rig.cloned().unwrap_or_default();
    let is_explained = |own: &Suspicion| {
        budget.as_ref().is_ok_and(|budget| 1.0 - budget.explained_by_columns() <= own.left)
    };
    let suspicion = rig.suspicion.iter().filter(|own| !is_explained(own));
    reasons.extend(suspicion.map(|own| own.finding.clone()));
    let remedies = match &budget {
        Ok(budget) => remedies(&asked.request, &calibration, &rig, budget, progress)?,
        Err(_) => Vec::new(),
    };
    let found = Sufficiency {
        verdict: Verdict::Enough,
        budget: budget.map_err(|reason| reason.to_string()),
        remedies,
        summary: format!("{}, {}", count.words(), counted(n_samples as usize, "sample")),
        findings: reasons,
        n_samples,
        count,
        rank: calibration.quality.rank,
        condition: calibration.quality.condition,
        faults,
        rig,
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
    let Request { recordings, datasets, .. } = &asked.request;
    let found = datasets.faults(recordings, &asked.range, progress)?;
    let all = recordings.entries().iter().zip(&found);
    let training = all.filter(|(entry, _)| entry.role == Role::Train);
    let (training, found): (Vec<&Recording>, Vec<&Arc<Faults>>) =
        training.map(|(entry, found)| (&*entry.recording, found)).unzip();
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
        .map(|rig| [rig.left_out_error(), rig.error_of(&training, is_sound)])
        .filter(|[with, without]| matters(*with, *without));
    let is_doubtful = errors.is_some() || share > FAULTY_SHARE;
    let seen = format!("{} of the training samples are faulty", percent(share));
    let mut figures = first_clauses(FAULTY, &words);
    if let Some(errors) = errors {
        let [with, without] = errors.map(|own| significant(100.0 * own, 2));
        figures += &format!(
            "; the held-out error is {with} % of full scale, and {without} % without these samples"
        );
    }
    let severity = if is_doubtful { Doubtful } else { Enough };
    let cost = errors.map_or(share, |[with, without]| with - without);
    reasons.push(Finding::new(Id::Faults, severity, seen).with(figures).costing(cost));
    Ok(words)
}

/// Returns a text about the loads with which the calibration was tested, and about conditions that the recordings do not
/// cover.
fn shown_for(axes: &[AxisReach], n: usize, how: Option<&str>, not_covered: &str) -> String {
    let loads = axes.iter().map(|own| {
        let [low, high] = [own.low, own.high].map(|end| significant(end, 3));
        format!("{} {low} to {high} {}", own.axis.symbol(), own.axis.unit())
    });
    format!(
        "The calibration was tested with loads {} in {} ({}). {not_covered}",
        joined(", ", loads),
        counted(n, "training recording"),
        how.unwrap_or("not cross-validated")
    )
}

fn reaches(calibration: &Calibration, coverage: &Coverage, spread: &LoadSpread) -> Vec<AxisReach> {
    let scores = &calibration.quality.compensated;
    let of = |errors: &Option<Vec<f64>>, at: usize| errors.as_ref().map(|errors| errors[at]);
    let n_axes = calibration.axes.len();
    let axes = calibration.axes.iter().enumerate().map(|(at, axis)| {
        let MinMax { min: low, max: high } = coverage.trained[at];
        let full_scale = calibration.full_scale[at];
        let rated = calibration.rated.get(at) == Some(&true);
        // An axis that is loaded one way is rated for this direction.
        let end = |this: f64, other: f64, recorded: f64| {
            let is_unused = this <= ONE_WAY * other;
            if !rated {
                recorded
            } else if is_unused {
                0.0
            } else {
                full_scale
            }
        };
        let (up, down) = (high.max(0.0), (-low).max(0.0));
        let correlated = (0..n_axes).filter(|other| *other != at).filter_map(|other| {
            Some((calibration.axes[other], spread.correlations[at * n_axes + other]?))
        });
        AxisReach {
            axis: *axis,
            low,
            high,
            full_scale,
            rated,
            region: (0.0 - end(down, up, -low), end(up, down, high)),
            deviation: spread.deviations[at],
            inflation: spread.inflations[at],
            train_rmse: of(&scores.train_rmse, at),
            left_out_rmse: of(&scores.cv_rmse, at),
            moves_with: correlated.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs())),
        }
    });
    axes.collect()
}

/// Returns findings about recordings that load one axis at a time, or that all repeat one sequence of loads.
fn of_programmes(data: &Dataset, n_axes: usize) -> Vec<Finding> {
    let training = in_role(&data.entries, Role::Train);
    let n = training.len();
    let all = if n == 2 { "both".to_owned() } else { format!("all {n}") };
    let separate = n_axes > 1 && is_one_axis_at_a_time(&data.entries, n_axes);
    let found = [
        (
            separate,
            Id::OneAxisAtATime,
            "in the training recordings, the axes are loaded one at a time".to_owned(),
        ),
        (
            is_one_programme(&training),
            Id::OneProgramme,
            format!("{all} training recordings repeat the same sequence of loads"),
        ),
    ];
    let found = found.into_iter().filter(|(is_seen, ..)| *is_seen);
    found.map(|(_, id, seen)| Finding::new(id, Doubtful, seen)).collect()
}

/// Request for the faulty samples of recordings, which the window marks.
#[derive(Clone, Debug)]
pub struct FindFaults {
    /// Recordings to search.
    pub recordings: Arc<RecordingSet>,
    /// Limits of the sensor's gauges and loads, outside which a sample is faulty.
    pub range: ValidRange,
    /// Cache of the faults that were found before.
    pub datasets: Datasets,
}

/// Faulty samples of one recording.
#[derive(Debug)]
pub struct FaultyRecording {
    /// Number of samples of the recording that cannot be used.
    pub n_samples: usize,
    /// For each kind of fault, a text that describes where it occurs.
    pub words: Vec<String>,
    /// Start and end (s) of each fault, on the recording's own clock.
    pub intervals: Vec<(f64, f64)>,
}

impl FindFaults {
    /// Returns the request about the recordings of another request.
    pub fn of(request: &Request, range: ValidRange) -> Self {
        let recordings = Arc::clone(&request.recordings);
        Self { recordings, range, datasets: request.datasets.clone() }
    }
}

same_where!(FindFaults: shared(recordings) value(range) besides(datasets));

impl Query for FindFaults {
    type Answer = Vec<Arc<FaultyRecording>>;
    type Cache = ();

    fn title(&self) -> String {
        "Looking for faulty samples".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let found = self.datasets.faults(&self.recordings, &self.range, work.progress)?;
        let entries = self.recordings.entries().iter().zip(&found);
        let of = |(entry, faults): (&Entry, &Arc<Faults>)| {
            let (recording, samples) = (&*entry.recording, faults.samples());
            let times = recording.times();
            let interval = |own: &Range<usize>| (times[own.start], times[own.end - 1]);
            Arc::new(FaultyRecording {
                n_samples: faults.n_samples(),
                words: faults.in_words(recording),
                intervals: samples.iter().map(interval).collect(),
            })
        };
        Ok(entries.map(of).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::calibration::{FitSettings, RidgeChoice};
    use crate::features::{Blocks, FeatureSettings, Polynomial};
    use crate::questions::errors::query::analyse;
    use crate::random::Random;
    use crate::recording::{Axis, Entry, GaugeRange, Recording, RecordingSet, Source, simulated};

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
        let asked = CheckData::of(&Request::fit(set, settings), ValidRange::default());
        sufficiency(&asked, &Progress::default()).unwrap()
    }

    fn abouts(found: &Sufficiency, verdict: Verdict) -> Vec<Id> {
        let of = found.findings.iter().filter(|reason| reason.severity == verdict);
        of.map(|reason| reason.id).collect()
    }

    #[test]
    fn as_many_poses_as_coefficients_do_not_carry_the_model_and_many_do() {
        let few = of(poses(16, 20, 4), quadratic(0.0));
        assert_eq!(
            (few.verdict, few.count.coefficients, few.count.load_cases),
            (Verdict::Insufficient, 15, 16)
        );
        assert!(abouts(&few, Verdict::Insufficient).contains(&Id::FewLoads), "{:#?}", few.findings);
        let many = of(poses(200, 20, 50), quadratic(0.0));
        assert_eq!(many.verdict, Verdict::Enough, "{:#?}", many.findings);
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
            let checked = of(request.recordings, request.settings).findings;
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
            CheckData::of(&request, ValidRange { gauges, ..ValidRange::default() })
        };
        let told = |asked: &CheckData| {
            let found = sufficiency(asked, &Progress::default()).unwrap();
            let about = found.findings.iter().find(|reason| reason.id == Id::Faults);
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
        assert!(zero.findings[0].seen.contains("Fx") && zero.findings[0].seen.contains("My"));
        assert!(zero.axes[0].moves_with.is_none());
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
        assert_eq!(worst(&hung), [Id::MovesTogether], "{:#?}", hung.findings);
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
        assert_eq!(found.verdict, Verdict::Enough, "{:#?}", found.findings);
        assert!(found.rig.findings.is_empty(), "{:?}", found.rig.findings);
    }
}
