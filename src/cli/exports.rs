//! `loopscope export`, and option `--export` of `fit` and `best`: write a calibration to files.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{
    error::{JobError, failed},
    inputs::Files,
    run::{Run, Work, examples},
    values::named_file,
};
use crate::{
    calibration::Calibration,
    export::{
        Footprint, Outline, Together, add_calibration, caution, known_target, listed_targets,
        read_with_notes,
    },
    finding::Face,
};

/// Write a stored calibration in other formats. The calibration is not fitted again, so its loads and errors stay the same.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope export sensor.json sensor.h sensor.zip", "writes C code, and a library with self-tests"),
]))]
pub struct ExportJob {
    /// Calibration (.json).
    #[arg(value_parser = named_file())]
    calibration: PathBuf,
    #[arg(required = true, value_name = "FILE", value_parser = named_file(), help = exported_help())]
    files: Vec<PathBuf>,
    /// Overwrite existing files, and export even a calibration that is not determined by its recordings.
    #[arg(long)]
    force: bool,
}

/// Returns the help text for the names of exported files.
pub fn exported_help() -> String {
    format!(
        "Write the calibration to this file. The file name ending selects the format. Can be given several times. Formats: {}",
        listed_targets()
    )
}

impl Work for ExportJob {
    fn files(&self) -> Files<'_> {
        Files::default().reading([&self.calibration]).writing(&self.files, self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        check_endings(&self.files)?;
        let calibration = stored(run, &self.calibration)?;
        check_formats(&self.files, &Outline::of(&calibration))?;
        check_determined(&calibration, self.force)?;
        let mut files = Together::default();
        add(run, &calibration, &self.files, &mut files)?;
        files.finish()?;
        self.files.iter().try_for_each(|path| run.print_path(path))
    }
}

/// Reads a calibration, and prints the notes about it.
pub fn stored(run: &Run, path: &Path) -> Result<Calibration, JobError> {
    let (calibration, notes) = read_with_notes(path)?;
    notes.iter().for_each(|note| run.say.note(note));
    Ok(calibration)
}

/// Checks that each file name ends like an export format (such as `.json` or `.h`).
pub fn check_endings(paths: &[PathBuf]) -> Result<(), JobError> {
    paths.iter().try_for_each(|path| known_target(path).map(drop).map_err(JobError::Usage))
}

/// Checks, before the fit, that each format can hold the calibration. All refusals are reported together, and nothing is
/// written.
pub fn check_formats(paths: &[PathBuf], outline: &Outline<'_>) -> Result<(), JobError> {
    let refusals = paths.iter().filter_map(|path| {
        let refusal = (known_target(path).ok()?.refusal)(outline)?;
        Some(format!("cannot write {}: {refusal}", path.display()))
    });
    let refusals: Vec<String> = refusals.collect();
    if refusals.is_empty() { Ok(()) } else { failed(refusals.join("; ")) }
}

/// Checks that the recordings have enough samples to determine the calibration. With `force`, every calibration passes.
pub fn check_determined(calibration: &Calibration, force: bool) -> Result<(), JobError> {
    match calibration.undetermined().filter(|_| !force) {
        None => Ok(()),
        Some(undetermined) => {
            let found = undetermined.finding().text(Face::CommandLine);
            failed(format!("{found}; --force exports it anyway"))
        }
    }
}

/// Adds a calibration to `files`, once for each of `paths`, in the format of its file name. Prints a warning if a format
/// cannot hold a part of it, and for C code the memory that a controller needs.
pub fn add(
    run: &Run,
    calibration: &Calibration,
    paths: &[PathBuf],
    files: &mut Together,
) -> Result<(), JobError> {
    for caution in paths.iter().filter_map(|path| caution(calibration, path)) {
        run.say.warning(caution);
    }
    for path in paths {
        add_calibration(files, calibration, path)?;
    }
    let is_for_controllers = |path: &PathBuf| {
        known_target(path).is_ok_and(|target| ["h", "zip"].contains(&target.endings[0]))
    };
    if paths.iter().any(is_for_controllers) {
        run.say.note(Footprint::of(calibration));
    }
    Ok(())
}
