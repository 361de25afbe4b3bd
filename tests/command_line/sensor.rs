//! The sensor's identity, the expected error, limits, and folders of recordings.

use std::fs;

use crate::program::{fit, run, stderr, succeed};
use crate::workshop::{ALL_FILES, Workshop, recording};

const SENSOR: &str = "serial = 4711\nnotes = \"A & B <GmbH>\"\ndate = 2026-03-31\nmodel = \"RS\"\n\
    reference_uncertainty = \"Fz 0.02 N\"\n[rated_loads]\nFz = 10\n";

fn stdout(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn every_export_contains_the_identity_of_the_sensor() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", SENSOR);
    let exports = ["c.json", "c.h", "c.py", "c.rs", "c.yaml", "c.cal.txt"];
    let mut words = vec!["fit", "--sensor", "sensor.toml", "--look-back", "none"];
    words.extend(ALL_FILES);
    for export in &exports[..5] {
        words.extend(["--export", *export]);
    }
    succeed(workshop.path(), &words);
    for export in &exports[..5] {
        let text = workshop.read(export);
        assert!(text.contains("4711") && text.contains("2026-03-31"), "{export}");
    }
    let own = json(&workshop.read("c.json"));
    assert_eq!(own["identity"]["notes"], "A & B <GmbH>");
    assert_eq!(own["full_scale"], serde_json::json!([10.0]));
    assert_eq!(own["rated"], serde_json::json!([true]));
    // One matrix row per axis, one number for each of two gauges and the offset.
    let standard = own["quality"]["coefficients"]["standard"].as_array().unwrap();
    assert_eq!((standard.len(), standard[0].as_array().unwrap().len()), (1, 3));
}

#[test]
fn best_and_sweep_obey_the_sensor_file() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", SENSOR);
    let best = [
        "best",
        "--sensor",
        "sensor.toml",
        "--minutes",
        "0.02",
        "--force",
        "--export",
        "best.json",
    ];
    succeed(workshop.path(), &[&best[..], &ALL_FILES].concat());
    let best = json(&workshop.read("best.json"));
    assert_eq!(best["identity"]["serial"], "4711");
    assert_eq!(best["full_scale"], serde_json::json!([10.0]));
    let sweep = ["sweep", "--sensor", "sensor.toml", "--f-th", "1", "--t-th", "5", "--json"];
    let sweep = succeed(workshop.path(), &[&sweep[..], &ALL_FILES].concat());
    assert_eq!(json(&stdout(&sweep))["full_scale"], serde_json::json!([10.0]));
}

const FRAME: &str = "[frame]\nturn_degrees = [10, -20, 35]\nshift_metres = [0.02, -0.03, 0.05]\n";

