//! Groups of recordings with the same load programme, day or mounting of the sensor. Cross-validation leaves out a whole
//! group at a time.
//!
//! Guarantees: groups that the user set are always used. Groups that the program finds from names, folders, files and
//! repeated loads are used only if there are at least three groups, and each axis is loaded in several groups. Otherwise each
//! recording is its own group, and [`UnusedGroups`] gives the reason. Names with only a running number (`press_1` …
//! `press_690`) give no groups. The pieces that pauses or late rows cut from one run of a file are never separate groups.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;
use std::str::FromStr;

use jiff::civil::Date;
use serde::{Deserialize, Serialize};

use crate::{
    min_max::MinMax,
    recording::{
        axis::Axis,
        load_cases::load_cases,
        programme::{press_shapes, repeated_programmes},
        recording::Recording,
        set::{Entry, RecordingSet, Role},
        shared::join,
    },
};

/// Minimum number of groups for which groups that the program finds are used. With two, half of the recordings would be
/// missing in each fit of a cross-validation.
const FEWEST_FOUND: usize = 3;
/// Minimum share of its load range that each axis must keep when cross-validation leaves out a group. Below this share, the
/// fit without the group would be tested far outside the loads of its training data.
const KEPT_RANGE: f64 = 0.5;

/// Words in the names of recordings and folders that stand before the number or letter of a load programme, as in `path3`. If
/// a name contains several, the first in this list counts.
const PROGRAMMES: &str = "path trajectory programme program programm profile sequence pattern";
/// Words in the names of recordings and folders that stand before the number or letter of a day or a mounting, as in `day2`.
const SESSIONS: &str = "day tag session mounting mount montage setup batch";
/// Words in the names of recordings and folders that stand before the number of a repetition, as in `run4`.
const REPETITIONS: &str =
    "run rep repeat repetition take trial try attempt wiederholung wdh lauf versuch";
/// Years that a date in a name may have. A number outside this range is not read as a year.
const YEARS: std::ops::RangeInclusive<i16> = 1970..=2099;
const ROLES: [&str; 3] = ["train", "training", "test"];

/// Criterion by which recordings are grouped. The `Display` text is the noun for one group, such as `path`.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    strum::Display,
    strum::EnumString,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum GroupedBy {
    #[default]
    Recording,
    /// Samples without times that were taken under an equal load, in one file or in several.
    #[serde(rename = "load case")]
    #[strum(to_string = "load case")]
    LoadCase,
    Group,
    /// Contiguous block of samples, used if there are too few recordings to leave a whole recording out.
    Block,
    Path,
    Trajectory,
    #[strum(to_string = "programme", serialize = "programm")]
    Programme,
    Program,
    Profile,
    Sequence,
    Pattern,
    #[strum(to_string = "day", serialize = "tag")]
    Day,
    Session,
    #[strum(to_string = "mounting", serialize = "montage")]
    Mounting,
    Mount,
    Setup,
    Batch,
    /// Name of the recording without the number of the repetition.
    Series,
    Folder,
    File,
}

/// Group of each recording in a set, and the criterion that gave the groups.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Groups {
    /// Criterion by which the recordings are grouped.
    pub by: GroupedBy,
    /// Number of the group of each recording in the set.
    pub of: Vec<usize>,
    names: Vec<String>,
    /// Groups that the program found but does not use, with the reason.
    pub unused: Option<UnusedGroups>,
    /// Group that the user set although, without it, an axis keeps less than half of its load range.
    pub lone: Option<LoneGroup>,
}

/// Group without which an axis keeps less than half of its load range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoneGroup {
    pub group: String,
    pub axis: Axis,
}

#[derive(Clone, Debug, PartialEq)]
pub struct UnusedGroups {
    pub by: GroupedBy,
    /// Number of groups among the training recordings.
    pub n: usize,
    /// Group without which an axis is hardly loaded, as the reason for not using the groups. `None` if the reason is that
    /// there are too few groups.
    pub lone: Option<LoneGroup>,
}

impl Groups {
    /// Returns the name of a recording's group, or `None` if each recording is its own group.
    pub fn name_of(&self, recording: usize) -> Option<&str> {
        let group = *self.of.get(recording)?;
        (self.by != GroupedBy::Recording).then(|| &*self.names[group])
    }

