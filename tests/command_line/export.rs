//! `fit --export` in every format, and `apply` with the formats that read back.

use std::fs;

use crate::program::{fit, run, stderr, succeed};
use crate::table::Table;
use crate::workshop::{ALL_FILES, Workshop, recording};

#[test]
fn one_fit_writes_many_formats_and_writes_over_them_only_by_force() {
    let workshop = Workshop::with_recordings();
    let exports = ["h", "rs", "py", "yaml", "npz", "mat"].map(|ending| format!("c.{ending}"));
    let mut arguments = [&["fit"], &ALL_FILES[..]].concat();
    for name in &exports {
        arguments.extend(["--export", name]);
    }
    succeed(workshop.path(), &arguments);
    fs::write(workshop.file("c.h"), "mine").unwrap();
    fs::remove_file(workshop.file("c.py")).unwrap();
    let again = run(workshop.path(), &arguments);
    assert!(!again.status.success() && stderr(&again).contains("--force"));
    assert_eq!(workshop.read("c.h"), "mine");
    assert!(!workshop.file("c.py").exists());
    succeed(workshop.path(), &[&arguments[..], &["--force"]].concat());
    assert!(workshop.read("c.h").contains("c_update("));
    assert!(workshop.file("c.py").exists());
}

#[test]
fn contents_that_a_format_cannot_contain_are_named() {
    let workshop = Workshop::with_recordings();
    for (name, word) in [("c.cal", "up to 8 gauges"), ("c.xyz", "is no export format")] {
        let arguments = [&["fit"], &ALL_FILES[..], &["--export", name]].concat();
        let message = stderr(&run(workshop.path(), &arguments));
        assert!(message.contains(name) && message.contains(word), "{message}");
        assert!(!workshop.file(name).exists());
    }
}

