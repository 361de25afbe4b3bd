//! Load cases, which are tables without times: a mass in many poses, each read several times.

use std::fmt::Write as _;

use serde_json::Value;

use crate::program::{fit, numbers, run, stderr, succeed};
use crate::workshop::Workshop;

const N_POSES: usize = 20;

/// Returns a table of six gauges and six axes under 2 kg in 20 poses, for these repeats of the poses. The gauges have noise.
pub fn poses(repeats: std::ops::Range<usize>) -> String {
    let mut text =
        String::from("pose,S1,S2,S3,S4,S5,S6,Fx [N],Fy [N],Fz [N],Mx [Nm],My [Nm],Mz [Nm]\n");
    for repeat in repeats {
        for pose in 0..N_POSES {
            let (a, b) = (0.9 * pose as f64, 0.37 * pose as f64 + 0.2);
            let force = [a.cos() * b.sin(), a.sin() * b.sin(), b.cos()].map(|x| 19.6133 * x);
            let [x, y, z] = force;
            // The centre of mass moves along the arm from pose to pose.
            let arm = [0.02, -0.01, 0.05 + 0.002 * (pose % 7) as f64];
            let moment =
                [arm[1] * z - arm[2] * y, arm[2] * x - arm[0] * z, arm[0] * y - arm[1] * x];
            write!(text, "{}", pose + 1).unwrap();
            for gauge in 0..6 {
                let g = gauge as f64;
                let weights = |k: usize| ((g + 1.3) * (k as f64 + 0.7)).sin();
                let clean: f64 =
                    (0..3).map(|k| weights(k) * force[k] + 10.0 * weights(k + 3) * moment[k]).sum();
                let noise = ((pose * 31 + repeat * 17 + gauge * 7) as f64 * 12.9898).sin();
                write!(text, ",{}", 3.0 + clean + 0.01 * noise).unwrap();
            }
            for load in force.iter().chain(&moment) {
                write!(text, ",{load:.6}").unwrap();
            }
            text.push('\n');
        }
    }
    text
}

