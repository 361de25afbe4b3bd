//! Checks a calibration, which may have been edited by hand or made for another sensor.

use crate::{
    calibration::{
        calibration::Calibration,
        entries::{check_length, check_numbers},
        error::{CalibrationError, FORMAT, LARGEST, VERSION},
        linear_map::LinearMap,
    },
    features::{Column, FeatureSettings},
};

impl Calibration {
    /// Checks all shapes, numbers and names of a calibration.
    pub fn validate(&self) -> Result<(), CalibrationError> {
        check_head(&self.format, self.version)?;
        if self.gauges.is_empty() {
            return Err(CalibrationError::Nothing { what: "gauges" });
        }
        if self.axes.is_empty() {
            return Err(CalibrationError::Nothing { what: "axes" });
        }
        if !self.axes.is_sorted_by(|a, b| a < b) {
            return Err(CalibrationError::AxisOrder);
        }
        let (n_axes, n_gauges) = (self.axes.len(), self.gauges.len());
        check_length("units", n_axes, self.units.len())?;
        for (field, expected, actual) in [
            ("rated", n_axes, self.rated.len()),
            ("gauge_limits", n_gauges, self.gauge_limits.len()),
        ] {
            if actual > 0 {
                check_length(field, expected, actual)?;
            }
        }
        for (axis, unit) in self.axes.iter().zip(&self.units) {
            if unit != axis.unit() {
                return Err(CalibrationError::Unit {
                    axis: axis.symbol(),
                    expected: axis.unit(),
                    actual: unit.clone(),
                });
            }
        }
        let ends = self.gauge_limits.iter().flat_map(|(low, high)| [low, high]);
        let ends: Vec<f64> = ends.filter_map(|end| *end).collect();
        let errors = self.quality.coefficients.iter();
        let errors: Vec<f64> = errors.flat_map(|known| known.standard.concat()).collect();
        let scale = &self.gauge_scale;
        let keep: Vec<f64> = self.keep_secs.values().copied().collect();
        let fade = self.fade.values().flatten().copied().collect::<Vec<f64>>();
        let (rate, run) = (self.rate_hz.as_slice(), scale.run_secs.as_slice());
        let n_travels = if scale.travel.is_empty() { 0 } else { n_gauges };
        let n_limits = if self.limits.is_empty() { 0 } else { n_axes };
        for (field, expected, numbers, least) in [
            ("full_scale", n_axes, &self.full_scale[..], 0.0),
            ("gauge_scale.shift", n_gauges, &scale.shift, -LARGEST),
            ("gauge_scale.inverse_scale", n_gauges, &scale.inverse_scale, 0.0),
            ("gauge_scale.deviation", n_gauges, &scale.deviation, 0.0),
            ("gauge_scale.travel", n_travels, &scale.travel, 0.0),
            ("gauge_scale.run_secs", run.len(), run, 0.0),
            ("limits", n_limits, &self.limits, 0.0),
            ("gauge_limits", ends.len(), &ends, -LARGEST),
            ("quality.coefficients", errors.len(), &errors, -LARGEST),
            ("gap_secs", 1, &[self.gap_secs], f64::MIN_POSITIVE),
            ("keep_secs", keep.len(), &keep, 0.0),
            ("fade", fade.len(), &fade, 0.0),
            ("history_step_secs", 1, &[self.history_step_secs], 0.0),
            ("rate_hz", rate.len(), rate, f64::MIN_POSITIVE),
        ] {
            check_numbers(field, expected, numbers, least)?;
        }
        if self.full_scale.iter().all(|value| *value == 0.0) {
            return Err(CalibrationError::NoFullScale);
        }
        if self.decimation == 0 {
            return Err(CalibrationError::Decimation);
        }
        self.features.validate()?;
        self.features.check_columns(n_gauges)?;
        self.check_fade()?;
        let present = FeatureSettings::present();
        self.validate_map("conventional", &self.conventional, &present)?;
        if let Some(map) = &self.compensated {
            self.validate_map("compensated", map, &self.features)?;
        }
        if let Some(learned) = &self.learned {
            let n_inputs = self.columns().len() - usize::from(self.offset);
            learned.validate(n_inputs, n_axes)?;
        }
        if self.compensated.is_none() && self.learned.is_none() {
            return Err(CalibrationError::Nothing { what: "compensated map" });
        }
        Ok(())
    }

    fn validate_map(
        &self,
        field: &'static str,
        map: &LinearMap,
        features: &FeatureSettings,
    ) -> Result<(), CalibrationError> {
        let columns = features.columns(self.gauges.len(), self.offset);
        let named =
            |columns: &[Column]| columns.iter().map(|column| format!("{column:?}")).collect();
        let (expected, actual): (Vec<_>, Vec<_>) = (named(&columns), named(&map.columns));
        check_features(field, &expected, &actual)?;
        check_length(&format!("{field}.matrix"), self.axes.len(), map.matrix.len())?;
        for (axis, row) in self.axes.iter().zip(&map.matrix) {
            check_numbers(&format!("{field}.matrix, row {axis}"), columns.len(), row, -LARGEST)?;
        }
        Ok(())
    }
}

pub(super) fn check_head(format: &str, version: u32) -> Result<(), CalibrationError> {
    if format != FORMAT {
        return Err(CalibrationError::Format);
    }
    if version != VERSION {
        return Err(CalibrationError::Version { version });
    }
    Ok(())
}

/// Checks that the column names of a matrix in a file are the expected feature names.
pub(super) fn check_features(
    field: &'static str,
    expected: &[String],
    actual: &[String],
) -> Result<(), CalibrationError> {
    check_length(&format!("{field}.features"), expected.len(), actual.len())?;
    for (position, (expected, actual)) in expected.iter().zip(actual).enumerate() {
        if expected != actual {
            return Err(CalibrationError::Feature {
                field,
                position: position + 1,
                expected: expected.clone(),
                actual: actual.clone(),
            });
        }
    }
    Ok(())
}
