//! `metrology`, which computes figures such as hysteresis. In every format the figures equal those of an independent implementation.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::program::{run, stderr, succeed};
use crate::workshop::{ALL_FILES, HEADER, Workshop};

/// Maximum relative difference from the NumPy figures.
const TOLERANCE: f64 = 1e-6;

#[track_caller]
fn metrology(directory: &Path, arguments: &[&str]) -> Value {
    let output = succeed(directory, &[&["metrology", "--json"], arguments].concat());
    serde_json::from_slice(&output.stdout).unwrap()
}

fn row<'a>(report: &'a Value, id: &str) -> &'a Value {
    let rows = report["rows"].as_array().unwrap();
    rows.iter().find(|row| row["id"] == id).expect(id)
}

/// Calls `check` with each row of the table and each figure of this row, conventional and compensated.
fn each_figure(report: &Value, mut check: impl FnMut(&Value, &Value)) {
    for row in report["rows"].as_array().unwrap() {
        for cell in row["cells"].as_array().unwrap() {
            check(row, &cell["conventional"]);
            check(row, &cell["compensated"]);
        }
    }
}

fn texts(workshop: &Workshop, arguments: &[&str]) -> String {
    let arguments = [&["metrology"], arguments].concat();
    String::from_utf8(succeed(workshop.path(), &arguments).stdout).unwrap()
}

#[test]
fn figures_are_those_of_an_independent_implementation() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let expected = fs::read_to_string(golden.join("metrology_expected.json")).unwrap();
    let expected: Value = serde_json::from_str(&expected).unwrap();
    for case in expected["cases"].as_array().unwrap() {
        let files = case["files"].as_array().unwrap().iter();
        let files: Vec<&str> = files.map(|file| file.as_str().unwrap()).collect();
        // The independent figures are those of a fit that stores all samples.
        let folder = tempfile::tempdir().unwrap();
        let stored = folder.path().join("all.json");
        let stored = stored.to_str().unwrap();
        let fit = ["--history-rate", "0", "--export", stored];
        succeed(&golden, &[&["fit", "--train"], &files[..], &fit].concat());
        let report = metrology(&golden, &[&["--calibration", stored], &files[..]].concat());
        for (at, axis) in case["axes"].as_array().unwrap().iter().enumerate() {
            let near = |actual: &Value, expected: &Value, what: &str| {
                let (Some(actual), Some(expected)) = (actual.as_f64(), expected.as_f64()) else {
                    assert_eq!(actual, expected, "{what}");
                    return;
                };
                let off = (actual / expected - 1.0).abs();
                assert!(off < TOLERANCE, "{what}: {actual} is not {expected}");
            };
            near(
                &report["reversal_thresholds"][at],
                &axis["reversal_threshold"],
                "reversal threshold",
            );
            for (id, figures) in axis["figures"].as_object().unwrap() {
                let cell = &row(&report, id)["cells"][at];
                for (output, name) in ["conventional", "compensated"].iter().enumerate() {
                    let what = format!("{name} {id} of {} in {files:?}", axis["axis"]);
                    near(&cell[name]["value"], &figures[output], &what);
                }
            }
        }
    }
}

#[test]
fn a_calibration_file_measures_as_the_fit_that_made_it() {
    let workshop = Workshop::with_recordings();
    let fit = ["fit", "--train", "a.csv", "b.csv", "--export", "c.json"];
    succeed(workshop.path(), &fit);
    let fitted = metrology(workshop.path(), &["a.csv", "b.csv"]);
    let read = metrology(workshop.path(), &["--calibration", "c.json", "a.csv", "b.csv"]);
    assert_eq!(fitted["rows"], read["rows"]);
    let rmse = &row(&fitted, "rmse")["cells"][0];
    assert!(rmse["compensated"]["value"].as_f64() < rmse["conventional"]["value"].as_f64());
}

#[test]
fn every_figure_is_a_number_or_a_reason() {
    let workshop = Workshop::with_recordings();
    let up = format!("{HEADER}0,1,2,0\n1,2,3,5\n2,3,5,9\n");
    workshop.write("up.csv", up);
    workshop.write("still.csv", format!("{HEADER}0,1,2,5\n1,1,2,5\n2,1,2,5\n"));
    for file in ["a.csv", "up.csv", "still.csv"] {
        let (mut numbers, mut reasons) = (0, 0);
        each_figure(&metrology(workshop.path(), &[file]), |row, figure| {
            let is_number = figure["value"].is_number();
            assert_ne!(is_number, figure["reason"].is_string(), "{file} {}", row["id"]);
            numbers += usize::from(is_number);
            reasons += usize::from(!is_number);
        });
        assert!(numbers >= 6 && reasons >= 2, "{file}: {numbers} {reasons}");
        let is_measured = |row: &Value| {
            let cell = &row["cells"][0];
            ["conventional", "compensated"].iter().any(|own| cell[own]["value"].is_number())
        };
        let (table, report) = (texts(&workshop, &[file]), metrology(workshop.path(), &[file]));
        for row in report["rows"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|row| row["cells"].as_array().unwrap().len() == 1)
        {
            let name = row["name"].as_str().unwrap();
            let is_shown = table.lines().any(|line| line.trim_start().starts_with(name));
            assert!(is_shown || !is_measured(row), "{file} {name}");
        }
        let creep =
            report["rows"].as_array().unwrap().iter().find(|row| row["id"] == "creep").unwrap();
        assert!(
            is_measured(creep)
                == table.lines().any(|line| line.trim_start().starts_with("Creep  ")),
            "{file}: {table}"
        );
        assert!(!texts(&workshop, &[file]).contains("NaN"), "{file}");
    }
}

