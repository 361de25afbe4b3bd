//! The same sensor on other days: what moved, and how much of the calibration has to be fitted again.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::analysis::dataset::{Dataset, Key};
use crate::analysis::learning::TrainingStep;
use crate::analysis::training::train;
use crate::analysis::{AnalysisError, Request};
use crate::calibration::{
    Calibration, CannotFold, FitSettings, Learned, NormalEquations, OutputChange, Ridge,
    RidgeChoice, Scores, Terms, fit,
};
use crate::evaluation::left_out::LeftOut;
use crate::evaluation::metrics::root_mean;
use crate::evaluation::sessions::{
    Drift, Refit, RefitScores, Session, changes, gauge_states, latest,
};
use crate::features::ColumnKind;
use crate::progress::Progress;
use crate::recording::{DateSource, Day, Entry, RECORDING, Recording, RecordingSet, Role, Source};

/// What changed, and the calibrations that go on from here, where there is one.
#[derive(Clone, Debug)]
pub struct Drifted {
    /// In figures and words.
    pub found: Drift,
    /// The refitted calibrations.
    pub calibrations: Vec<(Refit, Arc<Calibration>)>,
    /// What they were fitted to.
    pub fitted_to: Arc<RecordingSet>,
    /// Whether the old calibration has learned something, which can be trained again.
    pub is_learned: bool,
}

/// The sessions that recordings are of: what they are told apart by, and for each, in order of time, its name and recordings.
type Sessions = (&'static str, Vec<(String, Vec<usize>)>);

/// What hears how far a network or kernel is.
pub type OnStep<'a> = &'a mut dyn FnMut(TrainingStep);

/// Why what was learned is not fitted again.
const NOT_TRAINED: &str = "a network or a kernel is trained again only where that is asked for (Train again); it is scored on parts that \
                           it has not seen, which takes several times as long as training it";

/// Compares the sessions of recordings, and a calibration on all of them (or the fit to the first, on the others) with refits. Networks
/// and kernels are trained where somebody hears of their steps; else the fit to the first session is linear.
///
/// # Errors
/// [`AnalysisError`] where there is no recording with a reference that is not off, or the calibration has other gauges.
pub fn drift(
    recordings: &RecordingSet,
    calibration: Option<&Calibration>,
    settings: &FitSettings,
    mut training: Option<OnStep<'_>>,
    progress: &Progress,
) -> Result<Drifted, AnalysisError> {
    let is_used = |entry: &&Entry| entry.role != Role::Off && entry.recording.has_reference();
    let used = recordings.entries().iter().filter(is_used);
    let used: Vec<Entry> = used.cloned().collect();
    if used.is_empty() {
        return Err(AnalysisError::NoRecordings);
    }
    let (by, sessions) = sessions(recordings, &used);
    let fitted_now = match calibration {
        Some(_) => None,
        None => {
            let first = set_of(sessions[0].1.iter().map(|at| &used[*at]));
            Some(match (settings.regressor.learner(), &mut training) {
                (Some(_), Some(on_step)) => train(
                    &Request::fit(Arc::new(first), settings.clone()),
                    progress,
                    on_step,
                )?,
                _ => fitted(first, settings, progress)?,
            })
        }
    };
    let old = calibration
        .or(fitted_now.as_ref())
        .expect("one of them is there");
    for entry in &used {
        old.check_gauges(&entry.recording)?;
        if *entry.recording.axes() != old.axes {
            return Err(AnalysisError::OtherAxes {
                recording: entry.recording.name().to_owned(),
            });
        }
    }
    progress.check()?;
    let states = sessions
        .iter()
        .map(|(name, own)| session(name, own.iter().map(|at| &used[*at]), old));
    let states: Vec<Session> = states.collect();
    progress.check()?;
    // The fit to the first session knows it.
    let first = usize::from(calibration.is_none());
    let since = match by {
        RECORDING => first,
        _ => latest(&states, &old.full_scale).max(first),
    };
    let newest = sessions.iter().skip(since);
    let new: Vec<usize> = newest.flat_map(|(_, own)| own.iter().copied()).collect();
    let fitted_to = Arc::new(set_of(new.iter().map(|at| &used[*at])));
    let (refits, calibrations, left_out) = match new.is_empty() {
        true => (Vec::new(), Vec::new(), None),
        false => refits(
            &fitted_to,
            old,
            settings,
            calibration.is_none(),
            training,
            progress,
        )?,
    };
    let found = Drift {
        by,
        refitted_from: since,
        changes: changes(&states, &old.gauges, &old.axes, &old.full_scale),
        sessions: states,
        axes: old.axes.clone(),
        full_scale: old.full_scale.clone(),
        gauges: old.gauges.clone(),
        old: match calibration {
            Some(own) => format!("made by {} of {}", own.program, own.trained_on.join(", ")),
            None => format!("fitted to the first session, {}", sessions[0].0),
        },
        left_out,
        refits,
        sentences: Vec::new(),
    };
    Ok(Drifted {
        found: found.told(),
        calibrations,
        fitted_to,
        is_learned: old.learned.is_some(),
    })
}

/// All of them to train on, as they are grouped.
fn set_of<'a>(entries: impl Iterator<Item = &'a Entry>) -> RecordingSet {
    let mut set = RecordingSet::default();
    for entry in entries {
        let entry = Entry {
            role: Role::Train,
            ..entry.clone()
        };
        set.push(entry).expect("they were in one set");
    }
    set
}

