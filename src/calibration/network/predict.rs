//! From inputs to loads, in double precision.
//!
//! Guarantees: many samples at once and one alone give the same numbers to within rounding; one alone allocates
//! nothing; an input that is not a finite number gives loads that are none, in its own sample only.

use rayon::prelude::*;

use super::Network;
use super::passes::Forward;

/// Samples that go through the network together; their values stay in the second-level cache.
const BLOCK_SAMPLES: usize = 256;

/// Memory for [`Network::predict_one`].
#[derive(Clone, Debug)]
pub struct Scratch {
    values: Vec<f64>,
    outputs: Vec<f64>,
}

impl Network {
    /// Predicts many samples, on all threads of the pool it is called from; the numbers do not depend on how many.
    ///
    /// **Shapes** `inputs` is `n × n_inputs`, `out` is `n × n_targets`, both row-major.
    ///
    /// # Panics
    /// If the shapes differ from these, or the network is not one that [`Network::validate`] accepts.
    pub fn predict_rows(&self, inputs: &[f64], out: &mut [f64]) {
        let (n_inputs, n_targets) = (self.n_inputs(), self.n_targets());
        let n = inputs.len() / n_inputs;
        assert_eq!(inputs.len(), n * n_inputs, "input rows must be whole");
        assert_eq!(out.len(), n * n_targets, "one row of loads per sample");
        let (shape, parameters) = (self.shape(), self.parameters::<f64>());
        let blocks = inputs.par_chunks(BLOCK_SAMPLES * n_inputs);
        out.par_chunks_mut(BLOCK_SAMPLES * n_targets)
            .zip(blocks)
            .for_each_init(
                || Forward::new(&shape, BLOCK_SAMPLES.min(n)),
                |forward, (out, inputs)| {
                    for (column, row) in forward.inputs().zip(inputs.chunks_exact(n_inputs)) {
                        self.standardise(row, column);
                    }
                    let outputs = forward.run(&parameters, out.len() / n_targets);
                    for (row, outputs) in
                        (out.chunks_exact_mut(n_targets)).zip(outputs.chunks_exact(n_targets))
                    {
                        self.restore(outputs, row);
                    }
                },
            );
    }

    /// Memory that [`Network::predict_one`] can use again and again.
    pub fn scratch(&self) -> Scratch {
        let widths = self.layers.iter().map(|layer| layer.biases.len());
        let widest = widths.chain([self.n_inputs()]).max().unwrap_or(0);
        Scratch {
            values: vec![0.0; widest],
            outputs: vec![0.0; widest],
        }
    }

    /// Predicts one sample without allocating.
    ///
    /// **Shapes** `inputs` is `n_inputs`, `out` is `n_targets`; `scratch` comes from [`Network::scratch`].
    ///
    /// # Panics
    /// If the shapes differ from these, the scratch is that of a smaller network, or the network is not one that
    /// [`Network::validate`] accepts.
    pub fn predict_one(&self, inputs: &[f64], scratch: &mut Scratch, out: &mut [f64]) {
        assert_eq!(inputs.len(), self.n_inputs(), "one number per input");
        assert_eq!(out.len(), self.n_targets(), "one number per target");
        pulp::Arch::new().dispatch(One {
            network: self,
            inputs,
            scratch,
            out,
        });
    }

    #[inline(always)]
    fn standardise(&self, inputs: &[f64], values: &mut [f64]) {
        let scales = self.input_shift.iter().zip(&self.input_inverse_scale);
        for ((value, input), (shift, inverse_scale)) in values.iter_mut().zip(inputs).zip(scales) {
            let z = (input - shift) * inverse_scale;
            // A rectifier could turn an infinite value into a finite load.
            *value = if z.is_finite() { z } else { f64::NAN };
        }
    }

    #[inline(always)]
    fn restore(&self, outputs: &[f64], loads: &mut [f64]) {
        let scales = self.target_shift.iter().zip(&self.target_scale);
        for ((load, output), (shift, scale)) in loads.iter_mut().zip(outputs).zip(scales) {
            *load = shift + scale * output;
        }
    }
}

/// Compiled for each instruction set; which one is decided when the program runs.
struct One<'a> {
    network: &'a Network,
    inputs: &'a [f64],
    scratch: &'a mut Scratch,
    out: &'a mut [f64],
}

