//! What can be asked of the state, and what it asks of the window.

use std::path::PathBuf;
use std::sync::Arc;

use crate::analysis::{Analysis, Candidate, HistoryBlock, Request, View};
use crate::app::{
    Choices, ComparisonCommand, Existing, FileContent, ImportCommand, KnownOf, OpenedSession, Pane,
    Preferences, SessionCommand, StudyCommand, StudyRequest, TrainingCommand, Wish,
};
use crate::calibration::{Calibration, FitSettings};
use crate::evaluation::threshold_study::Measure;
use crate::recording::columns::ColumnMap;
use crate::recording::delimited::Loaded;
use crate::recording::{Axis, RecordingSet, Role, Tare};

/// A wish: from a panel, or the result of background work.
#[derive(Clone, Debug)]
pub enum Command {
    /// Change the choices of the fit.
    SetSettings(FitSettings),
    /// Give a recording a role.
    SetRole(usize, Role),
    /// Give every recording with a reference a role.
    SetAllRoles(Role),
    /// Tare these recordings.
    Tare(Vec<usize>, Tare),
    /// They are tared: the recordings of before, and those of now.
    Tared(Arc<RecordingSet>, Result<RecordingSet, String>),
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
    /// What only the window can do.
    Wish(Wish),
    /// These panes are on screen now.
    PanesOnScreen(Vec<Pane>),
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
    /// Compare no longer with the matrix that the sensor came with.
    DropFactory,
    /// Ask where to write a report.
    ChooseReport,
    /// Ask where to write the traces that are on screen: this stretch of time, or all.
    ChooseTraces(Option<(f64, f64)>),
    /// Ask where to write the calibration.
    ChooseExport,
    /// Write the calibration.
    Export(PathBuf, Existing),
    /// Write a file.
    Save(FileContent, PathBuf, Existing),
    /// Ask where to write this; the name is a suggestion.
    ChooseFileFor(FileContent, &'static str),
    /// There was no dialog to ask with: let a path be typed.
    TypePathFor(FileContent, String),
    /// The path was typed, or not.
    PathTyped(Option<PathBuf>),
    /// The file is there already: ask whether to replace it.
    AskToReplace(FileContent, PathBuf),
    /// The answer: replace it, or leave it.
    Replace(bool),
    /// Writing has ended.
    Saved(PathBuf, Result<(), String>),
    /// An analysis has ended.
    Analysed(Result<Arc<Analysis>, String>),
    /// Something to tell.
    Tell(crate::app::Notice),
    /// Take notice `n` away.
    DismissNotice(usize),
    /// Take all notices away.
    DismissNotices,
    /// What is remembered of a person has changed.
    SetPreferences(Preferences),
    /// Go back or forward to these choices.
    Restore(Choices),
    /// What concerns files whose columns have to be said.
    Import(ImportCommand),
    /// What concerns sessions.
    Session(SessionCommand),
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

/// What a file held.
#[derive(Clone, Debug)]
pub enum Opened {
    /// Recordings, with what was remarkable about reading them, and the map that they were read by if any.
    Recordings(Loaded, Option<Box<ColumnMap>>),
    /// A calibration.
    Calibration(Arc<Calibration>),
    /// The matrix that the sensor came with.
    Factory(Arc<Calibration>),
    /// A session with its files.
    Session(Box<OpenedSession>),
    /// Its columns have to be said first, for this reason.
    WantsMap(String),
}

/// A file with what it held, or why it could not be read.
pub type OpenedFile = (PathBuf, Result<Opened, String>);

/// What the window must do for the state.
#[derive(Clone, Debug)]
pub enum Effect {
    /// Analyse this; the newest wish wins.
    Analyse(Request),
    /// Read these files, each by its map if it has one; one whose names say too little by the map of its shape.
    Read(Vec<(PathBuf, Option<ColumnMap>)>, Vec<ColumnMap>),
    /// Tare these recordings.
    Tare(Arc<RecordingSet>, Vec<usize>, Tare),
    /// Look at a file; the newest wish wins.
    Inspect(PathBuf, KnownOf),
    /// Read a column map.
    ReadMap(PathBuf),
    /// Find the weight in a file by this map; tell it with [`ImportCommand::WeightEstimated`].
    EstimateWeight(PathBuf, Box<ColumnMap>),
    /// Ask for a file to import with a dialog.
    AskForImport,
    /// Read this autosaved session; tell it with [`SessionCommand::Recovered`].
    Restore(PathBuf),
    /// Drop this autosaved session.
    DropLeft(PathBuf),
    /// Make the built-in recordings.
    Simulate,
    /// What only the window can do.
    Wish(Wish),
    /// Ask for files with a dialog.
    AskForFiles,
    /// Ask where to write this with a dialog; the name is a suggestion.
    AskWhere(FileContent, String),
    /// Write a file.
    Write(FileContent, PathBuf, Existing),
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
    /// Make the map of thresholds, and say what the present ones touch; the newest wish wins.
    Study(StudyRequest),
    /// Choose a block's numbers by cross-validation.
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
    /// Stop background work.
    CancelWork,
}
