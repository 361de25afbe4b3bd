//! Units in files, and their factors to SI units. An unknown spelling of a unit gives `None`. Upper and lower case are the
//! same, except where they distinguish milli from mega.

/// Names of the known units, for the message about an unknown unit. The next two lists serve the same purpose.
pub const FORCE_UNITS: &str = "N, kN, MN, mN, µN, daN, cN, lbf, klbf, ozf, kgf, gf, kp; masses as weights: kg, g, mg, t, lb, oz";
pub const MOMENT_UNITS: &str = "N·m, N·mm, N·cm, mN·m, kN·m, lbf·in, lbf·ft, ozf·in, kgf·m, kgf·cm, gf·cm (also written Nm, N-m, N.m, N*m)";

pub const ANGLE_UNITS: &str = "rad, deg";

const POUND_FORCE: f64 = 4.448_221_615_260_5;
const KILOGRAM_FORCE: f64 = 9.806_65;
const INCH: f64 = 0.0254;
const FOOT: f64 = 0.3048;

pub fn force_in_newtons(unit: &str) -> Option<f64> {
    if unit.trim() == "MN" {
        return Some(1e6);
    }
    // A mass stands for its weight.
    Some(match plain(unit)?.as_str() {
        "n" | "newton" | "newtons" | "н" => 1.0,
        "kn" | "кн" => 1e3,
        "dan" => 10.0,
        "cn" => 1e-2,
        "mn" => 1e-3,
        "un" | "µn" | "μn" => 1e-6,
        "lbf" | "lb" | "lbs" | "pound" | "pounds" => POUND_FORCE,
        "klbf" | "kip" | "kips" => 1e3 * POUND_FORCE,
        "ozf" | "oz" => POUND_FORCE / 16.0,
        "kgf" | "kp" | "kg" | "кгс" | "кг" => KILOGRAM_FORCE,
        "gf" | "g" | "gram" | "grams" => KILOGRAM_FORCE / 1e3,
        "mg" => KILOGRAM_FORCE / 1e6,
        "t" | "tf" | "ton" | "tonne" => KILOGRAM_FORCE * 1e3,
        _ => return None,
    })
}

pub fn moment_in_newton_metres(unit: &str) -> Option<f64> {
    Some(match plain(unit)?.as_str() {
        "nm" => 1.0,
        "nmm" | "mnm" => 1e-3,
        "ncm" => 1e-2,
        "knm" => 1e3,
        // A pound that is multiplied by a length can only be a pound-force, not a mass.
        "lbfin" | "inlbf" | "lbin" | "inlb" => POUND_FORCE * INCH,
        "lbfft" | "ftlbf" | "lbft" | "ftlb" => POUND_FORCE * FOOT,
        "ozfin" | "inozf" | "ozin" | "inoz" => POUND_FORCE / 16.0 * INCH,
        "kgfm" | "kpm" => KILOGRAM_FORCE,
        "kgfcm" | "kpcm" => KILOGRAM_FORCE / 1e2,
        "kgfmm" => KILOGRAM_FORCE / 1e3,
        "gfcm" => KILOGRAM_FORCE / 1e5,
        _ => return None,
    })
}

pub fn angle_in_radians(unit: &str) -> Option<f64> {
    Some(match unit.trim().to_lowercase().as_str() {
        "rad" | "radian" | "radians" => 1.0,
        "deg" | "degree" | "degrees" | "°" => std::f64::consts::PI / 180.0,
        _ => return None,
    })
}

/// Returns the unit into which the values of an auxiliary channel are converted, and the factor and summand of the
/// conversion. Temperatures become °C, voltages V, humidities %. Values in any other unit are not converted.
pub fn auxiliary_unit(unit: &str) -> (String, f64, f64) {
    let (label, factor, shift) = match closed_up(unit).as_str() {
        "v" | "volt" | "volts" => ("V", 1.0, 0.0),
        "mv" if !unit.contains('M') => ("V", 1e-3, 0.0),
        "%" | "%rh" | "rh" | "%rf" | "%rel" => ("%", 1.0, 0.0),
        _ => match temperature_in_celsius(unit) {
            Some((factor, shift)) => ("°C", factor, shift),
            None => (unit.trim(), 1.0, 0.0),
        },
    };
    (label.to_owned(), factor, shift)
}

/// Returns the factor and the summand that convert a temperature to °C; `None` if the unit is no temperature unit.
pub fn temperature_in_celsius(unit: &str) -> Option<(f64, f64)> {
    const FAHRENHEIT: f64 = 5.0 / 9.0;
    Some(match closed_up(unit).as_str() {
        "°c" | "℃" | "degc" | "degrc" | "c" | "celsius" | "gradc" | "degreesc"
        | "degreescelsius" | "ºc" => (1.0, 0.0),
        "k" | "kelvin" | "°k" | "degk" => (1.0, -273.15),
        "°f" | "℉" | "degf" | "f" | "fahrenheit" | "ºf" => (FAHRENHEIT, -32.0 * FAHRENHEIT),
        _ => return None,
    })
}

fn closed_up(unit: &str) -> String {
    unit.trim().to_lowercase().replace([' ', '_', '.'], "")
}

