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
    let over = [&["report", "--force", "--out", "b.csv"], &ALL_FILES[..]].concat();
    let message = stderr(&run(workshop.path(), &over));
    assert!(message.contains("replace the input"), "{message}");
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
