//! `inspect`, which lists the detected columns, and reading by the column maps that `inspect` writes.

use std::fs;

use serde_json::Value;

use crate::program::{fit, numbers, run, stderr, succeed};
use crate::workshop::{HEADER, Workshop, recording, rows};

/// Writes a recording without a header, with semicolons and decimal commas.
fn headerless(workshop: &Workshop, name: &str, seed: f64) {
    let text = recording(seed, 150);
    let (_, rows) = text.split_once('\n').unwrap();
    workshop.write(name, rows.replace(',', ";").replace('.', ","));
}

fn inspected(workshop: &Workshop, arguments: &[&str]) -> Value {
    let output = run(workshop.path(), &[&["inspect", "--json"], arguments].concat());
    // The code 3 says that the file loads, and that a calibration needs an answer about the load.
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_corrected_map_reads_all_files_with_this_layout() {
    let workshop = Workshop::with_recordings();
    headerless(&workshop, "x.csv", 0.0);
    headerless(&workshop, "y.csv", 1.0);
    let refused = run(workshop.path(), &["fit", "--train", "x.csv"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("--columns \"2=Fz N\""), "{}", stderr(&refused));
    let shown = run(workshop.path(), &["inspect", "x.csv"]);
    assert_eq!(shown.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&shown.stdout).contains("--columns \"2=Fz N\""));
    // The answer with the right column gives the same fit as names do.
    let typed = fit(workshop.path(), &["--train", "x.csv", "y.csv", "--columns", "4=Fz N"]);
    let named = fit(workshop.path(), &["--train", "a.csv", "b.csv"]);
    assert_eq!(typed["conventional"], named["conventional"]);

    let found = inspected(&workshop, &["x.csv", "--write-map", "map.json"]);
    assert_eq!(found["table"]["text"]["delimiter"], "semicolon");
    assert_eq!(found["table"]["text"]["decimal"], "comma");
    assert_eq!(found["check"]["recordings"][0]["n_samples"], 150);
    let map = workshop.read("map.json");
    let reference = "\"column\": 4, \"is\": \"Fz\"";
    assert!(map.contains("\"column\": 4, \"is\": \"gauge\""), "{map}");
    let corrected = map.replace("\"column\": 4, \"is\": \"gauge\"", reference);
    workshop.write("map.json", corrected);

    let columns = ["--columns", "map.json"];
    let mapped = fit(workshop.path(), &[&["--train", "x.csv", "y.csv"], &columns[..]].concat());
    let named = fit(workshop.path(), &["--train", "a.csv", "b.csv"]);
    assert_eq!(mapped["conventional"], named["conventional"]);
    assert_eq!(numbers(&mapped["compensated"]["cv_rmse"]).len(), 1);
    let checked = inspected(&workshop, &[&["y.csv"], &columns[..]].concat());
    assert_eq!(checked["check"]["axes"][0], "Fz");
    assert_eq!(checked["map"]["format"], "loopscope column map");
}

#[test]
fn a_calibration_is_applied_to_files_read_by_a_map() {
    let workshop = Workshop::with_recordings();
    headerless(&workshop, "x.csv", 0.0);
    inspected(&workshop, &["x.csv", "--write-map", "map.json"]);
    let map = workshop
        .read("map.json")
        .replace("\"column\": 4, \"is\": \"gauge\"", "\"column\": 4, \"is\": \"Fz\"");
    workshop.write("map.json", map);
    succeed(workshop.path(), &["fit", "--train", "a.csv", "--export", "c.json"]);
    succeed(workshop.path(), &["apply", "c.json", "a.csv", "--out", "named"]);
    let by_map = ["apply", "c.json", "x.csv", "--columns", "map.json", "--out", "mapped"];
    succeed(workshop.path(), &by_map);
    assert_eq!(workshop.read("mapped/x_loads.csv"), workshop.read("named/a_loads.csv"));
}

#[test]
fn inspect_lists_the_role_of_each_column_and_the_recordings() {
    let workshop = Workshop::with_recordings();
    let output = succeed(workshop.path(), &["inspect", "a.csv"]);
    let text = String::from_utf8(output.stdout).unwrap();
    for part in [
        "a.csv: ",
        "about 150 rows",
        "delimiter comma, decimal point, header on line 1",
        "1 recording with 150 samples",
        "gauges: S1 S2",
        "reference: Fz",
    ] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    workshop.write("odd.csv", "a,b\np,x\nq,y\np,z\n");
    let output = run(workshop.path(), &["inspect", "odd.csv"]);
    assert_eq!(output.status.code(), Some(1));
    let written = ["inspect", "odd.csv", "--write-map", "odd.json"];
    succeed(workshop.path(), &written);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("would not be loaded: odd.csv, line 1: no table of numbers"), "{text}");
}

