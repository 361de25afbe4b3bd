//! Tests on recordings of real sensors, read by column maps. The recordings are not part of this project; without them, the tests do
//! nothing.

#[path = "support/program.rs"]
mod program;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use loopscope::calibration::FitSettings;
use loopscope::import::map::ColumnMap;
use loopscope::import::read;
use loopscope::progress::Progress;
use loopscope::questions::loops::{
    Channel, CrossQuestion, Look, LookRequest, LoopQuestion, Question, Span, TableOf, Up, look,
};
use loopscope::questions::metrology::{Metrology, MetrologySettings};
use loopscope::questions::{OnScreen, Request, analyse};
use loopscope::recording::{Entry, RecordingSet, Role};
use loopscope::report::Trace;
use loopscope::scoring::loops::{Density, Frame};
use program::{fit, numbers};
use serde_json::Value;

/// Returns the folder with a sensor's recordings, if it exists.
fn recordings_of(sensor: &str) -> Option<PathBuf> {
    let folders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/real");
    let folder = folders.join(sensor);
    if folder.is_dir() {
        return Some(folder);
    }
    let _ = writeln!(std::io::stderr(), "skipped: there is no {}", folder.display());
    None
}

/// Returns the report of a fit to the files of a folder, read by a map from `tests/column_maps`.
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

/// Returns the report of a fit that tests on the last 40 % of a recording. The file has resistances and force, each with its own
/// clock.
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

/// Fifteen channels are in one file, and the load is in another file. A load of −1 is a missing value.
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

/// Rows arrive in bursts of fifteen. A metal sensor has hardly any hysteresis.
#[test]
fn look_back_does_little_for_a_metal_sensor() {
    let Some(folder) = recordings_of("ft6") else {
        return;
    };
    let [first, second, third, fourth] = [1, 2, 3, 4].map(|run| format!("directional_{run}.txt"));
    let roles = ["--train", &first, &second, &fourth, "--test", &third];
    let thresholds = ["--f-th", "10", "--t-th", "15", "--history-rate", "0"];
    let report = fit_by("headerless.json", &folder, &[&roles[..], &thresholds].concat());
    assert_eq!(report["recordings"], 4);
    let conventional = [6.882583, 6.285746, 1.655491, 1.072821, 1.255908, 0.1283777];
    let compensated = [7.186475, 6.187605, 1.655938, 1.041042, 1.310694, 0.1153050];
    assert_test_rmse(&report, "conventional", &conventional);
    assert_test_rmse(&report, "compensated", &compensated);
}

/// Returns the recordings of files, read by a map from `tests/column_maps`.
fn recordings_by(map: &str, folder: &Path, files: &[&str]) -> RecordingSet {
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/column_maps");
    let map = ColumnMap::read(&maps.join(map)).unwrap();
    let mut set = RecordingSet::default();
    for file in files {
        let loaded = read(&folder.join(file), Some(&map), &[], &Progress::default()).unwrap();
        for recording in loaded.recordings {
            set.push(Entry::new(recording, Role::Train)).unwrap();
        }
    }
    set
}

/// Returns the names of the sensors with all their available recordings.
fn all_real() -> Vec<(&'static str, RecordingSet)> {
    let mut all = Vec::new();
    if let Some(folder) = recordings_of("stretch") {
        for file in ["multisine_600s_1.csv", "rand_sawtooth.csv"] {
            let set = recordings_by("two_clocks_in_one_file.json", &folder, &[file]);
            all.push((file, set));
        }
    }
    if let Some(folder) = recordings_of("eflesh") {
        let files = ["014340", "015037", "015717"].map(|run| format!("20250401_{run}/sensor.csv"));
        let files: Vec<&str> = files.iter().map(String::as_str).collect();
        let set = recordings_by("reference_in_its_own_file.json", &folder, &files);
        all.push(("eflesh", set));
    }
    if let Some(folder) = recordings_of("ft6") {
        for (name, n) in [("directional", 4), ("eps", 3)] {
            let files: Vec<String> = (1..=n).map(|k| format!("{name}_{k}.txt")).collect();
            let files: Vec<&str> = files.iter().map(String::as_str).collect();
            all.push((name, recordings_by("headerless.json", &folder, &files)));
        }
    }
    all
}

type Step = [[f64; 2]; 2];

/// Line segments, listed for each square of a grid that they come near.
struct Near(std::collections::HashMap<[i64; 2], Vec<Step>>);

impl Near {
    fn of(steps: impl Iterator<Item = Step>) -> Self {
        let mut near = Self(std::collections::HashMap::new());
        for step @ [a, b] in steps {
            let n = (a[0] - b[0]).hypot(a[1] - b[1]).ceil().max(1.0);
            let mut last = None;
            for k in 0..=n as usize {
                let share = k as f64 / n;
                let square = [0, 1].map(|i| ((a[i] + share * (b[i] - a[i])) / 4.0).floor() as i64);
                if last.replace(square) != Some(square) {
                    near.0.entry(square).or_default().push(step);
                }
            }
        }
        near
    }

