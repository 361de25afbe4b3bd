use std::fmt;

use serde::{Deserialize, Serialize};

use crate::recording::Axis;
use crate::shown::counted;

/// Number of held-out samples, and of their groups or test recordings.
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
    /// The larger of the values of cross-validation and test; `None` if the load on the axis hardly changes.
    pub value: Option<f64>,
    /// `value` in percent of full scale.
    pub percent_fs: Option<f64>,
    /// Value of the errors in cross-validation.
    pub cross_validation: Option<f64>,
    /// Value of the errors on the test recordings.
    pub test: Option<f64>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExpectedError {
    pub axes: Vec<AxisExpectedError>,
    /// Samples held out in cross-validation; `None` if only test recordings were used.
    pub cross_validation: Option<HeldOut>,
    pub test: Option<HeldOut>,
    /// Sentence that names the conditions which the recordings do not cover.
    pub not_covered: String,
}

impl ExpectedError {
    /// Returns the expected error of an axis in its unit, or the reason why it is unknown.
    pub fn of_axis(&self, axis: Axis) -> Result<f64, String> {
        let own = self.axes.iter().find(|own| own.axis == axis);
        own.and_then(|own| own.value)
            .ok_or_else(|| format!("the load on {axis} hardly changes in the recordings"))
    }

    /// Returns sentences on the held-out samples and on the conditions that are not covered.
    pub fn notes(&self) -> Vec<String> {
        vec![format!("{self}."), self.not_covered.clone()]
    }
}

impl fmt::Display for ExpectedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = |(own, noun, how): (&Option<HeldOut>, _, _)| {
            let HeldOut { groups, samples } = own.as_ref()?;
            Some(format!("{}{how} ({samples} samples)", counted(*groups, noun)))
        };
        let left_out = (&self.cross_validation, "group", " left out in turn");
        let test = (&self.test, "test recording", "");
        let held_out: Vec<String> = [left_out, test].into_iter().filter_map(words).collect();
        write!(
            f,
            "95 % of the errors lie within the expected error on {}",
            held_out.join(", and on ")
        )?;
        if held_out.len() > 1 {
            write!(f, "; the larger value counts")?;
        }
        Ok(())
    }
}
