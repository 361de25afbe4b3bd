//! `fit` on recordings in files.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::program::{fit, numbers, run, stderr, succeed};
use crate::workshop::{ALL_FILES, HEADER, Workshop, recording, rows};

#[test]
fn a_split_trains_on_the_first_part_and_tests_on_the_rest() {
    let workshop = Workshop::new();
    workshop.write("run.csv", recording(0.0, 111));
    let report = fit(workshop.path(), &["--train", "run.csv", "--split", "0.6"]);
    assert_eq!((&report["n_train"], &report["n_test"]), (&66.into(), &45.into()));
    assert!(report["compensated"]["test_rmse"].is_array());
}

#[test]
fn files_called_test_in_a_folder_are_not_used_for_training() {
    let workshop = Workshop::with_recordings();
    workshop.write("README.txt", "not a recording");
    let samples = |arguments: &[&str]| {
        let report = fit(workshop.path(), arguments);
        (report["n_train"].clone(), report["n_test"].clone())
    };
    assert_eq!(fit(workshop.path(), &["--train", "."]), fit(workshop.path(), &ALL_FILES));
    let one_tested = ["--train", ".", "--test", "./test.csv"];
    assert_eq!(samples(&one_tested), (450.into(), 150.into()));
    workshop.write("Test 2.csv", recording(4.0, 60));
    assert_eq!(samples(&["--train", "."]), (450.into(), 210.into()));
    assert_eq!(samples(&one_tested), (450.into(), 150.into()));
    assert_eq!(samples(&["--train", ".", "--split", "0.5"]), (330.into(), 330.into()));
    let message = stderr(&run(workshop.path(), &["fit", "--train", "."]));
    assert!(message.contains("Test 2.csv, test.csv"), "{message}");
    // `check` and `metrology` find the test recordings of a folder by the same rule. `inspect` reads all files.
    let json = |arguments: &[&str]| -> Value {
        serde_json::from_slice(&run(workshop.path(), arguments).stdout).unwrap()
    };
    let bare = ["a.csv", "b.csv", "c.csv"];
    let checked = |files: &[&str]| json(&[&["check", "--json"], files].concat());
    assert_eq!(checked(&["."])["leverage"], checked(&bare)["leverage"]);
    assert_eq!(json(&["metrology", "--json", "."])["n_samples"], 210);
    assert_eq!(json(&["inspect", "--json", "."]).as_array().unwrap().len(), 5);
}

/// Some shells do not expand patterns such as `*.csv`, so the program must.
#[test]
fn patterns_are_expanded() {
    let workshop = Workshop::with_recordings();
    let files = ["--train", "?.csv", "--test", "test*.csv"];
    assert_eq!(fit(workshop.path(), &files), fit(workshop.path(), &ALL_FILES));
    let none = run(workshop.path(), &["fit", "--train", "d*.csv"]);
    assert!(stderr(&none).contains("d*.csv: no file matches this name"));
}

