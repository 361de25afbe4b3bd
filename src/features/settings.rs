use std::fmt;

use serde::de::{Error as _, MapAccess, Visitor};
use serde::ser::SerializeMap as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Value, from_value};

use crate::features::{
    block::{Appends, Block, STORED_SAMPLES},
    blocks::{Auxiliary, BLOCKS},
    channel::AuxiliaryChannel,
    column::{Column, History},
    look_back::{Distance, F_TH, T_TH, Thresholds},
    setting::{FeatureError, MAX_COLUMNS},
};

/// Key of the auxiliary channels in calibration and session files.
const CHANNELS: &str = "auxiliary_channels";

/// Settings of all feature blocks: a list of values for each block, which is empty if the block is not used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blocks {
    values: [Vec<f64>; BLOCKS.len()],
    /// Number of sets of past gauges that the blocks append. It is stored because it is needed for every sample.
    n_histories: usize,
}

impl Blocks {
    /// Returns the setting of a feature block; empty if the block is not used.
    pub fn of(&self, block: &dyn Block) -> &[f64] {
        &self.values[position(block)]
    }

    /// Returns the settings in which all feature blocks have their default values. Auxiliary channels are left out, because
    /// not every sensor has any.
    pub fn every() -> Self {
        let blocks = BLOCKS.iter().copied();
        let blocks = blocks.filter(|block| !matches!(block.appends(), Appends::Auxiliary));
        blocks.fold(Self::default(), |all, block| all.with(block, block.setting().default))
    }

    /// Sets the values of a feature block. If its setting has named values, the first of them switches the block off.
    pub fn set(&mut self, block: &dyn Block, values: Vec<f64>) {
        let none = block.setting().choices().map(|choices| choices[0].value);
        let is_none = none.is_some_and(|none| values == [f64::from(none)]);
        self.values[position(block)] = if is_none { Vec::new() } else { values };
        let histories = self.used().filter(|(block, _)| is_history(*block));
        self.n_histories = histories.map(|(_, values)| values.len()).sum();
    }

    /// Returns these settings with other values for one feature block.
    pub fn with(mut self, block: &dyn Block, values: &[f64]) -> Self {
        self.set(block, values.to_vec());
        self
    }

    /// Returns the feature blocks in use with their values, in the order of their columns.
    pub fn used(&self) -> impl Iterator<Item = (&'static dyn Block, &[f64])> {
        let all = BLOCKS.iter().copied().zip(&self.values);
        all.filter_map(|(block, values)| (!values.is_empty()).then_some((block, &values[..])))
    }

    /// Returns every feature block with its values in the form that calibration and session files have.
    pub fn stored(&self) -> impl Iterator<Item = (&'static dyn Block, Stored<'_>)> {
        BLOCKS.iter().copied().zip(&self.values).map(|(block, values)| {
            let stored = match block.setting().choices() {
                Some(choices) => {
                    Stored::Number(values.first().map_or(choices[0].value, |v| *v as u8))
                }
                None => Stored::List(values),
            };
            (block, stored)
        })
    }
}

/// Values of a feature block in the form that calibration and session files have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Stored<'a> {
    /// Chosen value of a setting with a few named values.
    Number(u8),
    /// Values of any other setting.
    List(&'a [f64]),
}

fn position(block: &dyn Block) -> usize {
    let place = BLOCKS.iter().position(|place| *place == block);
    place.expect("every feature block is in the list `BLOCKS`")
}

/// Features that are appended to the present gauges: look-backs and other blocks. In files, each block has the key of its
/// [`Setting`](crate::features::Setting).
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureSettings {
    /// Force and time threshold of each look-back. Each look-back appends one set of past gauges.
    pub look_backs: Vec<Thresholds>,
    /// Norm of the load difference that is compared with the force threshold F_th of the look-backs.
    pub distance: Distance,
    /// Settings of the feature blocks other than look-backs.
    pub blocks: Blocks,
    /// Auxiliary channels, determined from the recordings when a calibration is fitted.
    pub auxiliary: Vec<AuxiliaryChannel>,
}

impl Default for FeatureSettings {
    fn default() -> Self {
        Self { look_backs: vec![Thresholds::default()], ..Self::present() }
    }
}

