//! Refused arguments and files give one line on standard error with the cause, an exit code, and no output.

use std::fs;

use crate::program::{run, stderr, succeed};
use crate::workshop::{ALL_FILES, Workshop, recording};

/// Runs a job that must be refused, and returns the error line.
#[track_caller]
fn refused(workshop: &Workshop, arguments: &[&str]) -> String {
    let output = run(workshop.path(), arguments);
    let message = stderr(&output);
    // Notes and warnings are on separate lines.
    let is_note = |line: &&str| line.starts_with("loopscope: note: ");
    let message: Vec<&str> = message.lines().filter(|line| !is_note(line)).collect();
    let message = message.join("\n");
    assert!(!output.status.success(), "{arguments:?} succeeded");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    assert!(message.starts_with("loopscope: "), "{arguments:?}: {message}");
    message
}

/// Checks that `job` with each of the arguments is refused, with a line that contains each of the words.
#[track_caller]
fn all_refused(workshop: &Workshop, job: &str, refusals: &[(&str, &[&str])]) {
    for (arguments, words) in refusals {
        let arguments: Vec<&str> = [job].into_iter().chain(arguments.split(' ')).collect();
        let message = refused(workshop, &arguments);
        for word in *words {
            assert!(message.contains(word), "{arguments:?}: no {word} in {message}");
        }
    }
}

#[test]
fn files_that_are_no_recordings_are_named() {
    let workshop = Workshop::with_recordings();
    workshop.write("empty.csv", "");
    workshop.write("text.csv", "Dear diary,\ntoday I measured.\n");
    workshop.write("binary.csv", b"\x7fELF\0\0\xff");
    workshop.write("no_gauge.csv", "t,Fz\n0,1\n0.1,2\n");
    workshop.write("no_reference.csv", "t,S1,S2\n0,1,3\n0.1,2,4\n");
    workshop.write("other.csv", "t,S1,S2,S3,Fz\n0,1,2,3,4\n0.1,2,3,4,5\n");
    workshop.write("axes.csv", "t,S1,S2,Fx\n0,1,2,3\n0.1,2,3,4\n");
    all_refused(
        &workshop,
        "fit",
        &[
            ("--train gone.csv", &["gone.csv"]),
            ("--train .", &["this is a folder"]),
            ("--train empty.csv", &["empty.csv", "empty"]),
            ("--train text.csv", &["text.csv, line 1", "no table of numbers"]),
            ("--train binary.csv", &["binary.csv", "not text but binary data"]),
            ("--train no_gauge.csv", &["no_gauge.csv", "no gauge", "no other column"]),
            ("--train no_reference.csv", &["no_reference.csv", "no reference"]),
            ("--train a.csv no_reference.csv", &["no_reference.csv"]),
            ("--train a.csv --test no_reference.csv", &["no_reference.csv"]),
            ("--train a.csv other.csv", &["other", "S1, S2, S3"]),
            ("--train a.csv --test other.csv", &["other", "S1, S2, S3"]),
            ("--train a.csv --test axes.csv", &["axes", "Fx"]),
        ],
    );
}

#[test]
fn numbers_out_of_range_are_refused() {
    let workshop = Workshop::with_recordings();
    all_refused(
        &workshop,
        "fit",
        &[
            ("--train a.csv --f-th NaN", &["F_th", "NaN"]),
            ("--train a.csv --f-th -1", &["F_th", "-1"]),
            ("--train a.csv --f-th inf", &["F_th", "inf"]),
            ("--train a.csv --t-th NaN", &["t_th", "NaN"]),
            ("--train a.csv --t-th -0.5", &["t_th", "-0.5"]),
            ("--train a.csv --split 0", &["split", "0"]),
            ("--train a.csv --split 1", &["split", "1"]),
            ("--train a.csv --split NaN", &["split", "NaN"]),
            ("--train a.csv --split -0.5", &["split", "-0.5"]),
            ("--train a.csv --split 1e-9", &["split"]),
            ("--train a.csv --decimate 0", &["decimation"]),
            ("--train a.csv --full-scale 0", &["full scale", "axis 1"]),
            ("--train a.csv --full-scale -5", &["full scale", "-5"]),
            ("--train a.csv --full-scale 5,6", &["2 full scales"]),
        ],
    );
}

