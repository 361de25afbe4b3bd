//! Tests of the whole engine without a window, and recordings for the tests of this room.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use crate::{
    calibration::{Calibration, FitSettings, Regressor},
    engine::{
        engine::{Action, Engine, Leaving, MAX_NOTICES},
        files::{Opened, OpenedFile},
        importing::ImportCommand,
        models::Row,
        notice::{Level, Notice},
        project::{Edit, FromFile, Project, SessionFile},
        query::Background as _,
        recovery::LeftSession,
        saving::{Doubt, Existing, FileContent},
        session::{OpenedSession, Session, SessionPart},
    },
    export::{read_calibration, with_sources},
    features::{Creep, Play, Thresholds},
    finding::{Finding, Id, Place, Verdict},
    formats::stuck,
    import::{
        Loaded,
        map::{ColumnKey, ColumnMap, ColumnRole, ColumnRule},
    },
    progress::Progress,
    questions::{
        Analysis, Candidates, Mark, View, analyse,
        loops::{Question, TableOf, query::LookAt},
        metrology::MetrologySettings,
        models::asked::Train,
        question::Query,
        thresholds::asked::{ChooseBlock, StudyThresholds},
    },
    recording::{
        Axis, Entry, GaugeRange, Identity, Item, Recording, RecordingSet, Role, Source, Tare,
        simulated::Late,
    },
    scoring::score_set::ScoreSet,
};

pub(super) const FORCES: [Axis; 3] = [Axis::Fx, Axis::Fy, Axis::Fz];
pub(super) const GAUGES: [&str; 3] = ["S1", "S2", "S3"];

/// Returns a recording whose gauges are mixtures of its loads. Every load changes.
pub(super) fn recording(name: &str, source: Source, gauges: &[&str], axes: &[Axis]) -> Recording {
    recording_of(40, name, source, gauges, axes)
}

fn recording_of(n: usize, name: &str, source: Source, gauges: &[&str], axes: &[Axis]) -> Recording {
    let load = |k: usize, axis: usize| (0.4 * k as f64 * (axis + 1) as f64).sin() * 5.0;
    let gauge = |k: usize, gauge: usize| {
        let mixed = (0..3).map(|axis| load(k, axis) / (1 + gauge + axis) as f64);
        mixed.sum::<f64>() + 0.01 * (k * k % 7) as f64
    };
    let table = |width: usize, value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        (0..n * width).map(|at| value(at / width, at % width)).collect()
    };
    Recording::new(
        name,
        source,
        (0..n).map(|k| k as f64 / 20.0).collect(),
        gauges.iter().map(|&gauge| gauge.to_owned()).collect(),
        table(gauges.len(), &gauge),
        axes.to_vec(),
        table(axes.len(), &load),
    )
    .unwrap()
}

pub(super) fn of_file(name: &str, gauges: &[&str], axes: &[Axis]) -> Recording {
    recording(name, Source::File(name.into()), gauges, axes)
}

#[track_caller]
pub(super) fn add(project: &mut Project, name: &str, gauges: &[&str], axes: &[Axis]) {
    let refused = project.add(vec![vec![of_file(name, gauges, axes)]]);
    assert!(refused.is_empty(), "{refused:?}");
}

/// Opens the training recordings `a` and `b` and the test recording `test` from files.
pub(super) fn with_files() -> Project {
    let mut project = Project::default();
    for name in ["a", "b", "test"] {
        add(&mut project, name, &GAUGES, &FORCES);
    }
    project
}

pub(super) fn built_in() -> RecordingSet {
    let mut set = RecordingSet::default();
    for name in ["train", "test"] {
        let recording = recording(name, Source::Simulated, &GAUGES, &FORCES);
        set.push(Entry::with_default_role(recording)).unwrap();
    }
    set
}

pub(super) fn names(project: &Project) -> Vec<&str> {
    let entries = project.recordings.entries().iter();
    entries.map(|entry| entry.recording.name()).collect()
}

pub(super) fn roles(project: &Project) -> Vec<Role> {
    let entries = project.recordings.entries().iter();
    entries.map(|entry| entry.role).collect()
}

pub(super) fn fitted(project: &Project) -> Arc<Calibration> {
    let analysis = analyse(&project.request(None), &Progress::default());
    analysis.unwrap().calibration
}

fn engine() -> Engine {
    Engine::new(Arc::new(|| {}))
}

/// Takes answers until no work runs or waits.
#[track_caller]
fn settle(engine: &mut Engine) {
    settle_until(engine, "an end", |_| false);
}

/// As [`settle`], but only until a condition holds.
#[track_caller]
fn settle_until(engine: &mut Engine, what: &str, is_so: impl Fn(&Engine) -> bool) {
    let deadline = Instant::now() + Duration::from_secs(60);
    loop {
        engine.take();
        if is_so(engine) {
            return;
        }
        if !engine.is_busy() {
            // Takes answers that arrived late, and answers to the questions that followed from them.
            engine.take();
            if !engine.is_busy() {
                return;
            }
        }
        assert!(Instant::now() < deadline, "{what}");
        thread::sleep(Duration::from_millis(1));
    }
}

fn edit(engine: &mut Engine, edit: Edit) {
    engine.act(Action::Edit(edit));
}

/// Takes files, as if they had just been read.
fn take_files(engine: &mut Engine, files: Vec<OpenedFile>) {
    engine.take_opened(files);
    engine.take();
}

fn read(recording: Recording) -> OpenedFile {
    let Source::File(path) = recording.source().clone() else {
        panic!("not of a file");
    };
    let loaded = Loaded { recordings: vec![recording], ..Loaded::default() };
    (path, Ok(Opened::Recordings(loaded)))
}

fn open(engine: &mut Engine, names: &[&str]) {
    let files = names.iter().map(|name| read(of_file(name, &GAUGES, &FORCES)));
    take_files(engine, files.collect());
}

fn open_calibration(engine: &mut Engine, calibration: &Arc<Calibration>) {
    let own = FromFile { path: "c.json".into(), calibration: Arc::clone(calibration) };
    let opened = Opened::Calibration(Edit::Apply(Some(own)), Vec::new());
    take_files(engine, vec![("c.json".into(), Ok(opened))]);
}

/// Returns the training recordings `a` and `b` and the test recording `test`, not analysed yet.
fn engine_with_files() -> Engine {
    let mut engine = engine();
    open(&mut engine, &["a", "b", "test"]);
    engine
}

fn simulated(engine: &mut Engine, replaced: &Arc<RecordingSet>) {
    engine.take_simulated(replaced, built_in());
    engine.take();
}

fn engine_with_built_in() -> Engine {
    let mut engine = engine();
    let nothing = Arc::clone(&engine.project().recordings);
    simulated(&mut engine, &nothing);
    engine
}

#[track_caller]
fn analysed(engine: &mut Engine) -> Arc<Analysis> {
    settle(engine);
    assert!(engine.is_current());
    Arc::clone(engine.analysis().expect("an analysis"))
}

#[track_caller]
fn last_notice(engine: &Engine, level: Level, part: &str) {
    let notice = engine.notices.last().expect("a notice");
    assert_eq!(notice.level, level);
    assert!(notice.text.contains(part), "{}", notice.text);
}

fn n_notices(engine: &Engine, level: Level) -> usize {
    let notices = engine.notices.iter();
    notices.filter(|notice| notice.level == level).count()
}

#[test]
fn a_file_that_is_open_is_read_again_and_not_added_twice() {
    let mut engine = engine_with_files();
    edit(&mut engine, Edit::Roles(vec![1], Role::Off));
    edit(&mut engine, Edit::Split(0.5));
    let n = engine.entries().len();
    open(&mut engine, &["b"]);
    last_notice(&engine, Level::Info, "b");
    assert_eq!(engine.entries().len(), n);
    edit(&mut engine, Edit::Unsplit);
    assert_eq!(names(engine.project()), ["a", "b", "test"]);
    assert_eq!(roles(engine.project())[1], Role::Off);
}

/// The warnings about three files differ only in their numbers.
#[test]
fn warnings_of_one_kind_are_one_notice() {
    let mut engine = engine();
    let file = |at: usize| {
        let mut file = read(of_file(["a", "b", "test"][at], &GAUGES, &FORCES));
        if let Ok(Opened::Recordings(loaded)) = &mut file.1 {
            let seen = format!("time jumps to {at} s");
            loaded.warnings.push(Finding::new(Id::Stamps, Verdict::Doubtful, seen));
        }
        file
    };
    take_files(&mut engine, (0..3).map(file).collect());
    assert_eq!((engine.entries().len(), n_notices(&engine, Level::Warning)), (3, 1));
}

fn with_f_th(engine: &Engine, f_th: f64) -> Edit {
    let mut settings = engine.project().settings.clone();
    settings.features.look_backs[0].f_th = f_th;
    Edit::Settings(settings)
}

fn f_th(engine: &Engine) -> f64 {
    engine.project().settings.features.look_backs[0].f_th
}

