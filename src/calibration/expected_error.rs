use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{recording::Axis, shown::counted};

/// Numbers of held-out samples, and of the groups or test recordings to which they belong.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    pub groups: usize,
    pub samples: u64,
}

/// Expected error of one axis, in its unit: the value within which 95 % of the errors on further recordings should lie.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisExpectedError {
    pub axis: Axis,
    pub unit: String,
    pub range: (f64, f64),
    /// Expected error: the larger one of `cross_validation` and `test`. `None` if the load on the axis hardly changes.
    pub value: Option<f64>,
    /// Expected error `value`, in percent of full scale.
    pub percent_fs: Option<f64>,
    /// Value from cross-validation, widened because it rests on few groups.
    pub cross_validation: Option<f64>,
    /// Value within which 95 % of the errors on the test recordings lie; widened if there is no cross-validation.
    pub test: Option<f64>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExpectedError {
    pub axes: Vec<AxisExpectedError>,
    /// Numbers of samples and groups held out in cross-validation; `None` if only test recordings were used.
    pub cross_validation: Option<HeldOut>,
    pub test: Option<HeldOut>,
    /// Sentence on the conditions (such as temperatures or loads) that the recordings do not cover.
    pub not_covered: String,
}

impl ExpectedError {
    /// Returns the expected error of an axis in its unit, or the reason why it is unknown.
    pub fn of_axis(&self, axis: Axis) -> Result<f64, String> {
        let found = self.axes.iter().find(|found| found.axis == axis);
        found
            .and_then(|found| found.value)
            .ok_or_else(|| format!("the load on {axis} hardly changes in the recordings"))
    }

    /// Returns a sentence on the held-out samples, and one on the conditions that the recordings do not cover.
    pub fn notes(&self) -> Vec<String> {
        vec![format!("{self}."), self.not_covered.clone()]
    }
}

impl fmt::Display for ExpectedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = |(held_out, noun, how): (&Option<HeldOut>, _, _)| {
            let HeldOut { groups, samples } = held_out.as_ref()?;
            Some(format!("{}{how} ({samples} samples)", counted(*groups, noun)))
        };
        let left_out = (&self.cross_validation, "group", " left out in turn");
        let test = (&self.test, "test recording", "");
        let held_out: Vec<String> = [left_out, test].into_iter().filter_map(words).collect();
        write!(
            f,
            "95 % of the errors on further recordings of this kind should lie within the expected error. It follows from {}, and is \
             wider than the 95 % of these errors as far as few groups say little",
            held_out.join(", and from ")
        )?;
        if held_out.len() > 1 {
            write!(f, "; the larger of both values is the expected error")?;
        }
        Ok(())
    }
}
