//! Kind (time, gauge or load axis) and unit of a column, derived from its name in a file.

mod path;
mod words;

use path::{NANOSECONDS, SECONDS, Understood, stamp_of_part};
pub(crate) use words::Kind;
pub(super) use words::is_one_of;
use words::{LONGEST, has, plain, plain_kind};

use crate::recording::{
    Axis,
    units::{
        TimeUnit, angle_in_radians, force_in_newtons, moment_in_newton_metres,
        temperature_in_celsius,
    },
};

/// Units that may follow a gauge's name without brackets, as in `S1 mV`. In brackets, a gauge may have any unit.
const GAUGE_UNITS: &str = "volt volts v mv uv µv counts count lsb raw adc ohm ohms strain pf";
/// Units that only gauges have. A column with one of these units is a gauge, whatever its name.
const GAUGE_ONLY_UNITS: &str =
    "mv/v uv/v µv/v μv/v v/v um/m µm/m μm/m ustrain µstrain µε με microstrain";
/// Units of a voltage.
const VOLTS: &str = "V mV uV µV Volt Volts";
/// French word that means time, and also weather. A column with this name is a time only if its unit is one of time.
const TIME_WITH_UNIT: &str = "temps";

#[derive(Clone, Debug, PartialEq)]
pub struct ColumnName {
    /// Name of the column as written, without a unit in brackets.
    pub name: String,
    pub kind: Option<Kind>,
    /// Unit as written: any text in brackets, a known unit behind the name, or a name that is a unit of a load.
    pub unit: Option<String>,
    /// Topic or struct in front of the name, such as `run` in `run.S1`; empty if the name is not a path.
    pub source: String,
}

impl ColumnName {
    pub fn parse(cell: &str) -> Self {
        let within;
        let (mut name, mut bracketed) = split_brackets(cell.trim());
        // A word in round brackets that is no unit belongs to the name, as in `Load (filtered)`.
        let is_remark = cell.trim_end().ends_with(')') && bracketed.is_some_and(is_plain_word);
        bracketed = bracketed.filter(|_| !is_remark);
        if bracketed.is_none()
            && let Some((before, unit, after)) = unit_within(cell.trim())
        {
            within = format!("{before} {after}");
            (name, bracketed) = (&within, Some(unit));
        }
        let separators = name.match_indices(['_', ' ', '/']);
        let mut separators = separators.take_while(|(at, _)| *at <= LONGEST);
        let plain_name = |kind, unit| Understood { kind, unit, source: String::new() };
        let with_suffix = separators.find_map(|(at, _)| {
            let (start, suffix) = (name[..at].trim_end(), &name[at + 1..]);
            let kind = kind_of(start)?;
            is_unit_of(kind, suffix).then_some(plain_name(kind, Some(suffix)))
        });
        // A unit behind the name is tried first, so that `time_s` is not taken for the plural `times`.
        let understood = with_suffix.or_else(|| {
            let kind = kind_of(name)?;
            let is_unit = kind == Kind::Time && TimeUnit::from_name(name).is_some();
            Some(plain_name(kind, is_unit.then_some(name)))
        });
        let understood = understood.or_else(|| path::understood(name));
        let (kind, unit, source) = understood
            .map_or((None, None, String::new()), |name| (Some(name.kind), name.unit, name.source));
        let is_time =
            |unit: &str| plain(name) == TIME_WITH_UNIT && TimeUnit::from_name(unit).is_some();
        let unit = bracketed.or(unit);
        // In two letters, `Cn` is a coefficient and `cN` a unit.
        let bare = || {
            let is_unit = is_load_unit(name) && !is_one_of(name, words::OTHER_UNITS);
            (is_unit && (name.len() > 2 || name.len() == 2 && !name.ends_with('n'))).then_some(name)
        };
        let unit = unit.or_else(bare);
        Self {
            name: if is_remark && bracketed.is_none() { cell.trim() } else { name }.to_owned(),
            kind: kind
                .or_else(|| unit.is_some_and(is_time).then_some(Kind::Time))
                .or_else(|| unit.is_some_and(is_of_gauges_alone).then_some(Kind::Gauge))
                .and_then(|kind| kind.with_unit(unit)),
            unit: unit.map(str::to_owned),
            source,
        }
    }