impl Serialize for FeatureSettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("look_backs", &self.look_backs)?;
        map.serialize_entry("distance", &self.distance)?;
        for (block, stored) in self.blocks.stored() {
            map.serialize_entry(block.setting().key, &stored)?;
        }
        if !self.auxiliary.is_empty() {
            map.serialize_entry(CHANNELS, &self.auxiliary)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for FeatureSettings {
    /// Reads the settings of a file. Missing keys get their default values, and unknown keys are ignored.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(ByKey)
    }
}

/// Reads settings key by key, so that an error message has the line and column of the wrong key.
struct ByKey;

impl<'de> Visitor<'de> for ByKey {
    type Value = FeatureSettings;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON object with the settings of features")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut keys: A) -> Result<FeatureSettings, A::Error> {
        let mut settings = FeatureSettings::default();
        while let Some((key, value)) = keys.next_entry::<String, Value>()? {
            settings.take(&key, value).map_err(A::Error::custom)?;
        }
        Ok(settings)
    }
}

impl FeatureSettings {
    fn take(&mut self, key: &str, value: Value) -> Result<(), serde_json::Error> {
        let block = BLOCKS.iter().copied().find(|block| block.setting().key == key);
        match (key, block) {
            ("look_backs", _) => self.look_backs = from_value(value)?,
            ("distance", _) => self.distance = from_value(value)?,
            (CHANNELS, _) => self.auxiliary = from_value(value)?,
            (_, Some(block)) if block.setting().choices().is_some() => {
                self.blocks.set(block, vec![f64::from(from_value::<u8>(value)?)]);
            }
            (_, Some(block)) => self.blocks.set(block, from_value(value)?),
            (_, None) => {}
        }
        Ok(())
    }

    /// Returns settings without any feature block. The load then depends on the present gauges alone.
    pub fn present() -> Self {
        Self {
            look_backs: Vec::new(),
            distance: Distance::Force,
            blocks: Blocks::default(),
            auxiliary: Vec::new(),
        }
    }

    /// Returns these settings without look-backs and other feature blocks that depend on earlier samples.
    pub fn without_history(&self) -> Self {
        let mut blocks = self.blocks.clone();
        for (block, _) in self.blocks.used().filter(|(block, _)| is_history(*block)) {
            blocks.set(block, Vec::new());
        }
        let taus_secs = blocks.of(&Auxiliary).iter().copied();
        let present = taus_secs.filter(|tau_secs| *tau_secs == 0.0).collect();
        blocks.set(&Auxiliary, present);
        Self { look_backs: Vec::new(), blocks, ..self.clone() }
    }

    /// Returns true if the model uses more than the present gauges: a look-back or another feature block.
    pub fn adds_columns(&self) -> bool {
        !self.look_backs.is_empty() || self.blocks.used().next().is_some()
    }

    /// Returns true if a look-back or another feature block depends on earlier samples.
    pub fn has_history(&self) -> bool {
        self.n_histories() > 0
    }

    /// Returns true if a feature block other than a look-back keeps a state between samples.
    pub fn has_memory(&self) -> bool {
        let is_low_passed = |tau_secs: &f64| *tau_secs > 0.0 && !self.auxiliary.is_empty();
        self.blocks.n_histories > 0 || self.blocks.of(&Auxiliary).iter().any(is_low_passed)
    }