    /// Returns the distance to the nearest line segment (pixels). Distances beyond the side of a square may be too large.
    fn distance(&self, place: [f64; 2]) -> f64 {
        let square = place.map(|at| (at / 4.0).floor() as i64);
        let around = (-1..=1).flat_map(|x| (-1..=1).map(move |y| [square[0] + x, square[1] + y]));
        let steps = around.filter_map(|square| self.0.get(&square)).flatten();
        let from = |[a, b]: &Step| {
            let way = [b[0] - a[0], b[1] - a[1]];
            let off = [place[0] - a[0], place[1] - a[1]];
            let square = (way[0] * way[0] + way[1] * way[1]).max(f64::MIN_POSITIVE);
            let share = ((off[0] * way[0] + off[1] * way[1]) / square).clamp(0.0, 1.0);
            (off[0] - share * way[0]).hypot(off[1] - share * way[1])
        };
        steps.map(from).fold(f64::INFINITY, f64::min)
    }
}

/// Measured points of each recording: horizontal and vertical values.
type Measured = Vec<Vec<[f64; 2]>>;

/// Checks the drawn points of a plot, whole and zoomed to a tenth. Each measured point is within a pixel of a drawn point, and each
/// drawn point is within a pixel of a measured point.
fn assert_to_the_pixel(
    name: &str,
    measured: &Measured,
    mut look: impl FnMut(Option<Frame>, [f64; 2]) -> (Frame, Vec<Vec<[f64; 2]>>, Vec<Arc<Density>>),
) {
    let pixels = [300.0, 220.0];
    let mut chosen = None;
    for _ in 0..2 {
        let (whole, strokes, densities) = look(chosen, pixels);
        let frame = chosen.unwrap_or(whole);
        let ranges = [frame.loads, frame.outputs];
        let place = |point: &[f64; 2]| {
            [0, 1].map(|i| pixels[i] * (point[i] - ranges[i].0) / (ranges[i].1 - ranges[i].0))
        };
        let inside = |at: &[f64; 2]| (0..2).all(|i| (0.0..=pixels[i]).contains(&at[i]));
        let steps = |points: &[[f64; 2]]| -> Vec<Step> {
            let pairs = points.windows(2);
            pairs.map(|pair| [place(&pair[0]), place(&pair[1])]).collect()
        };
        let mut drawn: Vec<Step> = strokes.iter().flat_map(|points| steps(points)).collect();
        for density in &densities {
            // Density is drawn in cells of half a pixel. Two diagonals represent a cell.
            drawn.extend(density.touched().flat_map(|(middle, _)| {
                let [x, y] = place(&middle);
                [0.25, -0.25].map(|up| [[x - 0.25, y - up], [x + 0.25, y + up]])
            }));
        }
        let measured: Vec<Step> = measured.iter().flat_map(|own| steps(own)).collect();
        let near = [&drawn, &measured].map(|steps| Near::of(steps.iter().copied()));
        let ends = |steps: &[Step]| -> Vec<[f64; 2]> {
            let ends = steps.iter().flatten().filter(|at| inside(at));
            ends.copied().collect()
        };
        for (what, places, near) in
            [("measured", ends(&measured), &near[0]), ("drawn", ends(&drawn), &near[1])]
        {
            assert!(chosen.is_some() || !places.is_empty(), "{name}: nothing is {what}");
            let distances = places.iter().map(|at| near.distance(*at));
            let far = distances.fold(0.0, f64::max);
            assert!(far <= 1.0, "{name}: {what} {far} pixels beside");
        }
        let middle = |(low, high): (f64, f64)| (0.55 * low + 0.45 * high, 0.45 * low + 0.55 * high);
        chosen = Some(Frame { loads: middle(frame.loads), outputs: middle(frame.outputs) });
    }
}

/// Returns every available sensor with its fit.
fn all_fitted() -> impl Iterator<Item = (&'static str, LookRequest, Vec<Vec<f64>>)> {
    all_real().into_iter().map(|(name, set)| {
        let recordings = Arc::new(set);
        let request = Request::fit(Arc::clone(&recordings), FitSettings::default());
        let analysis = analyse(&request, &Progress::default()).unwrap();
        let entries = recordings.entries().iter();
        let applied = entries.map(|entry| analysis.calibration.apply(&entry.recording).unwrap());
        let outputs = applied.map(|own| own.conventional).collect();
        let request = LookRequest {
            loads: OnScreen::of(&request, &analysis, None),
            measuring: MetrologySettings::default(),
            question: Question::Table(TableOf::All),
        };
        (name, request, outputs)
    })
}

fn column(values: &[f64], at: usize, n_columns: usize) -> impl Iterator<Item = f64> {
    values.iter().skip(at).step_by(n_columns).copied()
}

