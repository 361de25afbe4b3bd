//! Theme and text size of the window.

use crate::{
    engine::{Preferences, Theme},
    ui::palette,
};

/// Width of the window (points) below which the right column is closed until the user opens it.
const COMPACT: f32 = 1200.0;

/// Adds the code font as a fallback for arrows and superscripts. Turns off the keys by which egui itself changes the text
/// size.
pub fn prepare(context: &egui::Context) {
    let mut fonts = egui::FontDefinitions::default();
    let code = fonts.families.get(&egui::FontFamily::Monospace);
    let code = code.and_then(|names| names.first()).cloned();
    if let Some(usual) = fonts.families.get_mut(&egui::FontFamily::Proportional) {
        usual.extend(code);
    }
    context.set_fonts(fonts);
    for theme in [egui::Theme::Dark, egui::Theme::Light] {
        context.set_visuals_of(theme, palette::visuals(theme == egui::Theme::Dark));
    }
    // A thin bar shows at once that an area holds more than is seen.
    context.all_styles_mut(|style| style.spacing.scroll = egui::style::ScrollStyle::thin());
    // The program handles these keys itself and stores the text size in the preferences.
    context.options_mut(|options| options.zoom_with_keyboard = false);
}

/// Returns true if the window is so narrow that the right column is closed until the user opens it.
pub fn is_compact(ui: &egui::Ui) -> bool {
    ui.ctx().content_rect().width() < COMPACT
}

/// Draws a ring around a widget that has the keyboard focus but does not show it.
pub fn focus_ring(painter: &egui::Painter, around: egui::Rect) {
    let ring = painter.ctx().global_style().visuals.selection.stroke;
    painter.rect_stroke(around, 2.0, ring, egui::StrokeKind::Inside);
}

/// Applies the preferred theme, and the preferred text size multiplied by `larger`.
pub fn apply(context: &egui::Context, preferences: &Preferences, larger: f32) {
    context.set_theme(match preferences.theme {
        Theme::System => egui::ThemePreference::System,
        Theme::Light => egui::ThemePreference::Light,
        Theme::Dark => egui::ThemePreference::Dark,
    });
    context.set_zoom_factor(larger * preferences.text_scale);
}
