//! Which sensor it is, how far readings may be off, certificates, and batches of sensors.

use std::fs;

use crate::program::{run, stderr, succeed};
use crate::workshop::{ALL_FILES, Workshop, recording};

const SENSOR: &str = "serial = 4711\ncustomer = \"A & B <GmbH>\"\ndate = 2026-03-31\nmodel = \"RS\"\n\
    reference_uncertainty = \"Fz 0.02 N\"\n[rated_loads]\nFz = 10\n";

fn stdout(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn every_export_says_which_sensor_it_is_of() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", SENSOR);
    let exports = ["c.json", "c.h", "c.py", "c.rs", "c.yaml", "c.cal.txt"];
    let mut words = vec!["fit", "--sensor", "sensor.toml", "--look-back", "none"];
    words.extend(ALL_FILES);
    for export in &exports[..5] {
        words.extend(["--export", *export]);
    }
    succeed(workshop.path(), &words);
    for export in &exports[..5] {
        let text = workshop.read(export);
        assert!(
            text.contains("4711") && text.contains("2026-03-31"),
            "{export}"
        );
    }
    let own = json(&workshop.read("c.json"));
    assert_eq!(own["identity"]["customer"], "A & B <GmbH>");
    assert_eq!(own["full_scale"], serde_json::json!([10.0]));
    assert_eq!(own["rated"], serde_json::json!([true]));
    // One matrix row per axis, one number for each of two gauges and the offset.
    let standard = own["quality"]["coefficients"]["standard"]
        .as_array()
        .unwrap();
    assert_eq!(
        (standard.len(), standard[0].as_array().unwrap().len()),
        (1, 3)
    );
}

#[test]
fn a_description_that_is_wrong_is_refused_before_anything_is_read() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", "seriel = 1\n");
    let refused = run(
        workshop.path(),
        &["fit", "--train", "a.csv", "--sensor", "sensor.toml"],
    );
    let told = stderr(&refused);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        told.contains("sensor.toml") && told.contains("seriel is not one of manufacturer"),
        "{told}"
    );
    let printed = stdout(&succeed(workshop.path(), &["sensor"]));
    workshop.write("sensor.toml", &printed);
    succeed(
        workshop.path(),
        &["fit", "--train", "a.csv", "--sensor", "sensor.toml"],
    );
}

/// U² = (2 · 0.01)² + (2 · left-out RMSE)² where nothing else is added.
#[test]
fn the_uncertainty_is_that_of_what_was_left_out_and_of_the_reference() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", SENSOR);
    let words = [
        &["fit", "--uncertainty", "--json", "--sensor", "sensor.toml"][..],
        &ALL_FILES,
    ]
    .concat();
    let found = json(&stdout(&succeed(workshop.path(), &words)));
    let left_out = found["compensated"]["cv_rmse"][0].as_f64().unwrap();
    let own = &found["uncertainty"]["axes"][0];
    let parts = own["budget"].as_array().unwrap();
    let part =
        |id: &str| parts.iter().find(|part| part["source"] == id).unwrap()["standard"].clone();
    assert_eq!(part("reference"), 0.01);
    let residual = part("residual").as_f64().unwrap();
    assert!(residual > 0.0, "the parts are less than the whole: {own}");
    let expected = 2.0 * left_out.hypot(0.01);
    let expanded = own["expanded"].as_f64().unwrap();
    assert!(
        (expanded / expected - 1.0).abs() < 1e-9,
        "{expanded} {expected}"
    );
    assert!(part("zero")["reason"].is_string());
    let share = own["coverage"]["share"].as_f64().unwrap();
    assert!((0.0..=1.0).contains(&share));
}