    /// Returns the entry as if the user had set its present group. A subset of such entries keeps these groups.
    pub fn with_group_name(&self, recording: usize, entry: &Entry) -> Entry {
        Entry { group: self.name_of(recording).map(str::to_owned), ..entry.clone() }
    }
}

/// Pattern from which the group name of each recording is made. `{file}`, `{folder}` and `{recording}` stand for the names of
/// the file, the folder and the recording. Any other `{word}` stands for the number or letter that follows this word in one
/// of these names.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct GroupPattern(String);

impl FromStr for GroupPattern {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let pattern = Self(text.trim().to_owned());
        let mut pieces = pattern.0.split('{');
        let is_plain = |piece: &str| !piece.contains('}');
        let is_word = |word: &str| !word.is_empty() && word.chars().all(char::is_alphabetic);
        let are_whole = pieces.next().is_some_and(is_plain)
            && pieces.all(|piece| {
                let ends = piece.split_once('}');
                ends.is_some_and(|(word, rest)| is_word(word) && is_plain(rest))
            });
        if are_whole && !pattern.0.is_empty() {
            Ok(pattern)
        } else {
            Err(format!(
                "the group pattern {text:?} is not valid; enter a name, which may contain {{file}}, {{folder}}, {{recording}} or, in braces, a word that stands before a number in the file names, such as {{mount}}"
            ))
        }
    }
}

impl TryFrom<String> for GroupPattern {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<GroupPattern> for String {
    fn from(pattern: GroupPattern) -> Self {
        pattern.0
    }
}

impl GroupPattern {
    /// Returns the group name of a recording, or `None` if a word of the pattern is not in the recording's name.
    pub fn group_of(&self, recording: &Recording) -> Option<String> {
        let path = recording.source().path();
        let mut pieces = self.0.split('{');
        let mut group = pieces.next().unwrap_or_default().to_owned();
        for piece in pieces {
            let (word, rest) = piece.split_once('}')?;
            group.push_str(&match word {
                "file" => last_name(path?)?,
                "folder" => last_name(path?.parent()?)?,
                "recording" => recording.name().to_owned(),
                word => after(&words_of(recording), &word.to_lowercase())?.to_owned(),
            });
            group.push_str(rest);
        }
        Some(group)
    }
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    Named(String),
    /// Group of the single recording with this index in the set.
    Own(usize),
}

/// A possible criterion of grouping, and the name of the group that it gives to each recording.
struct Way {
    by: GroupedBy,
    keys: Vec<Option<String>>,
    /// True if the user is told when this criterion puts all recordings in one group. All of them then repeat one load
    /// programme.
    reports_single_group: bool,
}

impl RecordingSet {
    /// Returns the group of each recording.
    pub fn groups(&self) -> Groups {
        let entries = self.entries();
        let training: Vec<usize> =
            (0..entries.len()).filter(|&at| entries[at].role == Role::Train).collect();
        let firsts = first_pieces(entries);
        let keyed = |found: Option<&Way>| -> Vec<Key> {
            let key = |(at, entry): (usize, &Entry)| {
                let found = || found.and_then(|way| way.keys[at].clone());
                let named = entry.group.clone().or_else(found);
                named.map_or(Key::Own(firsts[at]), Key::Named)
            };
            entries.iter().enumerate().map(key).collect()
        };
        let distinct = |keys: &[Key]| {
            let keys = training.iter().map(|&at| &keys[at]);
            keys.collect::<BTreeSet<_>>().len()
        };
        let lone = |keys: &[Key]| lone_group(entries, &training, keys);
        let is_set = training.iter().any(|&at| entries[at].group.is_some());
        if !is_set
            && !training.is_empty()
            && training.iter().all(|&at| entries[at].recording.is_load_case())
        {
            let keys = load_case_keys(entries);
            let lone = lone(&keys);
            return groups_from_keys(GroupedBy::LoadCase, keys, lone);
        }
        let n = training.len();
        let mut unused = None;
        for way in self.ways(&training) {
            let keys = keyed(Some(&way));
            let n_groups = distinct(&keys);
            if n_groups >= n || n_groups == 1 && !way.reports_single_group {
                continue;
            }
            let lone = lone(&keys);
            let are_many = n_groups >= FEWEST_FOUND;
            if is_set && n_groups > 1 {
                return groups_from_keys(GroupedBy::Group, keys, lone);
            }
            if are_many && lone.is_none() {
                return groups_from_keys(way.by, keys, None);
            }
            // Names with a running number, folders and files do not show that recordings repeat the same loads.
            if are_many
                || !matches!(way.by, GroupedBy::Series | GroupedBy::Folder | GroupedBy::File)
            {
                let lone = lone.filter(|_| are_many);
                unused.get_or_insert(UnusedGroups { by: way.by, n: n_groups, lone });
            }
        }
        let keys = keyed(None);
        let n_groups = distinct(&keys);
        if is_set && n_groups < n {
            if n_groups > 1 && n > 2 {
                let lone = lone(&keys);
                return groups_from_keys(GroupedBy::Group, keys, lone);
            }
            unused = Some(UnusedGroups { by: GroupedBy::Group, n: n_groups, lone: None });
        }
        let keys = firsts.into_iter().map(Key::Own).collect();
        Groups { unused, ..groups_from_keys(GroupedBy::Recording, keys, None) }
    }

