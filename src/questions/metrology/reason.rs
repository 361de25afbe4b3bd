//! Reasons why a metrology figure is missing, as sentences that take the place of the figure.

use std::borrow::Cow;

use crate::{
    recording::Axis,
    scoring::{
        holds::NoTimeConstant,
        lag::NoLag,
        loops::{FEWEST_CYCLES, FULL_SHARE, MOST},
        numbers::significant,
    },
    shown::counted,
};

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Reason {
    #[error(
        "no recording has a reference load for {axis}; record this load in a column named {axis}"
    )]
    NoReference { axis: Axis },
    #[error(
        "{axis} stays between {} and {} {}, within the reversal threshold of {} {}; apply a larger load, or choose a smaller reversal threshold", short(*.low), short(*.high), .axis.unit(), short(*.reversal_threshold), .axis.unit()
    )]
    ConstantLoad { axis: Axis, low: f64, high: f64, reversal_threshold: f64 },
    #[error(
        "the recordings are load cases without times, so {axis} has no loop, no dwell and no creep; record a motion, with its times in a column t"
    )]
    NoTimes { axis: Axis },
    #[error(
        "no load case of {axis} was measured twice, so the repeatability is unknown; measure load cases twice"
    )]
    NoRepeats { axis: Axis },
    #[error("{axis} only {} in every recording, so there is no second branch to compare; record a rising and a falling load", if *.rises { "rises" } else { "falls" })]
    OneBranch { axis: Axis, rises: bool },
    #[error(
        "{axis} has no cycle within a recording; record a rising and a falling load in one run"
    )]
    NoCycle { axis: Axis },
    #[error("this figure needs a rising load, but {axis} only falls; record a rising load")]
    NoRisingBranch { axis: Axis },
    #[error(
        "the branch of {axis} has samples at only {found} loads; load the axis more slowly, or record at a higher rate"
    )]
    TooFewLoads { axis: Axis, found: usize },
    #[error(
        "{axis} has {} (at least {} % of the largest cycle's range), with {} % of the load range in common; a mean loop needs {} \
         cycles with more than {} % in common. Only the largest cycle is shown", counted(*count, "full cycle"), short(100.0 * FULL_SHARE), short(100.0 * .share), FEWEST_CYCLES,
        short(100.0 * MOST)
    )]
    FewCycles { axis: Axis, count: usize, share: f64 },
    #[error(
        "no recording has two large branches of {axis} in the same direction; repeat the cycle in one run"
    )]
    TooFewCycles { axis: Axis },
    #[error(
        "no cycle of {axis} is repeated: no cycle turns at the same loads as the previous cycle; repeat the cycle in one run"
    )]
    NotRepeated { axis: Axis },
    #[error(
        "the cycles of {axis} are not repeated: at equal {axis}, the load on {other} differs; repeat the cycle with one axis loaded"
    )]
    OthersDiffer { axis: Axis, other: Axis },
    #[error(
        "this figure of {axis} is below the noise of the recordings, which alone could give {} {}; repeat the cycle, or record more slowly", significant(*.limit, 2), .axis.unit()
    )]
    BelowNoise { axis: Axis, limit: f64, percent: Option<f64> },
    #[error("no recording with a reference for {axis} has a channel in °C that changes by {} °C", short(*.least))]
    NoTemperature { axis: Axis, least: f64 },
    #[error("{axis} has no full scale, because the axis is never loaded; enter a full scale")]
    NoFullScale { axis: Axis },
    #[error(
        "no recording holds the load constant for {} s while {axis} is at {} % of full scale or above",
        short(*.secs), short(100.0 * .share)
    )]
    NoHold { axis: Axis, share: f64, secs: f64 },
    #[error(
        "no recording dwells at zero for {} s (every axis within {} % of full scale)",
        short(*.secs), short(100.0 * .share)
    )]
    NoZero { share: f64, secs: f64 },
    #[error(
        "no recording dwells at zero both before and after {axis} is at {} % of full scale or above", short(100.0 * .share)
    )]
    NoReturn { axis: Axis, share: f64 },
    #[error(
        "no recording dwells at zero after {axis} is at {} % of full scale or above", short(100.0 * .share)
    )]
    NoRecovery { axis: Axis, share: f64 },
    #[error("the time lag of {axis} is unknown: {reason}")]
    NoLag { axis: Axis, reason: NoLag },
    #[error("the time lag explains {:.0} % of the mean loop width of {axis}, so the hysteresis needs no correction for the lag", 100.0 * .share)]
    LagExplainsLittle { axis: Axis, share: f64 },
    #[error(
        "the time lag is uncertain, so the hysteresis of {axis} without the lag is uncertain by ± {} {}; load the axis more slowly", significant(*.uncertainty, 2), .axis.unit()
    )]
    LagTooUncertain { axis: Axis, uncertainty: f64 },
    #[error(transparent)]
    NoTimeConstant(#[from] NoTimeConstant),
    #[error("{axis} is the loaded axis, and an axis has no crosstalk onto itself")]
    LoadedAxis { axis: Axis },
    #[error("{axis} is the only axis, so there is no crosstalk")]
    OnlyAxis { axis: Axis },
    #[error(
        "no recording loads {axis} alone (to {} % of full scale or above, with every other axis within {} %)", short(100.0 * .loaded_share), short(100.0 * .alone_share)
    )]
    NeverAlone { axis: Axis, loaded_share: f64, alone_share: f64 },
    #[error(
        "while {axis} alone is loaded, its load hardly changes, so there is no slope; record {axis} loaded and unloaded in one run"
    )]
    NotLinear { axis: Axis },
    #[error(
        "{recording}: the load or the output of {axis} is not a finite number in sample {sample}"
    )]
    NotFinite { axis: Axis, recording: String, sample: usize },
    #[error("the loads or errors of {axis} are too large to compute with")]
    Overflow { axis: Axis },
}

