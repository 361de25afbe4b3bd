//! External tools of the tests, such as compilers. A test without its tool is skipped, and says so even if it passes. With
//! `LOOPSCOPE_TOOLS=all`, which `.ci/run` sets after it has installed the tools, a missing tool is a failure.

use std::io::Write as _;
use std::process::{Command, Stdio};

/// Tools that `.ci/run` does not install, because each of them takes several hundred megabytes or is not packaged.
const NEVER_REQUIRED: [&str; 4] = ["arm-none-eabi-gcc", "chromium", "mcap", "pyarrow"];

/// Returns true if the tool runs with these arguments.
#[track_caller]
pub fn is_there(tool: &str, arguments: &[&str]) -> bool {
    let mut command = Command::new(tool);
    let status = command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).status();
    let is_there = status.is_ok_and(|status| status.success());
    if !is_there {
        skipped(tool, &format!("{tool} {} does not run here", arguments.join(" ")));
    }
    is_there
}

/// Prints that the present test, or a part of it, is skipped because this tool is missing.
#[track_caller]
pub fn skipped(tool: &str, why: &str) {
    let are_all_required = std::env::var("LOOPSCOPE_TOOLS").is_ok_and(|tools| tools == "all");
    assert!(!are_all_required || NEVER_REQUIRED.contains(&tool), "LOOPSCOPE_TOOLS=all, but {why}");
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    // The macros for printing write only the output of failed tests.
    let _ = writeln!(std::io::stderr(), "skipped: {test}: {why}");
}
