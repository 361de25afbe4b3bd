//! Feature blocks, ridges and regressors on the command line, one at a time and together.

use serde_json::Value;

use crate::program::{fit, numbers, run, stderr, succeed};
use crate::table::Table;
use crate::workshop::{ALL_FILES, Workshop, recording};

fn features(report: &Value) -> Vec<&str> {
    let features = report["features"].as_array().unwrap().iter();
    features.map(|name| name.as_str().unwrap()).collect()
}

fn rmse(report: &Value, calibration: &str, set: &str) -> f64 {
    numbers(&report[calibration][set])[0]
}

fn fitted(workshop: &Workshop, choices: &[&str]) -> Value {
    fit(workshop.path(), &[&ALL_FILES[..], choices].concat())
}

#[test]
fn named_features_are_combined() {
    let workshop = Workshop::with_recordings();
    let report = fitted(
        &workshop,
        &[
            "--look-back",
            "3,8",
            "--fixed-lag",
            "0.5",
            "--creep",
            "2",
            "--play",
            "0.2,0.4",
            "--polynomial",
            "2",
        ],
    );
    assert_eq!(
        features(&report).join(" "),
        "S1 S2 S1_past S2_past S1_past2 S2_past2 S1_lag_0.5s S2_lag_0.5s S1_creep_2s S2_creep_2s S1_play_0.2 \
         S2_play_0.2 S1_play_0.4 S2_play_0.4 S1^2 S1*S2 S2^2 offset"
    );
    assert_eq!(report["blocks"]["play_radii"], serde_json::json!([0.2, 0.4]));
    assert_eq!(features(&fitted(&workshop, &["--play", "0.2"])).len(), 5);
    assert_eq!(features(&fitted(&workshop, &["--f-th", "2"])).len(), 5);
}

#[test]
fn without_history_compensated_equals_uncompensated() {
    let workshop = Workshop::with_recordings();
    let report = fitted(&workshop, &["--look-back", "none"]);
    assert_eq!(report["conventional"], report["compensated"]);
    assert!(report["f_th"].is_null());
}

#[test]
fn a_strong_ridge_leaves_the_conventional_calibration_and_auto_does_not() {
    let workshop = Workshop::with_recordings();
    let strong = fitted(&workshop, &["--play", "0.2,0.6", "--ridge", "1e12"]);
    let [conventional, shrunk] =
        ["conventional", "compensated"].map(|c| rmse(&strong, c, "test_rmse"));
    assert!((shrunk / conventional - 1.0).abs() < 1e-6);
    let auto = fitted(&workshop, &["--play", "0.2,0.6", "--ridge", "auto"]);
    assert!(rmse(&auto, "compensated", "test_rmse") < 0.7 * conventional);
    assert_eq!(numbers(&auto["ridge"]).len(), 1);
}

#[test]
fn every_regressor_is_exported_and_applied_with_the_errors_it_reported() {
    for regressor in ["linear", "network", "kernel", "hybrid-network", "hybrid-kernel"] {
        let workshop = Workshop::with_recordings();
        let choices =
            ["--regressor", regressor, "--epochs", "20", "--landmarks", "15", "--export", "c.json"];
        let report = fitted(&workshop, &choices);
        assert_eq!(report["regressor"], regressor);
        succeed(workshop.path(), &["apply", "c.json", "test.csv", "--out", "."]);
        let loads = Table::read(&workshop.file("test_loads.csv"));
        let (truth, found) = (loads.column("Fz reference"), loads.column("Fz compensated"));
        let squares: f64 = truth.iter().zip(&found).map(|(a, b)| (a - b) * (a - b)).sum();
        let actual = (squares / truth.len() as f64).sqrt();
        let reported = rmse(&report, "compensated", "test_rmse");
        assert!((actual / reported - 1.0).abs() < 1e-9, "{regressor}: {actual} {reported}");
        assert_eq!(report["compensated"]["cv_rmse"].is_null(), regressor.contains("network"));
    }
}

#[test]
fn the_same_seed_gives_the_same_network() {
    let workshop = Workshop::with_recordings();
    let error = |seed: &str| {
        let choices = ["--regressor", "network", "--epochs", "3", "--seed", seed];
        rmse(&fitted(&workshop, &choices), "compensated", "train_rmse")
    };
    assert_eq!(error("5"), error("5"));
    assert_ne!(error("5"), error("6"));
}

