//! Cross-validation folds of a model search. A fold holds out a group of recordings, or a segment of one long recording. The
//! models are fitted to the remaining training recordings.
//!
//! Guarantees: each training sample is held out once, and is then predicted from a cold start. Later segments of one long
//! recording are also predicted from the earlier segments alone, so that a drift increases the error.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::{
    calibration::CrossValidation,
    questions::error::AnalysisError,
    recording::{Entry, GroupedBy, RecordingSet, Role},
    scoring::cross_validation::{Fold, MOST_FITS, fit_without},
};

/// Number of segments of each recording, for recordings without at least two groups.
const SEGMENTS: usize = 4;

pub struct NestedFolds {
    pub folds: Vec<Fold>,
    /// All training recordings, cut into groups or segments as in the folds, and the test recordings.
    pub whole: Arc<RecordingSet>,
    /// Description of the cross-validation folds, for the headings of tables.
    pub what: String,
    /// Names of the groups or segments. The choice of a model compares the errors of each group or segment.
    pub parts: Vec<String>,
    /// Number of folds that together hold out each sample once. Further folds predict forward in time.
    pub n_left_out: usize,
}

struct Piece {
    fold: usize,
    part: usize,
    entry: Entry,
}

impl NestedFolds {
    /// Divides the training recordings into folds. Without training recordings, returns [`AnalysisError::NoTraining`].
    pub fn of(recordings: &RecordingSet) -> Result<Self, AnalysisError> {
        let groups = recordings.groups();
        let mut training: Vec<(Entry, usize)> = (recordings.entries().iter().enumerate())
            .filter(|(_, entry)| entry.role == Role::Train)
            .map(|(at, entry)| (groups.with_group_name(at, entry), groups.of[at]))
            .collect();
        let first = training.first().ok_or(AnalysisError::NoTraining)?;
        let run = first.0.recording.source().path();
        let is_one_run = run.is_some()
            && training.iter().all(|(entry, _)| entry.recording.source().path() == run);
        let group_numbers = |training: &[(Entry, usize)]| -> Vec<usize> {
            let numbers: BTreeSet<usize> = training.iter().map(|(_, group)| *group).collect();
            numbers.into_iter().collect()
        };
        let mut numbers = group_numbers(&training);
        if numbers.len() == 1 && is_one_run && are_even(&training) {
            training.iter_mut().enumerate().for_each(|(at, (_, group))| *group = at);
            numbers = group_numbers(&training);
        }
        let n_groups = numbers.len();
        let (pieces, parts, what): (Vec<Piece>, _, _) = if n_groups > 1 {
            let n_folds = n_groups.min(MOST_FITS);
            // If one file has several recordings, a single one (such as one press) is too short for a group. So consecutive
            // recordings are combined.
            let is_coarse = is_one_run && groups.by == GroupedBy::Recording;
            let pieces: Vec<Piece> = (training.into_iter())
                .map(|(entry, group)| {
                    let group = numbers.binary_search(&group).unwrap_or_default();
                    let fold = if is_one_run {
                        group * n_folds / n_groups
                    } else {
                        fit_without(group, n_groups)
                    };
                    Piece { fold, part: if is_coarse { fold } else { group }, entry }
                })
                .collect();
            let what = CrossValidation { by: groups.by, groups: n_groups, parts: n_folds };
            let name = |part: usize| {
                let mut names = pieces.iter().filter(|piece| piece.part == part).map(|piece| {
                    let group = piece.entry.group.as_deref();
                    group.unwrap_or(piece.entry.recording.name())
                });
                let first = names.next().unwrap_or_default();
                match names.next_back().filter(|last| *last != first) {
                    Some(last) => format!("{first} to {last}"),
                    None => first.to_owned(),
                }
            };
            let n_parts = if is_coarse { n_folds } else { n_groups };
            let parts = (0..n_parts).map(name).collect();
            (pieces, parts, what)
        } else {
            // The pieces of one run are cut where the whole run is cut into segments of equal length.
            let n_all: usize = training.iter().map(|(entry, _)| entry.recording.n_samples()).sum();
            let mut first = 0;
            let segments = |(entry, _): (Entry, usize)| {
                let n = entry.recording.n_samples();
                let (before, n_all) = if is_one_run { (first, n_all) } else { (0, n) };
                first += n;
                let at =
                    move |fold: usize| (fold * n_all / SEGMENTS).clamp(before, before + n) - before;
                let ranges = (0..SEGMENTS).map(move |fold| (fold, at(fold)..at(fold + 1)));
                ranges.filter(|(_, range)| !range.is_empty()).map(move |(fold, range)| {
                    let recording = Arc::new(entry.recording.segment(range));
                    Piece { fold, part: fold, entry: Entry { recording, ..entry.clone() } }
                })
            };
            let what = CrossValidation { by: GroupedBy::Block, groups: SEGMENTS, parts: SEGMENTS };
            let parts = (1..=SEGMENTS).map(|at| format!("segment {at}")).collect();
            (training.into_iter().flat_map(segments).collect(), parts, what)
        };
        // Only groups that follow one another in the same file can be predicted forward in time.
        let is_forward = n_groups == 1 || is_one_run && pieces.is_sorted_by_key(|piece| piece.fold);
        let n_left_out = pieces.iter().map(|piece| piece.fold + 1).max().unwrap_or(0);
        let fold =
            |left_out: usize, n_folds: usize| {
                let used = pieces.iter().filter(|piece| piece.fold < n_folds);
                Fold::of(used.map(|piece| {
                    (piece.entry.clone(), (piece.fold == left_out).then_some(piece.part))
                }))
            };
        let mut folds: Vec<Fold> = (0..n_left_out).map(|at| fold(at, n_left_out)).collect();
        if is_forward {
            // The last segment is already predicted from all earlier segments. Fewer than half of the segments are too few
            // for a fit.
            let later = n_left_out.div_ceil(2)..n_left_out.saturating_sub(1);
            folds.extend(later.map(|at| fold(at, at + 1)));
        }
        let training = pieces.iter().map(|piece| (piece.entry.clone(), None));
        let tested = recordings.entries().iter().filter(|entry| entry.role == Role::Test);
        let whole = Fold::of(training.chain(tested.map(|entry| (entry.clone(), Some(0))))).set;
        let what = if folds.len() > n_left_out {
            format!("nested, {what}; and with later segments predicted from earlier ones")
        } else {
            format!("nested, {what}")
        };
        Ok(Self { folds, whole, what, parts, n_left_out })
    }
}