    /// Returns the names of the memories in which the features keep their states; see [`Block::memory`].
    pub(crate) fn memories(&self) -> Vec<&'static str> {
        let look_backs = self.look_backs.first().map(|_| STORED_SAMPLES);
        let mut names: Vec<_> = look_backs
            .into_iter()
            .chain(self.blocks.used().filter_map(|(block, _)| block.memory()))
            .collect();
        names.dedup();
        names
    }

    /// Returns true if auxiliary channels are used.
    pub fn uses_auxiliary(&self) -> bool {
        !self.auxiliary.is_empty() && !self.blocks.of(&Auxiliary).is_empty()
    }

    /// Returns the names of the auxiliary channels that recordings must have.
    pub fn auxiliary_names(&self) -> Vec<String> {
        let names = self.auxiliary.iter().map(|channel| channel.name.clone());
        names.collect()
    }

    /// Returns the number of sets of past gauges that look-backs and other feature blocks append. Each set has one column per
    /// gauge.
    pub fn n_histories(&self) -> usize {
        self.look_backs.len() + self.blocks.n_histories
    }

    /// Returns the columns of the design matrix for `n_gauges` gauges: present gauges, sets of past gauges, monomials,
    /// auxiliary channels, offset.
    pub fn columns(&self, n_gauges: usize, offset: bool) -> Vec<Column> {
        let mut columns: Vec<Column> = (0..n_gauges).map(Column::Gauge).collect();
        let past = |history| (0..n_gauges).map(move |gauge| Column::Past { history, gauge });
        columns.extend((0..self.look_backs.len()).flat_map(|at| past(History::LookBack(at))));
        for (block, values) in self.blocks.used() {
            let values = values.iter().copied();
            match block.appends() {
                Appends::Past(_) => {
                    columns.extend(values.flat_map(|value| past(History::Block(block, value))));
                }
                Appends::Monomials(of) => {
                    let monomials = values.flat_map(|value| of(value, n_gauges));
                    columns.extend(monomials.map(Column::Monomial));
                }
                Appends::Auxiliary => columns.extend(values.flat_map(|tau_secs| {
                    let channels = 0..self.auxiliary.len();
                    channels.flat_map(move |channel| {
                        let alone = std::iter::once(None);
                        let gauges = alone.chain((0..n_gauges).map(Some));
                        gauges.map(move |gauge| Column::Auxiliary { channel, tau_secs, gauge })
                    })
                })),
            }
        }
        columns.extend(offset.then_some(Column::Offset));
        columns
    }

    pub(super) fn n_columns(&self, n_gauges: usize) -> usize {
        let blocks = self.blocks.used();
        let appended = blocks.map(|(block, values)| self.n_columns_of(block, values, n_gauges));
        n_gauges * (1 + self.look_backs.len()) + appended.sum::<usize>()
    }

    pub(crate) fn n_columns_of(&self, block: &dyn Block, values: &[f64], n_gauges: usize) -> usize {
        match block.appends() {
            Appends::Auxiliary => values.len() * self.auxiliary.len() * (1 + n_gauges),
            _ => block.n_columns(values, n_gauges),
        }
    }

    /// Returns the longest time for which any feature block keeps samples (s); zero if none keeps any.
    pub fn window_secs(&self) -> f64 {
        self.longest(|block, values| block.window_secs(values))
    }

    /// Returns the time after a start until the states of all feature blocks are determined (s). Blocks whose state depends
    /// on the range of the load, and not on time, are not included.
    pub fn settling_secs(&self) -> f64 {
        self.longest(|block, values| block.settling_secs(values))
    }

    fn longest(&self, secs: impl Fn(&dyn Block, &[f64]) -> f64) -> f64 {
        let t_ths_secs = self.look_backs.iter().map(|look_back| look_back.t_th_secs);
        let blocks = self.blocks.used().map(|(block, values)| secs(block, values));
        t_ths_secs.chain(blocks).fold(0.0, f64::max)
    }

    /// Checks every value of the settings. The error describes the first value that is not allowed.
    pub fn validate(&self) -> Result<(), FeatureError> {
        for Thresholds { f_th, t_th_secs } in &self.look_backs {
            F_TH.check(*f_th)?;
            T_TH.check(*t_th_secs)?;
        }
        for (block, values) in self.blocks.used() {
            for value in values {
                block.setting().check(*value)?;
            }
        }
        for channel in &self.auxiliary {
            if let Some((what, value)) = channel.broken() {
                let name = channel.name.clone();
                return Err(FeatureError::Channel { name, what, value });
            }
        }
        Ok(())
    }

    /// Returns [`FeatureError::Columns`] if the features of `n_gauges` gauges need more than [`MAX_COLUMNS`] columns.
    pub fn check_columns(&self, n_gauges: usize) -> Result<(), FeatureError> {
        let columns = self.n_columns(n_gauges);
        if columns > MAX_COLUMNS {
            return Err(FeatureError::Columns { columns, gauges: n_gauges });
        }
        Ok(())
    }

    /// Returns the features in words, for tables of results; empty if only the present gauges are used.
    pub fn describe(&self) -> String {
        let mut parts = Vec::new();
        for (at, Thresholds { f_th, t_th_secs }) in self.look_backs.iter().enumerate() {
            let repeated = at > 0 && self.look_backs[0].t_th_secs == *t_th_secs;
            let t_th = if repeated { String::new() } else { format!(", t_th {t_th_secs} s") };
            parts.push(self.distance.in_words(*f_th) + &t_th);
        }
        parts.extend(self.blocks.used().map(|(block, values)| {
            let mut name = block.name().to_lowercase();
            if matches!(block.appends(), Appends::Auxiliary) && !self.auxiliary.is_empty() {
                name = format!("{name} {},", self.auxiliary_names().join(", "));
            }
            format!("{name} {}", block.setting().in_words(values))
        }));
        parts.join("; ")
    }
}

