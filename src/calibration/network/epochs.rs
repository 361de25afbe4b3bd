//! Runs the epochs of a training. Each epoch takes the samples in a new order, in small batches with one Adam step each.
//!
//! Guarantees: cancellation takes effect within one batch. The order of the samples depends only on seed and epoch.

use std::f64::consts::PI;

use super::adam::Adam;
use super::passes::{Backward, Forward, Shape};
use super::samples::{Scale, Standardised};
use crate::{
    calibration::{
        error::CalibrationError,
        network::{samples::Samples, settings::NetworkSettings},
    },
    progress::{Cancelled, Progress},
    random::Random,
};

/// Number of held-out samples that are predicted together.
const HELD_OUT_BATCH: usize = 256;

/// Numbers of the independent random sequences (for initial weights and order of samples) that follow from one seed.
const WEIGHTS: u64 = 1;
const ORDER: u64 = 2;

/// Mean loss per sample over the training samples and over the held-out samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Losses {
    pub train: f64,
    pub held_out: Option<f64>,
}

struct Standard<'a> {
    inputs: Standardised<'a>,
    targets: Standardised<'a>,
}

impl<'a> Standard<'a> {
    fn new(samples: &'a Samples, inputs: &Scale, targets: &Scale) -> Self {
        Self {
            inputs: samples.inputs.standardised(inputs),
            targets: samples.targets.standardised(targets),
        }
    }

    fn n_samples(&self) -> usize {
        self.inputs.n_rows()
    }
}

/// Batch of samples, with the values of all network layers for these samples.
struct Batch {
    forward: Forward<f32>,
    /// Standardised targets, `capacity × n_targets` row-major.
    targets: Vec<f32>,
    /// Weight of each target in the loss: one, or zero for a constant target, which needs no training.
    weights: Vec<f32>,
}

impl Batch {
    fn new(shape: &Shape, capacity: usize, targets: &Scale) -> Self {
        let weight = |&spread: &f64| if spread > 0.0 { 1.0 } else { 0.0 };
        Self {
            forward: Forward::new(shape, capacity),
            targets: vec![0.0; capacity * shape.n_outputs()],
            weights: targets.spread.iter().map(weight).collect(),
        }
    }

    /// Writes inputs and targets of these samples into the batch. Samples beyond the capacity are left out.
    fn fill(&mut self, from: &Standard, samples: impl Iterator<Item = usize> + Clone) {
        from.inputs.prefetch(samples.clone());
        from.targets.prefetch(samples.clone());
        let targets = self.targets.chunks_exact_mut(self.weights.len());
        for ((inputs, targets), k) in self.forward.inputs().zip(targets).zip(samples) {
            from.inputs.write_row(k, inputs);
            from.targets.write_row(k, targets);
        }
    }

    /// Returns the loss, summed over the first `n_samples` samples. `error` is called with the index and the weighted error
    /// of every output.
    fn loss(
        &mut self,
        parameters: &[f32],
        n_samples: usize,
        mut error: impl FnMut(usize, f32),
    ) -> f64 {
        let width = self.weights.len();
        let outputs = self.forward.run(parameters, n_samples).chunks_exact(width);
        let mut losses = vec![0.0; width];
        for (row, (outputs, targets)) in outputs.zip(self.targets.chunks_exact(width)).enumerate() {
            for at in 0..width {
                let difference = (outputs[at] - targets[at]) * self.weights[at];
                losses[at] += f64::from(difference) * f64::from(difference);
                error(row * width + at, difference);
            }
        }
        losses.iter().sum()
    }
}

pub(super) struct Training<'a> {
    settings: &'a NetworkSettings,
    progress: &'a Progress,
    pub shape: Shape,
    train: Standard<'a>,
    held_out: Option<(Standard<'a>, Batch)>,
    pub parameters: Vec<f32>,
    gradient: Vec<f32>,
    adam: Adam,
    batch: Batch,
    backward: Backward<f32>,
    /// Indices of all training samples, in the order in which the present epoch takes them.
    order: Vec<usize>,
}