impl pulp::WithSimd for One<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Scratch { values, outputs } = self.scratch;
        self.network.standardise(self.inputs, values);
        let mut fan_in = self.inputs.len();
        for (at, layer) in self.network.layers.iter().enumerate() {
            let last = at + 1 == self.network.layers.len();
            let units = layer.weights.iter().zip(&layer.biases);
            for (output, (row, &bias)) in outputs.iter_mut().zip(units) {
                let sum = f64::from(bias) + dot(row, &values[..fan_in]);
                *output = if sum < 0.0 && !last { 0.0 } else { sum };
            }
            fan_in = layer.biases.len();
            std::mem::swap(values, outputs);
        }
        self.network.restore(&values[..fan_in], self.out);
    }
}

/// Sums that run side by side, so that they need not wait for each other.
const LANES: usize = 16;

#[inline(always)]
fn dot(weights: &[f32], values: &[f64]) -> f64 {
    let (weights, last_weights) = weights.as_chunks::<LANES>();
    let (values, last_values) = values.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (weights, values) in weights.iter().zip(values) {
        for lane in 0..LANES {
            sums[lane] += f64::from(weights[lane]) * values[lane];
        }
    }
    let last: f64 = (last_weights.iter().zip(last_values))
        .map(|(weight, value)| f64::from(*weight) * value)
        .sum();
    sums.iter().sum::<f64>() + last
}

#[cfg(test)]
mod tests {
    use super::super::fitted::tests::any_network;
    use super::*;

    /// Rows about the shifts of [`any_network`].
    fn rows(n: usize) -> Vec<f64> {
        (0..n)
            .flat_map(|k| {
                let phase = k as f64;
                [3.0 + 0.2 * phase.sin(), -1e6 + 1e5 * (1.7 * phase).cos()]
            })
            .collect()
    }

    /// One unit: z = (x − 3)·10, w·z + b rectified, out of it y = 7 + 2·(v·h + c).
    #[test]
    fn a_small_network_gives_what_it_should() {
        let mut network = any_network(&[1]);
        network.layers[0].weights = vec![vec![0.5, 0.0]];
        network.layers[0].biases = vec![1.0];
        network.layers[1].weights = vec![vec![0.25], vec![0.0]];
        network.layers[1].biases = vec![-1.0, 0.0];
        let mut out = [0.0; 4];
        // z = 4: h = 3, y = 7 + 2·(0.75 − 1); z = −10: h = 0, y = 7 − 2.
        network.predict_rows(&[3.4, 0.0, 2.0, 0.0], &mut out);
        for (actual, expected) in out.iter().zip([6.5, 1e-4, 5.0, 1e-4]) {
            assert!((actual - expected).abs() < 1e-12, "{actual} {expected}");
        }
    }

    #[test]
    fn one_sample_gives_what_many_give() {
        for hidden in [&[][..], &[1], &[40], &[100, 33, 17]] {
            let network = any_network(hidden);
            let mut scratch = network.scratch();
            let inputs = rows(2 * BLOCK_SAMPLES + 3);
            let mut many = vec![0.0; inputs.len()];
            network.predict_rows(&inputs, &mut many);
            for (inputs, many) in inputs.chunks_exact(2).zip(many.chunks_exact(2)) {
                let mut one = [0.0; 2];
                network.predict_one(inputs, &mut scratch, &mut one);
                for (one, many) in one.iter().zip(many) {
                    assert!((one - many).abs() <= 1e-12 * many.abs(), "{one} {many}");
                }
            }
        }
    }

    #[test]
    fn an_input_that_is_no_number_spoils_its_own_sample_only() {
        let network = any_network(&[8, 8]);
        for wrong in [f64::NAN, f64::INFINITY] {
            let mut inputs = rows(3);
            inputs[2] = wrong;
            let mut out = [0.0; 6];
            network.predict_rows(&inputs, &mut out);
            assert_eq!(
                out.map(f64::is_nan),
                [false, false, true, true, false, false]
            );
            network.predict_one(&inputs[2..4], &mut network.scratch(), &mut out[..2]);
            assert!(out[0].is_nan());
        }
    }

    #[test]
    fn no_samples_give_no_loads() {
        any_network(&[4]).predict_rows(&[], &mut []);
    }
}
