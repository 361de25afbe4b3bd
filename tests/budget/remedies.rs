//! Tries the remedies that change recordings, lags and auxiliary channels on simulated sensors, both ways: where the fault is, and
//! where it is not. To print the table of the guide:
//! `REMEDY_SENSORS=20 cargo test --release --test budget remedies -- --nocapture`.

use std::f64::consts::TAU;
use std::sync::Arc;

use loopscope::calibration::FitSettings;
use loopscope::features::FeatureSettings;
use loopscope::progress::Progress;
use loopscope::questions::check::query::CheckData;
use loopscope::questions::{Request, analyse, sufficiency};
use loopscope::recording::{Axis, Entry, Recording, RecordingSet, Role, Source, ValidRange};
use serde_json::Value;

use crate::number;
use crate::sensor::Dice;

const FAULTS: [&str; 4] = ["zeros", "sensitivity", "lag", "temperature"];
const LARGEST: f64 = 10.0;
const RATE_HZ: f64 = 50.0;
const SAMPLES: usize = 1200;
const RECORDINGS: usize = 6;
const GAUGES: usize = 3;
const AXES: usize = 2;

/// Returns the loads at a time: rests before the first movement and between others, and sines of several frequencies.
fn loads(waves: &[[f64; 3]], secs: f64) -> [f64; AXES] {
    let part = secs % 8.0;
    let share = ((part - 2.0) * (8.0 - part)).clamp(0.0, 1.0);
    let sum = |axis: usize| {
        let own = waves.iter().skip(axis).step_by(AXES);
        own.map(|[size, hz, phase]| size * (TAU * hz * (part - 2.0) + phase).sin()).sum::<f64>()
    };
    [0, 1].map(|axis| LARGEST * share * (0.5 * sum(axis)).clamp(-1.0, 1.0))
}

/// Recordings that a request is about.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Recorded,
    /// The same recordings without the fault.
    Mended,
    /// Other recordings of the same sensor.
    Fresh,
}

/// Makes recordings of a slightly curved sensor with this fault.
fn request(seed: u64, fault: &str, kind: Kind, features: FeatureSettings) -> Request {
    let is_mended = kind == Kind::Mended;
    let mut dice = Dice::new(seed);
    let matrix: Vec<f64> = (0..GAUGES * AXES)
        .map(|at| f64::from(u8::from(at % AXES == at / AXES % AXES)) + 0.3 * dice.normal())
        .collect();
    let bends: Vec<f64> = (0..GAUGES).map(|_| 0.001 * dice.normal()).collect();
    let warmths: Vec<f64> = (0..GAUGES).map(|_| 0.1 + 0.1 * dice.normal()).collect();
    let late_secs = dice.between(0.02, 0.06);
    let (bad, factor) = (dice.below(RECORDINGS), 1.0 + dice.between(0.04, 0.1));
    if kind == Kind::Fresh {
        dice = Dice::new(seed + 1000);
    }
    let mut set = RecordingSet::default();
    for at in 0..RECORDINGS {
        let waves: Vec<[f64; 3]> = (0..4 * AXES)
            .map(|_| [dice.between(0.3, 1.0), dice.between(0.1, 0.7), dice.between(0.0, TAU)])
            .collect();
        let zeros: Vec<f64> = (0..GAUGES).map(|_| 0.2 * dice.normal()).collect();
        let (mut gauges, mut all_loads, mut warm) = (Vec::new(), Vec::new(), Vec::new());
        let mut now = dice.normal();
        for k in 0..SAMPLES {
            let has = |own: &str| own == fault && !is_mended;
            let secs = k as f64 / RATE_HZ;
            let seen = loads(&waves, if has("lag") { (secs - late_secs).max(0.0) } else { secs });
            now += 0.03 * dice.normal();
            for gauge in 0..GAUGES {
                let row = matrix[gauge * AXES..][..AXES].iter().zip(&seen);
                let strain: f64 = row.map(|(a, b)| a * b).sum();
                let gain = if has("sensitivity") && at == bad { factor } else { 1.0 };
                let mut value = gain * (strain + bends[gauge] * strain * strain);
                value += 0.01 * dice.normal();
                value += if has("zeros") { zeros[gauge] } else { 0.0 };
                value += if has("temperature") { warmths[gauge] * now } else { 0.0 };
                gauges.push(value);
            }
            all_loads.extend(loads(&waves, secs));
            warm.push(now);
        }
        let recording = Recording::new(
            format!("run {at}"),
            Source::Simulated,
            (0..SAMPLES).map(|k| k as f64 / RATE_HZ).collect(),
            (1..=GAUGES).map(|gauge| format!("S{gauge}")).collect(),
            gauges,
            vec![Axis::Fx, Axis::Fy],
            all_loads,
        );
        let (names, units) = (vec!["T".to_owned()], vec!["°C".to_owned()]);
        let recording = recording.unwrap().with_auxiliary(names, units, warm).unwrap();
        if !(is_mended && fault == "sensitivity" && at == bad) {
            set.push(Entry::new(recording, Role::Train)).unwrap();
        }
    }
    let full_scale = vec![Some(LARGEST); AXES];
    Request::fit(Arc::new(set), FitSettings { full_scale, features, ..FitSettings::default() })
}

