//! Trains a network and reports the progress.
//!
//! Guarantees: with early stopping, the result is the network of the best completed epoch, otherwise that of the last
//! completed epoch. This also holds after cancellation. A loss that is not finite ends the training with an error.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::epochs::Training;
use crate::{
    calibration::{
        error::CalibrationError,
        network::{fitted::Network, samples::Samples, settings::NetworkSettings},
    },
    progress::{Cancelled, Progress},
};

/// Report after one epoch of a training. Losses are squared errors of the standardised targets, summed over the axes and
/// averaged over the samples. A network that always predicts the mean has the number of axes as its loss.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpochReport {
    /// Number of completed epochs.
    pub epoch: usize,
    pub epochs: usize,
    /// Loss over the training samples. The error of each sample is computed just before the optimiser step that uses the
    /// sample.
    pub train_loss: f64,
    /// Loss over the held-out samples after the epoch; `None` if no samples are held out.
    pub held_out_loss: Option<f64>,
    /// Number of the epoch with the best network so far, counted from one.
    pub best_epoch: usize,
    pub elapsed: Duration,
}

impl EpochReport {
    /// Returns the estimated remaining time of the training.
    pub fn time_left(&self) -> Duration {
        let left = self.epochs.saturating_sub(self.epoch) as f64;
        self.elapsed.mul_f64(left / self.epoch.max(1) as f64)
    }
}

impl Network {
    /// Trains a network on one thread (section 4.2.1 of the paper of Koike et al., 2019).
    ///
    /// The initial weights are those of He et al. (2015). Hidden units are rectified, outputs are linear, and the loss is the
    /// squared error of the standardised targets. The learning rate of Adam (Kingma and Ba 2015) falls along half a cosine
    /// (Loshchilov and Hutter 2017, without restarts), or is constant. `progress` counts the batches that are done.
    ///
    /// The best epoch has the lowest held-out loss, or the lowest training loss if no samples are held out.
    ///
    /// # Errors
    /// [`CalibrationError::Features`], [`CalibrationError::NoColumns`], [`CalibrationError::NoSamples`] and
    /// [`CalibrationError::HeldOutColumns`] before the training, [`CalibrationError::Diverged`] if a loss is not finite,
    /// [`CalibrationError::Cancelled`] in the first epoch.
    pub fn train(
        train: &Samples,
        held_out: Option<&Samples>,
        settings: &NetworkSettings,
        progress: &Progress,
        on_epoch: &mut dyn FnMut(EpochReport),
    ) -> Result<Self, CalibrationError> {
        let start = Instant::now();
        settings.validate()?;
        check_samples(train, held_out)?;
        let inputs = train.inputs.measure(progress)?;
        let targets = train.targets.measure(progress)?;
        let mut training = Training::new(train, held_out, &inputs, &targets, settings, progress);
        let mut best: Option<Best> = None;
        for epoch in 1..=settings.epochs {
            let Ok(losses) = training.epoch(epoch - 1) else {
                break;
            };
            training.check(losses, epoch)?;
            let loss = losses.held_out.unwrap_or(losses.train);
            let is_better = |best: &Best| !settings.early_stopping || loss < best.loss;
            if best.as_ref().is_none_or(is_better) {
                best = Some(Best { epoch, loss, parameters: training.parameters.clone() });
            }
            on_epoch(EpochReport {
                epoch,
                epochs: settings.epochs,
                train_loss: losses.train,
                held_out_loss: losses.held_out,
                best_epoch: best.as_ref().map_or(0, |best| best.epoch),
                elapsed: start.elapsed(),
            });
        }
        let parameters = best.ok_or(Cancelled)?.parameters;
        Ok(Self::from_parameters(&training.shape, &parameters, &inputs, &targets))
    }
}

fn check_samples(train: &Samples, held_out: Option<&Samples>) -> Result<(), CalibrationError> {
    if train.n_inputs() == 0 || train.n_targets() == 0 {
        return Err(CalibrationError::NoColumns);
    }
    let which = [("training", Some(train)), ("held-out", held_out)];
    for (which, samples) in which {
        if samples.is_some_and(|samples| samples.n_samples() == 0) {
            return Err(CalibrationError::NoSamples { which });
        }
    }
    let Some(held_out) = held_out else {
        return Ok(());
    };
    for (what, expected, actual) in [
        ("input", train.n_inputs(), held_out.n_inputs()),
        ("target", train.n_targets(), held_out.n_targets()),
    ] {
        if expected != actual {
            return Err(CalibrationError::HeldOutColumns { what, expected, actual });
        }
    }
    Ok(())
}

struct Best {
    epoch: usize,
    loss: f64,
    parameters: Vec<f32>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Returns `n` samples of two inputs in −1..1 and the targets of `target`.
    fn samples<const T: usize>(
        n: usize,
        seed: u64,
        target: impl Fn(f64, f64) -> [f64; T],
    ) -> Samples {
        let mut random = Random::new(seed, &[]);
        let mut samples = Samples::new(2, T);
        for _ in 0..n {
            let (a, b) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            samples.push_rows(&[a, b], &target(a, b)).unwrap();
        }
        samples
    }