#[test]
fn arguments_that_are_no_numbers_are_explained() {
    let workshop = Workshop::with_recordings();
    for (option, value, words) in [
        ("--t-th", "15s", "not a number"),
        ("--history-rate", "fast", "not a number"),
        ("--decimate", "0.5", "not a whole number"),
        ("--seed", "one", "not a whole number"),
    ] {
        let output = run(workshop.path(), &["fit", option, value]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        for word in [option, value, words] {
            assert!(message.contains(word), "no {word} in {message}");
        }
    }
}

#[test]
fn full_scales_are_one_for_each_axis_and_calibrations_are_no_recordings() {
    let workshop = calibrated();
    let six_axes = "Fx Fy Fz Mx My Mz";
    all_refused(
        &workshop,
        "fit",
        &[
            ("--full-scale 100", &["--full-scale has 1", six_axes]),
            ("--full-scale 100,100", &["--full-scale has 2", six_axes]),
            ("--train c.json", &["c.json is a calibration"]),
        ],
    );
    all_refused(&workshop, "inspect", &[("c.json", &["c.json is a calibration"])]);
}

#[test]
fn options_of_another_regressor_give_a_note() {
    let workshop = Workshop::with_recordings();
    let message = |regressor| {
        let options = ["--epochs", "2", "--landmarks", "10", "--regressor", regressor];
        let arguments = [&["fit"], &ALL_FILES[..], &options].concat();
        stderr(&succeed(workshop.path(), &arguments))
    };
    let of_network = "--epochs has no effect with --regressor";
    let of_kernel = "--landmarks has no effect with --regressor";
    let linear = message("linear");
    assert!(linear.contains(of_network) && linear.contains(of_kernel), "{linear}");
    let kernel = message("kernel");
    assert!(kernel.contains(of_network) && !kernel.contains(of_kernel), "{kernel}");
}

#[test]
fn impossible_sweeps_are_refused_with_a_correction() {
    let workshop = Workshop::with_recordings();
    workshop.write("short.csv", recording(0.0, 6));
    all_refused(
        &workshop,
        "sweep",
        &[
            ("--train a.csv --f-th 0:5:0", &["step of F_th", "above zero"]),
            ("--train a.csv --f-th 0:5:-1", &["step of F_th", "-1"]),
            ("--train a.csv --f-th 5:0:1", &["F_th", "smaller value first"]),
            ("--train a.csv --t-th 5,3", &["t_th", "ascending"]),
            ("--train a.csv --t-th 5,5", &["t_th", "ascending"]),
            ("--train a.csv --t-th -1", &["t_th", "-1"]),
            ("--train a.csv --t-th inf", &["t_th", "inf"]),
            ("--train a.csv --f-th 0:1:1e-9", &["F_th", "larger step"]),
            ("--train a.csv --measure mx", &["no Mx", "Fz"]),
            ("--train a.csv --measure moments", &["none of the axes", "choose"]),
            ("--train short.csv", &["4 training samples", "record longer"]),
            ("--train a.csv --svg gone/map.svg", &["no folder gone"]),
            ("--train a.csv --csv ./a.csv", &["./a.csv", "replace the input"]),
        ],
    );
    let message = refused(&workshop, &["sweep", "--train", "a.csv", "--t-th", ""]);
    assert!(message.contains("t_th has no values; enter"), "{message}");
}

#[test]
fn exports_that_cannot_be_written_are_refused_and_leave_old_files_whole() {
    let workshop = Workshop::with_recordings();
    workshop.write("kept.json", "old");
    workshop.write("old.json", "old");
    let read_only = workshop.file("kept.json");
    let mut permissions = fs::metadata(&read_only).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&read_only, permissions).unwrap();
    fs::create_dir(workshop.file("folder.json")).unwrap();
    let before = workshop.read("a.csv");
    all_refused(
        &workshop,
        "fit",
        &[
            ("--train a.csv --export c.xml", &["c.xml", ".json"]),
            ("--train a.csv --export c", &["ending"]),
            ("--train a.csv --export gone/c.json", &["gone/c.json", "no folder gone"]),
            ("--train a.csv --export folder.json --force", &["folder.json", "this is a folder"]),
            ("--train a.csv --export kept.json --force", &["kept.json", "read-only"]),
            ("--train a.csv --export kept.json", &["kept.json", "already", "--force"]),
            ("--train gone.csv --export old.json --force", &["gone.csv"]),
            ("--train a.csv --export ./a.csv", &["./a.csv", "replace the input"]),
        ],
    );
    assert_eq!(workshop.read("kept.json"), "old");
    assert_eq!(workshop.read("old.json"), "old");
    assert_eq!(workshop.read("a.csv"), before);
    assert!(!workshop.file("gone").exists());
}

#[test]
fn demo_does_not_overwrite_files() {
    let workshop = Workshop::with_recordings();
    let message = refused(&workshop, &["demo", "a.csv", "--pattern", "b"]);
    assert!(message.contains("a.csv"), "{message}");
}

