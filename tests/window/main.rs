//! Tests of the window without a display. Widgets are found by role and label, as screen readers find them.

mod any_table;
#[path = "../support/dropped.rs"]
mod dropped;
mod explained;
mod heard;
mod importing;
mod keyboard;
mod sessions;
mod workspace;

use std::cell::RefCell;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui::{Key, Modifiers, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use dropped::Dropped;
use loopscope::calibration::{Regressor, RidgeChoice};
use loopscope::engine::{Action, Edit, Engine, ImportCommand, Level, Preferences};
use loopscope::export::{read_calibration, with_sources, write_calibration};
use loopscope::features::{Column, Creep, Play, Polynomial};
use loopscope::questions::thresholds::asked::{ChooseBlock, StudyThresholds};
use loopscope::questions::{Analysis, View};
use loopscope::recording;
use loopscope::recording::{Axis, Missing};
use loopscope::ui::{Command, Dialogs, PathFor, Reply, Shell, chosen};

/// Time after which a test fails because the window hangs, long enough for slow machines.
const DEADLINE: Duration = Duration::from_secs(180);

/// Window with its shell. The shell is created in the first frame, because it needs egui's context.
type Window = Harness<'static, Option<Shell>>;

/// File dialogs that return prepared paths instead of asking a user.
#[derive(Clone, Default)]
struct Choices {
    open: Rc<RefCell<Vec<PathBuf>>>,
    export: Rc<RefCell<Option<PathBuf>>>,
}

impl Dialogs for Choices {
    fn ask(&mut self, what: PathFor, reply: Reply) {
        let paths = match what {
            PathFor::Save(_) => self.export.borrow().iter().cloned().collect(),
            _ => self.open.borrow().clone(),
        };
        if let Some(command) = chosen(what, paths) {
            reply.send(command);
        }
    }
}

fn window_with(files: Vec<PathBuf>, choices: Choices) -> Window {
    window_of(files, choices, Preferences::default())
}

fn window_of(files: Vec<PathBuf>, choices: Choices, preferences: Preferences) -> Window {
    let mut window = Harness::builder().with_size([1400.0, 1000.0]).build_ui_state(
        move |ui, shell: &mut Option<Shell>| {
            shell
                .get_or_insert_with(|| {
                    Shell::new(ui.ctx(), files.clone(), Box::new(choices.clone()))
                        .with_preferences(preferences.clone())
                })
                .frame(ui);
        },
        None,
    );
    settle(&mut window);
    window.key_press(Key::Num0); // all axes
    settle(&mut window);
    window
}

fn window(files: Vec<PathBuf>) -> Window {
    window_with(files, Choices::default())
}

fn shell(window: &Window) -> &Shell {
    window.state().as_ref().expect("the shell is made in the first frame")
}

fn state(window: &Window) -> &Engine {
    shell(window).engine()
}

#[track_caller]
fn analysis(window: &Window) -> Arc<Analysis> {
    let state = state(window);
    let analysis = state.analysis().cloned();
    analysis.unwrap_or_else(|| panic!("{:?} {:?}", state.problem(), state.notices))
}

/// Draws frames until the condition is true.
#[track_caller]
fn until(window: &mut Window, condition: impl Fn(&Shell) -> bool) {
    let start = Instant::now();
    loop {
        window.step();
        if condition(shell(window)) {
            return;
        }
        assert!(start.elapsed() < DEADLINE, "{:?}", state(window).notices);
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Draws frames until no background work remains.
#[track_caller]
fn settle(window: &mut Window) {
    loop {
        until(window, |shell| !shell.is_busy());
        window.step(); // takes finished work, which may start more
        if !shell(window).is_busy() {
            break;
        }
    }
    window.step();
}

#[track_caller]
fn click(window: &mut Window, role: Role, label: &str) {
    window.get_by_role_and_label(role, label).click();
    settle(window);
}

/// Clicks the topmost of several widgets with this label.
#[track_caller]
fn click_first(window: &mut Window, role: Role, label: &str) {
    let found = window.query_all_by_role_and_label(role, label);
    let topmost = found.min_by(|a, b| a.rect().min.y.total_cmp(&b.rect().min.y));
    topmost.unwrap_or_else(|| panic!("no {label}")).click();
    settle(window);
}

#[track_caller]
fn slide(window: &mut Window, slider: &str, value: f64) {
    let slider = window.get_by_role_and_label(Role::Slider, slider);
    slider.set_value_accesskit(value);
    settle(window);
}

/// Replaces the text of a text field.
#[track_caller]
fn type_into(window: &mut Window, field: &str, text: &str) {
    window.get_by_role_and_label(Role::TextInput, field).focus();
    window.step();
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(egui::Event::Text(text.to_owned()));
    window.step();
}

/// Replaces the value of a number field.
#[track_caller]
fn type_number(window: &mut Window, field: &str, text: &str) {
    window.get_by_role_and_label(Role::SpinButton, field).click();
    window.step();
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(egui::Event::Text(text.to_owned()));
    window.key_press(Key::Enter);
    settle(window);
}

#[track_caller]
fn menu(window: &mut Window, menu: &str, item: &str) {
    click(window, Role::Button, menu);
    window.get_by_label_contains(item).click();
    settle(window);
}

fn has(window: &Window, text: &str) -> bool {
    window.query_all_by_label_contains(text).next().is_some()
}

fn panes(window: &Window, label: &str) -> usize {
    let panes = window.query_all_by_role_and_label(Role::GraphicsObject, label);
    panes.count()
}

#[track_caller]
fn message(window: &mut Window, level: Level, part: &str) {
    let notices = &state(window).notices;
    let found =
        |notice: &loopscope::engine::Notice| notice.level == level && notice.text.contains(part);
    assert!(notices.iter().any(found), "no {part:?} in {notices:?}");
    // Older notices are only in the list of all notices.
    let is_gone = !has(window, part);
    let list = |window: &mut Window| {
        if is_gone {
            let shell = window.state_mut().as_mut().unwrap();
            shell.send(Command::ToggleNotices);
            settle(window);
        }
    };
    list(window);
    assert!(has(window, part), "{part:?} is not on screen");
    list(window);
}

/// Shows this pane. Changes to a workspace that contains the pane.
fn show(window: &mut Window, pane: &str) {
    let shell = window.state_mut().as_mut().unwrap();
    shell.send(Command::ShowPane(workspace::named(pane)));
    settle(window);
}

/// Types a path for this purpose.
#[track_caller]
fn type_path(window: &mut Window, what: PathFor, path: &str) {
    let title = what.title();
    window.state_mut().as_mut().unwrap().send(Command::TypePath(what));
    settle(window);
    type_into(window, title, path);
}

/// Opens a file by its path.
#[track_caller]
fn load(window: &mut Window, path: &str) {
    type_path(window, PathFor::Open, path);
    click(window, Role::Button, "Open");
}

/// Shows this pane alone.
fn maximize(window: &mut Window, pane: &str) {
    show(window, pane);
    let shell = window.state_mut().as_mut().unwrap();
    // A pane in no workspace is shown alone.
    if shell.on_screen().len() > 1 {
        shell.send(Command::ToggleMaximized(Some(workspace::named(pane))));
        settle(window);
    }
}

fn names(window: &Window) -> Vec<String> {
    let entries = state(window).project().recordings.entries().iter();
    entries.map(|entry| entry.recording.name().to_owned()).collect()
}

fn train_rmse(window: &Window) -> [Vec<f64>; 2] {
    let quality = &analysis(window).calibration.quality;
    [&quality.conventional, &quality.compensated]
        .map(|scores| scores.train_rmse.clone().expect("there are training samples"))
}

struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).expect("written");
        path
    }

    /// Writes a recording with hysteresis at 20 Hz: gauges S1 to S3, and a reference with these axes. Returns its path.
    fn recording(&self, name: &str, phase: f64, n: usize, axes: &[Axis]) -> PathBuf {
        let mut text = "t [s],S1,S2,S3".to_owned();
        for axis in axes {
            write!(text, ",{} [{}]", axis.symbol(), axis.unit()).unwrap();
        }
        let mut drag = [0.0_f64; 3];
        for k in 0..n {
            let t = k as f64 / 20.0;
            let load = [0.9, 1.3, 1.7].map(|rate| 6.0 * (rate * t + phase).sin());
            write!(text, "\n{t}").unwrap();
            for at in 0..3 {
                drag[at] = drag[at].clamp(load[at] - 1.5, load[at] + 1.5);
                let noise = 0.002 * ((k * k + 7 * k * at) % 11) as f64;
                let other = 0.1 * load[(at + 1) % 3];
                write!(text, ",{}", load[at] + 0.2 * drag[at] + other + noise).unwrap();
            }
            for value in &load[..axes.len()] {
                write!(text, ",{value}").unwrap();
            }
        }
        self.write(name, &text)
    }

    /// Writes two training recordings and one test recording. Returns their paths.
    fn three(&self) -> Vec<PathBuf> {
        [("a.csv", 0.0), ("b.csv", 1.0), ("test_c.csv", 2.0)]
            .map(|(name, phase)| self.recording(name, phase, 400, &FORCES))
            .to_vec()
    }
}

