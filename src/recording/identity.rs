//! Which sensor it is, who calibrated it, when, and against what: everything that a certificate says beside numbers.
//!
//! Guarantees: each item is described once, in [`Item`]; files, form, exports and certificate are printed from that list. Nothing
//! has to be entered.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use strum::{EnumIter, IntoEnumIterator as _};

use crate::recording::Axis;
use crate::recording::units::{force_in_newtons, moment_in_newton_metres};
use crate::small_file::read_small;

/// No description of a sensor is longer.
const BYTES_LIMIT: u64 = 1 << 20;

/// One thing to know of a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, EnumIter)]
#[expect(missing_docs, reason = "their texts say what they are")]
pub enum Item {
    Manufacturer,
    Model,
    Serial,
    Customer,
    Certificate,
    Laboratory,
    Place,
    Country,
    Date,
    Operator,
    Approver,
    Temperature,
    Humidity,
    Procedure,
    Remarks,
    Reference,
    ReferenceSerial,
    ReferenceCertificate,
    ReferenceUncertainty,
}

/// What is said of an item: its name in files, its label, the heading that it stands under, and what to enter.
struct Texts(&'static str, &'static str, &'static str, &'static str);

impl Item {
    /// All of them, in the order in which they are shown.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::iter()
    }

    fn texts(self) -> Texts {
        use Item::*;
        match self {
            Manufacturer => Texts(
                "manufacturer",
                "Manufacturer",
                SENSOR,
                "who made the sensor",
            ),
            Model => Texts("model", "Model", SENSOR, "its type or part number"),
            Serial => Texts("serial", "Serial number", SENSOR, "which one it is"),
            Customer => Texts(
                "customer",
                "Customer",
                ORDER,
                "whom the certificate is for, with the address",
            ),
            Certificate => Texts(
                "certificate",
                "Certificate number",
                ORDER,
                "the number of this certificate",
            ),
            Laboratory => Texts(
                "laboratory",
                "Laboratory",
                ORDER,
                "who calibrates, with the address",
            ),
            Place => Texts(
                "place",
                "Place of calibration",
                ORDER,
                "where, if not at the laboratory's address",
            ),
            Country => Texts(
                "country",
                "Country",
                ORDER,
                "two letters, as DE; a machine-readable certificate needs it",
            ),
            Date => Texts("date", "Date of calibration", ORDER, "as 2026-03-31"),
            Operator => Texts("operator", "Calibrated by", ORDER, "who measured"),
            Approver => Texts("approver", "Approved by", ORDER, "who signs for it"),
            Temperature => Texts(
                "temperature",
                "Temperature",
                CONDITIONS,
                "with its unit, as (23 ± 1) °C",
            ),
            Humidity => Texts("humidity", "Relative humidity", CONDITIONS, "as (45 ± 5) %"),
            Reference => Texts(
                "reference",
                "Reference standard",
                TRACEABILITY,
                "what the loads were measured or made with",
            ),
            ReferenceSerial => Texts(
                "reference_serial",
                "Its serial number",
                TRACEABILITY,
                "which one it is",
            ),
            ReferenceCertificate => Texts(
                "reference_certificate",
                "Its certificate",
                TRACEABILITY,
                "number, laboratory and date of its own calibration",
            ),
            ReferenceUncertainty => Texts(
                "reference_uncertainty",
                "Its uncertainty (k = 2)",
                TRACEABILITY,
                "expanded uncertainty of the reference load: 0.05 % of full scale for every axis, or by axis, as Fx 0.2 N, Mz 0.004 N·m",
            ),
            Procedure => Texts(
                "procedure",
                "Procedure",
                CONDITIONS,
                "the document that the calibration follows",
            ),
            Remarks => Texts(
                "remarks",
                "Remarks",
                CONDITIONS,
                "whatever else belongs on the certificate",
            ),
        }
    }

    /// What files call it.
    pub fn key(self) -> &'static str {
        self.texts().0
    }

    /// Its name, for people.
    pub fn label(self) -> &'static str {
        self.texts().1
    }

    /// The heading that it stands under.
    pub fn heading(self) -> &'static str {
        self.texts().2
    }

    /// What to enter.
    pub fn hint(self) -> &'static str {
        self.texts().3
    }

    fn named(key: &str) -> Option<Self> {
        Self::all().find(|item| item.key() == key)
    }
}

