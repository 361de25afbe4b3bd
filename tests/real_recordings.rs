//! Recordings of real sensors, where they are at hand (they are no part of this project), read as they are by column
//! maps: the figures must be those that NumPy gives on the same files by the rules of `golden/generate.py`.

#[path = "support/program.rs"]
mod program;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use loopscope::analysis::loops::{Look, LookRequest, LoopQuestion, Question, Span, Up, Viewer};
use loopscope::analysis::{Request, analyse};
use loopscope::calibration::FitSettings;
use loopscope::evaluation::loops::Frame;
use loopscope::evaluation::metrology::MetrologySettings;
use loopscope::import::map::ColumnMap;
use loopscope::import::read;
use loopscope::progress::Progress;
use loopscope::recording::{Axis, Entry, RecordingSet, Role};
use program::{fit, numbers};
use serde_json::Value;

/// The folder with a sensor's recordings, if it is there.
fn recordings_of(sensor: &str) -> Option<PathBuf> {
    let folders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/real");
    let folder = folders.join(sensor);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: there is no {}", folder.display());
    None
}

/// What fitting the files of a folder by one of the maps beside this test gives.
fn fit_by(map: &str, folder: &Path, arguments: &[&str]) -> Value {
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/column_maps");
    let map = maps.join(map);
    let columns = ["--columns", map.to_str().unwrap()];
    fit(folder, &[arguments, &columns].concat())
}

#[track_caller]
fn assert_test_rmse(report: &Value, calibration: &str, expected: &[f64]) {
    let actual = numbers(&report[calibration]["test_rmse"]);
    assert_eq!(actual.len(), expected.len());
    for (actual, expected) in actual.iter().zip(expected) {
        let off = (actual / expected - 1.0).abs();
        assert!(off < 1e-4, "{calibration}: {actual} is not {expected}");
    }
}

/// The error on the last 40 % of a interval recording: resistances and force on two clocks in one file.
fn stretch_report(name: &str, thresholds: &[&str]) -> Option<Value> {
    let folder = recordings_of("stretch")?;
    let split = ["--train", name, "--split", "0.6"];
    let arguments = [&split, thresholds].concat();
    Some(fit_by("two_clocks_in_one_file.json", &folder, &arguments))
}

#[test]
fn look_back_mends_a_fifth_of_the_error_of_a_stretch_sensor() {
    let thresholds = ["--f-th", "0.15", "--t-th", "3"];
    if let Some(report) = stretch_report("multisine_600s_1.csv", &thresholds) {
        assert_test_rmse(&report, "conventional", &[0.355129]);
        assert_test_rmse(&report, "compensated", &[0.279889]);
    }
}

#[test]
fn look_back_mends_a_third_of_the_error_of_a_stretch_sensor_in_sawtooth() {
    let thresholds = ["--f-th", "0.22", "--t-th", "7"];
    if let Some(report) = stretch_report("rand_sawtooth.csv", &thresholds) {
        assert_test_rmse(&report, "conventional", &[0.483748]);
        assert_test_rmse(&report, "compensated", &[0.327000]);
    }
}

/// Fifteen channels in one file, the load in another; a load of -1 is a dropout.
#[test]
fn look_back_mends_a_fifth_of_the_error_of_a_magnetic_skin() {
    let Some(folder) = recordings_of("eflesh") else {
        return;
    };
    let [first, second, third] =
        ["014340", "015037", "015717"].map(|run| format!("20250401_{run}/sensor.csv"));
    let roles = ["--train", &first, &second, "--test", &third];
    let thresholds = ["--f-th", "1000", "--t-th", "30"];
    let arguments = [&roles[..], &thresholds].concat();
    let report = fit_by("reference_in_its_own_file.json", &folder, &arguments);
    assert_test_rmse(&report, "conventional", &[90.343772]);
    assert_test_rmse(&report, "compensated", &[73.239233]);
}

/// Rows come in bursts of fifteen; a metal sensor has hardly any hysteresis to mend.
#[test]
fn look_back_does_little_for_a_metal_sensor() {
    let Some(folder) = recordings_of("ft6") else {
        return;
    };
    let [first, second, third, fourth] = [1, 2, 3, 4].map(|run| format!("directional_{run}.txt"));
    let roles = ["--train", &first, &second, &fourth, "--test", &third];
    let thresholds = ["--f-th", "10", "--t-th", "15"];
    let report = fit_by(
        "headerless.json",
        &folder,
        &[&roles[..], &thresholds].concat(),
    );
    assert_eq!(report["recordings"], 4);
    let conventional = [6.882583, 6.285746, 1.655491, 1.072821, 1.255908, 0.1283777];
    let compensated = [7.186475, 6.187605, 1.655938, 1.041042, 1.310694, 0.1153050];
    assert_test_rmse(&report, "conventional", &conventional);
    assert_test_rmse(&report, "compensated", &compensated);
}

