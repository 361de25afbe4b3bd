//! The report file has well-formed markup for any file names, and a browser can display it.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use loopscope::calibration::FitSettings;
use loopscope::features::Play;
use loopscope::finding::Id;
use loopscope::progress::Progress;
use loopscope::questions::Request;
use loopscope::questions::page::{ReportData, ReportRequest, write_report};
use loopscope::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

use crate::tools::skipped;

const HOSTILE: &str =
    "<script>alert('1')</script> & \"q\" ]]> --> \u{1b}[31m \u{202e} https://x.y 力";

/// Returns a recording of two gauges that lag behind one force. The names in the recording contain markup that must be escaped.
fn hostile(seed: f64, n: usize) -> Recording {
    let times: Vec<f64> = (0..n).map(|k| k as f64 / 10.0).collect();
    let mut lagging = 0.0_f64;
    let (mut gauges, mut loads) = (Vec::new(), Vec::new());
    for t in &times {
        let force = 6.0 * (0.9 * t + seed).sin();
        lagging = lagging.clamp(force - 1.5, force + 1.5);
        gauges.extend([force + 0.4 * lagging, lagging]);
        loads.push(force);
    }
    let names = vec![HOSTILE.to_owned(), "S2".to_owned()];
    let source = Source::File("gone/<img src=x>.csv".into());
    let name = format!("{HOSTILE} {seed}");
    Recording::new(name, source, times, names, gauges, vec![Axis::Fz], loads).unwrap()
}

fn hostile_set(roles: &[Role]) -> Arc<RecordingSet> {
    let mut set = RecordingSet::default();
    for (at, role) in roles.iter().enumerate() {
        set.push(Entry::new(hostile(at as f64, 300), *role)).unwrap();
    }
    Arc::new(set)
}

fn report(request: &Request) -> ReportData {
    let asked = ReportRequest::of(request.clone());
    loopscope::questions::page::report(&asked, &Progress::default()).unwrap()
}

fn reported(roles: &[Role]) -> ReportData {
    report(&Request::fit(hostile_set(roles), FitSettings::default()))
}

fn written(data: &ReportData, path: &Path) -> String {
    write_report(path, data).unwrap();
    std::fs::read_to_string(path).unwrap()
}

/// Returns the names of all elements and attributes, and the text between the tags. Panics if the markup is not well-formed.
fn parsed(html: &str) -> (Vec<String>, String) {
    use quick_xml::events::Event;
    let mut reader = quick_xml::Reader::from_str(html);
    reader.config_mut().check_end_names = true;
    let (mut names, mut text, mut depth) = (Vec::new(), String::new(), 0);
    loop {
        let event = reader.read_event().unwrap();
        if let Event::Start(tag) | Event::Empty(tag) = &event {
            names.push(String::from_utf8(tag.name().as_ref().to_vec()).unwrap());
            for attribute in tag.attributes() {
                let key = attribute.unwrap().key.as_ref().to_vec();
                names.push(String::from_utf8(key).unwrap());
            }
        }
        match event {
            Event::Eof => break,
            Event::Start(_) => depth += 1,
            Event::End(_) => depth -= 1,
            Event::Text(part) => text.push_str(&part.decode().unwrap()),
            Event::GeneralRef(part) => {
                text.push_str(match &*part.decode().unwrap() {
                    "lt" => "<",
                    "gt" => ">",
                    "amp" => "&",
                    "quot" => "\"",
                    "apos" => "'",
                    other => panic!("&{other}; is no entity of XML"),
                });
            }
            _ => {}
        }
    }
    assert_eq!(depth, 0);
    (names, text)
}

#[test]
fn notes_and_the_errors_of_the_factory_are_in_the_report_as_text() {
    let directory = tempfile::tempdir().unwrap();
    let recordings = hostile_set(&[Role::Train, Role::Train, Role::Test]);
    let fitted = report(&Request::fit(Arc::clone(&recordings), FitSettings::default()));
    let factory = fitted.calibration;
    let request =
        Request { factory: Some(factory), ..Request::fit(recordings, FitSettings::default()) };
    let mut data = report(&request);
    data.notes = format!("bolted anew\n\n{HOSTILE}");
    let own = data.calibration.quality.conventional.test_rmse.as_ref().unwrap()[0];
    let scored = data.factory.as_ref().unwrap().test_rmse[0].unwrap();
    assert!((own - scored).abs() < 1e-9, "the factory calibration is the conventional one");
    let html = written(&data, &directory.path().join("r.html"));
    let (_, text) = parsed(&html);
    assert!(html.contains("id=\"notes\"") && text.contains("bolted anew"));
    assert!(!html.contains("<script>"));
    assert!(text.contains("calibration that the sensor came with"));
}

/// Sections of a report on a sensor with one axis, in their order. The first five make the first page.
const SECTIONS: [&str; 10] = [
    "scores",
    "budget",
    "loop",
    "expected-error",
    "findings",
    "errors",
    "thresholds",
    "metrology",
    "matrices",
    "recordings",
];

