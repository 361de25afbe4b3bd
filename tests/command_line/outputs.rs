//! Output files. All paths are checked before the first file is written, and no file is left incomplete.

use std::fs;
use std::io::Write as _;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::program::{program, run, stderr, succeed};
use crate::tools;
use crate::workshop::{ALL_FILES, Workshop};

fn names(workshop: &Workshop) -> Vec<String> {
    let entries = fs::read_dir(workshop.path()).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Runs a job and checks that it is refused with a message that contains these words, and that the folder is unchanged.
#[track_caller]
fn refused(workshop: &Workshop, arguments: &str, words: &[&str]) {
    let before = names(workshop);
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let output = run(workshop.path(), &arguments);
    let message = stderr(&output);
    assert!(!output.status.success(), "{arguments:?} succeeded");
    for word in words {
        assert!(message.contains(word), "{arguments:?}: no {word} in {message}");
    }
    assert_eq!(names(workshop), before, "{arguments:?}");
}

#[test]
fn of_several_outputs_none_is_written_unless_all_can_be() {
    let workshop = Workshop::with_recordings();
    fs::create_dir(workshop.file("sub")).unwrap();
    let fit = ["fit", &ALL_FILES.join(" ")].join(" ");
    for (outputs, words) in [
        ("--export m.csv --traces m.csv", &["m.csv", "same file"][..]),
        ("--export a.h --export a.h", &["a.h", "same file"]),
        ("--export a.h --export sub/../a.h", &["sub/../a.h", "same"]),
        ("--export a.json --export a.cal --export a.h", &["a.cal", "up to 8 gauges"]),
        ("--export a.cal --export b.cal", &["a.cal", "b.cal"]),
        ("--export a.json --export a.xyz", &["a.xyz", "format"]),
        ("--export a.json --export gone/a.h", &["gone/a.h", "no folder gone"]),
        ("--export a.json --traces test.csv --force", &["test.csv", "replace the input"]),
        ("--export a.json --t-th 1e9 --export a.h", &["a.h", "look back"]),
    ] {
        refused(&workshop, &format!("{fit} {outputs}"), words);
    }
    workshop.write("map.json", "{}");
    let mapped = "fit --train a.csv --columns map.json --export map.json --force";
    refused(&workshop, mapped, &["map.json", "replace the input"]);
}

#[test]
fn a_demo_and_a_map_replace_files_only_by_force() {
    let workshop = Workshop::with_recordings();
    let demo = ["demo", "d", "--pattern", "b"];
    succeed(workshop.path(), &demo);
    workshop.write("d/README.txt", "mine");
    refused(&workshop, &demo.join(" "), &["--force"]);
    for name in fs::read_dir(workshop.file("d")).unwrap() {
        let path = name.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "csv") {
            fs::remove_file(path).unwrap();
        }
    }
    refused(&workshop, &demo.join(" "), &["README.txt", "--force"]);
    assert_eq!(workshop.read("d/README.txt"), "mine");
    succeed(workshop.path(), &[&demo[..], &["--force"]].concat());
    assert!(workshop.read("d/README.txt").contains("simulated"));

    workshop.write("map.json", "mine");
    let map = "inspect a.csv --write-map map.json";
    refused(&workshop, map, &["map.json", "--force"]);
    let forced: Vec<&str> = map.split(' ').chain(["--force"]).collect();
    succeed(workshop.path(), &forced);
    assert!(workshop.read("map.json").contains("column map"));
}

#[cfg(unix)]
#[test]
fn a_link_to_nothing_is_not_replaced_without_force() {
    let workshop = Workshop::with_recordings();
    let link = workshop.file("c.json");
    std::os::unix::fs::symlink("gone.json", &link).unwrap();
    refused(&workshop, "fit --train a.csv --export c.json", &["already"]);
    assert!(link.is_symlink());
}