/// An axis that no recording loads, and one that they load to half of what it is rated for.
#[test]
fn nothing_is_stated_of_loads_that_no_recording_has() {
    let workshop = Workshop::with_recordings();
    for name in ["a", "b", "c"] {
        let text = workshop.read(&format!("{name}.csv"));
        let still = text.lines().enumerate().map(|(at, line)| match at {
            0 => format!("{line},Mz [N·m]\n"),
            _ => format!("{line},0\n"),
        });
        workshop.write(&format!("{name}.csv"), still.collect::<String>());
    }
    workshop.write(
        "sensor.toml",
        "reference_uncertainty = \"1 %\"\n[rated_loads]\nFz = 16\nMz = 2\n",
    );
    workshop.write("limits.toml", "U = 90\n");
    let train = [
        "--train",
        "a.csv",
        "b.csv",
        "c.csv",
        "--sensor",
        "sensor.toml",
    ];
    let words = [&["fit", "--uncertainty", "--json"][..], &train].concat();
    let found = json(&stdout(&succeed(workshop.path(), &words)));
    let axes = found["uncertainty"]["axes"].as_array().unwrap();
    assert_eq!(axes.len(), 1);
    assert_eq!(axes[0]["axis"], "Fz");
    let range = axes[0]["range"].as_array().unwrap();
    assert!(range[1].as_f64().unwrap() <= 8.0, "{range:?}");
    let words = [
        &[
            "report",
            "--certificate",
            "--limits",
            "limits.toml",
            "--out",
            "c.html",
        ][..],
        &train,
    ]
    .concat();
    run(workshop.path(), &words);
    let page = workshop.read("c.html");
    assert!(page.contains("Mz hardly moves in the recordings"));
    assert!(page.contains("do not reach full scale (Fz from"));
    assert!(
        page.contains(": FAIL. "),
        "a U that is not known keeps no limit"
    );
}

#[test]
fn a_certificate_says_who_what_and_whether_it_passes() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", SENSOR);
    workshop.write("limits.toml", "U = 90\ncondition = 2\n");
    let words = [
        &[
            "report",
            "--certificate",
            "--sensor",
            "sensor.toml",
            "--limits",
            "limits.toml",
            "--look-back",
            "none",
            "--out",
            "c.html",
        ][..],
        &ALL_FILES,
    ]
    .concat();
    succeed(workshop.path(), &words);
    let page = workshop.read("c.html");
    assert!(page.contains("<h1>Calibration certificate</h1>"));
    assert!(page.contains("A &amp; B &lt;GmbH&gt;") && !page.contains("<GmbH>"));
    assert!(page.contains("FAIL. condition is"), "{}", &page[..4000]);
    assert!(
        page.contains("scope=\"col\"")
            && page.contains("<caption>")
            && page.contains("role=\"img\"")
    );
    // Whoever has no look-back is not told of its thresholds.
    assert!(!page.contains("id=\"thresholds\""));
    let with = [
        &["report", "--certificate", "--f-th", "2", "--out", "d.html"][..],
        &ALL_FILES,
    ]
    .concat();
    succeed(workshop.path(), &with);
    assert!(workshop.read("d.html").contains("id=\"thresholds\""));
    assert!(
        workshop
            .read("d.html")
            .contains("nothing is said of conformity")
    );
}

