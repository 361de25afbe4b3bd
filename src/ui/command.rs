//! Commands that panes, menus and keys send: each is an action of the engine (data, fits, files) or an action of the window.

use crate::{
    engine::{Action, Edit, FileContent, ImportCommand, Level, Notice},
    features::Setting,
    questions::thresholds::Along,
    ui::scope::AxisChoice,
};

/// A part of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pane {
    /// Name by which the program refers to the pane.
    pub key: &'static str,
    /// Title above the pane.
    pub title: &'static str,
}

impl Pane {
    pub(crate) const RECORDINGS: Self = Self::new("recordings", "Recordings");
    pub(crate) const SETTINGS: Self = Self::new("settings", "Settings");
    pub(crate) const TRACES: Self = Self::new("traces", "Traces");
    pub(crate) const LOOK_BACK: Self = Self::new("look-back", "Look-back");
    pub(crate) const THRESHOLDS: Self = Self::new("thresholds", "Thresholds");
    pub(crate) const PAIRS: Self = Self::new("pairs", "Good pairs");
    pub(crate) const MODELS: Self = Self::new("compare", "Models");
    pub(crate) const TRADE: Self = Self::new("trade", "Error against memory");
    pub(crate) const LOOPS: Self = Self::new("loops", "Loops");
    pub(crate) const AXES: Self = Self::new("axes", "Axes");
    pub(crate) const METROLOGY: Self = Self::new("metrology", "Metrology");
    pub(crate) const ERRORS: Self = Self::new("errors", "Errors (RMSE)");
    pub(crate) const CALIBRATION: Self = Self::new("calibration", "Calibration");
    pub(crate) const EXPORT: Self = Self::new("export", "Export");
    pub(crate) const NOTES: Self = Self::new("notes", "Notes");
    pub(crate) const LIVE: Self = Self::new("live", "Live");
    pub(crate) const CHECK: Self = Self::new("check", "Check");
    pub(crate) const CHANNELS: Self = Self::new("channels", "Channels");

    const fn new(key: &'static str, title: &'static str) -> Self {
        Self { key, title }
    }
}

/// Kind of work, with its own arrangement of panes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workspace {
    /// Recordings and their roles (training, test, off).
    Import,
    /// The load and the error over time, the model, and its errors.
    Calibrate,
    /// Hysteresis loops, their traces over time, and the metrology figures.
    Loops,
    /// Map of the model's error over pairs of force threshold and time threshold.
    Thresholds,
    /// List of the models that were tried.
    Models,
    /// Check of the recordings, and the loads of a log file to which rows are still being added.
    Check,
    /// Identity of the sensor, calibration matrices and their export.
    Export,
}

impl Workspace {
    /// All workspaces in the order of the work, with title and explanation.
    pub const ALL: [(Self, &'static str, &'static str); 7] = [
        (Self::Import, "Import", "Recordings with their roles, groups and faults; your notes"),
        (
            Self::Calibrate,
            "Calibrate",
            "The load and the error over time, the model, and its errors",
        ),
        (Self::Loops, "Loops", "Hysteresis loops, their traces over time, and metrology figures"),
        (
            Self::Thresholds,
            "Thresholds",
            "A map of the error for pairs of thresholds, and the best pair",
        ),
        (Self::Models, "Models", "Finds the best model and compares the models that were tried"),
        (
            Self::Check,
            "Check",
            "Checks whether the recordings determine the model, and shows a log file that is still being written",
        ),
        (
            Self::Export,
            "Export",
            "The identity of the sensor, the calibration matrices, and their export to files",
        ),
    ];
}

/// A change of the visible interval of time, or of the present sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeMove {
    /// Shows the whole time axis.
    Fit,
    /// Multiplies the length of the visible interval of time by this factor.
    Zoom(f64),
    /// Moves the visible interval of time by this share of its length; a negative share moves to earlier times.
    Move(f64),
    /// Plays through the recordings in time, or stops.
    TogglePlay,
    /// Goes one sample forward (1) or back (−1).
    Step(i8),
    /// Puts cursor A (0) or B (1) at the sample under the pointer, or at the playing position.
    PutCursor(usize),
    /// Shows or hides the table of the signals' values at cursors A and B.
    ToggleTable,
    /// Shows the compensated load, or hides it.
    ToggleCompensated,
}

/// Destination of an image of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageTo {
    /// The clipboard.
    Clipboard,
    /// A file that the user chooses.
    File,
}

/// Purpose for which the user chooses a path.
#[derive(Clone, Debug)]
pub enum PathFor {
    /// Files to open.
    Open,
    /// A file whose columns the user chooses.
    Import,
    /// A log file that is still being written.
    Follow,
    /// The folder that now holds the files of the session.
    Locate,
    /// The file to which this content is written.
    Save(FileContent),
}

/// Command of the user to the engine or the window.
#[derive(Clone, Debug)]
pub enum Command {
    /// Runs an action of the engine.
    Do(Action),
    /// Shows a pane, in a workspace that contains it or as a drawer.
    ShowPane(Pane),
    /// Shows a workspace.
    Show(Workspace),
    /// Opens a pane as a drawer over the workspace, or closes it.
    ToggleDrawer(Pane),
    /// Opens or closes the right column of a narrow window.
    ToggleRight,
    /// Shows these axes.
    Axes(AxisChoice),
    /// Shows the previous (-1) or next (1) recording.
    OtherRecording(i8),
    /// Moves a threshold by this number of steps.
    StepThreshold(Along, i32),
    /// Applies the remedy that the strip shows.
    Remedy,
    /// Shows the loads of the model with this number, until Escape restores the present model.
    Compare(u64),
    /// Maximises a pane, or shows all panes again.
    ToggleMaximized(Option<Pane>),
    /// Starts or ends presenter mode: full screen, larger text and no menus.
    TogglePresenter,
    /// Shows the loops in place of the map in presenter mode, or the map again.
    TogglePresentedLoops,
    /// Opens the command palette.
    ShowPalette,
    /// Shows the control of a setting, and moves the keyboard focus to it.
    FindSetting(Setting),
    /// Shows or hides the help.
    ToggleHelp,
    /// Shows the page of the guide with this index.
    ShowGuide(usize),
    /// Shows the About page.
    ShowAbout,
    /// Shows or hides the list of all notices.
    ToggleNotices,
    /// Changes the visible time or the present sample.
    Time(TimeMove),
    /// Enlarges (1), shrinks (-1) or resets (0) text and controls.
    TextScale(i8),
    /// Takes an image of this rectangle of the window.
    Image(egui::Rect, ImageTo),
    /// Tares the recording with this index by its gauges between the cursors.
    TareBetweenCursors(usize),
    /// Opens the dialog that asks for a path.
    Choose(PathFor),
    /// Lets the user type the path, because the computer has no file dialog, or because the user prefers to type.
    TypePath(PathFor),
    /// Asks where to write the calibration.
    ChooseExport,
    /// Asks where to write the report.
    ChooseReport,
    /// Asks for the file to which the shown traces are written.
    ChooseTraces,
    /// Saves the session to its file; asks for a path if the session has no file.
    SaveSession,
    /// Asks where to save the session.
    SaveSessionAs,
}

impl Command {
    /// Returns the command that shows a notice with this text.
    pub fn tell(level: Level, text: impl Into<String>) -> Self {
        Action::Notice(Notice::new(level, text)).into()
    }
}

/// Commands that were sent in one frame, in the order of their execution.
#[derive(Debug, Default)]
pub struct Out(pub Vec<Command>);

impl Out {
    pub fn send(&mut self, command: impl Into<Command>) {
        self.0.push(command.into());
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