    /// Returns the unit of an auxiliary channel such as a temperature, empty if none is given; `None` for any other column.
    pub fn auxiliary_unit(&self, unit: Option<&str>) -> Option<String> {
        let unit = unit.or(self.unit.as_deref());
        if self.kind.is_some() || self.name.len() > LONGEST || unit.is_some_and(is_load_unit) {
            return None;
        }
        let name = self.name.to_lowercase();
        let words = words_of(&name);
        let is_of_load = |word: &&str| matches!(plain_kind(word), Some(Kind::Load(_)));
        if words.iter().any(is_of_load) {
            return None;
        }
        // A unit of one letter (C, F, K) is ambiguous. The column is a temperature only if its name also has a word that
        // starts with T.
        let is_temperature = |unit: &str| {
            temperature_in_celsius(unit).is_some()
                && (unit.len() > 1 || words.iter().any(|word| word.starts_with('t')))
        };
        let is_called = has(&words, &[words::AUXILIARIES]) && !has(&words, &[words::NOT_MEASURED]);
        if !is_called && !unit.is_some_and(is_temperature) {
            return None;
        }
        let is_unit =
            |word: &&str| ["v", "mv"].contains(word) || temperature_in_celsius(word).is_some();
        Some(
            unit.or(words.last().copied().filter(|_| words.len() > 1).filter(is_unit))
                .unwrap_or_default()
                .to_owned(),
        )
    }

    /// Returns true if the name or the unit belongs to a force, a mass or a moment, but the name does not tell the axis.
    pub fn is_unnamed_load(&self, unit: Option<&str>) -> bool {
        let unit = unit.or(self.unit.as_deref());
        if self.kind.is_some() || self.name.len() > LONGEST {
            return false;
        }
        let name = self.name.to_lowercase();
        let words: Vec<&str> = name.split(|c: char| !c.is_alphanumeric()).collect();
        let is_other = |unit: &str| is_of_gauges_alone(unit) || self.is_other_quantity(Some(unit));
        unit.is_some_and(is_load_unit)
            || words::is_load(&words) && !unit.is_some_and(is_other) && !self.has(&[words::SPREADS])
    }

    /// Returns true if a load without an axis is a moment.
    pub fn is_unnamed_moment(&self, unit: Option<&str>) -> bool {
        match unit.or(self.unit.as_deref()) {
            Some(unit) if force_in_newtons(unit).is_some() => false,
            Some(unit) if is_load_unit(unit) => true,
            _ => {
                let name = self.name.to_lowercase();
                let words = words_of(&name).into_iter().filter(|word| word.len() > 1);
                has(&words.collect::<Vec<_>>(), &[words::MOMENTS, "mx mz"])
            }
        }
    }

    /// Returns true if the name is that of a mass, so that its unit is not N.
    pub fn is_mass(&self) -> bool {
        self.has(&[words::MASSES])
    }

    /// Returns true if a word of a name that is not too long is in one of these lists.
    fn has(&self, lists: &[&str]) -> bool {
        self.name.len() <= LONGEST && has(&words_of(&self.name.to_lowercase()), lists)
    }

    /// Returns true if a word of the name means a time.
    pub fn has_clock_word(&self) -> bool {
        self.name.len() <= LONGEST && words::is_clock(&words_of(&self.name.to_lowercase()))
    }

    /// Returns true if the name is that of a count of rows, cycles or frames.
    pub fn is_counter(&self, is_whole: bool) -> bool {
        let has_word = || words::is_counter(&words_of(&self.name.to_lowercase()));
        is_whole && self.name.len() <= LONGEST && has_word()
    }

    /// Returns true if the name or the unit is that of a quantity that is neither a load nor the signal of a gauge, such as a
    /// displacement, a stress or the spread of other values.
    pub fn is_other_quantity(&self, unit: Option<&str>) -> bool {
        // A strain has no unit, so that `%` or `mm/mm` says nothing about it.
        let is_other = |unit: &str| {
            let is_ratio = unit.contains('/') && !is_of_gauges_alone(unit);
            (is_ratio || is_one_of(&unit.trim().to_lowercase(), words::OTHER_UNITS))
                && !(self.has(&[words::STRAINS]) && is_one_of(unit.trim(), words::STRAIN_UNITS))
        };
        unit.is_some_and(is_other) || self.has(&[words::DISPLACEMENTS, words::SPREADS])
    }

