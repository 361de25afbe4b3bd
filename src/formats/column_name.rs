//! What a column's name says: its kind and its unit.

use crate::recording::Axis;
use crate::recording::units::{TimeUnit, force_in_newtons, moment_in_newton_metres};

/// Names of a time column, in small letters without separators. A time unit alone, but for the bare `s`, is one too.
const TIMES: [&str; 10] = [
    "t",
    "time",
    "times",
    "timestamp",
    "timestamps",
    "stamp",
    "elapsed",
    "elapsedtime",
    "epoch",
    "unixtime",
];
/// What stands before a gauge's number, in small letters.
const GAUGES: [&str; 18] = [
    "s",
    "sg",
    "stg",
    "g",
    "gauge",
    "ch",
    "chan",
    "channel",
    "ai",
    "u",
    "v",
    "raw",
    "strain",
    "sensor",
    "adc",
    "a",
    "coinft_raw",
    "coinft",
];
/// What may follow a gauge's name without brackets; gauges keep whatever unit they have.
const GAUGE_UNITS: [&str; 16] = [
    "mv/v", "uv/v", "v/v", "v", "mv", "uv", "counts", "count", "lsb", "raw", "adc", "ohm", "ohms",
    "strain", "ustrain", "pf",
];
/// No name that is understood is longer (bytes).
const LONGEST: usize = 64;
/// What may stand before an axis of the reference.
const REFERENCES: [&str; 3] = ["ati", "reference", "ref"];

/// What a column is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Time,
    Gauge,
    Load(Axis),
}

/// A column's name, understood.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ColumnName {
    /// As written, without the bracketed unit.
    pub(crate) name: String,
    /// `None` for a column that is not used.
    pub(crate) kind: Option<Kind>,
    /// As written; a bracketed one may be anything, one after a separator is known for the kind.
    pub(crate) unit: Option<String>,
}

impl ColumnName {
    pub(crate) fn parse(cell: &str) -> Self {
        let (name, bracketed) = split_brackets(cell.trim());
        let separators = name.match_indices(['_', ' ', '/']);
        let mut separators = separators.take_while(|(at, _)| *at <= LONGEST);
        let with_suffix = separators.find_map(|(at, _)| {
            let (start, suffix) = (name[..at].trim_end(), &name[at + 1..]);
            let kind = kind_of(start)?;
            is_unit_of(kind, suffix).then_some((kind, Some(suffix)))
        });
        // The suffix first: time_s is not times.
        let understood = with_suffix.or_else(|| {
            let kind = kind_of(name)?;
            let is_unit = kind == Kind::Time && TimeUnit::from_name(name).is_some();
            Some((kind, is_unit.then_some(name)))
        });
        Self {
            name: name.to_owned(),
            kind: understood.map(|(kind, _)| kind),
            unit: bracketed
                .or(understood.and_then(|(_, unit)| unit))
                .map(str::to_owned),
        }
    }
}

/// `name [unit]` or `name (unit)` in two, whatever the unit; empty brackets hold none, and an index is part of the name.
fn split_brackets(cell: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(inside) = cell.strip_suffix(close)
            && let Some((name, unit)) = inside.rsplit_once(open)
            && !name.is_empty()
            && !is_index(unit)
        {
            let unit = unit.trim();
            return (name.trim_end(), (!unit.is_empty()).then_some(unit));
        }
    }
    (cell, None)
}

/// Whether this is where an element stands in an array, or which copy of a name this is: `0`, `1,2`, `0:3`.
fn is_index(inside: &str) -> bool {
    let is_part = |c: char| c.is_ascii_digit() || [',', ':', ' '].contains(&c);
    inside.contains(|c: char| c.is_ascii_digit()) && inside.chars().all(is_part)
}

fn kind_of(name: &str) -> Option<Kind> {
    let plain = name.to_lowercase().replace(['_', ' '], "");
    let is_time_unit = name.len() > 1 && TimeUnit::from_name(name).is_some();
    if TIMES.contains(&plain.as_str()) || is_time_unit {
        Some(Kind::Time)
    } else if is_gauge(name) {
        Some(Kind::Gauge)
    } else {
        axis_of(&plain).map(Kind::Load)
    }
}

/// Whether a column with this name is a gauge.
pub(crate) fn is_gauge_name(name: &str) -> bool {
    ColumnName::parse(name).kind == Some(Kind::Gauge)
}

/// Whether a column with this name is the time.
pub(crate) fn is_time_name(name: &str) -> bool {
    ColumnName::parse(name).kind == Some(Kind::Time)
}

fn is_gauge(name: &str) -> bool {
    let start = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let n_digits = name.len() - start.len();
    let start = start.strip_suffix(['_', ' ', '-']).unwrap_or(start);
    (1..=9).contains(&n_digits) && GAUGES.contains(&start.to_lowercase().as_str())
}