fn is_history(block: &dyn Block) -> bool {
    matches!(block.appends(), Appends::Past(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::blocks::{Creep, FixedLag, Play, Polynomial};

    #[test]
    fn values_out_of_range_are_named() {
        let refused = |change: fn(&mut FeatureSettings)| {
            let mut settings = FeatureSettings::default();
            change(&mut settings);
            settings.validate().unwrap_err().to_string()
        };
        assert_eq!(FeatureSettings::default().validate(), Ok(()));
        assert!(refused(|s| s.look_backs[0].f_th = -1.0).contains("F_th is -1"));
        assert!(refused(|s| s.look_backs[0].t_th_secs = f64::INFINITY).contains("t_th"));
        assert!(refused(|s| s.blocks.set(&Play, vec![0.1, 0.0])).contains("play radius is 0"));
        assert!(refused(|s| s.blocks.set(&Creep, vec![f64::NAN])).contains("NaN"));
        assert!(refused(|s| s.blocks.set(&FixedLag, vec![-2.0])).contains("fixed lag"));
        assert!(refused(|s| s.blocks.set(&Polynomial, vec![4.0])).contains("polynomial is 4"));
    }

    #[test]
    fn too_many_columns_are_refused_before_they_are_made() {
        let squares = FeatureSettings {
            blocks: Blocks::default().with(&Polynomial, &[2.0]),
            ..FeatureSettings::present()
        };
        assert_eq!(squares.check_columns(6), Ok(()));
        assert!(squares.check_columns(64).is_err());
    }

    #[test]
    fn blocks_are_described_in_words() {
        let settings = FeatureSettings {
            look_backs: [3.0, 8.0].map(|f_th| Thresholds { f_th, t_th_secs: 15.0 }).to_vec(),
            blocks: Blocks::default().with(&Play, &[0.1, 0.2]).with(&Polynomial, &[2.0]),
            ..FeatureSettings::present()
        };
        assert_eq!(
            settings.describe(),
            "F_th 3 N, t_th 15 s; F_th 8 N; play 0.1, 0.2 σ; polynomial degree 2"
        );
        assert_eq!(FeatureSettings::present().describe(), "");
    }

    /// Reads the keys that calibration and session files have had since the first version.
    #[test]
    fn every_block_has_its_own_key_in_files() {
        let chosen = FeatureSettings {
            blocks: Blocks::default()
                .with(&FixedLag, &[0.5])
                .with(&Creep, &[1.0, 6.0])
                .with(&Play, &[0.1])
                .with(&Polynomial, &[3.0]),
            ..FeatureSettings::default()
        };
        let text = r#"{"look_backs": [{"f_th": 3.0, "t_th_secs": 15.0}], "distance": "force", "fixed_lags_secs": [0.5],
            "creep_secs": [1.0, 6.0], "play_radii": [0.1], "polynomial": 3}"#;
        let old: serde_json::Value = serde_json::from_str(text).unwrap();
        let written = serde_json::to_value(&chosen).unwrap();
        for (key, value) in old.as_object().unwrap() {
            assert_eq!(&written[key], value, "{key}");
        }
        for block in BLOCKS {
            assert!(!written[block.setting().key].is_null());
        }
        let read = |text| serde_json::from_str::<FeatureSettings>(text);
        assert_eq!(read(text).unwrap(), chosen);
        assert_eq!(
            read(r#"{"polynomial": 1, "unheard_of": {"a": [1]}}"#).unwrap(),
            FeatureSettings::default()
        );
        let error = read(r#"{"play_radii": ["x"]}"#).unwrap_err().to_string();
        assert!(error.contains("line 1 column"), "{error}");
    }
}