impl<'a> Training<'a> {
    pub fn new(
        train: &'a Samples,
        held_out: Option<&'a Samples>,
        inputs: &Scale,
        targets: &Scale,
        settings: &'a NetworkSettings,
        progress: &'a Progress,
    ) -> Self {
        let shape = Shape::new(train.n_inputs(), &settings.hidden, train.n_targets());
        let n = train.n_samples();
        let batch = Batch::new(&shape, settings.batch.min(n), targets);
        let batches = n.div_ceil(settings.batch) as u64;
        progress.add_total(batches.saturating_mul(settings.epochs as u64));
        Self {
            settings,
            progress,
            train: Standard::new(train, inputs, targets),
            held_out: held_out.map(|samples| {
                let capacity = HELD_OUT_BATCH.min(samples.n_samples());
                (Standard::new(samples, inputs, targets), Batch::new(&shape, capacity, targets))
            }),
            parameters: first_parameters(&shape, settings.seed),
            gradient: vec![0.0; shape.n_parameters()],
            adam: Adam::new(shape.n_parameters()),
            backward: Backward::new(&batch.forward),
            batch,
            order: (0..n).collect(),
            shape,
        }
    }

    /// Runs one epoch; `epoch` counts from zero.
    pub fn epoch(&mut self, epoch: usize) -> Result<Losses, Cancelled> {
        self.progress.check()?;
        Random::new(self.settings.seed, &[ORDER, epoch as u64]).shuffle(&mut self.order);
        let n = self.order.len();
        let capacity = self.batch.forward.capacity();
        let n_batches = n.div_ceil(capacity);
        let mut loss = 0.0;
        for (at, start) in (0..n).step_by(capacity).enumerate() {
            self.progress.check()?;
            let done = epoch as f64 + at as f64 / n_batches as f64;
            let fraction = done / self.settings.epochs as f64;
            let share =
                if self.settings.constant_rate { 1.0 } else { 0.5 * (1.0 + (PI * fraction).cos()) };
            let rate = self.settings.learning_rate * share;
            loss += self.step(start, (start + capacity).min(n), rate);
            self.progress.advance(1);
        }
        Ok(Losses { train: loss / n as f64, held_out: self.held_out_loss()? })
    }

    /// Changes the parameters by one Adam step with the samples `order[start..end]`. Returns their summed loss before the
    /// step.
    fn step(&mut self, start: usize, end: usize, rate: f64) -> f64 {
        let samples = &self.order[start..end];
        let m = samples.len();
        self.batch.fill(&self.train, samples.iter().copied());
        let slopes = self.backward.output_slopes();
        let factor = 2.0 / m as f32;
        let loss = self.batch.loss(&self.parameters, m, |at, difference| {
            slopes[at] = factor * difference;
        });
        self.backward.run(&self.batch.forward, &self.parameters, m, &mut self.gradient);
        self.adam.step(&mut self.parameters, &self.gradient, rate);
        loss
    }

    fn held_out_loss(&mut self) -> Result<Option<f64>, Cancelled> {
        let Some((samples, batch)) = &mut self.held_out else {
            return Ok(None);
        };
        let n = samples.n_samples();
        let capacity = batch.forward.capacity();
        let mut loss = 0.0;
        for start in (0..n).step_by(capacity) {
            self.progress.check()?;
            let rows = start..(start + capacity).min(n);
            batch.fill(samples, rows.clone());
            loss += batch.loss(&self.parameters, rows.len(), |_, _| {});
        }
        Ok(Some(loss / n as f64))
    }

    /// Checks that losses and parameters are finite; `epoch` counts from one.
    pub fn check(&self, losses: Losses, epoch: usize) -> Result<(), CalibrationError> {
        // The parameters are checked too, because the last step can make them infinite after the loss was computed.
        let sound = losses.train.is_finite() && self.parameters.iter().all(|p| p.is_finite());
        let which = match losses.held_out {
            _ if !sound => "training",
            Some(held_out) if !held_out.is_finite() => "held-out",
            _ => return Ok(()),
        };
        Err(CalibrationError::Diverged { which, epoch, learning_rate: self.settings.learning_rate })
    }
}

