//! `report`, which writes one HTML page with all results.

use crate::program::{run, stderr, succeed};
use crate::workshop::{ALL_FILES, Workshop};

#[test]
fn a_report_names_its_files_and_is_written_over_only_by_force() {
    let workshop = Workshop::with_recordings();
    let arguments = [&["report", "--out", "r.html"], &ALL_FILES[..]].concat();
    succeed(workshop.path(), &arguments);
    let html = workshop.read("r.html");
    for word in ["test.csv", "SHA-256", "F_th 3 N, t_th 15 s", "S1_past", "10.00"] {
        assert!(html.contains(word), "{word}");
    }
    let again = run(workshop.path(), &arguments);
    assert!(!again.status.success() && stderr(&again).contains("--force"));
    succeed(workshop.path(), &[&arguments[..], &["--force"]].concat());
}

#[test]
fn a_report_contains_the_warnings_of_reading_and_never_replaces_a_recording() {
    let workshop = Workshop::with_recordings();
    let spoilt = workshop.read("a.csv").replacen("\n1,", "\nx,", 1);
    workshop.write("a.csv", spoilt);
    let arguments = [&["report", "--out", "r.html"], &ALL_FILES[..]].concat();
    succeed(workshop.path(), &arguments);
    assert!(workshop.read("r.html").contains("&quot;x&quot;"));
    // The ending of a recording does not matter.
    workshop.write("b.html", workshop.read("b.csv"));
    let over = ["report", "--force", "--out", "b.html", "--train", "a.csv", "b.html", "c.csv"];
    let message = stderr(&run(workshop.path(), &over));
    assert!(message.contains("replace the input"), "{message}");
    assert_eq!(workshop.read("b.html"), workshop.read("b.csv"));
}

/// A stored calibration and the recordings of its fit give the same page as the fit. Only the time of day may differ.
#[test]
fn a_report_on_a_stored_calibration_has_the_figures_of_its_fit() {
    let workshop = Workshop::with_recordings();
    succeed(workshop.path(), &[&["fit", "--export", "c.json"], &ALL_FILES[..]].concat());
    succeed(workshop.path(), &[&["report", "--out", "fit.html"], &ALL_FILES[..]].concat());
    let stored = [&["report", "c.json", "--out", "stored.html"], &ALL_FILES[..]].concat();
    succeed(workshop.path(), &stored);
    let lines = |name: &str| {
        let is_dated = |line: &&str| !line.contains(" UTC") && !line.contains("made");
        workshop.read(name).lines().filter(is_dated).map(str::to_owned).collect::<Vec<_>>()
    };
    let (fitted, stored) = (lines("fit.html"), lines("stored.html"));
    let other = fitted.iter().zip(&stored).find(|(fitted, stored)| fitted != stored);
    assert!(fitted.len() == stored.len() && other.is_none(), "{other:?}");
    let other = ["report", "c.json", "--train", "a.csv", "--out", "other.html"];
    succeed(workshop.path(), &other);
    assert!(workshop.read("other.html").contains("not fitted to these recordings"));
    let bare = run(workshop.path(), &["report", "c.json", "--out", "bare.html"]);
    assert_eq!(bare.status.code(), Some(2));
}

#[test]
fn a_report_under_another_ending_is_refused() {
    let workshop = Workshop::with_recordings();
    let arguments = [&["report", "--out", "r.pdf"], &ALL_FILES[..]].concat();
    let refused = run(workshop.path(), &arguments);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains(".html"), "{}", stderr(&refused));
    assert!(!workshop.file("r.pdf").exists());
}
