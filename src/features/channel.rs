//! Auxiliary channels of a calibration. Values enter the fit relative to their mean over the training recordings, in standard
//! deviations. A channel that hardly changed is not used, because its noise would be amplified.

use serde::{Deserialize, Serialize};

use crate::min_max::MinMax;
use crate::recording::{Recording, span};

/// Share of its largest value by which a channel must change; a channel that changes less counts as constant.
const STILL: f64 = 0.01;
/// Minimum change of a supply voltage, as a share of its value; an amplifier that is not ratiometric follows every change.
const STILL_SUPPLY: f64 = 1e-3;
/// Accepted distance beyond the training range, as a share of this range.
const BEYOND_RANGE: f64 = 0.1;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuxiliaryChannel {
    /// As in the recordings.
    pub name: String,
    /// Empty if unknown.
    pub unit: String,
    /// Value at which the channel has no effect: the user's entry, else the mean over the training recordings.
    pub reference: f64,
    /// Inverse of the standard deviation over the training recordings.
    pub inverse_scale: f64,
    pub min: f64,
    pub max: f64,
}

impl AuxiliaryChannel {
    /// Determines a channel from the training recordings, which must all have it, or the reason why its effect is not known.
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
        // A few outliers do not count as a change.
        let moved = range.span().min(4.0 * deviation);
        let least = match &*unit {
            "°C" => 1.0,
            "%" => 2.0,
            "V" => STILL_SUPPLY * range.magnitude(),
            _ => STILL * range.magnitude(),
        };
        if moved < least || deviation == 0.0 {
            return Err(format!(
                "auxiliary channel {name} left out: its range in the training recordings is {}, but it must change by at least {} {unit} for its effect to be \
                 determined",
                span(range, &unit),
                (least * 1e4).round() / 1e4,
            ));
        }
        Ok(Self { name, unit, reference, inverse_scale: 1.0 / deviation, min, max })
    }

    pub fn trained(&self) -> String {
        span(MinMax { min: self.min, max: self.max }, &self.unit)
    }

    /// Returns the limits within which the effect of the channel is known.
    pub fn limits(&self) -> (f64, f64) {
        let margin = BEYOND_RANGE * (self.max - self.min);
        (self.min - margin, self.max + margin)
    }

    /// Returns true if a value is beyond [`Self::limits`].
    pub fn is_beyond(&self, value: f64) -> bool {
        let (low, high) = self.limits();
        value < low || value > high
    }

    pub fn reference_beyond(&self) -> Option<String> {
        let range = self.trained();
        let words =
            format!("{}: the reference value is {} {}", self.name, self.reference, self.unit);
        let is_beyond = self.is_beyond(self.reference);
        is_beyond
            .then(|| format!("{}, but the training recordings cover {range}", words.trim_end()))
    }

    /// Returns a description, such as `name [unit], trained from min to max unit`.
    pub fn in_words(&self) -> String {
        let unit = match &*self.unit {
            "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        format!("{}{unit}, trained from {}", self.name, self.trained())
    }

    /// Returns the first invalid number with its key in files.
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