const FORCES: [Axis; 3] = [Axis::Fx, Axis::Fy, Axis::Fz];

#[test]
fn it_starts_on_the_built_in_sensor_and_every_widget_has_a_name() {
    let mut window = window(Vec::new());
    assert!(state(&window).project().recordings.is_simulated());
    let (bench, paper): (Vec<_>, Vec<_>) =
        (names(&window).into_iter()).partition(|name| name.starts_with("bench_"));
    assert_eq!((paper.len(), bench.len()), (90, 6));
    assert!(analysis(&window).fitted);
    window.check_accessibility();
    for heading in ["Errors (RMSE)", "Look-back", "Uncompensated"] {
        assert!(has(&window, heading), "{heading}");
    }
    assert!(has(&window, "Compensation halves the error: "));
    for axis in Axis::ALL {
        assert_eq!(panes(&window, &format!("{} [{}]", axis.symbol(), axis.unit())), 1);
    }
    assert!(panes(&window, "error [N]") > 0);

    let errors = |window: &Window| analysis(window).calibration.quality.compensated.cv_rmse.clone();
    let (settings, before) = (state(&window).project().settings.clone(), errors(&window).unwrap());
    window.key_press(Key::R);
    settle(&mut window);
    assert!(!state(&window).project().settings.features.blocks.of(&Play).is_empty());
    let after = errors(&window).unwrap();
    assert!(after.iter().zip(&before).all(|(after, before)| after < before), "{after:?}");
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(state(&window).project().settings, settings, "the remedy is one step");
}

#[test]
fn the_sliders_set_the_thresholds_and_without_a_past_comp_equals_conv() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "settings");
    let [conventional, before] = train_rmse(&window);
    assert_ne!(conventional, before);

    slide(&mut window, "F_th", 1.5);
    assert_eq!(analysis(&window).calibration.features.look_backs[0].f_th, 1.5);
    assert_eq!(analysis(&window).traces.thresholds.unwrap().f_th, 1.5);
    let [same, after] = train_rmse(&window);
    assert_eq!(same, conventional);
    assert_ne!(after, before);

    slide(&mut window, "t_th", 0.5);
    assert_eq!(analysis(&window).calibration.features.look_backs[0].t_th_secs, 0.5);
    assert_ne!(train_rmse(&window)[1], after);

    slide(&mut window, "F_th", 0.0);
    assert_eq!(train_rmse(&window)[1], conventional);
    click(&mut window, Role::Button, "Reset to 3 N, 15 s");
    assert_eq!(train_rmse(&window), [conventional.clone(), before]);
    slide(&mut window, "t_th", 0.0);
    assert_eq!(train_rmse(&window)[1], conventional);
}

#[test]
fn a_typed_threshold_may_exceed_the_slider_but_not_be_negative() {
    let files = Files::new();
    let mut window = window(files.three());
    for (typed, expected) in [("2.64", 2.64), ("500", 500.0), ("-1", 0.0)] {
        let field = window.get_by_role_and_label(Role::SpinButton, "F_th");
        field.click();
        window.step();
        window.key_press_modifiers(Modifiers::COMMAND, Key::A);
        window.event(egui::Event::Text(typed.to_owned()));
        window.key_press(Key::Enter);
        settle(&mut window);
        assert_eq!(analysis(&window).calibration.features.look_backs[0].f_th, expected, "{typed}");
    }
}

#[test]
fn many_quick_moves_of_a_slider_end_with_the_newest() {
    let files = Files::new();
    let mut window = window(files.three());
    for step in 1..=40 {
        let slider = window.get_by_role_and_label(Role::Slider, "F_th");
        slider.set_value_accesskit(f64::from(step) * 0.125);
        window.step();
    }
    settle(&mut window);
    assert_eq!(state(&window).project().settings.features.look_backs[0].f_th, 5.0);
    assert_eq!(analysis(&window).calibration.features.look_backs[0].f_th, 5.0);
}

#[test]
fn offset_and_full_scale_distance_are_choices_of_the_fit() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "settings");
    assert!(analysis(&window).calibration.offset);
    click(&mut window, Role::CheckBox, "Offset term");
    let without = analysis(&window);
    assert!(!without.calibration.offset);
    assert_eq!(without.calibration.conventional.columns, [0, 1, 2].map(Column::Gauge));

    click(&mut window, Role::RadioButton, "all axes [% FS]");
    let over_full_scale = analysis(&window);
    assert_eq!(over_full_scale.calibration.features.look_backs[0].f_th, 0.25);
    slide(&mut window, "F_th", 50.0);
    assert_eq!(analysis(&window).calibration.features.look_backs[0].f_th, 0.5);
    click(&mut window, Role::Button, "Reset to 25 % FS, 15 s");
    assert_eq!(
        train_rmse(&window)[1],
        over_full_scale.calibration.quality.compensated.train_rmse.clone().unwrap()
    );
}