/// Matrix of the frame above, from NumPy: `[[R, 0], [[p]x R, R]]` with R = Rz(35°) Ry(-20°) Rx(10°).
fn load_matrix() -> [[f64; 6]; 6] {
    let [(sx, cx), (sy, cy), (sz, cz)] = [10.0_f64, -20.0, 35.0].map(|a| a.to_radians().sin_cos());
    let turn = [
        [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
        [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
        [-sy, cy * sx, cy * cx],
    ];
    let shift = [0.02, -0.03, 0.05];
    let mut matrix = [[0.0; 6]; 6];
    for i in 0..3 {
        for j in 0..3 {
            (matrix[i][j], matrix[i + 3][j + 3]) = (turn[i][j], turn[i][j]);
            let (a, b) = ((i + 1) % 3, (i + 2) % 3);
            matrix[i + 3][j] = shift[a] * turn[b][j] - shift[b] * turn[a][j];
        }
    }
    matrix
}

/// Least squares commutes with a matrix that mixes the loads, so the matrix in a frame is the product of the frame's matrix and
/// the matrix without a frame.
#[test]
fn every_exported_matrix_is_in_the_sensor_frame() {
    let workshop = Workshop::new();
    let mut text = "t [s],S1,S2,S3,S4,S5,S6,Fx,Fy,Fz,Mx,My,Mz\n".to_owned();
    for k in 0..400 {
        let t = f64::from(k) / 20.0;
        let loads: Vec<f64> =
            (0..6).map(|axis| (t * (0.7 + 0.31 * f64::from(axis))).sin() * 5.0).collect();
        let gauges = (0..6).map(|gauge| {
            let noise = 0.01 * (13.0 * t * f64::from(gauge + 1)).cos();
            loads[gauge as usize] * 2.0 + 0.3 * loads[(gauge as usize + 1) % 6] + noise
        });
        let cells: Vec<String> =
            gauges.chain(loads.iter().copied()).map(|value| value.to_string()).collect();
        text += &format!("{t},{}\n", cells.join(","));
    }
    workshop.write("a.csv", text);
    workshop.write("sensor.toml", FRAME);
    let fitted = |sensor: &[&str], name: &str| {
        let endings = ["json", "csv", "yaml", "h", "py", "rs", "m", "cal", "inc"];
        let exports: Vec<String> = endings.map(|ending| format!("{name}.{ending}")).into();
        let mut words = vec!["fit", "--train", "a.csv", "--look-back", "none"];
        words.extend(sensor);
        exports.iter().for_each(|export| words.extend(["--export", export]));
        succeed(workshop.path(), &words);
        exports
    };
    fitted(&[], "plain");
    let exports = fitted(&["--sensor", "sensor.toml"], "framed");
    let matrix = |name: &str| -> Vec<Vec<f64>> {
        let calibration = json(&workshop.read(name));
        serde_json::from_value(calibration["conventional"]["matrix"].clone()).unwrap()
    };
    let (plain, framed) = (matrix("plain.json"), matrix("framed.json"));
    for (row, frame) in framed.iter().zip(load_matrix()) {
        for (gauge, found) in row.iter().enumerate() {
            let expected: f64 = (0..6).map(|axis| frame[axis] * plain[axis][gauge]).sum();
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
    for export in exports {
        let text = workshop.read(&export);
        assert!(
            text.contains("turn_degrees") || text.contains("turned by 10, -20, 35"),
            "{export}"
        );
        let numbers = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
        let numbers: Vec<f64> = numbers.filter_map(|word| word.parse().ok()).collect();
        for coefficient in framed.iter().flat_map(|row| &row[..6]) {
            let is_it = |number: &f64| (number - coefficient).abs() < 1e-12;
            assert!(numbers.iter().any(is_it), "{export} lacks {coefficient}");
        }
    }
}

#[test]
fn a_frame_that_mixes_an_unmeasured_axis_is_refused() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", FRAME);
    let refused = run(workshop.path(), &["fit", "--train", "a.csv", "--sensor", "sensor.toml"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("Fx was not measured") || stderr(&refused).contains("Fx"));
}

#[test]
fn a_wrong_sensor_description_is_refused_before_recordings_are_read() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", "seriel = 1\n");
    let refused = run(workshop.path(), &["fit", "--train", "a.csv", "--sensor", "sensor.toml"]);
    let message = stderr(&refused);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        message.contains("sensor.toml")
            && message.contains("seriel is not known; use one of manufacturer"),
        "{message}"
    );
    let printed = stdout(&succeed(workshop.path(), &["sensor"]));
    workshop.write("sensor.toml", &printed);
    succeed(workshop.path(), &["fit", "--train", "a.csv", "--sensor", "sensor.toml"]);
}

/// Compares the expected error of `fit --json` with the sorted errors of the applied loads on the test recording.
#[test]
fn the_expected_error_bounds_95_percent_of_the_held_out_errors() {
    let workshop = Workshop::with_recordings();
    let found = fit(
        workshop.path(),
        &[&ALL_FILES[..], &["--export", "c.json", "--traces", "t.csv"]].concat(),
    );
    let own = &found["expected_error"]["axes"][0];
    let (value, tested, left_out) =
        (&own["value"], own["test"].as_f64().unwrap(), own["cross_validation"].as_f64().unwrap());
    assert_eq!(value.as_f64(), Some(tested.max(left_out)));
    assert_eq!(
        found["expected_error"]["cross_validation"],
        serde_json::json!({"groups": 3, "samples": 450})
    );
    assert_eq!(found["expected_error"]["test"], serde_json::json!({"groups": 1, "samples": 150}));
    let text = workshop.read("t.csv");
    let mut rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let column = head.iter().position(|name| name.starts_with("Fz compensated error")).unwrap();
    let of_test = rows.filter(|row| row[0] == "test");
    let mut errors: Vec<f64> =
        of_test.map(|row| row[column].parse::<f64>().unwrap().abs()).collect();
    errors.sort_by(f64::total_cmp);
    assert_eq!(errors.len(), 150);
    assert!((errors[142] - tested).abs() < 1e-9, "{} {tested}", errors[142]);
    // The file contains the expected error, and the conditions that the expected error does not cover.
    let file = json(&workshop.read("c.json"));
    assert_eq!(file["quality"]["expected_error"], found["expected_error"]);
    let not_covered = found["expected_error"]["not_covered"].as_str().unwrap();
    assert!(
        not_covered.contains("another mounting") && not_covered.contains("another day"),
        "{not_covered}"
    );
    assert!(!not_covered.contains("one at a time"), "there is one axis: {not_covered}");
}

#[test]
fn fewer_than_three_groups_give_a_reason_instead_of_an_expected_error() {
    let workshop = Workshop::with_recordings();
    for files in [&["--train", "a.csv"][..], &["--train", "a.csv", "b.csv", "--test", "c.csv"]] {
        let found = fit(workshop.path(), files);
        assert!(found["expected_error"].is_null(), "{files:?}");
        let reason = found["no_expected_error"].as_str().unwrap();
        assert!(reason.contains("3 test recordings are enough"), "{reason}");
    }
    workshop.write("limits.toml", "expected_error = 1e6\n");
    let words = ["fit", "--train", "a.csv", "b.csv", "--limits", "limits.toml"];
    assert_eq!(
        run(workshop.path(), &words).status.code(),
        Some(3),
        "an unknown figure does not pass"
    );
}

#[test]
fn fit_and_report_check_limits_alike_and_exit_with_3() {
    let workshop = Workshop::with_recordings();
    for (limits, code) in [
        ("expected_error = 100\nrmse = 100\nloop_width = 100\n", 0),
        ("expected_error = 0.01\n", 3),
        ("rmse = { Fz = \"0.001 N\" }\n", 3),
        ("loop_width = 0.001\n", 3),
        ("rmse = { Mz = 100 }\n", 3),
    ] {
        workshop.write("limits.toml", limits);
        let words =
            |job: &'static str| [&[job, "--limits", "limits.toml"][..], &ALL_FILES].concat();
        let fitted = run(workshop.path(), &words("fit"));
        let reported =
            run(workshop.path(), &[&words("report")[..], &["--out", "r.html", "--force"]].concat());
        for output in [&fitted, &reported] {
            assert_eq!(output.status.code(), Some(code), "{limits}: {}", stderr(output));
        }
        let limit_message = |output| {
            stderr(output).lines().find(|line| line.contains("out of limits")).map(str::to_owned)
        };
        assert_eq!(limit_message(&fitted), limit_message(&reported));
        assert_eq!(limit_message(&fitted).is_some(), code == 3);
        assert!(workshop.read("r.html").contains("id=\"limits\""));
    }
    workshop.write("limits.toml", "U = 1\n");
    let words = [&["fit", "--limits", "limits.toml"][..], &ALL_FILES].concat();
    let refused = run(workshop.path(), &words);
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("expected_error"), "{}", stderr(&refused));
}

#[test]
fn the_report_begins_with_the_identity_of_the_sensor() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", SENSOR);
    let words =
        [&["report", "--sensor", "sensor.toml", "--out", "r.html"][..], &ALL_FILES].concat();
    succeed(workshop.path(), &words);
    let html = workshop.read("r.html");
    let (identity, errors) = (html.find("4711").unwrap(), html.find("id=\"scores\"").unwrap());
    assert!(identity < errors);
    assert!(html.contains("A &amp; B &lt;GmbH&gt;") && html.contains("Fz 10.00 N"));
}