/// Each load is twice its gauge. The `.cal` has other gauge names than the recording.
#[test]
fn an_ati_style_file_is_applied_to_the_gauges_in_their_order() {
    let workshop = Workshop::new();
    let rows: String = (["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"].iter().enumerate())
        .map(|(at, name)| {
            let values = ["0"; 6].map(str::to_owned);
            let mut values = values.to_vec();
            values[at] = "2".to_owned();
            format!("<UserAxis Name=\"{name}\" values=\"{}\" max=\"9\"/>", values.join(" "))
        })
        .collect();
    let units = "ForceUnits=\"N\" TorqueUnits=\"N-m\"";
    let text =
        format!("<FTSensor NumGages=\"6\"><Calibration {units}>{rows}</Calibration></FTSensor>");
    workshop.write("s.cal", text);
    workshop.write("run.csv", "t [s],g1,g2,g3,g4,g5,g6\n0,1,2,3,4,5,6\n1,0,0,0,0,0,7\n");
    let output = run(workshop.path(), &["apply", "s.cal", "run.csv", "--out", "."]);
    assert!(output.status.success());
    for words in ["s.cal: a .cal file", "without compensation", "offset"] {
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
    let loads = Table::read(&workshop.file("run_loads.csv"));
    assert_eq!(loads.column("Fy compensated"), [4.0, 0.0]);
    assert_eq!(loads.column("Mz uncompensated"), [12.0, 14.0]);
    let again = run(workshop.path(), &["apply", "s.cal", "run.csv", "--out", "."]);
    assert!(stderr(&again).contains("--force"));
    succeed(workshop.path(), &["apply", "s.cal", "run.csv", "--out", ".", "--force"]);
}

/// Every format with text states the sample rate (10 Hz), the recordings and their hashes.
#[test]
fn every_export_names_its_sources_and_errors() {
    let workshop = Workshop::with_recordings();
    let names = ["k.json", "k.csv", "k.h", "k.rs", "k.py", "k.yaml", "k.npz"];
    let mut arguments = [&["fit"], &ALL_FILES[..]].concat();
    for name in &names {
        arguments.extend(["--export", name]);
    }
    succeed(workshop.path(), &arguments);
    let calibration: serde_json::Value = serde_json::from_str(&workshop.read("k.json")).unwrap();
    let sources = calibration["sources"].as_array().unwrap();
    assert_eq!(sources.len(), 4);
    assert_eq!(sources[3]["role"], "test");
    let hash = sources[3]["sha256"].as_str().unwrap();
    assert_eq!(hash.len(), 64);
    for name in &names {
        let bytes = fs::read(workshop.file(name)).unwrap();
        // NumPy stores each character in four bytes.
        let letters: Vec<u8> = bytes.into_iter().filter(|byte| *byte != 0).collect();
        let text = String::from_utf8_lossy(&letters);
        assert!(text.contains(hash), "{name}");
        let quality = match *name {
            "k.json" => "test_rmse",
            _ => "on test recordings",
        };
        assert!(text.contains(quality), "{name}");
    }
    let kept = "history stores at most one sample in 0.0313";
    assert!(workshop.read("k.h").contains(kept) && workshop.read("k.rs").contains(kept));
}

/// The warning is printed before the file is written, and only if parts of the calibration are omitted.
#[test]
fn a_matrix_alone_warns_of_the_missing_parts() {
    let workshop = Workshop::with_recordings();
    let fit = [&["fit"], &ALL_FILES[..]].concat();
    let message =
        run(workshop.path(), &[&fit[..], &["--export", "c.inc", "--export", "c.json"]].concat());
    let message = stderr(&message);
    for words in ["warning: c.inc leaves out", "F_th 3 N", "the offset"] {
        assert!(message.contains(words), "{message}");
    }
    assert!(!message.contains("c.json leaves out"), "{message}");
    let bare = ["--look-back", "none", "--no-offset", "--export", "d.inc"];
    let message = stderr(&run(workshop.path(), &[&fit[..], &bare].concat()));
    assert!(workshop.file("d.inc").exists() && !message.contains("leaves out"), "{message}");
}

/// A misspelt key has no effect, so it must be reported.
#[test]
fn unknown_keys_are_named() {
    let workshop = Workshop::with_recordings();
    succeed(workshop.path(), &[&["fit", "--export", "c.json"], &ALL_FILES[..]].concat());
    let mut file: serde_json::Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
    let apply = ["apply", "c.json", "a.csv", "--out", ".", "--force"];
    let quiet = run(workshop.path(), &apply);
    assert!(!stderr(&quiet).contains("note"), "{}", stderr(&quiet));
    file["gap_sec"] = 1.into();
    file["features"]["play_radi"] = serde_json::json!([0.1]);
    file["note"] = "mine".into();
    workshop.write("c.json", file.to_string());
    let output = run(workshop.path(), &apply);
    assert!(output.status.success());
    let message = stderr(&output);
    let keys = "note: c.json: unknown keys, which were ignored: features.play_radi, gap_sec, note";
    assert!(message.contains(keys), "{message}");
}

/// Calibration files of older versions contain neither sample rate nor recordings.
#[test]
fn a_calibration_without_the_newest_facts_is_read() {
    let workshop = Workshop::with_recordings();
    succeed(workshop.path(), &[&["fit", "--export", "c.json"], &ALL_FILES[..]].concat());
    let mut older: serde_json::Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
    older.as_object_mut().unwrap().retain(|key, _| key != "sources" && key != "rate_hz");
    workshop.write("c.json", older.to_string());
    succeed(workshop.path(), &["apply", "c.json", "a.csv", "--out", "."]);
}

/// Each file has one error. The message names the place of the error, and nothing is written.
#[test]
fn a_damaged_calibration_is_not_applied() {
    let workshop = Workshop::with_recordings();
    succeed(workshop.path(), &[&["fit", "--export", "c.json"], &ALL_FILES[..]].concat());
    let whole: serde_json::Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
    type Spoil = fn(&mut serde_json::Value);
    let spoils: [(Spoil, &str); 6] = [
        (|c| c["conventional"]["matrix"] = serde_json::json!([]), "conventional.matrix"),
        (|c| c["compensated"]["matrix"][0][1] = serde_json::Value::Null, "not a calibration file"),
        (|c| c["units"][0] = "lbf".into(), "unit of Fz"),
        (|c| c["version"] = 77.into(), "version 77"),
        (|c| c["rate_hz"] = (-1.0).into(), "rate_hz"),
        (|c| drop(c.as_object_mut().unwrap().remove("gauges")), "gauges"),
    ];
    for (spoil, word) in spoils {
        let mut spoilt = whole.clone();
        spoil(&mut spoilt);
        workshop.write("s.json", spoilt.to_string());
        let output = run(workshop.path(), &["apply", "s.json", "a.csv", "--out", "."]);
        let message = stderr(&output);
        assert!(message.contains("s.json") && message.contains(word), "{word}: {message}");
        assert!(!workshop.file("a_loads.csv").exists());
    }
}

#[test]
fn a_fit_to_fewer_samples_than_coefficients_warns_and_is_exported_only_by_force() {
    let workshop = Workshop::new();
    workshop.write("few.csv", recording(0.0, 6));
    let few = ["fit", "--train", "few.csv", "--polynomial", "2"];
    let plain = run(workshop.path(), &few);
    assert!(plain.status.success());
    assert!(stderr(&plain).contains("6 training samples for"), "{}", stderr(&plain));
    let export = [&few[..], &["--export", "c.json"]].concat();
    let refused = run(workshop.path(), &export);
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("--force"), "{}", stderr(&refused));
    assert!(!workshop.file("c.json").exists());
    let forced = run(workshop.path(), &[&export[..], &["--force"]].concat());
    assert!(forced.status.success() && workshop.file("c.json").exists());
}

