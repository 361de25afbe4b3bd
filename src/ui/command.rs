//! What panes, menus and keys ask for: something that the engine does, or that only the window can do.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::engine::{Action, Edit, FileContent, ImportCommand, Level, Notice};
use crate::features::Setting;

/// What a pane is called and what is in it; there is one of each.
#[derive(Debug)]
pub struct Kind {
    /// What it is called in files.
    pub key: &'static str,
    /// What stands on its tab.
    pub title: &'static str,
    /// What is in it.
    pub explanation: &'static str,
}

/// A part of the window that can be moved, closed and brought back.
#[derive(Clone, Copy, Debug)]
pub struct Pane(pub &'static Kind);

impl Pane {
    /// What stands on its tab.
    pub fn title(self) -> &'static str {
        self.0.title
    }

    /// What is in it.
    pub fn explanation(self) -> &'static str {
        self.0.explanation
    }
}

impl PartialEq for Pane {
    fn eq(&self, other: &Self) -> bool {
        self.0.key == other.0.key
    }
}

impl Eq for Pane {}

/// A change of a pane's place or size that needs no mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PaneMove {
    /// Along the left edge of the window.
    Left,
    /// Along the right edge of the window.
    Right,
    /// Along the upper edge of the window.
    Top,
    /// Along the lower edge of the window.
    Bottom,
    /// Among the tabs of the next group.
    NextTabs,
    /// More of the width.
    Wider,
    /// Less of the width.
    Narrower,
    /// More of the height.
    Taller,
    /// Less of the height.
    Lower,
}

impl PaneMove {
    const EDGE: &'static str = "Along this edge of the window, beside all the others";
    const SIZE: &'static str = "Its neighbours give or take the room";

    /// All of them, with what menus call them after the pane's name, and what becomes of the pane.
    pub const ALL: [(Self, &'static str, &'static str); 9] = [
        (Self::Left, "to the left", Self::EDGE),
        (Self::Right, "to the right", Self::EDGE),
        (Self::Top, "to the top", Self::EDGE),
        (Self::Bottom, "to the foot", Self::EDGE),
        (Self::NextTabs, "to the next tabs", "Among the tabs of the next group of panes"),
        (Self::Wider, "wider", Self::SIZE),
        (Self::Narrower, "narrower", Self::SIZE),
        (Self::Taller, "taller", Self::SIZE),
        (Self::Lower, "lower", Self::SIZE),
    ];
}

/// A kind of work, with the panes that it needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Workspace {
    /// Recordings, their roles and the sensor.
    Import,
    /// Settings, traces and errors.
    Calibrate,
    /// Loops, the traces that they come from, and the metrology figures.
    Loops,
    /// The error for every pair of thresholds.
    Thresholds,
    /// The models that were tried.
    Models,
    /// The data check, and a log that is still written.
    Check,
    /// The matrices and the files that they are written to.
    Export,
}

impl Workspace {
    /// All workspaces in the order of the work, with title and explanation.
    pub const ALL: [(Self, &'static str, &'static str); 7] = [
        (
            Self::Import,
            "Import",
            "Recordings with their roles, groups and faults; the sensor; notes",
        ),
        (Self::Calibrate, "Calibrate", "Settings beside the traces, with the errors under them"),
        (
            Self::Loops,
            "Loops",
            "Hysteresis loops, the traces that they come from, metrology figures",
        ),
        (
            Self::Thresholds,
            "Thresholds",
            "The sliders beside the traces, and the error for every pair",
        ),
        (Self::Models, "Models", "Finds the best model and compares the models that were tried"),
        (
            Self::Check,
            "Check",
            "Whether the recordings determine the model; a log that is still written",
        ),
        (Self::Export, "Export", "The calibration matrices and the files that they are written to"),
    ];
}

/// A change of the part of time that is shown, or of the sample that is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeMove {
    /// Show all of the time axis.
    Fit,
    /// The part of time that was shown before.
    Back,
    /// The part of time that was shown after.
    Forward,
    /// So many times as much of the time axis.
    Zoom(f64),
    /// Earlier or later, in shares of what is on screen.
    Move(f64),
    /// Go through time, or stop.
    TogglePlay,
    /// One sample forward (1) or back (-1).
    Step(i8),
    /// Put cursor A (0) or B (1) at the sample under the pointer, or where it plays.
    PutCursor(usize),
    /// Show or hide the table of the cursors.
    ToggleTable,
}

/// Where a picture of the screen goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ImageTo {
    /// The clipboard.
    Clipboard,
    /// A file that is asked for.
    File,
    /// This file.
    Path(PathBuf),
}

/// What is asked for.
#[derive(Clone, Debug)]
pub enum Command {
    /// What the engine does.
    Do(Action),
    /// Bring this pane to the front, in a workspace that has it.
    ShowPane(Pane),
    /// Take this pane away.
    ClosePane(Pane),
    /// Give this pane another place or size.
    MovePane(Pane, PaneMove),
    /// Open this pane in the workspace of now.
    OpenPane(Pane),
    /// Show this workspace.
    Show(Workspace),
    /// Give the workspace of now its first arrangement.
    ResetWorkspace,
    /// Let this pane fill the window, or show all of the workspace again.
    ToggleMaximized(Option<Pane>),
    /// Fill the screen with large panes and no menus, or end that.
    TogglePresenter,
    /// Show what can be done, to search in.
    ShowPalette,
    /// Show the control of this setting, and give it the focus.
    FindSetting(Setting),
    /// Show or hide the help.
    ToggleHelp,
    /// Show what the program is.
    ShowAbout,
    /// Show or hide the list of all notices.
    ToggleNotices,
    /// Show or end the tour.
    Tour(bool),
    /// Change what part of time is shown.
    Time(TimeMove),
    /// Everything larger (1), smaller (-1), or as at first (0).
    TextScale(i8),
    /// Make a picture of the whole window.
    ImageOfAll(ImageTo),
    /// Make a picture of a part of the window.
    Image(egui::Rect, ImageTo),
    /// Tare this recording between the cursors.
    TareBetweenCursors(usize),
    /// Ask which files to open.
    ChooseFiles,
    /// Ask which file to import.
    ChooseImport,
    /// Ask which file to follow.
    ChooseFollowed,
    /// Ask in which folder the session's files are now.
    ChooseLost,
    /// Ask where to write the calibration.
    ChooseExport,
    /// Ask where to write a report.
    ChooseReport,
    /// Ask where to write the traces that are on screen.
    ChooseTraces,
    /// Save the session where it was saved before, or ask where.
    SaveSession,
    /// Ask where to save the session.
    SaveSessionAs,
    /// Ask where to write this.
    ChooseFileFor(FileContent),
    /// There was no dialog to ask with: let a path be typed.
    TypePathFor(FileContent),
    /// The path was typed, or not.
    PathTyped(Option<PathBuf>),
}

impl Command {
    /// Says something.
    pub fn tell(level: Level, text: impl Into<String>) -> Self {
        Action::Tell(Notice::new(level, text)).into()
    }
}

impl From<Action> for Command {
    fn from(action: Action) -> Self {
        Self::Do(action)
    }
}

impl From<Edit> for Command {
    fn from(edit: Edit) -> Self {
        Action::Edit(edit).into()
    }
}

impl From<ImportCommand> for Command {
    fn from(command: ImportCommand) -> Self {
        Action::Import(command).into()
    }
}
