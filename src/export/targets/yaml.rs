//! Calibrations as parameters of ROS 2 for `ros2 param load` and `--params-file`.
//!
//! Guarantees, as ROS 2 requires: the parameters are for all nodes (`/**`). Each is a flag, a number, a text or a list of
//! these. No list is empty or nested. A real number always has a decimal point. A matrix is one row-major list, beside its
//! numbers of rows and columns. Empty parts are omitted, so a feature block without parameters in the file is not used.

use std::io;

use crate::export::{
    fields::{Field, Value, fields},
    target::{Export, Target, linear_parts},
    text::for_yaml,
};

pub(super) static YAML: Target = Target {
    name: "ROS 2 parameters (YAML)",
    purpose: "ROS 2",
    endings: &["yaml", "yml"],
    holds: "matrices, settings of the feature blocks, scales, rule for gaps",
    leaves_out: |calibration| match calibration.learned {
        Some(_) => "the network or kernel, so the compensated load is incomplete",
        None => "nothing",
    },
    write,
    parts: linear_parts,
    ..Target::PLAIN
};

fn write(export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
    writeln!(out, "/**:\n  ros__parameters:\n    about:")?;
    for (name, text) in &export.facts {
        writeln!(out, "      {}: {}", key(name), for_yaml(text))?;
    }
    let mut open = "";
    for field in fields(export.calibration) {
        let entries = entries(&field);
        if entries.is_empty() {
            continue;
        }
        if field.group != open {
            open = field.group;
            writeln!(out, "    {open}:")?;
        }
        let indent = if open.is_empty() { "    " } else { "      " };
        if !field.about.is_empty() {
            writeln!(out, "{indent}# {}", field.about)?;
        }
        for (name, value) in entries {
            writeln!(out, "{indent}{name}: {value}")?;
        }
    }
    Ok(())
}

/// Returns a parameter name that consists only of letters, digits and underscores, as ROS 2 requires.
fn key(name: &str) -> String {
    let name =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' });
    name.collect()
}

/// Returns a part of the calibration as ROS 2 parameters; an empty part gives none.
fn entries(field: &Field) -> Vec<(&'static str, String)> {
    let listed = |texts: Vec<String>| {
        if texts.is_empty() {
            Vec::new()
        } else {
            vec![(field.name, format!("[{}]", texts.join(", ")))]
        }
    };
    let numbers = |values: &[f64]| listed(values.iter().copied().map(number).collect());
    match &field.value {
        Value::Flag(flag) => vec![(field.name, flag.to_string())],
        Value::Flags(flags) => listed(flags.iter().map(bool::to_string).collect()),
        Value::Count(count) => vec![(field.name, count.to_string())],
        Value::Number(value) => vec![(field.name, number(*value))],
        Value::Text(text) => vec![(field.name, for_yaml(text))],
        Value::Texts(texts) => listed(texts.iter().map(|text| for_yaml(text)).collect()),
        Value::Numbers(values) => numbers(values),
        Value::Matrix(rows) => {
            let columns = rows.first().map_or(0, Vec::len);
            let shape = [("n_rows", rows.len().to_string()), ("n_columns", columns.to_string())];
            shape.into_iter().chain(numbers(&rows.concat())).collect()
        }
    }
}

/// Returns a number with a decimal point, because many YAML readers take `1e-7` for a text.
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

    /// YAML 1.1 requires a point and a signed exponent in numbers with an exponent.
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
