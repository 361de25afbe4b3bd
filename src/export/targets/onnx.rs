//! Networks as ONNX: from a row of features to the compensated load, in single precision.
//!
//! The row is: gauges less their centre; for each history of the blocks the gauges then less the present ones; monomials of
//! the standardised gauges. Centre, scales and the names of the columns stand in the model's metadata. The blocks that make
//! the row are not in the model: it has no memory.
//!
//! **Source** onnx.proto (field numbers), opset 13; protobuf encoding.

use std::io;

use crate::calibration::network::Layer;
use crate::calibration::{Calibration, Learned, Learner, Network, Regressor};
use crate::export::code::{LearnedProgram, Program};
use crate::export::facts::Fact;
use crate::export::target::{Export, Outline, Refusal, Target};

/// `.onnx`.
pub(super) struct Onnx;

impl Target for Onnx {
    fn name(&self) -> &'static str {
        "ONNX network"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["onnx"]
    }

    fn holds(&self) -> &'static str {
        "from a row of features to the compensated load"
    }

    fn leaves_out(&self, _calibration: &Calibration) -> &'static str {
        "the blocks that make the row, the conventional load"
    }

    fn check(&self, outline: &Outline<'_>) -> Result<(), Refusal> {
        match outline.learner {
            Some(Learner::Network) => Ok(()),
            _ => Err(Box::new(NoNetwork {
                regressor: outline.regressor,
            })),
        }
    }

    fn write(&self, export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        write(export.calibration, &export.facts, out)
    }
}

/// A calibration that no network is part of.
#[derive(Debug, thiserror::Error)]
#[error(
    "ONNX holds networks, and this calibration ({}) has none; use .h, .py, .npz or .json, or fit a network", .regressor.label()
)]
struct NoNetwork {
    regressor: Regressor,
}

/// Version of the file's structure, and of the operators: both old enough for any runtime in use.
const IR_VERSION: u64 = 7;
const OPSET: u64 = 13;
const FLOAT: u64 = 1;

/// Writes the model; nothing for a calibration without a network, which is refused.
fn write(calibration: &Calibration, facts: &[Fact], out: &mut dyn io::Write) -> io::Result<()> {
    let program = Program::new(calibration);
    let Some(LearnedProgram {
        inputs,
        regression: Learned::Network(network),
    }) = &program.learned
    else {
        return Ok(());
    };
    let mut graph = Graph::default();
    graph.network(inputs, network);
    if let Some(linear) = &program.linear {
        // Hybrid: what the network gives is added to what is linear in the row.
        graph.matrix("linear", &linear.matrix);
        graph.vector("linear_base", &linear.base);
        graph.node(
            "Gemm",
            &["row", "linear", "linear_base"],
            "linear_load",
            true,
        );
        graph.node("Add", &["linear_load", "learned"], "load", false);
    } else {
        graph.node("Identity", &["learned"], "load", false);
    }
    let n_axes = calibration.axes.len();
    let mut model = Message::default();
    model.number(1, IR_VERSION);
    model.text(2, "LoopScope");
    model.text(3, env!("CARGO_PKG_VERSION"));
    model.text(6, "From a row of features to the load of a force/torque sensor; see metadata_props for the row.");
    model.message(7, &graph.finish(program.n_columns, n_axes));
    let mut opset = Message::default();
    opset.text(1, "");
    opset.number(2, OPSET);
    model.message(8, &opset);
    let row = row_metadata(calibration, &program).map(|(name, text)| (name.into(), text));
    for (key, value) in facts.iter().cloned().chain(row) {
        let mut entry = Message::default();
        entry.text(1, &key);
        entry.text(2, &value);
        model.message(14, &entry);
    }
    out.write_all(&model.0)
}

/// How the row is made, for whoever runs the model.
fn row_metadata(
    calibration: &Calibration,
    program: &Program,
) -> impl Iterator<Item = (&'static str, String)> {
    let list = |values: &mut dyn Iterator<Item = f64>| {
        let texts: Vec<String> = values.map(|value| value.to_string()).collect();
        texts.join(" ")
    };
    let mut names = calibration.feature_names();
    names.truncate(program.n_columns);
    [
        (
            "row",
            "gauges less row_centre; each history less the present gauges; monomials of the gauges less row_centre, times \
             row_factor, plus row_constant; auxiliary channels as the file of the calibration says"
                .to_owned(),
        ),
        ("row_columns", names.join(" ")),
        ("row_centre", list(&mut program.centre.iter().copied())),
        (
            "row_factor",
            list(&mut program.standardise.iter().map(|(factor, _)| *factor)),
        ),
        (
            "row_constant",
            list(&mut program.standardise.iter().map(|(_, constant)| *constant)),
        ),
    ]
    .into_iter()
}

/// Nodes and constants of a graph, in the order in which they run.
#[derive(Default)]
struct Graph(Message);