    fn curved(a: f64, b: f64) -> [f64; 1] {
        [(2.0 * a).sin() + a * b]
    }

    fn settings(epochs: usize) -> NetworkSettings {
        NetworkSettings { hidden: vec![64, 64], batch: 20, epochs, ..NetworkSettings::default() }
    }

    #[derive(Debug, PartialEq)]
    struct Trained {
        network: Network,
        losses: Vec<(f64, Option<f64>)>,
        best_epoch: usize,
    }

    impl Trained {
        fn held_out_loss(&self) -> Option<f64> {
            self.losses[self.best_epoch - 1].1
        }
    }

    fn train(train: &Samples, held_out: Option<&Samples>, settings: &NetworkSettings) -> Trained {
        trained(train, held_out, settings, &Progress::default(), usize::MAX).unwrap()
    }

    /// Trains, and cancels after epoch `last`.
    fn trained(
        train: &Samples,
        held_out: Option<&Samples>,
        settings: &NetworkSettings,
        progress: &Progress,
        last: usize,
    ) -> Result<Trained, CalibrationError> {
        let (mut losses, mut best_epoch) = (Vec::new(), 0);
        let network = Network::train(train, held_out, settings, progress, &mut |report| {
            losses.push((report.train_loss, report.held_out_loss));
            best_epoch = report.best_epoch;
            assert_eq!((losses.len(), settings.epochs), (report.epoch, report.epochs));
            if report.epoch == last {
                progress.cancel();
            }
        })?;
        Ok(Trained { network, losses, best_epoch })
    }

    /// Returns the root mean squared error of each target over a grid.
    fn grid_rmse<const T: usize>(
        network: &Network,
        target: impl Fn(f64, f64) -> [f64; T],
    ) -> [f64; T] {
        let mut squares = [0.0; T];
        for at in 0..100 {
            let (a, b) = (f64::from(at % 10) / 5.0 - 0.9, f64::from(at / 10) / 5.0 - 0.9);
            let mut out = [0.0; T];
            network.predict_rows(&[a, b], &mut out);
            for ((square, out), target) in squares.iter_mut().zip(out).zip(target(a, b)) {
                *square += (out - target).powi(2) / 100.0;
            }
        }
        squares.map(f64::sqrt)
    }

    /// The targets have a standard deviation of about 0.8; the error between the training samples must be below 1.5 % of it.
    #[test]
    fn a_smooth_function_is_learned() {
        let trained = train(&samples(2000, 1, curved), None, &settings(60));
        let [rmse] = grid_rmse(&trained.network, curved);
        assert!(rmse < 0.012, "{rmse}");
        assert_eq!(trained.losses.len(), 60);
        assert_eq!(trained.network.validate(2, 1), Ok(()));
    }

    #[test]
    fn targets_of_any_size_are_learned_equally_well() {
        let target = |a: f64, b: f64| [1e-6 * curved(a, b)[0], 1e6 * (curved(b, a)[0] + 40.0)];
        let trained = train(&samples(2000, 1, target), None, &settings(60));
        let [small, large] = grid_rmse(&trained.network, target);
        assert!(small < 0.02e-6 && large < 0.02e6, "{small} {large}");
    }

    #[test]
    fn the_result_depends_only_on_the_seed() {
        let samples = samples(230, 1, curved);
        let with_seed = |seed| {
            let settings = NetworkSettings { seed, ..settings(3) };
            train(&samples, None, &settings)
        };
        let elsewhere = std::thread::scope(|scope| scope.spawn(|| with_seed(5)).join().unwrap());
        assert_eq!(with_seed(5), elsewhere);
        assert_ne!(with_seed(5).network, with_seed(6).network);
    }

    /// The held-out samples follow another function, so their loss soon rises.
    #[test]
    fn the_result_is_the_network_with_the_best_held_out_loss() {
        let learned = samples(300, 1, curved);
        let held_out = samples(50, 2, |a, b| [1.5 * curved(a, b)[0] + 0.4 * (9.0 * a).sin()]);
        let trained = train(&learned, Some(&held_out), &settings(40));
        let losses = trained.losses.iter();
        let losses: Vec<f64> = losses.map(|(_, held_out)| held_out.unwrap()).collect();
        let lowest = losses.iter().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(trained.held_out_loss(), Some(lowest));
        assert_eq!(losses[trained.best_epoch - 1], lowest);
        assert!(trained.best_epoch < 40, "the test must be able to fail");
        let again = train(&learned, Some(&held_out), &settings(40));
        assert_eq!(again, trained);
        let to_the_end = NetworkSettings { early_stopping: false, ..settings(40) };
        let last = train(&learned, Some(&held_out), &to_the_end);
        assert_eq!((last.best_epoch, last.held_out_loss()), (40, losses.last().copied()));
    }