const SENSOR: &str = "Sensor";
const ORDER: &str = "Calibration";
const CONDITIONS: &str = "Conditions and procedure";
const TRACEABILITY: &str = "Traceability";

/// What somebody entered; an item that is not there was not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Identity(BTreeMap<Item, String>);

impl Identity {
    /// What was entered, blank where nothing was.
    pub fn get(&self, item: Item) -> &str {
        self.0.get(&item).map_or("", String::as_str)
    }

    /// Enters it.
    pub fn set(&mut self, item: Item, text: impl Into<String>) {
        let text = text.into();
        match text.trim().is_empty() {
            true => self.0.remove(&item),
            false => self.0.insert(item, text),
        };
    }

    /// Whether nothing was entered.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What was entered, in order.
    pub fn entered(&self) -> impl Iterator<Item = (Item, &str)> {
        self.0.iter().map(|(item, text)| (*item, text.trim()))
    }

    /// This with what `other` says in its place.
    pub fn with(&self, other: &Self) -> Self {
        let both = self.0.iter().chain(&other.0);
        Self(both.map(|(item, text)| (*item, text.clone())).collect())
    }

    /// The expanded uncertainty (k = 2) of the reference on each axis, in its unit; `None` where it was not entered.
    ///
    /// # Errors
    /// A sentence where what was entered cannot be understood.
    pub fn reference_uncertainty(
        &self,
        axes: &[Axis],
        full_scale: &[f64],
    ) -> Result<Vec<Option<f64>>, String> {
        let text = self.get(Item::ReferenceUncertainty);
        uncertainty(text, axes, full_scale).ok_or_else(|| {
            let names: Vec<String> = axes.iter().map(|axis| format!("{} 0.1 {}", axis.symbol(), axis.unit())).collect();
            format!(
                "the uncertainty of the reference, {text:?}, is neither a share of full scale, as 0.05 %, nor one by axis, as {}",
                names.join(", ")
            )
        })
    }
}

/// `None` where it is not understood.
fn uncertainty(text: &str, axes: &[Axis], full_scale: &[f64]) -> Option<Vec<Option<f64>>> {
    let number = |text: &str| {
        text.trim()
            .parse::<f64>()
            .ok()
            .filter(|own| own.is_finite() && *own >= 0.0)
    };
    if text.trim().is_empty() {
        return Some(vec![None; axes.len()]);
    }
    let text = text.trim().to_lowercase();
    let whole = [
        "for every axis",
        "for all axes",
        "of every axis",
        "on every axis",
        "on all axes",
    ];
    let text = whole
        .iter()
        .find_map(|end| text.strip_suffix(end))
        .unwrap_or(&text)
        .trim();
    if let Some((share, of)) = text.split_once('%') {
        let is_known = [
            "",
            "fs",
            "of fs",
            "of full scale",
            "full scale",
            "f.s.",
            "fso",
        ]
        .contains(&of.trim());
        // A decimal comma can be nothing else here.
        let share = number(&share.replace(',', ".")).filter(|_| is_known)? / 100.0;
        return Some(full_scale.iter().map(|full| Some(share * full)).collect());
    }
    if let Some((value, unit)) = text.split_once(' ')
        && let Some(value) = number(&value.replace(',', "."))
    {
        // One load stands for all axes that have its unit.
        let of_axis = |axis: &Axis| Some(value * factor_of(unit.trim(), *axis)?);
        let found: Vec<Option<f64>> = axes.iter().map(of_axis).collect();
        return found.iter().any(Option::is_some).then_some(found);
    }
    let mut found = vec![None; axes.len()];
    for part in text.split([',', ';']) {
        let mut words = part.split_whitespace();
        let symbol = words.next()?;
        let axis = Axis::ALL.into_iter().find(|axis| {
            let other = axis.symbol().replace('M', "T");
            symbol.eq_ignore_ascii_case(axis.symbol()) || symbol.eq_ignore_ascii_case(&other)
        })?;
        let value = number(words.next()?)?;
        let factor = words
            .next()
            .map_or(Some(1.0), |unit| factor_of(unit, axis))?;
        if words.next().is_some() {
            return None;
        }
        if let Some(at) = axes.iter().position(|own| *own == axis) {
            found[at] = Some(factor * value);
        }
    }
    Some(found)
}

