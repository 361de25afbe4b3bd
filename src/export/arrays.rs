//! A calibration as named arrays: what NumPy and MATLAB are given.

use super::code::input_by_input;
use super::facts::Fact;
use crate::calibration::{Calibration, Kernel, Learned, LinearMap, Network};

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
    ];
    let blocks = features.blocks.stored();
    arrays.extend(blocks.map(|(block, stored)| vector(block.setting().key, &stored.numbers())));
    arrays.extend([
        vector("gauge_shift", &scale.shift),
        vector("gauge_inverse_scale", &scale.inverse_scale),
        vector("gauge_deviation", &scale.deviation),
        texts("trained_on", calibration.trained_on.iter().cloned()),
    ]);
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
