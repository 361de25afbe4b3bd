//! `check`, which judges the recordings: its verdict as exit code, text and JSON.

use serde_json::Value;

use crate::program::{run, stderr, succeed};
use crate::workshop::{ALL_FILES, HEADER, Workshop};

/// Returns a recording of `n` poses, one per second, each repeated three times. One gauge follows the force. The other gauge mainly
/// follows another quantity.
fn poses(n: usize) -> String {
    let row = |k: usize| {
        let pose = k % n;
        let force = 10.0 * ((pose * 7 % n) as f64 / n as f64 - 0.4);
        let (other, more) = ((pose * 31 % 17) as f64 / 8.0, (pose * 13 % 11) as f64 / 8.0);
        let noise = ((k * 7919) % 101) as f64 / 5e3;
        format!("{k},{},{},{force}\n", force + other + noise, other + more - noise)
    };
    HEADER.to_owned() + &(0..3 * n).map(row).collect::<String>()
}

#[test]
fn too_few_poses_are_exit_code_three_and_say_why() {
    let workshop = Workshop::new();
    workshop.write("poses.csv", poses(8));
    let arguments = ["check", "poses.csv", "--polynomial", "3"];
    let output = run(workshop.path(), &arguments);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.lines().any(|line| line.starts_with("Not enough")), "{text}");
    assert!(
        text.lines().count() <= 30 && text.lines().all(|line| line.chars().count() <= 120),
        "{text}"
    );
    assert!(text.contains("coefficients per axis are fitted to 8 load cases"), "{text}");
    let output = run(workshop.path(), &[&arguments[..], &["--json"]].concat());
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&found["verdict"], &found["load_cases"]), (&"insufficient".into(), &8.into()));
    assert!(found["free_coefficients"].as_f64().unwrap() > 8.0 / 1.25, "{found}");
    let reasons = found["findings"].as_array().unwrap();
    assert!(
        reasons
            .iter()
            .any(|reason| reason["about"] == "load_cases" && reason["verdict"] == "insufficient")
    );
}

#[test]
fn recordings_that_determine_the_model_give_exit_code_zero() {
    let workshop = Workshop::with_recordings();
    let arguments = [&["check", "--json", "--look-back", "none"], &ALL_FILES[..]].concat();
    let found: Value =
        serde_json::from_slice(&succeed(workshop.path(), &arguments).stdout).unwrap();
    assert_ne!(found["verdict"], "insufficient");
    assert_eq!(found["rig"]["runs"].as_array().unwrap().len(), 3);
}

/// An axis that is loaded in one direction is named, without a rated load too, and an axis whose load never changes.
#[test]
fn axes_and_directions_without_load_are_named() {
    let workshop = Workshop::new();
    let row = |k: usize| {
        let [x, m] = [0.37, 0.53].map(|step| (step * k as f64).sin());
        let noise = ((k * 7919) % 101) as f64 / 1e4;
        format!(
            "{k},{},{},{},{},0\n",
            x.abs() + m + noise,
            x.abs() - m - noise,
            10.0 * x.abs(),
            2.0 * m
        )
    };
    let text =
        "t [s],S1,S2,Fz [N],Mx [Nm],My [Nm]\n".to_owned() + &(0..200).map(row).collect::<String>();
    workshop.write("a.csv", text);
    let named = |more: &[&str], id: &str| {
        let arguments = [&["check", "a.csv", "--json", "--look-back", "none"], more].concat();
        let output = run(workshop.path(), &arguments);
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        let own = found["findings"].as_array().unwrap().iter();
        let own: Vec<Value> = own.filter(|reason| reason["id"] == id).cloned().collect();
        assert_eq!(own.len(), 1, "{found}");
        let text = own[0]["text"].as_str().unwrap();
        let axes = ["Fz", "Mx", "My"].map(|axis| text.split(':').next().unwrap().contains(axis));
        (axes, own[0]["verdict"].as_str().unwrap().to_owned())
    };
    assert_eq!(named(&[], "one_sided"), ([true, false, false], "enough".to_owned()));
    let rated = ["--full-scale", "20,5,5"];
    assert_eq!(named(&rated, "one_sided"), ([true, false, false], "doubtful".to_owned()));
    assert_eq!(named(&[], "still"), ([false, false, true], "insufficient".to_owned()));
}