#[test]
fn pattern_b_trains_on_every_tenth_sample() {
    let mut window = window(Vec::new());
    show(&mut window, "settings");
    assert_eq!(analysis(&window).calibration.quality.n_train, 202_500);
    click(&mut window, Role::Button, "B");
    assert_eq!(analysis(&window).calibration.quality.n_train, 20_250);
    assert!(has(&window, "20250 samples"));
    click(&mut window, Role::Button, "A");
    assert_eq!(analysis(&window).calibration.quality.n_train, 202_500);
}

#[test]
fn a_role_is_chosen_from_the_menu_in_the_row() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "recordings");
    // The table of errors, at the right, has a button of this name too.
    let found = window.query_all_by_role_and_label(Role::Button, "Train");
    let role = found.min_by(|a, b| a.rect().min.x.total_cmp(&b.rect().min.x));
    role.expect("a role").click();
    settle(&mut window);
    click(&mut window, Role::RadioButton, "Test");
    let roles: Vec<_> =
        state(&window).project().recordings.entries().iter().map(|entry| entry.role).collect();
    use recording::Role::{Test, Train};
    assert_eq!(roles, [Test, Train, Test]);
    let quality = &analysis(&window).calibration.quality;
    assert_eq!((quality.n_train, quality.n_test), (400, 800));
    menu(&mut window, "Edit", "Use all for training");
    assert_eq!(analysis(&window).calibration.quality.n_train, 1200);
}

#[test]
fn keys_set_the_role_of_all_selected_recordings() {
    use recording::Role::{Off, Test, Train};
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "recordings");
    click_first(&mut window, Role::Button, "a");
    let first = window.query_all_by_role_and_label(Role::Button, "test_c").next();
    first.expect("a row").click_modifiers(Modifiers::COMMAND);
    settle(&mut window);
    let roles = |window: &Window| {
        let entries = state(window).project().recordings.entries().iter();
        entries.map(|entry| entry.role).collect::<Vec<_>>()
    };
    for (key, role) in [(Key::O, Off), (Key::E, Test), (Key::T, Train)] {
        window.key_press(key);
        settle(&mut window);
        assert_eq!(roles(&window), [role, Train, role], "{key:?}");
    }
    ctrl_z(&mut window);
    assert_eq!(roles(&window), [Test, Train, Test], "one step of undo for both");
}

fn ctrl_z(window: &mut Window) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(window);
}

#[test]
fn recordings_of_the_built_in_sensor_are_listed_by_group() {
    let mut window = window(Vec::new());
    show(&mut window, "recordings");
    let rows = |window: &Window, label: &str| {
        window.query_all_by_role_and_label(Role::Button, label).count()
    };
    let group = |mark| format!("{mark} path 6 (15)");
    assert_eq!((rows(&window, &group("▸")), rows(&window, "test_path6_mount1_fast")), (1, 0));
    click(&mut window, Role::Button, &group("▸"));
    assert_eq!((rows(&window, &group("▾")), rows(&window, "test_path6_mount1_fast")), (1, 1));
    type_into(&mut window, "Filter", "mount3");
    assert_eq!((rows(&window, "▾ path 1 (3)"), rows(&window, "train_path1_mount3_fast")), (1, 1));
}

#[test]
fn without_a_training_recording_the_window_offers_a_remedy() {
    let files = Files::new();
    let mut window = window(files.three());
    menu(&mut window, "Edit", "Exclude all");
    assert!(state(&window).problem().is_some());
    assert!(has(&window, "no recording is in the train role"));
    menu(&mut window, "Edit", "Use all for training");
    assert_eq!(state(&window).problem(), None);
}

#[test]
fn a_press_on_a_name_puts_the_recording_on_screen() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "recordings");
    click_first(&mut window, Role::Button, "b");
    assert_eq!(state(&window).project().view, View::One(1));
    let traces = Arc::clone(&analysis(&window).traces);
    assert_eq!((traces.segments.len(), traces.segments[0].name.as_str()), (1, "b"));

    window.key_press(Key::Escape);
    settle(&mut window);
    click(&mut window, Role::ComboBox, "Recording");
    click(&mut window, Role::Button, "All, one after the other");
    assert_eq!(state(&window).project().view, View::All);
    assert_eq!(analysis(&window).traces.segments.len(), 3);
    assert_eq!(analysis(&window).traces.times.len(), 1200);
}

#[test]
fn closing_a_recording_removes_it_from_the_fit() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "recordings");
    click_first(&mut window, Role::Button, "a");
    window.key_press(Key::Delete);
    settle(&mut window);
    assert_eq!(names(&window), ["b", "test_c"]);
    assert_eq!(analysis(&window).calibration.trained_on, ["b"]);
    window.key_press_modifiers(Modifiers::COMMAND, Key::N);
    settle(&mut window);
    assert_eq!(names(&window), ["b", "test_c"], "the user is asked about unsaved changes");
    click(&mut window, Role::Button, "Discard");
    assert!(names(&window).is_empty());
    assert!(has(&window, "No recordings yet"));
    menu(&mut window, "File", "Built-in sensor (simulated)");
    assert!(state(&window).project().recordings.is_simulated());
    assert!(analysis(&window).calibration.simulated);
}

#[test]
fn the_table_of_errors_chooses_the_axes_on_screen() {
    let files = Files::new();
    let mut window = window_of(files.three(), Choices::default(), Preferences::default());
    let shown = |window: &Window| {
        ["Fx [N]", "Fy [N]", "Fz [N]", "error [N]"].map(|label| panes(window, label))
    };
    window.key_press(Key::Num2);
    settle(&mut window);
    assert_eq!(shown(&window), [0, 1, 0, 1], "one axis is large");
    click(&mut window, Role::RadioButton, "Fx [N]");
    assert_eq!(shown(&window), [1, 0, 0, 1]);
    window.key_press_modifiers(Modifiers::SHIFT, Key::Num3);
    settle(&mut window);
    assert_eq!(shown(&window), [1, 0, 1, 2]);
    window.key_press(Key::Num0);
    settle(&mut window);
    assert_eq!(shown(&window), [1, 1, 1, 3]);
}

#[test]
fn recordings_are_cut_in_time_and_put_together_again() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "recordings");
    assert!(window.query_by_role_and_label(Role::Button, "Undo split").is_none());
    click(&mut window, Role::Button, "Split");
    assert_eq!(names(&window).len(), 6);
    let quality = &analysis(&window).calibration.quality;
    assert_eq!((quality.n_train, quality.n_test), (720, 480));
    click(&mut window, Role::Button, "Undo split");
    assert_eq!(names(&window), ["a", "b", "test_c"]);
    assert_eq!(analysis(&window).calibration.quality.n_train, 800);
}

