//! Exported Rust files, compiled without this crate.

use std::fs::{self, File};
use std::process::{Command, Stdio};

use loopscope::calibration::Regressor;

use crate::support::{
    RECORDING, assert_loads, assert_runs_live, calibration, disturbed, every_block, export,
    learned, lines, samples, succeed,
};
use crate::tools::is_there;

const DRIVER: &str = r#"
#[allow(dead_code)]
mod exported;
use exported::{GAUGES, Real, State};

fn main() {
    let mut state = State::new();
    for line in std::io::stdin().lines() {
        let line = line.unwrap();
        let mut numbers = line.split(' ').map(|text| text.parse::<f64>().unwrap());
        let time = numbers.next().unwrap();
        let gauges: [Real; GAUGES] = std::array::from_fn(|_| numbers.next().unwrap() as Real);
        let loads = state.update(time, &gauges);
        let status = Real::from(loads.status.0);
        let all = loads.load.iter().chain(&loads.conventional).chain([&status]);
        println!("{}", all.map(|load| load.to_string()).collect::<Vec<_>>().join(" "));
    }
}
"#;

#[test]
fn every_calibration_gives_the_same_loads_in_rust() {
    if !is_there("rustc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("samples.txt"), lines(&samples(&RECORDING))).unwrap();
    fs::write(at("disturbed.txt"), lines(&disturbed())).unwrap();
    fs::write(at("main.rs"), DRIVER).unwrap();
    let mut all = learned();
    all.push(("all_blocks".to_owned(), calibration(every_block(), Regressor::Linear)));
    all.push(("present".to_owned(), calibration(Default::default(), Regressor::Linear)));
    let has_clippy = is_there("clippy-driver", &["--version"]);
    for (name, calibration) in all {
        let double = export(&calibration, &at("exported.rs"));
        let single = double.replace("pub type Real = f64;", "pub type Real = f32;");
        assert_ne!(single, double);
        for (code, tolerance) in [(double, 1e-9), (single, 1e-4)] {
            fs::write(at("exported.rs"), code).unwrap();
            let mut compile = Command::new("rustc");
            compile.args(["--edition", "2024", "-D", "warnings", "-o"]).arg(at("program"));
            succeed(compile.arg(at("main.rs")));
            // The code must also compile for a machine without an operating system.
            fs::write(at("bare.rs"), "#![no_std]\n#![allow(dead_code)]\nmod exported;\n").unwrap();
            let mut compile = Command::new("rustc");
            compile.args(["--edition", "2024", "--crate-type", "lib", "--emit", "metadata"]);
            succeed(compile.arg(at("bare.rs")).arg("-o").arg(at("bare.rmeta")));
            if has_clippy {
                let mut clippy = Command::new("clippy-driver");
                clippy.args(["--edition", "2024", "--crate-type", "lib", "--emit", "metadata"]);
                clippy.args(["-D", "warnings", "-o"]).arg(at("linted.rmeta"));
                succeed(clippy.arg(at("exported.rs")));
            }
            let run = |file: &str| {
                let input = Stdio::from(File::open(at(file)).unwrap());
                succeed(Command::new(at("program")).stdin(input))
            };
            let printed = run("samples.txt");
            assert_loads(&printed, &calibration, &RECORDING, tolerance, &name);
            // In single precision, a load that differs by almost exactly F_th may find another past sample.
            if tolerance < 1e-6 {
                assert_runs_live(&run("disturbed.txt"), &calibration, tolerance, &name);
            }
        }
    }
}

/// A 32-bit counter that wraps around gives the same loads as seconds.
#[test]
fn ticks_in_rust_are_the_same_clock_as_seconds() {
    if !is_there("rustc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    // Times are rounded to microseconds, so that no age equals a threshold.
    let seconds = DRIVER.replace(
        "let time = numbers.next().unwrap();",
        "let time = (1.000137e6 * numbers.next().unwrap()).round() * 1e-6;",
    );
    let ticks = seconds.replace(
        "state.update(time, &gauges)",
        "state.update_ticks((4.29e9 + (1e6 * time).round()) as u64 as u32, 1e6, &gauges)",
    );
    assert!(seconds != DRIVER && ticks != seconds);
    export(&calibration(every_block(), Regressor::Linear), &at("exported.rs"));
    let run = |driver: &str| {
        fs::write(at("samples.txt"), lines(&samples(&RECORDING))).unwrap();
        fs::write(at("main.rs"), driver).unwrap();
        let mut compile = Command::new("rustc");
        compile.args(["--edition", "2021", "-D", "warnings", "-o"]).arg(at("program"));
        succeed(compile.arg(at("main.rs")));
        let input = Stdio::from(File::open(at("samples.txt")).unwrap());
        let printed = succeed(Command::new(at("program")).stdin(input));
        let numbers = printed.split_whitespace().map(|text| text.parse::<f64>().unwrap());
        numbers.collect::<Vec<_>>()
    };
    let (by_seconds, by_ticks) = (run(&seconds), run(&ticks));
    assert!(by_seconds.len() > 100 && by_seconds.len() == by_ticks.len());
    for (own, other) in by_ticks.iter().zip(&by_seconds) {
        assert!((own - other).abs() < 1e-6 || own.is_nan() && other.is_nan(), "{own} {other}");
    }
}