/// Writes a recording of this name in `folder`. Without `header`, its columns have no names.
fn write_recording(folder: &Path, name: &str, header: bool) -> PathBuf {
    let recording = of_file(name, &GAUGES, &FORCES);
    let mut text = String::new();
    if header {
        text.push_str("t [s],S1,S2,S3,Fx [N],Fy [N],Fz [N]\n");
    }
    let gauges = recording.gauges().chunks_exact(GAUGES.len());
    let loads = recording.loads().chunks_exact(FORCES.len());
    for ((time, gauges), loads) in recording.times().iter().zip(gauges).zip(loads) {
        write!(text, "{time}").unwrap();
        for value in gauges.iter().chain(loads) {
            write!(text, ",{value}").unwrap();
        }
        text.push('\n');
    }
    let path = folder.join(format!("{name}.csv"));
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn other_settings_ask_for_one_analysis_and_the_same_for_none() {
    let mut engine = engine_with_files();
    let first = analysed(&mut engine);
    let settings = engine.project().settings.clone();
    edit(&mut engine, Edit::Settings(settings));
    assert!(engine.is_current() && !engine.is_busy());
    assert!(!engine.history.can_undo());
    let other = with_f_th(&engine, 1.5);
    edit(&mut engine, other);
    assert!(!engine.is_current());
    let second = analysed(&mut engine);
    assert!(!Arc::ptr_eq(&first, &second));
    assert_eq!(second.calibration.features.look_backs[0].f_th, 1.5);
    assert_eq!(f_th(&engine), 1.5);
    engine.take();
    assert!(!engine.is_busy(), "the question is answered");
}

#[test]
fn the_analysis_of_before_stays_while_the_next_runs() {
    let mut engine = engine_with_files();
    let first = analysed(&mut engine);
    for asked in [with_f_th(&engine, 1.5), Edit::Roles(vec![1], Role::Test)] {
        edit(&mut engine, asked);
        assert!(Arc::ptr_eq(engine.analysis().unwrap(), &first));
        assert!(!engine.is_current());
    }
    analysed(&mut engine);
}

#[test]
fn results_move_up_with_their_recordings_when_one_is_removed() {
    let mut engine = engine_with_files();
    let all = analysed(&mut engine).recordings.clone();
    edit(&mut engine, Edit::Remove(vec![0]));
    let results = |engine: &Engine| -> Vec<_> {
        (0..3).map_while(|at| engine.result_of(at).cloned()).collect()
    };
    assert_eq!(results(&engine), all[1..]);
    edit(&mut engine, Edit::Remove(vec![0]));
    edit(&mut engine, Edit::Remove(vec![0]));
    assert!(engine.analysis().is_none());
    settle(&mut engine);
    assert!(engine.analysis().is_none());
}

#[test]
fn results_before_a_split_are_not_shown_for_its_segments() {
    let mut engine = engine_with_files();
    let whole = analysed(&mut engine).recordings.clone();
    edit(&mut engine, Edit::Split(0.5));
    assert_eq!(engine.project().recordings.entries().len(), 6);
    assert_eq!(engine.project().view, View::One(1), "the first test segment is shown");
    assert!((0..6).all(|at| engine.result_of(at).is_none()));
    assert_eq!(analysed(&mut engine).recordings.len(), 6);
    edit(&mut engine, Edit::Unsplit);
    assert!(engine.result_of(0).is_none());
    assert_eq!(analysed(&mut engine).recordings, whole);
    edit(&mut engine, Edit::Unsplit);
    assert!(engine.is_current(), "a refused split changes nothing");
}

#[test]
fn real_recordings_replace_simulated_ones() {
    let mut engine = engine_with_built_in();
    analysed(&mut engine);
    let a = of_file("a", &["G1", "G2"], &[Axis::Fz]);
    take_files(&mut engine, vec![read(a)]);
    assert_eq!(names(engine.project()), ["a"]);
    assert_eq!(engine.project().view, View::One(0));
    assert!(engine.analysis().is_none(), "the fit of the simulated recordings is removed");
    let test = of_file("test", &["G1", "G2"], &[Axis::Fz]);
    take_files(&mut engine, vec![read(test)]);
    assert_eq!(names(engine.project()), ["a", "test"]);
    assert_eq!(engine.project().view, View::One(1));
}

#[test]
fn the_built_in_sensor_replaces_loaded_recordings_but_not_those_opened_during_the_simulation() {
    let mut engine = engine_with_files();
    analysed(&mut engine);
    let replaced = Arc::clone(&engine.project().recordings);
    simulated(&mut engine, &replaced);
    assert!(engine.project().recordings.is_simulated());
    assert_eq!(engine.project().view, View::One(1), "the test recording is shown");
    assert!(engine.analysis().is_none());
    analysed(&mut engine);

    let replaced = Arc::clone(&engine.project().recordings);
    let a = of_file("a", &["S1"], &[Axis::Fz]);
    take_files(&mut engine, vec![read(a)]);
    simulated(&mut engine, &replaced);
    assert_eq!(names(engine.project()), ["a"]);
}

#[test]
fn a_calibration_opened_before_the_built_in_sensor_is_ready_is_applied_to_it() {
    let calibration = fitted(engine_with_built_in().project());
    let mut engine = engine();
    let replaced = Arc::clone(&engine.project().recordings);
    open_calibration(&mut engine, &calibration);
    simulated(&mut engine, &replaced);
    let request = engine.project().request(None);
    assert_eq!(request.calibration, Some(calibration));
    assert!(!analysed(&mut engine).fitted);
    assert!(engine.notices.is_empty());
}

#[test]
fn the_built_in_sensor_is_simulated_on_request() {
    let mut engine = engine();
    engine.act(Action::OpenBuiltIn(None));
    assert!(engine.is_busy());
    settle_until(&mut engine, "the built-in sensor", |engine| {
        engine.project().recordings.is_simulated()
    });
    assert!(engine.project().recordings.is_simulated());
    assert!(!engine.is_unsaved(), "built-in recordings need no saving");
}

#[test]
fn other_gauges_are_refused_and_nothing_is_lost() {
    let mut engine = engine_with_files();
    let analysis = analysed(&mut engine);
    let before = Arc::clone(&engine.project().recordings);
    let other = of_file("other", &["G1"], &FORCES);
    take_files(&mut engine, vec![read(other)]);
    last_notice(&engine, Level::Error, "other: the gauges are G1");
    assert!(Arc::ptr_eq(&engine.project().recordings, &before));
    assert!(Arc::ptr_eq(engine.analysis().unwrap(), &analysis));
    assert!(engine.is_current());
}

#[test]
fn a_file_that_failed_changes_nothing_else() {
    let failed = || ("x".into(), Err("x: cannot be read".to_owned()));
    for mut engine in [engine_with_files(), engine_with_built_in()] {
        let before = Arc::clone(&engine.project().recordings);
        take_files(&mut engine, vec![failed()]);
        last_notice(&engine, Level::Error, "x: cannot be read");
        assert!(Arc::ptr_eq(&engine.project().recordings, &before));
    }
    let mut engine = engine_with_files();
    let c = read(of_file("c", &GAUGES, &FORCES));
    take_files(&mut engine, vec![failed(), c]);
    assert_eq!(names(engine.project()), ["a", "b", "test", "c"]);
    assert_eq!(engine.notices.len(), 1);
}

#[test]
fn warnings_of_a_file_become_notices() {
    let mut engine = engine();
    let place = Place { path: "a.csv".into(), first_line: 3, last_line: 3, count: 1 };
    let warning = Finding::new(Id::RowsSkipped, Verdict::Doubtful, "no rotation");
    let warning = Finding { place: Some(place), ..warning };
    let loaded = Loaded {
        recordings: vec![of_file("a", &["S1"], &[Axis::Fz])],
        warnings: vec![warning],
        ..Loaded::default()
    };
    let opened = Ok(Opened::Recordings(loaded));
    take_files(&mut engine, vec![("a".into(), opened)]);
    last_notice(&engine, Level::Warning, "a.csv");
}

#[test]
fn loads_without_a_unit_are_said_and_counts_are_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let said_of = |name: &str, largest: f64, digits: usize| {
        let mut text = "t [s],S1,Fz\n".to_owned();
        for k in 0..200 {
            let strain = (f64::from(k) / 20.0).sin();
            let (secs, load) = (f64::from(k) / 100.0, largest * strain);
            writeln!(text, "{secs},{strain},{load:.digits$}").unwrap();
        }
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let mut engine = engine();
        engine.act(Action::Open(vec![path]));
        settle(&mut engine);
        assert_eq!(engine.project().recordings.entries().len(), 1);
        let of_file = engine.notices.iter().filter(|notice| notice.text.starts_with(name));
        of_file.map(|notice| notice.level).collect::<Vec<_>>()
    };
    assert_eq!(said_of("counts.csv", 2e7, 0), [Level::Warning]);
    assert_eq!(said_of("newtons.csv", 40.5, 3), [Level::Info]);
}

#[test]
fn a_calibration_is_applied_until_fit_again() {
    let mut engine = engine_with_files();
    let calibration = Arc::clone(&analysed(&mut engine).calibration);
    open_calibration(&mut engine, &calibration);
    let applied = |engine: &Engine| engine.project().applied.clone();
    assert_eq!(applied(&engine).unwrap().path, Path::new("c.json"));
    assert!(!analysed(&mut engine).fitted);

    open(&mut engine, &["c"]);
    assert!(
        applied(&engine).is_some(),
        "the calibration is also applied to recordings that are opened later"
    );

    edit(&mut engine, Edit::Apply(None));
    assert!(applied(&engine).is_none());
    assert!(analysed(&mut engine).fitted);
}

#[test]
fn a_calibration_of_other_gauges_is_refused() {
    let mut engine = engine_with_files();
    let mut calibration = Calibration::clone(&fitted(engine.project()));
    calibration.gauges[0] = "G1".to_owned();
    open_calibration(&mut engine, &Arc::new(calibration));
    last_notice(&engine, Level::Error, "G1");
    assert!(engine.project().applied.is_none());
}

#[test]
fn a_failed_analysis_keeps_the_last_one_and_gives_the_reason() {
    let mut engine = engine_with_files();
    let analysis = analysed(&mut engine);
    edit(&mut engine, Edit::AllRoles(Role::Test));
    settle(&mut engine);
    let problem = engine.problem().expect("nothing trains");
    assert!(problem.contains("no recording is in the train role"));
    assert!(Arc::ptr_eq(engine.analysis().unwrap(), &analysis));
    edit(&mut engine, Edit::AllRoles(Role::Train));
    analysed(&mut engine);
    assert_eq!(engine.problem(), None);
}