/// By groups that somebody set, or that are days or mountings; else by the days of their dates; else by recordings.
fn sessions(recordings: &RecordingSet, used: &[Entry]) -> Sessions {
    const SESSION_WORDS: [&str; 6] = ["day", "session", "mounting", "mount", "setup", "batch"];
    let groups = recordings.groups();
    let place = |entry: &Entry| {
        recordings
            .entries()
            .iter()
            .position(|own| Arc::ptr_eq(&own.recording, &entry.recording))
    };
    let group = |entry: &Entry| {
        let set = entry.group.clone();
        let found = || {
            SESSION_WORDS
                .contains(&groups.by)
                .then(|| groups.name_of(place(entry)?).map(str::to_owned))
                .flatten()
        };
        set.or_else(found)
    };
    let day = |entry: &Entry| Some(entry.recording.dated()?.day.to_string());
    let named = |of: &dyn Fn(&Entry) -> Option<String>| {
        let names: Option<Vec<String>> = used.iter().map(of).collect();
        let names = names?;
        let mut each: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        names
            .into_iter()
            .enumerate()
            .for_each(|(at, name)| each.entry(name).or_default().push(at));
        (each.len() > 1).then(|| each.into_iter().collect::<Vec<_>>())
    };
    let (by, mut found) = match (named(&group), named(&day)) {
        (Some(found), _) => ("group", found),
        (None, Some(found)) => ("day", found),
        (None, None) => {
            // Loggers call every file the same; then its folder says which.
            let named = |entry: &Entry| {
                let name = entry.recording.name();
                let again = used
                    .iter()
                    .filter(|other| other.recording.name() == name)
                    .count()
                    > 1;
                let Source::File(path) = entry.recording.source() else {
                    return name.to_owned();
                };
                let folder = path.parent().and_then(Path::file_name).filter(|_| again);
                folder.map_or_else(
                    || name.to_owned(),
                    |folder| format!("{}/{name}", folder.to_string_lossy()),
                )
            };
            let own = used
                .iter()
                .enumerate()
                .map(|(at, entry)| (named(entry), vec![at]));
            (RECORDING, own.collect())
        }
    };
    // In the order in which they were loaded, but for what dates and clocks tell.
    found.sort_by_key(|(_, own)| own.first().copied());
    let of = |own: &[usize]| {
        own.iter()
            .map(|at| &*used[*at].recording)
            .collect::<Vec<_>>()
    };
    let days: Vec<Option<Day>> = found.iter().map(|(_, own)| first_day(&of(own))).collect();
    if days.iter().all(Option::is_some) {
        let start = |own: &[usize]| started(&of(own)).unwrap_or(0.0);
        found.sort_by(|(_, a), (_, b)| {
            let by_day = first_day(&of(a)).cmp(&first_day(&of(b)));
            by_day.then(start(a).total_cmp(&start(b)))
        });
    }
    (by, found)
}

/// The first day of recordings, where all have one.
fn first_day(recordings: &[&Recording]) -> Option<Day> {
    let days = recordings.iter().map(|own| Some(own.dated()?.day));
    days.min().flatten()
}

