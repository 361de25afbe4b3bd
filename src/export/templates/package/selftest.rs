//! Self-test of an exported calibration: computes the loads of the samples in expected.csv and compares them. The exit code
//! is 0 if all agree.
//!
//! rustc --edition 2021 -O selftest.rs && ./selftest ../expected.csv

#[allow(dead_code)]
#[path = "{{ name }}.rs"]
mod calibration;

use calibration::{AXES,{{ ' AUXILIARY,' if auxiliary }} GAUGES, Real, State};

const FULL_SCALE: [f64; AXES] = [{{ full_scale|join(', ') }}];
const ALLOWED: f64 = if size_of::<Real>() > 4 { {{ allowed_double }} } else { {{ allowed_float }} };

fn main() {
    let path = std::env::args().nth(1).unwrap_or_else(|| "../expected.csv".to_owned());
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let mut state = State::new();
    let (mut worst, mut taken, mut compared, mut bad) = (0.0, 0, 0, 0);
    for (k, line) in text.lines().enumerate().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|text| text.parse().expect("a number")).collect();
        let gauges: [Real; GAUGES] = std::array::from_fn(|gauge| numbers[1 + gauge] as Real);
{% if auxiliary %}        let auxiliary: [Real; AUXILIARY] = std::array::from_fn(|at| numbers[1 + GAUGES + at] as Real);
{% endif %}        let actual = state.update(numbers[0], &gauges{{ ', &auxiliary' if auxiliary }});
        let expected = &numbers[1 + GAUGES{{ ' + AUXILIARY' if auxiliary }}..];
        taken += 1;
        if expected[2 * AXES + 1] > 0.0 {
            continue;
        }
        compared += 1;
        let loads = actual.load.iter().chain(&actual.conventional).zip(expected).enumerate();
        let mut off = 0.0_f64;
        for (at, (actual, expected)) in loads {
            let by = (f64::from(*actual) - expected).abs() / FULL_SCALE[at % AXES];
            off = match (actual.is_nan(), expected.is_nan()) {
                (true, true) => off,
                (false, false) => off.max(by),
                _ => f64::INFINITY,
            };
        }
        worst = off.max(worst);
        let status = f64::from(actual.status.0);
        if off > ALLOWED || status != expected[2 * AXES] {
            if bad == 0 {
                println!("line {}: error {off:e} of full scale, status {status} instead of {}", k + 1, expected[2 * AXES]);
            }
            bad += 1;
        }
    }
    let verdict = if bad == 0 { "PASS" } else { "FAIL" };
    println!("{verdict}: {compared} of {taken} samples compared, {bad} differ; largest difference {worst:e} of full scale, {ALLOWED:e} allowed");
    std::process::exit(i32::from(bad > 0));
}
