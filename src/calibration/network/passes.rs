//! Forward and backward pass of a network for a block of samples.
//!
//! Guarantees: memory is allocated beforehand. All work is on the calling thread. The rectifier keeps NaN, so it reaches the
//! loss.
//!
//! Layout: the values of a layer are a matrix with one column per sample. Every layer but the last has an additional unit that
//! is always one. So the biases are the last column of the weights, and one matrix product includes them.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::traits::RealField;
use faer::{Accum, MatMut, MatRef, Par};

use crate::vectorised::vectorised;

/// Floating-point type in which a network is computed.
pub(super) trait Real: RealField + Copy + PartialOrd + From<f32> {}

impl Real for f32 {}
impl Real for f64 {}

/// Returns a matrix whose columns are `stride` numbers apart in memory.
fn view<T>(values: &[T], n_rows: usize, n_columns: usize, stride: usize) -> MatRef<'_, T> {
    MatRef::from_column_major_slice_with_stride(values, n_rows, n_columns, stride)
}

/// Writes `left · right` to a matrix whose columns are `stride` numbers apart in memory. The numbers between the columns stay
/// unchanged.
fn product<T: Real>(out: &mut [T], stride: usize, left: MatRef<'_, T>, right: MatRef<'_, T>) {
    let (n_rows, n_columns) = (left.nrows(), right.ncols());
    let out = MatMut::from_column_major_slice_with_stride_mut(out, n_rows, n_columns, stride);
    matmul(out, Accum::Replace, left, right, T::from(1.0), Par::Seq);
}

/// Number of units in each layer. The inputs are the first layer, the outputs the last one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Shape(Vec<usize>);

impl Shape {
    pub fn new(n_inputs: usize, hidden: &[usize], n_targets: usize) -> Self {
        let ends = ([n_inputs], [n_targets]);
        Self([&ends.0[..], hidden, &ends.1[..]].concat())
    }

    pub fn n_layers(&self) -> usize {
        self.0.len() - 1
    }

    /// Returns the number of inputs of a layer of weights. The inputs of layer 0 are those of the network.
    pub fn fan_in(&self, layer: usize) -> usize {
        self.0[layer]
    }

    pub fn fan_out(&self, layer: usize) -> usize {
        self.0[layer + 1]
    }

    pub fn n_outputs(&self) -> usize {
        self.fan_out(self.n_layers() - 1)
    }

    /// Returns the range that a layer's weights and biases have in the list of parameters: `fan_out × (fan_in + 1)`,
    /// column-major, biases last.
    pub fn parameters(&self, layer: usize) -> Range<usize> {
        let count = |layer: usize| self.fan_out(layer) * (self.fan_in(layer) + 1);
        let start = (0..layer).map(count).sum();
        start..start + count(layer)
    }

    pub fn n_parameters(&self) -> usize {
        self.parameters(self.n_layers() - 1).end
    }

    /// Returns the number of values per sample that enter a layer, with the additional unit. For `layer = n_layers`, it is
    /// the number of network outputs.
    fn stride(&self, layer: usize) -> usize {
        self.0[layer] + usize::from(layer < self.n_layers())
    }
}

/// Forward pass: values of all units of a network for up to `capacity` samples.
#[derive(Clone, Debug)]
pub(super) struct Forward<T> {
    shape: Shape,
    capacity: usize,
    blocks: Vec<Vec<T>>,
}

impl<T: Real> Forward<T> {
    pub fn new(shape: &Shape, capacity: usize) -> Self {
        // All values start at one, because the additional units must be one and are never written.
        let blocks = (0..=shape.n_layers())
            .map(|layer| vec![T::from(1.0); shape.stride(layer) * capacity])
            .collect();
        Self { shape: shape.clone(), capacity, blocks }
    }

    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Returns the network inputs of each sample. The caller writes them before [`Forward::run`].
    pub fn inputs(&mut self) -> impl Iterator<Item = &mut [T]> {
        let n_inputs = self.shape.fan_in(0);
        self.blocks[0].chunks_exact_mut(n_inputs + 1).map(move |column| &mut column[..n_inputs])
    }

