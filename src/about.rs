//! Version, build and licences of the program, and the licences of its dependencies.

use std::sync::LazyLock;

pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Names and texts of the program's licences, of which the user can choose one.
pub const OWN_LICENCES: [(&str, &str); 2] =
    [("MIT", include_str!("../LICENSE-MIT")), ("Apache-2.0", include_str!("../LICENSE-APACHE"))];
/// Dependencies with their licences, as listed by `.ci/licences.py`.
pub const LICENCES_OF_CRATES: &str = include_str!("../assets/licences.txt");

const COMMIT: &str = env!("LOOPSCOPE_COMMIT");
const FEATURES: &str = env!("LOOPSCOPE_FEATURES");
const TARGET: &str = env!("LOOPSCOPE_TARGET");

/// Returns version, commit, features and target of this build, by name. They are displayed, and asked for in bug reports.
pub fn built() -> [(&'static str, &'static str); 4] {
    let commit = match COMMIT {
        "" if cfg!(debug_assertions) => "not recorded in a debug build",
        "" => "not known",
        commit => commit,
    };
    let features = match FEATURES {
        "" => "none",
        features => features,
    };
    [("version", VERSION), ("commit", commit), ("features", features), ("target", TARGET)]
}

/// Returns the text of `--version` after the program's name.
pub fn long_version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let rest = built().into_iter().skip(1);
        let rest = rest.map(|(name, value)| format!("\n{name}: {value}"));
        VERSION.to_owned() + &rest.collect::<String>()
    });
    &TEXT
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// If this test fails, run `.ci/licences.py`.
    #[test]
    fn the_licences_are_those_of_the_crates_that_are_locked() {
        let lock = include_str!("../Cargo.lock");
        let mut locked = BTreeSet::new();
        let mut name = "";
        for line in lock.lines() {
            let quoted = |key| line.strip_prefix(key)?.strip_suffix('"');
            name = quoted("name = \"").unwrap_or(name);
            if let Some(version) = quoted("version = \"") {
                locked.insert(format!("{name} {version}"));
            }
        }
        assert!(locked.remove(&format!("loopscope {VERSION}")));
        let lists = LICENCES_OF_CRATES.split("\n====").next().unwrap();
        let crates = lists.lines().skip(2).filter(|line| {
            !line.is_empty() && !line.starts_with(' ') && !line.starts_with("Only used")
        });
        let listed = crates.map(|line| line.split(':').next().unwrap().to_owned());
        let listed: BTreeSet<String> = listed.collect();
        let apart: Vec<_> = listed.symmetric_difference(&locked).collect();
        assert!(apart.is_empty(), "{apart:?}");
    }

    #[test]
    fn the_listed_features_are_those_of_the_build() {
        let [_, _, (_, features), _] = built();
        assert_eq!(features.split(' ').any(|own| own == "gui"), cfg!(feature = "gui"));
        assert_eq!(features.split(' ').any(|own| own == "xlsx"), cfg!(feature = "xlsx"));
    }
}
