//! A sensor's identity: which one it is, who calibrated it, when, and against what.
//!
//! Guarantees: each item is described once, in [`Item`]; files, form, exports and report follow from that list. Nothing has to be
//! entered.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use strum::{EnumIter, IntoEnumIterator as _, IntoStaticStr};

use crate::recording::axis::Axis;
use crate::small_file::{TomlError, read_toml};

/// One item of a sensor's identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, EnumIter, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[expect(missing_docs, reason = "their texts say what they are")]
pub enum Item {
    Manufacturer,
    Model,
    Serial,
    Date,
    Operator,
    Temperature,
    Reference,
    ReferenceUncertainty,
    Notes,
}

impl Item {
    /// All of them, in the order in which they are shown.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::iter()
    }

    /// Returns the label, and what to enter.
    fn texts(self) -> [&'static str; 2] {
        match self {
            Self::Manufacturer => ["Manufacturer", "who made the sensor"],
            Self::Model => ["Model", "its type or part number"],
            Self::Serial => ["Serial number", "which one it is"],
            Self::Date => ["Date of calibration", "as 2026-03-31"],
            Self::Operator => ["Calibrated by", "who measured"],
            Self::Temperature => ["Temperature", "with its unit, as (23 ± 1) °C"],
            Self::Reference => [
                "Reference standard",
                "what the loads were measured or made with, and its certificate",
            ],
            Self::ReferenceUncertainty => [
                "Its stated uncertainty",
                "as its certificate states it, such as 0.05 % of full scale (k = 2)",
            ],
            Self::Notes => ["Notes", "anything else that belongs to the calibration"],
        }
    }

    /// Returns the name in files.
    pub fn key(self) -> &'static str {
        self.into()
    }

    /// Returns the name for people.
    pub fn label(self) -> &'static str {
        self.texts()[0]
    }

    /// Returns what to enter.
    pub fn hint(self) -> &'static str {
        self.texts()[1]
    }

    fn named(key: &str) -> Option<Self> {
        Self::all().find(|item| item.key() == key)
    }
}

/// What the user entered; an item that is not there was not entered.
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
        if text.trim().is_empty() {
            self.0.remove(&item)
        } else {
            self.0.insert(item, text)
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
    /// [`TomlError`] if it cannot be read, is no TOML, or has a name that is not known.
    pub fn read(path: &Path) -> Result<Self, TomlError> {
        read_toml(path, "a description of a sensor", Self::from_toml)
    }

    fn from_toml(text: &str) -> Result<Self, String> {
        // Of the parser's words the first line says where, the last what.
        let told = |error: toml::de::Error| error.to_string().trim().replace('\n', " ");
        let mut table: toml::Table = toml::from_str(text).map_err(told)?;
        let rated = table.remove("rated_loads");
        let rated: BTreeMap<Axis, f64> = match rated {
            Some(value) => {
                value.try_into().map_err(|error| format!("rated_loads: {}", told(error)))?
            }
            None => BTreeMap::new(),
        };
        if let Some((axis, load)) =
            rated.iter().find(|(_, load)| !(load.is_finite() && **load > 0.0))
        {
            return Err(format!(
                "rated_loads: {load} of {} is not a load above zero",
                axis.symbol()
            ));
        }
        let identity: Identity = toml::Value::Table(table).try_into().map_err(told)?;
        Ok(Self { identity, rated_loads: rated })
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
            "serial = 4711\ndate = 2026-03-31\ntemperature = \"(23 ± 1) °C\"\nnotes = \"  \"\n[rated_loads]\nFz = 200\nMx = 2.5",
        );
        let read = read.unwrap();
        let entered: Vec<_> =
            read.identity.entered().map(|(item, text)| (item.key(), text)).collect();
        assert_eq!(
            entered,
            [("serial", "4711"), ("date", "2026-03-31"), ("temperature", "(23 ± 1) °C")]
        );
        let mut full_scale = vec![None, Some(7.0)];
        read.rate(&[Axis::Fz, Axis::Mx, Axis::My], &mut full_scale);
        assert_eq!(full_scale, [Some(200.0), Some(7.0), None]);
        let json = serde_json::to_string(&read.identity).unwrap();
        assert_eq!(serde_json::from_str::<Identity>(&json).unwrap(), read.identity);
    }

    #[test]
    fn what_is_not_known_is_named() {
        let wrong = |text: &str| SensorFile::from_toml(text).unwrap_err();
        assert!(wrong("seriel = 1").contains("seriel is not one of manufacturer, model, serial"));
        assert!(wrong("[rated_loads]\nFx = -3").contains("-3 of Fx"));
        assert!(wrong("[rated_loads]\nFq = 3").contains("Fq"));
        assert!(wrong("serial = ").contains("line 1"));
    }
}