/// Returns initial parameters: uniformly distributed weights with the variance 2 / fan-in (He et al. 2015, equation 10), zero
/// biases.
fn first_parameters(shape: &Shape, seed: u64) -> Vec<f32> {
    let mut parameters = vec![0.0; shape.n_parameters()];
    for layer in 0..shape.n_layers() {
        let mut random = Random::new(seed, &[WEIGHTS, layer as u64]);
        let fan_in = shape.fan_in(layer);
        let bound = (6.0 / fan_in as f64).sqrt();
        let n_weights = fan_in * shape.fan_out(layer);
        for weight in &mut parameters[shape.parameters(layer)][..n_weights] {
            *weight = random.between(-bound, bound) as f32;
        }
    }
    parameters
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns four samples `x, x²`, enough for one step.
    fn parabola() -> (Samples, Scale, Scale) {
        let mut samples = Samples::new(1, 1);
        samples.push_rows(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 4.0, 9.0]).unwrap();
        let progress = Progress::default();
        let inputs = samples.inputs.measure(&progress).unwrap();
        let targets = samples.targets.measure(&progress).unwrap();
        (samples, inputs, targets)
    }

    /// Overflowing weights or outputs must reach the loss of the same epoch.
    #[test]
    fn a_diverging_training_is_an_error() {
        let (samples, inputs, targets) = parabola();
        let (settings, progress) = (NetworkSettings::default(), Progress::default());
        for spoil in [|p: &mut f32| *p = f32::INFINITY, |p: &mut f32| *p *= 1e30] {
            let mut training =
                Training::new(&samples, None, &inputs, &targets, &settings, &progress);
            training.parameters.iter_mut().take(100).for_each(spoil);
            let losses = training.epoch(0).unwrap();
            let error = training.check(losses, 1).unwrap_err();
            assert!(matches!(
                error,
                CalibrationError::Diverged { which: "training", epoch: 1, .. }
            ));
        }
    }

    /// A uniform distribution in ±b has the variance b² / 3 = 2 / fan-in. Tolerance: five standard errors of 10,000 draws.
    #[test]
    fn first_weights_have_the_variance_of_he_and_biases_are_zero() {
        let shape = Shape::new(100, &[100], 1);
        let parameters = first_parameters(&shape, 3);
        let layer = &parameters[shape.parameters(0)];
        let (weights, biases) = layer.split_at(100 * 100);
        let variance = weights.iter().map(|w| f64::from(w * w)).sum::<f64>() / 1e4;
        assert!((variance / 0.02 - 1.0).abs() < 0.05, "{variance}");
        assert_eq!(biases, [0.0; 100]);
    }

    /// Returns the change of the weights in the first of a hundred epochs, and in the last, run directly after it.
    fn moved(constant_rate: bool) -> (f32, f32) {
        let (samples, inputs, targets) = parabola();
        let settings = NetworkSettings {
            hidden: vec![4],
            epochs: 100,
            constant_rate,
            ..NetworkSettings::default()
        };
        let progress = Progress::default();
        let mut training = Training::new(&samples, None, &inputs, &targets, &settings, &progress);
        let mut moved = |epoch| {
            let before = training.parameters.clone();
            training.epoch(epoch).unwrap();
            (before.iter().zip(&training.parameters))
                .map(|(before, after)| (after - before).abs())
                .fold(0.0, f32::max)
        };
        (moved(0), moved(99))
    }

    #[test]
    fn a_constant_rate_moves_the_weights_in_the_last_epoch_as_in_the_first() {
        let (first, last) = moved(true);
        assert!(last > 0.3 * first, "{first} {last}");
    }

    /// With a rate that falls along half a cosine, the changes decrease.
    #[test]
    fn the_last_epoch_hardly_moves_the_weights() {
        let (first, last) = moved(false);
        // Adam's first step equals the learning rate for every weight with a nonzero gradient.
        assert!((first / 0.003 - 1.0).abs() < 1e-3 && last < 1e-3 * first, "{first} {last}");
    }
}
