//! Compares the program with `golden/generate.py` and `golden/blocks.py`, an independent implementation in NumPy.

#[path = "support/program.rs"]
mod program;
#[path = "support/table.rs"]
mod table;

use std::path::PathBuf;

use program::{fit, numbers, succeed};
use serde_json::Value;
use table::Table;

/// Maximum relative difference from the NumPy figures. The largest observed difference is 8e-10.
const TOLERANCE: f64 = 1e-8;

fn golden() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "golden"].iter().collect()
}

/// Returns the expected results of one kind (`fits` or `applied`) for one sensor.
fn cases(kind: &str, sensor: &str) -> Vec<Value> {
    let text = std::fs::read_to_string(golden().join("expected.json")).unwrap();
    let mut all: Value = serde_json::from_str(&text).unwrap();
    let Value::Array(mut cases) = all[kind].take() else { panic!("no list of {kind}") };
    cases.retain(|case| case["sensor"] == sensor);
    assert!(!cases.is_empty(), "no {kind} of {sensor}");
    cases
}

fn words(value: &Value) -> Vec<&str> {
    let words = value.as_array().unwrap().iter();
    words.map(|word| word.as_str().unwrap()).collect()
}

/// Checks that each number differs from the expected number by at most the tolerance times its scale.
#[track_caller]
fn assert_near(actual: &[f64], expected: &[f64], scale: impl Fn(usize) -> f64, what: &str) {
    assert_eq!(actual.len(), expected.len(), "{what}");
    for (at, (actual, expected)) in actual.iter().zip(expected).enumerate() {
        let off = (actual - expected).abs() / scale(at);
        assert!(off <= TOLERANCE, "{what} {at}: {actual} is not {expected}, off by {off:e}");
    }
}

fn assert_fits_agree(sensor: &str) {
    for case in cases("fits", sensor) {
        let (arguments, expected) = (words(&case["arguments"]), &case["expected"]);
        let actual = fit(&golden(), &arguments);
        for exact in ["n_train", "n_test", "axes", "rank"] {
            assert_eq!(actual[exact], expected[exact], "{exact} of {arguments:?}");
        }
        let near = |actual: &Value, expected: &Value, what: &str| {
            let expected = numbers(expected);
            let what = format!("{what} of {arguments:?}");
            assert_near(&numbers(actual), &expected, |at| expected[at].abs(), &what);
        };
        near(&actual["full_scale"], &expected["full_scale"], "full scale");
        for calibration in ["conventional", "compensated"] {
            for (name, rmse) in expected[calibration].as_object().unwrap() {
                let what = format!("{calibration} {name}");
                near(&actual[calibration][name], rmse, &what);
            }
            let has_test = expected[calibration].get("test_rmse").is_some();
            assert_eq!(!actual[calibration]["test_rmse"].is_null(), has_test);
        }
        let condition = |report: &Value| Value::Array(vec![report["condition"].clone()]);
        near(&condition(&actual), &condition(expected), "condition");
    }
}

/// Applies the calibration file that the fit wrote. Each load may differ by the tolerance times full scale.
fn assert_applied_loads_agree(sensor: &str) {
    for case in cases("applied", sensor) {
        let directory = tempfile::tempdir().unwrap();
        let calibration = directory.path().join("calibration.json");
        let calibration = calibration.to_str().unwrap();
        let arguments = [&words(&case["fit"])[..], &["--export", calibration]].concat();
        let report = fit(&golden(), &arguments);
        let full_scale = numbers(&report["full_scale"]);
        let file = case["file"].as_str().unwrap();
        let out = directory.path().to_str().unwrap();
        succeed(&golden(), &["apply", calibration, file, "--out", out]);
        let name = file.replace(".csv", "_loads.csv");
        let loads = Table::read(&directory.path().join(name));
        for row in case["rows"].as_array().unwrap() {
            let sample = row["sample"].as_u64().unwrap() as usize;
            for (kind, calibration) in
                [("uncompensated", "conventional"), ("compensated", "compensated")]
            {
                let actual: Vec<f64> = words(&report["axes"])
                    .iter()
                    .map(|axis| loads.column(&format!("{axis} {kind}"))[sample])
                    .collect();
                let what = format!("{calibration} load of sample {sample}");
                let expected = numbers(&row[calibration]);
                assert_near(&actual, &expected, |at| full_scale[at], &what);
            }
        }
    }
}

#[test]
fn fits_of_eight_gauges_and_six_axes_agree() {
    assert_fits_agree("eight_gauges");
}

#[test]
fn fits_of_one_split_recording_with_one_axis_agree() {
    assert_fits_agree("two_gauges");
}

#[test]
fn fits_of_samples_exactly_as_old_as_allowed_agree() {
    assert_fits_agree("even_clock");
}

#[test]
fn fits_of_a_moment_alone_agree() {
    assert_fits_agree("moment_only");
}

#[test]
fn applied_forces_and_moments_agree() {
    assert_applied_loads_agree("eight_gauges");
}

#[test]
fn applied_moments_alone_agree() {
    assert_applied_loads_agree("moment_only");
}

#[test]
fn fits_with_every_block_and_a_ridge_agree() {
    let text = std::fs::read_to_string(golden().join("blocks_expected.json")).unwrap();
    let all: Value = serde_json::from_str(&text).unwrap();
    let fits = all["fits"].as_array().unwrap();
    assert_eq!(fits.len(), 9);
    for case in fits {
        let arguments = words(&case["arguments"]);
        let actual = fit(&golden(), &arguments);
        for set in ["train_rmse", "cv_rmse", "test_rmse"] {
            let expected = numbers(&case["expected"]["compensated"][set]);
            let found = numbers(&actual["compensated"][set]);
            let what = format!("{set} of {arguments:?}");
            assert_near(&found, &expected, |at| expected[at].abs(), &what);
        }
    }
}
