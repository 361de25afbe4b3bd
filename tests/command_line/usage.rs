//! Typing errors in commands. Each error message suggests the correct form.

use crate::program::{run, stderr, succeed};
use crate::workshop::{ALL_FILES, Workshop};

/// Exit code for wrong arguments.
const USAGE: i32 = 2;

#[test]
fn each_wrong_argument_is_answered_with_a_correction() {
    let workshop = Workshop::with_recordings();
    std::fs::create_dir(workshop.file("runs")).unwrap();
    workshop.write("runs/one.csv", "");
    workshop.write("runs/two.csv", "");
    succeed(workshop.path(), &[&["fit"], &ALL_FILES[..], &["--export", "c.json"]].concat());
    for (arguments, words) in [
        ("fitt", &["'fitt'", "'fit'"][..]),
        ("fitt --train a.csv", &["'fitt'", "'fit'"]),
        ("swep", &["'sweep'"]),
        ("gone.csv", &["gone.csv", "no such file"]),
        ("fit a.csv", &["a.csv", "fit --train a.csv"]),
        ("sweep a.csv", &["sweep --train a.csv"]),
        ("fit --train runs", &["runs", "one.csv, two.csv", "*.csv"]),
        ("fit --train -", &["standard input", "name a file"]),
        ("apply c.json - --out .", &["live rows (- or --follow)"]),
        ("fit --train a.csv --f-th 3,5", &["--look-back 3,5"]),
        ("fit --train a.csv b.csv ./a.csv", &["a.csv and ./a.csv"]),
        ("fit --train a.csv --test a.csv", &["same recording", "--test"]),
        ("metrology a.csv a.csv", &["same recording"]),
        ("fit --test test.csv", &["--train <FILE>"]),
        ("fit --train a.csv --export c.xyz", &["is no export format"]),
        ("fit --train a.csv --traces t.xyz", &["traces cannot be written"]),
        ("fit --train a.csv --split 1", &["--split is 1"]),
        ("best --train a.csv --minutes=-1", &["--minutes", "zero or a number above zero"]),
        ("sweep --train a.csv --measure mx", &["no Mx"]),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let output = run(workshop.path(), &arguments);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(USAGE), "{arguments:?}: {error}");
        for word in words {
            assert!(error.contains(word), "{arguments:?}: no {word} in {error}");
        }
    }
}

#[test]
fn a_recording_given_as_column_map_is_recognised() {
    let workshop = Workshop::with_recordings();
    let output = run(workshop.path(), &["fit", "--train", "a.csv", "--columns", "b.csv"]);
    let error = stderr(&output);
    assert!(error.contains("b.csv") && error.contains("--write-map"), "{error}");
    assert!(!error.contains("expected"), "{error}");
}

/// Terminals would execute escape sequences, and marks that change the writing direction would mislead readers.
#[test]
fn control_characters_in_file_names_are_escaped() {
    let workshop = Workshop::new();
    workshop.write("a.csv", "t,S1,\"\u{1b}[2J\u{202e}\",Fz [x\u{7}]\n0,1,2,3\n0.1,2,3,4\n");
    workshop.write("c.json", "{\"format\": \"loopscope calibration\", \"\u{9b}2J\u{202e}\": 1}");
    let sensor = "<?xml version=\"1.0\"?><FTSensor NumGages=\"\u{202e}&#27;]0;\"/><Calibration/>";
    workshop.write("c.cal", sensor);
    for arguments in [
        &["inspect", "a.csv"][..],
        &["fit", "--train", "a.csv"],
        &["apply", "c.json", "a.csv", "--out", "."],
        &["apply", "c.cal", "a.csv", "--out", "."],
        &["apply", "\u{1b}[2J.json", "a.csv", "--out", "."],
    ] {
        let output = run(workshop.path(), arguments);
        let error = stderr(&output) + &String::from_utf8(output.stdout).unwrap();
        let is_hidden = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!error.contains(is_hidden), "{arguments:?}: {error:?}");
    }
}

#[test]
fn the_long_version_names_the_build_and_the_short_one_does_not() {
    let workshop = Workshop::new();
    let printed = |argument| {
        let output = succeed(workshop.path(), &[argument]);
        String::from_utf8(output.stdout).unwrap()
    };
    let short = format!("loopscope {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(printed("-V"), short);
    let long = printed("--version");
    assert!(long.starts_with(&short), "{long}");
    for name in ["\ncommit: ", "\nfeatures: ", "\ntarget: "] {
        assert!(long.contains(name), "{long}");
    }
}

#[test]
fn shells_and_manuals_know_every_job() {
    let workshop = Workshop::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = succeed(workshop.path(), &["completions", shell]);
        let text = String::from_utf8(output.stdout).unwrap();
        for word in ["metrology", "leave-out-faulty"] {
            assert!(text.contains(word), "{shell}: no {word}");
        }
    }
    succeed(workshop.path(), &["man", "pages/man1"]);
    let page = |name: &str| std::fs::read_to_string(workshop.file(&format!("pages/man1/{name}.1")));
    let of_program = page("loopscope").unwrap();
    assert!(of_program.contains("loopscope\\-fit(1)"), "{of_program}");
    assert!(page("loopscope-fit").unwrap().contains("Examples:"));
    assert!(page("loopscope-man").is_err());
    workshop.write("file", "");
    let refused = run(workshop.path(), &["man", "file"]);
    assert!(!refused.status.success() && stderr(&refused).contains("file"));
}