#[test]
fn samples_beyond_a_given_range_of_gauges_are_in_the_verdict() {
    let workshop = Workshop::with_recordings();
    let faults = |range: &str| {
        let arguments = ["check", "--json", "--gauge-range", range];
        let output = run(workshop.path(), &[&arguments[..], &ALL_FILES[..]].concat());
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        found["faults"].as_array().unwrap().len()
    };
    assert_eq!(faults("-1e6:1e6"), 0);
    assert!(faults("-1e-3:1e-3") > 0);
}

/// `fit` refuses unusable files, because the calibration would be different without them.
#[test]
fn files_that_cannot_be_used_are_findings_of_a_check_and_stop_a_fit() {
    let workshop = Workshop::with_recordings();
    workshop.write("broken.csv", "nothing\n1;2\n");
    workshop.write("bare.csv", "t,S1,S2\n0,1,3\n0.1,2,4\n");
    let files = ["a.csv", "broken.csv", "b.csv", "bare.csv", "c.csv"];
    let arguments = [&["check", "--json"], &files[..]].concat();
    let output = run(workshop.path(), &arguments);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["rig"]["runs"].as_array().unwrap().len(), 3);
    let reasons = found["findings"].as_array().unwrap().iter();
    let mut unusable = reasons.filter(|own| own["id"] == "unusable");
    let text = unusable.next().unwrap()["text"].as_str().unwrap();
    assert!(text.contains("broken.csv") && text.contains("bare.csv"), "{text}");
    assert!(unusable.next().is_none());
    let refused = run(workshop.path(), &[&["fit", "--train"], &files[..]].concat());
    assert_eq!(refused.status.code(), Some(1));
    assert!(refused.stdout.is_empty(), "fit writes no calibration of only some files");
}

/// The recordings do not reach the rated load, which limits the calibration, but the model is determined.
#[test]
fn the_exit_code_follows_the_verdict_that_is_asked_for() {
    let workshop = Workshop::with_recordings();
    workshop.write("sensor.toml", "serial = 4711\n[rated_loads]\nFz = 100\n");
    let arguments = [&["check", "--json", "--sensor", "sensor.toml"], &ALL_FILES[..]].concat();
    let output = succeed(workshop.path(), &arguments);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&found["verdict"], &found["serial"]), (&"doubtful".into(), &"4711".into()));
    assert!(found["findings"].as_array().unwrap().iter().any(|own| own["id"] == "not_reached"));
    let failing = [&arguments[..], &["--fail-on", "doubtful"]].concat();
    assert_eq!(run(workshop.path(), &failing).status.code(), Some(3));
}

#[test]
fn a_screen_begins_with_the_budget_and_all_has_every_finding() {
    let workshop = Workshop::with_recordings();
    let text = |more: &[&str]| {
        let output = run(workshop.path(), &[&["check"], &ALL_FILES[..], more].concat());
        String::from_utf8(output.stdout).unwrap()
    };
    let (screen, all) = (text(&[]), text(&["--all"]));
    assert!(screen.lines().count() <= 30, "{screen}");
    assert!(screen.lines().all(|line| line.chars().count() <= 120), "{screen}");
    let at = |text: &str, word: &str| text.lines().position(|line| line.contains(word));
    let (error, unexplained) =
        (at(&screen, "  error").unwrap(), at(&screen, "unexplained").unwrap());
    assert!(error <= 3 && unexplained < 14, "{screen}");
    assert!(at(&all, "held-out error").is_some() && at(&screen, "held-out error [%]").is_none());
}

