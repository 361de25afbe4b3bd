//! Simulated sensors with known lag and play, from a separate simulator with twenty steps per sample.

use super::*;
use crate::random::Random;

/// Form of the load of an axis over time.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Path {
    /// Eight sines of random frequencies.
    Random,
    /// Ramps of random rates between random turns.
    Ramps,
    /// Sines of three rates, one after another.
    Sines,
    /// A repeated triangle.
    OneRate,
    /// Steps between dwells.
    Steps,
    /// One cycle in five minutes.
    Slow,
}

#[derive(Clone, Copy, Debug)]
struct Sensor {
    path: Path,
    rate_hz: f64,
    kind: LagKind,
    samples: f64,
    play: f64,
    noise: f64,
    n_axes: usize,
    /// True if each axis has play, as in a structure; false if each gauge has it.
    play_of_axes: bool,
    secs: f64,
}

const SENSOR: Sensor = Sensor {
    path: Path::Random,
    rate_hz: 100.0,
    kind: LagKind::Delay,
    samples: 0.0,
    play: 0.0,
    noise: 0.001,
    n_axes: 1,
    play_of_axes: false,
    secs: 60.0,
};

const FINER: usize = 20;
const RUNS: u64 = 3;

/// Returns the load, from −1 to 1, at twenty times per sample.
fn path(path: Path, n: usize, step: f64, random: &mut Random) -> Vec<f64> {
    let time = |k: usize| k as f64 * step;
    let tau = std::f64::consts::TAU;
    match path {
        Path::Random => {
            let waves: Vec<[f64; 2]> =
                (0..8).map(|_| [random.between(0.05, 1.0), random.between(0.0, tau)]).collect();
            let wave =
                |t: f64, [rate, phase]: [f64; 2]| (tau * rate * t + phase).sin() / (1.0 + rate);
            let values: Vec<f64> = (0..n)
                .map(|k| waves.iter().map(|component| wave(time(k), *component)).sum())
                .collect();
            let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
            values.iter().map(|value| value / largest).collect()
        }
        Path::Ramps => {
            let (mut load, mut way, mut goal, mut rate) = (0.0, 1.0, 0.5, 1.0);
            let step = |_| {
                load += way * rate * step;
                if (goal - load) * way <= 0.0 {
                    way = -way;
                    goal = way * random.between(0.2, 1.0);
                    rate = random.between(-1.0, 1.0).exp2();
                }
                load
            };
            (0..n).map(step).collect()
        }
        Path::Sines => {
            let mut phase = 0.0;
            let wave = |k: usize| {
                phase += tau * step * [0.1, 0.3, 0.9][(3 * k / n).min(2)];
                f64::sin(phase)
            };
            (0..n).map(wave).collect()
        }
        Path::OneRate => {
            (0..n).map(|k| 4.0 * ((0.25 * time(k)).fract() - 0.5).abs() - 1.0).collect()
        }
        Path::Steps => {
            let levels: Vec<f64> = (0..=n).map(|_| random.between(-1.0, 1.0)).collect();
            (0..n).map(|k| levels[(time(k) / 1.5) as usize]).collect()
        }
        Path::Slow => (0..n).map(|k| (tau * time(k) / 300.0).sin()).collect(),
    }
}

fn play(load: &[f64], radius: f64) -> Vec<f64> {
    let mut state = load[0];
    let follow = |load: &f64| {
        state = state.max(load - radius).min(load + radius);
        state
    };
    load.iter().map(follow).collect()
}

/// Applies a low-pass in small steps, or shifts by whole small steps.
fn lagged(values: &[f64], kind: LagKind, fine_samples: f64) -> Vec<f64> {
    match kind {
        LagKind::Delay => {
            let shift = fine_samples.round() as usize;
            (0..values.len()).map(|k| values[k.saturating_sub(shift)]).collect()
        }
        LagKind::FirstOrder => {
            let mut state = values[0];
            let share = if fine_samples > 0.0 { 1.0 / (fine_samples + 0.5) } else { 1.0 };
            let step = |value: &f64| {
                state += share * (value - state);
                state
            };
            values.iter().map(step).collect()
        }
    }
}