/// Each format gets the same bytes from the fit and from the stored calibration.
#[test]
fn a_stored_calibration_is_exported_to_the_same_bytes_as_by_its_fit() {
    let workshop = Workshop::with_recordings();
    fs::create_dir(workshop.file("stored")).unwrap();
    let names = ["h", "rs", "py", "m", "zip", "yaml", "inc", "csv", "npz", "mat", "json"];
    let names = names.map(|ending| format!("s.{ending}"));
    let exports = names.iter().flat_map(|name| ["--export", name]);
    let fit: Vec<&str> = ["fit", "--play"].into_iter().chain(ALL_FILES).chain(exports).collect();
    succeed(workshop.path(), &fit);
    let stored: Vec<String> = names.iter().map(|name| format!("stored/{name}")).collect();
    let export: Vec<&str> =
        ["export", "s.json"].into_iter().chain(stored.iter().map(|name| &**name)).collect();
    succeed(workshop.path(), &export);
    for (name, stored) in names.iter().zip(&stored) {
        let [fitted, stored] = [name, stored].map(|name| fs::read(workshop.file(name)).unwrap());
        assert!(fitted == stored, "{name}");
    }
    let again = run(workshop.path(), &export);
    assert!(!again.status.success() && stderr(&again).contains("--force"));
    let refused = run(workshop.path(), &["export", "s.json", "d.h", "d.xyz"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(!workshop.file("d.h").exists());
}

/// The matrices of the band are most of a kernel's file, so they are written only on demand.
#[test]
fn the_band_of_a_kernel_is_exported_on_demand() {
    let workshop = Workshop::with_recordings();
    let fit = ["fit", "--regressor", "kernel", "--landmarks", "30", "--force"];
    let size = |more: &[&str]| {
        succeed(workshop.path(), &[&fit[..], &ALL_FILES, &["--export", "c.json"], more].concat());
        succeed(workshop.path(), &["apply", "c.json", "a.csv", "--out", ".", "--force"]);
        (workshop.read("c.json").len(), workshop.read("a_loads.csv"))
    };
    let ((without, loads), (with, same)) = (size(&[]), size(&["--band"]));
    assert!(with > without + 20_000 && loads == same, "{with} and {without} bytes");
}

/// Returns the rows of a recording whose gauge has play of 1 N. The clock starts at zero at the sample `first`.
fn played(rate_hz: f64, seed: f64, first: u32) -> String {
    let mut play = 0.0_f64;
    let rows = (0..(40.0 * rate_hz) as u32).map(|k| {
        let t = f64::from(k) / rate_hz;
        let load = 5.0 * (0.7 * t + seed).sin() + 2.0 * (1.9 * t).sin();
        play = play.clamp(load - 1.0, load + 1.0);
        let gauge = load + 0.2 * play + 1e-3 * (37.0 * t).sin();
        format!("{:.5},{gauge},{load}\n", f64::from(k.saturating_sub(first)) / rate_hz)
    });
    let rows: String = rows.skip(first as usize).collect();
    format!("t [s],S1,Fz [N]\n{rows}")
}

/// At 1 kHz, the history of 15 s needs more than 64 kB, so its rate is chosen, before anything is scored. At 20 Hz it needs
/// less, and all samples are stored.
#[test]
fn a_history_too_large_for_a_controller_is_made_coarser_before_the_fit() {
    let workshop = Workshop::new();
    for (rate_hz, is_coarser) in [(1000.0, true), (20.0, false)] {
        for seed in 0..3 {
            workshop.write(&format!("run{seed}.csv"), played(rate_hz, f64::from(seed), 0));
        }
        let train = ["--train", "run0.csv", "run1.csv", "run2.csv"];
        let printed = |more: &[&str]| {
            let mut printed = fit(workshop.path(), &[&train[..], more].concat());
            let file: serde_json::Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
            printed["step"] = file["history_step_secs"].clone();
            (printed, file)
        };
        let (chosen, file) = printed(&["--export", "c.json", "--force"]);
        let (alone, _) = printed(&[]);
        assert_eq!(alone, chosen, "an export changes nothing");
        let whole = 0.3137 / rate_hz;
        let step = chosen["step"].as_f64().unwrap();
        assert_eq!(step > 1.5 * whole, is_coarser, "{step} s at {rate_hz} Hz");
        assert_eq!(file["quality"]["history_scatter"].is_null(), !is_coarser);
        let (all, file) = printed(&["--export", "c.json", "--force", "--history-rate", "0"]);
        assert!((all["step"].as_f64().unwrap() / whole - 1.0).abs() < 0.01, "{all}");
        assert!(file["quality"]["history_scatter"].is_null());
    }
}

/// A robot may be switched on at any sample. After the time threshold, its loads agree within the stated scatter, and its
/// errors lie within the expected error.
#[test]
fn loads_of_runs_that_start_at_different_samples_agree_within_the_stated_scatter() {
    let workshop = Workshop::new();
    for seed in 0..4 {
        workshop.write(&format!("run{seed}.csv"), played(1000.0, 1.3 * f64::from(seed), 0));
    }
    let train = ["--train", "run0.csv", "run1.csv", "run2.csv", "run3.csv"];
    let printed = fit(workshop.path(), &[&train[..], &["--export", "c.json"]].concat());
    let expected = &printed["expected_error"]["axes"][0];
    let expected = expected["value"].as_f64().unwrap_or_else(|| panic!("{expected}"));
    let file: serde_json::Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
    let stated = file["quality"]["history_scatter"][0].as_f64().unwrap();
    let loads = |first: u32| {
        let name = format!("start{first}.csv");
        workshop.write(&name, played(1000.0, 0.5, first));
        succeed(workshop.path(), &["apply", "c.json", &name, "--out", "."]);
        let table = Table::read(&workshop.file(&name.replace(".csv", "_loads.csv")));
        (table.column("Fz compensated"), table.column("Fz reference"))
    };
    let (whole, truth) = loads(0);
    for first in [101, 257, 412, 872] {
        let later = loads(first).0;
        let full = first as usize + 15 * 1000 + 1;
        let differences = (full..whole.len()).map(|k| whole[k] - later[k - first as usize]);
        let n = (whole.len() - full) as f64;
        let scatter = (differences.map(|difference| difference.powi(2)).sum::<f64>() / n).sqrt();
        assert!(scatter < 1.5 * stated, "{scatter} N, stated are {stated} N");
        let errors = (full..whole.len()).map(|k| later[k - first as usize] - truth[k]);
        let within = errors.filter(|error| error.abs() <= expected).count() as f64 / n;
        assert!(within > 0.93, "{within} of the errors are within {expected} N");
    }
}
