//! Words for times, gauges and loads in column names, in the languages of the people who write headers.

use crate::recording::Axis;

/// Maximum length of a column name that is compared with the words of this file (bytes).
pub const LONGEST: usize = 64;

/// Names of a time column, in lower case without separators. A unit of time alone, such as `ms`, also names a time column,
/// but a single `s` does not.
pub const TIMES: &str = "\
    t time times timestamp timestamps stamp elapsed elapsedtime epoch unixtime unixtimestamp %time zeit zeitstempel tiempo tempo \
    时间 時間 時刻";
/// Words that name a gauge if a number follows, in lower case. `strain gauge` is compared separately.
const GAUGES: &str = "\
    s sg stg g gauge ch chan channel ai u v raw strain sensor adc a coinft_raw coinft dms dehnung kanal jauge voie \
    galga canal canale estensimetro extensometro extensômetro 通道 应变 应变片 ひずみ チャンネル bridge brücke \
    bruecke messbrücke pont puente ponte voltage";
/// Words for the reference sensor that may stand in front of a load axis.
pub const REFERENCES: &str = "ati reference referenz ref applied true";
/// Words for a force in column names, in lower case; symbols of one letter first.
pub const FORCES: &str =
    "f force kraft fuerza forza força forca síla siła erő kuvvet сила усилие δύναμη 力 荷重";
/// Words for a moment in column names, in lower case; symbols of one letter first.
pub const MOMENTS: &str =
    "m t moment torque drehmoment couple momento coppia binário 力矩 扭矩 转矩 トルク モーメント";
/// Words that may stand in front of the letter x, y or z of a load axis, as in `axis x`.
const BEFORE_DIRECTION: &str = "in en axe eje asse eixo axis";
/// Words that may stand behind the letter x, y or z of a load axis, as in `x axis`.
const AFTER_DIRECTION: &str = "axis achse richtung direction 轴 軸 方向 向";
/// Words for a load whose axis is unknown, in lower case, besides the words for forces and moments.
pub const LOADS: &str = "load last thrust schub weight effort carico carga mass masse gewicht peso poids massa masa нагрузка масса вес φορτίο 质量 重量";
/// Words among [`LOADS`] for a mass. The load is then the weight of the mass.
pub const MASSES: &str = "mass masse weight gewicht peso poids massa masa масса вес 质量 重量";
/// Words in names of raw signals. A name with one of them and a word for a load, such as `load cell`, is the name of a gauge.
pub const RAW: &str = "cell raw adc counts count code zelle";
/// Words for an electrical signal, besides [`RAW`].
pub const SIGNALS: &str = "voltage spannung tension";
/// Words for a time anywhere in a column name, besides words that end in `time` or `zeit`.
pub const CLOCKS: &str = "\
    time times timestamp timestamps stamp elapsed epoch clock zeit zeitstempel uhrzeit tiempo tempo temps czas čas cas tid \
    tijd aika время χρόνος zaman idő idö thời chrono 时间 時間 时刻 時刻 시간";
/// Words for a count of rows, cycles or frames.
pub const COUNTERS: &str = "\
    index idx frame frames cycle cycles row rows id step seq sequence nr no num number trial packet line point sample samples \
    iteration zyklus zyklen nummer n 循环计数";
/// Words for the channel, the device or the place that the values of a row belong to.
pub const IDENTIFIERS: &str = "\
    channel sensor device cell loadcell scale node signal quantity variable parameter field tag name id mac topic side leg foot \
    kanal gerät waage";
/// Words for a displacement. A column with such a name is read as a gauge only if the name also has a word for a gauge.
pub const DISPLACEMENTS: &str = "\
    displacement extension position travel stroke deflection weg traversenweg crosshead rotation angle winkel drehwinkel pos \
    distance déplacement desplazamiento spostamento";
/// Words for the spread of values, for an error and for a stress, which are no signals.
pub const SPREADS: &str = "std stdev stddev sd sigma var variance stress error fehler erreur";
/// Words for a strain, and the units that it may have.
pub const STRAINS: &str =
    "strain dehnung verformung deformación déformation 应变 压缩应变 拉伸应变 ひずみ";
pub const STRAIN_UNITS: &str = "% - 1 mm/mm m/m in/in";
/// Units of quantities that are neither a load nor the signal of a gauge, in lower case. Ratios such as `mm/s` count too.
pub const OTHER_UNITS: &str = "\
    mm cm m um µm μm nm km in inch deg degree degrees ° rad % - mpa kpa pa gpa bar mbar psi °c degc ℃ °f hz rpm w kw db dbm byte bytes";
/// Words for auxiliary channels in column names, in lower case: temperature, humidity, supply voltage.
pub const AUXILIARIES: &str = "\
    temperature temp temperatur température temperatura 温度 celsius kelvin degc humidity rh feuchte luftfeuchte \
    luftfeuchtigkeit humidité humedad umidità umidade 湿度 supply excitation vsup vsupply vexc vcc vdd vbat speisung \
    speisespannung versorgung versorgungsspannung alimentation alimentación alimentazione alimentação 电源 電源 \
    電源電圧";
/// Words that rule out an auxiliary channel, whatever the other words of the name: a corrected load, a setpoint, a time of
/// day.
pub const NOT_MEASURED: &str =
    "compensated comp corrected compensation setpoint target status time error soll";

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Time,
    Gauge,
    Load(Axis),
}

