//! Names that are paths: fields of a message as ROS tools write them (`/ft/wrench/force/x`, `field.wrench.force.x`,
//! `/gauges/data[0]`), and fields of a struct (`run.S1`). An ambiguous path is neither a gauge nor a load.

use super::kind::{Kind, plain, plain_kind};
use super::words;

/// Words in the path of a quantity that describes a load, such as its deviation or its setpoint, but is not one.
const NO_LOADS: [&str; 16] = [
    "std",
    "stddev",
    "bias",
    "offset",
    "offsets",
    "error",
    "err",
    "residual",
    "covariance",
    "cov",
    "command",
    "cmd",
    "desired",
    "setpoint",
    "target",
    "goal",
];
/// Words in the path of a load.
const LOADS: [&str; 16] = [
    "force",
    "forces",
    "wrench",
    "wrenches",
    "torque",
    "torques",
    "moment",
    "moments",
    "ft",
    "load",
    "loads",
    "ati",
    "ref",
    "reference",
    "effort",
    "weight",
];
/// Words that occur only in the path of a gauge.
const GAUGES: [&str; 12] = [
    "gauge",
    "gauges",
    "gage",
    "gages",
    "strain",
    "strains",
    "sg",
    "stg",
    "dms",
    "straingauge",
    "straingauges",
    "coinft",
];
/// Words that occur in the paths of gauges and of other signals. A path that also has a word for a load is no gauge.
const CHANNELS: [&str; 8] = ["raw", "adc", "channel", "channels", "ch", "ai", "volts", "voltages"];
/// Parts of a path without meaning.
const NEUTRAL: [&str; 4] = ["data", "value", "values", "field"];
const SECONDS: [&str; 2] = ["sec", "secs"];
const NANOSECONDS: [&str; 4] = ["nanosec", "nanosecs", "nsec", "nsecs"];

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Path {
    pub kind: Kind,
    /// Parts before the one that gives the kind, in lower case.
    pub source: String,
    pub unit: Option<&'static str>,
}

/// Returns the stamp that a name is the nanoseconds (`is_rest`) or whole seconds of; empty if the name is only this part.
pub(super) fn stamp_of_part(name: &str, is_rest: bool) -> Option<&str> {
    let name = name.trim();
    let (stamp, last) = name.rsplit_once(['/', '.', '_']).unwrap_or(("", name));
    let words: &[&str] = if is_rest { &NANOSECONDS } else { &SECONDS };
    words.contains(&last.to_lowercase().as_str()).then_some(stamp)
}

/// Parses a path; `None` if the name is not a path or has no kind.
pub(super) fn understood(name: &str) -> Option<Path> {
    let (stem, is_element) = without_index(name);
    if !is_element && !name.contains(['/', '.']) {
        return None;
    }
    let stem = stem.to_lowercase();
    let all: Vec<&str> = stem.split(['/', '.']).filter(|s| !s.is_empty()).collect();
    let has_word = |words: &[&str]| all.iter().any(|segment| has_one_of(segment, words));
    let path = |kind, n_before: usize, unit| Path { kind, source: all[..n_before].join("/"), unit };
    if is_element {
        // `rostopic echo -p` writes a message that is only an array like this; gauges are published so.
        let is_bare = all == ["field", "data"];
        let is_gauge = (is_bare || is_gauges(&all)) && !has_word(&NO_LOADS);
        return is_gauge.then(|| path(Kind::Gauge, all.len(), None));
    }
    let n_telling = all.iter().rposition(|segment| !NEUTRAL.contains(segment))? + 1;
    let (last, before) = all[..n_telling].split_last()?;
    let above = before.last().copied().unwrap_or_default();
    if let Some(axes) = words::axes_of_quantity(above).filter(|_| above.len() > 1)
        && let Some(direction) = words::direction(last)
    {
        let load = path(Kind::Load(axes[direction]), before.len() - 1, None);
        return (!has_word(&NO_LOADS)).then_some(load);
    }
    if above == "header" && *last == "stamp" {
        return Some(path(Kind::Time, before.len(), None));
    }
    if above == "stamp" {
        let unit = match (SECONDS.contains(last), NANOSECONDS.contains(last)) {
            (true, _) => "s",
            (_, true) => "ns",
            _ => return None,
        };
        return Some(path(Kind::Time, before.len(), Some(unit)));
    }
    let kind = plain_kind(last)?;
    let is_one = match kind {
        Kind::Time => words::is_time(&plain(last)),
        Kind::Load(_) => !has_word(&NO_LOADS),
        Kind::Gauge => {
            let stem = words::gauge_stem(last).unwrap_or_default();
            let may_be_other = has_one_of(&stem, &CHANNELS) || stem == "sensor";
            !(has_word(&NO_LOADS) || may_be_other && before.iter().any(|s| has_one_of(s, &LOADS)))
        }
    };
    is_one.then(|| path(kind, before.len(), None))
}

/// Returns the name of an array, and true if the name is one of its elements: `data[0]`, `data.0`, `data0`.
fn without_index(name: &str) -> (&str, bool) {
    let bracketed = || name.strip_suffix(']')?.rsplit_once('[');
    if let Some((stem, index)) = bracketed()
        && !index.is_empty()
        && index.bytes().all(|byte| byte.is_ascii_digit())
    {
        return (stem, true);
    }
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let has_index = stem.len() < name.len();
    if let Some(array) = stem.strip_suffix(['.', '/']).filter(|_| has_index) {
        return (array, !array.is_empty());
    }
    let is_data = has_index && stem.ends_with("data") && stem.contains(['.', '/']);
    if is_data { (stem, true) } else { (name, false) }
}

fn has_one_of(segment: &str, words: &[&str]) -> bool {
    let parts = segment.split(['_', '-', ' ']);
    let mut parts = parts.map(|part| part.trim_end_matches(|c: char| c.is_ascii_digit()));
    parts.any(|part| words.contains(&part))
}

/// Returns true if the last part with a meaning makes the path an array of gauges.
fn is_gauges(segments: &[&str]) -> bool {
    let mut telling = segments.iter().rev().filter(|s| !NEUTRAL.contains(s));
    let Some(segment) = telling.next() else {
        return false;
    };
    let has = |words| has_one_of(segment, words);
    let mut has_load_above = || telling.any(|segment| has_one_of(segment, &LOADS));
    !has(&LOADS) && (has(&GAUGES) || (has(&CHANNELS) && !has_load_above()))
}