fn simulated(sensor: &Sensor, seed: u64) -> [Vec<f64>; 3] {
    let n = (sensor.secs * sensor.rate_hz) as usize;
    let (step, axes) = (1.0 / (FINER as f64 * sensor.rate_hz), sensor.n_axes);
    let mut random = Random::new(seed, &[]);
    let loads: Vec<Vec<f64>> =
        (0..axes).map(|_| path(sensor.path, n * FINER, step, &mut random)).collect();
    let played: Vec<Vec<f64>> = if sensor.play_of_axes {
        loads.iter().map(|load| play(load, sensor.play)).collect()
    } else {
        loads.clone()
    };
    let of_gauge = if sensor.play_of_axes { 0.0 } else { sensor.play };
    let gauge = |gauge: usize| {
        let share = |axis: usize| {
            if axis == gauge { 1.0 } else { 0.2 * ((7 * gauge + 3 * axis) as f64).sin() }
        };
        let strain = |k: usize| (0..axes).map(|axis| share(axis) * played[axis][k]).sum();
        let strain: Vec<f64> = (0..n * FINER).map(strain).collect();
        lagged(&play(&strain, of_gauge), sensor.kind, sensor.samples * FINER as f64)
    };
    let gauges: Vec<Vec<f64>> = (0..axes).map(gauge).collect();
    let rows = |columns: &[Vec<f64>]| -> Vec<f64> {
        (0..n).flat_map(|k| columns.iter().map(move |column| column[k * FINER])).collect()
    };
    let gauges = rows(&gauges).iter().map(|value| value + sensor.noise * random.normal()).collect();
    [(0..n).map(|k| k as f64 / sensor.rate_hz).collect(), gauges, rows(&loads)]
}

/// Returns the lag of the first output. The outputs are the gauges, because any mixture of them has their lag.
fn found(sensor: &Sensor) -> Result<Lag, NoLag> {
    let runs: Vec<_> = (0..RUNS).map(|run| simulated(sensor, 100 + run)).collect();
    let runs: Vec<_> = (runs.iter())
        .map(|[times, gauges, loads]| LagRun { times, gauges, loads, outputs: gauges })
        .collect();
    lags(&runs, &Progress::default()).unwrap().swap_remove(0)
}

fn assert_found(sensor: Sensor) {
    let lag = match found(&sensor) {
        // Much play under ramps makes a short time constant uncertain.
        Err(NoLag::Uncertain { uncertainty_secs }) if sensor.play == 0.1 => {
            let most = 0.4 / sensor.rate_hz;
            assert!(sensor.path == Path::Ramps && uncertainty_secs < most, "{sensor:?}");
            return;
        }
        lag => lag.unwrap_or_else(|reason| panic!("{sensor:?}: {reason:?}")),
    };
    let error = (lag.samples - sensor.samples).abs();
    assert!(error < (0.03 * sensor.samples).max(0.1), "{sensor:?}: {lag:?}");
    if sensor.samples >= 2.0 && lag.kind_is_known {
        assert_eq!(lag.kind, sensor.kind, "{sensor:?}: {lag:?}");
    }
}

const LAGS: [(LagKind, f64); 6] = [
    (LagKind::Delay, 0.0),
    (LagKind::Delay, 0.2),
    (LagKind::Delay, 3.0),
    (LagKind::FirstOrder, 0.3),
    (LagKind::FirstOrder, 2.0),
    (LagKind::FirstOrder, 5.0),
];

#[test]
fn lags_are_found_with_and_without_play() {
    for (kind, samples) in LAGS {
        for play in [0.0, 0.01, 0.1] {
            for path in [Path::Random, Path::Ramps, Path::Sines] {
                assert_found(Sensor { path, kind, samples, play, ..SENSOR });
            }
        }
    }
}

#[test]
fn lags_are_found_in_noise_at_both_rates() {
    for (rate_hz, secs) in [(100.0, 60.0), (1000.0, 60.0)] {
        for (kind, samples) in [(LagKind::Delay, 3.0), (LagKind::FirstOrder, 5.0)] {
            let sensor = Sensor { kind, samples, play: 0.03, noise: 0.003, ..SENSOR };
            assert_found(Sensor { rate_hz, secs, ..sensor });
        }
    }
}

#[test]
fn six_axes_each_have_their_lag() {
    for (kind, samples) in [(LagKind::Delay, 0.5), (LagKind::FirstOrder, 5.0)] {
        for play_of_axes in [false, true] {
            let sensor = Sensor { kind, samples, play: 0.05, noise: 0.003, n_axes: 6, ..SENSOR };
            assert_found(Sensor { play_of_axes, ..sensor });
        }
    }
}

/// A lag that the samples do not determine is an error.
#[test]
fn one_rate_jumps_and_slow_loads_have_no_lag() {
    for play in [0.0, 0.05] {
        for path in [Path::OneRate, Path::Steps, Path::Slow] {
            let sensor = Sensor { path, kind: LagKind::FirstOrder, samples: 2.0, play, ..SENSOR };
            let reason = found(&sensor).expect_err(&format!("{sensor:?}"));
            assert_eq!(reason == NoLag::Jumps, path == Path::Steps, "{sensor:?}: {reason:?}");
        }
    }
    let still =
        LagRun { times: &[0.0, 1.0], gauges: &[0.0; 2], loads: &[0.0; 2], outputs: &[0.0; 2] };
    assert_eq!(lags(&[still], &Progress::default()).unwrap(), [Err(NoLag::TooShort)]);
}