#[test]
fn a_folder_of_test_recordings_alone_is_not_used_for_training() {
    let workshop = Workshop::new();
    std::fs::create_dir(workshop.file("in")).unwrap();
    workshop.write("in/test_1.csv", recording(0.0, 100));
    for job in ["fit --train", "check", "metrology"] {
        let arguments: Vec<&str> = job.split(' ').chain(["in"]).collect();
        let output = run(workshop.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{job}");
        assert!(stderr(&output).contains("begin with test"), "{job}");
    }
}

#[test]
fn a_pause_in_a_file_restarts_the_history() {
    let workshop = Workshop::new();
    let [first, second] = [rows(1.0, 120, 0.0), rows(2.0, 120, 500.0)];
    workshop.write("first.csv", format!("{HEADER}{first}"));
    workshop.write("second.csv", format!("{HEADER}{second}"));
    workshop.write("paused.csv", format!("{HEADER}{first}{second}"));
    let thresholds = ["--f-th", "2", "--t-th", "1e6"];
    let of = |files: &[&str]| fit(workshop.path(), &[&["--train"], files, &thresholds].concat());
    // All results are those of two files, except that the pieces of one run count as one recording.
    let all_but_counts = |files: &[&str]| {
        let mut report = of(files);
        for key in ["findings", "no_expected_error"] {
            report.as_object_mut().unwrap().remove(key).unwrap();
        }
        report
    };
    assert_eq!(all_but_counts(&["paused.csv"]), all_but_counts(&["first.csv", "second.csv"]));
    // Without the pause, the second half continues the history of the first half. Only the past samples differ.
    let joined = format!("{HEADER}{first}{}", rows(2.0, 120, 12.0));
    workshop.write("joined.csv", joined);
    let rmse = |file, calibration: &str| numbers(&of(&[file])[calibration]["train_rmse"])[0];
    let change = |calibration| rmse("joined.csv", calibration) / rmse("paused.csv", calibration);
    assert!((change("conventional") - 1.0).abs() < 1e-12);
    assert!((change("compensated") - 1.0).abs() > 1e-6);
}

#[test]
fn both_exports_contain_the_matrices_of_the_fit() {
    let workshop = Workshop::with_recordings();
    let exports = ["--export", "c.json", "--export", "m.csv"];
    let report = fit(workshop.path(), &[&ALL_FILES[..], &exports].concat());
    let calibration: Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
    for score in ["conventional", "compensated"] {
        assert_eq!(calibration["quality"][score], report[score]);
    }
    assert_eq!(calibration["compensated"]["features"], report["features"]);
    let mut csv =
        csv::ReaderBuilder::new().comment(Some(b'#')).from_path(workshop.file("m.csv")).unwrap();
    let rows: Vec<BTreeMap<String, String>> = csv.deserialize().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert_eq!((&*row["axis"], &*row["unit"]), ("Fz", "N"));
        let map = &calibration[&row["calibration"]];
        let features = map["features"].as_array().unwrap();
        for (feature, expected) in features.iter().zip(numbers(&map["matrix"][0])) {
            let written: f64 = row[feature.as_str().unwrap()].parse().unwrap();
            assert_eq!(written, expected);
        }
    }
}

#[test]
fn an_entered_full_scale_is_used() {
    let workshop = Workshop::with_recordings();
    let over_full_scale = |full_scale: &str, f_th: &str| {
        let changed = ["--distance", "full-scale", "--full-scale", full_scale];
        let files = &ALL_FILES[..6];
        fit(workshop.path(), &[files, &changed, &["--f-th", f_th]].concat())
    };
    let report = over_full_scale("20", "0.1");
    assert_eq!(numbers(&report["full_scale"]), [20.0]);
    assert_eq!(report["compensated"], over_full_scale("10", "0.2")["compensated"]);
    assert_ne!(report["compensated"], over_full_scale("10", "0.1")["compensated"]);
}

#[test]
fn the_table_shows_the_figures_of_the_json() {
    let workshop = Workshop::with_recordings();
    let arguments = [&["fit"], &ALL_FILES[..]].concat();
    let table = String::from_utf8(succeed(workshop.path(), &arguments).stdout).unwrap();
    let report = fit(workshop.path(), &ALL_FILES);
    for calibration in ["conventional", "compensated"] {
        for score in ["train_rmse", "test_rmse", "cv_rmse"] {
            let figure = format!("{:.6}", numbers(&report[calibration][score])[0]);
            assert!(table.contains(&figure), "{calibration} {score} {figure}: {table}");
        }
    }
}

