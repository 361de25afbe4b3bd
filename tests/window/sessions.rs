//! Sessions: saved, opened, asked about before they are lost.

use super::*;

fn send(window: &mut Window, command: Command) {
    window.state_mut().as_mut().unwrap().send(command);
    settle(window);
}

fn saved(files: &Files) -> PathBuf {
    let choices = Choices::default();
    let path = files.path("work.json");
    choices.export.replace(Some(path.clone()));
    let mut window = window_with(files.three(), choices);
    slide(&mut window, "F_th", 1.25);
    send(&mut window, Command::SetRole(1, recording::Role::Off));
    assert!(state(&window).is_unsaved());
    menu(&mut window, "File", "Save session as…");
    told(&window, Level::Info, "work.json");
    assert!(!state(&window).is_unsaved());
    path
}

#[test]
fn a_session_comes_back_with_its_files_roles_and_settings() {
    let files = Files::new();
    let path = saved(&files);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.contains("\"path\": \"a.csv\""),
        "relative where it can be: {text}"
    );
    let window = window(vec![path]);
    assert_eq!(names(&window), ["a", "b", "test_c"]);
    let roles: Vec<_> = state(&window)
        .recordings
        .entries()
        .iter()
        .map(|entry| entry.role)
        .collect();
    use recording::Role::{Off, Test, Train};
    assert_eq!(roles, [Train, Off, Test]);
    assert_eq!(
        analysis(&window).calibration.features.look_backs[0].f_th,
        1.25
    );
    assert_eq!(state(&window).title(), "work – LoopScope");
    assert!(
        state(&window).notices.is_empty(),
        "{:?}",
        state(&window).notices
    );
}

#[test]
fn a_file_that_changed_is_said_and_one_that_moved_is_asked_for() {
    let files = Files::new();
    let path = saved(&files);
    let a = std::fs::read_to_string(files.path("a.csv")).unwrap();
    let shorter: Vec<&str> = a.lines().take(200).collect();
    files.write("a.csv", &shorter.join("\n"));
    std::fs::rename(files.path("b.csv"), files.path("moved.csv")).unwrap();
    let mut window = window(vec![path]);
    told(
        &window,
        Level::Warning,
        "not the file that the session was saved with",
    );
    assert_eq!(names(&window), ["a", "test_c"]);
    let moved = files.path("moved.csv");
    type_into(&mut window, "It is now at", moved.to_str().unwrap());
    click(&mut window, Role::Button, "Read it there");
    assert_eq!(names(&window), ["a", "test_c", "moved"]);
    assert!(state(&window).lost.is_empty());
}

#[test]
fn what_is_not_saved_is_asked_about_before_the_window_closes() {
    let files = Files::new();
    let mut window = window(files.three());
    menu(&mut window, "File", "Quit");
    assert!(has(&window, "The session is not saved"));
    click(&mut window, Role::Button, "Stay");
    assert!(!has(&window, "The session is not saved"));
}

#[test]
fn a_broken_session_says_why_and_loses_nothing() {
    let files = Files::new();
    let mut window = window(files.three());
    let newer = r#"{"format": "loopscope session", "version": 99}"#;
    let path = files.write("newer.json", newer);
    send(&mut window, Command::OpenFiles(vec![path]));
    told(&window, Level::Error, "version 99");
    assert_eq!(names(&window), ["a", "b", "test_c"]);
}

#[test]
fn a_window_that_did_not_close_leaves_its_session_to_the_next() {
    let files = Files::new();
    let folder = tempfile::tempdir().unwrap();
    let session = std::fs::read_to_string(saved(&files)).unwrap();
    let absolute = session.replace(
        "\"path\": \"",
        &format!("\"path\": \"{}/", files.path("").display()),
    );
    std::fs::write(folder.path().join("autosave-1.json"), absolute).unwrap();
    std::fs::write(folder.path().join("autosave-1.lock"), "").unwrap();
    let mut window = window(Vec::new());
    let shell = window
        .state_mut()
        .take()
        .unwrap()
        .with_recovery(folder.path());
    *window.state_mut() = Some(shell);
    settle(&mut window);
    click(&mut window, Role::Button, "Take it up again");
    assert_eq!(names(&window), ["a", "b", "test_c"]);
    assert!(state(&window).is_unsaved(), "it is saved nowhere yet");
    assert!(!folder.path().join("autosave-1.json").exists());
}
