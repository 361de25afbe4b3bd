//! What times, gauges and loads are called in the languages of those who write headers.

use crate::recording::Axis;

/// Names of a time column, in small letters without separators. A time unit alone, but for the bare `s`, is one too.
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
/// What stands before a gauge's number, in small letters.
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
/// What may stand before an axis of the reference.
const REFERENCES: [&str; 6] = ["ati", "reference", "referenz", "ref", "applied", "true"];
/// What a force is called, in small letters.
const FORCES: [&str; 9] =
    ["f", "force", "kraft", "fuerza", "forza", "força", "forca", "力", "荷重"];
/// What a moment is called, in small letters.
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
/// What may stand before the letter of a direction.
const BEFORE_DIRECTION: [&str; 8] = ["", "in", "en", "axe", "eje", "asse", "eixo", "axis"];
/// What may stand after the letter of a direction.
const AFTER_DIRECTION: [&str; 9] =
    ["", "axis", "achse", "richtung", "direction", "轴", "軸", "方向", "向"];

/// Words for a load that name no axis, in small letters, beside those for forces and moments.
const LOADS: [&str; 6] = ["load", "last", "weight", "effort", "carico", "carga"];

/// Returns true if one of these words names a load, whichever axis it is of.
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
    // "F_ref" and "ref_F": a letter alone says it beside a word for the reference.
    let has_reference = words.iter().any(|word| REFERENCES.contains(word));
    words.iter().any(is_word)
        || (has_reference && words.iter().any(|word| ["f", "m"].contains(word)))
}

/// What a channel is called that is no gauge but moves them, in small letters: temperature, humidity, supply.
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
/// What makes of such a channel something else: a load that was corrected by it, what it should be, when it was measured.
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

/// Whether one of a name's words, in small letters and without the numbers behind them, calls it an auxiliary channel.
pub(super) fn is_auxiliary(words: &[&str]) -> bool {
    let has = |list: &[&str]| words.iter().any(|word| list.contains(word));
    has(&AUXILIARIES) && !has(&NOT_MEASURED)
}

/// Whether a name in small letters without separators is that of a time.
pub(super) fn is_time(plain: &str) -> bool {
    TIMES.contains(&plain)
}

/// What stands before the number of a gauge, in small letters; `None` if this is no gauge's name.
pub(super) fn gauge_stem(name: &str) -> Option<String> {
    let start = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let n_digits = name.len() - start.len();
    let start = start.strip_suffix(['_', ' ', '-']).unwrap_or(start);
    let stem = start.to_lowercase();
    ((1..=9).contains(&n_digits) && GAUGES.contains(&stem.as_str())).then_some(stem)
}

/// Whether a word is that of a force (the first three axes) or of a moment (the last three).
pub(super) fn axes_of_quantity(word: &str) -> Option<&'static [Axis]> {
    if FORCES.contains(&word) {
        Some(&Axis::ALL[..3])
    } else if MOMENTS.contains(&word) {
        Some(&Axis::ALL[3..])
    } else {
        None
    }
}

/// The axis that a name in small letters without separators is of: `fx`, `momentx`, `xkraft`, `x方向力`.
pub(super) fn axis_of(plain: &str) -> Option<Axis> {
    let without_reference = REFERENCES.iter().find_map(|reference| plain.strip_prefix(reference));
    let bare = without_reference.unwrap_or(plain);
    let all = FORCES.iter().chain(&MOMENTS);
    let mut found = all.filter_map(|word| {
        let axes = axes_of_quantity(word)?;
        let is_letter = word.len() == 1;
        let after = bare.strip_prefix(word).and_then(|rest| match is_letter {
            true => letter(rest),
            // `Kraft Fx`
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

/// Which direction a text in small letters without separators names.
pub(super) fn direction(text: &str) -> Option<usize> {
    let of = |before: &str, after: &str| letter(text.strip_prefix(before)?.strip_suffix(after)?);
    let mut found = BEFORE_DIRECTION.iter().flat_map(|before| {
        let mut after = AFTER_DIRECTION.iter();
        after.find_map(|after| of(before, after))
    });
    found.next()
}