/// When the first of them began, where all their clocks say so.
fn started(recordings: &[&Recording]) -> Option<f64> {
    let starts: Option<Vec<f64>> = recordings.iter().map(|own| own.started()).collect();
    starts.and_then(|starts| starts.into_iter().min_by(f64::total_cmp))
}

fn session<'a>(name: &str, entries: impl Iterator<Item = &'a Entry>, old: &Calibration) -> Session {
    let recordings: Vec<_> = entries.map(|entry| &*entry.recording).collect();
    let n_axes = old.axes.len();
    let (mut sums, mut squares, mut n) = (vec![0.0; n_axes], vec![0.0; n_axes], 0);
    for recording in &recordings {
        let Ok(applied) = old.apply(recording) else {
            continue;
        };
        n += recording.n_samples() as u64;
        for (load, known) in applied
            .compensated
            .chunks_exact(n_axes)
            .zip(recording.loads().chunks_exact(n_axes))
        {
            for (axis, (load, known)) in load.iter().zip(known).enumerate() {
                sums[axis] += load - known;
                squares[axis] += (load - known).powi(2);
            }
        }
    }
    let dated = recordings.iter().filter_map(|own| own.dated());
    let mut dated_by: Vec<DateSource> = dated.map(|own| own.from).collect();
    dated_by.sort_unstable();
    dated_by.dedup();
    Session {
        name: name.to_owned(),
        started: started(&recordings),
        day: first_day(&recordings),
        dated_by,
        recordings: recordings.iter().map(|own| own.name().to_owned()).collect(),
        n_samples: n,
        gauges: gauge_states(&recordings),
        mean_error: sums.iter().map(|sum| sum / n.max(1) as f64).collect(),
        rmse: root_mean(&squares, n).unwrap_or_default(),
    }
}

/// The linear fit to these recordings.
fn fitted(
    set: RecordingSet,
    settings: &FitSettings,
    progress: &Progress,
) -> Result<Calibration, AnalysisError> {
    settings.validate()?;
    let request = Request::fit(Arc::new(set), settings.clone());
    let data = Dataset::prepare(&Key::of(&request), progress)?;
    let mut calibration = data.blank_calibration(settings)?;
    let past = data.past(&calibration, progress)?;
    data.fit(settings.ridge, &past, &mut calibration, progress)?;
    Ok(calibration)
}

/// The settings that made a calibration, as far as it says.
fn settings_of(calibration: &Calibration, settings: &FitSettings) -> FitSettings {
    let is_rated = |at: usize| calibration.rated.get(at) == Some(&true);
    let full_scale = calibration.full_scale.iter().enumerate();
    let strengths = &calibration.quality.ridge;
    let (mut network, mut kernel) = (settings.network.clone(), settings.kernel);
    match &calibration.learned {
        Some(Learned::Network(own)) => {
            let hidden = own
                .layers
                .split_last()
                .map_or(&[][..], |(_, hidden)| hidden);
            network.hidden = hidden.iter().map(|layer| layer.biases.len()).collect();
        }
        Some(Learned::Kernel(own)) => kernel.landmarks = own.landmarks.len(),
        None => {}
    }
    FitSettings {
        regressor: calibration.regressor,
        network,
        kernel,
        auxiliary_references: (calibration.features.auxiliary.iter())
            .map(|channel| (channel.name.clone(), channel.reference))
            .collect(),
        features: calibration.features.clone(),
        offset: calibration.offset,
        decimation: calibration.decimation,
        ridge: match strengths.iter().all(|strength| *strength == 0.0) {
            true if calibration.quality.ridge_by_block.is_empty() => RidgeChoice::Strength(0.0),
            true => RidgeChoice::ByBlock,
            false => RidgeChoice::Auto,
        },
        full_scale: full_scale
            .map(|(at, scale)| is_rated(at).then_some(*scale))
            .collect(),
        ..settings.clone()
    }
}

type Refits = (
    Vec<RefitScores>,
    Vec<(Refit, Arc<Calibration>)>,
    Option<String>,
);