    /// Returns true if the name or the unit is that of a stress or a spread, which is computed from other values.
    pub fn is_computed(&self, unit: Option<&str>) -> bool {
        const STRESSES: &str = "pa kpa mpa gpa psi n/mm^2 n/mm² n/mm2";
        unit.is_some_and(|unit| is_one_of(&unit.trim().to_lowercase(), STRESSES))
            || self.has(&[words::SPREADS])
    }

    /// Returns true if the unit is volts, or the name has a word for an electrical signal or its digits, such as `voltage` or
    /// `adc`.
    pub fn is_signal(&self, unit: Option<&str>) -> bool {
        unit.is_some_and(|unit| is_one_of(unit, VOLTS) && !self.is_other_quantity(Some(unit)))
            || self.has(&[words::RAW, words::SIGNALS])
    }

    /// Returns true if the column holds the seconds or nanoseconds of a time stamp.
    pub fn is_of_stamp(&self) -> bool {
        [SECONDS, NANOSECONDS].iter().any(|words| stamp_of_part(&self.name, words).is_some())
    }

    /// Returns the unit behind a name whose kind is unknown, as in `Mass_kg`.
    pub fn unit_behind_name(&self) -> Option<String> {
        // A number behind the unit tells equal columns apart, as in `Force_kN_1`.
        let digits = self.name.trim_end_matches(|c: char| c.is_ascii_digit());
        let name = digits.strip_suffix(['_', ' ']).unwrap_or(&self.name);
        let (start, unit) = name.rsplit_once(['_', ' ', '/'])?;
        if let Some(above) = start.strip_suffix("_per").or_else(|| start.strip_suffix(" per")) {
            let above = above.rsplit(['_', ' ']).next().unwrap_or_default();
            return Some(format!("{above}/{unit}"));
        }
        let is_time = TimeUnit::from_name(unit).is_some() && unit.len() > 1
            || unit == "s" && words::is_clock(&words_of(&start.to_lowercase()));
        let is_load = || words::is_load(&words_of(&start.to_lowercase()));
        let is_unit = is_load_unit(unit)
            || is_time
            || is_one_of(unit, VOLTS)
            || force_in_newtons(unit).is_some() && is_load()
            || unit.len() > 1 && is_one_of(&unit.to_lowercase(), words::OTHER_UNITS);
        (self.name.len() <= LONGEST && is_unit).then(|| unit.to_owned())
    }

    /// Returns true if this column holds the whole seconds of a time stamp, and the column `other` the nanoseconds of the
    /// same stamp.
    pub fn is_completed_by(&self, other: &Self) -> bool {
        let stamp = stamp_of_part(&self.name, SECONDS);
        stamp.is_some() && stamp == stamp_of_part(&other.name, NANOSECONDS)
    }
}

/// Returns true if a text contains a word for a quantity that is not plain ASCII.
pub(super) fn has_foreign_word(text: &str) -> bool {
    let text = text.to_lowercase();
    let is_foreign = |word: &&str| !word.is_ascii() && word.chars().count() > 1;
    words::are_known(&words_of(&text).into_iter().filter(is_foreign).collect::<Vec<_>>())
}

/// Returns the words of a name in lower case, without the numbers behind them.
fn words_of(name: &str) -> Vec<&str> {
    name.split(|c: char| !c.is_alphanumeric())
        .map(|word| word.trim_end_matches(|c: char| c.is_ascii_digit()))
        .filter(|word| !word.is_empty())
        .collect()
}

impl Kind {
    /// Returns the kind of a column whose name alone gives this kind, after a look at its unit. A load's name with the unit
    /// of a gauge gives a gauge. A gauge's name with the unit of a load gives no kind, since the axis is unknown. `T` in
    /// degrees is a temperature, not a time.
    pub fn with_unit(self, unit: Option<&str>) -> Option<Self> {
        let is_of_gauge = |unit: &str| is_unit_of(Self::Gauge, unit);
        match (self, unit) {
            (Self::Gauge, Some(unit)) if is_load_unit(unit) => None,
            (Self::Time, Some(unit)) if temperature_in_celsius(unit).is_some() => None,
            (Self::Load(_), Some(unit)) if is_of_gauge(unit) => Some(Self::Gauge),
            _ => Some(self),
        }
    }
}

