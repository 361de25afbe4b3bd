//! Times to compute the metrology table, and the data of the loop pane for one axis. The samples are the 243,000 of the built-in
//! sensor.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use loopscope::calibration::{AppliedLoads, FitSettings};
use loopscope::progress::Progress;
use loopscope::questions::metrology::{MetrologySettings, Rules, Run, lags_of, table_by};
use loopscope::questions::{Request, analyse};
use loopscope::recording::{RecordingSet, simulated};
use loopscope::scoring::lag::{LagRun, lags};
use loopscope::scoring::loops::extents_of_set;
use loopscope::scoring::loops::{Frame, Loop, Loops, default_reversal_threshold, outline};

/// Width and height of a plot in pixels.
const PIXELS: [f64; 2] = [1000.0, 700.0];
const POINTS: usize = 20_000;

fn metrology(c: &mut Criterion) {
    let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
    let request = Request::fit(Arc::clone(&recordings), FitSettings::default());
    let calibration = analyse(&request, &Progress::default())
        .expect("the built-in sensor can be fitted")
        .calibration;
    let applied: Vec<AppliedLoads> = (recordings.entries().iter())
        .map(|entry| calibration.apply(&entry.recording).expect("same gauges"))
        .collect();
    let runs: Vec<Run<'_>> = (recordings.entries().iter().zip(&applied))
        .map(|(entry, applied)| Run::new(&entry.recording, applied))
        .collect();
    let rules = Rules {
        axes: &calibration.axes,
        full_scale: &calibration.full_scale,
        settings: &MetrologySettings::default(),
        extents: &extents_of_set(&recordings, &calibration.axes),
    };
    c.bench_function("table, six axes, 243,000 samples", |b| {
        let lags = || lags_of(&runs, &calibration.axes, &Progress::default()).unwrap();
        b.iter(|| table_by(&runs, &rules, lags()));
    });
    let lag_runs = (recordings.entries().iter().zip(&applied)).map(|(entry, applied)| LagRun {
        times: entry.recording.times(),
        gauges: entry.recording.gauges(),
        loads: entry.recording.loads(),
        outputs: &applied.conventional,
    });
    let lag_runs: Vec<LagRun<'_>> = lag_runs.collect();
    c.bench_function("time lag of six axes, 243,000 samples", |b| {
        b.iter(|| lags(&lag_runs, &Progress::default()));
    });
    loop_pane(c, &recordings, &applied);
}

fn loop_pane(c: &mut Criterion, recordings: &RecordingSet, applied: &[AppliedLoads]) {
    let column = |values: &[f64]| -> Vec<f64> { values.iter().step_by(6).copied().collect() };
    let columns: Vec<[Vec<f64>; 3]> = (recordings.entries().iter().zip(applied))
        .map(|(entry, applied)| {
            let loads = entry.recording.loads();
            [loads, &applied.conventional, &applied.compensated].map(column)
        })
        .collect();
    let loads = || columns.iter().map(|column| &column[0][..]);
    c.bench_function("loops of one axis with both widths, 243,000 samples", |b| {
        b.iter(|| {
            let loops = Loops::of(loads(), default_reversal_threshold(loads()));
            let cycles = loops.full_cycles();
            [1, 2].map(|output| {
                let all = cycles.iter().map(|cycle| {
                    let column = &columns[cycle.recording];
                    Loop::of(cycle, &column[0], |k| column[output][k])
                });
                Loop::mean(&all.collect::<Vec<_>>()).map(|mean| mean.area())
            })
        });
    });
    let loops = Loops::of(loads(), default_reversal_threshold(loads()));
    let whole = Frame { loads: (-12.0, 12.0), outputs: (-14.0, 14.0) };
    c.bench_function("outline of one axis and output, 243,000 samples", |b| {
        b.iter(|| {
            let branches = (columns.iter().zip(loops.branches())).flat_map(|(column, own)| {
                own.iter().map(|branch| {
                    let samples = branch.samples.clone();
                    let points = column[0][samples.clone()].iter().zip(&column[1][samples]);
                    points.map(|(load, output)| [*load, *output])
                })
            });
            black_box(outline(branches, whole, PIXELS, POINTS))
        });
    });
}

criterion_group!(benches, metrology);
criterion_main!(benches);
