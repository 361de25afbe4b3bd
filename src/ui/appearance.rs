//! Light or dark, and how large everything is.

use crate::app::{Preferences, Theme};

/// Makes the window look as the preferences say.
pub fn apply(context: &egui::Context, preferences: &Preferences) {
    context.set_theme(match preferences.theme {
        Theme::System => egui::ThemePreference::System,
        Theme::Light => egui::ThemePreference::Light,
        Theme::Dark => egui::ThemePreference::Dark,
    });
    context.set_zoom_factor(preferences.text_scale);
}