/// Returns true if the pieces of one run can be combined to [`MOST_FITS`] parts of similar length.
fn are_even(training: &[(Entry, usize)]) -> bool {
    let mut n_samples = [0; MOST_FITS];
    for (at, (entry, _)) in training.iter().enumerate() {
        n_samples[at * MOST_FITS / training.len()] += entry.recording.n_samples();
    }
    let all: usize = n_samples.iter().sum();
    n_samples.iter().all(|n| 2 * MOST_FITS * n >= all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Axis, Recording, Source, simulated};

    fn of_lengths(n: usize) -> RecordingSet {
        let mut set = RecordingSet::default();
        for entry in simulated::recordings(1).entries().iter().take(n) {
            set.push(Entry::new(entry.recording.decimated(20), Role::Train)).unwrap();
        }
        let tested = simulated::recordings(1).entries()[89].recording.decimated(20);
        set.push(Entry::new(tested, Role::Test)).unwrap();
        set
    }

    #[test]
    fn folds_are_made_of_the_training_recordings() {
        for n in [1, 2, 3, 7] {
            let set = of_lengths(n);
            let found = NestedFolds::of(&set).unwrap();
            let all = set.n_samples(Role::Train);
            let folds = &found.folds[..found.n_left_out];
            let left_out: usize = folds.iter().map(|fold| fold.set.n_samples(Role::Test)).sum();
            assert_eq!(left_out, all, "{n} recordings");
            for fold in folds {
                let [tested, others] =
                    [Role::Test, Role::Train].map(|role| fold.set.n_samples(role));
                assert!(tested > 0 && tested + others == all, "{n} recordings");
                let tested = fold.set.entries().iter().filter(|entry| entry.role == Role::Test);
                assert_eq!(tested.count(), fold.parts.len());
            }
            assert_eq!(found.whole.n_samples(Role::Train), all);
        }
        assert!(matches!(
            NestedFolds::of(&RecordingSet::default()),
            Err(AnalysisError::NoTraining)
        ));
    }

    /// One recording in four segments: the third is also predicted from the first two.
    #[test]
    fn one_run_is_predicted_forward_in_time() {
        let found = NestedFolds::of(&of_lengths(1)).unwrap();
        assert_eq!((found.folds.len(), found.n_left_out), (5, 4));
        let forward = &found.folds[4];
        assert_eq!(forward.parts, [2]);
        let entries = forward.set.entries();
        let last = |role| {
            let last = entries.iter().rfind(|entry| entry.role == role).unwrap();
            last.recording.times().get(last.recording.n_samples() - 1).copied().unwrap()
        };
        assert!(last(Role::Train) < last(Role::Test));
        assert_eq!(NestedFolds::of(&of_lengths(3)).unwrap().folds.len(), 3);
    }

    /// Twelve presses in one file form five parts. Twelve presses in twelve files form twelve parts.
    #[test]
    fn presses_of_one_file_are_no_groups() {
        let all = simulated::recordings(1);
        let found = |file: &dyn Fn(usize) -> String, group: &dyn Fn(usize) -> Option<String>| {
            let mut set = RecordingSet::default();
            for at in 0..12 {
                let thinned = all.entries()[at].recording.decimated(20);
                let thinned = Recording::new(
                    format!("press #{}", at + 1),
                    Source::File(file(at).into()),
                    thinned.times().to_vec(),
                    thinned.gauge_names().to_vec(),
                    thinned.gauges().to_vec(),
                    thinned.axes().to_vec(),
                    thinned.loads().to_vec(),
                );
                let mut thinned = thinned.unwrap();
                thinned.group = group(at);
                set.push(Entry::new(thinned, Role::Train)).unwrap();
            }
            NestedFolds::of(&set).unwrap()
        };
        let one = |_| "/a.csv".to_owned();
        let of_one = found(&one, &|_| None).parts;
        assert_eq!((of_one.len(), &*of_one[0]), (5, "press #1 to press #3"));
        assert_eq!(found(&|at| format!("/{at}.csv"), &|_| None).parts.len(), 12);
        // A column names four groups, which follow one another or alternate. Only groups that follow one another are predicted
        // forward in time.
        let days = found(&one, &|at| Some(format!("day {}", at / 3)));
        assert_eq!(days.parts, ["day 0", "day 1", "day 2", "day 3"]);
        assert_eq!((days.n_left_out, days.folds.len()), (4, 5));
        let conditions = found(&one, &|at| Some(format!("condition {}", at % 4)));
        assert_eq!((conditions.n_left_out, conditions.folds.len()), (4, 4));
    }

    /// Pauses cut the file into twelve similar pieces, or late rows into a long and two short pieces.
    #[test]
    fn pieces_of_one_run_are_combined_or_cut_into_parts_of_similar_length() {
        let n = 240;
        let values = || (0..n).map(|k| k as f64).collect::<Vec<_>>();
        let source = Source::File("/a.csv".into());
        let (names, axes) = (vec!["S1".to_owned()], vec![Axis::Fz]);
        let whole = Recording::new("a", source, values(), names, values(), axes, values()).unwrap();
        let found = |ends: Vec<usize>| {
            let mut set = RecordingSet::default();
            let mut start = 0;
            for end in ends {
                let mut piece = whole.segment(start..end);
                piece.run = Some(0);
                set.push(Entry::new(piece, Role::Train)).unwrap();
                start = end;
            }
            let found = NestedFolds::of(&set).unwrap();
            let left_out = found.folds.iter().take(found.n_left_out);
            let sizes: Vec<usize> = left_out.map(|fold| fold.set.n_samples(Role::Test)).collect();
            assert_eq!(sizes.iter().sum::<usize>(), n);
            (found.parts.len(), sizes)
        };
        let (n_parts, sizes) = found((1..=12).map(|piece| piece * n / 12).collect());
        assert_eq!((n_parts, sizes), (5, vec![60, 40, 60, 40, 40]));
        let (n_parts, sizes) = found(vec![n - 10, n - 9, n]);
        assert_eq!((n_parts, sizes), (4, vec![60; 4]));
    }

    /// The recordings of a fold still have groups, so that thresholds are also chosen by leaving out groups.
    #[test]
    fn a_fold_is_a_whole_group_and_the_others_stay_groups() {
        let all = simulated::recordings(1);
        let mut set = RecordingSet::default();
        for at in [0, 1, 15, 16, 30, 31] {
            let recording = all.entries()[at].recording.decimated(20);
            set.push(Entry::new(recording, Role::Train)).unwrap();
        }
        let found = NestedFolds::of(&set).unwrap();
        assert_eq!(found.what, "nested, by path: leave-one-path-out, 3 groups");
        assert_eq!(found.parts, ["path 1", "path 2", "path 3"]);
        for (fold, path) in found.folds.iter().zip(["path 1", "path 2", "path 3"]) {
            for entry in fold.set.entries() {
                let is_own = entry.group.as_deref() == Some(path);
                assert_eq!(entry.role == Role::Test, is_own);
            }
            let groups = fold.set.groups();
            assert_eq!(groups.by, GroupedBy::Group);
        }
    }
}