#[test]
fn a_report_is_well_formed_and_complete_for_any_file_names() {
    let directory = tempfile::tempdir().unwrap();
    let data = reported(&[Role::Train, Role::Train, Role::Train, Role::Test]);
    assert!(data.thresholds.is_ok() && data.metrology.is_ok());
    assert!(data.loops.iter().all(Result::is_ok));
    let html = written(&data, &directory.path().join("r.html"));
    let (names, text) = parsed(&html);
    assert!(text.contains("<script>alert('1')</script> & \"q\" ]]> --> \\u{1b}[31m \\u{202e}"));
    let places = SECTIONS.map(|section| html.find(&format!(" id=\"{section}\"")).expect(section));
    assert!(places.is_sorted());
    // The figures are curves over both thresholds, one loop, one trace, and two figures with the gauges of each recording.
    assert_eq!(names.iter().filter(|name| *name == "svg").count(), 6);
    for unwanted in ["script", "img", "link", "src", "href", "onload"] {
        assert!(!names.contains(&unwanted.to_owned()), "{unwanted}");
    }
    assert!(!html.contains("url(") && !html.contains("@import"));
}

/// The report is printed on at most six pages: no page is begun by force, long tables end early, and a feature that the model
/// does not use has no figure.
#[test]
fn a_report_of_many_recordings_and_features_is_bounded() {
    let directory = tempfile::tempdir().unwrap();
    let roles = [[Role::Train; 40], [Role::Test; 40]].concat();
    let mut settings = FitSettings::default();
    settings.features.look_backs.clear();
    settings.features.blocks.set(&Play, (1..=20).map(|at| 0.1 * f64::from(at)).collect());
    let data = report(&Request::fit(hostile_set(&roles), settings));
    assert!(data.thresholds.is_err());
    let html = written(&data, &directory.path().join("r.html"));
    assert!(!html.contains("break-before") && !html.contains("id=\"thresholds\""));
    let rows = |section: &str| {
        let (_, after) = html.split_once(&format!("<section id=\"{section}\"")).unwrap();
        after.split("</section>").next().unwrap().matches("<tr>").count()
    };
    assert_eq!((rows("recordings"), rows("matrices")), (17, 21));
    assert!(!html.contains("no recording"));
}

/// Only two addresses are allowed: the name space of SVG, which is not fetched, and a text in the name of the recording.
#[test]
fn nothing_is_fetched_from_elsewhere() {
    let directory = tempfile::tempdir().unwrap();
    let data = reported(&[Role::Train]);
    let html = written(&data, &directory.path().join("r.html"));
    let rest = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "").replace("https://x.y", "");
    assert!(!rest.contains("http"));
    assert!(data.warnings.iter().any(|warning| warning.id == Id::NoTest));
    assert!(html.contains("the file could not be read again"));
}

#[test]
fn the_errors_over_time_are_those_of_the_worst_test_recording() {
    let data = reported(&[Role::Train, Role::Train, Role::Test, Role::Test, Role::Test]);
    let tests = data.recordings.iter().skip(2);
    let worst = tests
        .max_by(|a, b| {
            let error = |one: &loopscope::questions::page::ReportRecording| {
                one.result.compensated_rmse.clone().unwrap()[0]
            };
            error(a).total_cmp(&error(b))
        })
        .unwrap();
    assert_eq!(data.errors.unwrap().recording, worst.used.name);
}

#[test]
fn a_report_is_not_half_written() {
    let directory = tempfile::tempdir().unwrap();
    let data = reported(&[Role::Train]);
    let path = directory.path().join("gone").join("r.html");
    let message = write_report(&path, &data).unwrap_err().to_string();
    assert!(message.contains("there is no folder"), "{message}");
    std::fs::write(directory.path().join("r.html"), "mine").unwrap();
    let mut permissions = std::fs::metadata(directory.path().join("r.html")).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(directory.path().join("r.html"), permissions).unwrap();
    let message = write_report(&directory.path().join("r.html"), &data).unwrap_err().to_string();
    assert!(message.contains("read-only"), "{message}");
}

/// A browser must find the last section and every figure of the page, and print it on at most six pages.
#[test]
fn a_browser_reads_the_report() {
    let browsers = ["chromium", "chromium-browser", "google-chrome"];
    let found = browsers.iter().find(|name| {
        let version = Command::new(name).arg("--version").output();
        version.is_ok_and(|output| output.status.success())
    });
    let Some(browser) = found else {
        skipped("chromium", "no Chromium is installed");
        return;
    };
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("r.html");
    written(&reported(&[Role::Train, Role::Test]), &path);
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"])
        .arg(format!("--user-data-dir={}", directory.path().join("profile").display()))
        .arg(&path)
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&output.stdout);
    assert!(dom.contains("<section id=\"recordings\""), "{dom}");
    assert_eq!(dom.matches("<svg").count(), 4);
    assert!(!dom.contains("<script"));
    let printed = directory.path().join("r.pdf");
    let print = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer"])
        .arg(format!("--user-data-dir={}", directory.path().join("profile").display()))
        .arg(format!("--print-to-pdf={}", printed.display()))
        .arg(&path)
        .output();
    assert!(print.unwrap().status.success());
    let pdf = std::fs::read(printed).unwrap();
    let pages = String::from_utf8_lossy(&pdf).matches("/Type /Page\n").count();
    assert!((1..=6).contains(&pages), "{pages} pages");
}