    /// Computes the network outputs of the first `n_samples` samples, `n_samples × n_outputs` row-major.
    pub fn run(&mut self, parameters: &[T], n_samples: usize) -> &[T] {
        let shape = &self.shape;
        for layer in 0..shape.n_layers() {
            let (fan_in, fan_out) = (shape.fan_in(layer), shape.fan_out(layer));
            let weights = &parameters[shape.parameters(layer)];
            let (before, after) = self.blocks.split_at_mut(layer + 1);
            let stride = shape.stride(layer + 1);
            let out = &mut after[0][..stride * n_samples];
            product(
                out,
                stride,
                view(weights, fan_out, fan_in + 1, fan_out),
                view(&before[layer], fan_in + 1, n_samples, fan_in + 1),
            );
            if layer + 1 < shape.n_layers() {
                rectify(out);
            }
        }
        &self.blocks[shape.n_layers()][..n_samples * shape.n_outputs()]
    }
}

/// Backward pass: derivatives of the loss with respect to the values of a [`Forward`].
#[derive(Clone, Debug)]
pub(super) struct Backward<T> {
    /// Derivatives of the loss with respect to the values that enter each layer, and last to the outputs. The first list is
    /// empty, because derivatives with respect to the inputs are not needed.
    slopes: Vec<Vec<T>>,
}

impl<T: Real> Backward<T> {
    pub fn new(forward: &Forward<T>) -> Self {
        let slopes = (forward.blocks.iter().enumerate())
            .map(|(layer, block)| vec![T::from(0.0); if layer == 0 { 0 } else { block.len() }])
            .collect();
        Self { slopes }
    }

    /// Returns the derivatives of the loss with respect to the outputs. The caller writes them before [`Backward::run`].
    pub fn output_slopes(&mut self) -> &mut [T] {
        self.slopes.last_mut().expect("a network has an output layer")
    }

    /// Writes the derivatives of the loss with respect to the parameters into `gradient`. Before, `forward` must have run on
    /// the same `n_samples` samples.
    pub fn run(
        &mut self,
        forward: &Forward<T>,
        parameters: &[T],
        n_samples: usize,
        gradient: &mut [T],
    ) {
        let shape = &forward.shape;
        for layer in (0..shape.n_layers()).rev() {
            let (fan_in, fan_out) = (shape.fan_in(layer), shape.fan_out(layer));
            let (before, after) = self.slopes.split_at_mut(layer + 1);
            let stride = shape.stride(layer + 1);
            let slopes = view(&after[0], fan_out, n_samples, stride);
            let values = &forward.blocks[layer][..(fan_in + 1) * n_samples];
            let gradient = &mut gradient[shape.parameters(layer)];
            let inputs = view(values, fan_in + 1, n_samples, fan_in + 1);
            product(gradient, fan_out, slopes, inputs.transpose());
            if layer > 0 {
                let weights = &parameters[shape.parameters(layer)];
                let earlier = &mut before[layer][..values.len()];
                let weights = view(weights, fan_out, fan_in, fan_out);
                product(earlier, fan_in + 1, weights.transpose(), slopes);
                // The derivative is zero for a unit whose value the rectifier set to zero.
                vectorised(
                    #[inline(always)]
                    move || {
                        for (slope, value) in earlier.iter_mut().zip(values) {
                            *slope *= switch(*value);
                        }
                    },
                );
            }
        }
    }
}

fn rectify<T: Real>(values: &mut [T]) {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        move || {
            for value in values {
                *value *= switch(*value);
            }
        },
    );
}