/// Returns the remedy of this fault, if it is offered.
fn offered<'a>(remedies: &'a [Value], fault: &str) -> Option<&'a Value> {
    let is_right = |own: &&Value| match fault {
        "zeros" => own["action"] == "tare",
        "sensitivity" => !own["action"]["leave_out"].is_null(),
        _ => own["cause"] == fault && !own["action"]["features"].is_null(),
    };
    remedies.iter().find(is_right)
}

fn remedies(seed: u64, fault: &str) -> Vec<Value> {
    let request = request(seed, fault, Kind::Recorded, FeatureSettings::present());
    let asked = CheckData::of(&request, ValidRange::default());
    let found = sufficiency(&asked, &Progress::default()).unwrap();
    serde_json::to_value(&found.remedies).unwrap().as_array().unwrap().clone()
}

/// Returns the error that a remedy really leaves (full scale): on the same recordings without their fault, or with new features
/// on other recordings.
fn truth(seed: u64, fault: &str, remedy: &Value) -> f64 {
    let features = &remedy["action"]["features"];
    let request = if features.is_null() {
        request(seed, fault, Kind::Mended, FeatureSettings::present())
    } else {
        request(seed, fault, Kind::Fresh, serde_json::from_value(features.clone()).unwrap())
    };
    let analysis = analyse(&request, &Progress::default()).unwrap();
    let rmse = analysis.calibration.quality.compensated.cv_rmse.clone().unwrap();
    let squares = rmse.iter().map(|own| (own / LARGEST).powi(2)).sum::<f64>();
    (squares / rmse.len() as f64).sqrt()
}

#[test]
fn remedies_are_offered_where_they_help_and_nowhere_else() {
    let n = number("REMEDY_SENSORS", 3);
    let sound: Vec<Vec<Value>> = (0..n).map(|seed| remedies(seed, "")).collect();
    for fault in FAULTS {
        let (mut named, mut within) = (0, 0);
        for seed in 0..n {
            let all = remedies(seed, fault);
            let Some(remedy) = offered(&all, fault) else { continue };
            let (left, truth) = (remedy["errors"][0].as_f64().unwrap(), truth(seed, fault, remedy));
            println!("{fault} {seed}: {:.3} % left, truth {:.3} %", 100.0 * left, 100.0 * truth);
            named += 1;
            within += u64::from((left / truth - 1.0).abs() < 0.2);
        }
        let wrong = sound.iter().filter(|own| offered(own, fault).is_some()).count() as u64;
        println!("{fault}: offered {named} of {n}, within 20 % {within}, without {wrong} of {n}");
        assert!(3 * named >= 2 * n && 3 * within >= 2 * named && 4 * wrong <= n, "{fault}");
    }
}
