//! Runs the program as users do: with arguments, an exit code and printed text.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// Returns a command that runs the program with these arguments in `directory`, as on a machine without a display.
pub fn program(directory: &Path, arguments: &[&str]) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_loopscope"));
    program.args(arguments).current_dir(directory).stdin(Stdio::null());
    for display in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        program.env_remove(display);
    }
    program
}

/// Runs the program with these arguments, and checks that it does not panic.
#[track_caller]
pub fn run(directory: &Path, arguments: &[&str]) -> Output {
    let output = program(directory, arguments).output().unwrap();
    let message = stderr(&output);
    assert!(!message.contains("panicked"), "{arguments:?}: {message}");
    output
}

#[track_caller]
pub fn succeed(directory: &Path, arguments: &[&str]) -> Output {
    let output = run(directory, arguments);
    let message = stderr(&output);
    assert!(output.status.success(), "{arguments:?}: {message}");
    output
}

/// Runs `fit --json` with these arguments, and returns the printed JSON.
#[track_caller]
pub fn fit(directory: &Path, arguments: &[&str]) -> Value {
    let output = succeed(directory, &[&["fit", "--json"], arguments].concat());
    serde_json::from_slice(&output.stdout).unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[track_caller]
pub fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap_or_else(|| panic!("{value}"));
    values.iter().map(|value| value.as_f64().unwrap()).collect()
}
