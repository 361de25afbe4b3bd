//! Trained network as stored in a file. Weights are stored in single precision, so they are short and are read back exactly.

use serde::{Deserialize, Serialize};

use super::passes::{Real, Shape};
use super::samples::Scale;
use crate::calibration::{
    entries::{check_length, check_numbers},
    error::{CalibrationError, LARGEST},
};

/// Layer of a network: `outputs = weights · inputs + biases`. In every layer but the last, negative outputs become zero.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// Weights: one row per output, one entry per input.
    pub weights: Vec<Vec<f32>>,
    pub biases: Vec<f32>,
}

/// Trained network: `load = target_shift + target_scale · layers((inputs − input_shift) · input_inverse_scale)`.
///
/// **Source** section 4.2.1 of the paper of Koike et al. (2019), which does not describe standardisation, optimiser and seed.
///
/// **Units** shifts and scales have the units of their columns; all other numbers have none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Network {
    /// Mean of each input over the training samples.
    pub input_shift: Vec<f64>,
    /// Inverse standard deviation of each input; zero for a constant input, which is then ignored.
    pub input_inverse_scale: Vec<f64>,
    /// Layers from the inputs to the outputs; at least one.
    pub layers: Vec<Layer>,
    /// Mean of each target over the training samples.
    pub target_shift: Vec<f64>,
    /// Standard deviation of each target; zero for a constant target, which is then predicted exactly.
    pub target_scale: Vec<f64>,
}

impl Network {
    /// Returns the number of inputs.
    pub fn n_inputs(&self) -> usize {
        self.input_shift.len()
    }

    /// Returns the number of targets.
    pub fn n_targets(&self) -> usize {
        self.target_shift.len()
    }

    /// Returns the number of weights and biases.
    pub fn n_parameters(&self) -> usize {
        let count =
            |layer: &Layer| layer.weights.iter().map(Vec::len).sum::<usize>() + layer.biases.len();
        self.layers.iter().map(count).sum()
    }

    /// Multiplies the predictions of the network by one factor per target.
    pub(crate) fn scale(&mut self, shares: &[f64]) {
        let targets = self.target_shift.iter_mut().zip(&mut self.target_scale);
        for ((shift, scale), share) in targets.zip(shares) {
            *shift *= share;
            *scale *= share;
        }
    }

    /// Checks shapes and numbers of a network from a file, so that it predicts without panic.
    pub fn validate(&self, n_inputs: usize, n_targets: usize) -> Result<(), CalibrationError> {
        if n_inputs == 0 || n_targets == 0 {
            return Err(CalibrationError::NoColumns);
        }
        let place = |field: &str| format!("learned.network.{field}");
        if self.layers.is_empty() {
            return check_length(&place("layers"), 1, 0);
        }
        for (field, expected, numbers, least) in [
            ("input_shift", n_inputs, &self.input_shift, -LARGEST),
            ("input_inverse_scale", n_inputs, &self.input_inverse_scale, 0.0),
            ("target_shift", n_targets, &self.target_shift, -LARGEST),
            ("target_scale", n_targets, &self.target_scale, 0.0),
        ] {
            check_numbers(&place(field), expected, numbers, least)?;
        }
        let check_weights = |field: &str, expected, weights: &[f32]| {
            let weights: Vec<f64> = weights.iter().copied().map(f64::from).collect();
            check_numbers(field, expected, &weights, -LARGEST)
        };
        let mut fan_in = n_inputs;
        for (at, layer) in self.layers.iter().enumerate() {
            let of = |field: &str| place(&format!("layers[{at}].{field}"));
            let fan_out = if at + 1 == self.layers.len() { n_targets } else { layer.biases.len() };
            if fan_out == 0 {
                return check_length(&of("biases"), 1, 0);
            }
            check_weights(&of("biases"), fan_out, &layer.biases)?;
            check_length(&of("weights"), fan_out, layer.weights.len())?;
            for (unit, row) in layer.weights.iter().enumerate() {
                check_weights(&of(&format!("weights[{unit}]")), fan_in, row)?;
            }
            fan_in = fan_out;
        }
        Ok(())
    }

    pub(super) fn shape(&self) -> Shape {
        let units: Vec<usize> = self.layers.iter().map(|layer| layer.biases.len()).collect();
        let hidden = &units[..units.len().saturating_sub(1)];
        Shape::new(self.n_inputs(), hidden, self.n_targets())
    }

    pub(super) fn parameters<T: Real>(&self) -> Vec<T> {
        let mut parameters = Vec::with_capacity(self.n_parameters());
        for layer in &self.layers {
            for input in 0..layer.weights.first().map_or(0, Vec::len) {
                parameters.extend(layer.weights.iter().map(|row| T::from(row[input])));
            }
            parameters.extend(layer.biases.iter().map(|&bias| T::from(bias)));
        }
        parameters
    }

