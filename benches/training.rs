//! Time of an epoch of the paper's network: 12 inputs, three layers of 100 units, 6 targets, batches of 100.
//!
//! One network trains with as many samples as the paper's patterns B and A. Then two networks train on two threads, to show the gain.

use std::thread;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use loopscope::calibration::network::{Network, NetworkSettings, Samples};
use loopscope::progress::Progress;

const N_INPUTS: usize = 12;
const N_TARGETS: usize = 6;

/// Returns samples with slowly varying inputs, and targets that are smooth functions of the inputs.
fn samples(n: usize) -> Samples {
    let mut samples = Samples::new(N_INPUTS, N_TARGETS);
    samples.reserve(n);
    for k in 0..n {
        let inputs: [f64; N_INPUTS] =
            std::array::from_fn(|i| (0.013 * (i + 1) as f64 * k as f64 + i as f64).sin());
        let targets: [f64; N_TARGETS] =
            std::array::from_fn(|i| (inputs[i] + inputs[i + 1] * inputs[i + 6]).sin());
        samples.push_rows(&inputs, &targets).expect("the values are finite");
    }
    samples
}

fn train(samples: &Samples, epochs: u64) -> Duration {
    let settings = NetworkSettings { epochs: epochs as usize, ..NetworkSettings::default() };
    let start = Instant::now();
    Network::train(samples, None, &settings, &Progress::default(), &mut |_| {})
        .expect("smooth functions can be learned");
    start.elapsed()
}

fn epochs(c: &mut Criterion) {
    let mut group = c.benchmark_group("epoch");
    group.sample_size(10);
    for n in [20_250, 202_500] {
        let samples = samples(n);
        group.bench_function(BenchmarkId::new("one network", n), |b| {
            b.iter_custom(|iterations| train(&samples, iterations));
        });
        group.bench_function(BenchmarkId::new("two at once", n), |b| {
            b.iter_custom(|iterations| {
                let start = Instant::now();
                thread::scope(|scope| {
                    for _ in 0..2 {
                        scope.spawn(|| train(&samples, iterations));
                    }
                });
                start.elapsed()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, epochs);
criterion_main!(benches);
