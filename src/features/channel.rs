//! The auxiliary channels that a calibration takes beside its gauges: what each is, and what recordings know of it.
//!
//! Guarantees: values enter the fit relative to their mean over the training recordings, in deviations; a channel that hardly moved
//! there is none, so that no noise of a thermometer is blown up to an effect.

use serde::{Deserialize, Serialize};

use crate::min_max::MinMax;
use crate::recording::{Recording, span};

/// A channel that moved by less than this share of its largest value is held for one that stands still.
const STILL: f64 = 0.01;
/// A supply is held well; but an amplifier that is not ratiometric follows it to the last digit.
const STILL_SUPPLY: f64 = 1e-3;
/// So far beyond what was trained, in shares of that range, a value is taken for one within it.
const BEYOND_RANGE: f64 = 0.1;

/// An auxiliary channel of a calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuxiliaryChannel {
    /// As recordings name it.
    pub name: String,
    /// The unit that it is given in; empty where none is known.
    pub unit: String,
    /// What its effect counts from: what the user entered, else its mean over the training recordings.
    pub reference: f64,
    /// One over its standard deviation there.
    pub inverse_scale: f64,
    /// The least value there.
    pub min: f64,
    /// The greatest value there.
    pub max: f64,
}

impl AuxiliaryChannel {
    /// Measures a channel of recordings that all have it.
    ///
    /// # Errors
    /// Why its effect cannot be known.
    pub fn measure(training: &[&Recording], name: &str) -> Result<Self, String> {
        let tables = training.iter().map(|recording| recording.auxiliary());
        let placed = tables.filter_map(|table| {
            let at = table.names().iter().position(|own| own == name)?;
            Some((table, at))
        });
        let placed: Vec<_> = placed.collect();
        let Some((first, at)) = placed.first() else {
            return Err(format!("no training recording has {name}"));
        };
        let (name, unit) = (name.to_owned(), first.units()[*at].clone());
        let values = || {
            let channels = placed.iter();
            channels.flat_map(|(table, at)| table.values().iter().skip(*at).step_by(table.len()))
        };
        let n = values().count().max(1) as f64;
        let reference = values().sum::<f64>() / n;
        let deviation = (values().map(|value| (value - reference).powi(2)).sum::<f64>() / n).sqrt();
        let range: MinMax = values().collect();
        let MinMax { min, max } = range;
        // A few faulty numbers are no movement.
        let moved = range.span().min(4.0 * deviation);
        let least = match &*unit {
            "°C" => 1.0,
            "%" => 2.0,
            "V" => STILL_SUPPLY * range.magnitude(),
            _ => STILL * range.magnitude(),
        };
        if moved < least || deviation == 0.0 {
            return Err(format!(
                "{name} stands at {} in the training recordings, which is less than it has to move ({} {unit}): its effect is not \
                 determined, and it is left out",
                span(range, &unit),
                (least * 1e4).round() / 1e4,
            ));
        }
        Ok(Self { name, unit, reference, inverse_scale: 1.0 / deviation, min, max })
    }

    /// Returns the values it was trained from, with the unit.
    pub fn trained(&self) -> String {
        span(MinMax { min: self.min, max: self.max }, &self.unit)
    }

    /// Between which values its effect is known, about.
    pub fn limits(&self) -> (f64, f64) {
        let margin = BEYOND_RANGE * (self.max - self.min);
        (self.min - margin, self.max + margin)
    }

    /// Whether a value is beyond the [limits](Self::limits).
    pub fn is_beyond(&self, value: f64) -> bool {
        let (low, high) = self.limits();
        value < low || value > high
    }

    /// That what its effect counts from was not trained, where it was not.
    pub fn reference_beyond(&self) -> Option<String> {
        let range = self.trained();
        let words = format!("{} counts from {} {}", self.name, self.reference, self.unit);
        let is_beyond = self.is_beyond(self.reference);
        is_beyond.then(|| format!("{}, but was trained from {range}", words.trim_end()))
    }

    /// As `name [unit], trained from min to max unit`.
    pub fn in_words(&self) -> String {
        let unit = match &*self.unit {
            "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        format!("{}{unit}, trained from {}", self.name, self.trained())
    }

    /// The first number that is none, or makes no sense; with what it is.
    pub(super) fn broken(&self) -> Option<(&'static str, f64)> {
        let Self { reference, inverse_scale, min, max, .. } = self;
        let numbers = [
            ("reference", *reference, reference.is_finite()),
            ("inverse_scale", *inverse_scale, *inverse_scale >= 0.0 && inverse_scale.is_finite()),
            ("min", *min, min.is_finite()),
            ("max", *max, *max >= *min && max.is_finite()),
        ];
        let bad = numbers.into_iter().find(|(.., is_good)| !is_good);
        bad.map(|(what, number, _)| (what, number))
    }
}