    /// Computes the reported loss from predictions: mean of (error / standard deviation)².
    #[test]
    fn the_held_out_loss_is_that_of_the_predictions() {
        let held_out = samples(333, 2, curved);
        let trained = train(&samples(300, 1, curved), Some(&held_out), &settings(5));
        let mut random = Random::new(2, &[]);
        let mut loss = 0.0;
        for _ in 0..333 {
            let (a, b) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            let mut out = [0.0];
            trained.network.predict_rows(&[a, b], &mut out);
            loss += ((out[0] - curved(a, b)[0]) / trained.network.target_scale[0]).powi(2) / 333.0;
        }
        let reported = trained.held_out_loss().unwrap();
        assert!((loss - reported).abs() < 1e-4 * loss, "{loss} {reported}");
    }

    #[test]
    fn constant_columns_are_ignored_or_predicted_exactly() {
        let mut samples = Samples::new(2, 2);
        for k in 0..100 {
            let x = f64::from(k % 17);
            samples.push_rows(&[0.3, x], &[0.1, x * x]).unwrap();
        }
        let network = train(&samples, None, &settings(20)).network;
        assert_eq!(network.input_inverse_scale[0], 0.0);
        let mut out = [0.0; 4];
        network.predict_rows(&[0.3, 4.0, 77.0, 4.0], &mut out);
        assert_eq!([out[0], out[2]], [0.1, 0.1]);
        assert_eq!(out[1], out[3]);
    }

    #[test]
    fn a_cancelled_training_returns_the_best_so_far() {
        let samples = samples(300, 1, curved);
        let progress = Progress::default();
        let trained = trained(&samples, None, &settings(50), &progress, 4).unwrap();
        assert_eq!(trained.losses.len(), 4);
        assert!(trained.best_epoch >= 1 && trained.best_epoch <= 4);
        assert_eq!(trained.network.validate(2, 1), Ok(()));
        let again = Network::train(&samples, None, &settings(50), &progress, &mut |_| {});
        assert_eq!(again, Err(CalibrationError::Cancelled(Cancelled)));
    }

    #[test]
    fn progress_counts_every_batch() {
        let progress = Progress::default();
        let mut fractions = Vec::new();
        let samples = samples(101, 1, curved);
        Network::train(&samples, None, &settings(2), &progress, &mut |_| {
            fractions.push(progress.fraction().unwrap());
        })
        .unwrap();
        assert_eq!(fractions, [0.5, 1.0]); // the last of six batches has one sample
    }

    fn diverged(
        train: &Samples,
        held_out: Option<&Samples>,
        settings: &NetworkSettings,
    ) -> &'static str {
        let progress = Progress::default();
        match Network::train(train, held_out, settings, &progress, &mut |_| {}) {
            Err(CalibrationError::Diverged { which, .. }) => which,
            other => panic!("{:?}", other.map(|network| network.n_parameters())),
        }
    }

    /// 1e30 divided by a standard deviation near 1e-10 is beyond single precision.
    #[test]
    fn held_out_samples_out_of_reach_are_an_error() {
        let (mut learned, mut held_out) = (Samples::new(1, 1), Samples::new(1, 1));
        learned.push_rows(&[0.0, 1e-10], &[0.0, 1.0]).unwrap();
        held_out.push_rows(&[0.0, 1e30], &[0.0, 1.0]).unwrap();
        assert_eq!(diverged(&learned, Some(&held_out), &settings(2)), "held-out");
    }

    #[test]
    fn samples_with_different_columns_are_refused() {
        let refused = |train: &Samples, held_out: Option<&Samples>| {
            let progress = Progress::default();
            Network::train(train, held_out, &settings(1), &progress, &mut |_| {}).unwrap_err()
        };
        let some = samples(3, 1, curved);
        let empty = Samples::new(2, 1);
        assert_eq!(refused(&Samples::new(0, 1), None), CalibrationError::NoColumns);
        assert!(matches!(refused(&empty, None), CalibrationError::NoSamples { which: "training" }));
        assert!(matches!(
            refused(&some, Some(&empty)),
            CalibrationError::NoSamples { which: "held-out" }
        ));
        let mut narrow = Samples::new(1, 1);
        narrow.push_rows(&[1.0], &[1.0]).unwrap();
        assert!(matches!(
            refused(&some, Some(&narrow)),
            CalibrationError::HeldOutColumns { what: "input", expected: 2, actual: 1 }
        ));
    }

    #[test]
    fn one_sample_is_enough_and_is_predicted_exactly() {
        let mut samples = Samples::new(2, 1);
        samples.push_rows(&[1.0, 2.0], &[0.7]).unwrap();
        let network = train(&samples, None, &settings(2)).network;
        let mut out = [0.0];
        network.predict_rows(&[5.0, 6.0], &mut out);
        assert_eq!(out, [0.7]);
    }
}
