//! Identity of a sensor: manufacturer, serial number, date and operator of the calibration, reference standard. [`Item`]
//! describes each item once, for files, for the form in the window, for exports and for the report. All items are optional.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize};
use strum::{EnumIter, EnumString, IntoEnumIterator as _, IntoStaticStr};

use crate::{
    recording::{axis::Axis, frame::SensorFrame},
    small_file::{TomlError, read_toml},
};

/// One item of a sensor's identity, such as its serial number.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    EnumIter,
    EnumString,
    IntoStaticStr,
)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[expect(missing_docs, reason = "the labels of the items describe them")]
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
    /// Returns all items in the order in which they are shown.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::iter()
    }

    fn texts(self) -> [&'static str; 2] {
        match self {
            Self::Manufacturer => ["Manufacturer", "maker of the sensor"],
            Self::Model => ["Model", "type or part number"],
            Self::Serial => ["Serial number", "as on the sensor's label"],
            Self::Date => ["Date of calibration", "such as 2026-03-31"],
            Self::Operator => ["Calibrated by", "person who measured"],
            Self::Temperature => ["Temperature", "with its unit, such as (23 ± 1) °C"],
            Self::Reference => [
                "Reference standard",
                "device or weights for the reference load, and the certificate",
            ],
            Self::ReferenceUncertainty => [
                "Uncertainty of the reference",
                "as in the certificate, such as 0.05 % of full scale (k = 2)",
            ],
            Self::Notes => ["Notes", "anything else that belongs to the calibration"],
        }
    }

    /// Returns the key under which files store the item, such as `serial`.
    pub fn key(self) -> &'static str {
        self.into()
    }

    /// Returns the label of the item's field in the window.
    pub fn label(self) -> &'static str {
        self.texts()[0]
    }

    /// Returns the text that an empty field shows as an example.
    pub fn placeholder(self) -> &'static str {
        self.texts()[1]
    }
}

/// Identity of a sensor: the items that the user entered.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Identity(BTreeMap<Item, String>);

impl Identity {
    pub fn get(&self, item: Item) -> &str {
        self.0.get(&item).map_or("", String::as_str)
    }

    /// Sets the text of an item, or removes the item if the text is blank.
    pub fn set(&mut self, item: Item, text: impl Into<String>) {
        let text = text.into();
        if text.trim().is_empty() {
            self.0.remove(&item)
        } else {
            self.0.insert(item, text)
        };
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the items that the user entered, in the order in which they are shown.
    pub fn entered(&self) -> impl Iterator<Item = (Item, &str)> {
        self.0.iter().map(|(item, text)| (*item, text.trim()))
    }

    /// Returns the items of both identities. If both contain an item, the text of `other` is used.
    pub fn with(&self, other: &Self) -> Self {
        let both = self.0.iter().chain(&other.0);
        Self(both.map(|(item, text)| (*item, text.clone())).collect())
    }
}

/// Value of an item in TOML: `serial = 4711` and `date = 2026-03-31` are accepted without quotes.
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
            let item = key.parse().map_err(|_| {
                let known: Vec<&str> = Item::all().map(Item::key).collect();
                serde::de::Error::custom(format!(
                    "{key} is not known; use one of {}",
                    known.join(", ")
                ))
            })?;
            identity.set(item, value.text());
        }
        Ok(identity)
    }
}

/// Content of the file `sensor.toml`: the identity of the sensor, its rated loads, and its frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorFile {
    pub identity: Identity,
    /// Rated load of each axis (N, N·m).
    pub rated_loads: BTreeMap<Axis, f64>,
    /// Frame in which the calibration gives loads; `None` for the frame of the reference load.
    pub frame: Option<SensorFrame>,
}

impl SensorFile {
    /// Reads a TOML file with lines like `serial = "FT-0042"`, `date = 2026-03-31`, `[rated_loads]`, `Fx = 100`.
    pub fn read(path: &Path) -> Result<Self, TomlError> {
        read_toml(path, "a file that describes a sensor", Self::from_toml)
    }

    fn from_toml(text: &str) -> Result<Self, String> {
        // The parser's message has several lines, from the place of the fault to the fault itself. They are joined to one
        // line.
        let in_words = |error: toml::de::Error| error.to_string().trim().replace('\n', " ");
        let mut table: toml::Table = toml::from_str(text).map_err(in_words)?;
        let rated = table.remove("rated_loads").map(toml::Value::try_into).transpose();
        let rated: Option<BTreeMap<Axis, f64>> =
            rated.map_err(|error| format!("rated_loads: {}", in_words(error)))?;
        let rated_loads = rated.unwrap_or_default();
        let frame = table.remove("frame").map(toml::Value::try_into).transpose();
        let frame: Option<SensorFrame> =
            frame.map_err(|error| format!("frame: {}", in_words(error)))?;
        let frame = frame.unwrap_or_default().checked();
        let frame = frame.map_err(|wrong| format!("frame: {wrong}"))?;
        let is_wrong = |(_, load): &(&Axis, &f64)| !(load.is_finite() && **load > 0.0);
        if let Some((axis, load)) = rated_loads.iter().find(is_wrong) {
            return Err(format!(
                "rated_loads: the rated load {load} of {axis} is not valid; enter a number above zero"
            ));
        }
        let identity = toml::Value::Table(table).try_into().map_err(in_words)?;
        Ok(Self { identity, rated_loads, frame })
    }
}

/// Sets the full scale of each axis for which the user entered no full scale to the rated load of the axis.
pub fn rate(rated_loads: &BTreeMap<Axis, f64>, axes: &[Axis], full_scale: &mut Vec<Option<f64>>) {
    if axes.iter().any(|axis| rated_loads.contains_key(axis)) {
        full_scale.resize(axes.len(), None);
        for (entered, axis) in full_scale.iter_mut().zip(axes) {
            *entered = entered.or(rated_loads.get(axis).copied());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_numbers_and_dates_are_read_without_quotes() {
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
        rate(&read.rated_loads, &[Axis::Fz, Axis::Mx, Axis::My], &mut full_scale);
        assert_eq!(full_scale, [Some(200.0), Some(7.0), None]);
        let json = serde_json::to_string(&read.identity).unwrap();
        assert_eq!(serde_json::from_str::<Identity>(&json).unwrap(), read.identity);
    }

    #[test]
    fn unknown_keys_and_wrong_loads_are_named() {
        let wrong = |text: &str| SensorFile::from_toml(text).unwrap_err();
        assert!(
            wrong("seriel = 1")
                .contains("seriel is not known; use one of manufacturer, model, serial")
        );
        assert!(wrong("[rated_loads]\nFx = -3").contains("-3 of Fx"));
        assert!(wrong("[rated_loads]\nFq = 3").contains("Fq"));
        assert!(wrong("serial = ").contains("line 1"));
        assert!(wrong("[frame]\nturn = [0, 0, 90]").contains("frame"));
        assert!(wrong("[frame]\nturn_degrees = [0, 0]").contains("frame"));
        assert!(wrong("[frame]\nturn_degrees = [0, 0, nan]").contains("frame"));
    }

    #[test]
    fn a_frame_is_read_and_one_that_changes_nothing_is_none() {
        let read = |text: &str| SensorFile::from_toml(text).unwrap().frame;
        let frame =
            read("[frame]\nturn_degrees = [0, 0, 90]\nshift_metres = [0, 0, 0.05]").unwrap();
        assert_eq!((frame.turn_degrees[2], frame.shift_metres[2]), (90.0, 0.05));
        assert_eq!(read("[frame]\nturn_degrees = [0, 0, 0]"), None);
    }
}
