//! The Python package: its tests, and the guide's lines, run from a wheel in a new environment.

use std::path::Path;
use std::process::Command;

use crate::program::stderr;
use crate::tools::is_there;
use crate::workshop::Workshop;

const PROGRAM: &str = env!("CARGO_BIN_EXE_loopscope");

fn in_repository(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

#[track_caller]
fn succeed(command: &mut Command) -> String {
    let output = command.env("PYTHONDONTWRITEBYTECODE", "1").output().unwrap();
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{command:?}: {printed}{}", stderr(&output));
    printed
}

#[test]
fn the_package_passes_its_tests() {
    if !is_there("python3", &["-c", "import numpy, pytest"]) {
        return;
    }
    let arguments = ["-m", "pytest", "-q", "-p", "no:cacheprovider"];
    let mut python = Command::new("python3");
    let python = python.args(arguments).arg(in_repository("tests/python"));
    succeed(python.env("LOOPSCOPE", PROGRAM).env("PYTHONPATH", in_repository("src/python")));
}

#[test]
#[cfg(unix)]
fn the_lines_of_the_guide_run_from_the_wheel() {
    if !is_there("python3", &["-c", "import ensurepip, numpy, venv"]) {
        return;
    }
    let workshop = Workshop::new();
    let mut wheel = Command::new("bash");
    let wheel = wheel.arg(in_repository(".ci/wheel.sh")).arg(PROGRAM).arg(workshop.path());
    let wheel = succeed(wheel);
    let environment = workshop.file("environment");
    succeed(
        Command::new("python3").args(["-m", "venv", "--system-site-packages"]).arg(&environment),
    );
    let python = || {
        let mut python = Command::new(environment.join("bin/python"));
        for variable in ["LOOPSCOPE", "PYTHONPATH"] {
            python.env_remove(variable);
        }
        python.current_dir(workshop.path());
        python
    };
    let install = ["-m", "pip", "install", "--no-index", "--quiet"];
    succeed(python().args(install).arg(wheel.trim()));
    let page = in_repository("assets/guide/python.md");
    succeed(python().arg(in_repository("tests/python/notebook.py")).arg(page));
}