/// Returns the factor by which the rectifier multiplies a value: one for a positive value, else zero. The product keeps NaN,
/// unlike `max`. Unlike a condition, it is not compiled to a masked store, which is slow.
#[inline(always)]
fn switch<T: Real>(value: T) -> T {
    T::from(if value > T::from(0.0) { 1.0 } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Returns the outputs of one sample, computed unit by unit.
    fn slow_outputs(shape: &Shape, parameters: &[f64], inputs: &[f64]) -> Vec<f64> {
        let mut values = inputs.to_vec();
        for layer in 0..shape.n_layers() {
            let weights = &parameters[shape.parameters(layer)];
            let fan_out = shape.fan_out(layer);
            values = (0..fan_out)
                .map(|unit| {
                    let bias = weights[values.len() * fan_out + unit];
                    let sum = (values.iter().enumerate())
                        .map(|(k, value)| value * weights[k * fan_out + unit])
                        .sum::<f64>()
                        + bias;
                    if layer + 1 < shape.n_layers() { sum.max(0.0) } else { sum }
                })
                .collect();
        }
        values
    }

    struct Case {
        shape: Shape,
        parameters: Vec<f64>,
        inputs: Vec<Vec<f64>>,
    }

    fn case(hidden: &[usize], n_samples: usize) -> Case {
        let shape = Shape::new(3, hidden, 2);
        let mut random = Random::new(4, &[hidden.len() as u64]);
        let mut draw = |n: usize| (0..n).map(|_| random.between(-1.0, 1.0)).collect();
        Case {
            parameters: draw(shape.n_parameters()),
            inputs: (0..n_samples).map(|_| draw(3)).collect(),
            shape,
        }
    }

    impl Case {
        fn forward(&self) -> Forward<f64> {
            let mut forward = Forward::new(&self.shape, self.inputs.len() + 2);
            for (column, inputs) in forward.inputs().zip(&self.inputs) {
                column.copy_from_slice(inputs);
            }
            forward
        }
    }

    #[test]
    fn forward_equals_the_sums_unit_by_unit() {
        for (hidden, n_samples) in [(&[][..], 4), (&[5], 1), (&[4, 7, 20], 9)] {
            let case = case(hidden, n_samples);
            let mut forward = case.forward();
            let outputs = forward.run(&case.parameters, n_samples);
            assert_eq!(outputs.len(), n_samples * 2);
            for (inputs, outputs) in case.inputs.iter().zip(outputs.chunks_exact(2)) {
                for (fast, slow) in
                    outputs.iter().zip(slow_outputs(&case.shape, &case.parameters, inputs))
                {
                    assert!((fast - slow).abs() < 1e-12);
                }
            }
        }
    }

    /// The loss is `Σ cᵢ yᵢ`, so its derivative by output i is cᵢ. Central differences err by O(h²), unless a unit switches.
    #[test]
    fn the_gradient_equals_central_differences() {
        for (hidden, n_samples) in [(&[][..], 4), (&[5], 1), (&[4, 7, 6], 9)] {
            let mut case = case(hidden, n_samples);
            let weight = |sample: usize, output: usize| 0.3 + sample as f64 - 1.7 * output as f64;
            let loss = |parameters: &[f64], case: &Case| -> f64 {
                (case.inputs.iter().enumerate())
                    .flat_map(|(k, inputs)| {
                        (slow_outputs(&case.shape, parameters, inputs).into_iter().enumerate())
                            .map(move |(output, y)| weight(k, output) * y)
                    })
                    .sum()
            };
            let mut forward = case.forward();
            forward.run(&case.parameters, n_samples);
            let mut backward = Backward::new(&forward);
            for (at, slope) in backward.output_slopes().iter_mut().enumerate() {
                *slope = weight(at / 2, at % 2);
            }
            let mut gradient = vec![f64::NAN; case.shape.n_parameters()];
            backward.run(&forward, &case.parameters, n_samples, &mut gradient);
            for (at, analytic) in gradient.into_iter().enumerate() {
                let mut shifted = |step: f64| {
                    let kept = std::mem::replace(&mut case.parameters[at], 0.0);
                    case.parameters[at] = kept + step;
                    let loss = loss(&case.parameters, &case);
                    case.parameters[at] = kept;
                    loss
                };
                let numeric = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
                assert!((analytic - numeric).abs() < 1e-6 * numeric.abs().max(1.0));
            }
        }
    }

    #[test]
    fn nan_passes_the_rectifier() {
        let mut values = [-1.0, f32::NAN, 2.0];
        rectify(&mut values);
        assert_eq!((values[0], values[2]), (0.0, 2.0));
        assert!(values[1].is_nan());
    }
}