#[test]
fn settings_out_of_range_are_refused_with_a_correction() {
    let workshop = Workshop::with_recordings();
    for (choices, words) in [
        (&["--play", "0"][..], &["play radius is 0", "above zero"][..]),
        (&["--play", "0.1,x"], &["\"x\" is not a number"]),
        (&["--creep", "-3"], &["creep time constant is -3"]),
        (&["--fixed-lag", "NaN"], &["fixed lag is NaN"]),
        (&["--fixed-lag", "-0.03"], &["fixed lag is -0.03", "future samples"]),
        (&["--look-back", "3,-1"], &["F_th is -1"]),
        (&["--polynomial", "4"], &["polynomial is 4"]),
        (&["--ridge", "-1"], &["ridge is -1"]),
        (&["--ridge", "much"], &["auto"]),
        (&["--regressor", "kernel", "--landmarks", "1999"], &["1999 landmarks", "450", "fewer"]),
        (&["--regressor", "kernel", "--landmarks", "0"], &["number of landmarks is 0"]),
        (&["--regressor", "network", "--epochs", "0"], &["epochs"]),
        (&["--f-th", "1", "--look-back", "2"], &["cannot be used with"]),
    ] {
        let output = run(workshop.path(), &[&["fit"], &ALL_FILES[..], choices].concat());
        let message = stderr(&output);
        assert!(!output.status.success(), "{choices:?} succeeded");
        for word in words {
            assert!(message.contains(word), "{choices:?}: no {word:?} in {message}");
        }
    }
}

#[test]
fn numbers_that_cannot_be_squared_are_refused_rather_than_fitted() {
    let workshop = Workshop::with_recordings();
    workshop.write("huge.csv", "t,S1,S2,Fz\n0,1,2,3\n0.1,1e200,2,4\n0.2,2,1,5\n");
    let output = run(workshop.path(), &["fit", "--train", "huge.csv"]);
    let message = stderr(&output);
    assert!(!output.status.success());
    assert!(message.contains("sample 2 has the value 1e200"), "{message}");
}

#[test]
fn a_training_set_too_short_for_cross_validation_is_fitted_with_a_finding() {
    let workshop = Workshop::new();
    workshop.write("short.csv", recording(0.0, 1));
    let arguments = ["fit", "--train", "short.csv", "--ridge", "auto", "--json"];
    let output = succeed(workshop.path(), &arguments);
    assert!(stderr(&output).contains("too few training samples"));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["compensated"]["cv_rmse"].is_null());
}

#[test]
fn the_models_of_the_paper_are_tried_without_and_with_look_back() {
    let workshop = Workshop::with_recordings();
    let arguments = [&["best", "--paper", "--json"], &ALL_FILES[..]].concat();
    let output = succeed(workshop.path(), &arguments);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let tried = report["tried"].as_array().unwrap();
    let of = |regressor: &str| tried.iter().filter(|row| row["regressor"] == regressor).count();
    // Squares that the ridge leaves out make the same model as the gauges alone, which is then listed once.
    assert!([2, 3].contains(&of("linear")), "{}", of("linear"));
    for regressor in ["kernel", "network", "hybrid-kernel", "hybrid-network"] {
        assert_eq!(of(regressor), 2, "{regressor}");
    }
    let with_past = tried.iter().filter(|row| row["blocks"].as_str().unwrap().contains("F_th"));
    assert_eq!(with_past.count(), 5);
    assert_eq!(report["ruled_out"].as_array().unwrap().len(), 0);
}

/// Appends the keys of all JSON objects in `value` to `keys`.
fn add_keys(value: &Value, keys: &mut Vec<String>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(key, own)| {
            keys.push(key.clone());
            add_keys(own, keys);
        }),
        Value::Array(all) => all.iter().for_each(|own| add_keys(own, keys)),
        _ => {}
    }
}

#[test]
fn keys_of_printed_json_are_terms_of_the_field() {
    let workshop = Workshop::with_recordings();
    let trained = |job: &'static str| [&[job, "--json"], &ALL_FILES[..]].concat();
    let jobs = [
        trained("fit"),
        trained("check"),
        trained("sweep"),
        vec!["metrology", "--json", "a.csv"],
        vec!["inspect", "--json", "a.csv"],
    ];
    for job in jobs {
        let printed = run(workshop.path(), &job).stdout;
        let mut keys = Vec::new();
        add_keys(&serde_json::from_slice(&printed).unwrap(), &mut keys);
        let old = ["stretch", "touch", "hint", "dead_band", "caution", "heard", "squares_cubes"];
        let is_old = |key: &&String| old.iter().any(|word| key.contains(word));
        assert!(keys.len() > 5 && !keys.iter().any(|key| is_old(&key)), "{job:?}: {keys:?}");
    }
}