#[test]
fn an_offset_between_two_clocks_is_shown_and_not_applied() {
    let workshop = Workshop::new();
    let load = |t: f64| (0.7 * t).sin() + (0.31 * t).cos();
    let mut text = String::new();
    for k in 0..600 {
        let t = f64::from(k) * 0.1;
        text += &format!("{t},{},{},{}\n", 3.0 * load(t), t - 0.5, load(t));
    }
    workshop.write("run.csv", text);
    let map = r#"{ "format": "loopscope column map", "version": 1, "table": { "shape": { "columns": 4 }, "columns": [
        { "column": 1, "is": "time", "unit": "s" }, { "column": 2, "is": "gauge" },
        { "column": 3, "is": "time_reference", "unit": "s" }, { "column": 4, "is": "Fz" } ] } }"#;
    workshop.write("map.json", map);
    let columns = ["run.csv", "--columns", "map.json"];
    let found = inspected(&workshop, &columns);
    let offset = found["check"]["clock_offset"]["offset_secs"].as_f64().unwrap();
    assert!((offset - 0.5).abs() < 0.01, "{offset}");
    let rmse = || {
        let report = fit(workshop.path(), &[&["--train"], &columns[..]].concat());
        numbers(&report["conventional"]["train_rmse"])[0]
    };
    assert!(rmse() > 0.1, "the estimated offset is not applied");
    let join = "\"join\": { \"clock_offset_secs\": 0.5 }, \"table\"";
    workshop.write("map.json", map.replace("\"table\"", join));
    assert!(rmse() < 1e-6);
}

/// In 36 of 200 rows, a cell is missing, so that the layout of the text was probably not understood.
#[test]
fn inspect_and_fit_refuse_the_same_file() {
    let workshop = Workshop::with_recordings();
    let text = recording(1.0, 200);
    let cut = |(at, line): (usize, &str)| match line.rsplit_once(',') {
        Some((short, _)) if at % 5 == 4 && at < 180 => format!("{short}\n"),
        _ => format!("{line}\n"),
    };
    workshop.write("short.csv", text.lines().enumerate().map(cut).collect::<String>());
    let refused = run(workshop.path(), &["inspect", "--json", "short.csv"]);
    let found: Value = serde_json::from_slice(&refused.stdout).unwrap();
    assert!(found["check"]["error"].as_str().unwrap().contains("36 of 200 rows"));
    assert_eq!(found["check"]["recordings"].as_array().unwrap().len(), 0);
    let fitted = run(workshop.path(), &["fit", "--train", "short.csv"]);
    assert_eq!((refused.status.code(), fitted.status.code()), (Some(1), Some(1)));
    // With the written map, the user accepts the skipped rows.
    succeed(workshop.path(), &["inspect", "short.csv", "--write-map", "map.json"]);
    for job in [&["inspect"][..], &["fit", "--train"]] {
        succeed(workshop.path(), &[job, &["short.csv", "--columns", "map.json"]].concat());
    }
}

#[test]
fn unusable_maps_are_refused_with_their_names() {
    let workshop = Workshop::with_recordings();
    inspected(&workshop, &["a.csv", "--write-map", "map.json"]);
    workshop.write("broken.json", workshop.read("map.json").replace("\"time\"", "\"tide\""));
    let two_columns = "t,S1\n0,1\n0.1,2\n";
    workshop.write("other.csv", two_columns);
    fs::create_dir(workshop.file("folder")).unwrap();
    for (arguments, words) in [
        (
            &["fit", "--train", "a.csv", "--columns", "gone.json"][..],
            ["gone.json", "cannot be read"],
        ),
        (&["fit", "--train", "a.csv", "--columns", "a.csv"], ["a.csv", "not JSON"]),
        (&["fit", "--train", "a.csv", "--columns", "broken.json"], ["broken.json", "tide"]),
        (&["fit", "--train", "a.csv", "--columns", "folder"], ["folder", "not of a file"]),
        (&["fit", "--train", "other.csv", "--columns", "map.json"], ["other.csv, line 1", "t [s]"]),
        (&["inspect", "gone.csv"], ["gone.csv", "cannot be read"]),
        (&["inspect", "folder"], ["folder", "no recordings"]),
        (&["inspect", "a.csv", "--write-map", "a.csv"], ["a.csv", "replace the input"]),
        (&["inspect", "a.csv", "--write-map", "gone/map.json"], ["gone", "no folder"]),
    ] {
        let output = run(workshop.path(), arguments);
        let message = stderr(&output);
        assert!(!output.status.success(), "{arguments:?} succeeded");
        assert_eq!(message.lines().count(), 1, "{message}");
        for word in words {
            assert!(message.contains(word), "{arguments:?}: no {word} in {message}");
        }
    }
    assert_eq!(workshop.read("other.csv"), two_columns);
}