#[test]
fn a_table_of_poses_loads_at_once_and_whole_load_cases_are_left_out() {
    let workshop = Workshop::new();
    workshop.write("poses.csv", poses(0..3));
    let arguments =
        ["fit", "--json", "--train", "poses.csv", "--export", "c.json", "--export", "c.h"];
    let output = succeed(workshop.path(), &arguments);
    let message = stderr(&output);
    assert!(message.contains("the 60 rows are read as 20 load cases"), "{message}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["n_train"], &report["rank"]), (&60.into(), &7.into()));
    assert_eq!(report["cross_validation"]["by"], "load case", "{report}");
    assert_eq!(report["cross_validation"]["groups"], N_POSES);
    assert_eq!(report["cross_validation"]["parts"], N_POSES);
    let findings = report["findings"].as_array().unwrap();
    assert!(findings.iter().any(|own| own["id"] == "no_times"), "{findings:?}");
    for scores in ["conventional", "compensated"] {
        for error in numbers(&report[scores]["cv_rmse"]) {
            assert!(error < 0.05, "{report}");
        }
    }
    // Load cases have no history, so the export has none.
    let calibration: Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
    assert_eq!(calibration["features"]["look_backs"], Value::Array(Vec::new()));
    assert_eq!(calibration["compensated"]["features"].as_array().unwrap().len(), 7);
}

/// One file in another order, and three files with one repeat each, give the same load cases and errors.
#[test]
fn load_cases_do_not_depend_on_order_and_file() {
    let workshop = Workshop::new();
    workshop.write("poses.csv", poses(0..3));
    for repeat in 0..3 {
        workshop.write(&format!("r{repeat}.csv"), poses(repeat..repeat + 1));
    }
    let text = poses(0..3);
    let mut rows: Vec<&str> = text.lines().skip(1).collect();
    rows.sort_by_key(|row| row.split(',').next().unwrap().parse::<u32>().unwrap());
    let header = text.lines().next().unwrap();
    workshop.write("sorted.csv", format!("{header}\n{}\n", rows.join("\n")));
    let scores = |files: &[&str]| {
        let report = fit(workshop.path(), &[&["--train"], files].concat());
        assert_eq!(report["cross_validation"]["parts"], N_POSES, "{files:?}");
        numbers(&report["conventional"]["cv_rmse"])
    };
    let whole = scores(&["poses.csv"]);
    for files in [&["sorted.csv"][..], &["r0.csv", "r1.csv", "r2.csv"]] {
        for (a, b) in scores(files).iter().zip(&whole) {
            assert!((a - b).abs() < 1e-9 * b, "{files:?}: {a} {b}");
        }
    }
}

/// A load case has several rows. 60 % of the load cases train, with all their rows.
#[test]
fn a_split_takes_whole_load_cases() {
    let workshop = Workshop::new();
    workshop.write("poses.csv", poses(0..3));
    let report = fit(workshop.path(), &["--train", "poses.csv", "--split", "0.6"]);
    assert_eq!((&report["n_train"], &report["n_test"]), (&36.into(), &24.into()));
    assert_eq!(report["cross_validation"]["parts"], 12);
}

#[test]
fn static_loads_give_reasons_for_loops_and_dwells_and_figures_for_the_rest() {
    let workshop = Workshop::new();
    workshop.write("poses.csv", poses(0..3));
    let output = succeed(workshop.path(), &["metrology", "--json", "poses.csv"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let figures = |id: &str| -> Vec<Value> {
        let rows = report["rows"].as_array().unwrap();
        let row = rows.iter().find(|row| row["id"] == id).expect(id);
        let cells = row["cells"].as_array().unwrap().iter();
        cells.map(|cell| cell["conventional"].clone()).collect()
    };
    for id in ["hysteresis", "loop_area", "nonlinearity_terminal", "zero_return", "creep"] {
        for figure in figures(id) {
            let reason = figure["reason"].as_str().unwrap();
            assert!(figure["value"].is_null() && reason.contains("times"), "{id}: {figure}");
        }
    }
    // A figure that noise alone can make has no value.
    for figure in figures("nonlinearity_best_fit") {
        let value = figure["value"].as_f64().unwrap_or(0.0);
        let reason = figure["reason"].as_str().unwrap_or_default();
        assert!(value < 0.2 && (value > 0.0 || reason.contains("below the noise")), "{figure}");
    }
    for id in ["repeatability", "rmse"] {
        for figure in figures(id) {
            let value = figure["value"].as_f64().unwrap_or_else(|| panic!("{id}: {figure}"));
            assert!(value > 0.0 && value < 0.2, "{id}: {figure}");
        }
    }
    let sweep = run(workshop.path(), &["sweep", "--train", "poses.csv"]);
    assert!(stderr(&sweep).contains("have no times"), "{}", stderr(&sweep));
}

/// If a column is monotonic, or if there are too many rows for load cases, the program asks for the time.
#[test]
fn a_few_rows_without_a_time_are_load_cases_and_many_are_in_order() {
    let workshop = Workshop::new();
    let rows = |n: usize, clock: fn(usize) -> f64| {
        (0..n).fold("ticker,S1,S2,Fz\n".to_owned(), |text, k| {
            let load = (0.01 * k as f64).sin();
            format!("{text}{},{},{},{load}\n", clock(k), 2.0 * load, 1.0 - load)
        })
    };
    workshop.write("clock.csv", rows(100, |k| 5.0 + 0.01 * k as f64));
    workshop.write("long.csv", rows(3000, |_| 0.0));
    for (file, read_as) in [("clock.csv", "100 load cases"), ("long.csv", "order of the 3000 rows")]
    {
        let output = succeed(workshop.path(), &["fit", "--train", file]);
        assert!(stderr(&output).contains(read_as), "{}", stderr(&output));
    }
}