fn refits(
    new: &Arc<RecordingSet>,
    old: &Calibration,
    settings: &FitSettings,
    is_ours: bool,
    training: Option<OnStep<'_>>,
    progress: &Progress,
) -> Result<Refits, AnalysisError> {
    let mut settings = if is_ours {
        settings.clone()
    } else {
        settings_of(old, settings)
    };
    // As honest as what it stands beside.
    settings.network.cross_validate = true;
    let request = Request::fit(Arc::clone(new), settings.clone());
    let data = Dataset::prepare(&Key::of(&request), progress)?;
    let n_axes = old.axes.len();
    let [conventional, compensated] = outputs(&data, old);
    progress.check()?;
    let how = data.cross_validation();
    let scored = |refit: Refit, train_rmse, left_out_rmse, problem: Option<String>| RefitScores {
        refit,
        train_rmse,
        left_out_rmse,
        problem,
    };
    let as_it_is = |parts: &[NormalEquations]| {
        let total = total(parts);
        let squares: Vec<f64> = (0..n_axes).map(|axis| total.target_square(axis)).collect();
        root_mean(&squares, total.n_samples())
    };
    let mut found = vec![scored(Refit::Old, None, as_it_is(&compensated), None)];
    let mut calibrations = Vec::new();
    let program = concat!("LoopScope ", env!("CARGO_PKG_VERSION"));
    let names: Vec<String> = new
        .entries()
        .iter()
        .map(|entry| entry.recording.name().to_owned())
        .collect();
    for refit in [Refit::Offset, Refit::Transform] {
        let [before, after] =
            [&conventional, &compensated].map(|parts| change(parts, refit, n_axes));
        let folded: Result<Calibration, CannotFold> =
            old.with_output(&before.change, &after.change);
        let problem = folded.as_ref().err().map(ToString::to_string);
        if let Ok(mut own) = folded {
            let scores = |of: &Changed| Scores {
                train_rmse: of.train_rmse.clone(),
                test_rmse: None,
                cv_rmse: of.left_out_rmse.clone(),
            };
            own.quality.conventional = scores(&before);
            own.quality.compensated = scores(&after);
            own.quality.n_train = total(&compensated).n_samples();
            own.quality.n_test = 0;
            own.quality.cross_validation = Some(how.clone());
            own.program = program.to_owned();
            own.trained_on.extend(
                names
                    .iter()
                    .map(|name| format!("{name} ({})", refit.label().to_lowercase())),
            );
            calibrations.push((refit, Arc::new(own)));
        }
        found.push(scored(
            refit,
            after.train_rmse,
            after.left_out_rmse,
            problem,
        ));
    }
    if old.learned.is_some() {
        let trained = match training {
            None => Err(NOT_TRAINED.to_owned()),
            Some(on_step) => match train(&request, progress, on_step) {
                Err(AnalysisError::Cancelled(cancelled)) => return Err(cancelled.into()),
                trained => trained.map_err(|error| error.to_string()),
            },
        };
        // A network that is cancelled is the best so far, and unscored.
        progress.check()?;
        match trained {
            Err(problem) => found.push(scored(Refit::All, None, None, Some(problem))),
            Ok(own) => {
                let scores = own.quality.compensated.clone();
                found.push(scored(Refit::All, scores.train_rmse, scores.cv_rmse, None));
                calibrations.push((Refit::All, Arc::new(own)));
            }
        }
    } else {
        let mut own = data.blank_calibration(&settings)?;
        let past = data.past(&own, progress)?;
        data.fit(settings.ridge, &past, &mut own, progress)?;
        let scores = own.quality.compensated.clone();
        found.push(scored(Refit::All, scores.train_rmse, scores.cv_rmse, None));
        calibrations.push((Refit::All, Arc::new(own)));
    }
    Ok((found, calibrations, Some(how.to_string())))
}

fn total(parts: &[NormalEquations]) -> NormalEquations {
    let mut total = NormalEquations::new(parts[0].n_features(), parts[0].n_targets());
    parts.iter().for_each(|part| total.add(part));
    total
}

