//! What only the window can do; the state passes it on.

use std::path::PathBuf;

use crate::app::Pane;

/// An arrangement of panes for one kind of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Settings, traces, errors and the matrix: the main job.
    Calibrate,
    /// Loops over the traces that they come from.
    InspectLoops,
    /// Sliders, traces, and what every other threshold would give.
    DemonstrateThresholds,
}

impl Preset {
    /// All of them.
    pub const ALL: [Self; 3] = [
        Self::Calibrate,
        Self::InspectLoops,
        Self::DemonstrateThresholds,
    ];

    /// What menus call it.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Calibrate => "Calibrate",
            Self::InspectLoops => "Inspect loops",
            Self::DemonstrateThresholds => "Demonstrate thresholds",
        }
    }
}

/// A part of the window (points from its upper left corner).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenPart {
    /// The upper left corner.
    pub min: [f32; 2],
    /// The lower right corner.
    pub max: [f32; 2],
}

/// Where a picture goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PictureTo {
    /// The clipboard.
    Clipboard,
    /// A file that is asked for.
    File,
    /// This file.
    Path(PathBuf),
}

/// What only the window can do.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// Bring this pane to the front, or back.
    ShowPane(Pane),
    /// Take this pane away.
    ClosePane(Pane),
    /// Arrange the panes so.
    Arrange(Preset),
    /// Take the last change of a setting or a role back.
    Undo,
    /// Make it again.
    Redo,
    /// Show what can be done, to search in.
    ShowPalette,
    /// Show or hide the keys and the words.
    ToggleHelp,
    /// Show or end the tour.
    Tour(bool),
    /// Show all of the time axis.
    FitView,
    /// The part of time that was shown before.
    ZoomBack,
    /// The part of time that was shown after.
    ZoomForward,
    /// Go through time, or stop.
    TogglePlay,
    /// Put cursor A (0) or B (1) at the sample under the pointer, or where it plays.
    PutCursor(usize),
    /// Make a picture of the whole window.
    PictureOfAll(PictureTo),
    /// Everything larger (1), smaller (-1), or as at first (0).
    TextScale(i8),
    /// Make a picture of a part of the window.
    Picture(ScreenPart, PictureTo),
    /// Tare this recording between the cursors: only the window knows where they stand.
    TareBetweenCursors(usize),
    /// Save the traces on screen: only the window knows which stretch that is.
    SaveTraces,
    /// Save the session here, or ask where: only the window knows how the panes stand.
    SaveSession(Option<PathBuf>),
    /// Put the panes where a session had them.
    Layout(serde_json::Value),
    /// Close the window.
    CloseNow,
}
