//! What a past sample must be: how far in load, how old, and what distances are measured over.

use serde::{Deserialize, Serialize};

use crate::features::setting::{Range, Setting, Unit};
use crate::recording::Axis;

/// How much the load must have differed; the paper's choice (section 4.2).
pub const F_TH: Setting = Setting {
    key: "f_th",
    option: "f-th",
    label: "F_th",
    what: "F_th",
    unit: Unit::NEWTONS,
    default: &[3.0],
    range: Range::NotNegative,
    step: 0.1,
    explanation: "How much the load must have differed: the gauges at the last moment when the conventional load differed by \
                  this much are appended to the present ones. With 0 Comp. equals Conv.; near the mean hysteresis (2.64 N in \
                  the paper) it helps most",
    source: "Eq. 9-12, Fig. 2",
};

/// How old the past sample may be; the paper's choice (section 4.2).
pub const T_TH: Setting = Setting {
    key: "t_th_secs",
    option: "t-th",
    label: "t_th",
    what: "t_th",
    unit: Unit::SECONDS,
    default: &[15.0],
    range: Range::NotNegative,
    step: 0.1,
    explanation: "How old the past sample may be. With 0 s there is no past, and Comp. equals Conv.",
    source: "Eq. 12",
};

/// How often a sample is kept to be looked back at.
pub const HISTORY_RATE: Setting = Setting {
    key: "history_rate_hz",
    option: "history-rate",
    label: "History rate",
    what: "the history rate",
    unit: Unit::new("Hz", "hertz", ["HZ"; 2]),
    default: &[0.0],
    range: Range::NotNegative,
    step: 1.0,
    explanation: "How many samples a second are kept for look-backs and lags, in the fit as on the robot: fewer take less memory \
                  and time there. 0 keeps all samples of the training recordings' rate",
    source: "",
};

/// The two thresholds of the look-back: [`F_TH`] and [`T_TH`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// F_th: (N), or a share of full scale (1 = full scale) for [`Distance::FullScale`].
    pub f_th: f64,
    /// t_th (s).
    pub t_th_secs: f64,
}

impl Default for Thresholds {
    /// The paper's choice (section 4.2): 3 N and 15 s.
    fn default() -> Self {
        Self::default_for(Distance::Force)
    }
}

impl Thresholds {
    /// The paper's choice, 3 N and 15 s; over full scale the same 3 N of its sensor's rated 12 N.
    pub fn default_for(distance: Distance) -> Self {
        Self {
            f_th: match distance {
                Distance::Force => F_TH.number(),
                Distance::FullScale => 0.25,
            },
            t_th_secs: T_TH.number(),
        }
    }
}

/// What "different by F_th" is measured in: always on the *conventional* load, the only one known at run time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Distance {
    /// Euclidean norm over the force axes (N), as in the paper.
    #[default]
    Force,
    /// Euclidean norm over all axes, each divided by its full scale (1).
    FullScale,
}

impl Distance {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Force, Self::FullScale];

    /// Its name on the command line.
    pub fn option(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::FullScale => "full-scale",
        }
    }

    /// Its title.
    pub fn label(self) -> &'static str {
        match self {
            Self::Force => "forces [N]",
            Self::FullScale => "all axes [% FS]",
        }
    }

    /// What it is.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Force => "Norm of the force difference in newtons, as in the paper",
            Self::FullScale => {
                "Norm over all axes, each divided by its full scale: for sensors whose moments move on their own"
            }
        }
    }

    /// An F_th with its unit.
    pub fn in_words(self, f_th: f64) -> String {
        match self {
            Self::Force => format!("F_th {f_th} N"),
            Self::FullScale => format!("F_th {} % of full scale", 100.0 * f_th),
        }
    }

    /// The factor for each axis: d is the norm of the differences times these.
    ///
    /// Without a force axis there is nothing to measure in newtons, so all axes over full scale take their place.
    pub fn weights(self, axes: &[Axis], full_scale: &[f64]) -> Vec<f64> {
        match self.effective(axes) {
            Self::Force => axes.iter().map(|axis| f64::from(axis.is_force())).collect(),
            Self::FullScale => full_scale
                .iter()
                .map(|&scale| if scale > 0.0 { 1.0 / scale } else { 0.0 })
                .collect(),
        }
    }

    /// The kind that is really used with these axes: [`Distance::FullScale`] where there is no force axis.
    pub fn effective(self, axes: &[Axis]) -> Self {
        if axes.iter().any(|axis| axis.is_force()) { self } else { Self::FullScale }
    }
}

/// The axes that a distance is measured over, with their weights.
pub(crate) fn measured(weights: &[f64]) -> Vec<(usize, f64)> {
    let weights = weights.iter().copied().enumerate();
    weights.filter(|(_, weight)| *weight != 0.0).collect()
}
