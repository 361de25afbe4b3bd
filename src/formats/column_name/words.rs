//! Names of times, gauges and loads in the languages of the people who write headers.

use crate::recording::Axis;

/// Names of a time column, in lower case without separators. A unit of time alone, except the bare `s`, counts too.
const TIMES: [&str; 18] = [
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
    "%time",
    "zeit",
    "zeitstempel",
    "tiempo",
    "tempo",
    "时间",
    "時間",
    "時刻",
];
/// Stems before a gauge's number, in lower case.
const GAUGES: [&str; 43] = [
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
    "dms",
    "dehnung",
    "kanal",
    "jauge",
    "voie",
    "galga",
    "canal",
    "canale",
    "estensimetro",
    "extensometro",
    "extensômetro",
    "通道",
    "应变",
    "应变片",
    "ひずみ",
    "チャンネル",
    "bridge",
    "brücke",
    "bruecke",
    "messbrücke",
    "pont",
    "puente",
    "ponte",
    "voltage",
    "strain gauge",
];
/// Words for a reference, which may stand before an axis.
const REFERENCES: [&str; 6] = ["ati", "reference", "referenz", "ref", "applied", "true"];
/// In lower case.
const FORCES: [&str; 9] =
    ["f", "force", "kraft", "fuerza", "forza", "força", "forca", "力", "荷重"];
/// In lower case.
const MOMENTS: [&str; 14] = [
    "m",
    "t",
    "moment",
    "torque",
    "drehmoment",
    "couple",
    "momento",
    "coppia",
    "binário",
    "力矩",
    "扭矩",
    "转矩",
    "トルク",
    "モーメント",
];
/// Words that may stand before the letter of a direction.
const BEFORE_DIRECTION: [&str; 8] = ["", "in", "en", "axe", "eje", "asse", "eixo", "axis"];
/// Words that may stand after the letter of a direction.
const AFTER_DIRECTION: [&str; 9] =
    ["", "axis", "achse", "richtung", "direction", "轴", "軸", "方向", "向"];

/// Words for a load that give no axis, in lower case. The words for forces and moments count too.
const LOADS: [&str; 6] = ["load", "last", "weight", "effort", "carico", "carga"];

/// Returns true if one of these words names a load of any axis.
pub(super) fn is_load(words: &[&str]) -> bool {
    let of_axis =
        |word: &str| matches!(word, "fx" | "fy" | "fz" | "mx" | "my" | "mz" | "tx" | "ty" | "tz");
    let is_word = |word: &&str| {
        let long = |own: &&str| own.len() > 1 && *own == *word;
        FORCES.iter().chain(&MOMENTS).chain(&LOADS).any(long) || of_axis(word)
    };
    // The raw signal of a load cell is a gauge.
    if words.contains(&"cell") {
        return false;
    }
    // In "F_ref" and "ref_F", a single letter beside a word for the reference names a load.
    let has_reference = words.iter().any(|word| REFERENCES.contains(word));
    words.iter().any(is_word)
        || (has_reference && words.iter().any(|word| ["f", "m"].contains(word)))
}

/// Names of auxiliary channels, in lower case: temperature, humidity, supply voltage.
const AUXILIARIES: [&str; 38] = [
    "temperature",
    "temp",
    "temperatur",
    "température",
    "temperatura",
    "温度",
    "celsius",
    "kelvin",
    "degc",
    "humidity",
    "rh",
    "feuchte",
    "luftfeuchte",
    "luftfeuchtigkeit",
    "humidité",
    "humedad",
    "umidità",
    "umidade",
    "湿度",
    "supply",
    "excitation",
    "vsup",
    "vsupply",
    "vexc",
    "vcc",
    "vdd",
    "vbat",
    "speisung",
    "speisespannung",
    "versorgung",
    "versorgungsspannung",
    "alimentation",
    "alimentación",
    "alimentazione",
    "alimentação",
    "电源",
    "電源",
    "電源電圧",
];
/// Words beside the name of an auxiliary channel that make it something else: a corrected load, a setpoint, a time of day.
const NOT_MEASURED: [&str; 10] = [
    "compensated",
    "comp",
    "corrected",
    "compensation",
    "setpoint",
    "target",
    "status",
    "time",
    "error",
    "soll",
];

/// Returns true if one of the words of a name, in lower case and without numbers, names an auxiliary channel.
pub(super) fn is_auxiliary(words: &[&str]) -> bool {
    let has = |list: &[&str]| words.iter().any(|word| list.contains(word));
    has(&AUXILIARIES) && !has(&NOT_MEASURED)
}

pub(super) fn is_time(plain: &str) -> bool {
    TIMES.contains(&plain)
}

/// Returns the stem before a gauge's number, in lower case.
pub(super) fn gauge_stem(name: &str) -> Option<String> {
    let start = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let n_digits = name.len() - start.len();
    let start = start.strip_suffix(['_', ' ', '-']).unwrap_or(start);
    let stem = start.to_lowercase();
    ((1..=9).contains(&n_digits) && GAUGES.contains(&stem.as_str())).then_some(stem)
}

/// Returns the first three axes for the name of a force, the last three for the name of a moment.
pub(super) fn axes_of_quantity(word: &str) -> Option<&'static [Axis]> {
    if FORCES.contains(&word) {
        Some(&Axis::ALL[..3])
    } else if MOMENTS.contains(&word) {
        Some(&Axis::ALL[3..])
    } else {
        None
    }
}

/// Returns the axis of a name in lower case without separators: `fx`, `momentx`, `xkraft`, `x方向力`.
pub(super) fn axis_of(plain: &str) -> Option<Axis> {
    let without_reference = REFERENCES.iter().find_map(|reference| plain.strip_prefix(reference));
    let bare = without_reference.unwrap_or(plain);
    let all = FORCES.iter().chain(&MOMENTS);
    let mut found = all.filter_map(|word| {
        let axes = axes_of_quantity(word)?;
        let is_letter = word.len() == 1;
        let after = bare.strip_prefix(word).and_then(|rest| match is_letter {
            true => letter(rest),
            // The symbol may follow the word, as in `Kraft Fx`.
            false => direction(rest).or_else(|| {
                let symbol = FORCES.iter().chain(&MOMENTS).filter(|own| own.len() == 1);
                let of_same = |own: &&&str| axes_of_quantity(own) == Some(axes);
                let rest = |own: &&str| letter(rest.strip_prefix(*own)?);
                symbol.filter(of_same).find_map(rest)
            }),
        });
        let before = || direction(bare.strip_suffix(word).filter(|_| !is_letter)?);
        Some(axes[after.or_else(before)?])
    });
    found.next()
}

fn letter(text: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|letter| *letter == text)
}

/// Returns the direction (0 to 2) of a plain text.
pub(super) fn direction(text: &str) -> Option<usize> {
    let of = |before: &str, after: &str| letter(text.strip_prefix(before)?.strip_suffix(after)?);
    let mut found = BEFORE_DIRECTION.iter().flat_map(|before| {
        let mut after = AFTER_DIRECTION.iter();
        after.find_map(|after| of(before, after))
    });
    found.next()
}