/// Returns the unit in lower case, without the signs between its factors, such as `·`. `None` if the prefix is mega, which
/// lower case would turn into milli.
fn plain(unit: &str) -> Option<String> {
    const BETWEEN: [char; 9] = ['·', '⋅', '∙', '•', '*', '.', '-', '_', ' '];
    let unit = unit.trim().replace(BETWEEN, "");
    let is_mega = unit.starts_with("MN") || unit.starts_with("Mn");
    (!is_mega).then(|| unit.to_lowercase())
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeUnit {
    Hours,
    Minutes,
    Seconds,
    Milliseconds,
    Microseconds,
    Nanoseconds,
}

impl TimeUnit {
    pub fn from_name(name: &str) -> Option<Self> {
        // Both micro signs are read as u: U+00B5, and the Greek letter that it becomes when text is normalised.
        let name = name.trim().to_lowercase().replace(['\u{b5}', '\u{3bc}'], "u");
        Some(match name.as_str() {
            "h" | "hr" | "hrs" | "hour" | "hours" | "stunden" => Self::Hours,
            "min" | "mins" | "minute" | "minutes" | "minuten" => Self::Minutes,
            "s" | "sec" | "secs" | "second" | "seconds" => Self::Seconds,
            "ms" | "msec" | "msecs" | "millisecond" | "milliseconds" | "millis" => {
                Self::Milliseconds
            }
            "us" | "usec" | "usecs" | "microsecond" | "microseconds" | "micros" => {
                Self::Microseconds
            }
            "ns" | "nsec" | "nsecs" | "nanosec" | "nanosecs" | "nanosecond" | "nanoseconds"
            | "nanos" => Self::Nanoseconds,
            _ => return None,
        })
    }

    /// Returns the number of these time units in one second. Dividing by this number is more exact than multiplying by its
    /// inverse.
    pub const fn per_second(self) -> f64 {
        match self {
            Self::Hours => 1.0 / 3600.0,
            Self::Minutes => 1.0 / 60.0,
            Self::Seconds => 1.0,
            Self::Milliseconds => 1e3,
            Self::Microseconds => 1e6,
            Self::Nanoseconds => 1e9,
        }
    }

    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Hours => "h",
            Self::Minutes => "min",
            Self::Seconds => "s",
            Self::Milliseconds => "ms",
            Self::Microseconds => "us",
            Self::Nanoseconds => "ns",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_become_newtons() {
        for (unit, newtons) in [
            ("N", 1.0),
            ("kN", 1000.0),
            ("mN", 0.001),
            ("lbf", 4.448_221_615_260_5),
            ("kgf", 9.806_65),
            (" gf ", 0.009_806_65),
            ("kp", 9.806_65),
            ("kip", 4_448.221_615_260_5),
            ("ozf", 0.278_013_850_953_781_2),
        ] {
            assert_eq!(force_in_newtons(unit), Some(newtons), "{unit}");
        }
        for unknown in ["", "Mn", "Nm", "bananas"] {
            assert_eq!(force_in_newtons(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn moments_become_newton_metres_in_every_spelling() {
        for unit in ["Nm", "N-m", "N·m", "N⋅m", "N.m", "N*m", "N m", "NM"] {
            assert_eq!(moment_in_newton_metres(unit), Some(1.0), "{unit}");
        }
        for (unit, newton_metres) in [
            ("N·mm", 1e-3),
            ("Ncm", 1e-2),
            ("kN·m", 1e3),
            ("mNm", 1e-3),
            ("lbf-in", 0.112_984_829_027_616_7), // 4.4482216152605 N · 0.0254 m
            ("lbf·ft", 1.355_817_948_331_400_4), // 4.4482216152605 N · 0.3048 m
            ("kgf·cm", 0.098_066_5),
            ("kgf*m", 9.806_65),
            ("gf-cm", 9.806_65e-5),
            ("ft-lb", 1.355_817_948_331_400_4),
            ("oz-in", 0.007_061_551_814_226_043), // 4.4482216152605 N / 16 · 0.0254 m
        ] {
            let factor = moment_in_newton_metres(unit).unwrap();
            assert!((factor - newton_metres).abs() <= 1e-15 * newton_metres, "{unit}");
        }
        for unknown in ["", "N", "MNm", "m"] {
            assert_eq!(moment_in_newton_metres(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn auxiliary_channels_of_one_quantity_have_one_unit() {
        let of = |unit: &str, value: f64| {
            let (label, factor, shift) = auxiliary_unit(unit);
            (label, ((value * factor + shift) * 1e9).round() / 1e9)
        };
        let celsius = |value: f64| ("°C".to_owned(), value);
        assert_eq!(of("degC", 21.5), celsius(21.5));
        assert_eq!(of("K", 300.0), celsius(26.85));
        assert_eq!(of("°F", 212.0), celsius(100.0));
        assert_eq!(of("deg F", 32.0), celsius(0.0));
        assert_eq!(of("mV", 5012.0), ("V".to_owned(), 5.012));
        assert_eq!(of("%RH", 40.0), ("%".to_owned(), 40.0));
        assert_eq!(of("MV", 1.0), ("MV".to_owned(), 1.0));
        assert_eq!(of("hPa", 1013.0), ("hPa".to_owned(), 1013.0));
    }

    #[test]
    fn both_micro_signs_are_microseconds() {
        for name in ["us", "\u{b5}s", "\u{3bc}s", "USEC"] {
            assert_eq!(TimeUnit::from_name(name), Some(TimeUnit::Microseconds));
        }
        for unit in ["s", "ms", "us", "ns", "min", "h"] {
            assert_eq!(TimeUnit::from_name(unit).unwrap().symbol(), unit);
        }
        assert_eq!(TimeUnit::from_name("week"), None);
    }
}