#[test]
fn a_folder_names_its_recordings_and_keep_going_skips_a_bad_file() {
    let workshop = Workshop::new();
    for (at, name) in ["s1", "s2"].iter().enumerate() {
        fs::create_dir_all(workshop.file("in").join(name)).unwrap();
        for run in 0..3 {
            let path = format!("in/{name}/r{run}.csv");
            workshop.write(&path, recording((3 * at + run) as f64, 150));
        }
    }
    workshop.write("in/s2/r1.csv", "nothing\n1;2\n");
    let good = ["fit", "--train", "in/s1", "--export", "c.json"];
    succeed(workshop.path(), &good);
    let bad = ["fit", "--train", "in/s2", "--json"];
    let refused = run(workshop.path(), &bad);
    assert!(stderr(&refused).contains("--keep-going"), "{}", stderr(&refused));
    assert_eq!(refused.status.code(), Some(2));
    let going = run(workshop.path(), &[&bad[..], &["--keep-going"]].concat());
    assert_eq!(going.status.code(), Some(1));
    assert_eq!(json(&stdout(&going))["recordings"], 2);
    assert!(
        stderr(&going).contains("left out: ") && stderr(&going).contains("r1.csv"),
        "{}",
        stderr(&going)
    );
    workshop.write("in/s1/a.csv", "t,S1,Fz\n0,1,3\n0.1,2,4\n0.2,3,5\n");
    let odd_first = run(workshop.path(), &["fit", "--train", "in/s1", "--json", "--keep-going"]);
    assert_eq!(json(&stdout(&odd_first))["recordings"], 3, "{}", stderr(&odd_first));
    assert!(stderr(&odd_first).contains("left out: a: "), "{}", stderr(&odd_first));
    let applied =
        run(workshop.path(), &["apply", "c.json", "in/s2", "--out", "loads", "--keep-going"]);
    assert_eq!(applied.status.code(), Some(1));
    assert!(
        workshop.file("loads/r2_loads.csv").exists()
            && !workshop.file("loads/r1_loads.csv").exists()
    );
    fs::create_dir(workshop.file("none")).unwrap();
    let none = run(workshop.path(), &["fit", "--train", "none"]);
    assert!(stderr(&none).contains("the folder contains no recordings"), "{}", stderr(&none));
}

