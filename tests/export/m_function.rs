//! Exported MATLAB functions. The tests run them only if Octave is installed.

use std::fs;
use std::path::Path;
use std::process::Command;

use loopscope::calibration::Regressor;

use crate::support::{
    RECORDING, assert_loads, assert_runs_live, calibration, calibrations, disturbed, every_block,
    export, lines, samples, succeed,
};
use crate::tools::is_there;

const DRIVER: &str = "
arguments = argv();
samples = dlmread(arguments{1}, ' ');
state = exported();
for at = 1:rows(samples)
    [load, conventional, status, state] = exported(state, samples(at, 1), samples(at, 2:end));
    printf('%.17g ', load, conventional);
    printf('%d\\n', status);
end
";

#[track_caller]
fn octave(directory: &Path, arguments: &[&str]) -> String {
    let mut octave = Command::new("octave-cli");
    let octave = octave.current_dir(directory).args(["--norc", "--quiet"]);
    succeed(octave.args(arguments))
}

fn octave_is_there() -> bool {
    is_there("octave-cli", &["--version"])
}

#[test]
fn every_calibration_gives_the_same_loads_in_octave() {
    if !octave_is_there() {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("samples.txt"), lines(&samples(&RECORDING))).unwrap();
    fs::write(at("disturbed.txt"), lines(&disturbed())).unwrap();
    fs::write(at("main.m"), DRIVER).unwrap();
    for (name, calibration) in calibrations() {
        export(&calibration, &at("exported.m"));
        let run = |file: &str| octave(directory.path(), &["main.m", file]);
        let printed = run("samples.txt");
        assert_loads(&printed, &calibration, &RECORDING, 1e-9, &name);
        assert_runs_live(&run("disturbed.txt"), &calibration, 1e-9, &name);
    }
}

/// A tare subtracts the mean gauges. The tare refuses gauges that are not numbers.
#[test]
fn a_tared_sensor_shows_no_load_in_octave() {
    if !octave_is_there() {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(every_block(), Regressor::Linear);
    export(&calibration, &directory.path().join("tared.m"));
    let script = "
state = tared();
mean = 1000 + (1:6);
state = tared(state, mean);
[load, conventional, status, state] = tared(state, 5, mean);
printf('%.17g ', conventional);
try
    tared(state, [mean(1:5), NaN]);
catch problem
    printf('%s', problem.message);
end
";
    fs::write(directory.path().join("main.m"), script).unwrap();
    let printed = octave(directory.path(), &["main.m"]);
    let (loads, message) = printed.split_at(printed.find("6 finite").unwrap());
    assert_eq!(message, "6 finite numbers are needed");
    for (load, full_scale) in loads.split_whitespace().zip(&calibration.full_scale) {
        let load: f64 = load.parse().unwrap();
        assert!(load.abs() < 1e-9 * full_scale, "{printed}");
    }
}

/// The name must be neither a keyword nor a function that the code calls. Texts of the user become ASCII comments.
#[test]
fn a_file_gets_a_name_that_matlab_takes() {
    let directory = tempfile::tempdir().unwrap();
    let mut calibration = calibration(every_block(), Regressor::Linear);
    calibration.trained_on = vec!["力 \n error('x') %{".to_owned()];
    for (file, function) in [
        ("2 left-arm.m", "cal_2_left_arm"),
        ("end.m", "cal_end"),
        ("zeros.m", "cal_zeros"),
        ("state.m", "cal_state"),
        ("sensor.m", "sensor"),
    ] {
        let code = export(&calibration, &directory.path().join(file));
        let head = format!("function [load, conventional, status, state] = {function}(");
        assert!(code.starts_with(&head), "{file}");
        assert!(code.contains(&format!("% This file must be called {function}.m.\n")));
        assert!(code.is_ascii() && !code.contains("\n error"));
        if octave_is_there() {
            let directory = tempfile::tempdir().unwrap();
            fs::write(directory.path().join(format!("{function}.m")), &code).unwrap();
            let call = format!(
                "state = {function}(); [load, ~, status] = {function}(state, 0, ones(6, 1)); disp(size(load))"
            );
            let printed = octave(directory.path(), &["--eval", &call]);
            assert_eq!(printed.split_whitespace().collect::<Vec<_>>(), ["6", "1"], "{file}");
        }
    }
}