    /// Returns the possible criteria of grouping, the most likely first. Each gives a group to every training recording
    /// without a group set by the user.
    fn ways(&self, training: &[usize]) -> Vec<Way> {
        let entries = self.entries();
        let open: Vec<usize> =
            training.iter().copied().filter(|&at| entries[at].group.is_none()).collect();
        if open.is_empty() {
            return Vec::new();
        }
        let words: Vec<Vec<String>> =
            entries.iter().map(|entry| words_of(&entry.recording)).collect();
        let by_words = |by, reports_single_group, key: &dyn Fn(&[String]) -> Option<String>| Way {
            by,
            keys: words.iter().map(|words| key(words)).collect(),
            reports_single_group,
        };
        let labelled = |word: &str| {
            let by: GroupedBy = word.parse().ok()?;
            Some(by_words(by, true, &|words| Some(format!("{by} {}", after(words, word)?))))
        };
        let mut ways: Vec<Way> = PROGRAMMES.split(' ').filter_map(labelled).collect();
        if open.iter().any(|&at| repetition(&words[at]).is_some()) {
            ways.push(by_words(GroupedBy::Series, false, &|words| {
                let rest = match repetition(words) {
                    Some(at) => [&words[..at], &words[at + 2..]].concat(),
                    None => words.to_vec(),
                };
                (!rest.is_empty()).then(|| rest.join(" "))
            }));
        }
        ways.extend(SESSIONS.split(' ').filter_map(labelled));
        ways.push(by_words(GroupedBy::Day, false, &day));
        if counts_repetitions(&open, &words) {
            ways.push(by_words(GroupedBy::Series, false, &|words| {
                without_last_number(words).map(|(rest, _)| rest.join(" "))
            }));
        }
        ways.push(by_path(GroupedBy::Folder, entries, Path::parent));
        ways.push(by_path(GroupedBy::File, entries, |path| Some(path)));
        ways.extend(by_loads(entries, &open));
        ways.retain(|way| open.iter().all(|&at| way.keys[at].is_some()));
        ways
    }
}

/// Returns the load case of each recording without times, as its group. A load case has the name of its first recording.
fn load_case_keys(entries: &[Entry]) -> Vec<Key> {
    let is_one = |entry: &Entry| entry.recording.is_load_case() && entry.recording.has_reference();
    let axes = entries.iter().find(|entry| is_one(entry));
    let axes = axes.map_or(&[][..], |entry| entry.recording.axes());
    let loads = entries.iter().filter(|entry| is_one(entry));
    let loads: Vec<f64> =
        loads.flat_map(|entry| &entry.recording.loads()[..axes.len()]).copied().collect();
    let mut cases = load_cases(&loads, axes).into_iter();
    let mut names: Vec<&str> = Vec::new();
    let key = |(at, entry): (usize, &Entry)| match is_one(entry).then(|| cases.next()) {
        Some(Some(case)) => {
            if case == names.len() {
                names.push(entries[at].recording.name());
            }
            Key::Named(names[case].to_owned())
        }
        _ => Key::Own(at),
    };
    entries.iter().enumerate().map(key).collect()
}

/// Returns, for each recording, the index of the first recording with the same role that was cut from the same run: by a
/// pause, by late rows, or where faulty samples were left out. For an uncut recording, this is its own index.
pub(crate) fn first_pieces(entries: &[Entry]) -> Vec<usize> {
    let mut firsts = HashMap::new();
    let mut first = |at: usize| {
        let Entry { recording, role, .. } = &entries[at];
        let left_out = recording.left_out().map(|left_out| &*left_out.of);
        let run = recording.run.map(Ok).or(left_out.map(Err));
        let of_role = (*role == Role::Train, recording.source());
        run.map_or(at, |run| *firsts.entry((of_role, run)).or_insert(at))
    };
    (0..entries.len()).map(&mut first).collect()
}

/// Returns the groups that these keys give: recordings with equal keys are one group. Groups are numbered in the order in
/// which they first occur.
fn groups_from_keys(by: GroupedBy, keys: Vec<Key>, lone: Option<LoneGroup>) -> Groups {
    let mut numbers: BTreeMap<Key, usize> = BTreeMap::new();
    let mut names = Vec::new();
    let mut of = Vec::with_capacity(keys.len());
    for key in keys {
        let next = numbers.len();
        let number = *numbers.entry(key.clone()).or_insert(next);
        if number == next {
            names.push(match key {
                Key::Named(name) => name,
                Key::Own(at) => format!("{}", at + 1),
            });
        }
        of.push(number);
    }
    Groups { by, of, names, unused: None, lone }
}

/// Returns the first group without which an axis keeps less than the share [`KEPT_RANGE`] of its load range.
fn lone_group(entries: &[Entry], training: &[usize], keys: &[Key]) -> Option<LoneGroup> {
    let axes = entries[*training.first()?].recording.axes();
    let mut ranges: BTreeMap<&Key, Vec<MinMax>> = BTreeMap::new();
    for &at in training {
        let ranges = ranges.entry(&keys[at]);
        let ranges = ranges.or_insert_with(|| vec![MinMax::NONE; axes.len()]);
        join(ranges, entries[at].recording.load_ranges());
    }
    let span = |axis: usize, left_out: Option<&Key>| {
        let kept = ranges.iter().filter(|(key, _)| Some(**key) != left_out);
        kept.map(|(_, ranges)| ranges[axis]).collect::<MinMax>().span()
    };
    (0..axes.len()).find_map(|axis| {
        let whole = span(axis, None);
        let mut named = ranges.keys().filter_map(|key| match key {
            Key::Named(name) => Some((*key, name)),
            Key::Own(_) => None,
        });
        let (_, group) = named.find(|(key, _)| span(axis, Some(*key)) < KEPT_RANGE * whole)?;
        Some(LoneGroup { group: group.clone(), axis: axes[axis] })
    })
}

/// Returns the words and numbers in the names of a recording and its folder, in lower case. The words for a role (such as
/// `train`) and the numbers of the segments of a file are left out.
fn words_of(recording: &Recording) -> Vec<String> {
    let name = recording.name();
    let name = name.split(" (").next().unwrap_or(name);
    let name = match name.rsplit_once(" #") {
        Some((stem, part)) if part.bytes().all(|b| b.is_ascii_digit()) => stem,
        _ => name,
    };
    let folder = recording.source().path().and_then(Path::parent);
    let folder = folder.and_then(last_name).unwrap_or_default();
    let mut words = [words_in(&folder), words_in(name)].concat();
    words.retain(|word| !ROLES.contains(&&**word));
    words
}

/// Returns the runs of digits and the runs of letters in a text, in lower case. A capital letter after a small letter starts a
/// new word, as in `pathA`.
fn words_in(text: &str) -> Vec<String> {
    let kind = |c: char| (c.is_ascii_digit(), c.is_alphabetic());
    let mut words: Vec<String> = Vec::new();
    let mut before = None;
    for letter in text.chars() {
        let continues = |last: char| {
            kind(last) == kind(letter) && !(last.is_lowercase() && letter.is_uppercase())
        };
        if letter.is_alphanumeric() {
            if !before.is_some_and(continues) {
                words.push(String::new());
            }
            words.last_mut().expect("pushed above").extend(letter.to_lowercase());
        }
        before = Some(letter).filter(|letter| letter.is_alphanumeric());
    }
    words
}

fn is_number(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_digit())
}