    /// Creates a network from parameters in the order of [`Network::parameters`].
    pub(super) fn from_parameters(
        shape: &Shape,
        parameters: &[f32],
        inputs: &Scale,
        targets: &Scale,
    ) -> Self {
        let layer = |layer: usize| {
            let values = &parameters[shape.parameters(layer)];
            let (fan_in, fan_out) = (shape.fan_in(layer), shape.fan_out(layer));
            let row = |unit| (0..fan_in).map(|input| values[input * fan_out + unit]).collect();
            Layer {
                weights: (0..fan_out).map(row).collect(),
                biases: values[fan_in * fan_out..].to_vec(),
            }
        };
        Self {
            input_shift: inputs.shift.clone(),
            input_inverse_scale: inputs.inverse_spread(),
            layers: (0..shape.n_layers()).map(layer).collect(),
            target_shift: targets.shift.clone(),
            target_scale: targets.spread.clone(),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::random::Random;

    /// Returns a network of random numbers with two inputs and two targets.
    pub(in super::super) fn any_network(hidden: &[usize]) -> Network {
        let shape = Shape::new(2, hidden, 2);
        let mut random = Random::new(8, &[]);
        let parameters: Vec<f32> =
            (0..shape.n_parameters()).map(|_| random.between(-0.5, 0.5) as f32).collect();
        let scale = |shift, spread| Scale { shift, spread };
        let inputs = scale(vec![3.0, -1e6], vec![0.1, 1e5]);
        Network::from_parameters(
            &shape,
            &parameters,
            &inputs,
            &scale(vec![7.0, 1e-4], vec![2.0, 1e-6]),
        )
    }

    #[test]
    fn parameters_keep_their_order() {
        let network = any_network(&[3, 5]);
        let parameters = network.parameters::<f32>();
        assert_eq!(parameters.len(), (2 + 1) * 3 + (3 + 1) * 5 + (5 + 1) * 2);
        assert_eq!(network.n_parameters(), parameters.len());
        let scale = |shift: &[f64], spread: Vec<f64>| Scale { shift: shift.to_vec(), spread };
        let again = Network::from_parameters(
            &network.shape(),
            &parameters,
            &scale(&network.input_shift, vec![0.1, 1e5]),
            &scale(&network.target_shift, network.target_scale.clone()),
        );
        assert_eq!(network, again);
    }

    #[test]
    fn a_file_gives_the_same_network() {
        let network = any_network(&[30, 20]);
        let text = serde_json::to_string(&network).unwrap();
        let again: Network = serde_json::from_str(&text).unwrap();
        assert_eq!(again, network);
        assert_eq!(again.validate(2, 2), Ok(()));
    }

    #[test]
    fn a_file_edited_wrongly_is_refused_by_field() {
        let refused = |change: fn(&mut Network)| {
            let mut network = any_network(&[3, 4]);
            change(&mut network);
            match network.validate(2, 2) {
                Err(
                    CalibrationError::Length { field, .. } | CalibrationError::Number { field, .. },
                ) => field.strip_prefix("learned.network.").unwrap().to_owned(),
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(refused(|n| n.layers.clear()), "layers");
        assert_eq!(refused(|n| n.input_shift.push(0.0)), "input_shift");
        assert_eq!(refused(|n| n.input_inverse_scale[0] = -1.0), "input_inverse_scale");
        assert_eq!(refused(|n| n.target_scale[1] = f64::INFINITY), "target_scale");
        assert_eq!(refused(|n| n.target_shift[1] = f64::NAN), "target_shift");
        assert_eq!(refused(|n| n.layers[1].biases.clear()), "layers[1].biases");
        assert_eq!(refused(|n| n.layers[2].biases.truncate(1)), "layers[2].biases");
        assert_eq!(refused(|n| n.layers[0].biases[2] = f32::NAN), "layers[0].biases");
        assert_eq!(refused(|n| n.layers[1].weights.truncate(3)), "layers[1].weights");
        assert_eq!(refused(|n| n.layers[1].weights[2].push(0.0)), "layers[1].weights[2]");
        assert_eq!(refused(|n| n.layers[0].weights[0][1] = f32::INFINITY), "layers[0].weights[0]");
        assert_eq!(
            refused(|n| {
                n.layers.pop();
            }),
            "layers[1].biases"
        );
    }

    /// A number in the file beyond the range of single precision is read as infinite.
    #[test]
    fn a_weight_too_large_for_the_file_is_refused() {
        let text = serde_json::to_string(&any_network(&[])).unwrap();
        let bias = any_network(&[]).layers[0].biases[0].to_string();
        assert!(text.contains(&bias));
        let read: Result<Network, _> = serde_json::from_str(&text.replace(&bias, "1e300"));
        assert!(read.is_err() || read.is_ok_and(|network| network.validate(2, 2).is_err()));
    }
}