impl Graph {
    fn network(&mut self, inputs: &[(f64, f64)], network: &Network) {
        let factors: Vec<f64> = inputs.iter().map(|(factor, _)| *factor).collect();
        let constants: Vec<f64> = inputs.iter().map(|(_, constant)| *constant).collect();
        self.vector("input_factor", &factors);
        self.vector("input_constant", &constants);
        self.node("Mul", &["row", "input_factor"], "scaled", false);
        self.node("Add", &["scaled", "input_constant"], "values_0", false);
        let n_layers = network.layers.len();
        for (at, layer) in network.layers.iter().enumerate() {
            let [weights, biases, sums, input, output] = [
                format!("weights_{at}"),
                format!("biases_{at}"),
                format!("sums_{at}"),
                format!("values_{at}"),
                format!("values_{}", at + 1),
            ];
            self.layer(&weights, &biases, layer);
            self.node("Gemm", &[&input, &weights, &biases], &sums, true);
            let kind = if at + 1 == n_layers {
                "Identity"
            } else {
                "Relu"
            };
            self.node(kind, &[&sums], &output, false);
        }
        self.vector("target_scale", &network.target_scale);
        self.vector("target_shift", &network.target_shift);
        let outputs = format!("values_{n_layers}");
        self.node("Mul", &[&outputs, "target_scale"], "scaled_load", false);
        self.node("Add", &["scaled_load", "target_shift"], "learned", false);
    }

    fn layer(&mut self, weights: &str, biases: &str, layer: &Layer) {
        let rows = layer.weights.concat();
        let width = rows.len() / layer.biases.len().max(1);
        self.tensor(weights, &[layer.biases.len(), width], rows.into_iter());
        self.tensor(biases, &[layer.biases.len()], layer.biases.iter().copied());
    }

    fn vector(&mut self, name: &str, values: &[f64]) {
        self.tensor(
            name,
            &[values.len()],
            values.iter().map(|value| *value as f32),
        );
    }

    fn matrix(&mut self, name: &str, rows: &[Vec<f64>]) {
        let width = rows.first().map_or(0, Vec::len);
        let values = rows.iter().flatten().map(|value| *value as f32);
        self.tensor(name, &[rows.len(), width], values);
    }

    fn tensor(&mut self, name: &str, shape: &[usize], values: impl Iterator<Item = f32>) {
        let mut tensor = Message::default();
        for length in shape {
            tensor.number(1, *length as u64);
        }
        tensor.number(2, FLOAT);
        tensor.text(8, name);
        let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
        tensor.bytes(9, &bytes);
        self.0.message(5, &tensor);
    }

    /// `transposed`: the second input of Gemm has one row per output, as in the calibration.
    fn node(&mut self, kind: &str, inputs: &[&str], output: &str, transposed: bool) {
        let mut node = Message::default();
        for input in inputs {
            node.text(1, input);
        }
        node.text(2, output);
        node.text(3, output);
        node.text(4, kind);
        if transposed {
            const INT: u64 = 2;
            let mut attribute = Message::default();
            attribute.text(1, "transB");
            attribute.number(3, 1);
            attribute.number(20, INT);
            node.message(5, &attribute);
        }
        self.0.message(1, &node);
    }

    fn finish(mut self, n_columns: usize, n_axes: usize) -> Message {
        self.0.text(2, "calibration");
        self.0.message(11, &value_info("row", n_columns));
        self.0.message(12, &value_info("load", n_axes));
        self.0
    }
}

/// A batch of any size of rows of so many floats.
fn value_info(name: &str, width: usize) -> Message {
    let mut batch = Message::default();
    batch.text(2, "samples");
    let mut columns = Message::default();
    columns.number(1, width as u64);
    let mut shape = Message::default();
    shape.message(1, &batch);
    shape.message(1, &columns);
    let mut tensor = Message::default();
    tensor.number(1, FLOAT);
    tensor.message(2, &shape);
    let mut kind = Message::default();
    kind.message(1, &tensor);
    let mut info = Message::default();
    info.text(1, name);
    info.message(2, &kind);
    info
}

/// A message of protobuf: fields with their numbers.
#[derive(Default)]
struct Message(Vec<u8>);

impl Message {
    fn varint(&mut self, mut value: u64) {
        while value > 0x7f {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    fn number(&mut self, field: u64, value: u64) {
        self.varint(field << 3);
        self.varint(value);
    }

    fn bytes(&mut self, field: u64, bytes: &[u8]) {
        self.varint(field << 3 | 2);
        self.varint(bytes.len() as u64);
        self.0.extend(bytes);
    }

    fn text(&mut self, field: u64, text: &str) {
        self.bytes(field, text.as_bytes());
    }

    fn message(&mut self, field: u64, message: &Self) {
        self.bytes(field, &message.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The two examples of the protobuf encoding guide: 150 in field 1, "testing" in field 2.
    #[test]
    fn messages_are_encoded_as_in_the_guide() {
        let mut message = Message::default();
        message.number(1, 150);
        message.text(2, "testing");
        assert_eq!(message.0, b"\x08\x96\x01\x12\x07testing");
    }
}
