//! Colours of the window. Each colour has one meaning in every pane and in the report, and has enough contrast. The colours
//! are distinguishable with any colour vision (Okabe and Ito 2008). Orange is the uncompensated load, blue the compensated
//! load, green the look-back (earlier gauge values), yellow a warning, red an error. The lines of training, test and held-out
//! errors differ by their dashes.

use egui::{Color32, Stroke, Visuals};

pub(crate) use crate::report::Trace;
use crate::{questions::loops::Inks, report::figure::color};

impl Trace {
    pub(super) fn color(self, visuals: &Visuals) -> Color32 {
        let (dark, light) = match self {
            Self::Calculated => (Color32::from_gray(215), color::CALCULATED),
            Self::Conventional => (Color32::from_rgb(240, 165, 40), color::CONVENTIONAL),
            Self::Factory => (rgb(color::PURPLE), color::FACTORY),
            Self::Compensated => (rgb(color::SKY), color::COMPENSATED),
        };
        if visuals.dark_mode { dark } else { rgb(light) }
    }

    /// Returns true if the line of this load is dashed, so that it can be recognised without its colour.
    pub fn is_dashed(self) -> bool {
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

pub fn rgb([red, green, blue]: [u8; 3]) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

pub fn bytes(color: Color32) -> [u8; 3] {
    [color.r(), color.g(), color.b()]
}

pub fn look_back(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(0, 200, 150) } else { rgb(color::LOOK_BACK) }
}

pub fn inks(visuals: &Visuals) -> Inks {
    Inks {
        conventional: bytes(Trace::Conventional.color(visuals)),
        compensated: bytes(Trace::Compensated.color(visuals)),
        gauge: bytes(look_back(visuals)),
        text: bytes(visuals.strong_text_color()),
        guide: bytes(visuals.weak_text_color()),
    }
}

/// Background colour of samples that look faulty.
pub fn faulty(visuals: &Visuals) -> Color32 {
    visuals.error_fg_color.gamma_multiply(0.28)
}

/// Colour of marks that show a present value, such as the cursors and the present thresholds.
pub fn present(visuals: &Visuals) -> Color32 {
    visuals.strong_text_color()
}

/// Returns the colours of egui in the dark or the light theme.
pub fn visuals(is_dark: bool) -> Visuals {
    let grey = Color32::from_gray;
    let mut visuals = if is_dark { Visuals::dark() } else { Visuals::light() };
    let text = grey(if is_dark { 180 } else { 60 });
    if is_dark {
        visuals.weak_text_color = Some(grey(145));
        visuals.warn_fg_color = Color32::from_rgb(240, 225, 80);
        visuals.error_fg_color = Color32::from_rgb(255, 115, 105);
    } else {
        visuals.weak_text_color = Some(rgb(color::GUIDE));
        visuals.warn_fg_color = Color32::from_rgb(115, 95, 0);
        visuals.error_fg_color = Color32::from_rgb(185, 0, 0);
        visuals.hyperlink_color = Color32::from_rgb(0, 90, 165);
        // Text fields get an outline, because a white field is hardly visible on a light pane.
        visuals.widgets.inactive.bg_stroke = Stroke::new(1.0, grey(170));
    }
    visuals.widgets.noninteractive.fg_stroke.color = text;
    visuals
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance and contrast ratio (Web Content Accessibility Guidelines 2.1, 1.4.3).
    fn contrast(one: Color32, other: Color32) -> f64 {
        let luminance = |color: Color32| {
            let [red, green, blue, _] = color.to_array().map(|value| {
                let value = f64::from(value) / 255.0;
                if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
            });
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        let (one, other) = (luminance(one), luminance(other));
        (one.max(other) + 0.05) / (one.min(other) + 0.05)
    }

    #[test]
    fn every_text_stands_out_from_what_it_stands_on() {
        for is_dark in [true, false] {
            let visuals = visuals(is_dark);
            let mut texts = vec![
                ("text", visuals.text_color()),
                ("weak", visuals.weak_text_color()),
                ("strong", visuals.strong_text_color()),
                ("warning", visuals.warn_fg_color),
                ("error", visuals.error_fg_color),
                ("link", visuals.hyperlink_color),
                ("look-back", look_back(&visuals)),
            ];
            texts.extend(Trace::ALL.map(|trace| (trace.label(), trace.color(&visuals))));
            let striped = visuals.panel_fill.blend(visuals.faint_bg_color);
            let grounds = [visuals.panel_fill, visuals.window_fill, visuals.extreme_bg_color];
            for (name, text) in texts {
                for ground in grounds.into_iter().chain([striped]) {
                    let ratio = contrast(text, ground);
                    assert!(ratio >= 4.5, "{name} on {ground:?}, dark {is_dark}: {ratio:.2}");
                }
            }
            for widget in [&visuals.widgets.inactive, &visuals.widgets.hovered] {
                let ratio = contrast(widget.fg_stroke.color, widget.weak_bg_fill);
                assert!(ratio >= 4.5, "a button, dark {is_dark}: {ratio:.2}");
            }
            let selection = visuals.selection;
            assert!(contrast(selection.stroke.color, selection.bg_fill) >= 4.5);
        }
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-9);
    }

    /// The sum of the differences in red, green and blue is at least 75.
    #[test]
    fn no_two_meanings_share_a_colour() {
        for is_dark in [true, false] {
            let visuals = visuals(is_dark);
            let meanings = [
                ("warning", visuals.warn_fg_color),
                ("error", visuals.error_fg_color),
                ("look-back", look_back(&visuals)),
                ("Uncompensated", Trace::Conventional.color(&visuals)),
                ("Compensated", Trace::Compensated.color(&visuals)),
                ("Factory", Trace::Factory.color(&visuals)),
                ("Reference", Trace::Calculated.color(&visuals)),
            ];
            for (at, (name, one)) in meanings.iter().enumerate() {
                for (other_name, other) in &meanings[at + 1..] {
                    let pairs = one.to_array().into_iter().zip(other.to_array());
                    let apart: u32 = pairs.map(|(a, b)| u32::from(a.abs_diff(b))).sum();
                    assert!(apart >= 75, "{name} and {other_name}, dark {is_dark}: {apart}");
                }
            }
        }
    }
}