/// The sensor is upright, then rolled by 90°, then pitched by 90°. The weight of 2 kg pulls along −z, −y and x. Fx reads 1 N too
/// much.
#[test]
fn a_weight_is_found_in_a_recording_with_pose_and_reference() {
    let workshop = Workshop::with_recordings();
    let rows = "1,0,0,0,1,0,-19.6133\n1,1,0,0,1,-19.6133,0\n1,0,1,0,20.6133,0,0\n";
    let rows: String = (0..3).zip(rows.lines()).map(|(k, row)| format!("{k},{row}\n")).collect();
    workshop.write("run.csv", format!("t_s,qw,qx,qy,qz,Fx,Fy,Fz\n{rows}"));
    let roles = "time pose_qw pose_qx pose_qy pose_qz Fx Fy Fz".split(' ');
    let rules: Vec<String> = roles
        .enumerate()
        .map(|(at, role)| format!(r#"{{ "column": {}, "is": "{role}" }}"#, at + 1))
        .collect();
    let map = format!(
        r#"{{ "format": "loopscope column map", "version": 1, "table": {{ "shape": {{ "columns": 8 }},
            "text": {{ "header": true }}, "columns": [{}] }} }}"#,
        rules.join(", ")
    );
    workshop.write("map.json", map);
    let arguments = ["run.csv", "--columns", "map.json", "--estimate-weight"];
    let found = inspected(&workshop, &arguments);
    assert!((found["mass_kg"].as_f64().unwrap() - 2.0).abs() < 1e-9);
    assert!((numbers(&found["force_offset"])[0] - 1.0).abs() < 1e-9);
    let by_names = inspected(&workshop, &["run.csv", "--estimate-weight"]);
    assert!((by_names["mass_kg"].as_f64().unwrap() - 2.0).abs() < 1e-9, "the names give the roles");
    let text = succeed(workshop.path(), &[&["inspect"], &arguments[..]].concat());
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.starts_with("mass: 2.000000 kg, from 3 samples"), "{text}");
    assert!(text.contains("centre of mass: unknown"), "{text}");
}

/// Returns the text of a logger that writes ten rows at once, three times a second.
fn in_bursts() -> String {
    let time = |k: u32| f64::from(k / 10) / 3.0 + f64::from(k % 10) / 1000.0;
    let row = |k: u32| format!("{},{},{},{k}\n", time(k), k % 7, k % 5);
    format!("{HEADER}{}", (0..600).map(row).collect::<String>())
}

#[test]
fn an_assumed_pattern_of_bursts_is_reported_and_written_to_the_map() {
    let workshop = Workshop::new();
    workshop.write("bursts.csv", in_bursts());
    let arguments = ["bursts.csv", "--write-map", "map.json"];
    let found = inspected(&workshop, &arguments);
    assert_eq!(found["check"]["recordings"].as_array().unwrap().len(), 1);
    assert_eq!(found["check"]["assumed_gap_secs"], 2.0);
    let warning = &found["check"]["findings"][0];
    assert_eq!(warning["id"], "assumed");
    assert_eq!(warning["place"]["count"], 59);
    let message = warning["text"].as_str().unwrap();
    let expected = "bursts.csv, line 12: rows come in bursts, with pauses of about 0.32 s that end no recording";
    assert!(message.starts_with(expected), "{message}");
    assert!(message.contains("(59 times, last on line 592)"), "{message}");
    let fitted = succeed(workshop.path(), &["fit", "--train", "bursts.csv"]);
    assert!(stderr(&fitted).contains("rows come in bursts"));

    // The map has a shorter gap, so each pause starts a new recording.
    let map = workshop.read("map.json");
    assert!(map.contains("\"gap_secs\": 2.0"), "{map}");
    workshop.write("map.json", map.replace("\"gap_secs\": 2.0", "\"gap_secs\": 0.3"));
    let cut = inspected(&workshop, &["bursts.csv", "--columns", "map.json"]);
    assert_eq!(cut["check"]["recordings"].as_array().unwrap().len(), 60);
    assert_eq!(cut["map"]["gap_secs"], 0.3);
}