/// Returns true if the word can be the number or letter that belongs to the word before it, as in `path 3`.
fn is_label(word: &str) -> bool {
    is_number(word) || word.chars().count() == 1
}

fn last_name(path: &Path) -> Option<String> {
    Some(path.file_name()?.to_string_lossy().into_owned())
}

/// Returns the number without leading zeros, so that 1 and 01 are equal.
fn plain(number: &str) -> &str {
    let digits = number.trim_start_matches('0');
    if digits.is_empty() && is_number(number) { "0" } else { digits }
}

/// Returns the number or letter that follows the first occurrence of `word`, such as `3` in `path3`.
fn after<'a>(words: &'a [String], word: &str) -> Option<&'a str> {
    let pairs = words.windows(2);
    let mut named = pairs.filter(|pair| pair[0] == word && is_label(&pair[1]));
    named.next().map(|pair| plain(&pair[1]))
}

/// Returns the index of the last word for a repetition, such as `run`, that is followed by a number or letter.
fn repetition(words: &[String]) -> Option<usize> {
    let mut pairs = words.windows(2);
    pairs.rposition(|pair| REPETITIONS.split(' ').any(|word| word == pair[0]) && is_label(&pair[1]))
}

/// Returns the first date in the words that has the form 2024-05-01 or 20240501.
fn day(words: &[String]) -> Option<String> {
    let date = |year: &str, month: &str, day: &str| {
        let (year, month, day) = (year.parse().ok()?, month.parse().ok()?, day.parse().ok()?);
        let date = Date::new(year, month, day).ok()?;
        YEARS.contains(&year).then(|| date.to_string())
    };
    let written_together = words.iter().find_map(|word| {
        let (year, month, day) = (word.get(..4)?, word.get(4..6)?, word.get(6..8)?);
        (word.len() == 8).then(|| date(year, month, day)).flatten()
    });
    let mut threes = words.windows(3);
    written_together.or_else(|| threes.find_map(|words| date(&words[0], &words[1], &words[2])))
}

