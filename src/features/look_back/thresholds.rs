use serde::{Deserialize, Serialize};

use crate::{
    features::setting::{Range, Setting, Unit},
    recording::Axis,
};

/// Force threshold F_th of a look-back: minimum load difference between the present and the past sample. The default is that
/// of Koike et al. (2019), section 4.2.
pub const F_TH: Setting = Setting {
    key: "f_th",
    option: "f-th",
    label: "F_th",
    what: "the force threshold F_th",
    unit: Unit::NEWTONS,
    default: &[3.0],
    range: Range::NotNegative,
    step: 0.1,
    explanation: "Force threshold of the look-back: appends the gauge values of the last moment at which the conventional load \
                  differed from the present one by at least this much. With 0, Compensated equals Uncompensated. Values near \
                  the mean hysteresis of the sensor (2.64 N in the paper of Koike et al.) help most",
    source: "Eq. 9-12, Fig. 2",
};

/// Time threshold t_th of a look-back: maximum age of the past sample. The default is that of Koike et al. (2019), section
/// 4.2.
pub const T_TH: Setting = Setting {
    key: "t_th_secs",
    option: "t-th",
    label: "t_th",
    what: "the time threshold t_th",
    unit: Unit::SECONDS,
    default: &[15.0],
    range: Range::NotNegative,
    step: 0.1,
    explanation: "Time threshold of the look-back: maximum age of the earlier sample, whose gauge values it appends. With 0 s, \
                  Compensated equals Uncompensated",
    source: "Eq. 12",
};

/// Number of samples per second that are kept in memory for look-backs and lags.
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
                  and time on the robot. 0 keeps all samples. Without it, the highest rate is chosen that fits into 64 kB on a controller, \
                  or all samples if the error of an axis would grow by more than 2 %",
    source: "",
};

/// Force threshold [`F_TH`] and time threshold [`T_TH`] of a look-back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// Force threshold F_th in N. For [`Distance::FullScale`], it is a share of full scale: 0.1 means 10 %.
    pub f_th: f64,
    /// t_th in s.
    pub t_th_secs: f64,
}

impl Default for Thresholds {
    /// Returns the thresholds of Koike et al. (2019), section 4.2: 3 N and 15 s.
    fn default() -> Self {
        Self::default_for(Distance::Force)
    }
}

impl Thresholds {
    /// Returns the default thresholds for this norm of the load difference: 3 N or 0.25 of full scale, and 15 s. 3 N is 0.25
    /// of the 12 N for which the sensor of Koike et al. (2019) is rated.
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

/// Norm of the load difference that is compared with the force threshold F_th. The loads are those of the conventional
/// calibration (without look-back), because a robot knows no other loads.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, strum::IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Distance {
    /// Euclidean norm over the force axes (N), as in the paper of Koike et al. (2019).
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
            Self::Force => {
                "Euclidean norm of the force difference in newtons, without moments, as in the paper of Koike et al."
            }
            Self::FullScale => {
                "Norm of the load difference over all axes, each divided by its full scale: for sensors whose moments change independently of the forces"
            }
        }
    }

    pub fn in_words(self, f_th: f64) -> String {
        match self {
            Self::Force => format!("F_th {f_th} N"),
            Self::FullScale => format!("F_th {} % of full scale", 100.0 * f_th),
        }
    }

    /// Returns the factor of each axis in the load difference: 1 for forces and 0 for moments, or 1 / full scale for each
    /// axis. Without a force axis, the factors are always 1 / full scale.
    pub fn weights(self, axes: &[Axis], full_scale: &[f64]) -> Vec<f64> {
        match self.effective(axes) {
            Self::Force => axes.iter().map(|axis| f64::from(axis.is_force())).collect(),
            Self::FullScale => full_scale
                .iter()
                .map(|&scale| if scale > 0.0 { 1.0 / scale } else { 0.0 })
                .collect(),
        }
    }

    /// Returns the norm of the load difference that is used for these axes: [`Distance::FullScale`] if there is no force
    /// axis, else this norm.
    pub fn effective(self, axes: &[Axis]) -> Self {
        if axes.iter().any(|axis| axis.is_force()) { self } else { Self::FullScale }
    }
}

/// Returns index and weight of each load axis whose weight in the load difference is not zero.
pub(crate) fn measured(weights: &[f64]) -> Vec<(usize, f64)> {
    let weights = weights.iter().copied().enumerate();
    weights.filter(|(_, weight)| *weight != 0.0).collect()
}
