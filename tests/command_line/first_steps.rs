//! Runs the commands of the guide's tutorials.

use std::process::{Command, Output};

use crate::program::stderr;
use crate::tools;
use crate::workshop::Workshop;

const PAGE: &str = include_str!("../../assets/guide/first-steps.md");

/// Returns all code blocks of a section that are in this language, joined.
fn code(section: &str, language: &str) -> String {
    let of_section = PAGE.split("\n## ").find(|own| own.starts_with(section));
    let blocks = of_section.unwrap().split("```").skip(1).step_by(2);
    let own = blocks.filter_map(|block| block.strip_prefix(language)?.strip_prefix('\n'));
    let code: String = own.collect();
    assert!(!code.is_empty(), "{section} has no {language}");
    code
}

/// Runs the shell commands of a section, with the program in the path. Returns the output.
#[track_caller]
fn walk(workshop: &Workshop, section: &str) -> String {
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_loopscope"));
    let mut path = program.parent().unwrap().as_os_str().to_owned();
    path.push(":");
    path.push(std::env::var_os("PATH").unwrap_or_default());
    let output: Output = Command::new("sh")
        .args(["-e", "-c", &code(section, "sh")])
        .current_dir(workshop.path())
        .env("PATH", path)
        .output()
        .unwrap();
    assert!(output.status.success(), "{section}: {}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
#[cfg(unix)]
fn own_files_become_a_calibration_by_the_commands_of_the_guide() {
    let workshop = Workshop::new();
    let text = walk(&workshop, "Your own files, on the command line");
    assert!(text.contains("Enough: the recordings determine the model"), "{text}");
    for file in ["sensor.json", "loads/test_path6_mount1_fast_loads.csv", "report.html"] {
        assert!(!workshop.read(file).is_empty(), "{file}");
    }
}

#[test]
#[cfg(unix)]
fn the_guide_s_program_in_cpp_computes_the_load_of_apply() {
    if !tools::is_there("g++", &["--version"]) {
        return;
    }
    let workshop = Workshop::new();
    let section = "From the built-in sensor to C++ on a robot";
    workshop.write("main.cpp", code(section, "cpp"));
    let text = walk(&workshop, section);
    let mut last = text.lines().rev();
    let (applied, run) =
        (last.next().unwrap(), last.find(|line| line.contains(" s: Fx ")).unwrap());
    let table = workshop.read("loads/test_path6_mount1_fast_loads.csv");
    let header = table.lines().next().unwrap();
    let column = |name: &str| {
        let mut heads = header.split(',');
        let at = heads.position(|head| head.starts_with(name)).unwrap();
        applied.split(',').nth(at).unwrap().parse::<f64>().unwrap()
    };
    let printed: Vec<f64> = (run.split([' ', ','])).filter_map(|word| word.parse().ok()).collect();
    let expected = [column("t "), column("Fx compensated"), column("Fz compensated")];
    assert_eq!(printed.len(), 3, "{run}");
    for (printed, expected) in printed.iter().zip(expected) {
        assert!((printed - expected).abs() < 6e-4, "{run}: {applied}");
    }
}