fn without_last_number(words: &[String]) -> Option<(Vec<String>, u64)> {
    let at = words.iter().rposition(|word| is_number(word))?;
    let number = words[at].parse().ok()?;
    Some(([&words[..at], &words[at + 1..]].concat(), number))
}

/// Returns true if the last number in these recordings' names counts repetitions, while the other numbers name at least three
/// series.
fn counts_repetitions(open: &[usize], words: &[Vec<String>]) -> bool {
    let (mut series, mut counted) = (BTreeSet::new(), BTreeSet::new());
    for &at in open {
        let Some((rest, number)) = without_last_number(&words[at]) else {
            return false;
        };
        let numbers = rest.into_iter().filter(|word| is_number(word));
        series.insert(numbers.collect::<Vec<_>>());
        counted.insert(number);
    }
    let (Some(&first), Some(&last)) = (counted.first(), counted.last()) else {
        return false;
    };
    let is_count = first <= 1 && last - first + 1 == counted.len() as u64;
    is_count && series.len() >= FEWEST_FOUND && 2 * series.len() <= open.len()
}

/// Groups recordings that repeat the same course of the load, or short presses of the same shape. The group has the name of its
/// first recording. Returns `None` if the training recordings run each load programme less than twice on average.
fn by_loads(entries: &[Entry], training: &[usize]) -> Option<Way> {
    let recordings: Vec<&Recording> = entries.iter().map(|entry| &*entry.recording).collect();
    let are_repeated = |programmes: &Vec<usize>| {
        let trained: BTreeSet<usize> = training.iter().map(|at| programmes[*at]).collect();
        2 * trained.len() <= training.len()
    };
    let programmes = Some(repeated_programmes(&recordings)).filter(are_repeated);
    let programmes = programmes.or_else(|| press_shapes(&recordings).filter(are_repeated))?;
    let name = |first: usize| Some(format!("loads of {}", recordings[first].name()));
    let keys = programmes.into_iter().map(name).collect();
    Some(Way { by: GroupedBy::Programme, keys, reports_single_group: false })
}