#[test]
fn files_are_opened_by_menu_shortcut_drop_and_path() {
    let files = Files::new();
    let choices = Choices::default();
    let mut window = window_with(vec![], choices.clone());
    let open = |name: &str| files.recording(name, 0.3, 100, &FORCES);

    choices.open.replace(vec![open("menu.csv"), open("test_menu.csv")]);
    menu(&mut window, "File", "Open…");
    assert_eq!(names(&window), ["menu", "test_menu"], "files replace the built-in sensor");

    choices.open.replace(vec![open("key.csv")]);
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    settle(&mut window);

    let dropped = Arc::new(Dropped(open("drop.csv")));
    window.input_mut().dropped_files.push(dropped);
    settle(&mut window);

    load(&mut window, open("load.csv").to_str().unwrap());

    type_path(&mut window, PathFor::Open, open("enter.csv").to_str().unwrap());
    window.key_press(Key::Enter);
    settle(&mut window);

    assert_eq!(names(&window), ["menu", "test_menu", "key", "drop", "load", "enter"]);
    assert_eq!(analysis(&window).recordings.len(), 6);
    let notices = &state(&window).notices;
    assert!(notices.iter().all(|notice| notice.level == Level::Info), "{notices:?}");
}

#[test]
fn recordings_opened_while_the_built_in_sensor_is_made_stay() {
    let files = Files::new();
    let mut window = window(files.three());
    let shell = window.state_mut().as_mut().unwrap();
    shell.send(Action::OpenBuiltIn(None));
    shell.send(Action::Open(vec![files.recording("d.csv", 0.5, 10, &FORCES)]));
    until(&mut window, |shell| shell.engine().project().recordings.entries().len() != 3);
    settle(&mut window);
    // The window shows the file that was requested last, even if the other file was read earlier.
    assert_eq!(names(&window).last().unwrap(), "d");
    assert!(!state(&window).project().recordings.is_simulated());
}

#[test]
fn files_that_do_not_fit_are_reported_and_lose_nothing() {
    let files = Files::new();
    let mut window = window(files.three());
    let broken = files.write("broken.csv", "t,S1,Fx\nno,recording,this\n");
    let other = files.write("other.csv", "t,G1,Fx\n0,1,2\n1,2,3\n");
    let json = files.write("broken.json", "{\"format\": 1}");
    for (path, part) in [
        (broken, "broken.csv"),
        (other, "the gauges are G1"),
        (json, "not a calibration"),
        (files.path("missing.csv"), "missing.csv"),
    ] {
        load(&mut window, path.to_str().unwrap());
        message(&mut window, Level::Error, part);
        click(&mut window, Role::Button, "Dismiss all");
        assert!(state(&window).notices.is_empty());
    }
    assert_eq!(names(&window), ["a", "b", "test_c"]);
    assert!(analysis(&window).fitted);
    assert_eq!(state(&window).problem(), None);
}

#[test]
fn an_exported_calibration_reads_back_and_is_applied_until_fit_again() {
    let files = Files::new();
    let mut window = window(files.three());
    let fitted = analysis(&window);
    let path = files.path("calibration.json");
    show(&mut window, "export");
    type_into(&mut window, "Export to", path.to_str().unwrap());
    click(&mut window, Role::Button, "Write 1 file");
    message(&mut window, Level::Info, "calibration.json");
    let written = read_calibration(&path).unwrap();
    let recordings = &state(&window).project().recordings;
    let mut expected = with_sources(&fitted.calibration, recordings);
    expected.quality.free_coefficients = None; // not stored in files
    assert_eq!(written, expected);
    assert!(written.sources.iter().all(|used| used.sha256.is_some()));

    window.key_press(Key::F3);
    settle(&mut window);
    load(&mut window, path.to_str().unwrap());
    show(&mut window, "recordings");
    assert!(has(&window, "Applying "));
    assert!(!analysis(&window).fitted);
    let slider = window.get_by_role_and_label(Role::Slider, "F_th");
    assert!(slider.accesskit_node().is_disabled(), "an applied calibration fixes the thresholds");

    window.run_steps(10);
    click(&mut window, Role::Button, "Fit again");
    assert!(!has(&window, "Applying "));
    let again = analysis(&window);
    assert!(again.fitted);
    assert_eq!(again.calibration, fitted.calibration);
    window.run_steps(10);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert!(has(&window, "Applying "), "the calibration is applied again");
    assert!(!analysis(&window).fitted);
}

/// The load changes every two seconds, and the gauge creeps by as much as the load. Directly after a start, the creep is unknown.
#[test]
fn a_load_fades_in_whose_cold_start_is_worse() {
    let files = Files::new();
    let mut numbers = 1_u64;
    let paths = ["a.csv", "b.csv", "c.csv", "d.csv"].map(|name| {
        let (mut slow, mut load) = (0.0, 0.0);
        let mut text = "t [s],S1,Fz [N]".to_owned();
        for k in 0..1200 {
            if k % 20 == 0 {
                numbers = numbers.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                load = (numbers >> 33) as f64 / f64::from(1_u32 << 27) - 8.0;
            }
            slow += (load - slow) * 0.01;
            write!(text, "\n{},{},{load}", 0.1 * f64::from(k), load + slow).unwrap();
        }
        files.write(name, &text)
    });
    let mut window = window(paths.to_vec());
    show(&mut window, "export");
    let mut settings = state(&window).project().settings.clone();
    settings.features.look_backs.clear();
    for (taus, fades) in [(vec![], false), (vec![10.0], true)] {
        settings.features.blocks.set(&Creep, taus);
        let shell = window.state_mut().as_mut().unwrap();
        shell.send(Edit::Settings(settings.clone()));
        settle(&mut window);
        assert_eq!(!analysis(&window).calibration.fade.is_empty(), fades);
        assert!(!has(&window, "after a cold start"), "the fade mends it");
    }
}

#[test]
fn a_calibration_named_at_the_start_is_applied_to_the_built_in_sensor() {
    let files = Files::new();
    let mut calibration = analysis(&window(Vec::new())).calibration.as_ref().clone();
    calibration.features.look_backs[0].f_th = 1.0;
    let path = files.path("c.json");
    write_calibration(&calibration, &path).unwrap();
    let mut window = window(vec![path]);
    assert!(state(&window).project().recordings.is_simulated());
    show(&mut window, "recordings");
    assert!(has(&window, "Applying "));
    let applied = analysis(&window);
    assert!(!applied.fitted);
    assert_eq!(applied.calibration.features.look_backs[0].f_th, 1.0);
}

#[test]
fn export_uses_the_dialog_and_an_unknown_ending_is_reported() {
    let files = Files::new();
    let choices = Choices::default();
    let mut window = window_with(files.three(), choices.clone());
    let path = files.path("matrices.csv");
    choices.export.replace(Some(path.clone()));
    menu(&mut window, "File", "Export calibration…");
    message(&mut window, Level::Info, "matrices.csv");
    assert!(std::fs::read_to_string(&path).unwrap().contains("S3_past"));

    let unknown = files.path("calibration.xlsx");
    show(&mut window, "export");
    type_into(&mut window, "Export to", unknown.to_str().unwrap());
    click(&mut window, Role::Button, "Write 1 file");
    message(&mut window, Level::Error, "calibration.xlsx");
    assert!(!unknown.exists());
}

