//! Writing and reading of ATI-style `.cal` files.

use std::fs;
use std::sync::Arc;

use loopscope::calibration::{FitSettings, Regressor};
use loopscope::export::{name_gauges, read_calibration, write_calibration};
use loopscope::features::FeatureSettings;
use loopscope::progress::Progress;
use loopscope::questions::{Request, train};
use loopscope::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

use crate::support::{RECORDING, calibration, every_block, export};

/// A `.cal` has no place for the offset.
#[test]
fn a_written_file_reads_back_to_the_conventional_load_less_its_offset() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("c.cal");
    let calibration = calibration(every_block(), Regressor::Linear);
    let text = export(&calibration, &path);
    assert!(text.contains("leaves out: the compensation of hysteresis"));
    let mut read = read_calibration(&path).unwrap();
    assert_eq!(read.gauges[5], "SG5");
    let beyond = calibration.full_scale.iter().zip(&calibration.limits);
    let largest: Vec<f64> = beyond.map(|(full_scale, limit)| full_scale.max(*limit)).collect();
    assert_eq!(read.full_scale, largest, "never below the loads of the training recordings");
    name_gauges(&mut read, RECORDING.gauge_names());
    let (actual, expected) =
        (read.apply(&RECORDING).unwrap(), calibration.apply(&RECORDING).unwrap());
    assert_eq!(actual.conventional, actual.compensated);
    for (at, (actual, expected)) in
        actual.conventional.iter().zip(&expected.conventional).enumerate()
    {
        let offset = calibration.conventional.matrix[at % 6].last().unwrap();
        assert!((actual + offset - expected).abs() < 1e-9);
    }
}

/// The limit comes from ATI's library.
#[test]
fn up_to_eight_gauges_are_written_and_read_back() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("c.cal");
    let of = |n_gauges: usize| {
        let n = 300;
        let wave = |k: usize, at: usize| ((0.01 + 0.013 * at as f64) * k as f64).sin();
        let rows = |width: usize| {
            let cells = (0..n).flat_map(move |k| (0..width).map(move |at| wave(k, at)));
            cells.collect::<Vec<f64>>()
        };
        let recording = Recording::new(
            "a",
            Source::Simulated,
            (0..n).map(|k| 0.01 * k as f64).collect(),
            (0..n_gauges).map(|at| format!("g{at}")).collect(),
            rows(n_gauges),
            Axis::ALL.to_vec(),
            rows(6),
        );
        let mut set = RecordingSet::default();
        set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
        let settings = FitSettings {
            features: FeatureSettings::present(),
            offset: false,
            ..FitSettings::default()
        };
        let request = Request::fit(Arc::new(set), settings);
        train(&request, &Progress::default(), &mut |_| {}).unwrap()
    };
    let eight = of(8);
    let text = export(&eight, &path);
    assert!(text.contains("NumGages=\"8\"") && !text.contains("offset left out"));
    let read = read_calibration(&path).unwrap();
    assert_eq!(read.conventional.matrix, eight.conventional.matrix);
    let message = write_calibration(&of(9), &path).unwrap_err().to_string();
    assert!(message.contains("up to 8 gauges"), "{message}");
}

/// Returns the text of a `.cal` as another manufacturer writes it, with millimetres, padding blanks and additional elements.
fn foreign() -> String {
    let row = |name: &str, values: &str| {
        format!("<UserAxis Name=\"{name}\" values=\" {values} \" max=\"50\"/>\n")
    };
    let rows: String = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
        .iter()
        .enumerate()
        .map(|(at, name)| row(name, &format!("{at}.5   -1 0  0 0 1e-3")))
        .collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!-- any -->\n<FTSensor Serial=\"A&amp;B\" NumGages=\"6\" CalFileVersion=\"1.1\">\n\
         <Calibration ForceUnits=\"N\" TorqueUnits=\"N-mm\">\n<Axis Name=\"Fx\" values=\"9 9 9 9 9 9\" max=\"1\" scale=\"3\"/>\n{rows}\
         </Calibration></FTSensor>\n"
    )
}

#[test]
fn moments_in_newton_millimetres_become_newton_metres() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("foreign.cal");
    fs::write(&path, foreign()).unwrap();
    let read = read_calibration(&path).unwrap();
    assert_eq!(read.axes, Axis::ALL);
    assert_eq!(read.conventional.matrix[0], [0.5, -1.0, 0.0, 0.0, 0.0, 1e-3]);
    assert!((read.conventional.matrix[3][0] - 3.5e-3).abs() < 1e-18);
    assert_eq!((read.full_scale[2], read.full_scale[3]), (50.0, 0.05));
}

#[test]
fn files_with_something_missing_or_unknown_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("edited.cal");
    for (from, to, word) in [
        ("N-mm", "N-inch", "TorqueUnits"),
        ("Name=\"Tz\"", "Name=\"tz\"", "Tx Ty Tz"),
        ("Name=\"Fy\"", "Name=\"Fx\"", "twice"),
        ("1e-3", "", "Fx has 5 values"),
        ("1e-3", "nan", "nan"),
        ("1e-3", "1,5", "1,5"),
        ("NumGages", "NumGauges", "NumGages"),
        ("values=\" 0.5", "Values=\" 0.5", "values"),
        ("max=\"50\"", "max=\"-50\"", "max"),
        ("UserAxis Name=\"Fx\"", "Axis Name=\"Fx\"", "UserAxis"),
        ("</Calibration>", "</Calibrated>", "XML"),
    ] {
        let whole = foreign();
        assert!(whole.contains(from), "{from}");
        fs::write(&path, whole.replacen(from, to, 1)).unwrap();
        let message = read_calibration(&path).unwrap_err().to_string();
        assert!(message.contains("edited.cal") && message.contains(word), "{to}: {message}");
    }
    fs::write(&path, "t,S1,Fx\n0,1,2\n").unwrap();
    let message = read_calibration(&path).unwrap_err().to_string();
    assert!(message.contains("no element FTSensor"), "{message}");
}