fn axis_of(plain: &str) -> Option<Axis> {
    let bare = REFERENCES
        .iter()
        .find_map(|reference| plain.strip_prefix(reference))
        .unwrap_or(plain);
    Axis::ALL.into_iter().find(|axis| {
        let (quantities, direction): (&[&str], _) = match axis {
            Axis::Fx => (&["f", "force"], "x"),
            Axis::Fy => (&["f", "force"], "y"),
            Axis::Fz => (&["f", "force"], "z"),
            Axis::Mx => (&["m", "t", "moment", "torque"], "x"),
            Axis::My => (&["m", "t", "moment", "torque"], "y"),
            Axis::Mz => (&["m", "t", "moment", "torque"], "z"),
        };
        bare.strip_suffix(direction)
            .is_some_and(|quantity| quantities.contains(&quantity))
    })
}

/// Whether this is a unit of any kind of column.
pub(crate) fn is_known_unit(unit: &str) -> bool {
    [
        Kind::Time,
        Kind::Gauge,
        Kind::Load(Axis::Fx),
        Kind::Load(Axis::Mx),
    ]
    .into_iter()
    .any(|kind| is_unit_of(kind, unit))
}

/// Whether this is a unit of a force or a moment, which no gauge has.
pub(crate) fn is_load_unit(unit: &str) -> bool {
    [Axis::Fx, Axis::Mx]
        .into_iter()
        .any(|axis| is_unit_of(Kind::Load(axis), unit))
}

fn is_unit_of(kind: Kind, suffix: &str) -> bool {
    match kind {
        Kind::Time => TimeUnit::from_name(suffix).is_some(),
        Kind::Gauge => GAUGE_UNITS.contains(&suffix.trim().to_lowercase().as_str()),
        Kind::Load(axis) if axis.is_force() => force_in_newtons(suffix).is_some(),
        Kind::Load(_) => moment_in_newton_metres(suffix).is_some(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_without_end_is_none_that_is_known() {
        let name = "a_".repeat(500_000);
        assert_eq!(ColumnName::parse(&name).kind, None);
        let name = format!("S{}", " ".repeat(1_000_000) + "V");
        assert_eq!(ColumnName::parse(&name).unit, None);
    }

    #[track_caller]
    fn assert_all(cells: &[&str], kind: Option<Kind>) {
        for cell in cells {
            assert_eq!(ColumnName::parse(cell).kind, kind, "{cell}");
        }
    }

    #[test]
    fn names_tell_the_kind() {
        let times = "t|Time|TIMESTAMP|times|stamp|elapsed|sec|secs|seconds|ms|epoch|time_stamp|\
            elapsed_time|Elapsed Time|t_ms|time [s]|timestamp_ns|t/s|Time (µs)|time_stamp_us| t ";
        assert_all(&times.split('|').collect::<Vec<_>>(), Some(Kind::Time));
        let gauges = "S1|SG0|STG3|G0|gauge 7|ch0|Chan-2|channel_12|ai0|u1|v2|raw_1|strain1|Sensor 1|\
            adc0|a3|CoinFT_raw_1|S1 [mV/V]|S1_mV/V|ch1 (V)|ch1_V|ai0/V|s_1 counts";
        assert_all(&gauges.split('|').collect::<Vec<_>>(), Some(Kind::Gauge));
        let fx =
            "Fx|FX|f_x|force_x|Force x|ATI_Fx|ref_Fx|ref_force_x|Fx_N|Fx [kN]|Fx/lbf|Fx [stone]";
        let fx: Vec<_> = fx.split('|').collect();
        assert_all(&fx, Some(Kind::Load(Axis::Fx)));
        let mz = "Mz|Tz|torque_z|moment_z|Mz (N·mm)|Tz_Nmm|ATI_Tz|ref tz|Tz_lbf-in|M_z N.m";
        let mz: Vec<_> = mz.split('|').collect();
        assert_all(&mz, Some(Kind::Load(Axis::Mz)));
    }

    #[test]
    fn other_names_tell_nothing() {
        let others = "|s|S|x|label|temperature|S1a|S1_N|ch|Fx_std|Fx_Nm|F|fxx|t1|1|min|S1234567890|time-s|[N]";
        assert_all(&others.split('|').collect::<Vec<_>>(), None);
    }

    #[test]
    fn units_are_taken_from_brackets_and_suffixes() {
        for (cell, name, unit) in [
            ("t_ms", "t_ms", Some("ms")),
            ("time_s", "time_s", Some("s")),
            ("ms", "ms", Some("ms")),
            ("seconds", "seconds", Some("seconds")),
            ("t", "t", None),
            ("Mx (N·mm)", "Mx", Some("N·mm")),
            ("S1 [mV/V]", "S1", Some("mV/V")),
            ("ch1_V", "ch1_V", Some("V")),
            ("Fx []", "Fx", None),
            ("Kanal 1 [mV/V]", "Kanal 1", Some("mV/V")),
            ("Weg [-]", "Weg", Some("-")),
            ("/gauges/data[0]", "/gauges/data[0]", None),
            ("data[0,12] [mV/V]", "data[0,12]", Some("mV/V")),
            ("Fx (2)", "Fx (2)", None),
            ("x[10 N]", "x", Some("10 N")),
        ] {
            let column = ColumnName::parse(cell);
            assert_eq!((&*column.name, column.unit.as_deref()), (name, unit));
        }
    }
}