#[test]
fn a_recording_without_reference_has_a_reason_for_each_figure() {
    let workshop = Workshop::with_recordings();
    let fit = [&["fit"], &ALL_FILES[..], &["--export", "c.json"]].concat();
    succeed(workshop.path(), &fit);
    workshop.write("bare.csv", "t [s],S1,S2\n0,40,0\n0.1,41,0.1\n");
    let report = metrology(workshop.path(), &["--calibration", "c.json", "bare.csv"]);
    each_figure(&report, |_, figure| {
        let reason = figure["reason"].as_str().unwrap();
        assert!(reason.contains("no recording has a reference load for Fz"), "{reason}");
    });
}

#[test]
fn the_csv_holds_the_figures_of_the_json_with_their_definitions() {
    let workshop = Workshop::with_recordings();
    let report = metrology(workshop.path(), &["a.csv", "--csv", "table.csv"]);
    let mut csv = csv::Reader::from_path(workshop.file("table.csv")).unwrap();
    let header = csv.headers().unwrap().clone();
    let at = |name: &str| header.iter().position(|column| column == name).unwrap();
    let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), report["rows"].as_array().unwrap().len());
    for (written, row) in rows.iter().zip(report["rows"].as_array().unwrap()) {
        assert_eq!(written[at("id")], row["id"]);
        assert_eq!(written[at("definition")], row["definition"]);
        for output in ["conventional", "compensated"] {
            let figure = &row["cells"][0][output];
            assert_eq!(written[at(output)].parse().ok(), figure["value"].as_f64());
            let reason = &written[at(&format!("{output}_reason"))];
            assert_eq!(reason, figure["reason"].as_str().unwrap_or_default());
        }
    }
}

#[test]
fn the_table_shows_notes_and_definitions() {
    let workshop = Workshop::with_recordings();
    let table = texts(&workshop, &["a.csv", "--full-scale", "2", "--reversal-threshold", "0.5"]);
    assert!(table.contains("full scale 2.000, reversal threshold 0.500"), "{table}");
    assert!(table.contains("Note: Fz reaches"), "{table}");
    assert!(!table.contains("OIML"));
    let explained = texts(&workshop, &["a.csv", "--definitions"]);
    for word in ["OIML R 60", "VDI/VDE 2638", "Free-running"] {
        assert!(explained.contains(word), "{word}");
    }
}

#[test]
fn without_files_the_built_in_sensor_is_measured_on_its_test_recordings() {
    let report = metrology(Path::new("."), &[]);
    assert_eq!(report["simulated"], true);
    // The built-in sensor has 15 test recordings with 40,500 samples, and six bench recordings with 6,841 samples each.
    assert_eq!(
        (&report["n_recordings"], &report["n_samples"]),
        (&21.into(), &(40_500 + 6 * 6_841).into())
    );
    each_figure(&report, |row, figure| {
        let reason = figure["reason"].as_str().unwrap_or_default();
        // The load moves slowly at one rate, and the gauges creep. So the lag is unknown on most axes.
        let is_of_lag =
            ["time_lag", "hysteresis_without_lag"].contains(&row["id"].as_str().unwrap());
        let is_there =
            figure["reason"].is_null() || reason.contains("is the loaded axis") || is_of_lag;
        // The recordings have no temperature, and several gauges have no single sensitivity.
        let id = row["id"].as_str().unwrap();
        let is_there = is_there || id.starts_with("temperature_") || id == "sensitivity";
        assert!(is_there, "{}: {reason}", row["id"]);
    });
    for id in ["hysteresis", "loop_area"] {
        for cell in row(&report, id)["cells"].as_array().unwrap() {
            let of = |output: &str| cell[output]["value"].as_f64().unwrap();
            assert!(of("compensated") < of("conventional"), "{id} {}", cell["axis"]);
        }
    }
}

#[test]
fn impossible_arguments_are_refused_in_one_line() {
    let workshop = Workshop::with_recordings();
    let before = workshop.read("a.csv");
    for (arguments, word) in [
        ("a.csv --full-scale 1,2", "2 full scales"),
        ("a.csv --dead-band NaN", "reversal threshold of axis 1 is NaN"),
        ("a.csv --hold 0", "shortest dwell is 0"),
        ("a.csv --csv a.csv", "replace the input"),
        ("gone.csv", "gone.csv"),
        ("--calibration gone.json a.csv", "gone.json"),
    ] {
        let arguments: Vec<&str> = ["metrology"].into_iter().chain(arguments.split(' ')).collect();
        let output = run(workshop.path(), &arguments);
        let message = stderr(&output);
        assert!(!output.status.success() && output.stdout.is_empty(), "{arguments:?}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.contains(word), "{arguments:?}: {message}");
    }
    let negative = run(workshop.path(), &["metrology", "a.csv", "--full-scale", "-1"]);
    assert!(!negative.status.success() && stderr(&negative).contains("'-1' for '--full-scale"));
    assert_eq!(workshop.read("a.csv"), before);
    workshop.write("bare.csv", "t [s],S1,S2\n0,40,0\n0.1,41,0.1\n");
    assert!(stderr(&run(workshop.path(), &["metrology", "bare.csv"])).contains("no reference"));
}
