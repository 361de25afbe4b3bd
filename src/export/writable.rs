//! Checks that all output files can be written, before the first is written.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use super::atomic::{check_writable, folder_of};
use crate::{
    export::atomic::WriteError,
    finding::{Advice, Way},
};

#[derive(Debug, thiserror::Error)]
pub enum TargetError {
    #[error("output {} would replace the input {}; choose another name", .output.display(), .input.display())]
    OverInput { input: PathBuf, output: PathBuf },
    #[error("{} and {} are the same file; choose different names", .first.display(), .second.display())]
    SameFile { first: PathBuf, second: PathBuf },
    #[error("{} already exists; choose another name, or allow it to be replaced", .path.display())]
    Exists { path: PathBuf },
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl Advice for TargetError {
    fn ways(&self) -> &'static [Way] {
        match self {
            Self::Exists { .. } => &[Way::Replace],
            _ => &[],
        }
    }
}

/// Checks that each output file can be written. No two outputs may be the same file, and no output may be an input. Existing
/// outputs are refused unless `replaced` is true.
///
/// # Errors
/// [`TargetError`] with the first output that cannot be written.
pub fn check_targets<'a>(
    inputs: impl IntoIterator<Item = &'a PathBuf>,
    outputs: &[PathBuf],
    replaced: bool,
) -> Result<(), TargetError> {
    let inputs: Vec<(&PathBuf, PathBuf)> = (inputs.into_iter())
        .filter_map(|input| Some((input, input.canonicalize().ok()?)))
        .collect();
    let places: Vec<(PathBuf, OsString)> = outputs.iter().map(|output| place(output)).collect();
    for (at, output) in outputs.iter().enumerate() {
        if let Ok(existing) = output.canonicalize()
            && let Some((input, _)) = inputs.iter().find(|(_, input)| *input == existing)
        {
            return Err(TargetError::OverInput {
                input: PathBuf::clone(input),
                output: output.clone(),
            });
        }
        if let Some(earlier) = places[..at].iter().position(|other| *other == places[at]) {
            return Err(TargetError::SameFile {
                first: outputs[earlier].clone(),
                second: output.clone(),
            });
        }
        // The path itself is checked, not the target of a link, so that a broken link also counts as an existing file.
        if !replaced && fs::symlink_metadata(output).is_ok() {
            return Err(TargetError::Exists { path: output.clone() });
        }
        check_writable(output)?;
    }
    Ok(())
}

/// Returns the folder and the name of a file after resolving symbolic links, to compare files.
fn place(path: &Path) -> (PathBuf, OsString) {
    let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let folder = folder_of(&whole);
    (
        folder.canonicalize().unwrap_or_else(|_| folder.to_owned()),
        whole.file_name().unwrap_or_default().to_owned(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(inputs: &[PathBuf], outputs: &[PathBuf], replaced: bool) -> Result<(), String> {
        check_targets(inputs, outputs, replaced).map_err(|error| error.to_string())
    }

    #[test]
    fn two_names_of_one_file_are_detected_even_if_it_does_not_exist() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        let twice = [at("a.h"), at("sub/../a.h")];
        assert!(check(&[], &twice, false).unwrap_err().contains("same file"));
        fs::write(at("a.h"), "").unwrap();
        assert!(check(&[], &twice, true).unwrap_err().contains("same file"));
        assert_eq!(check(&[], &[at("b.h"), at("sub/b.h")], false), Ok(()));
        assert!(!at("b.h").exists(), "the check does not change the file");
    }

    #[test]
    fn inputs_are_never_written_and_existing_files_only_if_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.csv"), "").unwrap();
        let a = [at("a.csv")];
        assert!(check(&a, &a, true).unwrap_err().contains("replace the input"));
        let exists = check_targets(&[], &a, false).unwrap_err();
        assert_eq!(exists.ways(), [Way::Replace]);
        assert_eq!(check(&[], &a, true), Ok(()));
        let gone = [at("gone/a.csv")];
        assert!(check(&[], &gone, true).unwrap_err().contains("no folder"));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_nothing_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("a.csv");
        std::os::unix::fs::symlink(folder.path().join("gone.csv"), &link).unwrap();
        let outputs = [link];
        assert!(check(&[], &outputs, false).unwrap_err().contains("already"));
        assert_eq!(check(&[], &outputs, true), Ok(()));
    }
}