/// The gauge creeps by a tenth of the load, about as quickly as the load moves.
#[test]
fn quick_creep_is_not_reported_as_a_lag() {
    let runs = (0..RUNS).map(|run| {
        let [times, gauges, loads] = simulated(&SENSOR, 100 + run);
        let crept = LagKind::FirstOrder.late(&times, &loads, 0.8);
        let gauges: Vec<f64> =
            gauges.iter().zip(crept).map(|(value, crept)| value + 0.1 * crept).collect();
        [times, gauges, loads]
    });
    let runs: Vec<_> = runs.collect();
    let runs: Vec<_> = (runs.iter())
        .map(|[times, gauges, loads]| LagRun { times, gauges, loads, outputs: gauges })
        .collect();
    assert_eq!(lag_of(&runs, 0), Err(NoLag::Creep));
}

/// One of three recordings is late by two samples.
#[test]
fn each_recording_has_its_own_lag() {
    let late = [0.0, 2.0, 0.0].map(|samples| Sensor { samples, ..SENSOR });
    let runs: Vec<_> = (100..).zip(&late).map(|(seed, sensor)| simulated(sensor, seed)).collect();
    let runs: Vec<_> = (runs.iter())
        .map(|[times, gauges, loads]| LagRun { times, gauges, loads, outputs: gauges })
        .collect();
    for (lag, sensor) in lag_by_run(&runs, 0).iter().zip(&late) {
        let lag = lag.as_ref().unwrap();
        assert!((lag.samples - sensor.samples).abs() < 0.1, "{lag:?}");
    }
}

/// Returns widths of the loop as shares of full scale: with the lag, after its removal, and of the same sensor without lag.
fn hysteresis(sensor: &Sensor, lag: &Lag) -> [f64; 3] {
    let widths_of = |sensor: &Sensor| {
        let runs: Vec<_> = (0..RUNS).map(|run| simulated(sensor, 100 + run)).collect();
        let runs: Vec<_> = (runs.iter())
            .map(|[times, gauges, loads]| LagRun { times, gauges, loads, outputs: gauges })
            .collect();
        widths(lag, 0, &runs, 0.1).expect("the load has cycles").largest
    };
    let [before, after] = widths_of(sensor);
    [before, after, widths_of(&Sensor { samples: 0.0, ..*sensor })[0]]
}

#[test]
fn the_width_without_the_lag_is_the_hysteresis() {
    for (kind, samples) in LAGS {
        for (play, n_axes) in [(0.0, 1), (0.01, 1), (0.1, 1), (0.05, 6)] {
            let is_quick = n_axes == 1 || samples == 5.0;
            let sensor = Sensor { kind, samples, play, n_axes, noise: 0.003, ..SENSOR };
            let Some(lag) = is_quick.then(|| found(&sensor).unwrap()) else { continue };
            let [before, after, truth] = hysteresis(&sensor, &lag);
            let allowed = (0.1 * truth).max(0.003);
            assert!(
                (after - truth).abs() < allowed,
                "{sensor:?}: {before} {after} {truth} {lag:?}"
            );
        }
    }
}

/// Prints the table of the guide: `cargo test --lib table_of_the_guide -- --ignored --nocapture`.
#[test]
#[ignore = "prints the table of the guide"]
fn table_of_the_guide() {
    println!(
        "| load | rate | true lag | play | noise | axes | found | width: with lag, removed, true |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let paths = [Path::Random, Path::Ramps, Path::Sines, Path::OneRate, Path::Steps, Path::Slow];
    let one = paths.map(|path| (path, 100.0, 1));
    for (path, rate_hz, n_axes) in
        one.into_iter().chain([(Path::Random, 1000.0, 1), (Path::Random, 100.0, 6)])
    {
        for (kind, samples) in [
            (LagKind::Delay, 0.2),
            (LagKind::Delay, 3.0),
            (LagKind::FirstOrder, 0.3),
            (LagKind::FirstOrder, 5.0),
        ] {
            for (play, noise) in [(0.0, 0.001), (0.01, 0.01), (0.1, 0.003)] {
                let sensor = Sensor { path, rate_hz, kind, samples, play, noise, n_axes, ..SENSOR };
                let lag = found(&sensor);
                let kind = match kind {
                    LagKind::Delay => "delay",
                    LagKind::FirstOrder => "low-pass",
                };
                let answer = match &lag {
                    Ok(lag) => format!(
                        "{:.2} ± {:.2}, {}",
                        lag.samples,
                        2.0 * lag.standard_error_secs * lag.samples / lag.seconds,
                        if lag.kind_is_known { lag.kind.name() } else { "either" }
                    ),
                    Err(reason) => format!(
                        "not known: {}",
                        reason.to_string().split([';', ':']).next().unwrap_or("")
                    ),
                };
                let widths = lag.map_or_else(
                    |_| "–".to_owned(),
                    |lag| {
                        let widths =
                            hysteresis(&sensor, &lag).map(|width| format!("{:.1}", 100.0 * width));
                        widths.join(", ")
                    },
                );
                println!(
                    "| {path:?} | {rate_hz} Hz | {kind} {samples} | {} % | {} % | {n_axes} | {answer} | {widths} |",
                    100.0 * play,
                    100.0 * noise
                );
            }
        }
    }
}
