//! Fits calibrations of every kind to a few built-in recordings, makes the input of exported code, and compares its output.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, LazyLock};

use loopscope::calibration::{
    Calibration, Estimator, FitSettings, KernelSettings, NetworkSettings, Regressor, Status,
};
use loopscope::export::write_calibration;
use loopscope::features::{
    Auxiliary, Blocks, Creep, FeatureSettings, FixedLag, Play, Polynomial, Thresholds,
};
use loopscope::progress::Progress;
use loopscope::questions::{Request, train};
use loopscope::recording::{Entry, Recording, RecordingSet, Role, simulated};

static RECORDINGS: LazyLock<Arc<RecordingSet>> = LazyLock::new(|| {
    let all = simulated::recordings(7);
    let mut set = RecordingSet::default();
    // The fit includes the recording of the tests, because a network gives meaningless loads outside its training range.
    let some = all.entries().iter().step_by(30);
    for entry in some.chain([&all.entries()[RUN]]) {
        let recording = Arc::new(entry.recording.decimated(4));
        set.push(Entry { recording, role: Role::Train, group: None }).unwrap();
    }
    Arc::new(set)
});

/// Index of the built-in recording on which the exported code runs.
const RUN: usize = 11;

/// Recording on which the exported code runs. Only every fourth of its samples was fitted. So the recording has more samples than
/// any ring buffer of 15 s.
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
        blocks: Blocks::every()
            .with(&FixedLag, &[0.03, 0.52, 3.0])
            .with(&Creep, &[1.0, 40.0])
            .with(&Play, &[0.1, 0.7])
            .with(&Polynomial, &[3.0]),
        ..FeatureSettings::present()
    }
}

/// Returns settings with names: no feature block, each block alone, and all blocks together.
pub fn block_sets() -> Vec<(&'static str, FeatureSettings)> {
    let all = every_block();
    let listed = |blocks| FeatureSettings { blocks, ..FeatureSettings::present() };
    let mut sets = vec![
        ("present", FeatureSettings::present()),
        (
            "look_back",
            FeatureSettings { look_backs: all.look_backs.clone(), ..FeatureSettings::present() },
        ),
        ("squares", listed(Blocks::default().with(&Polynomial, &[2.0]))),
    ];
    for (block, values) in all.blocks.used() {
        let alone = Blocks::default().with(block, values);
        sets.push((block.setting().key, listed(alone)));
    }
    sets.push(("all_blocks", all));
    sets
}

pub fn calibration(features: FeatureSettings, regressor: Regressor) -> Calibration {
    let settings = FitSettings { features, ..settings(regressor) };
    let request = Request::fit(Arc::clone(&RECORDINGS), settings);
    train(&request, &Progress::default(), &mut |_| {}).unwrap()
}

fn settings(regressor: Regressor) -> FitSettings {
    FitSettings {
        regressor,
        network: NetworkSettings { hidden: vec![12, 9], epochs: 3, ..NetworkSettings::default() },
        kernel: KernelSettings { landmarks: 15, length_scale: Some(1.0) },
        ..FitSettings::default()
    }
}

/// Returns a calibration with auxiliary channels and other blocks. The gauges drift with temperature and supply voltage, directly
/// and through a low-pass.
pub fn drifting(regressor: Regressor) -> Calibration {
    let mut set = RecordingSet::default();
    for (at, entry) in RECORDINGS.entries().iter().enumerate() {
        let n = entry.recording.n_samples();
        let values = (0..n).flat_map(|k| {
            let slow = (0.003 * k as f64 + at as f64).sin();
            [25.0 + 10.0 * slow, 5.0 - 0.2 * slow * slow]
        });
        let names = ["T */ #error", "U"].map(str::to_owned).to_vec();
        let units = ["°C", "V"].map(str::to_owned).to_vec();
        let recording = Recording::clone(&entry.recording);
        let recording = recording.with_auxiliary(names, units, values.collect());
        set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
    }
    let settings = FitSettings {
        features: FeatureSettings {
            blocks: Blocks::default()
                .with(&Auxiliary, &[0.0, 7.0])
                .with(&Creep, &[6.0])
                .with(&Polynomial, &[2.0]),
            ..FeatureSettings::default()
        },
        ..settings(regressor)
    };
    let request = Request::fit(Arc::new(set), settings);
    let calibration = train(&request, &Progress::default(), &mut |_| {}).unwrap();
    assert_eq!(calibration.features.auxiliary.len(), 2);
    keeping(calibration, 10.0)
}

/// Returns calibrations with names: least squares on each set of blocks, and every other regressor on all blocks.
pub fn calibrations() -> Vec<(String, Calibration)> {
    let linear = block_sets()
        .into_iter()
        .map(|(name, blocks)| (name.to_owned(), calibration(blocks, Regressor::Linear)))
        .map(|(name, own)| match name.as_str() {
            "present" | "all_blocks" => (name, clipped(own)),
            _ => (name, own),
        });
    // Pauses of 4.5 s are bridged by half of the calibrations.
    let all = linear.chain(learned()).enumerate();
    all.map(|(at, (name, own))| (name, if at % 2 == 0 { own } else { keeping(own, 5.0) })).collect()
}

