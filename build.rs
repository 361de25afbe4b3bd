//! Says what the program is built from and with. The same source and the same settings give the same words: no times, no paths.

use std::env;
use std::path::Path;
use std::process::Command;

/// Packagers who build without the repository name the commit here.
const COMMIT: &str = "LOOPSCOPE_COMMIT";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed={COMMIT}");
    let given = env::var(COMMIT).ok().filter(|commit| !commit.is_empty());
    let commit = given.or_else(commit).unwrap_or_default();
    println!("cargo:rustc-env={COMMIT}={commit}");
    let target = env::var("TARGET").unwrap_or_default();
    println!("cargo:rustc-env=LOOPSCOPE_TARGET={target}");
    let features = env::vars().filter_map(|(name, _)| {
        let feature = name.strip_prefix("CARGO_FEATURE_")?.to_lowercase();
        (feature != "default").then_some(feature)
    });
    let mut features: Vec<String> = features.collect();
    features.sort();
    println!("cargo:rustc-env=LOOPSCOPE_FEATURES={}", features.join(" "));
}

/// The commit of the repository, or the one that a published crate was packed from. A debug build has none: every commit would
/// build everything anew.
fn commit() -> Option<String> {
    if env::var("PROFILE").ok()? != "release" {
        return None;
    }
    let packed = ".cargo_vcs_info.json";
    if Path::new(packed).exists() {
        println!("cargo:rerun-if-changed={packed}");
        let text = std::fs::read_to_string(packed).ok()?;
        let (_, rest) = text.split_once("\"sha1\"")?;
        return Some(rest.split('"').nth(1)?.chars().take(7).collect());
    }
    // Another repository around this folder is none of ours.
    if !Path::new(".git").exists() {
        return None;
    }
    // The head changes with the branch, its log with every commit.
    for name in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--git-path", name])?;
        if Path::new(&path).exists() {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    git(&["rev-parse", "--short", "HEAD"])
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| said.trim().to_owned())
}
