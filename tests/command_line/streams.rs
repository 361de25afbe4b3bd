//! Closed output streams, and machines without a display.

use std::process::Stdio;

use crate::program::{program, run, stderr};
use crate::workshop::{ALL_FILES, Workshop};

/// Returns an output stream whose reader has closed it.
fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

#[test]
fn a_closed_output_is_no_error() {
    let workshop = Workshop::with_recordings();
    let fit = [&["fit"], &ALL_FILES[..]].concat();
    let exported = [&fit[..], &["--json", "--export", "c.json"]].concat();
    for arguments in [
        &fit[..],
        &exported,
        &["apply", "c.json", "a.csv", "--out", "."],
        &["demo", "demo", "--pattern", "b"],
        &["--help"],
    ] {
        let mut job = program(workshop.path(), arguments);
        let output = job.stdout(closed()).stderr(Stdio::piped()).output().unwrap();
        assert_eq!(stderr(&output), "", "{arguments:?}");
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
    }
}

#[test]
fn a_closed_error_output_still_gives_the_exit_code() {
    let workshop = Workshop::new();
    let mut job = program(workshop.path(), &["fit", "--train", "gone.csv"]);
    let status = job.stderr(closed()).status().unwrap();
    assert_eq!(status.code(), Some(1));
}

#[test]
fn without_a_display_the_window_is_refused_in_one_line() {
    let workshop = Workshop::with_recordings();
    for files in [&[][..], &["a.csv"]] {
        let output = run(workshop.path(), files);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.starts_with("loopscope: "), "{message}");
    }
}