/// Returns true if a list of words, separated by blanks, contains this word.
pub fn is_one_of(word: &str, list: &str) -> bool {
    list.split(' ').any(|listed| listed == word)
}

pub fn plain(name: &str) -> String {
    name.to_lowercase().replace(['_', ' '], "")
}

/// Returns the kind of a column from its name alone, without a path in front and without a unit behind it.
pub fn plain_kind(name: &str) -> Option<Kind> {
    if name.len() > LONGEST {
        return None;
    }
    let plain = plain(name);
    if is_one_of(&plain, TIMES) {
        Some(Kind::Time)
    } else if gauge_stem(name).is_some() {
        Some(Kind::Gauge)
    } else {
        axis_of(&plain.replace('-', "")).map(Kind::Load)
    }
}

/// Words for a quantity in column names.
const QUANTITIES: [&str; 9] =
    [TIMES, GAUGES, FORCES, MOMENTS, LOADS, CLOCKS, COUNTERS, DISPLACEMENTS, AUXILIARIES];

/// Returns true if one of the words means a quantity.
pub fn are_known(words: &[&str]) -> bool {
    has(words, &QUANTITIES)
}

/// Returns true if one of the words is in one of the lists.
pub fn has(words: &[&str], lists: &[&str]) -> bool {
    words.iter().any(|word| lists.iter().any(|list| is_one_of(word, list)))
}

/// Returns true if the words of a name mean a load, whose axis they need not tell.
pub fn is_load(words: &[&str]) -> bool {
    let long: Vec<&str> = words.iter().copied().filter(|word| word.len() > 1).collect();
    // The raw signal of a load cell is a gauge, not a load. A letter next to a word for the reference, as in "F_ref", names a
    // load.
    !has(words, &[RAW])
        && (has(&long, &[FORCES, MOMENTS, LOADS])
            || has(words, &["fx fy fz mx mz"]) && !is_counter(words)
            || has(words, &[REFERENCES]) && has(words, &["f m"]))
}

/// Returns true if one of the words means a time.
pub fn is_clock(words: &[&str]) -> bool {
    let ends_so = |word: &&str| word.ends_with("time") || word.ends_with("zeit");
    has(words, &[CLOCKS]) || words.iter().any(|word| word.len() > 4 && ends_so(word))
}

/// Returns true if one of the words means a count. A single letter may be a unit, as in `factor_N_per_mm`.
pub fn is_counter(words: &[&str]) -> bool {
    let is_it = |word: &&str| is_one_of(word, COUNTERS) && (word.len() > 1 || words.len() == 1);
    words.iter().any(is_it)
}

/// Returns the word in front of the number in a gauge's name, in lower case; `None` if the name is not that of a gauge.
pub fn gauge_stem(name: &str) -> Option<String> {
    let start = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let n_digits = name.len() - start.len();
    let stem = start.strip_suffix(['_', ' ', '-']).unwrap_or(start).to_lowercase();
    let is_gauge = is_one_of(&stem, GAUGES) || stem == "strain gauge";
    ((1..=9).contains(&n_digits) && is_gauge).then_some(stem)
}

fn quantities() -> [(&'static str, &'static [Axis]); 2] {
    [(FORCES, &Axis::ALL[..3]), (MOMENTS, &Axis::ALL[3..])]
}

/// Returns the axes Fx, Fy, Fz for a word that means force, and Mx, My, Mz for a word that means moment.
pub fn axes_of_quantity(word: &str) -> Option<&'static [Axis]> {
    let found = quantities().into_iter().find(|(words, _)| is_one_of(word, words));
    found.map(|(_, axes)| axes)
}

/// Returns the load axis of a column name, which is in lower case without separators: `fx`, `momentx`, `xkraft`, `x方向力`.
pub fn axis_of(plain: &str) -> Option<Axis> {
    // The controllers of UR number the parts of the wrench.
    let numbered = plain.strip_prefix("actual").unwrap_or(plain).strip_prefix("tcpforce");
    if let Some(number) = numbered {
        return Axis::ALL.get(number.parse::<usize>().ok()?).copied();
    }
    let bare = REFERENCES.split(' ').find_map(|word| plain.strip_prefix(word)).unwrap_or(plain);
    quantities().into_iter().find_map(|(words, axes)| {
        let (symbols, long): (Vec<&str>, Vec<&str>) =
            words.split(' ').partition(|word| word.len() == 1);
        let of_symbol =
            |text: &str| symbols.iter().find_map(|symbol| letter(text.strip_prefix(*symbol)?));
        let of_word = |word: &&str| {
            // A symbol such as `Fx` may follow the word, as in `Kraft Fx`.
            let of_rest = |rest| direction(rest).or_else(|| of_symbol(rest));
            let after = bare.strip_prefix(*word).and_then(of_rest);
            after.or_else(|| direction(bare.strip_suffix(*word)?))
        };
        of_symbol(bare).or_else(|| long.iter().find_map(of_word)).map(|at| axes[at])
    })
}

fn letter(text: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|letter| *letter == text)
}

/// Returns the direction that a text names: 0 for x, 1 for y, 2 for z.
pub fn direction(text: &str) -> Option<usize> {
    let mut before = BEFORE_DIRECTION.split(' ').chain([""]);
    before.find_map(|before| {
        let rest = text.strip_prefix(before)?;
        let mut after = AFTER_DIRECTION.split(' ').chain([""]);
        after.find_map(|after| letter(rest.strip_suffix(after)?))
    })
}