#[test]
fn closing_leaves_nothing_of_the_recordings() {
    let mut engine = engine_with_files();
    settle(&mut engine);
    assert_eq!(engine.problem(), None);
    let calibration = fitted(engine.project());
    open_calibration(&mut engine, &calibration);
    edit(&mut engine, Edit::New);
    for _ in 0..2 {
        assert!(engine.project().recordings.entries().is_empty());
        assert!(engine.analysis().is_none() && engine.project().applied.is_none());
        settle(&mut engine);
    }
    assert!(engine.problem().is_some_and(|problem| problem.contains("no recording is loaded")));
}

/// Opens a recording of another sensor, which has two gauges.
fn open_other(engine: &mut Engine) {
    let other = of_file("other", &["G1", "G2"], &[Axis::Fz]);
    take_files(engine, vec![read(other)]);
}

/// Returns everything that a session of the document would save.
fn saved_of(project: &Project) -> serde_json::Value {
    let text = Session::of(project).to_json(Path::new(""));
    serde_json::from_slice(&text).unwrap()
}

fn serial_number(serial: &str) -> Identity {
    let mut identity = Identity::default();
    identity.set(Item::Serial, serial);
    identity
}

/// Enters all that belongs to one sensor: identity, settings, notes, groups and a list of models, and saves the session.
fn enter_all(engine: &mut Engine, session: &Path) {
    let mut settings = engine.project().settings.clone();
    settings.features.look_backs.clear();
    settings.features.blocks = settings.features.blocks.with(&Play, &[0.5]).with(&Creep, &[9.0]);
    settings.ridge = crate::calibration::RidgeChoice::Strength(0.5);
    for own in [
        Edit::Settings(settings),
        Edit::Identity(serial_number("SN-0042")),
        Edit::Notes("oiled".to_owned()),
        Edit::Groups(vec![Some("monday".to_owned())]),
        Edit::GaugeRange(Some(GaugeRange::All((-10.0, 10.0)))),
        Edit::OverloadTolerance(0.5),
        Edit::Measuring(MetrologySettings { hold_secs: 1.5, ..MetrologySettings::default() }),
    ] {
        edit(engine, own);
    }
    settle(engine);
    engine.act(Action::KeepModel);
    settle(engine);
    assert_eq!(engine.models.rows.len(), 1);
    save_session(engine, session);
}

#[test]
fn a_new_document_has_nothing_of_the_former_sensor_and_undo_brings_it_back() {
    let folder = tempfile::tempdir().unwrap();
    let (session, export) = (folder.path().join("s.json"), folder.path().join("c.json"));
    let mut engine = engine_with_files();
    enter_all(&mut engine, &session);
    engine.act(Action::New);
    assert!(engine.leaving.is_none(), "everything is saved");
    assert_eq!((engine.entries().len(), engine.models.rows.len()), (0, 0));
    assert!(engine.session.is_none() && !engine.is_unsaved());
    open_other(&mut engine);
    let mut expected = Project::default();
    add(&mut expected, "other", &["G1", "G2"], &[Axis::Fz]);
    assert_eq!(saved_of(engine.project()), saved_of(&expected));
    analysed(&mut engine);
    engine.act(Action::Export(vec![export.clone()], Existing::Ask));
    settle(&mut engine);
    assert!(read_calibration(&export).unwrap().identity.is_empty());

    engine.act(Action::Undo);
    engine.act(Action::Undo);
    assert_eq!(names(engine.project()), ["a", "b", "test"]);
    assert_eq!(engine.project().identity.get(Item::Serial), "SN-0042");
    assert_eq!((engine.session.as_ref(), engine.models.rows.len()), (Some(&session), 1));
    assert!(engine.models.rows[0].is_present(engine.project()));
    engine.act(Action::Redo);
    assert!(engine.session.is_none() && engine.models.rows.is_empty());
    assert!(engine.project().identity.is_empty());
}

#[test]
fn recordings_of_other_gauges_begin_with_default_settings_and_those_of_the_same_do_not() {
    let folder = tempfile::tempdir().unwrap();
    for is_other in [false, true] {
        let mut engine = engine_with_files();
        enter_all(&mut engine, &folder.path().join("s.json"));
        while !engine.entries().is_empty() {
            edit(&mut engine, Edit::Remove(vec![0]));
        }
        let before = engine.project().settings.clone();
        if is_other {
            open_other(&mut engine);
        } else {
            open(&mut engine, &["c"]);
        }
        let serial = engine.project().identity.get(Item::Serial);
        if is_other {
            assert_eq!((serial, &*engine.project().notes), ("", ""));
            assert_eq!(engine.project().settings, FitSettings::default());
            assert!(engine.session.is_none(), "the session of the former sensor stays as it is");
        } else {
            assert_eq!((serial, &engine.project().settings), ("SN-0042", &before));
        }
    }
}

#[test]
fn a_new_document_asks_only_about_unsaved_changes() {
    let mut engine = engine_with_files();
    engine.act(Action::New);
    assert!(matches!(engine.leaving, Some(Leaving::New)));
    engine.act(Action::Stay);
    assert_eq!(engine.entries().len(), 3);
    engine.act(Action::New);
    engine.act(Action::Discard);
    assert_eq!(engine.entries().len(), 0);
    engine.act(Action::Undo);
    assert_eq!(engine.entries().len(), 3);
}

#[test]
fn the_identity_of_an_applied_calibration_replaces_that_of_the_former_sensor() {
    let mut engine = engine_with_files();
    let calibration = Calibration::clone(&analysed(&mut engine).calibration);
    let mut identity = serial_number("SN-0042");
    identity.set(Item::Model, "F10");
    edit(&mut engine, Edit::Identity(identity.clone()));
    open_calibration(&mut engine, &Arc::new(calibration.clone()));
    assert_eq!(engine.project().identity, identity, "the calibration has no identity");
    let own = serial_number("SN-0043");
    open_calibration(&mut engine, &Arc::new(Calibration { identity: own.clone(), ..calibration }));
    assert_eq!(engine.project().identity, own);
}

#[test]
fn an_empty_document_has_no_problem() {
    let mut engine = engine();
    edit(&mut engine, Edit::Notes("new".to_owned()));
    settle(&mut engine);
    assert_eq!(engine.problem(), None);
}

fn ask_figures(engine: &mut Engine) {
    if let Some(look) = engine.look(None, Question::Table(TableOf::All)) {
        engine.ask(LookAt(look));
    }
}

fn ask_study(engine: &mut Engine) {
    if !engine.entries().is_empty() {
        engine.ask(study_of(engine.project()));
    }
}

fn study_of(project: &Project) -> StudyThresholds {
    StudyThresholds::of(&project.request(None), project.thresholds())
}

#[test]
fn answers_about_recordings_that_were_closed_are_not_shown() {
    let mut engine = engine_with_files();
    analysed(&mut engine);
    ask_figures(&mut engine);
    settle(&mut engine);
    assert!(engine.lane::<LookAt>().answer().is_some(), "{:?}", engine.lane::<LookAt>().problem());
    edit(&mut engine, Edit::New);
    assert!(engine.lane::<LookAt>().answer().is_none());
    // Other recordings of the same gauges and axes, before and after the running work has ended.
    for settled in [false, true] {
        open(&mut engine, &["c", "d"]);
        assert!(engine.analysis().is_none() && engine.result_of(0).is_none());
        if settled {
            settle(&mut engine);
        }
        ask_figures(&mut engine);
        edit(&mut engine, Edit::New);
        open(&mut engine, &["e", "f"]);
        assert!(engine.analysis().is_none());
        assert!(engine.lane::<LookAt>().answer().is_none());
        settle(&mut engine);
        assert!(
            engine.lane::<LookAt>().answer().is_none(),
            "there is no question about these recordings"
        );
        assert_eq!(analysed(&mut engine).calibration.trained_on, ["e", "f"]);
        edit(&mut engine, Edit::New);
    }
}

#[test]
fn figures_of_before_stay_while_the_next_are_made() {
    let mut engine = engine_with_files();
    analysed(&mut engine);
    ask_figures(&mut engine);
    settle(&mut engine);
    let other = with_f_th(&engine, 1.5);
    edit(&mut engine, other);
    analysed(&mut engine);
    ask_figures(&mut engine);
    assert!(engine.lane::<LookAt>().answer().is_some() && !engine.lane::<LookAt>().is_current());
    settle(&mut engine);
    assert!(engine.lane::<LookAt>().is_current());
}

#[test]
fn a_threshold_study_of_other_recordings_goes() {
    let mut engine = engine_with_files();
    ask_study(&mut engine);
    settle(&mut engine);
    let has_map = |engine: &Engine| {
        let map = engine.lane::<StudyThresholds>().answer().and_then(|study| study.map.as_ref());
        map.is_some_and(|map| map.is_complete())
    };
    assert!(has_map(&engine) && engine.lane::<StudyThresholds>().is_current());

    let other = Thresholds { f_th: 2.5, ..engine.project().thresholds() };
    edit(&mut engine, Edit::Thresholds(other));
    ask_study(&mut engine);
    assert!(has_map(&engine), "the map stays for other thresholds");
    settle(&mut engine);
    assert!(has_map(&engine) && engine.lane::<StudyThresholds>().is_current());

    edit(&mut engine, Edit::Roles(vec![1], Role::Off));
    ask_study(&mut engine);
    assert!(engine.lane::<StudyThresholds>().answer().is_none());
    // The running work now belongs to other recordings.
    edit(&mut engine, Edit::Roles(vec![1], Role::Train));
    ask_study(&mut engine);
    settle(&mut engine);
    let answered = engine.lane::<StudyThresholds>().answered().unwrap();
    assert!(Query::is_akin(answered, &study_of(engine.project())) && has_map(&engine));

    edit(&mut engine, Edit::New);
    ask_study(&mut engine);
    settle(&mut engine);
    assert!(engine.lane::<StudyThresholds>().answer().is_none());
}