#[test]
fn a_report_and_the_traces_on_screen_go_through_the_dialog() {
    let files = Files::new();
    let choices = Choices::default();
    let mut window = window_with(files.three(), choices.clone());
    let path = files.path("report.html");
    choices.export.replace(Some(path.clone()));
    menu(&mut window, "File", "Save report…");
    message(&mut window, Level::Info, "report.html");
    let report = std::fs::read_to_string(&path).unwrap();
    assert!(report.contains("<svg") && report.contains("test_c"));
    let path = files.path("traces.csv");
    choices.export.replace(Some(path.clone()));
    menu(&mut window, "File", "Save traces on screen…");
    let traces = std::fs::read_to_string(&path).unwrap();
    let rows = traces.lines().filter(|line| line.starts_with("a,"));
    assert_eq!(rows.count(), 400, "only the recording on screen is written");
}

#[test]
fn the_matrix_that_a_sensor_came_with_is_drawn_and_scored_beside_the_fit() {
    let files = Files::new();
    let mut window = window(Vec::new());
    let path = files.path("sensor.cal");
    show(&mut window, "export");
    type_into(&mut window, "Export to", path.to_str().unwrap());
    click(&mut window, Role::Button, "Write 1 file");
    show(&mut window, "traces");
    load(&mut window, path.to_str().unwrap());
    let scores = analysis(&window).factory.clone().expect("the recording has scores");
    let conventional = analysis(&window).calibration.quality.conventional.clone();
    let [factory, fitted] = [scores.test_rmse[0].unwrap(), conventional.test_rmse.unwrap()[0]];
    assert!((factory - fitted).abs() < 0.05 * fitted, "{factory} {fitted}");
    click(&mut window, Role::CheckBox, "Factory");
    let shell = window.state_mut().as_mut().unwrap();
    shell.send(Edit::Compare(None));
    settle(&mut window);
    assert!(!has(&window, "Factory") && analysis(&window).factory.is_none());
}

#[test]
fn the_pointer_on_a_pane_shows_the_past_that_was_found() {
    let files = Files::new();
    let mut window = window(files.three());
    let pane = window.get_by_role_and_label(Role::GraphicsObject, "Fx [N]").rect();
    window.hover_at(pane.center() + Vec2::new(20.0, 0.0));
    window.run_steps(3);
    assert!(has(&window, "Fx at "));
    assert!(has(&window, "look-back to the sample "));
    window.remove_cursor();
    window.run_steps(3);
    assert!(has(&window, "look-back to the sample "), "the last sample stays");
}

#[test]
fn the_wheel_zooms_and_fit_view_shows_all_again() {
    let files = Files::new();
    let mut window = window(files.three());
    let pane = window.get_by_role_and_label(Role::GraphicsObject, "Fx [N]").rect();
    let right = pane.right_center() - Vec2::new(30.0, 0.0);
    let time_at = |window: &mut Window| {
        window.hover_at(right);
        window.run_steps(3);
        let printed = window.get_by_label_contains("Fx at ").value().unwrap();
        let time = printed.trim_start_matches("Fx at ").trim_end_matches(" s");
        let time: f64 = time.parse().unwrap();
        window.remove_cursor();
        window.run_steps(2);
        time
    };
    let all = time_at(&mut window);
    window.hover_at(pane.center());
    window.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: Vec2::new(0.0, 200.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    window.run_steps(10);
    let zoomed = time_at(&mut window);
    assert!(zoomed < all, "{zoomed} {all}");
    click(&mut window, Role::Button, "Fit view");
    assert_eq!(time_at(&mut window), all);
}

#[test]
fn cancel_ends_the_reading_and_keeps_the_loaded_recordings() {
    let files = Files::new();
    let mut window = window(files.three());
    let large = files.recording("large.csv", 0.0, 20_000, &FORCES);
    let many = vec![large; 3000];
    let asked = many.len();
    window.state_mut().as_mut().unwrap().send(Action::Open(many));
    window.step();
    assert!(has(&window, "Reading 3000 files"));
    click(&mut window, Role::Button, "Cancel");
    assert!(names(&window).len() < asked);
    assert_eq!(names(&window)[..3], ["a", "b", "test_c"]);
    assert!(!has(&window, "Reading"));
}

#[test]
fn a_recording_without_reference_shows_conv_and_comp_and_no_errors() {
    let files = Files::new();
    let mut paths = files.three();
    paths.push(files.recording("bare.csv", 0.7, 200, &[]));
    let mut window = window(paths);
    show(&mut window, "recordings");
    assert_eq!(panes(&window, "error [N]"), 3);
    click_first(&mut window, Role::Button, "bare");
    let traces = Arc::clone(&analysis(&window).traces);
    assert!(traces.axes.iter().all(|axis| axis.calculated.is_none()));
    assert_eq!(traces.axes[0].compensated.len(), 200);
    assert_eq!((panes(&window, "Fx [N]"), panes(&window, "error [N]")), (1, 0));
}

#[test]
fn a_recording_without_reference_alone_shows_nothing_of_the_built_in_sensor() {
    let files = Files::new();
    let mut window = window(Vec::new());
    let bare = files.recording("bare.csv", 0.7, 200, &[]);
    let dropped = Arc::new(Dropped(bare));
    window.input_mut().dropped_files.push(dropped);
    settle(&mut window);
    assert_eq!(names(&window), ["bare"]);
    assert!(state(&window).analysis().is_none());
    assert_eq!(state(&window).project().missing(), Some(Missing::Load));
    assert!(has(&window, "no load yet"));
}

#[test]
fn an_answer_about_recordings_that_were_closed_meanwhile_is_dropped() {
    let mut window = window(Vec::new());
    show(&mut window, "settings");
    window.get_by_role_and_label(Role::Button, "B").click();
    window.step();
    window.step();
    let shell = window.state_mut().as_mut().unwrap();
    shell.send(Edit::New);
    settle(&mut window);
    assert!(state(&window).analysis().is_none());
    assert!(state(&window).problem().is_some());
}

#[test]
fn an_entered_full_scale_is_used_until_it_is_measured_again() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "settings");
    let measured = analysis(&window).calibration.full_scale.clone();
    click(&mut window, Role::DisclosureTriangle, "Full scale");
    let last = window.get_by_role_and_label(Role::SpinButton, "Fz [N]");
    last.scroll_to_me();
    settle(&mut window);
    type_number(&mut window, "Fy [N]", "12");
    let entered = analysis(&window).calibration.full_scale.clone();
    assert_eq!(entered, [measured[0], 12.0, measured[2]]);
    let measure = window.query_all_by_role_and_label(Role::Button, "Measure");
    let enabled: Vec<_> = measure.filter(|button| !button.accesskit_node().is_disabled()).collect();
    assert_eq!(enabled.len(), 1);
    enabled[0].click();
    settle(&mut window);
    assert_eq!(analysis(&window).calibration.full_scale, measured);
}

