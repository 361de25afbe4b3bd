//! `apply`: a calibration file and recordings in, loads out.

use crate::program::{fit, numbers, stderr, succeed};
use crate::table::Table;
use crate::workshop::{ALL_FILES, HEADER, Workshop, rows};

fn rmse(predicted: &[f64], truth: &[f64]) -> f64 {
    let errors = predicted.iter().zip(truth).map(|(a, b)| (a - b).powi(2));
    (errors.sum::<f64>() / truth.len() as f64).sqrt()
}

/// Fits the files of the workshop with `change`, leaving `c.json`; returns what `fit` reported.
fn calibrate(workshop: &Workshop, change: &[&str]) -> serde_json::Value {
    let arguments = [&ALL_FILES[..], &["--export", "c.json"], change].concat();
    fit(workshop.path(), &arguments)
}

fn apply(workshop: &Workshop, file: &str) -> Table {
    succeed(workshop.path(), &["apply", "c.json", file, "--out", "."]);
    Table::read(&workshop.file(&file.replace(".csv", "_loads.csv")))
}

#[test]
fn applied_loads_have_the_errors_that_the_fit_reported() {
    for change in [
        &[][..],
        &["--no-offset"],
        &["--distance", "full-scale", "--f-th", "0.2"],
    ] {
        let workshop = Workshop::with_recordings();
        let paused = [HEADER, &rows(3.0, 90, 7.0), &rows(4.0, 60, 300.0)].concat();
        workshop.write("test.csv", paused);
        let report = calibrate(&workshop, change);
        let loads = apply(&workshop, "test.csv");
        let truth = loads.column("Fz calc");
        for (column, calibration) in [("Fz conv", "conventional"), ("Fz comp", "compensated")] {
            let reported = numbers(&report[calibration]["test_rmse"])[0];
            let found = rmse(&loads.column(column), &truth);
            assert!((found / reported - 1.0).abs() < 1e-9, "{change:?} {column}");
        }
        assert_ne!(loads.column("Fz conv"), loads.column("Fz comp"));
    }
}

#[test]
fn as_many_rows_come_out_as_went_in() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let paused = [HEADER, &rows(3.0, 70, 0.0), &rows(4.0, 50, 99.0)].concat();
    workshop.write("paused.csv", paused);
    let given = Table::read(&workshop.file("paused.csv"));
    let loads = apply(&workshop, "paused.csv");
    assert_eq!(loads.column("t [s]"), given.column("t [s]"));
    assert_eq!(loads.column("Fz calc"), given.column("Fz"));
}

#[test]
fn a_recording_without_reference_gets_loads_too() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    workshop.write("bare.csv", "t [s],S1,S2\n0,40,0\n0.1,41,0.1\n");
    let loads = apply(&workshop, "bare.csv");
    assert_eq!(loads.header, ["t [s]", "Fz conv [N]", "Fz comp [N]"]);
    assert_eq!(loads.rows.len(), 2);
}

#[test]
fn several_files_go_into_a_directory_that_is_made() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let arguments = ["apply", "c.json", "a.csv", "b.csv", "--out", "new/loads"];
    let output = succeed(workshop.path(), &arguments);
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 2);
    for name in ["new/loads/a_loads.csv", "new/loads/b_loads.csv"] {
        assert_eq!(Table::read(&workshop.file(name)).rows.len(), 150);
    }
}

/// A zero that has moved between two days: without taring it is in every load, with taring in none.
#[test]
fn a_tared_calibration_says_so_and_reads_tared_recordings() {
    let workshop = Workshop::with_recordings();
    let shifted = |text: String| -> String {
        let mut lines = text.lines();
        let header = lines.next().unwrap().to_owned();
        let shift = |line: &str| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            cells[1] = (cells[1].parse::<f64>().unwrap() + 5.0).to_string();
            cells.join(",")
        };
        [header]
            .into_iter()
            .chain(lines.map(shift))
            .collect::<Vec<_>>()
            .join("\n")
    };
    workshop.write("today.csv", shifted(workshop.read("a.csv")));
    let tare = ["--tare", "0:0.5"];
    let made = [
        &[
            "fit", "--train", "a.csv", "b.csv", "--export", "cal.json", "--export", "cal.yaml",
        ],
        &tare[..],
    ]
    .concat();
    succeed(workshop.path(), &made);
    assert!(workshop.read("cal.json").contains("\"stretch\""));
    assert!(
        workshop
            .read("cal.yaml")
            .contains("0 s to 0.5 s of each recording")
    );
    let apply = |out: &str, file: &str, more: &[&str]| {
        let arguments = [&["apply", "cal.json", file, "--out", out], more].concat();
        succeed(workshop.path(), &arguments)
    };
    apply("before", "a.csv", &tare);
    apply("after", "today.csv", &tare);
    let loads = |path: &str| -> Vec<f64> {
        let text = workshop.read(path);
        let rows = text
            .lines()
            .skip_while(|line| !line.starts_with(char::is_numeric));
        rows.flat_map(|row| {
            row.split(',')
                .map(|cell| cell.parse().unwrap())
                .collect::<Vec<f64>>()
        })
        .collect()
    };
    let (before, after) = (loads("before/a_loads.csv"), loads("after/today_loads.csv"));
    assert!(!before.is_empty() && before.len() == after.len());
    for (before, after) in before.iter().zip(&after) {
        assert!((before - after).abs() < 1e-5, "{before} became {after}");
    }
    let told = stderr(&apply("raw", "today.csv", &[]));
    assert!(
        told.contains("not tared, and the calibration was made of gauges less"),
        "{told}"
    );
}