#[test]
fn cancel_does_not_ask_the_same_again() {
    let mut engine = engine_with_files();
    analysed(&mut engine);
    let other = with_f_th(&engine, 1.5);
    edit(&mut engine, other);
    ask_study(&mut engine);
    engine.act(Action::Cancel);
    settle(&mut engine);
    for _ in 0..3 {
        engine.take();
        ask_study(&mut engine);
        assert!(!engine.is_busy(), "the outdated question has ended");
    }
    let other = with_f_th(&engine, 4.5);
    edit(&mut engine, other);
    analysed(&mut engine);
}

#[test]
fn export_needs_an_analysis_and_a_known_ending() {
    let folder = tempfile::tempdir().unwrap();
    let export = |name: &str| Action::Export(vec![folder.path().join(name)], Existing::Ask);
    let mut engine = engine_with_files();
    engine.act(export("c.json"));
    last_notice(&engine, Level::Error, "no calibration");
    let analysis = analysed(&mut engine);
    engine.act(export("c.xlsx"));
    last_notice(&engine, Level::Error, "c.xlsx");
    for name in ["c.json", "c.CSV"] {
        engine.act(export(name));
        settle(&mut engine);
        last_notice(&engine, Level::Info, name);
        assert!(folder.path().join(name).exists());
    }
    let written = read_calibration(&folder.path().join("c.json")).unwrap();
    let recordings = &engine.project().recordings;
    let mut expected = with_sources(&analysis.calibration, recordings);
    expected.quality.free_coefficients = None; // no file keeps it
    assert_eq!(written, expected);
    assert_eq!(n_notices(&engine, Level::Error), 2);
    assert_eq!(engine.notices.len(), 4);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn each_exported_file_has_its_own_result() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let [written, failed, existing] = ["c.json", "gone/c.csv", "c.csv"].map(at);
    fs::write(&existing, "precious").unwrap();
    let mut engine = engine_with_files();
    analysed(&mut engine);
    let paths = [&written, &failed, &existing].map(Clone::clone).to_vec();
    engine.act(Action::Export(paths, Existing::Ask));
    settle(&mut engine);
    assert_eq!(engine.exported(&written), Some(&Ok(())));
    let reason = engine.exported(&failed).unwrap().clone().unwrap_err();
    assert!(reason.contains("gone"), "{reason}");
    assert_eq!(engine.exported(&existing), None, "the user is asked first");
    let (asked, doubt) = engine.replacing.as_ref().unwrap();
    assert_eq!((&asked.paths[..], *doubt), (&[existing.clone()][..], Doubt::IsThere));
    assert_eq!(fs::read_to_string(&existing).unwrap(), "precious");
    engine.act(Action::Replace(true));
    settle(&mut engine);
    assert!(engine.exported(&existing).unwrap().is_ok() && engine.exported(&failed).is_some());
    assert!(fs::read_to_string(&existing).unwrap().contains("S1_past"));
    edit(&mut engine, Edit::Notes("oiled".to_owned()));
    assert_eq!(engine.exported(&written), None, "the files are of an earlier document");
}

#[test]
fn an_applied_calibration_is_exported_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.json");
    let mut engine = engine_with_files();
    let calibration = Arc::clone(&analysed(&mut engine).calibration);
    open_calibration(&mut engine, &calibration);
    analysed(&mut engine);
    edit(&mut engine, Edit::Roles(vec![0], Role::Test));
    let rescored = analysed(&mut engine);
    assert_ne!(rescored.calibration.quality, calibration.quality);
    engine.act(Action::Export(vec![path.clone()], Existing::Ask));
    settle(&mut engine);
    let mut expected = (*calibration).clone();
    expected.quality.free_coefficients = None; // no file keeps it
    assert_eq!(read_calibration(&path).unwrap(), expected);
}

#[test]
fn a_fit_to_fewer_samples_than_coefficients_is_exported_only_after_a_yes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.json");
    let mut engine = engine();
    let short = recording_of(5, "a", Source::File("a".into()), &GAUGES, &FORCES);
    take_files(&mut engine, vec![read(short)]);
    analysed(&mut engine);
    for yes in [false, true] {
        engine.act(Action::Export(vec![path.clone()], Existing::Ask));
        let doubt = engine.replacing.as_ref().map(|(_, doubt)| *doubt);
        assert!(matches!(doubt, Some(Doubt::Undetermined(..))), "{doubt:?}");
        engine.act(Action::Replace(yes));
        settle(&mut engine);
        assert_eq!(path.exists(), yes);
    }
    engine.act(Action::Export(vec![path.clone()], Existing::Ask));
    engine.act(Action::Replace(true));
    settle(&mut engine);
    let doubt = engine.replacing.as_ref().map(|(_, doubt)| *doubt);
    assert_eq!(doubt, Some(Doubt::IsThere), "the user is also asked about an existing file");
}

#[test]
fn parts_that_a_format_leaves_out_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.inc");
    let mut engine = engine_with_files();
    analysed(&mut engine);
    engine.act(Action::Export(vec![path.clone()], Existing::Ask));
    last_notice(&engine, Level::Warning, "c.inc leaves out the compensation");
    settle(&mut engine);
    assert!(path.exists());
}

#[test]
fn the_end_of_writing_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let mut engine = engine();
    let content = FileContent::Bytes(Arc::from(*b"x"));
    let save = |path: &str| Action::Save(content.clone(), folder.path().join(path), Existing::Ask);
    engine.act(save("c.png"));
    settle(&mut engine);
    last_notice(&engine, Level::Info, "c.png");
    engine.act(save("nowhere/c.png"));
    settle(&mut engine);
    last_notice(&engine, Level::Error, "nowhere");
}

#[test]
fn a_file_that_is_there_is_replaced_only_after_a_yes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, "before").unwrap();
    let mut engine = engine();
    for yes in [false, true] {
        let content = FileContent::Bytes(Arc::from(*b"after"));
        engine.act(Action::Save(content, path.clone(), Existing::Ask));
        settle(&mut engine);
        assert!(engine.replacing.is_some());
        engine.act(Action::Replace(yes));
        assert!(engine.replacing.is_none());
        settle(&mut engine);
        let expected = if yes { "after" } else { "before" };
        assert_eq!(fs::read_to_string(&path).unwrap(), expected);
    }
}

#[test]
fn a_recording_is_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = write_recording(folder.path(), "a", true);
    let before = fs::read(&path).unwrap();
    let mut engine = engine();
    engine.act(Action::Open(vec![path.clone()]));
    settle(&mut engine);
    let content = FileContent::Bytes(Arc::from(*b"after"));
    engine.act(Action::Save(content, path.clone(), Existing::Replace));
    settle(&mut engine);
    last_notice(&engine, Level::Error, "a.csv");
    assert_eq!(fs::read(&path).unwrap(), before);
}

#[test]
fn notices_are_capped_oldest_first_and_can_be_dismissed() {
    let mut engine = engine();
    for at in 0..MAX_NOTICES + 5 {
        engine.act(Action::Notice(Notice::new(Level::Info, at.to_string())));
    }
    assert_eq!(engine.notices.len(), MAX_NOTICES);
    assert_eq!(engine.notices[0].text, "5");
    engine.act(Action::Dismiss(1));
    assert_eq!(engine.notices[1].text, "7");
    engine.act(Action::Dismiss(MAX_NOTICES));
    assert_eq!(engine.notices.len(), MAX_NOTICES - 1);
    engine.act(Action::DismissAll);
    assert!(engine.notices.is_empty());
}

#[test]
fn files_are_read_and_an_empty_list_does_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut engine = engine();
    assert!(engine.calibration_content().is_none(), "there is no fit yet");
    engine.act(Action::Open(Vec::new()));
    engine.act(Action::Cancel);
    assert!(!engine.is_busy());
    let files = ["b", "a"].map(|name| write_recording(folder.path(), name, true));
    engine.act(Action::Open(files.to_vec()));
    assert!(engine.is_busy());
    settle(&mut engine);
    assert_eq!(names(engine.project()), ["b", "a"]);
    let read = &engine.project().recordings.entries()[1].recording;
    assert_eq!(read.loads(), of_file("a", &GAUGES, &FORCES).loads());
    assert_eq!(engine.preferences.recent[0], files[1]);
    edit(&mut engine, Edit::New);
    engine.act(Action::Open(vec![folder.path().to_owned()]));
    settle(&mut engine);
    assert_eq!(names(engine.project()), ["a", "b"], "all files of the folder are opened");
}

#[test]
fn files_are_read_one_after_another_and_once_however_often_they_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut engine = engine();
    let files = ["b", "a"].map(|name| write_recording(folder.path(), name, true));
    for _ in 0..3 {
        for file in &files {
            engine.act(Action::Open(vec![file.clone()]));
        }
    }
    assert_eq!(engine.running().len(), 1, "one task runs at a time");
    settle(&mut engine);
    assert_eq!(names(engine.project()), ["b", "a"]);
    assert!(engine.notices.is_empty(), "{:?}", engine.notices);
    edit(&mut engine, Edit::New);
    engine.act(Action::Open(vec![files[0].clone()]));
    engine.act(Action::Open(vec![files[1].clone()]));
    engine.act(Action::Cancel);
    settle(&mut engine);
    let read = names(engine.project());
    assert!(!read.contains(&"a"), "waiting requests are dropped: {read:?}");
}

