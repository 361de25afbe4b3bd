//! Calibrations as YAML with plain keys and row-major matrices, as parameters of a robot are configured.

use std::io;

use crate::calibration::Calibration;
use crate::export::fields::{Field, Value, fields};
use crate::export::target::{Export, Target};
use crate::export::text::for_yaml;

/// `.yaml`.
pub(super) struct Yaml;

impl Target for Yaml {
    fn name(&self) -> &'static str {
        "YAML"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["yaml", "yml"]
    }

    fn holds(&self) -> &'static str {
        "matrices, choices of the blocks, scales"
    }

    fn leaves_out(&self, calibration: &Calibration) -> &'static str {
        match calibration.learned {
            Some(_) => "the network or kernel, without which the compensated load is not whole",
            None => "nothing",
        }
    }

    /// Writes scalars, flow lists of numbers, and texts in double quotes.
    fn write(&self, export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        writeln!(out, "about:")?;
        for (name, text) in &export.facts {
            let name = name.replace(' ', "_").to_ascii_lowercase();
            writeln!(out, "  {name}: {}", for_yaml(text))?;
        }
        let mut open = "";
        for field in fields(export.calibration) {
            if field.group != open {
                open = field.group;
                writeln!(out, "{open}:")?;
            }
            let indent = if open.is_empty() { "" } else { "  " };
            if !field.about.is_empty() {
                writeln!(out, "{indent}# {}", field.about)?;
            }
            for (name, value) in entries(&field) {
                writeln!(out, "{indent}{name}: {value}")?;
            }
        }
        Ok(())
    }
}

/// A field as YAML has it: a matrix row-major in one list, as well as rows and columns, so that a parameter of numbers holds
/// it.
fn entries(field: &Field) -> Vec<(&'static str, String)> {
    let value = match &field.value {
        Value::Flag(flag) => flag.to_string(),
        Value::Flags(flags) => format!("{flags:?}"),
        Value::Count(count) => count.to_string(),
        Value::Text(text) => for_yaml(text),
        Value::Texts(all) => texts(all),
        Value::Numbers(values) => numbers(values),
        Value::Table(columns) => {
            let rows = (0..columns.first().map_or(0, |(_, values)| values.len())).map(|row| {
                let cells = columns.iter();
                let cells = cells.map(|(name, values)| format!("{name}: {}", number(values[row])));
                format!("{{{}}}", cells.collect::<Vec<_>>().join(", "))
            });
            format!("[{}]", rows.collect::<Vec<_>>().join(", "))
        }
        Value::Matrix(rows) => {
            let columns = rows.first().map_or(0, Vec::len);
            return vec![
                ("rows", rows.len().to_string()),
                ("columns", columns.to_string()),
                (field.name, numbers(&rows.concat())),
            ];
        }
    };
    vec![(field.name, value)]
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