/// Lets a calibration keep its states after pauses: the stored samples after pauses of this time (s), play after twice, creep and
/// auxiliary channels after three times this time. After a start its load fades in.
pub fn keeping(mut calibration: Calibration, secs: f64) -> Calibration {
    let memories = ["stored_samples", "play_radii", "creep_secs", "auxiliary_secs"];
    let memories = memories.map(str::to_owned).into_iter().zip([1.0, 2.0, 3.0, 3.0]);
    calibration.keep_secs = memories.map(|(memory, factor)| (memory, factor * secs)).collect();
    let blocks = &calibration.features.blocks;
    let inverse = calibration.gauge_scale.deviation.iter().map(|deviation| deviation.powi(-2));
    let inverse = inverse.map(|factor| if factor.is_finite() { factor } else { 0.0 });
    let of_radii: Vec<f64> = blocks.of(&Play).iter().flat_map(|_| inverse.clone()).collect();
    let of_taus = blocks.of(&Creep).iter().map(|tau_secs| 5.0 / tau_secs).collect();
    let fades = [("play_radii", of_radii), ("creep_secs", of_taus)].into_iter();
    let fades = fades.filter(|(_, factors): &(_, Vec<f64>)| !factors.is_empty());
    calibration.fade = fades.map(|(block, factors)| (block.to_owned(), factors)).collect();
    calibration
}

/// Adds limits of the gauges: on one side, on two sides, and none for one gauge.
fn clipped(mut calibration: Calibration) -> Calibration {
    let scale = &calibration.gauge_scale;
    let gauges = scale.shift.iter().zip(&scale.deviation);
    let limits = gauges
        .map(|(mean, deviation)| (Some(mean - 1.7 * deviation), Some(mean + 1.9 * deviation)));
    calibration.gauge_limits = limits.collect();
    calibration.gauge_limits[0].0 = None;
    calibration.gauge_limits[1] = (None, None);
    calibration
}

pub fn learned() -> Vec<(String, Calibration)> {
    let regressors = Regressor::ALL.into_iter().skip(1);
    regressors
        .map(|regressor| {
            let name = regressor.label().to_ascii_lowercase().replace([' ', '+'], "");
            (name, calibration(every_block(), regressor))
        })
        .collect()
}

#[track_caller]
pub fn export(calibration: &Calibration, path: &Path) -> String {
    write_calibration(calibration, path).unwrap();
    std::fs::read_to_string(path).unwrap_or_default()
}

pub type Samples = Vec<(f64, Vec<f64>)>;

pub fn samples(recording: &Recording) -> Samples {
    let gauges = recording.gauges().chunks_exact(recording.n_gauges());
    let times = recording.times().iter().copied();
    times.zip(gauges.map(<[f64]>::to_vec)).collect()
}

/// Returns [`RECORDING`] with jitter, pauses, numbers that are not finite, and times that are far ahead, late or repeated. The
/// clock restarts shortly before a 32-bit counter overflows, and finally jumps to the time since 1970.
pub fn disturbed() -> Samples {
    let mut samples = samples(&RECORDING);
    samples.truncate(900);
    samples[100].0 = 1e9;
    samples[150].0 = samples[140].0;
    samples[200].0 = samples[199].0;
    samples[250].1[2] = f64::NAN;
    samples[251].1[0] = f64::INFINITY;
    samples[300].0 = f64::NAN;
    for (k, (time, _)) in samples[310..360].iter_mut().enumerate() {
        *time += 0.02 * f64::from(k as u32 % 3);
    }
    for (at, pause) in [(360, 0.15), (370, 4.5), (390, 10.0)] {
        for (time, _) in &mut samples[at..] {
            *time += pause;
        }
    }
    let zero = samples[400].0 - 4_290.0;
    for (time, _) in &mut samples[400..] {
        *time -= zero;
        if *time >= 4_294.967_296 {
            *time -= 4_294.967_296;
        }
    }
    for at in [520, 600] {
        for (time, _) in &mut samples[at..] {
            *time += 4.5;
        }
    }
    for (time, _) in &mut samples[700..] {
        *time += 1.7e9;
    }
    samples
}

/// Returns [`RECORDING`] with pauses, gaps, pauses beyond the range of a 32-bit clock, and invalid gauges for longer than this
/// range. No sample is exactly as old as a threshold of [`every_block`], because rounding would then decide the past sample.
pub fn with_pauses() -> Samples {
    let mut samples = samples(&RECORDING);
    samples.truncate(1000);
    let mut paused_secs = 0.0;
    for (k, (time, gauges)) in samples.iter_mut().enumerate() {
        paused_secs += match k {
            150 => 0.15,
            300 => 10.0,
            400 => 2_400.0,
            500 => 4_200.0,
            600 => 5_400.0,
            // Together with the rejected samples, this is slightly more than one turn of a 32-bit microsecond counter.
            720 => 3_000.0,
            760 => 1_289.93,
            900 => 80_000.0,
            _ => 0.0,
        };
        *time = ((0.0501 * k as f64 + paused_secs) * 1e4).round() / 1e4;
        if (700..800).contains(&k) || k == 850 {
            gauges[1] = f64::NAN;
        }
    }
    samples
}