#[test]
fn a_gesture_is_one_step_also_where_files_are_opened_meanwhile() {
    let mut engine = engine_with_files();
    let first = f_th(&engine);
    engine.gesture = Some(1);
    for value in [1.0, 1.5, 2.0] {
        let other = with_f_th(&engine, value);
        edit(&mut engine, other);
    }
    open(&mut engine, &["c"]);
    engine.gesture = None;
    engine.act(Action::Undo);
    assert_eq!(names(engine.project()), ["a", "b", "test"]);
    assert_eq!(f_th(&engine), 2.0);
    engine.act(Action::Undo);
    assert_eq!(f_th(&engine), first);
    assert!(!engine.history.can_undo());
    engine.act(Action::Redo);
    engine.act(Action::Redo);
    assert_eq!(names(engine.project()).len(), 4);
    let calibration = &analysed(&mut engine).calibration;
    assert_eq!(calibration.features.look_backs[0].f_th, 2.0);
}

#[test]
fn taring_is_a_step_and_is_dropped_where_others_were_opened_meanwhile() {
    let mut engine = engine_with_files();
    let tare = Tare::Interval(0.0, 0.5);
    let untared = Arc::clone(&engine.project().recordings);
    engine.act(Action::Tare(vec![0], tare));
    settle(&mut engine);
    let tares = |engine: &Engine| -> Vec<_> {
        let entries = engine.project().recordings.entries().iter();
        entries.map(|entry| entry.recording.tare()).collect()
    };
    assert_eq!(tares(&engine), [Some(tare), None, None]);
    let tared = RecordingSet::clone(&engine.project().recordings);
    engine.act(Action::Undo);
    assert!(Arc::ptr_eq(&engine.project().recordings, &untared));
    open(&mut engine, &["c"]);
    engine.take_changed(&untared, tared, Vec::new());
    engine.take();
    assert_eq!(tares(&engine), [None; 4]);
    last_notice(&engine, Level::Warning, "Repeat the action");
    engine.act(Action::Tare(vec![0], Tare::Interval(8.0, 9.0)));
    settle(&mut engine);
    last_notice(&engine, Level::Error, "no sample from 8 s to 9 s");
    assert_eq!(tares(&engine), [None; 4]);
}

#[test]
fn requests_that_create_recordings_run_one_after_another() {
    let mut engine = engine_with_files();
    let folder = tempfile::tempdir().unwrap();
    let path = write_recording(folder.path(), "late", true);
    let tare = Tare::Interval(0.0, 0.5);
    engine.act(Action::Open(vec![path]));
    engine.act(Action::Tare(vec![1], tare));
    engine.act(Action::Tare(vec![2], tare));
    engine.act(Action::Edit(Edit::Remove(vec![0])));
    assert_eq!(engine.running().len(), 1);
    settle(&mut engine);
    let entries = engine.project().recordings.entries().iter();
    let tares: Vec<_> = entries.map(|entry| entry.recording.tare()).collect();
    assert_eq!(tares, [Some(tare), Some(tare), None]);
}

/// Returns a map for files of [`write_recording`] without column names.
fn nameless_map(found: &ColumnMap) -> ColumnMap {
    let mut map = found.clone();
    let gauges = GAUGES.map(|_| ColumnRole::Gauge);
    let loads = FORCES.map(ColumnRole::Load);
    let roles = [ColumnRole::Time].into_iter().chain(gauges).chain(loads);
    let columns = (1..).zip(roles);
    let columns = columns.map(|(number, is)| ColumnRule::new(ColumnKey::Number(number), is));
    map.table.columns = columns.collect();
    map
}

#[test]
fn a_file_that_needs_a_column_map_is_imported_and_its_map_is_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let [x, y] = ["x", "y"].map(|name| write_recording(folder.path(), name, false));
    let mut engine = engine_with_files();
    for path in [&x, &y] {
        engine.act(Action::Import(ImportCommand::Open(path.clone())));
    }
    settle(&mut engine);
    let importing = engine.importing.as_ref().expect("no names");
    assert_eq!(importing.path, x);
    assert_eq!(importing.waiting, std::slice::from_ref(&y));
    assert!(importing.inspection.is_some() && !importing.is_detecting);
    let import = Action::Import;
    let map = nameless_map(&importing.map);
    let other = ColumnMap { gap_secs: Some(3.0), ..map.clone() };
    // The last command counts, at any order of the answers.
    for map in [&other, &map] {
        engine.act(import(ImportCommand::SetMap(Box::new(map.clone()))));
    }
    engine.act(Action::Cancel);
    settle(&mut engine);
    let importing = engine.importing.as_ref().unwrap();
    assert!(!importing.is_detecting, "the inspection has ended");
    assert_eq!((importing.problem.as_deref(), &importing.map), (None, &map));
    engine.act(import(ImportCommand::Load));
    assert!(engine.importing.is_none());
    settle(&mut engine);
    assert_eq!(names(engine.project()), ["a", "b", "test", "x", "y"]);
    assert_eq!(engine.project().maps[&x], map);
    assert_eq!(engine.project().maps[&y], map, "y has the same shape, so it is read by the map");
    last_notice(&engine, Level::Info, "y.csv: read with the column map");
    assert_eq!(engine.preferences.maps, [map]);
}

#[test]
fn a_changed_column_map_reads_the_open_files_of_its_shape_again() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["x", "y"].map(|name| write_recording(folder.path(), name, false));
    let mut engine = engine();
    engine.act(Action::Open(paths.to_vec()));
    settle(&mut engine);
    engine.act(Action::Import(ImportCommand::Open(paths[0].clone())));
    settle(&mut engine);
    let map = nameless_map(&engine.importing.as_ref().unwrap().map);
    engine.act(Action::Import(ImportCommand::SetMap(Box::new(map.clone()))));
    settle(&mut engine);
    engine.act(Action::Import(ImportCommand::Load));
    settle(&mut engine);
    assert_eq!(names(engine.project()), ["x", "y"]);
    assert_eq!(engine.project().axes(), FORCES);
    assert!(paths.iter().all(|path| engine.project().maps[path] == map));
    // The page begins with the roles that the file has.
    engine.act(Action::Import(ImportCommand::Open(paths[1].clone())));
    settle(&mut engine);
    assert_eq!(engine.importing.as_ref().unwrap().map, map);
}

#[test]
fn a_reader_that_never_returns_is_abandoned_and_other_files_load() {
    let folder = tempfile::tempdir().unwrap();
    let sound = write_recording(folder.path(), "x", true);
    let path = folder.path().join("stuck.dat");
    fs::write(&path, stuck::SIGNATURE).unwrap();
    let begun_and_cancelled = [
        (Action::Open(vec![path.clone()]), Action::Cancel),
        (Action::Import(ImportCommand::Open(path)), Action::Import(ImportCommand::Cancel)),
    ];
    for (at, (begin, cancel)) in begun_and_cancelled.into_iter().enumerate() {
        let mut engine = engine_with_files();
        engine.act(begin);
        while stuck::N_STARTED.load(Ordering::SeqCst) == at {
            thread::sleep(Duration::from_millis(1));
        }
        engine.act(cancel);
        settle(&mut engine);
        last_notice(&engine, Level::Error, "stuck.dat");
        engine.act(Action::Open(vec![sound.clone()]));
        settle(&mut engine);
        assert_eq!(names(engine.project()), ["a", "b", "test", "x"]);
    }
}

#[test]
fn waiting_files_are_imported_one_after_another() {
    let wants = |path: &str| (path.into(), Ok(Opened::WantsMap));
    let mut engine = engine();
    let files = ["x", "y", "z"].map(wants).to_vec();
    take_files(&mut engine, files);
    let path = |engine: &Engine| engine.importing.as_ref().map(|own| own.path.clone());
    assert_eq!(path(&engine), Some("x".into()));
    engine.act(Action::Import(ImportCommand::Cancel));
    settle(&mut engine);
    assert_eq!(path(&engine), Some("y".into()));
    let importing = engine.importing.as_ref().unwrap();
    let problem = importing.problem.as_deref().unwrap_or_default();
    assert!(problem.starts_with("y"), "{problem}");
    engine.act(Action::Import(ImportCommand::CancelAll));
    assert_eq!(path(&engine), None);
    last_notice(&engine, Level::Info, "no columns were chosen: y, z");
}

#[test]
fn a_cancelled_queue_of_imports_names_some_files_and_counts_the_rest() {
    let mut engine = engine_with_files();
    let before = engine.project().recordings.clone();
    let wants = |at| {
        let path = format!("/data/{at}.dat").into();
        (path, Ok(Opened::WantsMap))
    };
    take_files(&mut engine, (0..40).map(wants).collect());
    engine.act(Action::Import(ImportCommand::CancelAll));
    last_notice(&engine, Level::Info, "0.dat, 1.dat");
    last_notice(&engine, Level::Info, "7.dat and 32 more");
    assert_eq!(engine.project().recordings, before, "the loaded recordings stay");
}

fn network(epochs: usize) -> FitSettings {
    let mut settings = FitSettings { regressor: Regressor::Network, ..FitSettings::default() };
    settings.network.hidden = vec![4];
    settings.network.epochs = epochs;
    settings
}

