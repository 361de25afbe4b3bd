//! A calibration as named arrays: what NumPy and MATLAB are given.

use super::code::input_by_input;
use super::facts::Fact;
use crate::calibration::{Calibration, Kernel, Learned, LinearMap, Network};
use crate::formats::{Array, Entry};

/// Everything that a fit leaves behind but the kernel's band.
///
/// `units` are those of the axes, in characters that readers know. Weights of layers stand input by input: `values @ weights + biases`.
pub(super) fn arrays(
    calibration: &Calibration,
    facts: &[Fact],
    units: impl Iterator<Item = String>,
) -> Vec<Entry> {
    let features = &calibration.features;
    let scale = &calibration.gauge_scale;
    let about = facts.iter().map(|(name, text)| format!("{name}: {text}"));
    let symbols = calibration.axes.iter().map(|axis| axis.symbol().to_owned());
    let look_backs = features.look_backs.iter();
    let quality = &calibration.quality;
    let mut arrays = vec![
        texts("about", about),
        texts("gauges", calibration.gauges.iter().cloned()),
        texts("axes", symbols),
        texts("units", units),
        vector("full_scale", &calibration.full_scale),
        vector("offset", &[f64::from(u8::from(calibration.offset))]),
        vector("distance_weights", &calibration.distance_weights()),
        vector(
            "f_th",
            &look_backs.clone().map(|l| l.f_th).collect::<Vec<_>>(),
        ),
        vector(
            "t_th_secs",
            &look_backs.map(|l| l.t_th_secs).collect::<Vec<_>>(),
        ),
        vector("fixed_lags_secs", &features.fixed_lags_secs),
        vector("creep_secs", &features.creep_secs),
        vector("play_radii", &features.play_radii),
        vector("polynomial", &[f64::from(features.polynomial)]),
        vector("gauge_shift", &scale.shift),
        vector("gauge_inverse_scale", &scale.inverse_scale),
        vector("gauge_deviation", &scale.deviation),
        texts("trained_on", calibration.trained_on.iter().cloned()),
    ];
    for (name, rmse) in [
        ("conventional_test_rmse", &quality.conventional.test_rmse),
        ("conventional_left_out_rmse", &quality.conventional.cv_rmse),
        ("compensated_test_rmse", &quality.compensated.test_rmse),
        ("compensated_left_out_rmse", &quality.compensated.cv_rmse),
    ] {
        arrays.extend(rmse.as_ref().map(|rmse| vector(name, rmse)));
    }
    let map = |name: &str, map: &LinearMap| {
        let features = map.names(&calibration.gauges).into_iter();
        [
            matrix(name, &map.matrix),
            texts(&format!("{name}_features"), features),
        ]
    };
    arrays.extend(map("conventional", &calibration.conventional));
    let compensated = calibration.compensated.iter();
    arrays.extend(compensated.flat_map(|own| map("compensated", own)));
    match &calibration.learned {
        Some(Learned::Network(network)) => arrays.extend(of_network(network)),
        Some(Learned::Kernel(kernel)) => arrays.extend(of_kernel(kernel)),
        None => {}
    }
    arrays
}

/// A matrix, row-major; one row is a vector.
fn numbers(name: &str, n_columns: usize, values: Vec<f64>) -> Entry {
    let shape = match values.len() == n_columns {
        true => vec![n_columns],
        false => vec![values.len() / n_columns.max(1), n_columns],
    };
    Entry::Numbers(Array {
        name: name.to_owned(),
        shape,
        values,
        ..Array::default()
    })
}

fn vector(name: &str, values: &[f64]) -> Entry {
    numbers(name, values.len(), values.to_vec())
}

fn matrix(name: &str, rows: &[Vec<f64>]) -> Entry {
    numbers(name, rows.first().map_or(0, Vec::len), rows.concat())
}

fn texts(name: &str, texts: impl Iterator<Item = String>) -> Entry {
    Entry::Texts {
        name: name.to_owned(),
        texts: texts.collect(),
    }
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
        matrix("landmarks", &kernel.landmarks),
        matrix("kernel_weights", &kernel.weights),
        vector("kernel_offset", &kernel.offset),
    ]
}