impl Reason {
    /// Returns the reason in one or two words, for a narrow table cell.
    pub fn word(&self) -> Cow<'static, str> {
        Cow::Borrowed(match self {
            Self::BelowNoise { percent: Some(percent), .. } => {
                return format!("below noise ({} % FS)", significant(*percent, 2)).into();
            }
            Self::BelowNoise { .. } => "below noise",
            Self::NoTemperature { .. } => "no °C",
            Self::NoReference { .. } => "no ref.",
            Self::ConstantLoad { .. } => "constant",
            Self::NoTimes { .. } => "no times",
            Self::NoRepeats { .. } => "no repeats",
            Self::OneBranch { .. } => "1 branch",
            Self::NoCycle { .. } => "no cycle",
            Self::NoRisingBranch { .. } => "no rise",
            Self::TooFewLoads { .. } => "few loads",
            Self::FewCycles { .. } => "few cycles",
            Self::TooFewCycles { .. } => "1 cycle",
            Self::NotRepeated { .. } | Self::OthersDiffer { .. } => "no repeats",
            Self::NotLinear { .. } => "1 load",
            Self::NoFullScale { .. } => "no FS",
            Self::NoHold { .. } => "no dwell",
            Self::NoZero { .. } => "no zero",
            Self::NoReturn { .. } => "no return",
            Self::NoRecovery { .. } => "no zero",
            Self::NoTimeConstant(_) => "no τ",
            Self::NoLag { .. } | Self::LagTooUncertain { .. } => "not known",
            Self::LagExplainsLittle { .. } => "no lag",
            Self::LoadedAxis { .. } => "·",
            Self::OnlyAxis { .. } => "only axis",
            Self::NeverAlone { .. } => "not alone",
            Self::NotFinite { .. } => "not finite",
            Self::Overflow { .. } => "too large",
        })
    }
}

/// Returns a number as text with three significant digits, without trailing zeros.
fn short(value: f64) -> String {
    let digits = significant(value, 3);
    if digits.contains('.') && !digits.contains('e') {
        digits.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        digits
    }
}