/// Checks the loops of every axis of every recording.
#[test]
fn loops_of_real_recordings_are_drawn_to_the_pixel() {
    for (name, mut request, outputs) in all_fitted() {
        let axes = request.loads.calibration.axes.clone();
        let recordings = Arc::clone(&request.loads.recordings);
        for (at, axis) in axes.iter().enumerate() {
            let pairs = recordings.entries().iter().zip(&outputs);
            let measured = pairs.map(|(entry, outputs)| {
                let loads = column(entry.recording.loads(), at, axes.len());
                let outputs = column(outputs, at, axes.len());
                let points = loads.zip(outputs);
                points.map(|(load, own)| [load, own - load]).collect()
            });
            let measured: Measured = measured.collect();
            assert_to_the_pixel(&format!("{name} {axis:?}"), &measured, |frame, pixels| {
                request.question = Question::Loops(LoopQuestion {
                    axis: *axis,
                    up: Up::Error,
                    span: Span::All,
                    lag_removed: false,
                    frame,
                    pixels,
                });
                match look(&request, &Progress::default()) {
                    Ok(Look::Loops(plot)) => {
                        let own = &plot.curves[0].drawn;
                        let strokes = own.strokes.iter().map(|one| one.points.clone());
                        let clouds = own.clouds.iter().map(|one| Arc::clone(&one.density));
                        (plot.whole, strokes.collect(), clouds.collect())
                    }
                    other => panic!("no loops of {name}: {other:?}"),
                }
            });
        }
    }
}

/// Checks four plots of every recording: a gauge against time, against the next gauge and against the load; an output against the load.
#[test]
fn cross_plots_of_real_recordings_are_drawn_to_the_pixel() {
    for (name, mut request, outputs) in all_fitted() {
        let axes = request.loads.calibration.axes.clone();
        let recordings = Arc::clone(&request.loads.recordings);
        let load = Channel::Load(Trace::Calculated, axes[0]);
        let output = Channel::Load(Trace::Conventional, axes[0]);
        for (across, up) in [
            (Channel::Time, Channel::Gauge(0)),
            (Channel::Gauge(1), Channel::Gauge(0)),
            (load, Channel::Gauge(0)),
            (load, output),
        ] {
            let pairs = recordings.entries().iter().zip(&outputs);
            let measured = pairs.map(|(entry, outputs)| {
                let own = &entry.recording;
                let values = |channel: Channel| -> Vec<f64> {
                    match channel {
                        Channel::Time => own.times().to_vec(),
                        Channel::Gauge(at) => column(own.gauges(), at, own.n_gauges()).collect(),
                        Channel::Load(Trace::Calculated, _) => {
                            column(own.loads(), 0, axes.len()).collect()
                        }
                        Channel::Load(_, _) => column(outputs, 0, axes.len()).collect(),
                    }
                };
                let points = values(across).into_iter().zip(values(up));
                points.map(|(across, up)| [across, up]).collect()
            });
            let measured: Measured = measured.collect();
            let what = format!("{name}: {up:?} over {across:?}");
            assert_to_the_pixel(&what, &measured, |frame, pixels| {
                request.question =
                    Question::Cross(CrossQuestion { across, up, span: Span::All, frame, pixels });
                match look(&request, &Progress::default()) {
                    Ok(Look::Cross(plot)) => {
                        let strokes = plot.drawn.strokes.iter().map(|one| one.points.clone());
                        let clouds = plot.drawn.clouds.iter().map(|one| Arc::clone(&one.density));
                        (plot.whole, strokes.collect(), clouds.collect())
                    }
                    other => panic!("no {what}: {other:?}"),
                }
            });
        }
    }
}

/// Compares the figures with half and twice the default reversal threshold. With another threshold, the ends of the largest
/// cycle may come from another cycle. A mean hardly changes.
#[test]
fn loop_figures_of_real_recordings_hardly_depend_on_the_reversal_threshold() {
    for (name, request, _) in all_fitted() {
        let table_of = |request: &LookRequest| match look(request, &Progress::default()) {
            Ok(Look::Table(table)) => table,
            _ => panic!("no table of {name}"),
        };
        let usual = table_of(&request);
        let row = |table: &Metrology| {
            let mut rows = table.rows.iter();
            rows.find(|row| row.definition.id == "loop_area").unwrap().clone()
        };
        for factor in [0.5, 2.0] {
            let mut request = request.clone();
            request.measuring.reversal_thresholds =
                usual.reversal_thresholds.iter().map(|own| Some(factor * own)).collect();
            let other = table_of(&request);
            for (cell, other) in row(&usual).cells.iter().zip(&row(&other).cells) {
                let outputs = [
                    (&cell.conventional, &other.conventional),
                    (&cell.compensated, &other.compensated),
                ];
                for (own, other) in outputs {
                    let (Ok(own), Ok(other)) = (own, other) else { continue };
                    let off = (other.value / own.value - 1.0).abs();
                    println!("{name} {:?} at {factor}: {off}", cell.axis);
                    assert!(off < 0.15, "{name} {:?}: {off}", cell.axis);
                }
            }
        }
    }
}
