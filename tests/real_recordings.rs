//! Recordings of real sensors, where they are at hand (they are no part of this project), read as they are by column
//! maps: the figures must be those that NumPy gives on the same files by the rules of `golden/generate.py`.

#[path = "support/program.rs"]
mod program;

use std::path::{Path, PathBuf};

use program::{fit, numbers};
use serde_json::Value;

/// The folder with a sensor's recordings, if it is there.
fn recordings_of(sensor: &str) -> Option<PathBuf> {
    let folders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/real");
    let folder = folders.join(sensor);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: there is no {}", folder.display());
    None
}

/// What fitting the files of a folder by one of the maps beside this test gives.
fn fit_by(map: &str, folder: &Path, arguments: &[&str]) -> Value {
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/column_maps");
    let map = maps.join(map);
    let columns = ["--columns", map.to_str().unwrap()];
    fit(folder, &[arguments, &columns].concat())
}

#[track_caller]
fn assert_test_rmse(report: &Value, calibration: &str, expected: &[f64]) {
    let actual = numbers(&report[calibration]["test_rmse"]);
    assert_eq!(actual.len(), expected.len());
    for (actual, expected) in actual.iter().zip(expected) {
        let off = (actual / expected - 1.0).abs();
        assert!(off < 1e-4, "{calibration}: {actual} is not {expected}");
    }
}

/// The error on the last 40 % of a stretch recording: resistances and force on two clocks in one file.
fn stretch_report(name: &str, thresholds: &[&str]) -> Option<Value> {
    let folder = recordings_of("stretch")?;
    let split = ["--train", name, "--split", "0.6"];
    let arguments = [&split, thresholds].concat();
    Some(fit_by("two_clocks_in_one_file.json", &folder, &arguments))
}

#[test]
fn look_back_mends_a_fifth_of_the_error_of_a_stretch_sensor() {
    let thresholds = ["--f-th", "0.15", "--t-th", "3"];
    if let Some(report) = stretch_report("multisine_600s_1.csv", &thresholds) {
        assert_test_rmse(&report, "conventional", &[0.355129]);
        assert_test_rmse(&report, "compensated", &[0.279889]);
    }
}

#[test]
fn look_back_mends_a_third_of_the_error_of_a_stretch_sensor_in_sawtooth() {
    let thresholds = ["--f-th", "0.22", "--t-th", "7"];
    if let Some(report) = stretch_report("rand_sawtooth.csv", &thresholds) {
        assert_test_rmse(&report, "conventional", &[0.483748]);
        assert_test_rmse(&report, "compensated", &[0.327000]);
    }
}

/// Fifteen channels in one file, the load in another; a load of -1 is a dropout.
#[test]
fn look_back_mends_a_fifth_of_the_error_of_a_magnetic_skin() {
    let Some(folder) = recordings_of("eflesh") else {
        return;
    };
    let [first, second, third] =
        ["014340", "015037", "015717"].map(|run| format!("20250401_{run}/sensor.csv"));
    let roles = ["--train", &first, &second, "--test", &third];
    let thresholds = ["--f-th", "1000", "--t-th", "30"];
    let arguments = [&roles[..], &thresholds].concat();
    let report = fit_by("reference_in_its_own_file.json", &folder, &arguments);
    assert_test_rmse(&report, "conventional", &[90.343772]);
    assert_test_rmse(&report, "compensated", &[73.239233]);
}

/// Rows come in bursts of fifteen; a metal sensor has hardly any hysteresis to mend.
#[test]
fn look_back_does_little_for_a_metal_sensor() {
    let Some(folder) = recordings_of("ft6") else {
        return;
    };
    let [first, second, third, fourth] = [1, 2, 3, 4].map(|run| format!("directional_{run}.txt"));
    let roles = ["--train", &first, &second, &fourth, "--test", &third];
    let thresholds = ["--f-th", "10", "--t-th", "15"];
    let report = fit_by(
        "headerless.json",
        &folder,
        &[&roles[..], &thresholds].concat(),
    );
    assert_eq!(report["recordings"], 4);
    let conventional = [6.882583, 6.285746, 1.655491, 1.072821, 1.255908, 0.1283777];
    let compensated = [7.186475, 6.187605, 1.655938, 1.041042, 1.310694, 0.1153050];
    assert_test_rmse(&report, "conventional", &conventional);
    assert_test_rmse(&report, "compensated", &compensated);
}
