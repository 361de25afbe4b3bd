//! The built-in sensor: `fit` without files, and `demo`, which writes the built-in recordings.

use std::fs;
use std::path::Path;

use crate::program::{fit, numbers, succeed};
use crate::workshop::Workshop;

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn without_files_the_built_in_sensor_is_fitted() {
    let report = fit(here(), &[]);
    assert_eq!(report["simulated"], true);
    assert_eq!((&report["n_train"], &report["n_test"]), (&202_500.into(), &40_500.into()));
    let axes = serde_json::json!(["Fx", "Fy", "Fz", "Mx", "My", "Mz"]);
    assert_eq!(report["axes"], axes);
    let units = serde_json::json!(["N", "N", "N", "N·m", "N·m", "N·m"]);
    assert_eq!(report["units"], units);
    assert_eq!(report["rank"], 13);
    assert_eq!(report["features"].as_array().unwrap().len(), 13);
    assert!(report["condition"].as_f64().unwrap() > 1.0);
    for score in ["train_rmse", "test_rmse", "cv_rmse"] {
        let conventional = numbers(&report["conventional"][score]);
        let compensated = numbers(&report["compensated"][score]);
        assert_eq!((conventional.len(), compensated.len()), (6, 6));
        let forces = conventional.iter().zip(&compensated).take(3);
        forces.for_each(|(conventional, compensated)| assert!(compensated < conventional));
    }
}

#[test]
fn thresholds_that_find_no_past_give_the_conventional_answer_exactly() {
    for thresholds in [["--f-th", "0"], ["--t-th", "0"], ["--f-th", "1e9"]] {
        let report = fit(here(), &thresholds);
        assert_eq!(report["compensated"], report["conventional"], "{thresholds:?}");
        assert_eq!(report["rank"], 7, "{thresholds:?}");
    }
}

#[test]
fn decimation_by_ten_leaves_a_tenth() {
    let report = fit(here(), &["--decimate", "10"]);
    assert_eq!((&report["n_train"], &report["n_test"]), (&20_250.into(), &4_050.into()));
}

#[test]
fn without_offset_no_feature_is_constant() {
    let report = fit(here(), &["--decimate", "10", "--no-offset"]);
    assert_eq!((&report["offset"], &report["rank"]), (&false.into(), &12.into()));
    let features = report["features"].as_array().unwrap();
    assert_eq!(features.len(), 12);
    assert!(!features.contains(&"offset".into()));
}

/// Returns the sorted names of the recordings that `demo` wrote.
fn recordings(directory: &Path) -> Vec<String> {
    let names = fs::read_dir(directory)
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| name.ends_with(".csv")).collect();
    names.sort_unstable();
    names
}

/// Returns the numbers of training and test samples in a folder that `demo` wrote.
fn samples(directory: &Path) -> [usize; 2] {
    ["train_", "test_"].map(|role| {
        let names = recordings(directory);
        let own = names.iter().filter(|name| name.starts_with(role));
        own.map(|name| {
            let text = fs::read_to_string(directory.join(name)).unwrap();
            text.lines().count() - 1
        })
        .sum()
    })
}

#[test]
fn demo_writes_all_samples_or_every_tenth_marked_as_simulated() {
    let workshop = Workshop::new();
    for (pattern, expected) in [("a", [202_500, 40_500]), ("b", [20_250, 4_050])] {
        succeed(workshop.path(), &["demo", pattern, "--pattern", pattern]);
        let directory = workshop.file(pattern);
        assert_eq!(recordings(&directory).len(), 90);
        assert_eq!(samples(&directory), expected);
        let about = workshop.read(&format!("{pattern}/README.txt"));
        assert!(about.contains("simulated"), "{about}");
    }
}

#[test]
fn a_seed_determines_the_demo() {
    let workshop = Workshop::new();
    let written = |directory: &str, seed: &str| {
        let arguments = ["demo", directory, "--pattern", "b", "--seed", seed];
        succeed(workshop.path(), &arguments);
        workshop.read(&format!("{directory}/train_path1_mount1_fast.csv"))
    };
    let first = written("first", "7");
    assert_eq!(written("again", "7"), first);
    assert_ne!(written("other", "8"), first);
}

#[test]
fn demo_files_fit_like_the_built_in_recordings() {
    let workshop = Workshop::new();
    succeed(workshop.path(), &["demo", ".", "--pattern", "b"]);
    let names = recordings(workshop.path());
    let named = |role: &'static str| {
        let own = names.iter().filter(move |name| name.starts_with(role));
        own.map(String::as_str)
    };
    let mut arguments = vec!["--train"];
    arguments.extend(named("train_"));
    arguments.push("--test");
    arguments.extend(named("test_"));
    let mut from_files = fit(workshop.path(), &arguments);
    let mut built_in = fit(here(), &["--decimate", "10"]);
    for report in [&mut from_files, &mut built_in] {
        let report = report.as_object_mut().unwrap();
        report.remove("simulated");
        report.remove("decimation");
    }
    assert_eq!(from_files, built_in);
}
