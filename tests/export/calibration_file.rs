//! The complete calibration as a file. A reader written only from the guide page and the schema computes the same loads.

use std::fs;
use std::process::Command;

use loopscope::calibration::{Calibration, Estimator, Regressor};
use loopscope::export::{read_calibration, with_sources, write_calibration};
use loopscope::features::{FeatureSettings, Thresholds};
use loopscope::recording::{Entry, RecordingSet, Role, Tare};

use crate::support::{
    RECORDING, Samples, calibration, calibrations, drifting, every_block, export, lines, samples,
    succeed,
};
use crate::tools::is_there;

/// Returns samples with pauses. Two of the pauses are gaps.
fn with_pauses() -> Samples {
    let mut samples = samples(&RECORDING);
    samples.truncate(600);
    for (at, pause) in [(200, 0.15), (250, 0.6), (300, 4.5), (450, 10.0)] {
        for (time, _) in &mut samples[at..] {
            *time += pause;
        }
    }
    samples
}

/// Returns a calibration with the distance over all axes, each divided by its full scale. The history skips samples.
fn by_full_scale() -> Calibration {
    let mut features = FeatureSettings {
        look_backs: vec![Thresholds { f_th: 0.3, t_th_secs: 8.0 }],
        ..every_block()
    };
    features.distance = serde_json::from_str("\"full-scale\"").unwrap();
    let mut calibration = calibration(features, Regressor::Linear);
    calibration.history_step_secs = 0.33;
    calibration
}

#[test]
fn a_reader_made_of_the_guide_alone_gives_the_loads_of_apply() {
    if !is_there("python3", &["-c", "import numpy"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    let samples = with_pauses();
    fs::write(at("samples.txt"), lines(&samples)).unwrap();
    fs::write(at("reader.py"), include_str!("reference_reader.py")).unwrap();
    let every = calibrations().into_iter();
    for (name, calibration) in every.chain([("full scale".to_owned(), by_full_scale())]) {
        let design = calibration.design();
        let mut estimator = Estimator::new(&calibration, &design).unwrap();
        let expected = samples
            .iter()
            .flat_map(|(time, gauges)| estimator.update(*time, gauges).unwrap().1.to_vec());
        let expected: Vec<f64> = expected.collect();
        write_calibration(&calibration, &at("c.json")).unwrap();
        let mut python = Command::new("python3");
        let python = python.current_dir(directory.path());
        let printed = succeed(python.args(["-B", "reader.py", "c.json", "samples.txt"]));
        let actual: Vec<f64> =
            (printed.split_whitespace()).map(|number| number.parse().unwrap()).collect();
        assert_eq!(actual.len(), expected.len(), "{name}");
        let n_axes = calibration.axes.len();
        for (k, (actual, expected)) in actual.iter().zip(&expected).enumerate() {
            let off = (actual - expected).abs() / calibration.full_scale[k % n_axes];
            assert!(off < 1e-9, "{name}, sample {}: off by {off:e}", k / n_axes);
        }
    }
}

/// Every written key is in the schema, and every required key is written.
#[test]
fn every_calibration_file_is_one_by_the_schema() {
    if !is_there("python3", &["-c", "import jsonschema"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    let mut set = RecordingSet::default();
    set.push(Entry::new(RECORDING.clone(), Role::Train)).unwrap();
    let mut all = calibrations();
    for (name, tare) in [("auto", Tare::Auto), ("interval", Tare::Interval(0.0, 1.5))] {
        let calibration = Calibration {
            tare: Some(tare),
            rated: vec![true; 6],
            ..with_sources(&by_full_scale(), &set)
        };
        all.push((name.to_owned(), calibration));
    }
    let mut files = Vec::new();
    let drifting = ("drifting".to_owned(), drifting(Regressor::Linear));
    for (name, calibration) in all.into_iter().chain([drifting]) {
        files.push(format!("{name}.json"));
        export(&calibration, &at(&files[files.len() - 1]));
    }
    fs::write(at("schema.json"), include_str!("../../assets/calibration.schema.json")).unwrap();
    let code = "
import json, sys, jsonschema
schema = json.load(open('schema.json', encoding='utf-8'))
def close(part):
    if isinstance(part, dict):
        if isinstance(part.get('properties'), dict):
            part['additionalProperties'] = False
        part = list(part.values())
    for inner in part if isinstance(part, list) else []:
        close(inner)
close(schema)
validator = jsonschema.Draft202012Validator(schema)
validator.check_schema(schema)
for name in sys.argv[1:]:
    whole = json.load(open(name, encoding='utf-8'))
    validator.validate(whole)
    for key in ['gap_secs', 'gauge_scale', 'conventional']:
        assert not validator.is_valid({k: v for k, v in whole.items() if k != key}), key
    assert not validator.is_valid({**whole, 'gap_sec': 1})
    assert not validator.is_valid({**whole, 'axes': ['Tx']})
";
    let mut python = Command::new("python3");
    let python = python.current_dir(directory.path());
    succeed(python.arg("-c").arg(code).args(&files));
}

#[test]
fn names_of_choices_are_those_of_the_command_line() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("c.json");
    let calibration = by_full_scale();
    let text = export(&calibration, &path);
    assert!(text.contains("\"distance\": \"full-scale\""), "{text}");
    let mut kept = calibration;
    kept.quality.free_coefficients = None; // not stored in files
    assert_eq!(read_calibration(&path).unwrap(), kept);
}