/// Splits `name [unit]` or `name (unit)` into name and unit. Empty brackets give no unit; an index in brackets stays in the
/// name.
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
    // Some spreadsheets write a unit as in "Fx in kN".
    match cell.rsplit_once(" in ") {
        Some((name, unit)) if is_known_unit(unit.trim()) => (name.trim_end(), Some(unit.trim())),
        _ => (cell, None),
    }
}

/// Returns the parts of a name around a known unit in brackets, and the unit: `Force (kN) Run #1`.
fn unit_within(cell: &str) -> Option<(&str, &str, &str)> {
    if cell.len() > LONGEST {
        return None;
    }
    [('[', ']'), ('(', ')')].into_iter().find_map(|(open, close)| {
        let (before, rest) = cell.split_once(open)?;
        let (unit, after) = rest.split_once(close)?;
        let is_unit = is_any_unit(unit) || force_in_newtons(unit).is_some();
        let after = after.trim_start_matches(['_', '-', ' ']);
        (is_unit && !before.is_empty() && !after.is_empty()).then_some((
            before.trim_end(),
            unit,
            after,
        ))
    })
}

/// Returns true if the text in brackets is a word that is no known unit: `filtered`. Unknown units are short.
fn is_plain_word(inside: &str) -> bool {
    const LONGEST_UNIT_BYTES: usize = 3;
    inside.len() > LONGEST_UNIT_BYTES
        && inside.chars().all(|c| c.is_alphabetic() || c == ' ')
        && !is_known_unit(inside)
        && !is_one_of(&inside.to_lowercase(), "sample samples unix")
        && temperature_in_celsius(inside).is_none()
        && angle_in_radians(inside).is_none()
        && !is_one_of(&inside.to_lowercase(), words::OTHER_UNITS)
}

/// Returns true if the text in brackets is no unit but an index or the number of a repeated name: `0`, `1,2`, `0:3`.
fn is_index(inside: &str) -> bool {
    let is_part = |c: char| c.is_ascii_digit() || [',', ':', ' '].contains(&c);
    inside.contains(|c: char| c.is_ascii_digit()) && inside.chars().all(is_part)
}

fn kind_of(name: &str) -> Option<Kind> {
    // Alone, `min` mostly means a minimum.
    let unit = TimeUnit::from_name(name).filter(|unit| unit.per_second() >= 1.0);
    let is_time_unit = name.len() > 1 && unit.is_some();
    if is_time_unit { Some(Kind::Time) } else { plain_kind(name) }
}

pub fn is_gauge_name(name: &str) -> bool {
    ColumnName::parse(name).kind == Some(Kind::Gauge)
}

/// Returns true if a word of the name means a channel, a device or a place.
pub fn is_identifier(name: &str) -> bool {
    name.len() <= LONGEST && has(&words_of(&name.to_lowercase()), &[words::IDENTIFIERS])
}

pub fn is_time_name(name: &str) -> bool {
    ColumnName::parse(name).kind == Some(Kind::Time)
}

fn is_of_gauges_alone(unit: &str) -> bool {
    is_one_of(&unit.trim().to_lowercase(), GAUGE_ONLY_UNITS)
}

pub fn is_known_unit(unit: &str) -> bool {
    is_load_unit(unit) || is_unit_of(Kind::Time, unit) || is_unit_of(Kind::Gauge, unit)
}

/// Returns true if a text is a known unit, of whatever quantity, or `h:m:s`.
pub fn is_any_unit(unit: &str) -> bool {
    let lower = unit.trim().to_lowercase();
    is_known_unit(unit)
        || temperature_in_celsius(unit).is_some()
        || angle_in_radians(unit).is_some()
        || is_one_of(&lower, words::OTHER_UNITS)
        || lower == "h:m:s"
}

/// Returns true for a unit of force or moment, which no gauge has.
pub fn is_load_unit(unit: &str) -> bool {
    // These letters also stand for an acceleration and for a time.
    if ["g", "t", "mg"].contains(&unit.trim()) {
        return false;
    }
    [Axis::Fx, Axis::Mx].into_iter().any(|axis| is_unit_of(Kind::Load(axis), unit))
}

