//! `sweep`, which computes errors for a grid of thresholds. The errors equal the errors of `fit`, and the files equal the printed output.

use serde_json::Value;

use crate::program::{fit, numbers, stderr, succeed};
use crate::workshop::{ALL_FILES, Workshop};

const RANGES: [&str; 4] = ["--f-th", "0:4:1", "--t-th", "0.5,3,10"];

#[track_caller]
fn sweep(workshop: &Workshop, arguments: &[&str]) -> Value {
    let arguments = [&["sweep", "--json"], &ALL_FILES[..], &RANGES, arguments].concat();
    let output = succeed(workshop.path(), &arguments);
    assert_eq!(stderr(&output), "", "progress is only shown in a terminal");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[track_caller]
fn assert_points_are_fits(workshop: &Workshop, blocks: &[&str]) {
    let report = sweep(workshop, blocks);
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 15);
    for point in points {
        let [f_th, t_th] = ["f_th", "t_th"].map(|name| point[name].to_string());
        let thresholds = ["--f-th", &f_th, "--t-th", &t_th];
        let fitted = fit(workshop.path(), &[&ALL_FILES[..], &thresholds, blocks].concat());
        for score in ["train_rmse", "test_rmse", "cv_rmse"] {
            let (actual, expected) = (&point[score], &fitted["compensated"][score]);
            for (actual, expected) in numbers(actual).iter().zip(numbers(expected)) {
                let error = (actual / expected - 1.0).abs();
                assert!(error < 1e-9, "{f_th} {t_th} {score}: {actual} {expected}");
            }
        }
        if f_th == "0.0" && blocks.is_empty() {
            assert_eq!(point["cv_rmse"], report["conventional"]["cv_rmse"]);
        }
    }
}

#[test]
fn every_pair_has_the_errors_of_a_fit() {
    assert_points_are_fits(&Workshop::with_recordings(), &[]);
}

#[test]
fn given_features_are_kept_while_the_thresholds_vary() {
    let blocks = ["--creep", "2", "--play", "0.3", "--ridge", "0.001", "--no-offset"];
    assert_points_are_fits(&Workshop::with_recordings(), &blocks);
}

#[test]
fn the_suggestion_has_the_lowest_cross_validation_error() {
    let workshop = Workshop::with_recordings();
    let report = sweep(&workshop, &["--measure", "fz"]);
    let left_out = |point: &Value| numbers(&point["cv_rmse"])[0];
    let points = report["points"].as_array().unwrap();
    let least = points.iter().map(left_out).fold(f64::INFINITY, f64::min);
    let suggestion = &report["suggestion"];
    assert_eq!(suggestion["left_out"].as_f64(), Some(least));
    let thresholds = &suggestion["thresholds"];
    let taken = points
        .iter()
        .find(|point| {
            point["f_th"] == thresholds["f_th"] && point["t_th"] == thresholds["t_th_secs"]
        })
        .unwrap();
    assert_eq!(left_out(taken), least);
    assert_eq!(suggestion["n_parts"], 3);
    assert!(report["mean_hysteresis"]["n_reversals"].as_u64().unwrap() > 0);
    assert_eq!(report["past_ages"]["n_samples"], 450);
}

#[test]
fn the_files_contain_the_printed_figures() {
    let workshop = Workshop::with_recordings();
    let report = sweep(&workshop, &["--csv", "map.csv", "--svg", "map.svg"]);
    let mut csv = csv::Reader::from_path(workshop.file("map.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 3 + 15 * 3);
    let points = report["points"].as_array().unwrap();
    for (rows, point) in rows[3..].chunks(3).zip(points) {
        for (row, score) in rows.iter().zip(["train_rmse", "test_rmse", "cv_rmse"]) {
            assert_eq!(row[0].parse::<f64>().ok(), point["f_th"].as_f64());
            assert_eq!(row[3].parse::<f64>().unwrap(), numbers(&point[score])[0]);
        }
    }
    let picture = workshop.read("map.svg");
    assert!(picture.starts_with("<svg ") && picture.ends_with("</svg>\n"));
    assert!(picture.contains("cross-validation"));
}

#[test]
fn the_tables_contain_the_suggestion_and_its_basis() {
    let workshop = Workshop::with_recordings();
    let picks = ["--pick", "play,creep"];
    let arguments = [&["sweep"], &ALL_FILES[..], &RANGES, &picks].concat();
    let text = String::from_utf8(succeed(workshop.path(), &arguments).stdout).unwrap();
    for printed in [
        "RMSE of forces [N] at t_th",
        "RMSE of forces [N] at F_th",
        "cross-validation minimum of forces",
        "as good within the uncertainty",
        "mean hysteresis",
        "reversals (Fz",
        "of the training samples find an earlier sample",
        "Play radii",
        "Creep time constants",
    ] {
        assert!(text.contains(printed), "no {printed:?} in {text}");
    }
    let without_test = [&["sweep"], &ALL_FILES[..4], &RANGES].concat();
    let text = String::from_utf8(succeed(workshop.path(), &without_test).stdout).unwrap();
    assert!(!text.lines().any(|line| line.ends_with("test")));
}

#[test]
fn without_ranges_the_grid_covers_the_sensor() {
    let workshop = Workshop::with_recordings();
    let arguments = [&["sweep", "--json"], &ALL_FILES[..]].concat();
    let output = succeed(workshop.path(), &arguments).stdout;
    let report: Value = serde_json::from_slice(&output).unwrap();
    let f_ths = |point: &Value| point["f_th"].as_f64().unwrap();
    let points = report["points"].as_array().unwrap();
    let largest = points.iter().map(f_ths).fold(0.0, f64::max);
    let full_scale = numbers(&report["full_scale"])[0];
    assert!(largest > full_scale && largest < 2.0 * full_scale, "{largest} {full_scale}");
}