fn by_path(by: GroupedBy, entries: &[Entry], part: fn(&Path) -> Option<&Path>) -> Way {
    let parts: Vec<Option<&Path>> =
        entries.iter().map(|entry| entry.recording.source().path().and_then(part)).collect();
    let last = |path: &Path| last_name(path).unwrap_or_default();
    let mut called: HashMap<String, BTreeSet<&Path>> = HashMap::new();
    for path in parts.iter().flatten() {
        called.entry(last(path)).or_default().insert(path);
    }
    let name = |path: &Path| match called[&last(path)].len() {
        1 => last(path),
        _ => path.display().to_string(),
    };
    Way { by, keys: parts.iter().map(|part| part.map(name)).collect(), reports_single_group: false }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::left_out::{Judged, LeftOut};
    use crate::recording::recording::{Recording, Source};

    /// Returns training recordings with these files and names, loaded from 0 to 1.
    fn set_of(names: &[(&str, &str)]) -> RecordingSet {
        with_loads(names, |_| vec![0.0, 1.0])
    }

    fn with_loads(names: &[(&str, &str)], loads: impl Fn(usize) -> Vec<f64>) -> RecordingSet {
        let mut set = RecordingSet::default();
        for (at, (file, name)) in names.iter().enumerate() {
            let recording = Recording::new(
                *name,
                Source::File(file.into()),
                vec![0.0, 1.0],
                vec!["S1".to_owned()],
                vec![0.0; 2],
                vec![Axis::Fz],
                loads(at),
            );
            set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
        }
        set
    }

    /// Returns the criterion and the group numbers found for files with these names.
    fn found(names: &[&str]) -> (GroupedBy, Vec<usize>) {
        let files: Vec<String> = names.iter().map(|name| format!("/d/{name}.csv")).collect();
        let names: Vec<(&str, &str)> =
            files.iter().map(|file| &**file).zip(names.iter().copied()).collect();
        let groups = set_of(&names).groups();
        (groups.by, groups.of)
    }

    #[test]
    fn names_with_a_programme_or_repetition_number_are_grouped() {
        for (names, by, of) in [
            (
                &["path1_run1", "path1_run2", "path2_run1", "path3_run1"][..],
                GroupedBy::Path,
                [0, 0, 1, 2],
            ),
            (
                &["train_path01_a", "train_path2", "path_1 fast", "pathB"],
                GroupedBy::Path,
                [0, 1, 0, 2],
            ),
            (&["a run 1", "b run 1", "a run 2", "c take 3"], GroupedBy::Series, [0, 1, 0, 2]),
            (&["Mount1 x", "Mount2 x", "Mount3 x", "Mount3 y"], GroupedBy::Mount, [0, 1, 2, 2]),
            (
                &["20240501_1", "2024-05-02 a", "20240503", "20240501_b"],
                GroupedBy::Day,
                [0, 1, 2, 0],
            ),
        ] {
            assert_eq!(found(names), (by, of.to_vec()), "{names:?}");
        }
        let levels = ["f_100_1", "f_100_2", "f_200_1", "f_200_2", "f_300_1", "f_300_2"];
        assert_eq!(found(&levels), (GroupedBy::Series, vec![0, 0, 1, 1, 2, 2]));
    }

    #[test]
    fn with_running_numbers_or_too_few_groups_each_recording_is_its_own_group() {
        let presses: Vec<String> = (1..=690).map(|k| format!("press_{k}")).collect();
        let presses: Vec<&str> = presses.iter().map(|name| &**name).collect();
        assert_eq!(found(&presses), (GroupedBy::Recording, (0..690).collect()));
        for names in [
            &["run1", "run2", "run3", "run4"][..],
            &["path1", "path2", "path3", "path4"],
            &["x10_y10", "x10_y20", "x20_y10", "x20_y20"],
            &["up", "down", "left", "right"],
            &["fx_1", "fx_2", "fy_1", "fz_1"],
            &["path1_a", "path1_b", "path2_a", "path2_b"],
            &["log 2024-05-01 10-00", "log 2024-05-01 11-00", "log 2024-05-01 11-30", "log"],
        ] {
            assert_eq!(found(names).0, GroupedBy::Recording, "{names:?}");
        }
    }

    #[test]
    fn groups_found_but_not_used_are_reported() {
        let unused = |names: &[(&str, &str)]| set_of(names).groups().unused;
        let few = [("/a", "path1 a"), ("/a", "path1 b"), ("/a", "path2 a"), ("/a", "path2 b")];
        let not_used = |n, lone| UnusedGroups { by: GroupedBy::Path, n, lone };
        assert_eq!(unused(&few), Some(not_used(2, None)));
        assert_eq!(unused(&few[..2]), Some(not_used(1, None)));
        assert_eq!(unused(&[("/a", "a"), ("/b", "b"), ("/c", "c")]), None);
        let runs = [("/a/1", "run1"), ("/a/2", "run2"), ("/b/3", "run3"), ("/b/4", "other")];
        assert_eq!(unused(&runs), None, "names and folders do not tell what was loaded");
        let names = [("/a", "path1 a"), ("/a", "path1 b"), ("/a", "path2"), ("/a", "path3")];
        let set = with_loads(&names, |at| vec![0.0, if at == 2 { 9.0 } else { 1.0 }]);
        let lone = LoneGroup { group: "path 2".to_owned(), axis: Axis::Fz };
        let groups = set.groups();
        assert_eq!(
            (groups.by, groups.unused),
            (GroupedBy::Recording, Some(not_used(3, Some(lone))))
        );
    }

    #[test]
    fn folders_and_files_are_groups_where_names_give_none() {
        let groups = |names: &[(&str, &str)]| {
            let groups = set_of(names).groups();
            let name = groups.name_of(0).map(str::to_owned);
            (groups.by, groups.of, name)
        };
        let folders =
            [("/mon/a.csv", "a"), ("/mon/b.csv", "b"), ("/tue/a.csv", "a"), ("/wed/a.csv", "a")];
        assert_eq!(groups(&folders), (GroupedBy::Folder, vec![0, 0, 1, 2], Some("mon".to_owned())));
        let parts = [("/a.csv", "a #1"), ("/a.csv", "a #2"), ("/b.csv", "b"), ("/c.csv", "c")];
        assert_eq!(groups(&parts), (GroupedBy::File, vec![0, 0, 1, 2], Some("a.csv".to_owned())));
        let one_file = [("/a.csv", "a #1"), ("/a.csv", "a #2"), ("/a.csv", "a #3")];
        assert_eq!(groups(&one_file), (GroupedBy::Recording, vec![0, 1, 2], None));
    }

    /// Recordings of presses at five heights and shapes, with different speeds and noise; then presses of random heights.
    #[test]
    fn recordings_of_equal_loads_are_one_group_with_any_names() {
        let groups = |height: &dyn Fn(usize) -> f64| {
            let mut set = RecordingSet::default();
            for at in 0..40 {
                let n = 30 + 7 * (at % 4);
                let load = |k: usize| {
                    let share = k as f64 / (n - 1) as f64;
                    height(at) * (std::f64::consts::PI * share).sin() + 0.02 * (1e3 * share).sin()
                };
                let recording = Recording::new(
                    format!("press_{at}"),
                    Source::File("/a.csv".into()),
                    (0..n).map(|k| 0.05 * k as f64).collect(),
                    vec!["S1".to_owned()],
                    vec![0.0; n],
                    vec![Axis::Fz],
                    (0..n).map(load).collect(),
                );
                set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
            }
            set.groups()
        };
        let found = groups(&|at| [1.0, 1.5, 2.0, 2.0, 2.5][at % 5]);
        assert_eq!((found.by, &found.of[..6]), (GroupedBy::Programme, &[0, 1, 2, 2, 3, 0][..]));
        let found = groups(&|at| 1.0 + 0.2 * at as f64);
        assert_eq!(found.by, GroupedBy::Recording);
    }

    #[test]
    fn groups_set_by_the_user_are_kept_and_only_training_recordings_count() {
        let names = [("/a", "path1 a"), ("/a", "path1 b"), ("/a", "path2 a"), ("/a", "path3 b")];
        let mut set = set_of(&names);
        assert_eq!(set.groups().of, [0, 0, 1, 2]);
        set.set_group(3, Some("path 2".to_owned()));
        assert_eq!((set.groups().by, set.groups().of), (GroupedBy::Group, vec![0, 0, 1, 1]));
        (0..4).for_each(|at| set.set_group(at, Some(format!("{at}"))));
        let alone = set.groups();
        assert_eq!((alone.by, alone.of), (GroupedBy::Recording, vec![0, 1, 2, 3]));
        assert_eq!(alone.unused, None);
        (0..4).for_each(|at| set.set_group(at, Some("all".to_owned())));
        let groups = set.groups();
        assert_eq!((groups.by, groups.of), (GroupedBy::Recording, vec![0, 1, 2, 3]));
        assert_eq!(groups.unused.unwrap().n, 1);
        let mut set = set_of(&names);
        set.set_role(2, Role::Test);
        assert_eq!(set.groups().by, GroupedBy::Recording, "two paths are too few");
        assert!(RecordingSet::default().groups().of.is_empty());
    }

    #[test]
    fn a_pattern_names_groups_by_file_folder_or_a_word_of_the_names() {
        let set = set_of(&[("/mon/Mount02_up.csv", "Mount02_up #3")]);
        let recording = &set.entries()[0].recording;
        for (text, group) in [
            ("all", Some("all")),
            ("{folder}", Some("mon")),
            ("{file}", Some("Mount02_up.csv")),
            ("{recording}", Some("Mount02_up #3")),
            ("on {mount}, {folder}", Some("on 2, mon")),
            ("{path}", None),
        ] {
            let pattern: GroupPattern = text.parse().unwrap();
            assert_eq!(pattern.group_of(recording).as_deref(), group, "{text}");
        }
        for text in ["", " ", "{", "a}", "{mount", "{}", "{a{b}}", "{a b}"] {
            assert!(text.parse::<GroupPattern>().is_err(), "{text}");
        }
    }

    #[test]
    fn remaining_parts_of_one_recording_are_one_group() {
        let set = set_of(&[("/d/x.csv", "a"), ("/d/x.csv", "b"), ("/d/x.csv", "c")]);
        let mut parts = RecordingSet::default();
        for (at, entry) in set.entries().iter().enumerate() {
            let left_out = LeftOut {
                of: entry.recording.name().to_owned(),
                judged: Judged::default(),
                n_samples: 1,
                unclipped: Vec::new(),
            };
            let nothing = 1..1;
            let cut = std::slice::from_ref(&nothing);
            let cut = if at == 1 { &[] } else { cut };
            for part in entry.recording.without(cut, &left_out) {
                parts.push(Entry::new(part.clone(), Role::Train)).unwrap();
                parts.push(Entry::new(part, Role::Train)).unwrap();
            }
        }
        let groups = parts.groups();
        assert_eq!((groups.by, groups.of), (GroupedBy::Recording, vec![0, 0, 1, 1, 2, 2]));
    }

    #[test]
    fn pieces_of_one_run_are_one_group_but_two_runs_of_a_file_are_two() {
        let set =
            set_of(&[("/a.csv", "a #1"), ("/a.csv", "a #2"), ("/a.csv", "a #3"), ("/b.csv", "b")]);
        let of_runs = |runs: [Option<usize>; 4]| {
            let mut cut = RecordingSet::default();
            for (entry, run) in set.entries().iter().zip(runs) {
                let mut recording = Recording::clone(&entry.recording);
                recording.run = run;
                cut.push(Entry::new(recording, Role::Train)).unwrap();
            }
            let groups = cut.groups();
            (groups.by, groups.of)
        };
        let by = GroupedBy::Recording;
        assert_eq!(of_runs([Some(0), Some(0), Some(0), None]), (by, vec![0, 0, 0, 1]));
        assert_eq!(of_runs([Some(0), Some(0), Some(1), Some(0)]), (by, vec![0, 0, 1, 2]));
    }

    #[test]
    fn the_built_in_recordings_are_grouped_by_path() {
        let groups = crate::recording::simulated::recordings(7).groups();
        assert_eq!((groups.by, groups.name_of(89)), (GroupedBy::Path, Some("path 6")));
        let fifteen_each: Vec<usize> = (0..90).map(|at| at / 15).collect();
        assert_eq!(groups.of, fifteen_each);
    }
}
