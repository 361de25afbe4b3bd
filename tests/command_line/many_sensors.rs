//! Runs the guide's example for many sensors by `make`.

use std::fs;
use std::process::Command;

use crate::tools;
use crate::workshop::{Workshop, recording};

/// Returns the code block of the guide's page that begins with this text.
fn block(start: &str) -> &'static str {
    let page = include_str!("../../assets/guide/many-sensors.md");
    let from = &page[page.find(start).unwrap()..];
    &from[..from.find("```").unwrap()]
}

#[test]
fn make_calibrates_the_good_sensors_and_continues_after_a_failure() {
    let workshop = Workshop::new();
    for (at, name) in ["s1", "s2", "s3"].iter().enumerate() {
        fs::create_dir_all(workshop.file("sensors").join(name)).unwrap();
        workshop.write(&format!("sensors/{name}/sensor.toml"), format!("serial = \"{name}\"\n"));
        for run in 0..3 {
            let path = format!("sensors/{name}/train_{run}.csv");
            workshop.write(&path, recording((3 * at + run) as f64, 150));
        }
    }
    workshop.write("sensors/s2/train_1.csv", "nothing\n1;2\n");
    workshop.write("Makefile", block("SENSORS :="));
    workshop.write("limits.toml", "expected_error = 60\n");
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_loopscope"));
    let make = || {
        let path = std::env::var_os("PATH").unwrap();
        let own = program.parent().unwrap().to_owned();
        let path =
            std::env::join_paths([own].into_iter().chain(std::env::split_paths(&path))).unwrap();
        Command::new("make")
            .args(["-j2", "-k"])
            .current_dir(workshop.path())
            .env("PATH", path)
            .output()
    };
    let first = match make() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            tools::skipped("make", "this machine has no make");
            return;
        }
        made => made.unwrap(),
    };
    let printed = String::from_utf8_lossy(&first.stderr);
    assert!(!first.status.success() && printed.contains("train_1.csv"), "{printed}");
    let is_there = |name: &str| workshop.file(&format!("results/{name}.json")).exists();
    assert_eq!(["s1", "s2", "s3"].map(is_there), [true, false, true], "{printed}");
    assert!(workshop.read("results/s1.h").contains("s1_update("));
    let calibration: serde_json::Value =
        serde_json::from_str(&workshop.read("results/s3.json")).unwrap();
    assert_eq!(calibration["identity"]["serial"], "s3");
    // After the bad sensor is corrected, `make` does not fit the other sensors again.
    let written = |name: &str| {
        fs::metadata(workshop.file(&format!("results/{name}.json"))).unwrap().modified().unwrap()
    };
    let before = written("s1");
    workshop.write("sensors/s2/train_1.csv", recording(4.0, 150));
    let second = make().unwrap();
    assert!(second.status.success(), "{}", String::from_utf8_lossy(&second.stderr));
    assert!(is_there("s2") && written("s1") == before);
    // The stricter limit is exceeded, so no calibration remains.
    std::thread::sleep(std::time::Duration::from_millis(20));
    workshop.write("limits.toml", "expected_error = 0.001\n");
    let strict = make().unwrap();
    let printed = String::from_utf8_lossy(&strict.stderr);
    assert!(printed.contains("expected error of Fz is") && !is_there("s1"), "{printed}");
}
