//! Calibrations of every kind on a few built-in recordings, and how exported code is fed and compared.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Arc, LazyLock};

use loopscope::analysis::{Request, train};
use loopscope::calibration::{
    Calibration, FitSettings, KernelSettings, NetworkSettings, Regressor,
};
use loopscope::export::write_calibration;
use loopscope::features::{FeatureSettings, Thresholds};
use loopscope::progress::Progress;
use loopscope::recording::{Entry, Recording, RecordingSet, Role, simulated};

/// The built-in sensor's rate (Hz).
pub const RATE_HZ: u32 = 20;

static RECORDINGS: LazyLock<Arc<RecordingSet>> = LazyLock::new(|| {
    let all = simulated::recordings(7);
    let mut set = RecordingSet::default();
    // With the one that is run: outside what it has seen a network gives thousands of newtons, which tell nothing.
    let some = all.entries().iter().step_by(30);
    for entry in some.chain([&all.entries()[RUN]]) {
        let recording = Arc::new(entry.recording.decimated(4));
        let role = Role::Train;
        set.push(Entry { recording, role }).unwrap();
    }
    Arc::new(set)
});

/// Which built-in recording is run.
const RUN: usize = 11;

/// At the full rate, where every fourth sample was fitted: longer than any ring of 15 s.
pub static RECORDING: LazyLock<Recording> = LazyLock::new(|| {
    let entry = simulated::recordings(7).entries()[RUN].clone();
    assert!(entry.recording.n_samples() > 1200);
    (*entry.recording).clone()
});

pub fn every_block() -> FeatureSettings {
    FeatureSettings {
        look_backs: [(3.0, 15.0), (1.0, 4.0)]
            .map(|(f_th, t_th_secs)| Thresholds { f_th, t_th_secs })
            .to_vec(),
        fixed_lags_secs: vec![0.52, 3.0],
        creep_secs: vec![1.0, 40.0],
        play_radii: vec![0.1, 0.7],
        polynomial: 3,
        ..FeatureSettings::present()
    }
}

/// No block, each block alone, all together.
pub fn block_sets() -> Vec<(&'static str, FeatureSettings)> {
    let (all, none) = (every_block(), FeatureSettings::present());
    let none = || none.clone();
    vec![
        ("present", none()),
        (
            "look_back",
            FeatureSettings {
                look_backs: all.look_backs.clone(),
                ..none()
            },
        ),
        (
            "fixed_lag",
            FeatureSettings {
                fixed_lags_secs: all.fixed_lags_secs.clone(),
                ..none()
            },
        ),
        (
            "creep",
            FeatureSettings {
                creep_secs: all.creep_secs.clone(),
                ..none()
            },
        ),
        (
            "play",
            FeatureSettings {
                play_radii: all.play_radii.clone(),
                ..none()
            },
        ),
        (
            "squares",
            FeatureSettings {
                polynomial: 2,
                ..none()
            },
        ),
        ("all_blocks", all),
    ]
}

pub fn calibration(features: FeatureSettings, regressor: Regressor) -> Calibration {
    let settings = FitSettings {
        features,
        regressor,
        network: NetworkSettings {
            hidden: vec![12, 9],
            epochs: 3,
            ..NetworkSettings::default()
        },
        kernel: KernelSettings {
            landmarks: 15,
            length_scale: Some(1.0),
        },
        ..FitSettings::default()
    };
    let request = Request::fit(Arc::clone(&RECORDINGS), settings);
    train(&request, &Progress::default(), &mut |_| {}).unwrap()
}

/// Every block set with least squares, and every other regressor on all blocks.
pub fn calibrations() -> Vec<(String, Calibration)> {
    let linear = block_sets()
        .into_iter()
        .map(|(name, blocks)| (name.to_owned(), calibration(blocks, Regressor::Linear)));
    linear.chain(learned()).collect()
}

pub fn learned() -> Vec<(String, Calibration)> {
    let regressors = Regressor::ALL.into_iter().skip(1);
    regressors
        .map(|regressor| {
            let name = regressor
                .label()
                .to_ascii_lowercase()
                .replace([' ', '+'], "");
            (name, calibration(every_block(), regressor))
        })
        .collect()
}

#[track_caller]
pub fn export(calibration: &Calibration, path: &Path) -> String {
    write_calibration(calibration, path).unwrap();
    std::fs::read_to_string(path).unwrap_or_default()
}

/// What exported programs read: one line for each sample, time and gauges.
pub fn samples(recording: &Recording) -> String {
    let mut text = String::new();
    for (k, time) in recording.times().iter().enumerate() {
        write!(text, "{time:?}").unwrap();
        for gauge in recording.gauges_at(k) {
            write!(text, " {gauge:?}").unwrap();
        }
        text.push('\n');
    }
    text
}

/// Whether a command can be run at all.
pub fn is_there(command: &str, arguments: &[&str]) -> bool {
    let status = Command::new(command)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let is_there = status.is_ok_and(|status| status.success());
    if !is_there {
        eprintln!(
            "skipped: {command} {} does not run here",
            arguments.join(" ")
        );
    }
    is_there
}

#[track_caller]
pub fn succeed(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}\n{told}");
    String::from_utf8(output.stdout).unwrap()
}

/// Each printed line holds load and conventional load of a sample; both are the program's own within `tolerance` of full scale.
#[track_caller]
pub fn assert_loads(
    printed: &str,
    calibration: &Calibration,
    recording: &Recording,
    tolerance: f64,
    what: &str,
) {
    let applied = calibration.apply(recording).unwrap();
    let n_axes = calibration.axes.len();
    assert_eq!(printed.lines().count(), recording.n_samples(), "{what}");
    for (k, line) in printed.lines().enumerate() {
        let actual: Vec<f64> = line
            .split_whitespace()
            .map(|x| x.parse().unwrap())
            .collect();
        assert_eq!(actual.len(), 2 * n_axes, "{what}: {line}");
        let of_sample = k * n_axes..(k + 1) * n_axes;
        let expected = [
            &applied.compensated[of_sample.clone()],
            &applied.conventional[of_sample],
        ]
        .concat();
        for (at, (actual, expected)) in actual.iter().zip(expected).enumerate() {
            let off = (actual - expected).abs() / calibration.full_scale[at % n_axes].max(1e-3);
            assert!(
                off <= tolerance,
                "{what}, sample {k}, number {at}: {actual} is not {expected}, off by {off:e}"
            );
        }
    }
}