#[test]
fn moments_alone_are_measured_over_full_scale() {
    let files = Files::new();
    let axes = [Axis::Mx, Axis::My];
    let mut window = window(vec![files.recording("a.csv", 0.0, 400, &axes)]);
    show(&mut window, "settings");
    assert_eq!(panes(&window, "error [N·m]"), 2);
    assert!(!has(&window, "F_th is a distance over"));
    slide(&mut window, "F_th", 40.0);
    assert_eq!(analysis(&window).calibration.features.look_backs[0].f_th, 0.4);
    click(&mut window, Role::Button, "Reset to 25 % FS, 15 s");
    assert_eq!(analysis(&window).calibration.features.look_backs[0].f_th, 0.25);
}

#[test]
fn the_smallest_window_shows_every_widget_with_a_name_in_both_themes() {
    let files = Files::new();
    let mut window = window(files.three());
    window.set_size(Vec2::new(900.0, 480.0));
    for theme in ["Light", "Dark"] {
        click(&mut window, Role::Button, "View");
        click(&mut window, Role::Button, &format!("Theme: {theme}"));
        window.check_accessibility();
        assert_eq!(panes(&window, "Fx [N]"), 1);
    }
    for trace in ["Reference", "Uncompensated", "Compensated"] {
        click(&mut window, Role::CheckBox, trace);
    }
    assert_eq!(panes(&window, "error [N]"), 3, "empty panes stay");
}

#[test]
fn blocks_are_switched_on_with_defaults_and_take_typed_numbers() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "settings");
    let before = analysis(&window).calibration.feature_names().len();
    click(&mut window, Role::CheckBox, "Play");
    let features = analysis(&window).calibration.features.clone();
    assert_eq!(features.blocks.of(&Play), [0.1, 0.2, 0.4, 0.7, 1.1, 1.6]);
    type_into(&mut window, "Play", "0.2, 0.5");
    settle(&mut window);
    assert_eq!(analysis(&window).calibration.features.blocks.of(&Play), [0.2, 0.5]);
    type_into(&mut window, "Play", "0.2, -1");
    settle(&mut window);
    let calibration = Arc::clone(&analysis(&window).calibration);
    assert_eq!(calibration.features.blocks.of(&Play), [0.2, 0.5]);
    assert_eq!(calibration.feature_names().len(), before + 6);
    click(&mut window, Role::CheckBox, "Look-back");
    click(&mut window, Role::Button, "degree 2");
    let calibration = Arc::clone(&analysis(&window).calibration);
    assert!(calibration.features.look_backs.is_empty());
    assert_eq!(calibration.features.blocks.of(&Polynomial), [2.0]);
    click(&mut window, Role::CheckBox, "auto");
    assert_eq!(state(&window).project().settings.ridge, RidgeChoice::Auto);
    assert_eq!(analysis(&window).calibration.quality.ridge.len(), 3);
}

#[test]
fn a_kernel_is_trained_in_the_background_and_becomes_stale_with_its_settings() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "settings");
    click(&mut window, Role::ComboBox, "Model type");
    click(&mut window, Role::Button, "Kernel");
    assert_eq!(state(&window).project().settings.regressor, Regressor::Kernel);
    assert!(has(&window, "Not trained yet"));
    assert_eq!(analysis(&window).calibration.regressor, Regressor::Linear);
    type_number(&mut window, "Landmarks", "20");
    let f_th = state(&window).project().settings.features.look_backs[0].f_th;
    click(&mut window, Role::Button, "Train the kernel");
    let trained = analysis(&window);
    assert_eq!(trained.calibration.regressor, Regressor::Kernel);
    assert!(trained.fitted && trained.traces.axes[0].band.is_some());
    assert!(trained.calibration.quality.compensated.cv_rmse.is_some());
    slide(&mut window, "F_th", f_th + 1.0);
    assert!(has(&window, "belongs to other settings"));
    assert_eq!(analysis(&window).calibration.regressor, Regressor::Linear);
    slide(&mut window, "F_th", f_th);
    assert_eq!(analysis(&window).calibration.regressor, Regressor::Kernel);
}

#[test]
fn a_training_that_cannot_begin_gives_the_reason() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "settings");
    click(&mut window, Role::ComboBox, "Model type");
    click(&mut window, Role::Button, "Linear + kernel");
    type_number(&mut window, "Landmarks", "2000");
    click(&mut window, Role::Button, "Train the kernel");
    message(&mut window, Level::Error, "choose fewer landmarks");
}

