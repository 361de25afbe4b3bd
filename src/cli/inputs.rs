//! The files that a job is told of; patterns and folders become the recordings that they stand for.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::error::{JobError, usage};
use super::messages::Messages;
use crate::import;
use crate::progress::Progress;
use crate::recording::Role;
use crate::shown::listed;

/// The files that a job is told of.
#[derive(Default)]
pub struct Files<'a> {
    /// Recordings that it reads, or trains on; folders and patterns among them.
    pub recordings: &'a [PathBuf],
    /// Recordings that it only tests on, if it trains.
    pub test: Option<&'a [PathBuf]>,
    /// Whether it tests on a part of each recording instead.
    pub is_split: bool,
    /// What it reads beside recordings.
    pub read: Vec<PathBuf>,
    /// What it writes.
    pub written: Vec<PathBuf>,
    /// Whether it writes over files that are there already.
    pub force: bool,
}

impl Files<'_> {
    /// These, and others that are read.
    pub fn reading<'b>(mut self, paths: impl IntoIterator<Item = &'b PathBuf>) -> Self {
        self.read.extend(paths.into_iter().cloned());
        self
    }

    /// These, and others that are written; over old ones only by `force`.
    pub fn writing<'b>(
        mut self,
        paths: impl IntoIterator<Item = &'b PathBuf>,
        force: bool,
    ) -> Self {
        self.written.extend(paths.into_iter().cloned());
        self.force = force;
        self
    }

    /// Finds the recordings.
    ///
    /// In a folder the files called `test…` are not for training. They are the test recordings unless others are named.
    pub fn opened(&self, say: &Messages) -> Result<Inputs, JobError> {
        let mut inputs = Inputs {
            recordings: opened(self.recordings)?,
            test: opened(self.test.unwrap_or_default())?,
            read: self.read.clone(),
        };
        if self.test.is_some() && !self.is_split {
            let is_test =
                |own: &Input| own.folder.is_some() && Role::of_name(&own.name()) == Role::Test;
            let (tests, train) = inputs.recordings.into_iter().partition(is_test);
            inputs.recordings = train;
            inputs.take_tests(tests, say)?;
        }
        inputs.check_distinct()?;
        Ok(inputs)
    }
}

/// A recording's file.
#[derive(Clone, Debug)]
pub struct Input {
    pub path: PathBuf,
    /// The folder that stood for it.
    folder: Option<PathBuf>,
}

impl Input {
    fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into()
    }

    /// Says why the file will not do; where its folder was named, that it is one of several.
    pub fn refused(&self, error: JobError) -> JobError {
        let read = |folder: &PathBuf| import::read(folder, None, &[], &Progress::default()).err();
        match self.folder.as_ref().and_then(read) {
            Some(folder) => JobError::Usage(format!(
                "{error}. It is in {folder}, or leave out what cannot be read by --keep-going"
            )),
            None => error,
        }
    }
}

/// The files that a job reads.
#[derive(Debug, Default)]
pub struct Inputs {
    /// Recordings that it reads, or trains on.
    pub recordings: Vec<Input>,
    /// Recordings that it only tests on.
    pub test: Vec<Input>,
    read: Vec<PathBuf>,
}

impl Inputs {
    /// Returns every file.
    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.recordings().chain(&self.read)
    }

    fn recordings(&self) -> impl Iterator<Item = &PathBuf> {
        self.recordings.iter().chain(&self.test).map(|input| &input.path)
    }

    fn take_tests(&mut self, tests: Vec<Input>, say: &Messages) -> Result<(), JobError> {
        let role = match self.test.is_empty() {
            true => "the test recordings",
            false => "not used, since the test recordings are named",
        };
        for own in tests.chunk_by(|first, second| first.folder == second.folder) {
            let folder = own[0].folder.as_deref().unwrap_or(Path::new("")).display();
            let names = listed(&own.iter().map(Input::name).collect::<Vec<_>>());
            say.note(format_args!("{folder}: files called test… are {role}: {names}"));
        }
        if self.recordings.is_empty() && !tests.is_empty() {
            return usage(
                "every recording in the folder is called test…, so none is left to train on; name the files to train on",
            );
        }
        if self.test.is_empty() {
            self.test = tests;
        }
        Ok(())
    }

    /// A recording that counts twice, or that a fit is scored on although it has seen it, makes the figures wrong.
    fn check_distinct(&self) -> Result<(), JobError> {
        let mut seen: HashMap<PathBuf, &PathBuf> = HashMap::new();
        for path in self.recordings() {
            // What is not there is reported where it is read.
            let Ok(whole) = path.canonicalize() else { continue };
            if let Some(first) = seen.insert(whole, path) {
                return usage(format!(
                    "{} and {} are the same recording; name each once, and under --test what the fit has not seen",
                    first.display(),
                    path.display()
                ));
            }
        }
        Ok(())
    }
}

/// Puts the files that patterns stand for in the places of the patterns: not every shell does it.
pub fn expanded(paths: &[PathBuf]) -> impl Iterator<Item = PathBuf> {
    paths.iter().flat_map(|path| import::matching(path).unwrap_or_else(|| vec![path.clone()]))
}

/// Returns the files with patterns expanded, and in the place of each folder the recordings in it.
fn opened(paths: &[PathBuf]) -> Result<Vec<Input>, JobError> {
    let mut opened = Vec::with_capacity(paths.len());
    for path in expanded(paths) {
        let refused = |what| JobError::Usage(format!("{}: {what}", path.display()));
        if import::is_pattern(&path) && !path.exists() {
            return Err(refused("no file is called like this"));
        }
        if !path.is_dir() {
            opened.push(Input { path, folder: None });
            continue;
        }
        let inside = import::recordings_in(&path).map_err(|error| {
            JobError::other(format!("cannot look into the directory {}: {error}", path.display()))
        })?;
        if inside.is_empty() {
            return Err(refused("the folder holds no recordings"));
        }
        opened.extend(
            inside.into_iter().map(|file| Input { path: file, folder: Some(path.clone()) }),
        );
    }
    Ok(opened)
}