#[test]
fn a_training_is_shown_only_for_its_recordings_and_settings() {
    let mut engine = engine_with_files();
    engine.act(Action::Train);
    assert!(engine.lane::<Train>().running().is_none(), "a linear fit needs no training");
    edit(&mut engine, Edit::Settings(network(3)));
    assert!(analysed(&mut engine).calibration.learned.is_none());
    engine.act(Action::Train);
    settle(&mut engine);
    assert_eq!(engine.lane::<Train>().answer().unwrap().epoch.unwrap().epoch, 3);
    let trained = Arc::clone(engine.fitting().expect("it was trained"));
    let analysis = analysed(&mut engine);
    assert_eq!(analysis.calibration.learned, trained.learned);
    assert!(analysis.fitted);

    let other = with_f_th(&engine, 1.5);
    edit(&mut engine, other);
    assert!(engine.fitting().is_none());
    assert!(analysed(&mut engine).calibration.learned.is_none());
    engine.act(Action::Undo);
    assert!(Arc::ptr_eq(engine.fitting().unwrap(), &trained));
    edit(&mut engine, Edit::Roles(vec![0], Role::Off));
    assert!(engine.fitting().is_none());
    engine.act(Action::Undo);
    assert_eq!(analysed(&mut engine).calibration.learned, trained.learned);
}

#[test]
fn a_network_that_is_stopped_keeps_its_best_and_the_one_before_stays_until_then() {
    let mut engine = engine_with_files();
    edit(&mut engine, Edit::Settings(network(3)));
    engine.act(Action::Train);
    settle(&mut engine);
    let first = Arc::clone(engine.fitting().unwrap());
    edit(&mut engine, Edit::Settings(network(100_000)));
    engine.act(Action::Train);
    settle_until(&mut engine, "epochs", |engine| {
        let trained = engine.lane::<Train>().answer().filter(|own| own.calibration.is_none());
        trained.is_some_and(|own| own.epoch.is_some())
    });
    assert!(engine.lane::<Train>().running().is_some());
    engine.act(Action::Undo);
    assert!(Arc::ptr_eq(engine.fitting().unwrap(), &first));
    engine.act(Action::Redo);
    assert!(engine.fitting().is_none());
    engine.act(Action::StopTraining);
    settle(&mut engine);
    assert!(engine.fitting().is_some(), "the best network so far is kept");
    assert!(engine.notices.is_empty());
}

#[test]
fn a_training_that_fails_gives_the_reason() {
    let mut engine = engine_with_files();
    edit(&mut engine, Edit::Settings(network(3)));
    edit(&mut engine, Edit::AllRoles(Role::Test));
    engine.act(Action::Train);
    settle(&mut engine);
    last_notice(&engine, Level::Error, "Training: no recording is in the train role");
    assert!(engine.fitting().is_none());
}

#[test]
fn numbers_of_a_block_that_were_chosen_are_a_step() {
    let mut engine = engine_with_files();
    let before = engine.project().settings.clone();
    engine.act(Action::ChooseBlock(&Creep, None));
    settle(&mut engine);
    let chosen = engine.lane::<ChooseBlock>().answer().expect("a choice").clone();
    let features = &engine.project().settings.features;
    assert_eq!(features.blocks.of(&Creep), chosen.values);
    if engine.history.can_undo() {
        engine.act(Action::Undo);
    }
    assert_eq!(engine.project().settings, before);
    edit(&mut engine, Edit::AllRoles(Role::Test));
    engine.act(Action::ChooseBlock(&Play, None));
    settle(&mut engine);
    last_notice(&engine, Level::Error, "no recording is in the train role");
}

fn find_best(engine: &mut Engine) {
    engine.act(Action::FindBest(Candidates::All, Duration::from_secs(600)));
}

fn of_mark(engine: &Engine, mark: Mark) -> Vec<&Row> {
    let rows = engine.models.rows.iter();
    rows.filter(|row| row.mark == mark).collect()
}

#[test]
fn a_search_lists_its_models_and_using_one_is_one_step_of_undo() {
    let mut engine = engine_with_files();
    find_best(&mut engine);
    assert!(engine.is_trying());
    settle(&mut engine);
    assert_eq!(engine.models.rows[0].name, "Conventional");
    assert_eq!(of_mark(&engine, Mark::Proposed).len(), 1);
    assert!(engine.models.remarks[0].starts_with("Proposed: "), "{:?}", engine.models.remarks);
    let rows = engine.models.rows.iter();
    let scored = rows.filter_map(|row| row.model.scores.cv_rmse.as_ref());
    assert_eq!(scored.count(), engine.models.rows.len());
    assert!(engine.models.rows.iter().all(|row| !row.is_stale(engine.project())));

    // Full scales belong to the sensor and do not change with the model. A linear model is analysed at once.
    let mut settings = engine.project().settings.clone();
    settings.full_scale = vec![Some(40.0), None, None];
    edit(&mut engine, Edit::Settings(settings));
    let before = engine.project().clone();
    let (id, own) = {
        let row = engine.models.rows.iter().find(|row| row.name == "Polynomial of degree 2");
        let row = row.expect("tried");
        (row.id, row.model.settings.clone())
    };
    engine.act(Action::BringBack(id));
    assert_eq!(engine.project().settings.features, own.features);
    assert_eq!(engine.project().settings.full_scale, before.settings.full_scale);
    assert!(engine.models.row(id).unwrap().is_present(engine.project()));
    engine.act(Action::Undo);
    assert!(*engine.project() == before);
    engine.act(Action::Redo);
    assert_eq!(engine.project().settings.features, own.features);

    edit(&mut engine, Edit::Roles(vec![0], Role::Off));
    assert!(engine.models.rows.iter().all(|row| row.is_stale(engine.project())));
    engine.act(Action::Undo);
    assert!(engine.models.rows.iter().all(|row| !row.is_stale(engine.project())));
}

#[test]
fn a_cancelled_search_keeps_its_rows_and_the_next_replaces_them() {
    let mut engine = engine_with_files();
    find_best(&mut engine);
    settle_until(&mut engine, "two models", |engine| engine.models.rows.len() >= 2);
    engine.act(Action::StopTrying);
    settle(&mut engine);
    let n_rows = engine.models.rows.len();
    assert!(n_rows >= 2 && !engine.is_trying());

    let first = engine.models.rows[0].id;
    // Rows that are removed during a search are not added again.
    find_best(&mut engine);
    settle_until(&mut engine, "the next search", |engine| engine.models.row(first).is_none());
    let conventional = |engine: &Engine| {
        engine.models.rows.iter().find(|row| row.name == "Conventional").map(|row| row.id)
    };
    settle_until(&mut engine, "the first model", |engine| conventional(engine).is_some());
    let removed = conventional(&engine).unwrap();
    engine.act(Action::RemoveModel(removed));
    settle(&mut engine);
    let names: Vec<&str> = engine.models.rows.iter().map(|row| &*row.name).collect();
    assert!(!names.contains(&"Conventional"), "{names:?}");
}

#[test]
fn a_search_that_cannot_begin_gives_the_reason_and_keeps_the_list() {
    let mut engine = engine_with_files();
    engine.act(Action::KeepModel);
    last_notice(&engine, Level::Error, "no model to keep yet");
    settle(&mut engine);
    engine.act(Action::KeepModel);
    settle(&mut engine);
    edit(&mut engine, Edit::AllRoles(Role::Test));
    find_best(&mut engine);
    settle(&mut engine);
    last_notice(&engine, Level::Error, "no recording is in the train role");
    let rows = &engine.models.rows;
    assert_eq!((rows.len(), &*rows[0].name), (1, "Kept 1"));
}

#[test]
fn a_kept_model_can_be_used_again_with_its_training() {
    let mut engine = engine_with_files();
    edit(&mut engine, Edit::Settings(network(3)));
    settle(&mut engine);
    assert!(!engine.can_keep(), "there is no training for these settings");
    engine.act(Action::Train);
    settle(&mut engine);
    let trained = Arc::clone(engine.fitting().unwrap());
    engine.act(Action::KeepModel);
    settle(&mut engine);
    let kept = engine.models.rows.last().unwrap();
    assert!(kept.model.cost.coefficients > 0);
    let id = kept.id;
    // Another training replaces the first.
    edit(&mut engine, Edit::Settings(network(5)));
    engine.act(Action::Train);
    settle(&mut engine);
    engine.act(Action::BringBack(id));
    settle(&mut engine);
    assert_eq!(engine.fitting().unwrap().learned, trained.learned);
    assert!(engine.can_keep());
    edit(&mut engine, Edit::Roles(vec![0], Role::Off));
    assert!(engine.fitting().is_none(), "the training is of other recordings");
}

#[test]
fn a_search_through_the_models_of_the_paper_that_is_stopped_keeps_the_rows_that_ended() {
    let mut engine = engine_with_files();
    engine.act(Action::FindBest(Candidates::Paper, Duration::from_secs(600)));
    settle_until(&mut engine, "the linear models", |engine| engine.models.rows.len() >= 3);
    engine.act(Action::Cancel);
    settle(&mut engine);
    assert!(!engine.is_trying());
    let rows = &engine.models.rows;
    assert!(rows[..3].iter().all(|row| row.model.settings.regressor == Regressor::Linear));
    assert!(rows[2].model.settings.features.has_history());
    let table = engine.models.table(engine.project(), &ScoreSet::ALL);
    assert!(table.rows.iter().all(|row| row.len() == table.columns.len()));
}

fn session_file(path: &Path, session: Session, parts: Vec<SessionPart>) -> Vec<OpenedFile> {
    let opened = OpenedSession { session, parts, calibration: None, trained: None };
    let opened = Opened::Session(Box::new(opened));
    vec![(path.into(), Ok(opened))]
}

fn session_with_notes(notes: &str) -> Session {
    let project = Project { notes: notes.to_owned(), ..Project::default() };
    Session { project, ..Session::default() }
}

fn empty_session(name: &str) -> Vec<OpenedFile> {
    session_file(Path::new(name), session_with_notes(name), Vec::new())
}

