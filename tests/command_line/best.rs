//! `best`, which proposes a model: its candidates, its proposal, and its independence of test recordings.

use serde_json::Value;

use crate::program::{fit, numbers, run, stderr, succeed};
use crate::workshop::{ALL_FILES, Workshop, recording};

fn best(workshop: &Workshop, arguments: &[&str]) -> Value {
    let output = succeed(workshop.path(), &[&["best", "--json"], arguments].concat());
    serde_json::from_slice(&output.stdout).unwrap()
}

fn tried(report: &Value) -> &Vec<Value> {
    report["tried"].as_array().unwrap()
}

/// Returns the report without measured times.
fn without_times(report: &Value) -> Value {
    let mut report = report.clone();
    for own in report["tried"].as_array_mut().unwrap() {
        for key in ["seconds", "test_rmse", "cost"] {
            own.as_object_mut().unwrap().remove(key);
        }
    }
    report
}

#[test]
fn the_proposal_does_not_depend_on_the_test_recordings() {
    let workshop = Workshop::with_recordings();
    let export = ["--export", "proposed.json"];
    let report = best(&workshop, &[&ALL_FILES[..], &export].concat());
    let all = tried(&report);
    assert_eq!(all[0]["name"], "Conventional");
    assert_eq!(report["n_folds"], 3);
    assert_eq!(report["n_left"], 0);
    let proposed: Vec<&Value> = all.iter().filter(|own| own["is_proposed"] == true).collect();
    let [proposed] = proposed[..] else { panic!("{all:?}") };
    // The gauges lag behind the force, so features with memory improve the fit.
    assert!(proposed["relative"].as_f64().unwrap() < 0.5, "{proposed}");
    assert!(proposed["refused"].is_null());
    let lowest = all.iter().filter(|own| own["refused"].is_null());
    let lowest = lowest.map(|own| own["relative"].as_f64().unwrap()).fold(1.0, f64::min);
    assert_eq!(proposed["relative"].as_f64().unwrap(), lowest);
    let smallest: Vec<&Value> = all.iter().filter(|own| own["is_smallest"] == true).collect();
    let [smallest] = smallest[..] else { panic!("{all:?}") };
    let bytes = |own: &Value| own["cost"]["bytes"].as_u64().unwrap();
    assert!(bytes(smallest) <= bytes(proposed));
    assert!(smallest["relative"].as_f64().unwrap() <= 1.05 * lowest);

    // Without or with other test recordings, only the test errors change.
    workshop.write("other.csv", recording(9.0, 60));
    let train = &ALL_FILES[..4];
    let without = best(&workshop, train);
    assert!(without["tried"][0]["test_rmse"].is_null());
    assert_eq!(without_times(&without), without_times(&report));
    let other = best(&workshop, &[train, &["--test", "other.csv"]].concat());
    assert_eq!(without_times(&other), without_times(&report));
    assert_ne!(other["tried"][0]["test_rmse"], report["tried"][0]["test_rmse"]);

    // `fit` with the printed arguments gives the same model.
    let arguments: Vec<&str> = report["fit"].as_str().unwrap().split(' ').collect();
    let fitted = fit(workshop.path(), &[&ALL_FILES[..], &arguments].concat());
    let calibration: Value = serde_json::from_str(&workshop.read("proposed.json")).unwrap();
    for score in ["train_rmse", "test_rmse"] {
        let [own, exported] = [&fitted["compensated"], &calibration["quality"]["compensated"]]
            .map(|scores| numbers(&scores[score])[0]);
        assert!((own / exported - 1.0).abs() < 1e-12, "{score}: {own} {exported}");
    }
}

#[test]
fn a_search_out_of_time_gives_the_models_tried_so_far() {
    let workshop = Workshop::with_recordings();
    let output = succeed(workshop.path(), &[&["best", "--minutes", "0"], &ALL_FILES[..]].concat());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("Proposed: Conventional"), "{text}");
    let exporting = ["best", "--minutes", "0", "--export", "c.json", "--json"];
    let exporting = [&exporting, &ALL_FILES[..]].concat();
    let output = run(workshop.path(), &exporting);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(!workshop.file("c.json").exists());
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["n_left"].as_u64().unwrap() > 30, "{report}");
    succeed(workshop.path(), &[&exporting[..], &["--force"]].concat());
    assert!(workshop.file("c.json").exists());
    for wrong in ["-1", "NaN", "inf"] {
        let output = run(
            workshop.path(),
            &[&["best", &format!("--minutes={wrong}")], &ALL_FILES[..]].concat(),
        );
        assert!(!output.status.success());
        assert!(stderr(&output).contains("minutes"), "{}", stderr(&output));
    }
}
