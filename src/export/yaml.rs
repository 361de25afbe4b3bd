//! Calibrations as YAML with plain keys and row-major matrices, as parameters of a robot are configured.

use std::io;

use super::facts::Fact;
use super::text::for_yaml;
use crate::calibration::{Calibration, LinearMap, Scores};
use crate::features::Stored;

/// Writes scalars, flow lists of numbers, and texts in double quotes.
pub(super) fn write(
    calibration: &Calibration,
    facts: &[Fact],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let features = &calibration.features;
    let scale = &calibration.gauge_scale;
    writeln!(out, "about:")?;
    for (name, text) in facts {
        writeln!(
            out,
            "  {}: {}",
            name.replace(' ', "_").to_ascii_lowercase(),
            for_yaml(text)
        )?;
    }
    writeln!(out, "gauges: {}", texts(&calibration.gauges))?;
    let axes: Vec<String> = calibration
        .axes
        .iter()
        .map(|axis| axis.symbol().to_owned())
        .collect();
    writeln!(out, "axes: {}", texts(&axes))?;
    writeln!(out, "units: {}", texts(&calibration.units))?;
    writeln!(out, "full_scale: {}", numbers(&calibration.full_scale))?;
    writeln!(out, "offset: {}", calibration.offset)?;
    writeln!(out, "simulated: {}", calibration.simulated)?;
    if let Some(tare) = calibration.tare {
        writeln!(out, "tared: \"{tare}\"")?;
    }
    writeln!(out, "blocks:")?;
    writeln!(
        out,
        "  look_backs:{}",
        if features.look_backs.is_empty() {
            " []"
        } else {
            ""
        }
    )?;
    for look_back in &features.look_backs {
        writeln!(
            out,
            "    - {{f_th: {}, t_th_secs: {}}}",
            number(look_back.f_th),
            number(look_back.t_th_secs)
        )?;
    }
    writeln!(
        out,
        "  # d of the look-back: the norm of the conventional load's differences times these"
    )?;
    writeln!(
        out,
        "  distance_weights: {}",
        numbers(&calibration.distance_weights())
    )?;
    for (block, stored) in features.blocks.stored() {
        let setting = block.setting();
        if !setting.unit.words.is_empty() {
            writeln!(out, "  # {} in {}", setting.label, setting.unit.words)?;
        }
        match stored {
            Stored::Number(number) => writeln!(out, "  {}: {number}", setting.key)?,
            Stored::List(values) => writeln!(out, "  {}: {}", setting.key, numbers(values))?,
        }
    }
    writeln!(out, "gauge_scale:")?;
    writeln!(out, "  shift: {}", numbers(&scale.shift))?;
    writeln!(out, "  inverse_scale: {}", numbers(&scale.inverse_scale))?;
    writeln!(out, "  deviation: {}", numbers(&scale.deviation))?;
    let (gauges, quality) = (&calibration.gauges, &calibration.quality);
    let conventional = &calibration.conventional;
    map(
        "conventional",
        conventional,
        gauges,
        &quality.conventional,
        out,
    )?;
    if let Some(compensated) = &calibration.compensated {
        map(
            "compensated",
            compensated,
            gauges,
            &quality.compensated,
            out,
        )?;
    }
    writeln!(out, "trained_on: {}", texts(&calibration.trained_on))
}

/// Matrix row-major in one list, as well as rows and columns, so that a parameter of numbers holds it.
fn map(
    name: &str,
    map: &LinearMap,
    gauges: &[String],
    scores: &Scores,
    out: &mut dyn io::Write,
) -> io::Result<()> {
    writeln!(out, "{name}:")?;
    writeln!(out, "  features: {}", texts(&map.names(gauges)))?;
    writeln!(out, "  rows: {}", map.matrix.len())?;
    writeln!(out, "  columns: {}", map.columns.len())?;
    writeln!(out, "  matrix: {}", numbers(&map.matrix.concat()))?;
    for (name, rmse) in [
        ("test_rmse", &scores.test_rmse),
        ("left_out_rmse", &scores.cv_rmse),
        ("train_rmse", &scores.train_rmse),
    ] {
        if let Some(rmse) = rmse {
            writeln!(out, "  {name}: {}", numbers(rmse))?;
        }
    }
    Ok(())
}

fn texts(texts: &[String]) -> String {
    let quoted: Vec<String> = texts.iter().map(|text| for_yaml(text)).collect();
    format!("[{}]", quoted.join(", "))
}

fn numbers(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|value| number(*value)).collect();
    format!("[{}]", texts.join(", "))
}

/// With a point always: many readers of YAML take `1e-7` for a text.
fn number(value: f64) -> String {
    let text = format!("{value:?}");
    match text.split_once('e') {
        Some((digits, exponent)) => {
            let point = if digits.contains('.') { "" } else { ".0" };
            let sign = if exponent.starts_with('-') { "" } else { "+" };
            format!("{digits}{point}e{sign}{exponent}")
        }
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// YAML 1.1 asks for a point and a sign in floats with an exponent.
    #[test]
    fn numbers_are_numbers_to_every_reader() {
        for (value, text) in [
            (1e-7, "1.0e-7"),
            (-2.5e-9, "-2.5e-9"),
            (1e300, "1.0e+300"),
            (0.25, "0.25"),
            (3.0, "3.0"),
        ] {
            assert_eq!(number(value), text);
            assert_eq!(text.parse::<f64>().unwrap(), value);
        }
    }
}