#[track_caller]
fn save_session(engine: &mut Engine, path: &Path) {
    let content = engine.session_content();
    engine.act(Action::Save(content, path.to_owned(), Existing::Replace));
    settle(engine);
}

#[test]
fn the_title_has_a_star_while_there_are_unsaved_changes() {
    let folder = tempfile::tempdir().unwrap();
    let mut engine = engine();
    assert!(!engine.is_unsaved());
    open(&mut engine, &["a"]);
    assert_eq!(engine.title(), "LoopScope *");
    save_session(&mut engine, &folder.path().join("s.json"));
    last_notice(&engine, Level::Info, "Saved the session");
    assert_eq!(engine.title(), "s – LoopScope");
    engine.act(Action::Close);
    assert!(std::mem::take(&mut engine.closes));
    edit(&mut engine, Edit::Roles(vec![0], Role::Test));
    assert_eq!(engine.title(), "s * – LoopScope");
    engine.act(Action::Close);
    assert!(!engine.closes);
    assert!(matches!(engine.leaving, Some(Leaving::Close)), "the user is asked first");
    engine.act(Action::Undo);
    assert_eq!(engine.title(), "s – LoopScope", "the session is unchanged");
    edit(&mut engine, Edit::Notes("oiled".to_owned()));
    assert!(engine.is_unsaved());
    engine.act(Action::Discard);
    assert!(engine.closes);
}

#[test]
fn a_session_opened_over_unsaved_changes_waits_for_an_answer() {
    let folder = tempfile::tempdir().unwrap();
    let mut engine = engine();
    open(&mut engine, &["a"]);
    let before = engine.project().clone();
    for answer in [Action::Stay, Action::Discard] {
        take_files(&mut engine, empty_session("s.json"));
        assert!(matches!(engine.leaving, Some(Leaving::Open(_))));
        assert!(*engine.project() == before && engine.session.is_none());
        engine.act(answer);
        assert!(engine.leaving.is_none());
    }
    assert_eq!(engine.session.as_deref(), Some(Path::new("s.json")));
    assert!(engine.project().recordings.entries().is_empty());
    take_files(&mut engine, empty_session("t.json"));
    assert_eq!(engine.project().notes, "t.json", "nothing would be lost");

    open(&mut engine, &["a"]);
    take_files(&mut engine, empty_session("u.json"));
    assert_eq!(engine.project().notes, "t.json");
    save_session(&mut engine, &folder.path().join("t.json"));
    assert_eq!(engine.project().notes, "u.json", "the other session opens after saving");
    assert!(!engine.history.can_undo(), "a new session has no undo");
}

#[test]
fn a_session_replaces_all_loaded_data() {
    let mut engine = engine_with_files();
    analysed(&mut engine);
    let recording = of_file("other", &GAUGES, &FORCES);
    let part = SessionPart {
        file: SessionFile { absolute: "other".into(), ..SessionFile::default() },
        loaded: Some(Ok(Loaded { recordings: vec![recording], ..Loaded::default() })),
        changed: true,
    };
    take_files(&mut engine, session_file(Path::new("s.json"), Session::default(), vec![part]));
    engine.act(Action::Discard);
    assert_eq!(names(engine.project()), ["other"]);
    last_notice(&engine, Level::Warning, "other: the file has changed since");
    assert!(engine.analysis().is_none());
    assert_eq!(analysed(&mut engine).calibration.trained_on, ["other"]);
}

#[test]
fn a_session_of_the_built_in_sensor_is_unchanged_after_opening() {
    let mut engine = engine();
    let session = Session { built_in: true, cut: Some(0.75), ..Session::default() };
    take_files(&mut engine, session_file(Path::new("s.json"), session, Vec::new()));
    settle_until(&mut engine, "the built-in sensor", |engine| {
        !engine.project().recordings.entries().is_empty()
    });
    assert!(engine.project().recordings.is_simulated() && !engine.is_unsaved());
    let split = engine.project().split.as_ref();
    assert_eq!(split.map(|split| split.fraction), Some(0.75));
}

#[test]
fn a_session_of_a_set_with_a_lag_opens_that_set() {
    let mut engine = engine();
    engine.act(Action::OpenBuiltIn(Some(Late::Both)));
    settle_until(&mut engine, "the set", |engine| engine.project().recordings.is_simulated());
    let session = Session::of(engine.project());
    assert_eq!((session.built_in, session.built_in_lag), (true, Some(Late::Both)));
}

#[test]
fn autosaved_sessions_stay_until_they_are_restored_or_discarded() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(format!("{name}.json"));
    let left = |name: &str| LeftSession {
        path: path(name),
        written: SystemTime::UNIX_EPOCH,
        bytes: 4,
        session: Err("torn".to_owned()),
    };
    let mut engine = engine();
    open(&mut engine, &["a"]);
    for name in ["1", "2", "3"] {
        fs::write(path(name), "torn").unwrap();
        engine.recoverable.push(left(name));
    }
    engine.act(Action::DropLeft(path("2")));
    assert!(!path("2").exists());
    engine.act(Action::Restore(path("3")));
    settle(&mut engine);
    last_notice(&engine, Level::Error, "3.json");
    assert_eq!(engine.recoverable, [left("1"), left("3")]);
    let session = session_with_notes("text of a crashed window");
    fs::write(path("3"), session.to_json(folder.path())).unwrap();
    engine.act(Action::Restore(path("3")));
    settle(&mut engine);
    assert!(engine.leaving.is_some(), "session a is not saved");
    assert_eq!(engine.recoverable.len(), 2);
    engine.act(Action::Discard);
    assert_eq!(engine.recoverable, [left("1")]);
    assert!(path("3").exists() && path("1").exists());
    assert_eq!(engine.project().notes, "text of a crashed window");
    assert!(engine.session.is_none() && engine.is_unsaved());
    save_session(&mut engine, &path("saved"));
    engine.write_down();
    assert!(!path("3").exists(), "the restored file is removed once its content is saved");
    engine.act(Action::ShowLeft(false));
    assert_eq!(engine.recoverable, [left("1")]);
    assert!(path("1").exists());
}

#[test]
fn a_restored_session_of_the_built_in_sensor_is_not_saved_yet() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("autosave-1.json");
    let session = Session { built_in: true, ..session_with_notes("text of a crashed window") };
    fs::write(&path, session.to_json(folder.path())).unwrap();
    let mut engine = engine();
    engine.recover_in(folder.path());
    assert!(engine.shows_left && engine.recoverable.len() == 1);
    engine.act(Action::ShowLeft(false));
    engine.act(Action::ShowLeft(true));
    engine.act(Action::Restore(engine.recoverable[0].path.clone()));
    let deadline = Instant::now() + Duration::from_secs(60);
    // Only a complete session may replace the autosaved one.
    loop {
        engine.take();
        engine.write_down();
        if !path.exists() {
            break;
        }
        assert!(Instant::now() < deadline, "the autosaved session stays complete");
        thread::sleep(Duration::from_millis(1));
    }
    assert!(engine.is_unsaved() && engine.recoverable.is_empty());
    let [own] = &fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "json"))
        .collect::<Vec<_>>()[..]
    else {
        panic!("one autosaved session")
    };
    let own = Session::read(own).unwrap();
    assert!(own.built_in && own.project.notes == "text of a crashed window");
    engine.end();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

fn lost(name: &str) -> SessionPart {
    let file = SessionFile {
        absolute: format!("/gone/{name}.csv").into(),
        roles: [(name.to_owned(), Role::Test)].into(),
        ..SessionFile::default()
    };
    SessionPart { file, loaded: None, changed: false }
}

#[test]
fn a_moved_file_is_asked_for_and_keeps_its_role() {
    let folder = tempfile::tempdir().unwrap();
    let mut engine = engine();
    let parts = ["a", "b", "c"].map(lost).to_vec();
    take_files(&mut engine, session_file(Path::new("s.json"), Session::default(), parts));
    assert_eq!(engine.project().lost.len(), 3);
    engine.act(Action::Forget(1));
    engine.act(Action::Forget(7));
    // The two missing files are now in the folder, beside a file that was never missing.
    let [a, c, d] = ["a", "c", "d"].map(|name| write_recording(folder.path(), name, true));
    engine.act(Action::Open(vec![d]));
    engine.act(Action::Locate(folder.path().join("gone")));
    settle(&mut engine);
    last_notice(&engine, Level::Error, "none of the missing files");
    assert_eq!(engine.project().lost.len(), 2);
    // Naming one file also finds the other beside it.
    engine.act(Action::Locate(a));
    settle(&mut engine);
    assert!(engine.project().lost.is_empty() && c.exists());
    let entries = engine.project().recordings.entries();
    let role = |name: &str| {
        let entry = entries.iter().find(|entry| entry.recording.name() == name);
        entry.map(|entry| entry.role)
    };
    assert_eq!(
        ["a", "b", "c", "d"].map(role),
        [Some(Role::Test), None, Some(Role::Test), Some(Role::Train)]
    );
}

