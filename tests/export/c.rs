//! C headers, compiled as strictly as C99 can be.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use loopscope::calibration::{Calibration, Regressor};
use loopscope::recording::Recording;

use crate::support::{
    RATE_HZ, RECORDING, assert_loads, calibration, calibrations, every_block, export, is_there,
    samples, succeed,
};

const STRICT: [&str; 5] = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"];

/// Exports `calibration` into `directory` and compiles the driver on it; `real` is the type of the numbers.
#[track_caller]
fn compiled(calibration: &Calibration, directory: &Path, name: &str, real: &str) -> PathBuf {
    let header = directory.join(format!("{name}.h"));
    if !header.exists() {
        export(calibration, &header);
    }
    let program = directory.join(format!("{name}_{real}"));
    let driver = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export/driver.c");
    let upper = name.to_ascii_uppercase();
    succeed(
        Command::new("cc")
            .args(STRICT)
            .args(["-O1", "-o"])
            .arg(&program)
            .arg(format!("-DHEADER=\"{}\"", header.display()))
            .arg(format!("-DNAME={name}"))
            .arg(format!("-DCALIBRATION={upper}_CALIBRATION"))
            .arg(format!("-DGAUGES={upper}_GAUGES"))
            .arg(format!("-DAXES={upper}_AXES"))
            .arg(format!("-DLOOPSCOPE_REAL={real}"))
            .arg(format!("-DLOOPSCOPE_RATE_HZ={RATE_HZ}"))
            .arg(driver)
            .arg("-lm"),
    );
    program
}

fn fed(program: &Path, directory: &Path, recording: &Recording) -> Command {
    let input = directory.join("samples.txt");
    fs::write(&input, samples(recording)).unwrap();
    let mut command = Command::new(program);
    command.stdin(Stdio::from(File::open(input).unwrap()));
    command
}

#[test]
fn every_calibration_runs_in_c_as_it_does_here() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    for (name, calibration) in calibrations() {
        for (real, tolerance) in [("double", 1e-9), ("float", 1e-4)] {
            let program = compiled(&calibration, directory.path(), &name, real);
            let printed = succeed(&mut fed(&program, directory.path(), &RECORDING));
            assert_loads(
                &printed,
                &calibration,
                &RECORDING,
                tolerance,
                &format!("{name} in {real}"),
            );
        }
    }
}

/// After taring at sample 100, what is printed is less by the loads of that sample.
#[test]
fn bias_takes_the_last_load_as_zero() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(every_block(), Regressor::Linear);
    let program = compiled(&calibration, directory.path(), "tared", "double");
    let printed = succeed(fed(&program, directory.path(), &RECORDING).arg("tare"));
    let applied = calibration.apply(&RECORDING).unwrap();
    let of = |sample: usize| &applied.compensated[sample * 6..][..6];
    for (k, line) in printed.lines().enumerate().skip(100) {
        for (axis, text) in line.split_whitespace().take(6).enumerate() {
            let actual: f64 = text.parse().unwrap();
            let expected = of(k)[axis] - of(99)[axis];
            assert!(
                (actual - expected).abs() < 1e-8,
                "sample {k}: {actual} is not {expected}"
            );
        }
    }
}

/// A sample that is no number, and one from the past, give the last load again and leave no trace.
#[test]
fn bad_samples_are_ignored_in_c() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(every_block(), Regressor::Linear);
    let program = compiled(&calibration, directory.path(), "robust", "double");
    let good: Vec<String> = samples(&RECORDING)
        .lines()
        .take(60)
        .map(str::to_owned)
        .collect();
    let run = |lines: &[String]| {
        let input = directory.path().join("lines.txt");
        fs::write(&input, lines.join("\n")).unwrap();
        let printed =
            succeed(Command::new(&program).stdin(Stdio::from(File::open(input).unwrap())));
        printed.lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let mut disturbed = good.clone();
    disturbed.insert(
        30,
        good[29]
            .replacen(' ', " nan ", 1)
            .rsplit_once(' ')
            .unwrap()
            .0
            .to_owned(),
    );
    disturbed.insert(31, good[10].clone());
    let (mut actual, expected) = (run(&disturbed), run(&good));
    assert_eq!(actual[30], expected[29]);
    actual.drain(30..32);
    assert_eq!(actual, expected);
}

/// What the comment says of the memory is what the compiler makes of it, at the rate that it names.
#[test]
fn the_stated_memory_is_that_of_the_state() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let header = directory.path().join("sized.h");
    let text = export(&calibration(every_block(), Regressor::Linear), &header);
    let stated = text
        .split_once("about ")
        .unwrap()
        .1
        .split_once(' ')
        .unwrap()
        .0;
    let stated: f64 = stated.parse().unwrap();
    let source = directory.path().join("sized.c");
    fs::write(&source, "#include <stdio.h>\n#include \"sized.h\"\nint main(void) { printf(\"%lu\", (unsigned long)sizeof(sized_state)); return 0; }\n").unwrap();
    let program = directory.path().join("sized");
    succeed(
        Command::new("cc")
            .args(STRICT)
            .arg(&source)
            .arg("-o")
            .arg(&program)
            .arg("-lm"),
    );
    let actual: f64 = succeed(&mut Command::new(program)).parse().unwrap();
    assert!((stated / actual - 1.0).abs() < 0.001, "{stated} {actual}");
}

#[test]
fn names_from_files_stay_in_their_comments() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let mut calibration = calibration(every_block(), Regressor::Linear);
    calibration.trained_on = vec![
        "*/ #error /* ??/\n\\".to_owned(),
        "x \u{202e}\u{1b}[31m".to_owned(),
    ];
    compiled(&calibration, directory.path(), "named", "double");
    let odd = directory.path().join("2 left-arm.h");
    let text = export(&calibration, &odd);
    assert!(text.contains("cal_2_left_arm_update("));
    assert!(!text.contains('\u{202e}') && !text.contains('\u{1b}'));
}
