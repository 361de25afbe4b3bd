use serde::{Deserialize, Serialize};

use crate::features::setting::{Range, Setting, Unit};
use crate::recording::Axis;

/// Minimum load difference between present and past sample; the default is the paper's (section 4.2).
pub const F_TH: Setting = Setting {
    key: "f_th",
    option: "f-th",
    label: "F_th",
    what: "F_th",
    unit: Unit::NEWTONS,
    default: &[3.0],
    range: Range::NotNegative,
    step: 0.1,
    explanation: "Minimum load difference of the look-back: appends the gauges at the last moment when the conventional load \
                  differed by at least this much. With 0, Compensated equals Uncompensated. Values near the mean hysteresis \
                  (2.64 N in the paper) help most",
    source: "Eq. 9-12, Fig. 2",
};

/// Maximum age of the past sample; the default is the paper's (section 4.2).
pub const T_TH: Setting = Setting {
    key: "t_th_secs",
    option: "t-th",
    label: "t_th",
    what: "t_th",
    unit: Unit::SECONDS,
    default: &[15.0],
    range: Range::NotNegative,
    step: 0.1,
    explanation: "Maximum age of the past sample. With 0 s, Compensated equals Uncompensated",
    source: "Eq. 12",
};

/// Rate at which samples are kept for look-backs.
pub const HISTORY_RATE: Setting = Setting {
    key: "history_rate_hz",
    option: "history-rate",
    label: "History rate",
    what: "the history rate",
    unit: Unit::new("Hz", "hertz", ["HZ"; 2]),
    default: &[0.0],
    range: Range::NotNegative,
    step: 1.0,
    explanation: "Number of samples per second kept for look-backs and lags, in the fit and on the robot. A lower rate needs less memory \
                  and time on the robot. 0 keeps all samples",
    source: "",
};

/// The two thresholds of the look-back: [`F_TH`] and [`T_TH`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// F_th in N, or as a share of full scale (1 = full scale) for [`Distance::FullScale`].
    pub f_th: f64,
    /// t_th in s.
    pub t_th_secs: f64,
}

impl Default for Thresholds {
    /// Returns the paper's choice (section 4.2): 3 N and 15 s.
    fn default() -> Self {
        Self::default_for(Distance::Force)
    }
}

impl Thresholds {
    /// Returns the paper's choice, 3 N and 15 s; for full scale, 3 N over the 12 N that the paper's sensor is rated for.
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

/// Norm of the difference of the *conventional* load, the only load known at run time, that is compared with F_th.
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
    pub const ALL: [Self; 2] = [Self::Force, Self::FullScale];

    pub fn option(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::FullScale => "full-scale",
        }
    }

    pub fn label(self) -> &'static str {
        match self {
            Self::Force => "forces [N]",
            Self::FullScale => "all axes [% FS]",
        }
    }

    pub fn explanation(self) -> &'static str {
        match self {
            Self::Force => "Norm of the force difference in newtons, as in the paper",
            Self::FullScale => {
                "Norm over all axes, each divided by its full scale: for sensors whose moments change independently of the forces"
            }
        }
    }

    pub fn in_words(self, f_th: f64) -> String {
        match self {
            Self::Force => format!("F_th {f_th} N"),
            Self::FullScale => format!("F_th {} % of full scale", 100.0 * f_th),
        }
    }

    /// Returns the weight of each axis: the distance is the norm of the weighted difference. Without a force axis, all axes are
    /// weighted by the inverse of their full scale.
    pub fn weights(self, axes: &[Axis], full_scale: &[f64]) -> Vec<f64> {
        match self.effective(axes) {
            Self::Force => axes.iter().map(|axis| f64::from(axis.is_force())).collect(),
            Self::FullScale => full_scale
                .iter()
                .map(|&scale| if scale > 0.0 { 1.0 / scale } else { 0.0 })
                .collect(),
        }
    }

    /// Returns the norm in use for these axes: [`Distance::FullScale`] if there is no force axis.
    pub fn effective(self, axes: &[Axis]) -> Self {
        if axes.iter().any(|axis| axis.is_force()) { self } else { Self::FullScale }
    }
}

/// Returns the axes with a nonzero weight, and their weights.
pub(crate) fn measured(weights: &[f64]) -> Vec<(usize, f64)> {
    let weights = weights.iter().copied().enumerate();
    weights.filter(|(_, weight)| *weight != 0.0).collect()
}