/// Returns [`RECORDING`] with shifted gauges, tared over its first second. Also returns the input of exported programs: the mean
/// gauges, then the samples.
pub fn tared() -> (Recording, Samples) {
    let moved = RECORDING.gauges().iter().enumerate();
    let moved = moved.map(|(at, gauge)| gauge + 0.3 * (at % RECORDING.n_gauges()) as f64);
    let recording = Recording::new(
        "moved",
        RECORDING.source().clone(),
        RECORDING.times().to_vec(),
        RECORDING.gauge_names().to_vec(),
        moved.collect(),
        RECORDING.axes().to_vec(),
        RECORDING.loads().to_vec(),
    )
    .unwrap();
    let mut fed = samples(&recording);
    let start = fed[0].0;
    let first: Vec<_> = fed.iter().take_while(|own| own.0 - start <= 1.0).collect();
    let mean = (0..recording.n_gauges()).map(|gauge| {
        let own = first.iter().map(|(_, gauges)| gauges[gauge]);
        own.sum::<f64>() / first.len() as f64
    });
    let mean = (0.0, mean.collect());
    fed.insert(0, mean);
    (recording.tared("0:1".parse().unwrap()).unwrap().0, fed)
}

/// Returns the text that exported programs read, one line per sample.
pub fn lines(samples: &Samples) -> String {
    let mut text = String::new();
    for (time, gauges) in samples {
        write!(text, "{time:?}").unwrap();
        for gauge in gauges {
            write!(text, " {gauge:?}").unwrap();
        }
        text.push('\n');
    }
    text
}

#[track_caller]
pub fn succeed(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}\n{message}");
    String::from_utf8(output.stdout).unwrap()
}

/// Checks that each line holds load, conventional load and status of a sample. Loads may differ by `tolerance` times full scale.
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
        let actual: Vec<f64> = line.split_whitespace().map(|x| x.parse().unwrap()).collect();
        assert_eq!(actual.len(), 2 * n_axes + 1, "{what}: {line}");
        let of_sample = k * n_axes..(k + 1) * n_axes;
        let expected =
            [&applied.compensated[of_sample.clone()], &applied.conventional[of_sample]].concat();
        assert_near(
            &actual[..expected.len()],
            &expected,
            calibration,
            tolerance,
            &format!("{what}, sample {k}"),
        );
    }
}

/// Checks the output for [`disturbed`] samples against the program's live estimator. Rejected samples have no load.
#[track_caller]
pub fn assert_runs_live(printed: &str, calibration: &Calibration, tolerance: f64, what: &str) {
    let statuses = assert_runs_as(&disturbed(), printed, calibration, tolerance, what);
    let n = |flag| statuses.iter().filter(|own| own.has(flag)).count();
    // 3 samples have bad numbers, 2 have a bad time, and 2 come before the restart. Pauses of more than four seconds are gaps.
    // The leap of the clock to near its end is also a gap.
    assert_eq!([n(Status::REJECTED_TIME), n(Status::REJECTED_VALUE)], [4, 3]);
    assert_eq!([n(Status::AFTER_GAP), n(Status::RESTARTED)], [5, 1]);
}

/// Checks that each printed line equals the result of the program's live estimator. Returns the statuses.
#[track_caller]
pub fn assert_runs_as(
    samples: &Samples,
    printed: &str,
    calibration: &Calibration,
    tolerance: f64,
    what: &str,
) -> Vec<Status> {
    let design = calibration.design();
    let mut estimator = Estimator::new(calibration, &design).unwrap();
    assert_eq!(printed.lines().count(), samples.len(), "{what}");
    let mut statuses = Vec::new();
    for (k, (line, (time, gauges))) in printed.lines().zip(samples).enumerate() {
        let actual: Vec<f64> = line.split_whitespace().map(|x| x.parse().unwrap()).collect();
        let (load, status) = match estimator.update(*time, gauges) {
            Ok((status, load)) => (load.to_vec(), status),
            Err(error) => (vec![f64::NAN; calibration.axes.len()], error.status()),
        };
        statuses.push(status);
        let status = [f64::from(status.bits())];
        let expected = [&load, estimator.conventional(), &status].concat();
        let what = format!("{what}, sample {k} of a stream");
        assert_near(&actual, &expected, calibration, tolerance, &what);
    }
    statuses
}

#[track_caller]
fn assert_near(
    actual: &[f64],
    expected: &[f64],
    calibration: &Calibration,
    tolerance: f64,
    what: &str,
) {
    assert_eq!(actual.len(), expected.len(), "{what}");
    for (at, (actual, expected)) in actual.iter().zip(expected).enumerate() {
        let full_scale = calibration.full_scale[at % calibration.axes.len()];
        let off = (actual - expected).abs() / full_scale.max(1e-3);
        assert!(
            off <= tolerance || (actual.is_nan() && expected.is_nan()),
            "{what}, number {at}: {actual} is not {expected}, off by {off:e}"
        );
    }
}