/// What a unit of a load on this axis is in that of the axis; `None` of any other unit.
fn factor_of(unit: &str, axis: Axis) -> Option<f64> {
    match axis.is_force() {
        true => force_in_newtons(unit),
        false => moment_in_newton_metres(unit),
    }
}

impl Serialize for Identity {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(item, text)| (item.key(), text)))
    }
}

/// A text, a number or a day: whoever writes `serial = 4711` means it.
#[derive(Deserialize)]
#[serde(untagged)]
enum Entered {
    Text(String),
    Whole(i64),
    Number(f64),
    Day(toml::value::Datetime),
}

impl Entered {
    fn text(self) -> String {
        match self {
            Self::Text(text) => text,
            Self::Whole(number) => number.to_string(),
            Self::Number(number) => number.to_string(),
            Self::Day(day) => day.to_string(),
        }
    }
}

impl<'de> Deserialize<'de> for Identity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let entered = BTreeMap::<String, Entered>::deserialize(deserializer)?;
        let mut identity = Self::default();
        for (key, value) in entered {
            let item = Item::named(&key).ok_or_else(|| {
                let known: Vec<&str> = Item::all().map(Item::key).collect();
                serde::de::Error::custom(format!("{key} is not one of {}", known.join(", ")))
            })?;
            identity.set(item, value.text());
        }
        Ok(identity)
    }
}

/// What `sensor.toml` holds: who the sensor is, and its rated loads.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorFile {
    /// Who it is.
    pub identity: Identity,
    /// Its rated loads, each in the unit of its axis.
    pub rated_loads: BTreeMap<Axis, f64>,
}

/// Why a description of a sensor cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct SensorFileError {
    path: String,
    reason: String,
}

impl SensorFile {
    /// Reads a file like
    ///
    /// ```toml
    /// serial = "FT-0042"
    /// date = 2026-03-31
    /// reference_uncertainty = "0.05 %"
    /// [rated_loads]
    /// Fx = 100
    /// ```
    ///
    /// # Errors
    /// [`SensorFileError`] if it cannot be read, is no TOML, or has a name that is not known.
    pub fn read(path: &Path) -> Result<Self, SensorFileError> {
        let wrong = |reason: String| SensorFileError {
            path: path.display().to_string(),
            reason,
        };
        let text = read_small(path, "a description of a sensor", BYTES_LIMIT)
            .map_err(|error| wrong(error.to_string()))?;
        let text = String::from_utf8(text).map_err(|_| wrong("not in UTF-8".to_owned()))?;
        Self::from_toml(&text).map_err(wrong)
    }

    fn from_toml(text: &str) -> Result<Self, String> {
        // Of the parser's words the first line says where, the last what.
        let told = |error: toml::de::Error| error.to_string().trim().replace('\n', " ");
        let mut table: toml::Table = toml::from_str(text).map_err(told)?;
        let rated = table.remove("rated_loads");
        let rated: BTreeMap<Axis, f64> = match rated {
            Some(value) => value
                .try_into()
                .map_err(|error| format!("rated_loads: {}", told(error)))?,
            None => BTreeMap::new(),
        };
        if let Some((axis, load)) = rated
            .iter()
            .find(|(_, load)| !(load.is_finite() && **load > 0.0))
        {
            return Err(format!(
                "rated_loads: {load} of {} is not a load above zero",
                axis.symbol()
            ));
        }
        let identity: Identity = toml::Value::Table(table).try_into().map_err(told)?;
        // What nobody understands would be left out of U.
        identity.reference_uncertainty(&Axis::ALL, &[1.0; Axis::ALL.len()])?;
        Ok(Self {
            identity,
            rated_loads: rated,
        })
    }