/// How far each of these places (pixels) is from the nearest of the steps, at most.
fn farthest(places: &[[f64; 2]], steps: &[[[f64; 2]; 2]]) -> f64 {
    let distance = |place: &[f64; 2]| {
        let from = |[a, b]: &[[f64; 2]; 2]| {
            let (way, off) = (
                [b[0] - a[0], b[1] - a[1]],
                [place[0] - a[0], place[1] - a[1]],
            );
            let square = (way[0] * way[0] + way[1] * way[1]).max(f64::MIN_POSITIVE);
            let share = ((off[0] * way[0] + off[1] * way[1]) / square).clamp(0.0, 1.0);
            (off[0] - share * way[0]).hypot(off[1] - share * way[1])
        };
        steps.iter().map(from).fold(f64::INFINITY, f64::min)
    };
    places.iter().map(distance).fold(0.0, f64::max)
}

/// Of 5,000 noisy samples, on the whole picture and on a tenth of it across and up.
#[test]
fn loops_of_a_stretch_sensor_are_drawn_to_the_pixel() {
    let Some(folder) = recordings_of("stretch") else {
        return;
    };
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/column_maps");
    let map = ColumnMap::read(&maps.join("two_clocks_in_one_file.json")).unwrap();
    let path = folder.join("multisine_600s_1.csv");
    let mut loaded = read(&path, Some(&map), &[], &Progress::default()).unwrap();
    let recording = loaded.recordings.remove(0);
    let mut set = RecordingSet::default();
    set.push(Entry::new(recording, Role::Train)).unwrap();
    let recordings = Arc::new(set);
    let request = Request::fit(Arc::clone(&recordings), FitSettings::default());
    let analysis = analyse(&request, &Progress::default()).unwrap();
    let recording = &recordings.entries()[0].recording;
    let outputs = analysis.calibration.apply(recording).unwrap().conventional;
    let errors = outputs.iter().zip(recording.loads());
    let measured: Vec<[f64; 2]> = errors.map(|(own, load)| [*load, own - load]).collect();

    let pixels = [700.0, 500.0];
    let mut question = LoopQuestion {
        axis: Axis::Fz,
        up: Up::Error,
        span: Span::All,
        frame: None,
        pixels,
    };
    for _ in 0..2 {
        let request = LookRequest {
            calibration: Arc::clone(&analysis.calibration),
            recordings: Arc::clone(&recordings),
            decimation: 1,
            traces: Arc::clone(&analysis.traces),
            visible: None,
            measuring: MetrologySettings::default(),
            question: Question::Loops(question.clone()),
        };
        let look = Viewer::default().look(&request, &Progress::default());
        let Ok(Look::Loops(picture)) = look else {
            panic!("no loops: {look:?}")
        };
        let frame = question.frame.unwrap_or(picture.whole);
        let ranges = [frame.loads, frame.outputs];
        let place = |point: &[f64; 2]| {
            [0, 1].map(|i| pixels[i] * (point[i] - ranges[i].0) / (ranges[i].1 - ranges[i].0))
        };
        let steps = |points: &[[f64; 2]]| -> Vec<[[f64; 2]; 2]> {
            let pairs = points.windows(2);
            pairs
                .map(|pair| [place(&pair[0]), place(&pair[1])])
                .collect()
        };
        let on_screen = |points: Vec<[f64; 2]>| -> Vec<[f64; 2]> {
            let inside = |at: &[f64; 2]| (0..2).all(|i| (0.0..=pixels[i]).contains(&at[i]));
            points.into_iter().filter(inside).collect()
        };
        let strokes = &picture.curves[0].strokes;
        let drawn: Vec<_> = strokes
            .iter()
            .flat_map(|stroke| steps(&stroke.points))
            .collect();
        let samples = on_screen(measured.iter().map(place).collect());
        assert!(samples.len() > 50, "{}", samples.len());
        assert!(farthest(&samples, &drawn) <= 1.0);
        let points = strokes
            .iter()
            .flat_map(|stroke| stroke.points.iter().map(place));
        assert!(farthest(&on_screen(points.collect()), &steps(&measured)) <= 1.0);

        let middle = |(low, high): (f64, f64)| (0.55 * low + 0.45 * high, 0.45 * low + 0.55 * high);
        question.frame = Some(Frame {
            loads: middle(frame.loads),
            outputs: middle(frame.outputs),
        });
    }
}
