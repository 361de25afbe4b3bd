//! Time from the recordings to the chosen thresholds, on the built-in sensor (202,500 training and 40,500 test samples).

use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use loopscope::calibration::{FitSettings, RidgeChoice};
use loopscope::features::{Creep, FeatureSettings, Play, Thresholds};
use loopscope::progress::Progress;
use loopscope::questions::thresholds::{Measure, ThresholdGrid};
use loopscope::questions::{HistoryBlock, Request, Study};
use loopscope::recording::simulated;

fn thresholds(c: &mut Criterion) {
    let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
    let progress = Progress::default();
    let lay = |settings: &FitSettings| {
        let request = Request::fit(Arc::clone(&recordings), settings.clone());
        Study::prepare(&request, &progress).expect("the built-in sensor can be fitted")
    };
    let plain = FitSettings::default();
    let auto = FitSettings { ridge: RidgeChoice::Auto, ..plain.clone() };
    let grid = ThresholdGrid::new(
        (0..40).map(|at| 0.35 * f64::from(at)).collect(),
        (1..=40).map(f64::from).collect(),
    )
    .expect("values rise");
    let mut group = c.benchmark_group("thresholds");
    group.sample_size(10);
    for (name, settings) in [("", &plain), (", automatic ridge", &auto)] {
        group.bench_function(format!("map of 40 x 40 with cross-validation{name}"), |b| {
            b.iter(|| lay(settings).threshold_map(None, &grid, &progress, &|_| {}));
        });
    }
    let map = lay(&plain).threshold_map(None, &grid, &progress, &|_| {}).expect("long enough");
    group.bench_function("suggestion from the map", |b| {
        b.iter(|| map.suggestion(Measure::FullScale));
    });
    group.bench_function("ages of the past samples, and the mean hysteresis", |b| {
        b.iter(|| {
            let study = lay(&plain);
            (study.past_ages(Thresholds::default()), study.mean_hysteresis())
        });
    });
    let present = FitSettings { features: FeatureSettings::present(), ..plain };
    for block in [&Play as HistoryBlock, &Creep] {
        group.bench_function(format!("list for {block:?}"), |b| {
            b.iter(|| lay(&present).suggest_block(block, Measure::FullScale, &progress));
        });
    }
    group.finish();
}

criterion_group!(benches, thresholds);
criterion_main!(benches);
