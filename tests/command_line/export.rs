//! `fit --export` in every format, and `apply` with what reads back.

use std::fs;

use crate::program::{run, stderr, succeed};
use crate::table::Table;
use crate::workshop::{ALL_FILES, Workshop};

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
fn what_a_format_cannot_carry_is_said() {
    let workshop = Workshop::with_recordings();
    for (name, word) in [("c.cal", "six gauges"), ("c.onnx", "fit a network")] {
        let arguments = [&["fit"], &ALL_FILES[..], &["--export", name]].concat();
        let told = stderr(&run(workshop.path(), &arguments));
        assert!(told.contains(name) && told.contains(word), "{told}");
        assert!(!workshop.file(name).exists());
    }
}

/// Each load is twice its own gauge: the gauges of a `.cal` are known by their order, whatever the recording calls them.
#[test]
fn an_ati_style_file_is_applied_to_the_gauges_in_their_order() {
    let workshop = Workshop::new();
    let rows: String = (["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"].iter().enumerate())
        .map(|(at, name)| {
            let values = ["0"; 6].map(str::to_owned);
            let mut values = values.to_vec();
            values[at] = "2".to_owned();
            format!(
                "<UserAxis Name=\"{name}\" values=\"{}\" max=\"9\"/>",
                values.join(" ")
            )
        })
        .collect();
    let units = "ForceUnits=\"N\" TorqueUnits=\"N-m\"";
    let text =
        format!("<FTSensor NumGages=\"6\"><Calibration {units}>{rows}</Calibration></FTSensor>");
    workshop.write("s.cal", text);
    workshop.write(
        "run.csv",
        "t [s],g1,g2,g3,g4,g5,g6\n0,1,2,3,4,5,6\n1,0,0,0,0,0,7\n",
    );
    succeed(
        workshop.path(),
        &["apply", "s.cal", "run.csv", "--out", "."],
    );
    let loads = Table::read(&workshop.file("run_loads.csv"));
    assert_eq!(loads.column("Fy comp"), [4.0, 0.0]);
    assert_eq!(loads.column("Mz conv"), [12.0, 14.0]);
    let again = run(
        workshop.path(),
        &["apply", "s.cal", "run.csv", "--out", "."],
    );
    assert!(stderr(&again).contains("--force"));
    succeed(
        workshop.path(),
        &["apply", "s.cal", "run.csv", "--out", ".", "--force"],
    );
}
