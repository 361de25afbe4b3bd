//! Sessions are saved, opened, and protected against loss.

use super::*;

fn send(window: &mut Window, command: impl Into<Command>) {
    window.state_mut().as_mut().unwrap().send(command);
    settle(window);
}

fn saved(files: &Files) -> PathBuf {
    let choices = Choices::default();
    let path = files.path("work.json");
    choices.export.replace(Some(path.clone()));
    let mut window = window_with(files.three(), choices);
    slide(&mut window, "F_th", 1.25);
    send(&mut window, Edit::Roles(vec![1], recording::Role::Off));
    assert!(state(&window).is_unsaved());
    menu(&mut window, "File", "Save session as…");
    message(&mut window, Level::Info, "work.json");
    assert!(!state(&window).is_unsaved());
    path
}

#[test]
fn a_session_comes_back_with_its_files_roles_and_settings() {
    let files = Files::new();
    let path = saved(&files);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("\"path\": \"a.csv\""), "the path is not relative: {text}");
    let window = window(vec![path]);
    assert_eq!(names(&window), ["a", "b", "test_c"]);
    let roles: Vec<_> =
        state(&window).project().recordings.entries().iter().map(|entry| entry.role).collect();
    use recording::Role::{Off, Test, Train};
    assert_eq!(roles, [Train, Off, Test]);
    assert_eq!(analysis(&window).calibration.features.look_backs[0].f_th, 1.25);
    assert_eq!(state(&window).title(), "work – LoopScope");
    assert!(state(&window).notices.is_empty(), "{:?}", state(&window).notices);
}

#[test]
fn a_changed_file_is_reported_and_a_moved_file_is_asked_for() {
    let files = Files::new();
    let path = saved(&files);
    let a = std::fs::read_to_string(files.path("a.csv")).unwrap();
    let shorter: Vec<&str> = a.lines().take(200).collect();
    files.write("a.csv", &shorter.join("\n"));
    std::fs::rename(files.path("b.csv"), files.path("moved.csv")).unwrap();
    let mut window = window(vec![path]);
    message(&mut window, Level::Warning, "the file has changed since the session was saved");
    assert_eq!(names(&window), ["a", "test_c"]);
    let moved = files.path("moved.csv");
    assert!(has(&window, "A file of the session was not found"));
    type_path(&mut window, PathFor::Locate, "/nowhere");
    click(&mut window, Role::Button, "Open");
    message(&mut window, Level::Error, "/nowhere: none of the missing files");
    type_path(&mut window, PathFor::Locate, moved.to_str().unwrap());
    window.key_press(Key::Enter);
    settle(&mut window);
    assert_eq!(names(&window), ["a", "test_c", "moved"]);
    assert!(state(&window).project().lost.is_empty());
}

#[test]
fn unsaved_changes_are_asked_about_before_the_window_closes() {
    let files = Files::new();
    let mut window = window(files.three());
    menu(&mut window, "File", "Quit");
    assert!(has(&window, "The session is not saved"));
    click(&mut window, Role::Button, "Cancel");
    assert!(!has(&window, "The session is not saved"));
}

#[test]
fn a_session_dropped_over_unsaved_changes_is_asked_about() {
    let files = Files::new();
    let session = saved(&files);
    let other = files.recording("other.csv", 0.5, 300, &FORCES);
    let choices = Choices::default();
    let own = files.path("own.json");
    choices.export.replace(Some(own.clone()));
    let mut window = window_with(vec![other], choices);
    let drop = |window: &mut Window| {
        let dropped = Arc::new(Dropped(session.clone()));
        window.input_mut().dropped_files.push(dropped);
        window.step();
        settle(window);
        assert!(has(window, "The session is not saved"));
        assert_eq!(names(window), ["other"]);
    };
    drop(&mut window);
    click(&mut window, Role::Button, "Cancel");
    assert_eq!(names(&window), ["other"]);
    drop(&mut window);
    click(&mut window, Role::Button, "Save");
    assert!(own.exists());
    assert_eq!(names(&window), ["a", "b", "test_c"]);
    assert_eq!(state(&window).title(), "work – LoopScope");
}

#[test]
fn a_broken_session_gives_the_reason_and_loses_nothing() {
    let files = Files::new();
    let mut window = window(files.three());
    let newer = r#"{"format": "loopscope session", "version": 99}"#;
    let path = files.write("newer.json", newer);
    send(&mut window, Action::Open(vec![path]));
    message(&mut window, Level::Error, "version 99");
    assert_eq!(names(&window), ["a", "b", "test_c"]);
}

#[test]
fn a_window_that_did_not_close_leaves_its_session_to_the_next() {
    let files = Files::new();
    let folder = tempfile::tempdir().unwrap();
    let session = std::fs::read_to_string(saved(&files)).unwrap();
    let absolute =
        session.replace("\"path\": \"", &format!("\"path\": \"{}/", files.path("").display()));
    for (number, text) in [(1, &*absolute), (2, "{}"), (3, "torn")] {
        let path = folder.path().join(format!("autosave-{number}.json"));
        std::fs::write(&path, text).unwrap();
        std::fs::write(path.with_extension("lock"), "").unwrap();
    }
    let exists = |number: i32| {
        let path = folder.path().join(format!("autosave-{number}.json"));
        path.exists()
    };
    let mut window = window(Vec::new());
    let shell = window.state_mut().take().unwrap().with_recovery(folder.path());
    *window.state_mut() = Some(shell);
    settle(&mut window);
    assert!(has(&window, "a.csv, b.csv, test_c.csv"));
    assert!(has(&window, "UTC") && has(&window, "2 B") && has(&window, "kB"));
    assert!(has(&window, "This session cannot be read: not a session"));
    click(&mut window, Role::Button, "Later");
    assert!(!has(&window, "a.csv, b.csv, test_c.csv"));
    menu(&mut window, "File", "Recover sessions…");
    click_first(&mut window, Role::Button, "Discard");
    click_first(&mut window, Role::Button, "Discard");
    assert!(exists(1) && !exists(2) && !exists(3));
    click(&mut window, Role::Button, "Restore");
    assert_eq!(names(&window), ["a", "b", "test_c"]);
    assert!(state(&window).is_unsaved(), "the restored session is unsaved");
    // Waits until the unsaved session is stored.
    until(&mut window, |_| !exists(1));
}

#[test]
fn a_trained_calibration_is_saved_beside_the_session() {
    let files = Files::new();
    let choices = Choices::default();
    let path = files.path("work.json");
    choices.export.replace(Some(path.clone()));
    let mut window = window_with(files.three(), choices);
    let mut settings = state(&window).project().settings.clone();
    settings.regressor = Regressor::Kernel;
    send(&mut window, Edit::Settings(settings));
    send(&mut window, Action::Train);
    menu(&mut window, "File", "Save session as…");
    message(&mut window, Level::Info, "work.trained.json");
    let scores = train_rmse(&window);
    let window = self::window(vec![path]);
    assert!(state(&window).fitting().is_some());
    assert_eq!(train_rmse(&window), scores);
    assert!(state(&window).notices.is_empty());
}
