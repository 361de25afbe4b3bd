//! Auxiliary channels of a calibration, such as a temperature or a supply voltage. The fit uses the difference of a channel
//! from its reference value (by default its mean over the training recordings), divided by its standard deviation. A channel
//! that hardly changed is not used, because its noise would be amplified.

use serde::{Deserialize, Serialize};

use crate::{
    min_max::MinMax,
    recording::{Recording, span},
};

/// Minimum change of a channel over the training recordings, as a share of its largest absolute value. A channel that changes
/// less counts as constant and is not used.
const STILL: f64 = 0.01;
/// Minimum change of a supply voltage over the training recordings, as a share of its largest absolute value. The limit is
/// low, because the output of an amplifier that is not ratiometric follows every change of its supply.
const STILL_SUPPLY: f64 = 1e-3;
/// Accepted distance of a channel's value from its range in the training recordings, as a share of the width of that range.
const BEYOND_RANGE: f64 = 0.1;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuxiliaryChannel {
    /// Name of the channel in the recordings.
    pub name: String,
    /// Unit of the channel; empty if unknown.
    pub unit: String,
    /// Value at which the channel has no effect: the user's entry, else the mean over the training recordings.
    pub reference: f64,
    /// Inverse of the channel's standard deviation over the training recordings.
    pub inverse_scale: f64,
    pub min: f64,
    pub max: f64,
}

impl AuxiliaryChannel {
    /// Determines reference value, scale and range of a channel from the training recordings. The error is the reason why
    /// the effect of the channel on the load cannot be determined.
    pub fn measure(training: &[&Recording], name: &str) -> Result<Self, String> {
        let tables = training.iter().map(|recording| recording.auxiliary());
        let placed = tables.filter_map(|table| {
            let at = table.names().iter().position(|known| known == name)?;
            Some((table, at))
        });
        let Some((first, at)) = placed.clone().next() else {
            return Err(format!("no training recording has the auxiliary channel {name}"));
        };
        let (name, unit) = (name.to_owned(), first.units()[at].clone());
        let values = || {
            let channels = placed.clone();
            channels.flat_map(|(table, at)| table.values().iter().skip(at).step_by(table.len()))
        };
        let n = values().count().max(1) as f64;
        let reference = values().sum::<f64>() / n;
        let deviation = (values().map(|value| (value - reference).powi(2)).sum::<f64>() / n).sqrt();
        let range: MinMax = values().collect();
        let MinMax { min, max } = range;
        // At most four standard deviations count as change, which limits the effect of a few outliers.
        let moved = range.span().min(4.0 * deviation);
        let least = match &*unit {
            "°C" => 1.0,
            "%" => 2.0,
            "V" => STILL_SUPPLY * range.magnitude(),
            _ => STILL * range.magnitude(),
        };
        if moved < least || deviation == 0.0 {
            return Err(format!(
                "auxiliary channel {name} left out: its range in the training recordings is {}, but the channel must change by at least {} {unit} for its effect to be \
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

    /// Returns the lower and the upper limit of the channel's values for which its effect on the load is known: its training
    /// range with a margin.
    pub fn limits(&self) -> (f64, f64) {
        let margin = BEYOND_RANGE * (self.max - self.min);
        (self.min - margin, self.max + margin)
    }

    /// Returns true if a value of the channel is outside [`Self::limits`].
    pub fn is_beyond(&self, value: f64) -> bool {
        let (low, high) = self.limits();
        value < low || value > high
    }

    pub fn reference_beyond(&self) -> Option<String> {
        let Self { name, unit, reference, .. } = self;
        let words = format!("{name}: the reference value is {reference} {unit}");
        self.is_beyond(*reference).then(|| {
            format!(
                "{}, but in the training recordings the channel covers {}",
                words.trim_end(),
                self.trained()
            )
        })
    }

    /// Returns a description of the channel: `name [unit], trained from min to max unit`, where min and max are its limits in
    /// the training recordings.
    pub fn in_words(&self) -> String {
        format!("{}, trained from {}", named(&self.name, &self.unit), self.trained())
    }

    /// Returns the key and the value of the channel's first number that is not valid; `None` if all are valid.
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

/// Returns the name of a channel with its unit in brackets, if it has one.
pub(crate) fn named(name: &str, unit: &str) -> String {
    match unit {
        "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    }
}
