//! Colours: the same for Calc., Conv. and Comp. everywhere, apart for colour-blind eyes too (Okabe and Ito 2008).

use egui::{Color32, Stroke, Visuals};

use crate::calibration::Regressor;
use crate::report::figure::color;

/// One of the three loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trace {
    /// The true load.
    Calculated,
    /// From the present gauges.
    Conventional,
    /// With what the past adds.
    Compensated,
    /// By the matrix that the sensor came with.
    Factory,
}

impl Trace {
    /// All, in the order in which they are drawn: the later over the earlier.
    pub const ALL: [Self; 4] = [
        Self::Calculated,
        Self::Factory,
        Self::Conventional,
        Self::Compensated,
    ];

    /// The paper's abbreviation.
    pub fn label(self) -> &'static str {
        match self {
            Self::Calculated => "Calc.",
            Self::Conventional => "Conv.",
            Self::Compensated => "Comp.",
            Self::Factory => "Factory",
        }
    }

    /// What the abbreviation stands for.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Calculated => "Calculated: the load that was really applied",
            Self::Conventional => "Conventional: from the present gauges alone (Eq. 3-8)",
            Self::Compensated => {
                "Compensated: from the present gauges and those of the past sample (Eq. 9-12)"
            }
            Self::Factory => "By the matrix that the sensor came with",
        }
    }

    pub fn color(self, visuals: &Visuals) -> Color32 {
        match (self, visuals.dark_mode) {
            (Self::Calculated, true) => Color32::from_gray(215),
            (Self::Calculated, false) => rgb(color::CALCULATED),
            (Self::Conventional, true) => Color32::from_rgb(240, 165, 40),
            (Self::Conventional, false) => rgb(color::CONVENTIONAL),
            (Self::Factory, true) => rgb(color::PURPLE),
            (Self::Factory, false) => rgb(color::FACTORY),
            (Self::Compensated, true) => rgb(color::SKY),
            (Self::Compensated, false) => rgb(color::COMPENSATED),
        }
    }

    /// Whether it is dashed, so that it can be told apart without its colour.
    pub fn is_dashed(self) -> bool {
        matches!(self, Self::Conventional | Self::Factory)
    }

    pub fn stroke(self, visuals: &Visuals) -> Stroke {
        let width = match self {
            Self::Calculated => 1.8,
            Self::Conventional | Self::Factory => 1.2,
            Self::Compensated => 1.4,
        };
        Stroke::new(width, self.color(visuals))
    }
}

/// A colour of the figures as egui has it.
pub fn rgb([red, green, blue]: [u8; 3]) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

/// The colour of a regressor in tables and bars.
pub fn regressor(regressor: Regressor, visuals: &Visuals) -> Color32 {
    let color = match regressor {
        Regressor::Linear => color::BLUE,
        Regressor::Network => color::VERMILION,
        Regressor::Kernel => color::GREEN,
        Regressor::HybridNetwork => color::PURPLE,
        Regressor::HybridKernel => [190, 160, 20],
    };
    // Lighter on a dark ground.
    rgb(match visuals.dark_mode {
        true => color.map(|value| value / 4 * 3 + 64),
        false => color,
    })
}

/// What marks the look-back.
pub fn look_back(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode {
        Color32::from_rgb(0, 200, 150)
    } else {
        Color32::from_rgb(0, 140, 105)
    }
}

/// Behind stretches where past = present.
pub fn without_past(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode {
        Color32::from_white_alpha(16)
    } else {
        Color32::from_black_alpha(20)
    }
}