#[test]
fn models_are_found_brought_back_and_saved() {
    let files = Files::new();
    let choices = Choices::default();
    let mut window = window_with(files.three(), choices.clone());
    click(&mut window, Role::Button, "Models");
    let find = window.get_by_role_and_label(Role::Button, "Find the best");
    find.click();
    until(&mut window, |shell| shell.engine().models.rows.len() >= 2);
    click(&mut window, Role::Button, "Stop");
    assert!(has(&window, "Proposed: "));
    let rows = state(&window).models.rows.clone();
    let before = state(&window).project().settings.clone();
    // The order of candidates depends on the recordings. So the test uses any row other than Conventional.
    let other = rows.iter().find(|row| row.name != "Conventional").expect("a candidate");
    click(&mut window, Role::Button, &other.name);
    let settings = state(&window).project().settings.clone();
    assert_eq!(settings.features, other.model.settings.features);
    click(&mut window, Role::Button, "Keep this model");
    assert!(has(&window, "Kept 1"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(state(&window).project().settings, before);

    let path = files.path("table.csv");
    choices.export.replace(Some(path.clone()));
    click(&mut window, Role::Button, "Save as…");
    let table = std::fs::read_to_string(&path).unwrap();
    assert_eq!(table.lines().count(), rows.len() + 2, "the table has a header and the kept model");
    assert!(table.starts_with(",model,train relative RMSE [%],test relative RMSE [%]"), "{table}");
}

/// Gauges in proportion to the load, with noise and without hysteresis.
#[test]
fn a_compensation_that_brings_nothing_is_switched_off_by_one_press() {
    let files = Files::new();
    let mut text = "t [s],S1,S2,Fz [N]".to_owned();
    let mut random = 1_u32;
    for k in 0..3000 {
        let t = f64::from(k) / 20.0;
        let force = 20.0 * (0.13 * t).sin() + 3.0 * (1.1 * t).cos();
        let mut noise = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(random >> 8) / f64::from(1 << 24) - 0.5
        };
        write!(text, "\n{t},{},{},{force}", 2.0 * force + noise(), -force + noise()).unwrap();
    }
    let mut window = window(vec![files.write("sound.csv", &text)]);
    let button = "Switch it off";
    let features = |window: &Window| state(window).project().settings.features.clone();
    assert!(!features(&window).look_backs.is_empty());
    until(&mut window, |shell| !shell.is_busy());
    click(&mut window, Role::Button, button);
    assert!(features(&window).look_backs.is_empty());
    assert!(window.query_by_role_and_label(Role::Button, button).is_none());
    ctrl_z(&mut window);
    assert!(!features(&window).look_backs.is_empty(), "one step of undo");
    let with_hysteresis = self::window(files.three());
    assert!(with_hysteresis.query_by_role_and_label(Role::Button, button).is_none());
}

#[test]
fn a_model_is_compared_until_escape() {
    let files = Files::new();
    let mut window = window(files.three());
    click(&mut window, Role::Button, "Models");
    click(&mut window, Role::Button, "Keep this model");
    let before = state(&window).project().settings.clone();
    click(&mut window, Role::Button, "Calibrate");
    click(&mut window, Role::Button, "Creep");
    let present = state(&window).project().settings.clone();
    click(&mut window, Role::Button, "Models");
    click_first(&mut window, Role::Button, "…");
    click(&mut window, Role::Button, "Compare in Calibrate");
    assert_eq!(state(&window).project().settings, before);
    assert!(shell(&window).on_screen().iter().any(|pane| pane.key == "traces"));
    window.key_press(Key::Escape);
    settle(&mut window);
    assert_eq!(state(&window).project().settings, present);
}

#[test]
fn the_map_of_thresholds_suggests_a_pair_and_sets_it() {
    let files = Files::new();
    let choices = Choices::default();
    let mut window = window_with(files.three(), choices.clone());
    click(&mut window, Role::Button, "Thresholds");
    let study = state(&window).lane::<StudyThresholds>().answer();
    let study = study.expect("the map is made while the pane is shown");
    let map = Arc::clone(study.map.as_ref().unwrap());
    assert!(map.is_complete());
    assert_eq!(panes(&window, "Map of F_th and t_th"), 1);
    assert!(study.past_ages.n_samples > 0);
    let measure = map.scale.default_measure();
    let suggested = map.suggestion(measure).unwrap().thresholds;
    click(&mut window, Role::Button, "Use: Lowest error");
    assert_eq!(state(&window).project().thresholds(), suggested);
    let left_out = analysis(&window).calibration.quality.compensated.cv_rmse.clone();
    let on_map = map.suggestion(measure).unwrap().left_out;
    let fresh = measure.of_rmse(&map.scale, &left_out.unwrap()).unwrap();
    assert!((fresh / on_map - 1.0).abs() < 1e-9);
    for (name, start) in [("map.csv", "f_th"), ("map.svg", "<svg")] {
        let path = files.path(name);
        choices.export.replace(Some(path.clone()));
        click(&mut window, Role::Button, "Save as…");
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(start), "{name}");
    }
    assert!(files.path("map_f_th.svg").is_file());
    // The inputs of the map are unchanged, so the map is not computed again.
    let shown = |window: &Window| {
        let study = state(window).lane::<StudyThresholds>().answer().unwrap();
        Arc::clone(study.map.as_ref().unwrap())
    };
    assert!(Arc::ptr_eq(&map, &shown(&window)));
    show(&mut window, "settings");
    click(&mut window, Role::CheckBox, "Offset term");
    assert!(!Arc::ptr_eq(&map, &shown(&window)));
}

#[test]
fn play_radii_are_chosen_by_leave_one_out() {
    let files = Files::new();
    let mut window = window(files.three());
    show(&mut window, "settings");
    click(&mut window, Role::Button, "Choose play radii");
    let chosen = state(&window).lane::<ChooseBlock>().answer().cloned().expect("a list was chosen");
    assert_eq!(analysis(&window).calibration.features.blocks.of(&Play), chosen.values);
    assert!(chosen.left_out <= chosen.left_out_without);
    assert!(has(&window, "lists of values were tried"));
}

/// Returns the number of labels on screen that contain a number.
fn numbers_on_screen(window: &Window) -> usize {
    let labels = window.query_all_by_role(Role::Label);
    labels
        .filter(|label| {
            let text = label.accesskit_node().value().unwrap_or_default();
            // The text of a table cell also contains its row, column and unit.
            text.split_whitespace().any(|word| word.parse::<f64>().is_ok())
        })
        .count()
}

#[test]
fn loops_show_their_width_for_any_axis_gauge_and_range() {
    let files = Files::new();
    let mut window = window(files.three());
    maximize(&mut window, "loops");
    window.check_accessibility();
    assert_eq!(panes(&window, "Fx error [N] against Fx Reference [N]"), 1);
    for card in ["Largest width: ", "Mean width: ", "Nonlinearity: ", "Time lag: "] {
        assert!(has(&window, card), "{card}");
    }
    assert!(has(&window, "400 samples of 1 recording"));

    click(&mut window, Role::ComboBox, "up");
    click(&mut window, Role::Button, "S1");
    assert_eq!(panes(&window, "S1 [raw] against Fx Reference [N]"), 1);
    click(&mut window, Role::ComboBox, "of");
    click(&mut window, Role::Button, "All recordings");
    assert!(has(&window, "1200 samples of 3 recordings"));
    window.key_press(Key::Num3);
    settle(&mut window);
    assert_eq!(panes(&window, "S1 [raw] against Fz Reference [N]"), 1);
    type_number(&mut window, "Reversal threshold", "50");
    assert!(has(&window, "within the reversal threshold of 50 N"));
    click(&mut window, Role::CheckBox, "from data");
    assert!(!has(&window, "within the reversal threshold"));
}

#[test]
fn a_press_on_a_notice_dismisses_it() {
    let files = Files::new();
    let mut window = window(files.three());
    load(&mut window, "missing.csv");
    message(&mut window, Level::Error, "missing.csv");
    let text = window.get_all_by_role(Role::Label);
    let text = text.into_iter().find_map(|label| {
        let words = label.accesskit_node().value().unwrap_or_default();
        words.contains("missing.csv").then(|| label.rect().center())
    });
    let at = text.expect("the text is over the window");
    window.hover_at(at);
    window.drag_at(at);
    window.drop_at(at);
    settle(&mut window);
    let is_told = |notice: &loopscope::engine::Notice| notice.text.contains("missing.csv");
    assert!(!state(&window).notices.iter().any(is_told));
}

#[test]
fn any_two_channels_are_crossed_and_saved_as_a_picture() {
    let files = Files::new();
    let choices = Choices::default();
    let mut window = window_with(files.three(), choices.clone());
    maximize(&mut window, "loops");
    click(&mut window, Role::Button, "Cross-plot");
    assert_eq!(panes(&window, "S1 [raw] against Fz Reference [N]"), 1);
    click(&mut window, Role::ComboBox, "across");
    click(&mut window, Role::Button, "Time");
    click(&mut window, Role::ComboBox, "up");
    click(&mut window, Role::Button, "Fx Compensated");
    assert_eq!(panes(&window, "Fx Compensated [N] against Time [s]"), 1);
    let path = files.path("cross.svg");
    choices.export.replace(Some(path.clone()));
    let plot =
        window.get_by_role_and_label(Role::GraphicsObject, "Fx Compensated [N] against Time [s]");
    plot.focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::SHIFT, Key::F10);
    window.run_steps(3);
    click(&mut window, Role::Button, "Save as SVG…");
    let svg = std::fs::read_to_string(&path).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains(">Fx Compensated [N]</text>"));
}