/// The folder is called `e`. The letter e is also part of words in the message, and of other file names.
#[test]
fn the_error_of_a_bad_file_names_its_folder() {
    let workshop = Workshop::with_recordings();
    fs::create_dir_all(workshop.file("e/ce")).unwrap();
    workshop.write("e/good.csv", recording(1.0, 150));
    workshop.write("e/ce/bad.csv", "nothing\n1;2\n");
    workshop.write("bad.csv", "nothing\n1;2\n");
    let alone = run(workshop.path(), &["fit", "--train", "e", "bad.csv"]);
    assert_eq!(alone.status.code(), Some(1), "{}", stderr(&alone));
    assert!(!stderr(&alone).contains("folder"), "{}", stderr(&alone));
    let inside = run(workshop.path(), &["fit", "--train", "e", "e/ce"]);
    assert_eq!(inside.status.code(), Some(2), "{}", stderr(&inside));
    assert!(
        stderr(&inside).contains("The file is in e/ce: this is a folder"),
        "{}",
        stderr(&inside)
    );
}

#[test]
fn keep_going_skips_files_without_reference_but_not_all() {
    let workshop = Workshop::with_recordings();
    fs::create_dir(workshop.file("in")).unwrap();
    workshop.write("in/bare.csv", "t,S1,S2\n0,1,3\n0.1,2,4\n");
    workshop.write("in/whole.csv", recording(1.0, 150));
    let refused = run(workshop.path(), &["fit", "--train", "in"]);
    assert!(stderr(&refused).contains("--keep-going"), "{}", stderr(&refused));
    let going = run(workshop.path(), &["fit", "--train", "in", "--keep-going", "--json"]);
    assert_eq!(going.status.code(), Some(1));
    assert_eq!(json(&stdout(&going))["recordings"], 1);
    assert!(!stderr(&going).contains("It is in"), "{}", stderr(&going));
    fs::remove_file(workshop.file("in/whole.csv")).unwrap();
    let none = run(workshop.path(), &["fit", "--train", "in", "--test", "a.csv", "--keep-going"]);
    let message = stderr(&none);
    assert!(message.contains("no recording to train on could be read"), "{message}");
    assert!(!message.contains("role"), "{message}");
}