/// The certificate for machines has what the schema requires, in its order; where a schema is at hand, it is held to it.
#[test]
fn a_certificate_for_machines_needs_a_country_and_keeps_the_order_of_the_schema() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", SENSOR);
    let words = [
        &[
            "report",
            "--certificate",
            "--sensor",
            "sensor.toml",
            "--look-back",
            "none",
            "--out",
            "c.html",
            "--dcc",
            "c.xml",
        ][..],
        &ALL_FILES,
    ]
    .concat();
    let refused = run(workshop.path(), &words);
    assert!(
        stderr(&refused).contains("needs certificate, laboratory, country, operator"),
        "{}",
        stderr(&refused)
    );
    assert!(!workshop.file("c.html").exists());
    let more = "certificate = \"C-1\"\nlaboratory = \"L\"\ncountry = \"de\"\noperator = \"O\"\nreference = \"R <1>\"\ntemperature = 23\n";
    workshop.write("sensor.toml", format!("{more}{SENSOR}"));
    succeed(workshop.path(), &words);
    let xml = workshop.read("c.xml");
    let mut rest = &xml[..];
    for element in [
        "administrativeData",
        "dccSoftware",
        "coreData",
        "items",
        "calibrationLaboratory",
        "respPersons",
        "customer",
        "measurementResults",
        "usedMethods",
        "measuringEquipments",
        "influenceConditions",
        "results",
    ] {
        let at = rest.find(&format!("<dcc:{element}>"));
        rest = &rest[at.unwrap_or_else(|| panic!("{element}: {xml}"))..];
    }
    assert!(
        xml.contains("<dcc:countryCodeISO3166_1>DE<") && xml.contains("A &amp; B &lt;GmbH&gt;")
    );
    assert!(xml.contains("<si:unit>\\newton</si:unit>") && xml.contains("<si:coverageFactor>2<"));
    let Ok(schema) = std::env::var("DCC_SCHEMA") else {
        eprintln!("not validated: DCC_SCHEMA names no schema");
        return;
    };
    let found = std::process::Command::new("xmllint")
        .args(["--noout", "--schema", &schema])
        .arg(workshop.file("c.xml"))
        .output()
        .unwrap();
    assert!(found.status.success(), "{}", stderr(&found));
}

/// Three sensors: a good one, one whose second recording is no recording, and one out of tolerance.
fn factory() -> Workshop {
    let workshop = Workshop::new();
    for (at, name) in ["s1", "s2", "s3"].iter().enumerate() {
        fs::create_dir_all(workshop.file("in").join(name)).unwrap();
        for run in 0..3 {
            workshop.write(
                &format!("in/{name}/r{run}.csv"),
                recording((3 * at + run) as f64, 150),
            );
        }
    }
    workshop.write("in/s2/r1.csv", "nothing\n1;2\n");
    workshop.write("in/s3/sensor.toml", "serial = \"FT-3\"\n");
    workshop.write("limits.toml", "U = { Fz = 60 }\n");
    workshop
}

const BATCH: [&str; 10] = [
    "batch",
    "in",
    "--out",
    "out",
    "--limits",
    "limits.toml",
    "--export",
    "h",
    "--export",
    "json",
];

#[test]
fn a_batch_goes_on_after_a_bad_sensor_and_makes_only_what_is_missing() {
    let workshop = factory();
    let first = run(workshop.path(), &BATCH);
    assert_eq!(first.status.code(), Some(1), "{}", stderr(&first));
    assert!(
        stdout(&first).contains("3 sensors: 2 pass, 0 out of tolerance, 1 failed"),
        "{}",
        stdout(&first)
    );
    let summary = workshop.read("out/summary.csv");
    let rows: Vec<&str> = summary.lines().collect();
    assert!(
        rows[0].starts_with("sensor,serial,verdict,reasons,U_Fz [% FS],input_sha256,program"),
        "{summary}"
    );
    assert!(
        rows[1].starts_with("s1,s1,pass,,") && rows[3].starts_with("s3,FT-3,pass,,"),
        "{summary}"
    );
    assert!(
        rows[2].starts_with("s2,s2,error,") && rows[2].contains("r1.csv"),
        "{summary}"
    );
    assert_eq!(
        json(&workshop.read("out/s3/calibration.json"))["identity"]["serial"],
        "FT-3"
    );
    assert!(!workshop.file("out/s2/calibration.h").exists());
    // The bad one is mended: the others stay as they are.
    let before = fs::metadata(workshop.file("out/s1/calibration.h"))
        .unwrap()
        .modified()
        .unwrap();
    workshop.write("in/s2/r1.csv", recording(9.0, 150));
    succeed(workshop.path(), &BATCH);
    assert_eq!(
        fs::metadata(workshop.file("out/s1/calibration.h"))
            .unwrap()
            .modified()
            .unwrap(),
        before
    );
    assert!(
        workshop
            .read("out/batch.log")
            .contains("s1: pass (unchanged)")
    );
    assert!(workshop.file("out/s2/calibration.h").exists());
    // Stricter limits are something else.
    workshop.write("limits.toml", "U = { Fz = 0.001 }\n");
    let strict = run(workshop.path(), &BATCH);
    assert_eq!(strict.status.code(), Some(3), "{}", stderr(&strict));
    assert!(
        stdout(&strict).contains("s1: fail: U of Fz is"),
        "{}",
        stdout(&strict)
    );
    assert_eq!(
        json(&workshop.read("out/s1/verdict.json"))["verdict"],
        "fail"
    );
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let workshop = factory();
    let made = |out: &str, jobs: &str| {
        let mut words = BATCH.to_vec();
        words[3] = out;
        words.extend(["--certificate", "--jobs", jobs]);
        run(workshop.path(), &words);
    };
    made("one", "1");
    made("two", "3");
    for file in [
        "summary.csv",
        "s1/calibration.h",
        "s1/calibration.json",
        "s1/certificate.html",
        "s1/verdict.json",
        "s2/verdict.json",
    ] {
        assert_eq!(
            workshop.read(&format!("one/{file}")),
            workshop.read(&format!("two/{file}")),
            "{file}"
        );
    }
}

