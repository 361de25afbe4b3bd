//! Input and output files of a command-line job. File patterns and folders are replaced by the recordings that they name.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::{
    error::{JobError, usage},
    messages::Messages,
};
use crate::{import, progress::Progress, recording::Role, shown::listed};

#[derive(Default)]
pub struct Files<'a> {
    /// Recordings, folders and file patterns (such as `run*.csv`) to read or to train on.
    pub recordings: &'a [PathBuf],
    /// Test recordings; `None` if the job has none, or splits each recording instead.
    pub test: Option<&'a [PathBuf]>,
    pub read: Vec<PathBuf>,
    pub written: Vec<PathBuf>,
    pub force: bool,
}

impl<'a> Files<'a> {
    /// Sets the recordings, if the user named any without `--train`.
    pub fn or_these(mut self, recordings: &'a [PathBuf]) -> Self {
        if !recordings.is_empty() {
            self.recordings = recordings;
        }
        self
    }

    pub fn reading<'b>(mut self, paths: impl IntoIterator<Item = &'b PathBuf>) -> Self {
        self.read.extend(paths.into_iter().cloned());
        self
    }

    /// Adds files that the job writes. Existing files are overwritten only with `force`.
    pub fn writing<'b>(
        mut self,
        paths: impl IntoIterator<Item = &'b PathBuf>,
        force: bool,
    ) -> Self {
        self.written.extend(paths.into_iter().cloned());
        self.force = force;
        self
    }

    /// Finds the recordings. In a folder, files whose names begin with `test` are not used for training. They are the test
    /// recordings, unless the user names other ones.
    pub fn opened(&self, say: &Messages) -> Result<Inputs, JobError> {
        let mut inputs = Inputs {
            recordings: opened(self.recordings)?,
            test: opened(self.test.unwrap_or_default())?,
            read: self.read.clone(),
        };
        if self.test.is_some() {
            let is_test = |input: &Input| {
                input.folder.is_some() && Role::of_name(&input.name()) == Role::Test
            };
            let (tests, train) = inputs.recordings.into_iter().partition(is_test);
            inputs.recordings = train;
            inputs.take_tests(tests, say)?;
        }
        inputs.check_distinct()?;
        Ok(inputs)
    }
}

#[derive(Debug)]
pub struct Input {
    pub path: PathBuf,
    /// Folder that the user named and that contains this file; `None` if the user named the file itself.
    folder: Option<PathBuf>,
}

impl Input {
    fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into()
    }

    /// Returns the error of an unusable file. If the user named a folder, the error says that the file is one of several in it.
    pub fn refused(&self, error: JobError) -> JobError {
        let read = |folder: &PathBuf| import::read(folder, None, &[], &Progress::default()).err();
        match self.folder.as_ref().and_then(read) {
            Some(folder) => JobError::Usage(format!(
                "{error}. The file is in {folder}; --keep-going skips unreadable files"
            )),
            None => error,
        }
    }
}

#[derive(Debug, Default)]
pub struct Inputs {
    pub recordings: Vec<Input>,
    pub test: Vec<Input>,
    read: Vec<PathBuf>,
}

impl Inputs {
    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.recordings().chain(&self.read)
    }

    fn recordings(&self) -> impl Iterator<Item = &PathBuf> {
        self.recordings.iter().chain(&self.test).map(|input| &input.path)
    }

    fn take_tests(&mut self, tests: Vec<Input>, say: &Messages) -> Result<(), JobError> {
        let role = if self.test.is_empty() {
            "the test recordings"
        } else {
            "not used, because --test names the test recordings"
        };
        for same_folder in tests.chunk_by(|first, second| first.folder == second.folder) {
            let folder = same_folder[0].folder.as_deref().unwrap_or(Path::new("")).display();
            let names = listed(&same_folder.iter().map(Input::name).collect::<Vec<_>>());
            say.note(format_args!(
                "{folder}: files whose names begin with test are {role}: {names}"
            ));
        }
        if self.recordings.is_empty() && !tests.is_empty() {
            return usage(
                "the names of all recordings in the folder begin with test, so none is left for training; name the training files",
            );
        }
        if self.test.is_empty() {
            self.test = tests;
        }
        Ok(())
    }

    /// Checks that no recording is named twice. If one were used for both training and test, the errors would be too small.
    fn check_distinct(&self) -> Result<(), JobError> {
        let mut seen: HashMap<PathBuf, &PathBuf> = HashMap::new();
        for path in self.recordings() {
            // A missing file is reported later, when it is read.
            let Ok(whole) = path.canonicalize() else { continue };
            if let Some(first) = seen.insert(whole, path) {
                return usage(format!(
                    "{} and {} are the same recording; name each file once, for training or for --test",
                    first.display(),
                    path.display()
                ));
            }
        }
        Ok(())
    }
}

/// Replaces each file pattern by the files that match it, because some shells do not replace patterns.
pub fn expanded(paths: &[PathBuf]) -> impl Iterator<Item = PathBuf> {
    paths.iter().flat_map(|path| import::matching(path).unwrap_or_else(|| vec![path.clone()]))
}

/// Replaces each file pattern by the files that match it, and each folder by the recordings in it.
fn opened(paths: &[PathBuf]) -> Result<Vec<Input>, JobError> {
    let mut opened = Vec::with_capacity(paths.len());
    for path in expanded(paths) {
        let refused = |what| JobError::Usage(format!("{}: {what}", path.display()));
        if import::is_pattern(&path) && !path.exists() {
            return Err(refused("no file matches this name"));
        }
        if !path.is_dir() {
            opened.push(Input { path, folder: None });
            continue;
        }
        let inside = import::recordings_in(&path).map_err(|error| {
            JobError::other(format!("cannot read the folder {}: {error}", path.display()))
        })?;
        if inside.is_empty() {
            return Err(refused("the folder contains no recordings"));
        }
        opened.extend(
            inside.into_iter().map(|file| Input { path: file, folder: Some(path.clone()) }),
        );
    }
    Ok(opened)
}
