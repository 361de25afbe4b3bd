//! Temperature as an auxiliary channel. The temperature is read, fitted and reported, and `apply` requires it.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::program::{fit, numbers, run, stderr, succeed};
use crate::workshop::Workshop;

/// Writes a recording with a gauge whose zero and sensitivity depend on a temperature. Only some rows have the temperature, in °F.
fn write(workshop: &Workshop, name: &str, celsius: f64) {
    let mut text = "t [s],S1 [mV/V],S2 [mV/V],Fz [N],T_body [degF]\n".to_owned();
    for k in 0..600 {
        let t = f64::from(k) * 0.02;
        let warm = celsius + 2.0 * (f64::from(k / 20) / 4.0).sin();
        let (s, noise) = ((1.3 * t).sin(), f64::from(k * 37 % 11) * 1e-3);
        let load = 100.0 * s + (warm - 20.0) * (1.0 + 0.5 * s);
        let cell = match k % 20 {
            0 => format!("{}", warm * 1.8 + 32.0),
            _ => String::new(),
        };
        writeln!(text, "{t},{s},{},{load},{cell}", (0.7 * t).cos() + noise).unwrap();
    }
    fs::write(workshop.path().join(name), text).unwrap();
}

fn output(directory: &Path, arguments: &[&str]) -> String {
    String::from_utf8(succeed(directory, arguments).stdout).unwrap()
}

#[test]
fn a_temperature_is_read_fitted_exported_and_asked_for() {
    let workshop = Workshop::new();
    let files = ["a.csv", "b.csv", "c.csv", "d.csv"];
    for (name, celsius) in files.into_iter().zip([10.0, 25.0, 40.0, 30.0]) {
        write(&workshop, name, celsius);
    }
    let inspected = output(workshop.path(), &["inspect", "a.csv"]);
    assert!(inspected.contains("auxiliary channels: T_body 8.0 to 12.0 °C"), "{inspected}");
    let chosen = ["--train", "a.csv", "b.csv", "c.csv", "--test", "d.csv", "--look-back", "none"];
    let error = |more: &[&str]| {
        let report = fit(workshop.path(), &[&chosen[..], more].concat());
        numbers(&report["compensated"]["test_rmse"])[0]
    };
    assert!(error(&[]) > 3.0);
    let exports = ["--auxiliary", "--export", "c.json", "--export", "c.h"];
    assert!(error(&exports) < 1e-6);
    let printed =
        output(workshop.path(), &[&["fit"], &chosen[..], &["--auxiliary", "0,3"]].concat());
    assert!(printed.contains("T_body [°C], trained from 8 to 42 °C"), "{printed}");
    let header = fs::read_to_string(workshop.path().join("c.h")).unwrap();
    assert!(header.contains("T_body [°C], trained from 8 to 42 °C"));

    let bare = fs::read_to_string(workshop.path().join("d.csv"))
        .unwrap()
        .replace("T_body [degF]", "label");
    fs::write(workshop.path().join("bare.csv"), bare).unwrap();
    let refused = run(workshop.path(), &["apply", "c.json", "bare.csv", "--out", "out"]);
    let answer = stderr(&refused);
    assert!(
        !refused.status.success() && answer.contains("bare has no auxiliary channel T_body [°C]"),
        "{answer}"
    );

    write(&workshop, "hot.csv", 60.0);
    let beyond = run(workshop.path(), &["apply", "c.json", "hot.csv", "--status", "--out", "out"]);
    let answer = stderr(&beyond);
    assert!(beyond.status.success(), "{answer}");
    assert!(
        answer
            .contains("warning: T_body of hot is 58.0 to 62.0 °C, but the training recordings cover 8 to 42 °C"),
        "{answer}"
    );
    let written = fs::read_dir(workshop.path().join("out")).unwrap().next().unwrap().unwrap();
    let loads = fs::read_to_string(written.path()).unwrap();
    assert!(loads.lines().skip(1).all(|line| line.ends_with(",beyond")));
}

#[test]
fn a_missing_auxiliary_column_is_named() {
    let workshop = Workshop::with_recordings();
    let printed = output(workshop.path(), &["fit", "--train", "a.csv", "b.csv", "--auxiliary"]);
    assert!(printed.contains("no column of the recordings is an auxiliary channel"), "{printed}");
}

/// The logger records no temperature from 6 s to 9 s.
#[test]
fn a_gap_in_a_temperature_is_reported_and_sets_the_status() {
    let workshop = Workshop::new();
    for (name, celsius) in [("a.csv", 10.0), ("b.csv", 40.0), ("c.csv", 25.0)] {
        write(&workshop, name, celsius);
    }
    let every_row = |text: &str, is_hole: &dyn Fn(usize) -> bool| {
        let mut last = String::new();
        let rows = text.lines().enumerate().map(|(k, row)| {
            let (front, cell) = row.rsplit_once(',').unwrap();
            if !cell.is_empty() {
                last = cell.to_owned();
            }
            let cell = if is_hole(k) { "" } else { &last };
            format!("{front},{cell}\n")
        });
        rows.collect::<String>()
    };
    let text = workshop.read("c.csv");
    workshop.write("c.csv", every_row(&text, &|k| (301..451).contains(&k)));
    let chosen = ["--train", "a.csv", "b.csv", "--auxiliary", "--look-back", "none"];
    succeed(workshop.path(), &[&["fit"], &chosen[..], &["--export", "c.json"]].concat());
    let applied =
        succeed(workshop.path(), &["apply", "c.json", "c.csv", "--status", "--out", "out"]);
    let answer = stderr(&applied);
    assert!(answer.contains("has no value in 150 rows, for at most 3.020 s"), "{answer}");
    let loads = workshop.read("out/c_loads.csv");
    let rows = loads.lines().skip(1);
    let held: Vec<usize> = rows
        .enumerate()
        .filter(|(_, row)| row.ends_with(",auxiliary held"))
        .map(|(row, _)| row)
        .collect();
    assert_eq!(held, (300..450).collect::<Vec<_>>());
    // The status begins one gap length (20 rows) after the last temperature.
    let rows: Vec<&str> = loads.lines().collect();
    assert!(rows[200].ends_with(",ok") && rows[500].ends_with(",ok"), "{}", rows[200]);
}
