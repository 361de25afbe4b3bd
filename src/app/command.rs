//! What can be asked of the state, and what it asks of the window.

use std::path::PathBuf;
use std::sync::Arc;

use crate::analysis::{Analysis, Candidate, ComparedRow, HistoryBlock, Request, View};
use crate::app::{ComparisonCommand, Pane, StudyCommand, StudyRequest, TrainingCommand};
use crate::calibration::{Calibration, FitSettings};
use crate::evaluation::metrology::Metrology;
use crate::evaluation::threshold_study::{Measure, ThresholdMap};
use crate::recording::delimited::Loaded;
use crate::recording::{Axis, RecordingSet, Role};

/// A wish: from a panel, or the result of background work.
#[derive(Clone, Debug)]
pub enum Command {
    /// Change the choices of the fit.
    SetSettings(FitSettings),
    /// Give a recording a role.
    SetRole(usize, Role),
    /// Give every recording with a reference a role.
    SetAllRoles(Role),
    /// Close one recording.
    RemoveRecording(usize),
    /// Close all recordings.
    CloseRecordings,
    /// Cut each recording in time: this first share trains, the rest tests.
    Split(f64),
    /// Take the cut back.
    Unsplit,
    /// Put these recordings on screen.
    SetView(View),
    /// Put this pane in the middle of the window.
    ShowPane(Pane),
    /// Show or hide an axis.
    ShowAxis(Axis, bool),
    /// Ask which files to open.
    ChooseFiles,
    /// Open recordings or a calibration.
    OpenFiles(Vec<PathBuf>),
    /// Background reading has ended.
    FilesOpened(Vec<OpenedFile>),
    /// Open the built-in simulated sensor instead of what is loaded.
    OpenBuiltIn,
    /// The built-in sensor is ready.
    BuiltInReady(RecordingSet),
    /// Stop applying a calibration, fit again.
    FitAgain,
    /// Ask where to write the calibration.
    ChooseExport,
    /// Write the calibration.
    Export(PathBuf),
    /// Writing has ended.
    Exported(PathBuf, Result<(), String>),
    /// An analysis has ended.
    Analysed(Result<Arc<Analysis>, String>),
    /// Something to tell.
    Tell(crate::app::Notice),
    /// Take notice `n` away.
    DismissNotice(usize),
    /// Take all notices away.
    DismissNotices,
    /// Write a file.
    SaveFile(FileContent, PathBuf),
    /// What concerns training.
    Training(TrainingCommand),
    /// What concerns the comparison of regressors.
    Comparison(ComparisonCommand),
    /// What concerns the choice of thresholds.
    Study(StudyCommand),
    /// Stop background work.
    Cancel,
    /// Do nothing: the answer came another way.
    Nothing,
}

/// What is to be written into a file, besides calibrations.
#[derive(Clone, Debug)]
pub enum FileContent {
    /// The metrology table as CSV.
    Metrology(Arc<Metrology>),
    /// A finished file, such as a picture.
    Bytes(Arc<[u8]>),
}

/// What a file held.
#[derive(Clone, Debug)]
pub enum Opened {
    /// Recordings, with what was remarkable about reading them.
    Recordings(Loaded),
    /// A calibration.
    Calibration(Arc<Calibration>),
}

/// A file with what it held, or why it could not be read.
pub type OpenedFile = (PathBuf, Result<Opened, String>);

/// What the window must do for the state.
#[derive(Clone, Debug)]
pub enum Effect {
    /// Analyse this; the newest wish wins.
    Analyse(Request),
    /// Read these files.
    Read(Vec<PathBuf>),
    /// Make the built-in recordings.
    Simulate,
    /// Ask for files with a dialog.
    AskForFiles,
    /// Ask for a file to write with a dialog.
    AskForExport,
    /// Write a calibration.
    Write(Arc<Calibration>, PathBuf),
    /// Train a network or a kernel.
    Train(Request),
    /// Ask the training to stop.
    StopTraining,
    /// Fit these candidates, under this number.
    Compare {
        /// The number.
        run: u64,
        /// The recordings with their roles.
        recordings: Arc<RecordingSet>,
        /// What the candidates do not say.
        settings: FitSettings,
        /// What is fitted.
        candidates: Vec<Candidate>,
    },
    /// Ask the comparison to stop.
    StopComparing,
    /// Write a comparison.
    WriteComparison(Vec<ComparedRow>, PathBuf),
    /// Make the map of thresholds, and say what the present ones touch; the newest wish wins.
    Study(StudyRequest),
    /// Choose a block's numbers by leave-one-out.
    ChooseBlock {
        /// Which.
        block: HistoryBlock,
        /// Whose errors count; `None`: what is looked at first.
        measure: Option<Measure>,
        /// The recordings with their roles.
        recordings: Arc<RecordingSet>,
        /// Everything else.
        settings: FitSettings,
    },
    /// Write a map of thresholds with its curves.
    WriteStudy(Arc<ThresholdMap>, Measure, PathBuf),
    /// Write a file.
    WriteFile(FileContent, PathBuf),
    /// Stop background work.
    CancelWork,
}
