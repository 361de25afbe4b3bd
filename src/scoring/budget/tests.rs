//! Compares the error budget with `tests/golden/budget.py`, a plain implementation in NumPy.

use std::path::PathBuf;

use serde_json::Value;

use super::*;

/// Maximum difference from the NumPy figures, as a share of the total mean square.
const TOLERANCE: f64 = 1e-6;

fn golden() -> PathBuf {
    match std::env::var("BUDGET_GOLDEN") {
        Ok(path) => PathBuf::from(path),
        Err(_) => [env!("CARGO_MANIFEST_DIR"), "tests", "golden", "budget"].iter().collect(),
    }
}

/// Samples of one file: gauges, loads and auxiliary channels.
type Samples = (Vec<f64>, Vec<f64>, Vec<f64>);

fn read(sensor: &str) -> Vec<Samples> {
    let path = |number: usize| golden().join(format!("{sensor}_{number}.csv"));
    let files = (1..).map_while(|number| std::fs::read_to_string(path(number)).ok());
    let samples = files.map(|text| {
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let mut samples = Samples::default();
        for line in lines {
            for (name, value) in names.iter().zip(line.split(',')) {
                let values = match name.chars().next() {
                    Some('t') => continue,
                    Some('S') => &mut samples.0,
                    Some('F') => &mut samples.1,
                    _ => &mut samples.2,
                };
                values.push(value.parse::<f64>().unwrap());
            }
        }
        samples
    });
    samples.collect()
}

fn numbers(of: &Value) -> Vec<f64> {
    of.as_array().unwrap().iter().map(|own| own.as_f64().unwrap()).collect()
}

fn assert_shares(actual: &Shares, expected: &Value, what: &str) {
    let total = expected["total"].as_f64().unwrap();
    let near = |actual: f64, expected: f64, of: &str| {
        let off = (actual - expected).abs() / total;
        println!("{what} {of}: {actual:e} {expected:e} off {off:e}");
        assert!(off <= TOLERANCE, "{of} of {what}: {actual} is not {expected}, off by {off:e}");
    };
    near(actual.total, total, "total");
    let shares = expected["shares"].as_object().unwrap();
    for share in &actual.shares {
        let cause = serde_json::to_value(share.cause).unwrap();
        let cause = cause.as_str().unwrap();
        let wanted = shares.get(cause).unwrap_or_else(|| panic!("{cause} invented in {what}"));
        near(share.square, wanted.as_f64().unwrap(), cause);
        let or = serde_json::to_value(&share.or).unwrap();
        assert_eq!(or, expected["alternatives"][cause], "alternatives of {cause} in {what}");
        near(share.standard_error / 1.5, expected["se"][cause].as_f64().unwrap(), "standard error");
    }
    assert_eq!(actual.shares.len(), shares.len(), "{what}: {:?}", actual.shares);
    near(actual.noise, expected["noise"].as_f64().unwrap(), "noise");
    near(actual.unexplained, expected["unexplained"].as_f64().unwrap(), "unexplained");
}

fn runs_of(samples: &[Samples], n_axes: usize, has_times: bool) -> Vec<Run<'_>> {
    let parts = samples.iter().enumerate();
    parts
        .map(|(part, (gauges, loads, auxiliary))| Run {
            n_samples: loads.len() / n_axes,
            gauges,
            loads,
            auxiliary,
            part,
            has_times,
        })
        .collect()
}

/// The order of rows tells rising from falling loads, but says nothing about speeds.
#[test]
fn rows_without_times_have_no_lag_creep_or_drift() {
    let wave = |at: usize| 50.0 * (1.0 - (at as f64 * 0.05).cos());
    let samples: Vec<Samples> = (0..4_u32)
        .map(|run| {
            let loads: Vec<f64> = (0..600).map(|at| wave(at + run as usize)).collect();
            let slope = |at: usize| wave(at + 1) - wave(at);
            let gauges = (0..600).map(|at| loads[at] + 0.4 * slope(at + run as usize));
            (gauges.collect(), loads, Vec::new())
        })
        .collect();
    let tested = |has_times: bool| {
        let (runs, progress) = (runs_of(&samples, 1, has_times), Progress::default());
        let measured = Measured::of(&runs, &[50.0], None, &progress).unwrap().unwrap();
        let found = measured.budget(&[vec![0]], false, &progress).unwrap();
        let of_time = [Cause::Creep, Cause::Lag, Cause::Drift];
        (
            of_time.map(|cause| found.tested.contains(&cause)),
            found.tested.contains(&Cause::Hysteresis),
        )
    };
    assert_eq!(tested(true), ([true; 3], true));
    assert_eq!(tested(false), ([false; 3], true));
}

#[test]
fn shares_equal_those_of_numpy() {
    let text = std::fs::read_to_string(golden().join("golden.json")).unwrap();
    let all: Value = serde_json::from_str(&text).unwrap();
    for (sensor, expected) in all.as_object().unwrap() {
        let samples = read(sensor);
        let full_scale = numbers(&expected["full_scale"]);
        let runs = runs_of(&samples, full_scale.len(), true);
        let pools = vec![(0..full_scale.len()).collect::<Vec<usize>>()];
        let progress = Progress::default();
        let measured = Measured::of(&runs, &full_scale, None, &progress).unwrap().unwrap();
        let found = measured.budget(&pools, false, &progress).unwrap();
        let change = expected["h10"].as_f64().unwrap();
        assert!((found.change_samples - change).abs() < 1e-9 * change, "{}", found.change_samples);
        for (axis, expected) in expected["axes"].as_array().unwrap().iter().enumerate() {
            assert_shares(
                found.axes[axis].as_ref().unwrap(),
                expected,
                &format!("{sensor} {axis}"),
            );
        }
        assert_shares(found.pools[0].as_ref().unwrap(), &expected["all"], sensor);
    }
}
