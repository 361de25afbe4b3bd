//! Tests that a program that is killed while it writes loses no complete file.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::{
    engine::{
        preferences::{Preferences, PreferencesFile},
        project::Project,
        recovery::{Recovery, Unsaved},
        saving::FileContent,
        session::Session,
    },
    progress::Progress,
};

/// Environment variable with the folder for the program that is killed.
const FOLDER: &str = "LOOPSCOPE_TEST_WRITES_INTO";
const KILLS: usize = 50;
/// Number of copies of a session's number in its file, so that an incomplete file is detected.
const REPEATED: usize = 4000;

fn session(round: u64) -> Session {
    let notes = format!("{round} ").repeat(REPEATED);
    Session { project: Project { notes, ..Project::default() }, ..Session::default() }
}

fn round_of(read: &Session) -> u64 {
    let first = read.project.notes.split(' ').next().unwrap_or_default();
    let round = first.parse().expect("a number");
    assert_eq!(*read, session(round), "the session file is complete");
    round
}

/// The newest of the recent files has the number of the round as its name.
fn last_round(preferences: &Preferences) -> Option<u64> {
    preferences.recent.first()?.file_name()?.to_str()?.parse().ok()
}

fn round_in(folder: &Path) -> u64 {
    let kept = PreferencesFile::read_in(folder).expect("the preferences can be read");
    last_round(&kept).expect("the program that wrote the file has ended")
}

fn n_temporary(folder: &Path) -> usize {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let names = entries.map(|entry| entry.file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(".part")).count()
}

#[test]
#[ignore = "the test below starts and kills it"]
fn writes_until_killed() {
    let Some(folder) = std::env::var_os(FOLDER) else {
        return;
    };
    let folder = Path::new(&folder);
    let mut recovery = Recovery::begin_every(folder, Duration::ZERO);
    let begun = PreferencesFile::read_in(folder).unwrap_or_default();
    let mut preferences = PreferencesFile::new(folder, begun.clone());
    let first = last_round(&begun).map_or(0, |round| round + 1);
    let mut now = begun;
    for round in first.. {
        now.remember(Path::new(&format!("/{round}")));
        preferences.write(&now).unwrap();
        let saved = FileContent::Session(Box::new(session(round)), None);
        let path = folder.join("saved").join("s.json");
        saved.write(&path, &Progress::default()).unwrap();
        let unsaved = Unsaved { session: session(round), ..Unsaved::default() };
        recovery.keep(unsaved, false);
        let written = || Session::read(recovery.path().unwrap()).ok();
        while written().is_none_or(|written| written != session(round)) {
            thread::sleep(Duration::from_millis(1));
        }
        fs::write(folder.join("begun"), "").unwrap();
    }
}

#[test]
fn a_program_killed_while_writing_leaves_complete_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("saved")).unwrap();
    let mut last = [0; 2];
    for kill in 1..=KILLS {
        let mut program = Command::new(std::env::current_exe().unwrap())
            .args(["--ignored", "--exact"])
            .arg("engine::killed_tests::writes_until_killed")
            .env(FOLDER, folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let deadline = Instant::now() + Duration::from_secs(60);
        while !at("begun").exists() {
            assert!(
                program.try_wait().unwrap().is_none(),
                "the program ended before it was killed"
            );
            assert!(Instant::now() < deadline);
            thread::sleep(Duration::from_millis(1));
        }
        // The program is killed at a different time in each round.
        thread::sleep(Duration::from_micros((kill as u64 * 7919) % 20_000));
        program.kill().unwrap();
        program.wait().unwrap();
        fs::remove_file(at("begun")).unwrap();

        let now = [round_of(&Session::read(&at("saved/s.json")).unwrap()), round_in(folder.path())];
        let goes_on = now.iter().zip(&last).all(|(now, last)| now >= last);
        assert!(goes_on, "{now:?} after {last:?}");
        last = now;
        assert!(n_temporary(&at("saved")) <= 1 && n_temporary(folder.path()) <= 2);
        let mut next = Recovery::begin(folder.path());
        assert_eq!(n_temporary(folder.path()), 0);
        let left = next.left();
        assert_eq!(left.len(), kill, "each killed program left one session");
        let newest = left[kill - 1].session.as_ref().unwrap();
        assert!(round_of(newest) <= now[1]);
        next.end();
    }
    for left in Recovery::begin(folder.path()).left() {
        round_of(&left.session.unwrap());
    }
}
