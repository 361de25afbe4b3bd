//! A calibration as named arrays: what NumPy and MATLAB are given.

use super::code::input_by_input;
use super::facts::Fact;
use super::fields::{Value, fields};
use crate::calibration::{Calibration, Kernel, Learned, Network};

/// One array with its name.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pub name: String,
    pub content: Content,
}

/// What is in an array.
#[derive(Clone, Debug)]
pub(super) enum Content {
    /// A matrix, row-major, with its number of columns; a vector is one row.
    Numbers { columns: usize, values: Vec<f64> },
    /// One text per entry.
    Texts(Vec<String>),
}

/// Everything that a fit leaves behind but the kernel's band.
///
/// `units` are those of the axes, in characters that readers know. Weights of layers stand input by input: `values @ weights + biases`.
pub(super) fn arrays(
    calibration: &Calibration,
    facts: &[Fact],
    units: impl Iterator<Item = String>,
) -> Vec<Array> {
    let about = facts.iter().map(|(name, text)| format!("{name}: {text}"));
    let mut arrays = vec![texts("about", about)];
    let mut units = Some(units);
    for field in fields(calibration) {
        let name = match (field.group, field.name) {
            ("" | "blocks", name) => name.to_owned(),
            ("gauge_scale", name) => format!("gauge_{name}"),
            (map, "matrix") => map.to_owned(),
            (map, name) => format!("{map}_{name}"),
        };
        match field.value {
            Value::Texts(_) if name == "units" => {
                arrays.extend(units.take().map(|units| texts(&name, units)));
            }
            Value::Flag(flag) => arrays.push(vector(&name, &[f64::from(u8::from(flag))])),
            Value::Count(count) => arrays.push(vector(&name, &[f64::from(count)])),
            Value::Text(text) => arrays.push(texts(&name, std::iter::once(text))),
            Value::Texts(all) => arrays.push(texts(&name, all.into_iter())),
            Value::Numbers(values) => arrays.push(vector(&name, &values)),
            Value::Matrix(rows) => arrays.push(matrix(&name, &rows)),
            Value::Table(columns) => {
                arrays.extend(columns.iter().map(|(name, values)| vector(name, values)));
            }
        }
    }
    match &calibration.learned {
        Some(Learned::Network(network)) => arrays.extend(of_network(network)),
        Some(Learned::Kernel(kernel)) => arrays.extend(of_kernel(kernel)),
        None => {}
    }
    arrays
}

fn vector(name: &str, values: &[f64]) -> Array {
    Array {
        name: name.to_owned(),
        content: Content::Numbers {
            columns: values.len(),
            values: values.to_vec(),
        },
    }
}

fn matrix(name: &str, rows: &[Vec<f64>]) -> Array {
    Array {
        name: name.to_owned(),
        content: Content::Numbers {
            columns: rows.first().map_or(0, Vec::len),
            values: rows.concat(),
        },
    }
}

fn texts(name: &str, texts: impl Iterator<Item = String>) -> Array {
    Array {
        name: name.to_owned(),
        content: Content::Texts(texts.collect()),
    }
}

fn of_network(network: &Network) -> Vec<Array> {
    let mut arrays = vec![
        vector("input_shift", &network.input_shift),
        vector("input_inverse_scale", &network.input_inverse_scale),
        vector("target_shift", &network.target_shift),
        vector("target_scale", &network.target_scale),
    ];
    for (at, layer) in network.layers.iter().enumerate() {
        let biases: Vec<f64> = layer.biases.iter().copied().map(f64::from).collect();
        arrays.push(Array {
            name: format!("weights_{at}"),
            content: Content::Numbers {
                columns: biases.len(),
                values: input_by_input(layer).map(f64::from).collect(),
            },
        });
        arrays.push(vector(&format!("biases_{at}"), &biases));
    }
    arrays
}

fn of_kernel(kernel: &Kernel) -> Vec<Array> {
    vec![
        vector("input_shift", &kernel.input_shift),
        vector("input_scale", &kernel.input_scale),
        vector("length_scale", &[kernel.length_scale]),
        matrix("landmarks", &kernel.landmarks),
        matrix("kernel_weights", &kernel.weights),
        vector("kernel_offset", &kernel.offset),
    ]
}