#[test]
fn faulty_samples_are_counted_and_left_out() {
    let files = Files::new();
    let mut text = "t [s],S1,S2,Fz [N]".to_owned();
    for k in 0..2000 {
        let t = f64::from(k) / 20.0;
        let force = 20.0 * (0.13 * t).sin() + 3.0 * (1.1 * t).cos();
        let wiggle = f64::from(k * 7919 % 13) / 13.0;
        let s1 = (2.0 * force + wiggle).round().min(30.0);
        let s2 = (10.0 - 1.1 * force + wiggle).round();
        write!(text, "\n{t},{s1},{s2},{force}").unwrap();
    }
    let mut window = window(vec![files.write("press.csv", &text)]);
    show(&mut window, "recordings");
    let n_recordings = |window: &Window| state(window).project().recordings.entries().len();
    assert!(has(&window, "of 2000 samples look faulty"));
    click(&mut window, Role::Button, "Leave out faulty samples");
    settle(&mut window);
    assert!(n_recordings(&window) > 1);
    assert!(!has(&window, "look faulty"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(n_recordings(&window), 1);
}

#[test]
fn a_load_that_never_rests_or_turns_is_answered_with_a_sentence() {
    let files = Files::new();
    let mut text = "t [s],S1,Fz [N]".to_owned();
    for k in 0..300 {
        let noise = f64::from((k * k) % 7);
        write!(text, "\n{},{},5", f64::from(k) / 20.0, 1.0 + 0.01 * noise).unwrap();
    }
    let constant = files.write("constant.csv", &text);
    let mut window = window(vec![constant]);
    show(&mut window, "loops");
    assert!(has(&window, "Fz stays between 5 and 5 N"));
    click(&mut window, Role::Button, "Drift");
    assert!(has(&window, "1 dwell"));
    assert_eq!(panes(&window, "Fz drift [N]"), 1);
    type_number(&mut window, "Dwells of at least", "60");
    assert!(has(&window, "no recording has a dwell of 60 s"));
    show(&mut window, "metrology");
    let rows = ["RMSE", "Hysteresis, mean loop"].map(|name| has(&window, name));
    assert_eq!(rows, [true, false], "a row without a figure is not shown");
}

#[test]
fn the_metrology_table_is_shown_for_a_role_and_saved_as_csv() {
    let files = Files::new();
    let choices = Choices::default();
    let mut window = window_with(files.three(), choices.clone());
    maximize(&mut window, "metrology");
    window.check_accessibility();
    for part in ["Hysteresis, mean loop", "RMSE", "1 recording, 400 samples"] {
        assert!(has(&window, part), "{part}");
    }
    for missing in ["Zero return", "Repeatability"] {
        assert!(!has(&window, missing), "{missing}: no recording dwells at zero, or loads twice");
    }
    assert!(numbers_on_screen(&window) > 8);
    click_first(&mut window, Role::Button, "All");
    assert!(has(&window, "3 recordings, 1200 samples"));
    let path = files.path("figures.csv");
    choices.export.replace(Some(path.clone()));
    click(&mut window, Role::Button, "Save as…");
    let table = std::fs::read_to_string(&path).unwrap();
    assert!(table.starts_with("id,quantity,axis,unit,full_scale,conventional"));
    // Each of three axes has 7 rows of loops, 1 of sensitivity, 2 of lag, 4 of dwells, 3 of crosstalk, 2 of noise, 2 of the temperature's effect
    // and 3 of errors. One more row is the header.
    assert_eq!(table.lines().count(), 1 + 3 * (7 + 1 + 2 + 4 + 3 + 2 + 2 + 3));
    click(&mut window, Role::Button, "Definitions…");
    type_number(&mut window, "Reversal threshold Fx", "100");
    assert!(has(&window, "constant"), "no load turns back by 100 N");
}

#[test]
fn a_click_on_a_loop_isolates_its_cycle() {
    let files = Files::new();
    let mut window = window(files.three());
    window.key_press(Key::F4);
    settle(&mut window);
    let plot = window
        .get_by_role_and_label(Role::GraphicsObject, "Fx error [N] against Fx Reference [N]")
        .rect();
    // The pointer moves down along the middle of the plot until a line is near.
    let on_loop = (1..40).find_map(|step| {
        let at = plot.center_top() + Vec2::new(0.0, plot.height() * step as f32 / 40.0);
        window.hover_at(at);
        window.run_steps(4);
        has(&window, "click to show only this cycle").then_some(at)
    });
    let at = on_loop.expect("a loop passes the middle");
    assert_eq!(shell(&window).visible_time(), None);
    window.drag_at(at);
    window.drop_at(at);
    settle(&mut window);
    let (from, to) = shell(&window).visible_time().expect("one cycle");
    assert!(0.0 < to - from && to - from < 19.0, "{from} to {to}");
}

/// The loops show three recordings, and the traces show the first of them.
#[test]
fn a_loop_of_other_recordings_is_linked_with_those_that_the_traces_show() {
    let files = Files::new();
    let mut window = window(files.three());
    window.key_press(Key::F4);
    settle(&mut window);
    assert!(!has(&window, "inked with Traces"));
    for (up, title) in [
        (None, "Fx error [N] against Fx Reference [N]"),
        (Some("S1"), "S1 [raw] against Fx Reference [N]"),
    ] {
        if let Some(up) = up {
            click(&mut window, Role::ComboBox, "up");
            click(&mut window, Role::Button, up);
        }
        click(&mut window, Role::ComboBox, "of");
        click(&mut window, Role::Button, "Test recordings");
        assert!(has(&window, "Not linked with Traces: the pane Traces shows other recordings"));
        click(&mut window, Role::ComboBox, "of");
        click(&mut window, Role::Button, "All recordings");
        assert!(has(&window, "The Traces pane shows 1 of 3 recordings"));
        let plot = window.get_by_role_and_label(Role::GraphicsObject, title).rect();
        let on_loop = (1..60).find_map(|step| {
            let at = plot.center_top() + Vec2::new(0.0, plot.height() * step as f32 / 60.0);
            window.hover_at(at);
            window.run_steps(4);
            has(&window, "click to show only this cycle").then_some(at)
        });
        let at = on_loop.expect("a loop passes the middle");
        window.drag_at(at);
        window.drop_at(at);
        settle(&mut window);
        assert!(shell(&window).visible_time().is_some());
        assert!(has(&window, "of 1 recording"), "the cycle is shown alone");
        window.hover_at(plot.left_top());
        window.key_press(Key::F4);
        settle(&mut window);
    }
}
