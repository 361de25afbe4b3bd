//! A calibration as named arrays, for NumPy and MATLAB.

use super::code::input_by_input;
use super::fields::{Value, fields};
use super::target::Export;
use crate::{
    calibration::{Kernel, Learned, Network},
    formats::{Array, Entry},
};

/// Returns all arrays of a calibration except the kernel's uncertainty band. The weights of a network layer have one row per
/// input, for `values @ weights + biases`.
pub(super) fn arrays(export: &Export<'_>) -> Vec<Entry> {
    let calibration = export.calibration;
    let mut arrays = vec![texts("about", export.lines(str::to_owned).collect())];
    for field in fields(calibration) {
        let name = match (field.group, field.name) {
            ("" | "blocks", name) => name.to_owned(),
            ("gauge_scale", name) => format!("gauge_{name}"),
            (map, "matrix") => map.to_owned(),
            (map, name) => format!("{map}_{name}"),
        };
        arrays.push(match field.value {
            Value::Flag(flag) => vector(&name, &[f64::from(flag)]),
            Value::Flags(flags) => {
                vector(&name, &flags.into_iter().map(f64::from).collect::<Vec<_>>())
            }
            Value::Count(count) => vector(&name, &[count as f64]),
            Value::Number(number) => vector(&name, &[number]),
            Value::Text(text) => texts(&name, vec![text]),
            Value::Texts(all) => texts(&name, all),
            Value::Numbers(values) => vector(&name, &values),
            Value::Matrix(rows) => matrix(&name, &rows),
        });
    }
    match &calibration.learned {
        Some(Learned::Network(network)) => arrays.extend(of_network(network)),
        Some(Learned::Kernel(kernel)) => arrays.extend(of_kernel(kernel)),
        None => {}
    }
    arrays
}

/// Returns an array of row-major numbers: a matrix, or a vector if there is only one row.
fn numbers(name: &str, n_columns: usize, values: Vec<f64>) -> Entry {
    let shape = if values.len() == n_columns {
        vec![n_columns]
    } else {
        vec![values.len() / n_columns.max(1), n_columns]
    };
    Entry::Numbers(Array { name: name.to_owned(), shape, values, ..Array::default() })
}

fn vector(name: &str, values: &[f64]) -> Entry {
    numbers(name, values.len(), values.to_vec())
}

fn matrix(name: &str, rows: &[Vec<f64>]) -> Entry {
    numbers(name, rows.first().map_or(0, Vec::len), rows.concat())
}

fn texts(name: &str, texts: Vec<String>) -> Entry {
    Entry::Texts { name: name.to_owned(), texts }
}

fn of_network(network: &Network) -> Vec<Entry> {
    let mut arrays = vec![
        vector("input_shift", &network.input_shift),
        vector("input_inverse_scale", &network.input_inverse_scale),
        vector("target_shift", &network.target_shift),
        vector("target_scale", &network.target_scale),
    ];
    for (at, layer) in network.layers.iter().enumerate() {
        let biases: Vec<f64> = layer.biases.iter().copied().map(f64::from).collect();
        let weights: Vec<f64> = input_by_input(layer).map(f64::from).collect();
        arrays.push(numbers(&format!("weights_{at}"), biases.len(), weights));
        arrays.push(vector(&format!("biases_{at}"), &biases));
    }
    arrays
}

fn of_kernel(kernel: &Kernel) -> Vec<Entry> {
    vec![
        vector("input_shift", &kernel.input_shift),
        vector("input_scale", &kernel.input_scale),
        vector("length_scale", &[kernel.length_scale]),
        matrix("landmarks", &Vec::from(kernel.landmarks.clone())),
        matrix("kernel_weights", &kernel.weights),
        vector("kernel_offset", &kernel.offset),
    ]
}