#[test]
fn a_batch_checks_what_it_is_asked_for_before_it_begins() {
    let workshop = factory();
    for (more, words) in [
        (&["--export", "docx"][..], "calibration.docx"),
        (&["--limits", "in/s3/sensor.toml"], "serial is not one of U"),
    ] {
        let mut asked = vec!["batch", "in", "--out", "out"];
        asked.extend(more);
        let refused = run(workshop.path(), &asked);
        assert!(
            !refused.status.success() && stderr(&refused).contains(words),
            "{}",
            stderr(&refused)
        );
        assert!(!workshop.file("out").exists());
    }
    fs::create_dir(workshop.file("empty")).unwrap();
    let empty = run(workshop.path(), &["batch", "empty", "--out", "out"]);
    assert_eq!(empty.status.code(), Some(2));
}

#[test]
fn each_file_can_be_a_sensor() {
    let workshop = Workshop::with_recordings();
    workshop.write("b.toml", "serial = \"B-2\"\n");
    succeed(
        workshop.path(),
        &["batch", ".", "--out", "out", "--sensor-from", "file"],
    );
    let summary = workshop.read("out/summary.csv");
    assert!(
        summary.contains("\na,a,no limits,,") && summary.contains("\nb,B-2,no limits,,"),
        "{summary}"
    );
}

#[test]
fn a_folder_stands_for_its_recordings_and_a_bad_file_is_left_out_where_that_is_asked() {
    let workshop = factory();
    let good = ["fit", "--train", "in/s1", "--export", "c.json"];
    succeed(workshop.path(), &good);
    let bad = ["fit", "--train", "in/s2", "--json"];
    let refused = run(workshop.path(), &bad);
    assert!(
        stderr(&refused).contains("--keep-going"),
        "{}",
        stderr(&refused)
    );
    assert_eq!(refused.status.code(), Some(2));
    let going = run(workshop.path(), &[&bad[..], &["--keep-going"]].concat());
    assert_eq!(going.status.code(), Some(1));
    assert_eq!(json(&stdout(&going))["recordings"], 2);
    assert!(
        stderr(&going).contains("left out: ") && stderr(&going).contains("r1.csv"),
        "{}",
        stderr(&going)
    );
    let applied = run(
        workshop.path(),
        &["apply", "c.json", "in/s2", "--out", "loads", "--keep-going"],
    );
    assert_eq!(applied.status.code(), Some(1));
    assert!(
        workshop.file("loads/r2_loads.csv").exists()
            && !workshop.file("loads/r1_loads.csv").exists()
    );
    fs::create_dir(workshop.file("none")).unwrap();
    let none = run(workshop.path(), &["fit", "--train", "none"]);
    assert!(
        stderr(&none).contains("the folder holds no recordings"),
        "{}",
        stderr(&none)
    );
}
