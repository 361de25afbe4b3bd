//! Recordings of real sensors, where they are at hand (they are no part of this project): the figures must be those
//! that NumPy gives on the same files by the rules of `golden/generate.py`.

#[path = "support/program.rs"]
mod program;

use std::fmt::Write as _;
use std::fs;
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

/// The numbers of a file without header.
fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    let numbers = |line: &str| {
        line.split([',', '\t'])
            .map(|x| x.parse().unwrap())
            .collect()
    };
    text.lines().map(numbers).collect()
}

fn write(path: &Path, header: &str, rows: impl Iterator<Item = Vec<f64>>) {
    let mut text = format!("{header}\n");
    for row in rows {
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(text, "{}", cells.join(",")).unwrap();
    }
    fs::write(path, text).unwrap();
}

/// Straight lines between the `(time, value)`s; before the first and after the last their values.
fn interpolated(at: f64, known: &[(f64, f64)]) -> f64 {
    let next = known.partition_point(|(time, _)| *time <= at);
    match (next.checked_sub(1).map(|last| known[last]), known.get(next)) {
        (Some((t0, y0)), Some((t1, y1))) => y0 + (y1 - y0) * (at - t0) / (t1 - t0),
        (Some((_, only)), None) | (None, Some(&(_, only))) => only,
        (None, None) => panic!("nothing to interpolate"),
    }
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

/// The error on the last 40 % of a stretch recording: resistances and force on two clocks, brought to one.
fn stretch_report(name: &str, thresholds: &[&str]) -> Option<Value> {
    let raw = rows(&recordings_of("stretch")?.join(name));
    let forces: Vec<(f64, f64)> = raw.iter().map(|row| (row[6], row[5])).collect();
    let directory = tempfile::tempdir().unwrap();
    let on_one_clock = raw.iter().map(|row| {
        let time = row[2];
        vec![row[0], row[1], time, interpolated(time, &forces)]
    });
    write(
        &directory.path().join("run.csv"),
        "u1,u2,t [s],Fz [N]",
        on_one_clock,
    );
    let split = ["--train", "run.csv", "--split", "0.6"];
    Some(fit(directory.path(), &[&split, thresholds].concat()))
}

#[test]
fn look_back_mends_a_fifth_of_the_error_of_a_stretch_sensor() {
    let thresholds = ["--f-th", "0.15", "--t-th", "3"];
    if let Some(report) = stretch_report("multisine_600s_1.csv", &thresholds) {
        assert_test_rmse(&report, "conventional", &[0.355129]);
        assert_test_rmse(&report, "compensated", &[0.279758]);
    }
}

#[test]
fn look_back_mends_a_third_of_the_error_of_a_stretch_sensor_in_sawtooth() {
    let thresholds = ["--f-th", "0.22", "--t-th", "7"];
    if let Some(report) = stretch_report("rand_sawtooth.csv", &thresholds) {
        assert_test_rmse(&report, "conventional", &[0.483879]);
        assert_test_rmse(&report, "compensated", &[0.327365]);
    }
}

/// Fifteen channels in one file, the load in another; a load of -1 is a dropout.
#[test]
fn look_back_mends_a_fifth_of_the_error_of_a_magnetic_skin() {
    let Some(folder) = recordings_of("eflesh") else {
        return;
    };
    let directory = tempfile::tempdir().unwrap();
    let channels: Vec<String> = (1..=15).map(|channel| format!("ch{channel}")).collect();
    let header = format!("t [s],{},Fz", channels.join(","));
    let runs = ["20250401_014340", "20250401_015037", "20250401_015717"];
    for (run, name) in runs.iter().zip(["1.csv", "2.csv", "3.csv"]) {
        let states = rows(&folder.join(run).join("states.csv"));
        let loads: Vec<(f64, f64)> = states
            .iter()
            .filter(|row| row[4] != -1.0)
            .map(|row| (row[0], row[4]))
            .collect();
        let sensor = rows(&folder.join(run).join("sensor.csv")).into_iter();
        let with_load = sensor.map(|mut row| {
            row.push(interpolated(row[0], &loads));
            row
        });
        write(&directory.path().join(name), &header, with_load);
    }
    let roles = ["--train", "1.csv", "2.csv", "--test", "3.csv"];
    let thresholds = ["--f-th", "1000", "--t-th", "30"];
    let report = fit(directory.path(), &[&roles[..], &thresholds].concat());
    assert_test_rmse(&report, "conventional", &[90.396472]);
    assert_test_rmse(&report, "compensated", &[73.204422]);
}

/// Rows come in bursts of fifteen; a metal sensor has hardly any hysteresis to mend.
#[test]
fn look_back_does_little_for_a_metal_sensor() {
    let Some(folder) = recordings_of("ft6") else {
        return;
    };
    let directory = tempfile::tempdir().unwrap();
    for name in ["1", "2", "3", "4"] {
        let raw = rows(&folder.join(format!("directional_{name}.txt")));
        let header = "t [ns],S1,S2,S3,S4,S5,S6,Fx,Fy,Fz,Mx,My,Mz";
        let used = raw.into_iter().map(|row| row[..13].to_vec());
        write(&directory.path().join(format!("{name}.csv")), header, used);
    }
    let roles = ["--train", "1.csv", "2.csv", "4.csv", "--test", "3.csv"];
    let thresholds = ["--f-th", "10", "--t-th", "15"];
    let report = fit(directory.path(), &[&roles[..], &thresholds].concat());
    assert_eq!(report["recordings"], 4);
    let conventional = [6.882583, 6.285746, 1.655491, 1.072821, 1.255908, 0.1283777];
    let compensated = [7.186475, 6.187605, 1.655938, 1.041042, 1.310694, 0.1153050];
    assert_test_rmse(&report, "conventional", &conventional);
    assert_test_rmse(&report, "compensated", &compensated);
}
