//! Predicts loads with a trained network in double precision.
//!
//! Guarantees: except for rounding, the load of a sample does not depend on other samples. A non-finite input gives NaN.

use rayon::prelude::*;

use super::passes::Forward;
use crate::calibration::network::fitted::Network;

/// Number of samples that are predicted together. The values of all units for them fit into the second-level cache.
const BLOCK_SAMPLES: usize = 256;

impl Network {
    /// Predicts `n × n_targets` loads from `n × n_inputs` inputs, on all threads of the current pool. The number of threads
    /// does not change the result. Panics if `inputs` or `out` has another length, or if [`Network::validate`] would fail.
    pub fn predict_rows(&self, inputs: &[f64], out: &mut [f64]) {
        let (n_inputs, n_targets) = (self.n_inputs(), self.n_targets());
        let n = inputs.len() / n_inputs;
        assert_eq!(inputs.len(), n * n_inputs, "each input row must have n_inputs numbers");
        assert_eq!(out.len(), n * n_targets, "there must be one row of loads per sample");
        let (shape, parameters) = (self.shape(), self.parameters::<f64>());
        let blocks = inputs.par_chunks(BLOCK_SAMPLES * n_inputs);
        out.par_chunks_mut(BLOCK_SAMPLES * n_targets).zip(blocks).for_each_init(
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

    fn standardise(&self, inputs: &[f64], values: &mut [f64]) {
        let scales = self.input_shift.iter().zip(&self.input_inverse_scale);
        for ((value, input), (shift, inverse_scale)) in values.iter_mut().zip(inputs).zip(scales) {
            let z = (input - shift) * inverse_scale;
            // An infinite input counts as NaN, because the rectifier could turn it into a finite load.
            *value = if z.is_finite() { z } else { f64::NAN };
        }
    }

    fn restore(&self, outputs: &[f64], loads: &mut [f64]) {
        let scales = self.target_shift.iter().zip(&self.target_scale);
        for ((load, output), (shift, scale)) in loads.iter_mut().zip(outputs).zip(scales) {
            *load = shift + scale * output;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fitted::tests::any_network;
    use super::*;

    /// Returns rows near the shifts of [`any_network`].
    fn rows(n: usize) -> Vec<f64> {
        (0..n)
            .flat_map(|k| {
                let phase = k as f64;
                [3.0 + 0.2 * phase.sin(), -1e6 + 1e5 * (1.7 * phase).cos()]
            })
            .collect()
    }

    /// One unit: z = (x − 3)·10, h = w·z + b rectified, y = 7 + 2·(v·h + c).
    #[test]
    fn a_small_network_gives_the_computed_load() {
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
    fn one_sample_and_many_give_the_same() {
        for hidden in [&[][..], &[1], &[40], &[100, 33, 17]] {
            let network = any_network(hidden);
            let inputs = rows(2 * BLOCK_SAMPLES + 3);
            let mut many = vec![0.0; inputs.len()];
            network.predict_rows(&inputs, &mut many);
            for (inputs, many) in inputs.chunks_exact(2).zip(many.chunks_exact(2)) {
                let mut one = [0.0; 2];
                network.predict_rows(inputs, &mut one);
                for (one, many) in one.iter().zip(many) {
                    assert!((one - many).abs() <= 1e-12 * many.abs(), "{one} {many}");
                }
            }
        }
    }

    #[test]
    fn a_non_finite_input_affects_only_its_own_sample() {
        let network = any_network(&[8, 8]);
        for wrong in [f64::NAN, f64::INFINITY] {
            let mut inputs = rows(3);
            inputs[2] = wrong;
            let mut out = [0.0; 6];
            network.predict_rows(&inputs, &mut out);
            assert_eq!(out.map(f64::is_nan), [false, false, true, true, false, false]);
            network.predict_rows(&inputs[2..4], &mut out[..2]);
            assert!(out[0].is_nan());
        }
    }

    #[test]
    fn no_samples_give_no_loads() {
        any_network(&[4]).predict_rows(&[], &mut []);
    }
}
