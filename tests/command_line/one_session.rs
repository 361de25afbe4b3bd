//! Window, report and command line give the same figures for one session.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use loopscope::engine::{Action, Engine};
use loopscope::progress::Progress;
use loopscope::questions::loops::query::LookAt;
use loopscope::questions::loops::{Look, LoopQuestion, Question, Span, TableOf, Up};
use loopscope::recording::Axis;
use loopscope::scoring::numbers::significant;
use serde_json::{Value, json};

use crate::load_cases::poses;
use crate::program::{numbers, succeed};
use crate::workshop::{Workshop, recording};

#[track_caller]
fn settle(engine: &mut Engine) {
    let deadline = Instant::now() + Duration::from_secs(60);
    loop {
        engine.take();
        if !engine.is_busy() {
            // Takes the results of finished tasks, and of the questions that follow from them.
            engine.take();
            if !engine.is_busy() {
                return;
            }
        }
        assert!(Instant::now() < deadline, "the work does not end");
        thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn window_report_and_command_line_give_the_same_number() {
    let workshop = Workshop::with_recordings();
    let session = json!({
        "format": "loopscope session",
        "version": 1,
        "files": [{ "path": "a.csv" }, { "path": "b.csv" }, { "path": "c.csv" }],
        "settings": { "full_scale": [9.0] },
        "measuring": { "reversal_thresholds": [0.7], "hold_secs": 0.5 },
    });
    workshop.write("session.json", session.to_string());
    let mut engine = Engine::new(Arc::new(|| {}));
    engine.act(Action::Open(vec![workshop.file("session.json")]));
    settle(&mut engine);
    let figures = Question::Table(TableOf::Train);
    engine.ask_as("metrology", LookAt(engine.look(None, figures).unwrap()));
    let loops = Question::Loops(LoopQuestion {
        axis: Axis::Fz,
        up: Up::Load,
        span: Span::Of(TableOf::Train),
        lag_removed: false,
        frame: None,
        pixels: [400.0, 300.0],
    });
    engine.ask_as("loops", LookAt(engine.look(None, loops).unwrap()));
    settle(&mut engine);
    let Some(Look::Table(table)) = engine.lane_of::<LookAt>("metrology").answer() else {
        panic!("no table: {:?}", engine.lane_of::<LookAt>("metrology").problem())
    };
    let Some(Look::Loops(picture)) = engine.lane_of::<LookAt>("loops").answer() else {
        panic!("no loops: {:?}", engine.lane_of::<LookAt>("loops").problem())
    };
    let progress = Progress::default();
    let calibration = engine.calibration_content().unwrap();
    calibration.write(&workshop.file("c.json"), &progress).unwrap();
    let report = engine.report_content();
    report.write(&workshop.file("r.html"), &progress).unwrap();

    let arguments = "metrology --json --calibration c.json --reversal-threshold 0.7 --hold 0.5 a.csv b.csv c.csv";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let output = succeed(workshop.path(), &arguments);
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(serde_json::to_value(&**table).unwrap()["rows"], printed["rows"]);
    assert_eq!(printed["reversal_thresholds"], json!([0.7]));
    assert_eq!((picture.reversal_threshold, picture.full_scale), (0.7, 9.0));
    assert_eq!(printed["full_scale"], json!([9.0]));

    let rows = printed["rows"].as_array().unwrap();
    let row = rows.iter().find(|row| row["id"] == "hysteresis").unwrap();
    let html = workshop.read("r.html");
    assert!(html.contains("full scale 9.000, reversal threshold 0.700"));
    for (curve, name) in picture.curves.iter().zip(["conventional", "compensated"]) {
        let own = curve.largest.as_ref().unwrap().measures[0];
        let value = row["cells"][0][name]["value"].as_f64().unwrap();
        assert!((own / value - 1.0).abs() < 1e-9, "{name}: {own} is not {value}");
        let shown = format!("{value:.4}");
        assert!(html.contains(&shown), "{name}: {shown}");
    }
}

/// The sensors have one axis in several files, one file that is cut into blocks, and load cases without times.
#[test]
fn errors_of_three_sensors_are_the_same_in_window_report_and_command_line() {
    let several = Workshop::with_recordings();
    let one = Workshop::new();
    one.write("one.csv", recording(3.0, 600));
    let cases = Workshop::new();
    cases.write("poses.csv", poses(0..3));
    let sets: [(Workshop, &[&str]); 3] =
        [(several, &["a.csv", "b.csv", "c.csv"]), (one, &["one.csv"]), (cases, &["poses.csv"])];
    for (workshop, names) in sets {
        let mut engine = Engine::new(Arc::new(|| {}));
        engine.act(Action::Open(names.iter().map(|name| workshop.file(name)).collect()));
        settle(&mut engine);
        let quality = &engine.analysis().expect("a fit").calibration.quality;
        let quality = serde_json::to_value(quality).unwrap();
        let fit = [&["fit", "--json", "--train"], names].concat();
        let fit = succeed(workshop.path(), &fit);
        let printed: Value = serde_json::from_slice(&fit.stdout).unwrap();
        let report = [&["report", "--out", "r.html", "--train"], names].concat();
        succeed(workshop.path(), &report);
        let html = workshop.read("r.html");
        for load in ["conventional", "compensated"] {
            for score in ["train_rmse", "cv_rmse"] {
                let in_window = numbers(&quality[load][score]);
                assert_eq!(in_window, numbers(&printed[load][score]), "{names:?} {load} {score}");
                for value in in_window {
                    let shown = significant(value, 4);
                    assert!(html.contains(&shown), "{names:?} {load} {score}: {shown}");
                }
            }
        }
    }
}
