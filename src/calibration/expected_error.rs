use std::fmt;

use serde::{Deserialize, Serialize};

use crate::recording::Axis;
use crate::shown::counted;

/// Number of held-out samples, and of the groups or test recordings that they belong to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    pub groups: usize,
    pub samples: u64,
}

/// Value within which 95 % of the held-out errors of one axis lie, in the axis' unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisExpectedError {
    pub axis: Axis,
    pub unit: String,
    pub range: (f64, f64),
    /// The larger of the two values below; `None` if the load on the axis hardly changes.
    pub value: Option<f64>,
    /// Percentage of full scale.
    pub percent_fs: Option<f64>,
    /// Value in cross-validation.
    pub cross_validation: Option<f64>,
    /// Value on the test recordings.
    pub test: Option<f64>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExpectedError {
    pub axes: Vec<AxisExpectedError>,
    /// Samples held out in cross-validation; `None` if only test recordings are used.
    pub cross_validation: Option<HeldOut>,
    pub test: Option<HeldOut>,
    /// Sentence on conditions that the recordings do not cover.
    pub not_covered: String,
}

impl ExpectedError {
    /// Returns the value of an axis in its unit, or the reason why there is none.
    pub fn of_axis(&self, axis: Axis) -> Result<f64, String> {
        let own = self.axes.iter().find(|own| own.axis == axis);
        own.and_then(|own| own.value)
            .ok_or_else(|| format!("{axis} hardly moves in the recordings"))
    }

    /// Returns the sentences beside the figures: the held-out samples, and the conditions that are not covered.
    pub fn notes(&self) -> Vec<String> {
        vec![format!("{self}."), self.not_covered.clone()]
    }
}

impl fmt::Display for ExpectedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let left_out = self.cross_validation.as_ref().map(|own| {
            let groups = counted(own.groups, "group");
            format!("{groups} left out in turn ({} samples)", own.samples)
        });
        let test = self.test.as_ref().map(|own| {
            let recordings = counted(own.groups, "test recording");
            format!("{recordings} ({} samples)", own.samples)
        });
        let held_out: Vec<String> = left_out.into_iter().chain(test).collect();
        write!(f, "95 % of the errors lie within it on {}", held_out.join(", and on "))?;
        if held_out.len() > 1 {
            write!(f, "; the larger value counts")?;
        }
        Ok(())
    }
}
