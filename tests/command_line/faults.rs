//! Faulty samples are reported and excluded, and the calibration stores the limits of the gauges.

use std::fmt::Write as _;

use crate::program::{run, stderr, succeed};
use crate::workshop::{ALL_FILES, HEADER, Workshop};

/// Returns a recording of 100 s at 20 Hz. The first gauge is clipped at 30 counts for two long intervals. The second gauge misses one
/// sample.
fn clipped() -> String {
    let mut text = HEADER.to_owned();
    for k in 0..2000 {
        let t = f64::from(k) / 20.0;
        let force = 20.0 * (0.13 * t).sin() + 3.0 * (1.1 * t).cos();
        let wiggle = f64::from(k * 7919 % 13) / 13.0;
        let s1 = (2.0 * force + wiggle).round().min(30.0);
        let s2 = if k == 700 { 0.0 } else { (10.0 - 1.1 * force + wiggle).round() };
        writeln!(text, "{t},{s1},{s2},{force}").unwrap();
    }
    text
}

#[test]
fn faulty_samples_are_reported_and_left_out_on_request() {
    let workshop = Workshop::new();
    workshop.write("press.csv", clipped());
    let noted = run(workshop.path(), &["fit", "--train", "press.csv"]);
    let noted = stderr(&noted);
    for words in
        ["press: looks faulty", "saturated (S1)", "1 dropped out (S2)", "--leave-out-faulty"]
    {
        assert!(noted.contains(words), "{words}: {noted}");
    }
    let fit = ["fit", "--train", "press.csv", "--leave-out-faulty", "--export", "c.json"];
    let message = stderr(&run(workshop.path(), &fit));
    assert!(message.contains("samples left out"), "{message}");
    assert!(message.contains("segments remain"), "{message}");
    let calibration: serde_json::Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
    let limits = serde_json::json!([[null, 30.0], [null, null]]);
    assert_eq!(calibration["gauge_limits"], limits);

    // `--gauge-range` gives the maximum value of the logger.
    let fit = [&fit[..4], &["--gauge-range=-40:25", "--export", "c.json", "--force"]].concat();
    succeed(workshop.path(), &fit);
    let calibration: serde_json::Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
    assert_eq!(calibration["gauge_limits"][0], serde_json::json!([-40.0, 25.0]));
}

#[test]
fn sound_samples_give_no_note_and_a_wrong_range_is_refused() {
    let workshop = Workshop::with_recordings();
    let fit = [&["fit"], &ALL_FILES[..]].concat();
    let message = stderr(&run(workshop.path(), &fit));
    assert!(!message.contains("faulty"), "{message}");
    for (range, word) in
        [("5:1", "smaller number"), ("x", "smaller number"), ("0:0", "smaller number")]
    {
        let arguments = [&fit[..], &["--gauge-range", range]].concat();
        let output = run(workshop.path(), &arguments);
        assert!(!output.status.success());
        assert!(stderr(&output).contains(word), "{}", stderr(&output));
    }
    let all = [&fit[..], &["--gauge-range=0:1e-9", "--leave-out-faulty"]].concat();
    let message = stderr(&run(workshop.path(), &all));
    assert!(message.contains("all samples look faulty"), "{message}");
}

#[test]
fn each_gauge_has_its_own_range() {
    let workshop = Workshop::new();
    workshop.write("press.csv", clipped());
    let fit = ["fit", "--train", "press.csv", "--leave-out-faulty"];
    let export = ["--export", "c.json", "--force"];
    let given = [&fit[..], &["--gauge-range=,-50:28.5"], &export].concat();
    succeed(workshop.path(), &given);
    let calibration: serde_json::Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
    let limits = serde_json::json!([[null, 30.0], [-50.0, 28.5]]);
    assert_eq!(calibration["gauge_limits"], limits, "limits that are not given are detected");
    let wrong = run(workshop.path(), &[&fit[..], &["--gauge-range=-1:1,-1:1,-1:1"]].concat());
    assert_eq!(wrong.status.code(), Some(2));
    assert!(stderr(&wrong).contains("3 ranges, but the recordings have 2 gauges"));
}

#[test]
fn overload_is_judged_by_rated_loads_from_any_source() {
    let workshop = Workshop::new();
    workshop.write("press.csv", clipped());
    workshop.write("sensor.toml", "serial = 4711\n[rated_loads]\nFz = 15\n");
    let message = |arguments: &[&str]| stderr(&run(workshop.path(), arguments));
    let fit = ["fit", "--train", "press.csv"];
    assert!(!message(&fit).contains("overload"));
    let by_file = message(&[&fit[..], &["--sensor", "sensor.toml"]].concat());
    assert!(by_file.contains("overloaded (Fz)"), "{by_file}");
    let scale = ["--full-scale", "15"];
    for arguments in [&fit[..], &["check", "press.csv"]] {
        let message = message(&[arguments, &scale].concat());
        assert!(message.contains("overloaded (Fz)"), "{arguments:?}: {message}");
    }
    // The largest load is 22.5 N, 50 % more than the rated load.
    let tolerant = [&["check", "press.csv"], &scale[..], &["--overload-tolerance", "60"]].concat();
    assert!(!message(&tolerant).contains("overload"), "{}", message(&tolerant));
    // Limits in the arguments override the limits of the file. Excluded samples are not used for training.
    let both = ["--sensor", "sensor.toml", "--full-scale", "30"];
    assert!(!message(&[&fit[..], &both].concat()).contains("overload"));
    let without = ["--leave-out-faulty", "--export", "c.json", "--force"];
    let left_out = message(&[&fit[..], &scale, &without].concat());
    assert!(left_out.contains("samples left out"), "{left_out}");
    let applied = ["apply", "c.json", "press.csv", "--out", "loads"];
    assert!(
        message(&applied).contains("overloaded (Fz)"),
        "the calibration stores the rated loads"
    );
}