    /// Puts the rated loads in the place of full scales that nobody entered.
    pub fn rate(&self, axes: &[Axis], full_scale: &mut Vec<Option<f64>>) {
        if self.rated_loads.is_empty() {
            return;
        }
        full_scale.resize(axes.len(), None);
        for (own, axis) in full_scale.iter_mut().zip(axes) {
            *own = own.or(self.rated_loads.get(axis).copied());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_description_is_read_as_somebody_would_write_it() {
        let read = SensorFile::from_toml(
            "serial = 4711\ndate = 2026-03-31\ntemperature = \"(23 ± 1) °C\"\ncustomer = \"  \"\n[rated_loads]\nFz = 200\nMx = 2.5",
        );
        let read = read.unwrap();
        let entered: Vec<_> = read
            .identity
            .entered()
            .map(|(item, text)| (item.key(), text))
            .collect();
        assert_eq!(
            entered,
            [
                ("serial", "4711"),
                ("date", "2026-03-31"),
                ("temperature", "(23 ± 1) °C")
            ]
        );
        let mut full_scale = vec![None, Some(7.0)];
        read.rate(&[Axis::Fz, Axis::Mx, Axis::My], &mut full_scale);
        assert_eq!(full_scale, [Some(200.0), Some(7.0), None]);
        let json = serde_json::to_string(&read.identity).unwrap();
        assert_eq!(
            serde_json::from_str::<Identity>(&json).unwrap(),
            read.identity
        );
    }

    #[test]
    fn what_is_not_known_is_named() {
        let wrong = |text: &str| SensorFile::from_toml(text).unwrap_err();
        assert!(wrong("seriel = 1").contains("seriel is not one of manufacturer, model, serial"));
        assert!(wrong("[rated_loads]\nFx = -3").contains("-3 of Fx"));
        assert!(wrong("[rated_loads]\nFq = 3").contains("Fq"));
        assert!(wrong("serial = ").contains("line 1"));
        assert!(wrong("reference_uncertainty = 'small'").contains("neither a share"));
    }

    #[test]
    fn the_uncertainty_of_the_reference_is_a_share_or_stands_by_axis() {
        let axes = [Axis::Fx, Axis::Mz];
        let of = |text: &str| {
            let mut identity = Identity::default();
            identity.set(Item::ReferenceUncertainty, text);
            identity.reference_uncertainty(&axes, &[200.0, 4.0])
        };
        assert_eq!(of(""), Ok(vec![None, None]));
        assert_eq!(of("0.05 %"), Ok(vec![Some(0.1), Some(0.002)]));
        assert_eq!(of("Fx 0.2 N, Tz 4 N·mm"), Ok(vec![Some(0.2), Some(0.004)]));
        assert_eq!(of("Mz 0.01"), Ok(vec![None, Some(0.01)]));
        for share in [
            "0.05 % of full scale for every axis",
            "0,05 %",
            "0.05% FS",
            "0.05 % of FS",
        ] {
            assert_eq!(of(share), of("0.05 %"), "{share}");
        }
        assert_eq!(
            of("0.1 N"),
            Ok(vec![Some(0.1), None]),
            "all axes of that unit"
        );
        assert_eq!(of("4 Nmm"), Ok(vec![None, Some(0.004)]));
        for wrong in ["good", "Fx", "Fx 1 N·m", "-1 %", "Fx nan N"] {
            assert!(
                of(wrong)
                    .unwrap_err()
                    .contains("0.05 %, nor one by axis, as Fx 0.1 N, Mz 0.1 N·m"),
                "{wrong}"
            );
        }
    }
}
