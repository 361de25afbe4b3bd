//! Colours: the same for Calc., Conv. and Comp. everywhere, apart for colour-blind eyes too (Okabe and Ito 2008).

use egui::{Color32, Stroke, Visuals};

pub(crate) use crate::report::Trace;
use crate::report::figure::color;

impl Trace {
    pub(super) fn color(self, visuals: &Visuals) -> Color32 {
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
    pub(super) fn is_dashed(self) -> bool {
        matches!(self, Self::Conventional | Self::Factory)
    }

    pub(super) fn stroke(self, visuals: &Visuals) -> Stroke {
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

/// What marks the look-back.
pub fn look_back(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode {
        Color32::from_rgb(0, 200, 150)
    } else {
        Color32::from_rgb(0, 140, 105)
    }
}

/// Behind intervals where past = present.
pub fn without_past(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode {
        Color32::from_white_alpha(16)
    } else {
        Color32::from_black_alpha(20)
    }
}