/// For the conventional and the compensated output of the old calibration: sums of `[load, 1 | true load − load]`, in the parts that
/// are left out in turn.
fn outputs(data: &Dataset, old: &Calibration) -> [Vec<NormalEquations>; 2] {
    let n_axes = old.axes.len();
    let pieces = data.pieces();
    let n_parts = pieces
        .iter()
        .flatten()
        .map(|piece| piece.fold + 1)
        .max()
        .unwrap_or(1);
    let mut sums = [(); 2].map(|()| vec![NormalEquations::new(n_axes + 1, n_axes); n_parts]);
    for (entry, pieces) in data.entries.iter().zip(&pieces) {
        let Ok(applied) = old.apply(&entry.recording) else {
            continue;
        };
        for (sums, outputs) in sums
            .iter_mut()
            .zip([&applied.conventional, &applied.compensated])
        {
            for piece in pieces {
                let sums = &mut sums[piece.fold];
                let stride = sums.stride();
                let mut row = vec![0.0; stride];
                for k in piece.samples.clone() {
                    let own = k * n_axes..(k + 1) * n_axes;
                    let (output, known) = (&outputs[own.clone()], &entry.recording.loads()[own]);
                    row[..n_axes].copy_from_slice(output);
                    row[n_axes] = 1.0;
                    for (at, (known, output)) in known.iter().zip(output).enumerate() {
                        row[n_axes + 1 + at] = known - output;
                    }
                    sums.add_rows(&row);
                }
            }
        }
    }
    sums
}

/// A change of an output, and how it does.
struct Changed {
    change: OutputChange,
    train_rmse: Option<Vec<f64>>,
    left_out_rmse: Option<Vec<f64>>,
}