/// Returns a folder with recordings, and with the calibration `c.json` that was fitted to them.
fn calibrated() -> Workshop {
    let workshop = Workshop::with_recordings();
    let arguments = [&["fit"], &ALL_FILES[..], &["--export", "c.json"]].concat();
    succeed(workshop.path(), &arguments);
    workshop
}

#[test]
fn apply_refuses_a_recording_that_does_not_fit_the_calibration() {
    let workshop = calibrated();
    fs::create_dir(workshop.file("sub")).unwrap();
    workshop.write("sub/a.csv", recording(5.0, 20));
    workshop.write("other.csv", "t,S1,S3,Fz\n0,1,2,3\n0.1,2,3,4\n");
    workshop.write("swapped.csv", "t,S2,S1,Fz\n0,1,2,3\n0.1,2,3,4\n");
    workshop.write("a_loads.csv", recording(5.0, 20));
    let before = workshop.read("a_loads.csv");
    all_refused(
        &workshop,
        "apply",
        &[
            ("c.json a.csv sub/a.csv --out new", &["a.csv", "sub/a.csv"]),
            ("c.json other.csv --out new", &["other.csv", "S1 S3"]),
            ("c.json swapped.csv --out new", &["swapped.csv", "S2 S1"]),
            ("c.json gone.csv --out new", &["gone.csv"]),
            ("gone.json a.csv --out new", &["gone.json"]),
            ("a.csv b.csv --out new", &["a.csv", "use a calibration"]),
            (". a.csv --out new", &["cannot read"]),
            ("c.json b.csv a.csv --out .", &["a_loads.csv", "--force"]),
            ("c.json a.csv --out b.csv", &["directory", "b.csv"]),
            ("c.json a.csv a_loads.csv --out .", &["./a_loads.csv", "replace the input"]),
        ],
    );
    assert_eq!(workshop.read("a_loads.csv"), before);
}

#[test]
fn a_calibration_edited_by_hand_is_refused_with_the_reason() {
    let workshop = calibrated();
    let whole = workshop.read("c.json");
    for (from, to, word) in [
        ("loopscope calibration", "another thing", "format"),
        ("\"version\": 2", "\"version\": 3", "version 3"),
        ("\"f_th\": 3.0", "\"f_th\": -3.0", "F_th is -3"),
        ("\"f_th\": 3.0", "\"f_th\": NaN", "not a calibration file"),
        ("\"f_th\": 3.0", "\"f_th\": 1e999", "not a calibration file"),
        ("\"t_th_secs\"", "\"t_th\"", "t_th"),
        ("\"offset\": true", "\"offset\": false", "features"),
        ("\"Fz\"", "\"Fq\"", "Fq"),
        ("\"N\"", "\"kN\"", "unit of Fz"),
        ("\"S2\"", "\"S9\"", "S9"),
        ("\"S2_past\"", "\"S2_passed\"", "S2_passed"),
        ("\"matrix\": [", "\"matrix\": [[1.0],", "matrix"),
        ("\"full_scale\": [", "\"full_scale\": [null,", "not a calibration file"),
        ("}", "", "not a calibration file"),
    ] {
        assert!(whole.contains(from), "{from}");
        workshop.write("edited.json", whole.replacen(from, to, 1));
        let arguments = ["apply", "edited.json", "a.csv", "--out", "new"];
        let message = refused(&workshop, &arguments);
        assert!(message.contains("edited.json") && message.contains(word), "{to}: {message}");
    }
    assert!(!workshop.file("new").exists());
}

/// A table that exists is refused before any computation, so nothing is printed. `--json` alone writes no file.
#[test]
fn tables_and_figures_are_overwritten_only_by_force() {
    let workshop = Workshop::with_recordings();
    let sweep = "sweep --train a.csv b.csv c.csv --f-th 0,2 --t-th 5";
    for (job, option, name) in [
        ("metrology a.csv", "--csv", "m.csv"),
        (sweep, "--csv", "m.csv"),
        (sweep, "--svg", "m.svg"),
    ] {
        workshop.write(name, "mine");
        let arguments: Vec<&str> = job.split(' ').chain([option, name]).collect();
        let refused = run(workshop.path(), &arguments);
        assert!(!refused.status.success() && refused.stdout.is_empty(), "{job}");
        assert!(stderr(&refused).contains("--force"), "{}", stderr(&refused));
        assert_eq!(workshop.read(name), "mine");
        succeed(workshop.path(), &[&arguments[..], &["--force"]].concat());
        assert_ne!(workshop.read(name), "mine");
        let json: Vec<&str> = job.split(' ').chain(["--json"]).collect();
        succeed(workshop.path(), &json);
    }
}
