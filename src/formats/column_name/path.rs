//! Recognises column names that are paths: fields of a message as ROS tools write them (`/ft/wrench/force/x`,
//! `field.wrench.force.x`, `/gauges/data[0]`), and fields of a struct (`run.S1`). An ambiguous path is neither a gauge nor a
//! load.

use super::words::{self, Kind, is_one_of, plain, plain_kind};

/// Words in the path of a column that is derived from a load but holds no load, such as a deviation, an error or a setpoint.
const NO_LOADS: &str = "std stddev bias offset offsets error err residual covariance cov command cmd desired setpoint target goal";
const LOADS: &str = "force forces wrench wrenches torque torques moment moments ft load loads ati ref reference effort weight";
/// Words that occur only in the path of a gauge.
const GAUGES: &str =
    "gauge gauges gage gages strain strains sg stg dms straingauge straingauges coinft";
/// Words in the paths of gauges and also of other signals. Next to a word for a load, they do not mean a gauge.
const CHANNELS: &str = "raw adc channel channels ch ai volts voltages";
/// Words in a path that do not tell what the column holds.
const NEUTRAL: &str = "data value values field";
pub const SECONDS: &str = "sec secs";
pub const NANOSECONDS: &str = "nanosec nanosecs nsec nsecs";

pub struct Understood<'a> {
    pub kind: Kind,
    pub unit: Option<&'a str>,
    /// Start of the path in front of the word that gives the column's kind, in lower case.
    pub source: String,
}

/// Returns the name of the time stamp of which a column holds a part (such as its nanoseconds), if the last word of the
/// column's name is one of `words`. The result is empty if the column's name has no other word.
pub fn stamp_of_part<'a>(name: &'a str, words: &str) -> Option<&'a str> {
    let name = name.trim();
    let (stamp, last) = name.rsplit_once(['/', '.', '_']).unwrap_or(("", name));
    is_one_of(&last.to_lowercase(), words).then_some(stamp)
}

/// Parses a column name as a path; `None` if it is not a path, or the path does not tell the column's kind.
pub fn understood(name: &str) -> Option<Understood<'static>> {
    let (stem, is_element) = without_index(name);
    if !is_element && !name.contains(['/', '.']) {
        return None;
    }
    let stem = stem.to_lowercase();
    let all: Vec<&str> = stem.split(['/', '.']).filter(|s| !s.is_empty()).collect();
    let is_measured = !all.iter().any(|segment| has_one_of(segment, NO_LOADS));
    let path = |kind, n_before: usize, unit| {
        Some(Understood { kind, unit, source: all[..n_before].join("/") })
    };
    if is_element {
        // `rostopic echo -p` writes such names for a message that holds only an array. Gauges are published as such messages.
        let is_bare = all == ["field", "data"];
        let is_gauge = is_measured && (is_bare || is_gauges(&all));
        return path(Kind::Gauge, all.len(), None).filter(|_| is_gauge);
    }
    let n_telling = all.iter().rposition(|segment| !is_one_of(segment, NEUTRAL))? + 1;
    let (last, before) = all[..n_telling].split_last()?;
    let above = before.last().copied().unwrap_or_default();
    if let Some(axes) = words::axes_of_quantity(above).filter(|_| above.len() > 1)
        && let Some(direction) = words::direction(last)
    {
        let load = path(Kind::Load(axes[direction]), before.len() - 1, None);
        return load.filter(|_| is_measured);
    }
    if above == "header" && *last == "stamp" {
        return path(Kind::Time, before.len(), None);
    }
    if above == "stamp" {
        let unit = match (is_one_of(last, SECONDS), is_one_of(last, NANOSECONDS)) {
            (true, _) => "s",
            (_, true) => "ns",
            _ => return None,
        };
        return path(Kind::Time, before.len(), Some(unit));
    }
    let kind = plain_kind(last)?;
    let is_kind = match kind {
        Kind::Time => is_one_of(&plain(last), words::TIMES),
        Kind::Load(_) => is_measured,
        Kind::Gauge => {
            let stem = words::gauge_stem(last).unwrap_or_default();
            let may_be_other = has_one_of(&stem, CHANNELS) || stem == "sensor";
            is_measured && !(may_be_other && before.iter().any(|s| has_one_of(s, LOADS)))
        }
    };
    path(kind, before.len(), None).filter(|_| is_kind)
}

/// Splits the index off a name of an array's element: `data[0]`, `data.0`, `data0`. Returns false if there is no index.
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

/// Returns true if a word of this part of a path is in the list `words`. Digits behind a word are ignored.
fn has_one_of(segment: &str, words: &str) -> bool {
    segment
        .split(['_', '-', ' '])
        .any(|part| is_one_of(part.trim_end_matches(|c: char| c.is_ascii_digit()), words))
}

/// Returns true if a path that names an array names gauges.
fn is_gauges(segments: &[&str]) -> bool {
    let mut telling = segments.iter().rev().filter(|s| !is_one_of(s, NEUTRAL));
    let Some(segment) = telling.next() else {
        return false;
    };
    let has = |words| has_one_of(segment, words);
    let mut has_load_above = || telling.any(|segment| has_one_of(segment, LOADS));
    !has(LOADS) && (has(GAUGES) || (has(CHANNELS) && !has_load_above()))
}