#[test]
fn faults_of_single_rows_are_reported_by_line_and_do_not_stop_the_fit() {
    let workshop = Workshop::new();
    let odd = "15.0,oops,1,1\n15.1,1,2\n15.2,nan,1,1\n";
    let text = [&recording(0.0, 150), odd, &rows(1.0, 150, 900.0)].concat();
    workshop.write("odd.csv", text);
    let output = succeed(workshop.path(), &["fit", "--train", "odd.csv", "--json"]);
    let message = stderr(&output);
    let places: Vec<&str> = message.lines().map(|line| &line[..38]).collect();
    // Line 1 is the header, lines 2 to 151 are the first run.
    assert_eq!(
        places,
        [152, 153, 154, 155].map(|line| format!("loopscope: warning: odd.csv, line {line}:"))
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["n_train"], 300);
    assert_eq!(report["recordings"], 2);
}

/// The factory calibration is the conventional calibration of the same fit, so its errors equal the conventional errors.
#[test]
fn the_factory_calibration_is_scored_beside_the_fit() {
    let workshop = Workshop::with_recordings();
    let report = fit(workshop.path(), &[&ALL_FILES[..], &["--export", "c.json"]].concat());
    let own = numbers(&report["conventional"]["test_rmse"])[0];
    let beside = fit(workshop.path(), &[&ALL_FILES[..], &["--factory", "c.json"]].concat());
    assert!((numbers(&beside["factory"]["test_rmse"])[0] - own).abs() < 1e-9 * own);
    let output =
        succeed(workshop.path(), &[&["fit"], &ALL_FILES[..], &["--factory", "c.json"]].concat());
    assert!(
        String::from_utf8(output.stdout).unwrap().contains("calibration that the sensor came with")
    );
    workshop.write("s.cal", "<FTSensor/>");
    let output =
        run(workshop.path(), &[&["fit"], &ALL_FILES[..], &["--factory", "s.cal"]].concat());
    assert!(stderr(&output).contains("s.cal"), "{}", stderr(&output));
}

/// Groups come from names, a pattern, or the column map. The output names this source.
#[test]
fn recordings_of_a_group_are_held_out_together() {
    let workshop = Workshop::new();
    let names = ["path1_a.csv", "path1_b.csv", "path2_a.csv", "path2_b.csv", "path3_a.csv"];
    for (seed, name) in names.iter().enumerate() {
        workshop.write(name, recording(seed as f64, 150));
    }
    let files = [&["--train"], &names[..]].concat();
    let by = |more: &[&str]| {
        let report = fit(workshop.path(), &[&files, more].concat());
        let how = &report["cross_validation"];
        let parts = how["parts"].as_u64().unwrap();
        let cv = numbers(&report["compensated"]["cv_rmse"])[0];
        (how["by"].as_str().unwrap().to_owned(), parts, cv)
    };
    let found = by(&[]);
    assert_eq!((&*found.0, found.1), ("path", 3));
    let set = by(&["--group", "{path}"]);
    assert_eq!((&*set.0, set.1, set.2), ("group", 3, found.2));
    let own = by(&["--group", "{recording}"]);
    assert_eq!((&*own.0, own.1), ("recording", 5));
    assert_ne!(own.2, found.2);
    let map = succeed(workshop.path(), &["inspect", "path1_a.csv", "--write-map", "map.json"]);
    assert!(map.status.success());
    let map = workshop.read("map.json");
    let end = map.trim_end().strip_suffix('}').unwrap().trim_end();
    workshop.write("map.json", format!("{end},\n  \"group\": \"{{file}}\"\n}}\n"));
    assert_eq!(by(&["--columns", "map.json"]), own);
    let text = succeed(workshop.path(), &[&["fit"], &files[..]].concat());
    let text = String::from_utf8(text.stdout).unwrap();
    let how = "RMSE, cross-validation by path: leave-one-path-out, 3 groups";
    assert!(text.contains(how), "{text}");
    for (pattern, word) in [("{path", "{mount}"), ("{mount}", "path1_a")] {
        let refused = run(workshop.path(), &[&["fit"], &files[..], &["--group", pattern]].concat());
        assert_eq!(refused.status.code(), Some(2));
        assert!(stderr(&refused).contains(word), "{}", stderr(&refused));
    }
}