fn change(parts: &[NormalEquations], refit: Refit, n_axes: usize) -> Changed {
    let mut kinds = vec![ColumnKind::Gauge; n_axes];
    kinds.push(ColumnKind::Offset);
    let used: Vec<usize> = match refit {
        Refit::Offset => vec![n_axes],
        _ => (0..=n_axes).collect(),
    };
    let terms = Terms {
        used: &used,
        kinds: &kinds,
        known: &[],
    };
    let total = total(parts);
    let added = fit(&total, terms, Ridge::None).coefficients;
    let parts: Vec<NormalEquations> = parts
        .iter()
        .filter(|part| part.n_samples() > 0)
        .cloned()
        .collect();
    let left_out = LeftOut {
        total: &total,
        parts: &parts,
        terms,
    };
    let none = vec![0.0; n_axes];
    let is_enough = parts.len() > 1;
    let row = |axis: usize| {
        (0..n_axes)
            .map(|of| added[of * n_axes + axis] + f64::from(u8::from(of == axis)))
            .collect()
    };
    Changed {
        change: OutputChange {
            matrix: (0..n_axes).map(row).collect(),
            offset: (0..n_axes)
                .map(|axis| added[n_axes * n_axes + axis])
                .collect(),
        },
        train_rmse: root_mean(&total.squared_residuals(&added), total.n_samples()),
        left_out_rmse: is_enough
            .then(|| left_out.rmse(&none, || left_out.squares(0.0)))
            .flatten(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::analyse;
    use crate::calibration::{KernelSettings, Regressor};
    use crate::features::FeatureSettings;
    use crate::random::Random;
    use crate::recording::Axis;

    /// When the first day begins.
    const BEGAN: f64 = 1.7e9;

    /// Three recordings of a day, with what was added to the first gauge, and what all gauges were multiplied with.
    fn day(set: &mut RecordingSet, day: u32, zero: f64, gain: [f64; 2]) {
        for run in 0..3_u32 {
            let mut random = Random::new(u64::from(day), &[u64::from(run)]);
            let loads: Vec<[f64; 2]> = (0..300)
                .map(|k| {
                    let t = f64::from(k) * (0.05 + 0.01 * f64::from(run));
                    [
                        10.0 * t.sin() + 0.1 * random.normal(),
                        8.0 * (1.7 * t).cos() + 0.1 * random.normal(),
                    ]
                })
                .collect();
            let gauges = loads.iter().flat_map(|[x, z]| {
                let (x, z) = (gain[0] * x, gain[1] * z);
                [5.0 + zero + 2.0 * x + 0.3 * z, 0.1 * x + z]
                    .map(|gauge| gauge + 0.02 * random.normal())
            });
            let start = BEGAN + 86_400.0 * f64::from(day) + 600.0 * f64::from(run);
            let recording = Recording::new(
                format!("run {day} {run}"),
                Source::Simulated,
                (0..300).map(|k| start + 0.1 * f64::from(k)).collect(),
                vec!["S1".to_owned(), "S2".to_owned()],
                gauges.collect(),
                vec![Axis::Fx, Axis::Fz],
                loads.as_flattened().to_vec(),
            );
            set.push(Entry::new(recording.unwrap(), Role::Train))
                .unwrap();
        }
    }

    fn linear() -> FitSettings {
        FitSettings {
            features: FeatureSettings::present(),
            ..FitSettings::default()
        }
    }

    fn of(set: &RecordingSet) -> Drifted {
        drift(set, None, &linear(), None, &Progress::default()).unwrap()
    }

    fn left_out(drifted: &Drifted, refit: Refit) -> &[f64] {
        let own = drifted
            .found
            .refits
            .iter()
            .find(|own| own.refit == refit)
            .unwrap();
        own.left_out_rmse.as_ref().unwrap()
    }

    #[test]
    fn a_zero_that_moved_needs_another_offset_and_a_gain_a_matrix() {
        let mut set = RecordingSet::default();
        day(&mut set, 7, 1.0, [1.0; 2]);
        day(&mut set, 0, 0.0, [1.0; 2]);
        let moved = of(&set);
        let names: Vec<&str> = moved.found.sessions.iter().map(|own| &*own.name).collect();
        assert_eq!(
            (moved.found.by, names),
            ("day", vec!["2023-11-14", "2023-11-21"]),
            "in order of time"
        );
        let s1 = &moved.found.changes[0];
        assert!(
            (s1.zero_share - 0.05).abs() < 5e-3 && s1.zero_is_sure && !s1.sensitivity_is_sure,
            "{s1:?}"
        );
        assert!(!moved.found.changes[1].zero_is_sure);
        assert!(
            moved
                .found
                .sentences
                .iter()
                .any(|own| own.starts_with("another offset is enough")),
            "{:?}",
            moved.found.sentences
        );
        assert!(left_out(&moved, Refit::Old)[0] > 10.0 * left_out(&moved, Refit::Offset)[0]);
        let mut set = RecordingSet::default();
        day(&mut set, 0, 0.0, [1.0; 2]);
        day(&mut set, 7, 0.0, [1.1, 0.95]);
        let gained = of(&set);
        assert!(
            gained
                .found
                .sentences
                .iter()
                .any(|own| own.starts_with("a matrix over the axes")),
            "{:?}",
            gained.found.sentences
        );
        assert!((gained.found.changes[0].sensitivity_share - 0.1).abs() < 5e-3);
    }

    #[test]
    fn what_was_learned_is_trained_again_where_that_is_asked() {
        let mut set = RecordingSet::default();
        day(&mut set, 0, 0.0, [1.0; 2]);
        day(&mut set, 3, 4.0, [1.1; 2]);
        let settings = FitSettings {
            regressor: Regressor::HybridKernel,
            kernel: KernelSettings {
                landmarks: 20,
                ..KernelSettings::default()
            },
            ..linear()
        };
        let progress = Progress::default();
        let first = Request::fit(Arc::new(set_of(set.entries()[..3].iter())), settings);
        let old = train(&first, &progress, &mut |_| {}).unwrap();
        let of = |training: Option<OnStep<'_>>| {
            let drifted = drift(&set, Some(&old), &linear(), training, &progress).unwrap();
            let all = drifted.found.refits.last().unwrap().clone();
            (drifted, all)
        };
        let (drifted, all) = of(None);
        assert!(all.left_out_rmse.is_none() && all.problem.unwrap().contains("Train again"));
        assert_eq!(drifted.calibrations.len(), 1, "no matrix of a kernel");
        let (drifted, all) = of(Some(&mut |_| {}));
        let (refit, own) = drifted.calibrations.last().unwrap();
        assert_eq!(
            (*refit, own.regressor),
            (Refit::All, Regressor::HybridKernel)
        );
        let errors = all.left_out_rmse.unwrap();
        let offset = left_out(&drifted, Refit::Offset);
        assert!(
            errors.iter().zip(offset).all(|(all, offset)| all < offset),
            "{errors:?} {offset:?}"
        );
    }

    #[test]
    fn a_day_that_somebody_entered_beats_the_clock() {
        let mut set = RecordingSet::default();
        day(&mut set, 0, 0.0, [1.0; 2]);
        day(&mut set, 3, 0.7, [1.0; 2]);
        (0..3).for_each(|at| set.set_day(at, "2024-05-03".parse().ok()));
        let found = of(&set).found;
        let told = found
            .sessions
            .iter()
            .map(|own| (&*own.name, own.dated_by[0]));
        let told: Vec<_> = told.collect();
        assert_eq!(
            told,
            [
                ("2023-11-17", DateSource::Clock),
                ("2024-05-03", DateSource::Entered)
            ]
        );
    }

    /// The slow way: for each recording that is left out an offset of the others, applied to it; and the refit to all of them.
    #[test]
    fn left_out_errors_are_those_of_explicit_refits() {
        let mut set = RecordingSet::default();
        day(&mut set, 0, 0.0, [1.0; 2]);
        day(&mut set, 3, 0.7, [1.03; 2]);
        let drifted = of(&set);
        let first = set_of(set.entries()[..3].iter());
        let old = fitted(first, &linear(), &Progress::default()).unwrap();
        let errors = |entry: &Entry, axis: usize| -> Vec<f64> {
            let loads = old.apply(&entry.recording).unwrap().compensated;
            let known = entry.recording.loads().iter().zip(loads);
            known
                .map(|(known, load)| known - load)
                .skip(axis)
                .step_by(2)
                .collect()
        };
        let new = &set.entries()[3..];
        for axis in 0..2 {
            let mut squares = 0.0;
            for at in 0..3 {
                let others = (0..3)
                    .filter(|other| *other != at)
                    .flat_map(|other| errors(&new[other], axis));
                let others: Vec<f64> = others.collect();
                let offset = others.iter().sum::<f64>() / others.len() as f64;
                squares += errors(&new[at], axis)
                    .iter()
                    .map(|error| (error - offset).powi(2))
                    .sum::<f64>();
            }
            let expected = (squares / 900.0).sqrt();
            assert!((left_out(&drifted, Refit::Offset)[axis] / expected - 1.0).abs() < 1e-9);
        }
        let request = Request::fit(Arc::new(set_of(new.iter())), linear());
        let refitted = analyse(&request, &Progress::default()).unwrap().calibration;
        assert_eq!(
            left_out(&drifted, Refit::All),
            refitted.quality.compensated.cv_rmse.as_ref().unwrap()
        );
        // What is exported does on the new recordings what is said of it.
        for (refit, calibration) in &drifted.calibrations {
            let mut squares = [0.0; 2];
            for entry in new {
                let loads = calibration.apply(&entry.recording).unwrap().compensated;
                for (at, (load, known)) in loads.iter().zip(entry.recording.loads()).enumerate() {
                    squares[at % 2] += (load - known).powi(2);
                }
            }
            let own = drifted
                .found
                .refits
                .iter()
                .find(|own| own.refit == *refit)
                .unwrap();
            for (square, rmse) in squares.iter().zip(own.train_rmse.as_ref().unwrap()) {
                assert!(
                    ((square / 900.0).sqrt() / rmse - 1.0).abs() < 1e-9,
                    "{refit:?}"
                );
            }
        }
        assert_eq!(drifted.calibrations.len(), 3);
    }

    #[test]
    fn one_session_is_told_so_and_loads_that_stand_still_compare_no_gauge() {
        let mut set = RecordingSet::default();
        day(&mut set, 0, 0.0, [1.0; 2]);
        let one = set_of(set.entries()[..1].iter());
        let alone = of(&one);
        assert!(alone.found.refits.is_empty() && alone.calibrations.is_empty());
        assert!(alone.found.sentences[0].starts_with("there is one session only"));
        let mut still = RecordingSet::default();
        for at in 0..2 {
            let recording = Recording::new(
                format!("r{at}"),
                Source::Simulated,
                vec![0.0, 1.0],
                vec!["S1".to_owned()],
                vec![1.0, 1.5],
                vec![Axis::Fz],
                vec![0.0; 2],
            );
            still
                .push(Entry::new(recording.unwrap(), Role::Train))
                .unwrap();
        }
        let still = of(&still);
        assert!(still.found.changes.is_empty());
        assert_eq!(
            still.found.sentences.len(),
            1,
            "{:?}",
            still.found.sentences
        );
        assert!(!serde_json::to_string(&still.found).unwrap().contains("NaN"));
        let groups = ["b", "a", "b"];
        let mut grouped = RecordingSet::default();
        for (entry, group) in set.entries().iter().zip(groups) {
            grouped
                .push(Entry {
                    group: Some(group.to_owned()),
                    ..entry.clone()
                })
                .unwrap();
        }
        let grouped = of(&grouped);
        assert_eq!(
            (grouped.found.by, grouped.found.sessions.len()),
            ("group", 2)
        );
    }
}
