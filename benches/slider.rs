//! Time of one slider step on the built-in sensor: search, sums, solution, all errors, and the traces on screen.
//!
//! Also the time of the look-back search alone, at 20 Hz and at 1 kHz, for thresholds from the fastest to the slowest.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use loopscope::calibration::{FitSettings, RidgeChoice};
use loopscope::features::{Blocks, LoadPath, Polynomial, Thresholds};
use loopscope::progress::Progress;
use loopscope::questions::{Analyst, Request, View};
use loopscope::recording::simulated;

fn slider_step(c: &mut Criterion) {
    let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
    let mut group = c.benchmark_group("slider step, 243,000 samples");
    for (name, view) in [("one recording on screen", View::One(80)), ("all on screen", View::All)] {
        for f_th in [0.0, 3.0, 20.0] {
            let mut analyst = Analyst::default();
            let mut request =
                Request { view, ..Request::fit(Arc::clone(&recordings), FitSettings::default()) };
            let mut nudge = 0.0;
            group.bench_function(format!("{name}, F_th {f_th} N"), |b| {
                b.iter(|| {
                    nudge += 1e-6;
                    request.settings.features.look_backs[0].f_th =
                        f_th + nudge * f64::from(u8::from(f_th > 0.0));
                    analyst
                        .analyse(&request, &Progress::default())
                        .expect("the built-in sensor can be fitted")
                });
            });
        }
    }
    group.finish();
}

/// Measures a step with every feature block: 106 columns for six gauges.
fn every_block(c: &mut Criterion) {
    let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
    let mut settings = FitSettings::default();
    let features = &mut settings.features;
    features.look_backs.push(Thresholds { f_th: 8.0, t_th_secs: 15.0 });
    features.blocks = Blocks::every().with(&Polynomial, &[3.0]);
    let mut group = c.benchmark_group("every block, 243,000 samples");
    for (name, ridge) in
        [("no ridge", RidgeChoice::Strength(0.0)), ("ridge auto", RidgeChoice::Auto)]
    {
        settings.ridge = ridge;
        let request = Request::fit(Arc::clone(&recordings), settings.clone());
        let mut analyst = Analyst::default();
        group.bench_function(name, |b| {
            b.iter(|| {
                analyst
                    .analyse(&request, &Progress::default())
                    .expect("the built-in sensor can be fitted")
            });
        });
    }
    group.finish();
}

/// Returns times, and a force vector that turns slowly, as `n × 3` row-major numbers at `rate_hz`.
fn turning_load(n: usize, rate_hz: f64) -> (Vec<f64>, Vec<f64>) {
    let times: Vec<f64> = (0..n).map(|k| k as f64 / rate_hz).collect();
    let loads = times
        .iter()
        .flat_map(|t| {
            let (a, b) = (0.31 * t, 0.23 * t);
            [11.0 * a.sin() * b.cos(), 11.0 * b.sin(), 11.0 * a.cos() * b.cos()]
        })
        .collect();
    (times, loads)
}

fn search(c: &mut Criterion) {
    for (n, rate_hz) in [(243_000, 20.0), (95_000, 1000.0)] {
        let (times, loads) = turning_load(n, rate_hz);
        let path = LoadPath::new(&loads, &[1.0; 3]);
        let mut group = c.benchmark_group(format!("search, {n} samples at {rate_hz} Hz, 15 s"));
        for f_th in [0.0, 1.0, 3.0, 8.0, 15.0, 20.0, 21.0, 30.0] {
            let thresholds = Thresholds { f_th, t_th_secs: 15.0 };
            group.bench_function(format!("F_th {f_th} N"), |b| {
                b.iter(|| black_box(path.past_samples(&times, thresholds)));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, slider_step, every_block, search);
criterion_main!(benches);
