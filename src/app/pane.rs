//! The panes that a window can show; where they stand is the window's affair.

use serde::{Deserialize, Serialize};

/// A part of the window that can be moved, closed and brought back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pane {
    /// The recordings with their roles.
    Recordings,
    /// Thresholds, blocks, regressor.
    Settings,
    /// Loads and errors over time.
    Traces,
    /// The map of thresholds, and what is suggested.
    Thresholds,
    /// Regressors side by side.
    Compare,
    /// Outputs over the load.
    Loops,
    /// The figures of a certificate.
    Metrology,
    /// RMSE per axis.
    Errors,
    /// The matrices and their way out.
    Calibration,
    /// Free text, kept with the session.
    Notes,
}

impl Pane {
    /// All of them, in the order in which menus list them.
    pub const ALL: [Self; 10] = [
        Self::Recordings,
        Self::Settings,
        Self::Traces,
        Self::Thresholds,
        Self::Compare,
        Self::Loops,
        Self::Metrology,
        Self::Errors,
        Self::Calibration,
        Self::Notes,
    ];

    /// What stands on its tab.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Recordings => "Recordings",
            Self::Settings => "Settings",
            Self::Traces => "Traces",
            Self::Thresholds => "Thresholds",
            Self::Compare => "Compare",
            Self::Loops => "Loops",
            Self::Metrology => "Metrology",
            Self::Errors => "Errors",
            Self::Calibration => "Calibration",
            Self::Notes => "Notes",
        }
    }

    /// What is in it.
    #[must_use]
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Recordings => "What was measured, and what each recording is for",
            Self::Settings => "Thresholds, what else is appended to the gauges, and the regressor",
            Self::Traces => "Loads and errors over time",
            Self::Thresholds => "The map of F_th and t_th, and which pair to take",
            Self::Compare => "Every regressor without and with the past",
            Self::Loops => "Hysteresis loops, cross-plots, and drift at rest",
            Self::Metrology => "The figures of a certificate, Conv. beside Comp.",
            Self::Errors => "RMSE per axis: on train, on test, and by cross-validation",
            Self::Calibration => "The matrices with their features named, and their export",
            Self::Notes => "Free text that is saved with the session",
        }
    }
}