/// Returns the output of a program. Panics after a time limit, because such a program would never end.
#[cfg(unix)]
#[track_caller]
fn in_time(mut child: Child) -> Output {
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("it hangs");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

#[cfg(unix)]
#[test]
fn pipes_do_not_block_and_are_not_replaced() {
    use std::os::unix::fs::FileTypeExt as _;
    let workshop = Workshop::with_recordings();
    let path = workshop.file("pipe.json");
    if !Command::new("mkfifo").arg(&path).status().is_ok_and(|made| made.success()) {
        tools::skipped("mkfifo", "there is no mkfifo");
        return;
    }
    for arguments in [
        "apply pipe.json a.csv --out .",
        "fit --train a.csv --columns pipe.json",
        "fit --train a.csv --factory pipe.json",
        "fit --train pipe.json",
        "inspect pipe.json",
        "metrology a.csv --calibration pipe.json",
        "fit --train a.csv --export pipe.json --force",
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let mut job = program(workshop.path(), &arguments);
        let job = job.stdout(Stdio::piped()).stderr(Stdio::piped());
        let output = in_time(job.spawn().unwrap());
        let message = stderr(&output);
        assert!(!output.status.success(), "{arguments:?}");
        assert!(
            message.contains("pipe.json") && message.contains("a pipe or a device"),
            "{message}"
        );
    }
    assert!(fs::metadata(&path).unwrap().file_type().is_fifo());
}

/// A file size limit of half a kilobyte has the same effect as a full disk.
#[cfg(target_os = "linux")]
#[test]
fn the_error_of_a_full_disk_names_the_requested_file() {
    let workshop = Workshop::with_recordings();
    let limited = "trap '' XFSZ; ulimit -f 1; exec \"$0\" fit --train a.csv --export c.json";
    let output = Command::new("sh")
        .args(["-c", limited, env!("CARGO_BIN_EXE_loopscope")])
        .current_dir(workshop.path())
        .output()
        .unwrap();
    let message = stderr(&output);
    assert!(!output.status.success(), "{message}");
    assert!(message.contains("cannot write c.json: File too large"), "{message}");
    assert!(!message.contains(".part"), "{message}");
    assert_eq!(names(&workshop), ["a.csv", "b.csv", "c.csv", "test.csv"]);
}

/// The second export fails after the first export is complete. No new file may appear, and the old file must stay.
#[cfg(target_os = "linux")]
#[test]
fn an_export_that_fails_leaves_no_other_file() {
    let workshop = Workshop::with_recordings();
    workshop.write("old.csv", "old");
    let limited = "trap '' XFSZ; ulimit -f 6; exec \"$0\" fit --train a.csv --force \
        --export k.csv --export old.csv --export k.json --traces t.csv";
    let output = Command::new("sh")
        .args(["-c", limited, env!("CARGO_BIN_EXE_loopscope")])
        .current_dir(workshop.path())
        .output()
        .unwrap();
    let message = stderr(&output);
    assert!(!output.status.success(), "{message}");
    assert!(message.contains("File too large"), "{message}");
    assert_eq!(workshop.read("old.csv"), "old");
    assert_eq!(names(&workshop), ["a.csv", "b.csv", "c.csv", "old.csv", "test.csv"]);
}

/// The program must read the factory calibration before it writes any file.
#[test]
fn a_factory_calibration_that_cannot_be_read_leaves_no_export() {
    let workshop = Workshop::with_recordings();
    workshop.write("f.cal", "<FTSensor/>");
    refused(
        &workshop,
        "fit --train a.csv --factory f.cal --export k.json --traces t.csv",
        &["f.cal"],
    );
}

#[cfg(target_os = "linux")]
fn signal(child: &Child, name: &str) {
    let kill = format!("kill -{name} {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
}

/// Returns the running program, paused by a signal while it writes a file.
#[cfg(target_os = "linux")]
fn stopped_while_writing(workshop: &Workshop, arguments: &[&str]) -> Child {
    let mut child = program(workshop.path(), arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let is_writing = || names(workshop).iter().any(|name| name.ends_with(".part"));
    while !is_writing() {
        assert!(
            child.try_wait().unwrap().is_none(),
            "the program ended before its temporary file was seen"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    signal(&child, "STOP");
    let is_stopped = || {
        let state = fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
        state.contains(") T ")
    };
    while !is_stopped() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(is_writing(), "the program ended before it was stopped");
    child
}

#[cfg(target_os = "linux")]
#[test]
fn temporary_files_of_an_interrupted_program_are_removed_at_once_and_of_a_killed_one_at_the_next_write()
 {
    let workshop = Workshop::new();
    workshop.write("t.csv", "old");
    let traces = ["fit", "--look-back", "none", "--traces", "t.csv", "--force"];
    if receives_interrupts() {
        let child = stopped_while_writing(&workshop, &traces);
        signal(&child, "TERM");
        signal(&child, "CONT");
        assert_eq!(in_time(child).status.code(), Some(143));
        assert_eq!(names(&workshop), ["t.csv"]);
        assert_eq!(workshop.read("t.csv"), "old");
        let child = stopped_while_writing(&workshop, &traces);
        signal(&child, "INT");
        signal(&child, "CONT");
        assert_eq!(in_time(child).status.code(), Some(130));
    }
    let child = stopped_while_writing(&workshop, &traces);
    signal(&child, "KILL");
    in_time(child);
    let left = names(&workshop);
    assert!(left.len() == 2 && left[0].starts_with(".loopscope-t.csv-"), "{left:?}");
    assert_eq!(workshop.read("t.csv"), "old");
    succeed(workshop.path(), &["fit", "--decimate", "100", "--traces", "t.csv", "--force"]);
    assert_eq!(names(&workshop), ["t.csv"]);
    assert_ne!(workshop.read("t.csv"), "old");
}

/// Returns true if programs receive interrupts. A script that starts the tests by `setsid … &` disables interrupts.
#[cfg(target_os = "linux")]
fn receives_interrupts() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap();
    let ignored = u64::from_str_radix(ignored.trim(), 16).unwrap();
    let (hang_up, interrupt) = (1, 2);
    ignored & (hang_up | interrupt) == 0
}

/// The search for a model takes minutes on the built-in sensor. The time to the first model depends on the machine.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_search_writes_its_results_so_far() {
    if !receives_interrupts() {
        let _ = writeln!(std::io::stderr(), "skipped: interrupts are ignored here");
        return;
    }
    let workshop = Workshop::new();
    let words = ["best", "--export", "c.json", "--minutes", "60", "--force"];
    let found = [1, 3, 9, 27].into_iter().any(|secs| {
        let child = program(workshop.path(), &words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs(secs));
        signal(&child, "INT");
        let output = in_time(child);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_ne!(output.status.code(), Some(0), "the search ended by itself");
        let table = String::from_utf8_lossy(&output.stdout).into_owned();
        let is_found = table.contains("Proposed: ");
        if is_found {
            assert_eq!(output.status.code(), Some(130), "{message}");
            assert!(message.contains("the results so far follow"), "{message}");
        }
        is_found
    });
    assert!(found && workshop.file("c.json").exists());
}