#[test]
fn presses_ten_seconds_apart_are_separate_recordings() {
    let workshop = Workshop::new();
    let presses = (0..40).map(|press| rows(f64::from(press), 50, 15.0 * f64::from(press)));
    let text = format!("{HEADER}{}", presses.collect::<String>());
    workshop.write("presses.csv", &text);
    let found = inspected(&workshop, &["presses.csv", "--write-map", "map.json"]);
    assert_eq!(found["check"]["recordings"].as_array().unwrap().len(), 40);
    assert!(!workshop.read("map.json").contains("gap_secs"));
}

#[test]
fn very_long_names_and_lists_of_columns_are_shortened() {
    let workshop = Workshop::new();
    let names = (0..300).map(|k| format!(",x{k}")).collect::<String>();
    let cells = ",5".repeat(301);
    let text = format!("t_s,S1,{}{names}\n0,1{cells}\n1,2{cells}\n", "n".repeat(70_000));
    workshop.write("wide.csv", text);
    let output = succeed(workshop.path(), &["inspect", "wide.csv"]);
    let message = String::from_utf8(output.stdout).unwrap();
    assert!(message.contains("  and 103 more columns; --json lists them all"), "{message}");
    assert!(message.lines().all(|line| line.chars().count() < 400));
}

#[test]
fn each_of_several_files_has_its_heading() {
    let workshop = Workshop::with_recordings();
    let output = succeed(workshop.path(), &["inspect", "a.csv", "b.csv"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let headings: Vec<&str> = text.lines().filter(|line| line.starts_with("==")).collect();
    assert_eq!(headings, ["== a.csv ==", "== b.csv =="]);
    assert_eq!(text.matches("would be loaded").count(), 2);
    let both = inspected(&workshop, &["a.csv", "b.csv"]);
    assert_eq!(both.as_array().unwrap().len(), 2);
    let refused = run(workshop.path(), &["inspect", "a.csv", "b.csv", "--write-map", "m.json"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("--write-map needs a single file"));
}

/// The second clock, which counts whole seconds, is proposed neither as the time nor as a gauge.
#[test]
fn a_column_that_is_named_as_a_time_is_never_proposed_as_a_gauge() {
    let workshop = Workshop::new();
    let row =
        |k: usize| format!("{},{},{},{}\n", k as f64 / 50.0, 1_550_000_000 + k / 50, k % 7, k % 11);
    let rows: String = (0..200).map(row).collect();
    workshop.write("bag.csv", format!("Time,header.stamp.secs,left,right\n{rows}"));
    let found = inspected(&workshop, &["bag.csv"]);
    let columns = found["map"]["table"]["columns"].as_array().unwrap();
    let gauges: Vec<&str> = columns
        .iter()
        .filter(|own| own["is"] == "gauge")
        .map(|own| own["column"].as_str().unwrap())
        .collect();
    assert_eq!(gauges, ["left", "right"], "{columns:?}");
}

#[test]
fn recordings_are_written_as_they_are_read() {
    let workshop = Workshop::new();
    let rows = rows(0.0, 60, 0.0) + &rows(1.0, 40, 900.0);
    let (milli, auxiliary) = ("t [ms],S1,S2,Fz [kN],T [°C],group\n", ",21.5,day1\n");
    let rows = rows.lines().map(|row| {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [t, s1, s2, force] = cells[..] else { panic!("{row}") };
        format!("{},{s1},{s2},{}{auxiliary}", 1000.0 * t, force / 1000.0)
    });
    workshop.write("log.csv", milli.to_owned() + &rows.collect::<String>());
    succeed(workshop.path(), &["inspect", "log.csv", "--out", "read"]);
    let first = workshop.read("read/log #1.csv");
    let mut lines = first.lines();
    assert_eq!(lines.next(), Some("t [s],S1,S2,Fz [N],T [°C],group"));
    assert_eq!(lines.clone().count(), 60);
    assert!(lines.next().unwrap().ends_with(",21.5,day1"));
    // The written files give the same fit.
    let [whole, parts] = [&["log.csv"][..], &["read/log #1.csv", "read/log #2.csv"]]
        .map(|files| fit(workshop.path(), &[&["--train"], files].concat()));
    for (whole, parts) in numbers(&whole["compensated"]["train_rmse"])
        .iter()
        .zip(numbers(&parts["compensated"]["train_rmse"]))
    {
        assert!((whole / parts - 1.0).abs() < 1e-9, "{whole} {parts}");
    }
    let again = run(workshop.path(), &["inspect", "log.csv", "--out", "read"]);
    assert_eq!(again.status.code(), Some(1));
}
