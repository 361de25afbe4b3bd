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

    /// What stands where.
    #[must_use]
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Calibrate => "Settings beside the traces, errors and matrices under them",
            Self::InspectLoops => "Loops over the traces that they come from",
            Self::DemonstrateThresholds => {
                "Sliders beside the traces, and under them what every other pair would give"
            }
        }
    }
}

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
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Left,
        Self::Right,
        Self::Top,
        Self::Bottom,
        Self::NextTabs,
        Self::Wider,
        Self::Narrower,
        Self::Taller,
        Self::Lower,
    ];

    /// What menus call it, after the pane's name.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Left => "to the left",
            Self::Right => "to the right",
            Self::Top => "to the top",
            Self::Bottom => "to the foot",
            Self::NextTabs => "to the next tabs",
            Self::Wider => "wider",
            Self::Narrower => "narrower",
            Self::Taller => "taller",
            Self::Lower => "lower",
        }
    }

    /// What becomes of the pane.
    #[must_use]
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Left | Self::Right | Self::Top | Self::Bottom => {
                "Along this edge of the window, beside all the others"
            }
            Self::NextTabs => "Among the tabs of the next group of panes",
            Self::Wider | Self::Narrower | Self::Taller | Self::Lower => {
                "Its neighbours give or take the room"
            }
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
    /// Give this pane another place or size.
    MovePane(Pane, PaneMove),
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
    /// So many times as much of the time axis.
    ZoomTime(f64),
    /// Earlier or later, in shares of what is on screen.
    MoveTime(f64),
    /// Go through time, or stop.
    TogglePlay,
    /// One sample forward (1) or back (-1).
    Step(i8),
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