/// Returns a recording of one force and two gauges, which follow it with backlash, or are curved.
fn pressed(seed: usize, backlash: f64, curved: f64) -> String {
    let mut played = [0.0_f64; 2];
    let row = |k: usize| {
        let t = k as f64 / 50.0;
        let phase = seed as f64;
        let force = 6.0 * (1.1 * t + phase).sin() + 4.0 * (2.3 * t + 2.0 * phase).sin();
        let mut gauges = [force, -0.7 * force];
        for (at, (gauge, played)) in gauges.iter_mut().zip(&mut played).enumerate() {
            let noise = ((k * 7919 + at * 104_729 + seed * 31) % 1009) as f64 / 1009.0 - 0.5;
            *played = played.max(*gauge - 2.0).min(*gauge + 2.0);
            *gauge += backlash * (*played - *gauge) + curved * force * *gauge + 0.01 * noise;
        }
        format!("{t},{},{},{force}\n", gauges[0], gauges[1])
    };
    HEADER.to_owned() + &(0..1500).map(row).collect::<String>()
}

#[test]
fn the_option_of_a_remedy_leaves_the_error_that_is_given() {
    for (backlash, curved, cause, option) in
        [(0.1, 0.0, "hysteresis", "--play"), (0.0, 0.005, "curvature", "--polynomial")]
    {
        let workshop = Workshop::new();
        let names: Vec<String> = (1..6).map(|at| format!("run{at}.csv")).collect();
        for (at, name) in names.iter().enumerate() {
            workshop.write(name, pressed(at + 1, backlash, curved));
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let checked = |more: &[&str]| -> Value {
            let arguments = [&["check", "--json"], more, &["--train"], &names].concat();
            serde_json::from_slice(&run(workshop.path(), &arguments).stdout).unwrap()
        };
        let found = checked(&["--look-back", "none"]);
        let remedy = &found["remedies"][0];
        assert_eq!(remedy["cause"], cause, "{found}");
        let options = found["remedy_options"][0].as_str().unwrap();
        assert!(options.contains(option), "{options}");
        let words: Vec<&str> = options.split(' ').collect();
        let arguments = [&["fit", "--json"], &words[..], &["--train"], &names].concat();
        let fitted: Value =
            serde_json::from_slice(&succeed(workshop.path(), &arguments).stdout).unwrap();
        let left = fitted["compensated"]["cv_rmse"][0].as_f64().unwrap();
        let left = left / fitted["full_scale"][0].as_f64().unwrap();
        let given = remedy["errors"][0].as_f64().unwrap();
        assert!((left - given).abs() < 1e-6 * given, "{left} {given}");
        let error = found["budget"]["uncompensated"]["pools"][0]["total"].as_f64().unwrap().sqrt();
        assert!(given < 0.5 * error, "{given} {error}");
        let after = checked(&words);
        let left = after["budget"]["compensated"]["pools"][0]["total"].as_f64().unwrap().sqrt();
        assert!((left - given).abs() < 1e-6 * given, "the total is that of the fit");
    }
}

/// In a table whose rows stand in the order of their load, a curve of the gauge looks like another sensitivity from one row on.
#[test]
fn a_curve_is_no_fault_in_a_table_in_the_order_of_its_load() {
    let workshop = Workshop::new();
    let row = |at: usize| {
        let load = 5.0 * at as f64;
        format!("{load},{}\n", (1000.0 * load - 6.0 * load * load).round())
    };
    let rows: String = (0..21).map(row).collect();
    workshop.write("rising.csv", format!("Fz [N],S1\n{rows}"));
    let output = run(workshop.path(), &["check", "--json", "--train", "rising.csv"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let all = found["findings"].as_array().unwrap();
    assert!(all.iter().all(|own| own["id"] != "gauge_changed"), "{all:?}");
    let shares = found["budget"]["uncompensated"]["pools"][0]["shares"].as_array().unwrap();
    assert_eq!(shares.len(), 1);
    assert_eq!(shares[0]["cause"], "curvature");
}