fn is_unit_of(kind: Kind, suffix: &str) -> bool {
    match kind {
        Kind::Time => TimeUnit::from_name(suffix).is_some(),
        Kind::Gauge => {
            let suffix = suffix.trim().to_lowercase();
            is_one_of(&suffix, GAUGE_UNITS) || is_of_gauges_alone(&suffix)
        }
        Kind::Load(axis) if axis.is_force() => force_in_newtons(suffix).is_some(),
        Kind::Load(_) => moment_in_newton_metres(suffix).is_some(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_very_long_name_has_no_kind_or_unit() {
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
    fn names_give_the_kind() {
        let times = "t|Time|TIMESTAMP|times|stamp|elapsed|sec|secs|seconds|ms|epoch|time_stamp|\
            elapsed_time|Elapsed Time|t_ms|time [s]|timestamp_ns|t/s|Time (µs)|time_stamp_us| t ";
        assert_all(&times.split('|').collect::<Vec<_>>(), Some(Kind::Time));
        let gauges = "S1|SG0|STG3|G0|gauge 7|ch0|Chan-2|channel_12|ai0|u1|v2|raw_1|strain1|Sensor 1|\
            adc0|a3|CoinFT_raw_1|S1 [mV/V]|S1_mV/V|ch1 (V)|ch1_V|ai0/V|s_1 counts|\
            field.data0|field.data12";
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
    fn other_names_have_no_kind() {
        let others = "|s|S|x|label|temperature|S1a|S1_N|ch|Fx_std|Fx_Nm|F|fxx|t1|1|min|S1234567890|time-s|[N]";
        assert_all(&others.split('|').collect::<Vec<_>>(), None);
    }

    #[test]
    fn names_written_by_ros_tools_are_understood() {
        let times = "%time|__time|Time|header.stamp|field.header.stamp|/ft/header/stamp|header.stamp.sec|\
            header.stamp.nanosec|/ft/header/stamp/nsecs|run.t|log.time [ms]";
        assert_all(&times.split('|').collect::<Vec<_>>(), Some(Kind::Time));
        let gauges = "/gauges/data[0]|/gauges/data.0|/gauges/data/11|gauges.data[3]|/ft_sensor/strain_gauges/data[2]|\
            /strain[4]|raw.7|/adc/data0|/gauge1/data|/sg/ch3|run.S1|log.ch2 [V]|/adc_raw/data[1]";
        assert_all(&gauges.split('|').collect::<Vec<_>>(), Some(Kind::Gauge));
        let fx = "wrench.force.x|field.wrench.force.x|/ft/wrench/force/x|/ft/wrench/wrench/force/x|/ati/Fx|run.Fx [N]|\
            /ati/fx/data|Force.X|force.x";
        let fx: Vec<_> = fx.split('|').collect();
        assert_all(&fx, Some(Kind::Load(Axis::Fx)));
        let mz = "wrench.torque.z|field.wrench.torque.z|/ft/wrench/torque/z|/ft/moment/z [N·mm]";
        let mz: Vec<_> = mz.split('|').collect();
        assert_all(&mz, Some(Kind::Load(Axis::Mz)));
        assert_eq!(ColumnName::parse("/ATI/wrench/force/x").source, "ati/wrench");
        let stamp = |name: &str| ColumnName::parse(&format!("header.stamp.{name}"));
        assert!(stamp("sec").is_completed_by(&stamp("nanosec")));
        assert!(stamp("secs").is_completed_by(&stamp("nsecs")));
        assert!(!stamp("nsecs").is_completed_by(&stamp("secs")));
        assert_eq!(stamp("nsecs").unit.as_deref(), Some("ns"));
    }

    #[test]
    fn loads_are_understood_in_other_languages() {
        let fx = "Applied Force X|true Fx [N]|Kraft X [N]|Kraft x|X-Kraft|Kraft in X-Richtung|Kraft Fx [kN]|Force X|Fuerza X|Fuerza eje X|Forza X|\
            Força X|力X|力_X [N]|X方向力|X轴力|力 X|ref Kraft x|荷重X|Force axe X|X force|Referenz Fx";
        assert_all(&fx.split('|').collect::<Vec<_>>(), Some(Kind::Load(Axis::Fx)));
        let mz = "Moment Z|Drehmoment z|Drehmoment Mz [Nm]|Couple Z|Momento Z [N·m]|Coppia Z|力矩Z|扭矩 Z|トルクZ|\
            Z軸モーメント|Z-Moment";
        assert_all(&mz.split('|').collect::<Vec<_>>(), Some(Kind::Load(Axis::Mz)));
        let gauges = "Bridge 1 [mV/V]|Brücke 2 [µV/V]|ε1 [µm/m]|Voltage_0|A [mV/V]|Left arm (µε)|pont 3|DMS 1|DMS_2 [mV/V]|Kanal 3|Jauge 1|Voie 2|Galga 4|Canal 1|Canale 2|通道1|应变片 3|ひずみ1|Dehnung 2";
        assert_all(&gauges.split('|').collect::<Vec<_>>(), Some(Kind::Gauge));
        let times = "Zeit [s]|Zeitstempel|Tiempo|Tempo (ms)|时间|時間 [s]|Temps [s]";
        assert_all(&times.split('|').collect::<Vec<_>>(), Some(Kind::Time));
    }

    /// A load taken for a gauge would make the calibration look perfect; a gauge taken for a load would make it useless.
    #[test]
    fn a_load_is_no_gauge_and_a_gauge_is_no_load() {
        let none = "/wrench/data[0]|/ft/data[2]|/ft_raw/data[0]|/force_sensor/data[1]|/force_gauge/data[0]|data[0]|\
            field.layout.dim0.size|field.layout.data_offset|/ati/ch1|/wrench/raw_1|/temperature/data[0]|/gauges/temperature/data[0]|Kanal 1 [N]|S1 [N]|\
            ch2 (N·m)|Kraft|Kraft [N]|Kraftsensor 1|Kraftaufnehmer 2|Moment|Couple [N·m]|Drehmomentsensor 1|\
            /imu/linear_acceleration/x|position.x|/pose/position/z|wrench.force_std.x|/ft/bias/force/x|\
            /cmd_wrench/force/x|/ft/wrench/covariance/force/x|wrench.force|header.frame_id|field.header.seq|Fx.1|\
            moment of inertia x|Temps|/gauges/offset/data[0]|/force_raw[0]|Zugkraft X max";
        assert_all(&none.split('|').collect::<Vec<_>>(), None);
        let gauges = "Fx [mV/V]|Kraft X (mV)|wrench.force.x [counts]|Fz [µm/m]";
        assert_all(&gauges.split('|').collect::<Vec<_>>(), Some(Kind::Gauge));
    }

    #[test]
    fn auxiliary_channels_are_known_by_their_name_or_their_unit() {
        for (cell, unit) in [
            ("T [degC]", "degC"),
            ("T [K]", "K"),
            ("t (°C)", "°C"),
            ("T1 [°C]", "°C"),
            ("Temp", ""),
            ("temp_2", ""),
            ("Temperature", ""),
            ("temperature_C", "c"),
            ("sensor temp degF", "degf"),
            ("Temperatur [°C]", "°C"),
            ("PT100 [°C]", "°C"),
            ("Humidity [%]", "%"),
            ("RH", ""),
            ("Vsup", ""),
            ("Supply [V]", "V"),
            ("supply_mV", "mv"),
            ("Vexc [V]", "V"),
            ("/temperature/data[0]", ""),
            ("温度 [℃]", "℃"),
        ] {
            let found = ColumnName::parse(cell).auxiliary_unit(None);
            assert_eq!(found.as_deref(), Some(unit), "{cell}");
        }
        let others = "T|t [s]|Tx|Tz [Nm]|T [Nm]|S1 [degC]|ch3 [°C]|temperature [N]|Fx temp compensated|attempts|template|\
            temp_setpoint|x [K]|RHS|temporary|Tempo|Temps [s]|Fx_temp";
        for cell in others.split('|') {
            let found = ColumnName::parse(cell).auxiliary_unit(None);
            assert_eq!(found, None, "{cell}");
        }
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
            ("Force (kN) Run #1", "Force Run #1", Some("kN")),
            ("Torque [mNm] 1", "Torque 1", Some("mNm")),
            ("Load(kgf)_1", "Load 1", Some("kgf")),
            ("Time (s) (filtered)", "Time (filtered)", Some("s")),
            ("Cn", "Cn", None),
            ("cN", "cN", Some("cN")),
        ] {
            let column = ColumnName::parse(cell);
            assert_eq!((&*column.name, column.unit.as_deref()), (name, unit));
        }
    }
}
