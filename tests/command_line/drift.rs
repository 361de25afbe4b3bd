//! `drift`: what moved, what to fit again, and the calibration that comes of it.

use serde_json::Value;

use crate::program::{run, stderr, succeed};
use crate::workshop::{ALL_FILES, Workshop};

fn json(workshop: &Workshop, arguments: &[&str]) -> Value {
    let output = succeed(workshop.path(), &[arguments, &["--json"]].concat());
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The recordings again, with 3 more on the first gauge.
fn moved(workshop: &Workshop) {
    for name in ["a", "b", "c"] {
        let text = workshop.read(&format!("{name}.csv"));
        let (header, rows) = text.split_once('\n').unwrap();
        let rows = rows.lines().map(|row| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            cells[1] = (cells[1].parse::<f64>().unwrap() + 3.0).to_string();
            cells.join(",") + "\n"
        });
        workshop.write(
            &format!("later_{name}.csv"),
            format!("{header}\n{}", rows.collect::<String>()),
        );
    }
}

#[test]
fn an_offset_that_moved_is_fitted_again_and_applied() {
    let workshop = Workshop::with_recordings();
    moved(&workshop);
    let fit = [
        &["fit", "--look-back", "none", "--export", "old.json"],
        &ALL_FILES[..],
    ]
    .concat();
    succeed(workshop.path(), &fit);
    let files = [
        "drift",
        "--calibration",
        "old.json",
        "later_a.csv",
        "later_b.csv",
        "later_c.csv",
    ];
    let found = json(
        &workshop,
        &[&files[..], &["--refit", "offset", "--out", "new.json"]].concat(),
    );
    let of = |refit: &str| {
        let all = found["refits"].as_array().unwrap();
        let own = all.iter().find(|own| own["refit"] == refit).unwrap();
        own["left_out_rmse"][0].as_f64().unwrap()
    };
    assert!(of("old") > 2.0 * of("offset"), "{found}");
    assert_eq!(found["sessions"].as_array().unwrap().len(), 3);
    let again = [
        "drift",
        "--calibration",
        "new.json",
        "later_a.csv",
        "later_b.csv",
        "later_c.csv",
    ];
    let again = json(&workshop, &again);
    assert!(
        again["sentences"].to_string().contains("keep it as it is"),
        "{again}"
    );
    let output = run(
        workshop.path(),
        &[&files[..], &["--refit", "offset", "--out", "new.json"]].concat(),
    );
    assert!(
        stderr(&output).contains("new.json"),
        "there already: {}",
        stderr(&output)
    );
    assert!(!output.status.success());
}

#[test]
fn the_first_session_gives_the_calibration_where_there_is_none() {
    let workshop = Workshop::with_recordings();
    moved(&workshop);
    let all = [
        "drift",
        "--look-back",
        "none",
        "a.csv",
        "b.csv",
        "c.csv",
        "later_a.csv",
        "later_b.csv",
        "later_c.csv",
    ];
    let found = json(&workshop, &all);
    assert_eq!(
        (&found["by"], found["refits"].as_array().unwrap().len()),
        (&"recording".into(), 4)
    );
    let change = &found["changes"][0];
    let moved = change["zero"][1].as_f64().unwrap() - change["zero"][0].as_f64().unwrap();
    assert!((moved - 3.0).abs() < 0.5, "{change}");
    let alone = run(
        workshop.path(),
        &["drift", "a.csv", "--refit", "all", "--out", "x.json"],
    );
    assert!(
        stderr(&alone).contains("one session only"),
        "{}",
        stderr(&alone)
    );
}

#[test]
fn dates_of_headers_and_of_arguments_tell_the_sessions() {
    let workshop = Workshop::with_recordings();
    moved(&workshop);
    for (name, header) in [
        ("a", "# date: 2024-05-03\n"),
        ("b", "Date,2024/05/03\n\n"),
        ("later_a", "# Recorded on 20 April 2024\n"),
        ("later_b", "# date: 04/05/2024\n"),
    ] {
        let file = format!("{name}.csv");
        workshop.write(&file, format!("{header}{}", workshop.read(&file)));
    }
    let files = ["drift", "a.csv", "b.csv", "later_a.csv", "later_b.csv"];
    let ambiguous = json(&workshop, &files);
    assert_eq!(ambiguous["by"], "recording", "two days are no day");
    let given = ["--date", "later_b.csv=2024-04-20", "--look-back", "none"];
    let found = json(&workshop, &[&files[..], &given].concat());
    assert_eq!(found["by"], "day");
    let sessions = found["sessions"].as_array().unwrap();
    let told = sessions.iter().map(|own| (&own["name"], &own["dated_by"]));
    let told: Vec<_> = told.collect();
    let expected = [
        (
            &"2024-04-20".into(),
            &serde_json::json!(["entered", "header"]),
        ),
        (&"2024-05-03".into(), &serde_json::json!(["header"])),
    ];
    assert_eq!(told, expected, "in order of time");
    for (date, what) in [
        ("later_b.csv=04/05/2024", "2024-05-03"),
        ("x.csv=2024-04-20", "x.csv"),
    ] {
        let refused = run(workshop.path(), &[&files[..], &["--date", date]].concat());
        assert_eq!(refused.status.code(), Some(2));
        assert!(stderr(&refused).contains(what), "{}", stderr(&refused));
    }
}