/// The folder was moved unchanged, but one file was replaced by another.
#[test]
fn a_session_whose_folder_moved_comes_back_whole_by_naming_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for day in ["old/day1", "old/day2"] {
        fs::create_dir_all(at(day)).unwrap();
    }
    let files = ["old/day1", "old/day2"].map(|day| write_recording(&at(day), "run", true));
    let mut engine = engine();
    engine.act(Action::Open(files.to_vec()));
    settle(&mut engine);
    engine.act(Action::Tare(vec![0], Tare::Interval(0.0, 0.5)));
    settle(&mut engine);
    let mut settings = engine.project().settings.clone();
    settings.full_scale = vec![Some(7.0)];
    for own in [
        Edit::Settings(settings),
        Edit::Roles(vec![1], Role::Test),
        Edit::Groups(vec![None, Some("mounted anew".to_owned())]),
    ] {
        edit(&mut engine, own);
    }
    save_session(&mut engine, &at("s.json"));
    let saved = engine.project().clone();
    fs::rename(at("old"), at("new")).unwrap();
    let changed = at("new/day2/run.csv");
    let text = fs::read_to_string(&changed).unwrap();
    let shorter: Vec<&str> = text.lines().take(30).collect();
    fs::write(&changed, shorter.join("\n")).unwrap();

    let mut engine = self::engine();
    engine.act(Action::Open(vec![at("s.json")]));
    settle(&mut engine);
    assert_eq!(engine.project().lost.len(), 2);
    engine.act(Action::Locate(at("new")));
    settle(&mut engine);
    last_notice(&engine, Level::Warning, "the file has changed since");
    let back = engine.project();
    assert!(back.lost.is_empty());
    assert_eq!(back.settings, saved.settings);
    let same = |at: usize| {
        let [now, then] = [back, &saved].map(|project| &project.recordings.entries()[at]);
        (now.role, &now.group) == (then.role, &then.group)
            && now.recording.tare() == then.recording.tare()
    };
    assert!(same(0) && same(1));
}

#[test]
fn a_split_comes_back_with_the_files_that_moved() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("old")).unwrap();
    let file = write_recording(&at("old"), "run", true);
    let mut engine = opened_again(&file);
    edit(&mut engine, Edit::Split(0.5));
    save_session(&mut engine, &at("s.json"));
    let names = names(engine.project());
    assert_eq!(names.len(), 2);
    fs::rename(at("old"), at("new")).unwrap();
    let mut back = opened_again(&at("s.json"));
    assert_eq!(n_notices(&back, Level::Error), 0);
    save_session(&mut back, &at("s.json"));
    let mut back = opened_again(&at("s.json"));
    back.act(Action::Locate(at("new")));
    settle(&mut back);
    assert_eq!(self::names(back.project()), names);
    let split = back.project().split.as_ref();
    assert_eq!(split.map(|split| split.fraction), Some(0.5));
}

/// Returns an engine with two recordings from files and a trained network, saved in the folder.
fn saved_with_training(folder: &Path) -> Engine {
    let files = ["a", "b"].map(|name| write_recording(folder, name, true));
    let mut engine = engine();
    engine.act(Action::Open(files.to_vec()));
    settle(&mut engine);
    edit(&mut engine, Edit::Settings(network(3)));
    save_session(&mut engine, &folder.join("s.json"));
    assert!(!engine.is_unsaved() && !folder.join("s.trained.json").exists());
    engine.act(Action::Train);
    settle(&mut engine);
    assert!(engine.is_unsaved(), "a new training is unsaved");
    save_session(&mut engine, &folder.join("s.json"));
    last_notice(&engine, Level::Info, "s.trained.json");
    assert!(!engine.is_unsaved());
    engine
}

#[track_caller]
fn opened_again(path: &Path) -> Engine {
    let mut engine = engine();
    engine.act(Action::Open(vec![path.to_owned()]));
    settle(&mut engine);
    engine
}

#[test]
fn a_trained_calibration_is_an_ordinary_file_and_comes_back_with_the_session() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let trained = saved_with_training(folder.path()).fitting().unwrap().clone();
    let beside = read_calibration(&at("s.trained.json")).unwrap();
    assert_eq!(beside.learned, trained.learned);
    let mut engine = opened_again(&at("s.json"));
    assert_eq!(engine.fitting().unwrap().learned, trained.learned);
    assert_eq!(analysed(&mut engine).calibration.learned, trained.learned);
    assert!(!engine.is_unsaved());
    assert_eq!(n_notices(&engine, Level::Warning), 0);
    // A linear fit needs no training, so there is no file beside the session.
    edit(&mut engine, Edit::Settings(FitSettings::default()));
    save_session(&mut engine, &at("linear.json"));
    assert!(!at("linear.trained.json").exists());
    let text = fs::read_to_string(at("linear.json")).unwrap();
    assert!(!text.contains("\"trained\""), "{text}");
}

#[test]
fn a_crash_costs_no_training() {
    let folder = tempfile::tempdir().unwrap();
    let left = folder.path().join("left");
    let mut crashed = saved_with_training(folder.path());
    crashed.recover_in(&left);
    let trained = crashed.fitting().unwrap().clone();
    crashed.act(Action::Edit(Edit::Notes("not saved".to_owned())));
    crashed.write_down();
    let deadline = Instant::now() + Duration::from_secs(60);
    let is_written = || fs::read_dir(&left).unwrap().count() == 3; // the lock and the pair
    while !is_written() {
        assert!(Instant::now() < deadline);
        thread::sleep(Duration::from_millis(1));
    }
    drop(crashed);
    let mut engine = engine();
    engine.recover_in(&left);
    assert_eq!(engine.recoverable.len(), 1, "session and training are one autosave");
    engine.act(Action::Restore(engine.recoverable[0].path.clone()));
    settle(&mut engine);
    assert_eq!(engine.project().notes, "not saved");
    assert_eq!(engine.fitting().unwrap().learned, trained.learned);
    // After this window is closed normally, neither autosave remains.
    engine.write_down();
    while engine.recoverable.iter().any(|own| own.path.exists())
        || fs::read_dir(&left).unwrap().count() != 3
    {
        assert!(Instant::now() < deadline);
        thread::sleep(Duration::from_millis(1));
    }
    engine.end();
    assert_eq!(fs::read_dir(&left).unwrap().count(), 0);
}

#[test]
fn a_trained_calibration_of_other_recordings_is_not_used_and_the_reason_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    saved_with_training(folder.path());
    let at = |name: &str| folder.path().join(name);
    let (session, beside) =
        ["s.json", "s.trained.json"].map(|name| fs::read_to_string(at(name)).unwrap()).into();
    let data = fs::read_to_string(at("b.csv")).unwrap();
    let check = |reason: &str| {
        let engine = opened_again(&at("s.json"));
        let mut texts = engine.notices.iter().map(|notice| &notice.text);
        assert!(texts.any(|text| text.contains(reason)), "{reason}: {:?}", engine.notices);
        assert!(engine.fitting().is_none());
        assert_eq!(engine.project().recordings.entries().len(), 2);
    };
    let no_rows = beside.replacen("\"matrix\": [", "\"matrix\": [[],", 1);
    for torn in ["", "5", "{}", &no_rows] {
        fs::write(at("s.trained.json"), torn).unwrap();
        check("has to be trained again");
    }
    let renamed = beside.replace("\"S1\"", "\"S9\"");
    fs::write(at("s.trained.json"), renamed).unwrap();
    check("it has other gauges or axes");
    fs::write(at("s.trained.json"), &beside).unwrap();
    fs::write(at("s.json"), session.replace("\"train\"", "\"off\"")).unwrap();
    check("recording a or its role has changed");
    fs::write(at("s.json"), &session).unwrap();
    let (first, last) = data.trim_end().rsplit_once('\n').unwrap();
    let cells = last.rsplit_once(',').unwrap().0;
    fs::write(at("b.csv"), format!("{first}\n{cells},0.125\n")).unwrap();
    check("recording b or its role has changed");
}

/// A trained calibration that cannot be checked yet stays beside the session, until its recordings are found.
#[test]
fn a_trained_calibration_waits_for_files_that_moved() {
    let folder = tempfile::tempdir().unwrap();
    let trained = saved_with_training(folder.path()).fitting().unwrap().clone();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("moved")).unwrap();
    fs::rename(at("b.csv"), at("moved/b.csv")).unwrap();
    let mut engine = opened_again(&at("s.json"));
    assert!(engine.fitting().is_none());
    save_session(&mut engine, &at("t.json"));
    let mut engine = opened_again(&at("t.json"));
    engine.act(Action::Locate(at("moved")));
    settle(&mut engine);
    assert_eq!(engine.fitting().unwrap().learned, trained.learned);
}

#[test]
fn a_saved_session_opens_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["a", "b", "test"].map(|name| write_recording(folder.path(), name, true));
    let path = folder.path().join("s.json");
    let mut engine = engine();
    engine.act(Action::Open(files.to_vec()));
    settle(&mut engine);
    engine.act(Action::Tare(vec![1], Tare::Interval(0.0, 0.5)));
    settle(&mut engine);
    let greatest = engine.project().recordings.entries()[0].recording.gauges();
    let greatest = greatest.iter().copied().fold(0.0, f64::max);
    edit(&mut engine, Edit::GaugeRange(Some(GaugeRange::All((-1e3, greatest)))));
    engine.act(Action::LeaveOutFaulty);
    settle(&mut engine);
    let first = &engine.project().recordings.entries()[0].recording;
    assert!(first.left_out().is_some_and(|own| own.n_samples > 0));
    let other = with_f_th(&engine, 0.125);
    for own in [Edit::Roles(vec![0], Role::Off), other, Edit::Notes("oiled".to_owned())] {
        edit(&mut engine, own);
    }
    engine.act(Action::Show(View::All));
    save_session(&mut engine, &path);
    let saved = engine.project().clone();
    let calibration = analysed(&mut engine).calibration.clone();
    edit(&mut engine, Edit::New);

    engine.act(Action::Open(vec![path.clone()]));
    settle(&mut engine);
    engine.act(Action::Discard);
    let back = engine.project();
    assert_eq!(back.recordings, saved.recordings);
    assert_eq!((&back.settings, back.view), (&saved.settings, saved.view));
    assert_eq!(back.notes, saved.notes);
    assert!(!engine.is_unsaved());
    assert_eq!(engine.session, Some(path));
    assert_eq!(analysed(&mut engine).calibration, calibration);
    assert_eq!(n_notices(&engine, Level::Warning), 0);
}
