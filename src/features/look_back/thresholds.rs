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

/// Rate at which samples are kept for look-backs and lags.
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

/// Thresholds of a look-back: [`F_TH`] and [`T_TH`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// F_th in N; for [`Distance::FullScale`] as a share of full scale, 0.1 for 10 %.
    pub f_th: f64,
    /// t_th in s.
    pub t_th_secs: f64,
}

impl Default for Thresholds {
    /// Returns the paper's thresholds (section 4.2): 3 N and 15 s.
    fn default() -> Self {
        Self::default_for(Distance::Force)
    }
}

impl Thresholds {
    /// Returns the paper's thresholds, 3 N and 15 s. 3 N is 0.25 of the 12 N for which the paper's sensor is rated.
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

/// Norm of the load difference that is compared with F_th. At run time, only conventional loads are known.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, strum::IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Distance {
    /// Euclidean norm over the force axes (N), as in the paper.
    #[default]
    Force,
    /// Euclidean norm over all axes, each divided by its full scale.
    FullScale,
}

impl Distance {
    pub const ALL: [Self; 2] = [Self::Force, Self::FullScale];

    pub fn option(self) -> &'static str {
        self.into()
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

    /// Returns the factor of each axis in the load difference. Without a force axis, the factor is 1 / full scale.
    pub fn weights(self, axes: &[Axis], full_scale: &[f64]) -> Vec<f64> {
        match self.effective(axes) {
            Self::Force => axes.iter().map(|axis| f64::from(axis.is_force())).collect(),
            Self::FullScale => full_scale
                .iter()
                .map(|&scale| if scale > 0.0 { 1.0 / scale } else { 0.0 })
                .collect(),
        }
    }

    /// Returns the norm that is used for these axes: [`Distance::FullScale`] if there is no force axis.
    pub fn effective(self, axes: &[Axis]) -> Self {
        if axes.iter().any(|axis| axis.is_force()) { self } else { Self::FullScale }
    }
}

/// Returns the index and the weight of each axis with a nonzero weight.
pub(crate) fn measured(weights: &[f64]) -> Vec<(usize, f64)> {
    let weights = weights.iter().copied().enumerate();
    weights.filter(|(_, weight)| *weight != 0.0).collect()
}
