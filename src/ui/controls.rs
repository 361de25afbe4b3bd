//! Controls that all panes use, each with a hover text.

use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{
    Align, Button, Layout, PopupCloseBehavior, Rect, Response, RichText, Role, ScrollArea, Ui,
    UiBuilder, Widget, WidgetInfo, WidgetText,
};

use crate::engine::Engine;

pub trait Controls {
    fn this_ui(&mut self) -> &mut Ui;

    /// Draws a button. Returns true if it was pressed.
    fn press(&mut self, label: impl Into<WidgetText>, about: impl Into<WidgetText>) -> bool {
        self.press_if(true, label, about)
    }

    /// Draws a button that is enabled only if the action is possible. Returns true if it was pressed.
    fn press_if(
        &mut self,
        makes_sense: bool,
        label: impl Into<WidgetText>,
        about: impl Into<WidgetText>,
    ) -> bool {
        let button = Button::new(label.into());
        let button = self.this_ui().add_enabled(makes_sense, button);
        button.on_hover_text(about).clicked()
    }

    fn press_small(&mut self, label: impl Into<WidgetText>, about: impl Into<WidgetText>) -> bool {
        let button = self.this_ui().small_button(label.into());
        button.on_hover_text(about).clicked()
    }

    fn tick(
        &mut self,
        on: &mut bool,
        label: impl Into<WidgetText>,
        about: impl Into<WidgetText>,
    ) -> bool {
        let tick = self.this_ui().checkbox(on, label.into());
        tick.on_hover_text(about).changed()
    }

    fn select<T: PartialEq>(&mut self, chosen: &mut T, one: T, label: &str, about: &str) {
        let button = self.this_ui().selectable_value(chosen, one, label);
        button.on_hover_text(about);
    }

    /// Draws a selectable button for each value, with its label and explanation, and then a separator.
    fn select_from<'a, T: PartialEq>(
        &mut self,
        chosen: &mut T,
        values: impl IntoIterator<Item = (T, &'a str, &'a str)>,
    ) {
        for (one, label, about) in values {
            self.select(chosen, one, label, about);
        }
        self.this_ui().separator();
    }

    fn select_radio<T: PartialEq>(&mut self, chosen: &mut T, one: T, label: &str, about: &str) {
        let button = self.this_ui().radio_value(chosen, one, label);
        button.on_hover_text(about);
    }

    fn field(
        &mut self,
        label: impl Into<WidgetText>,
        field: impl Widget,
        about: impl Into<WidgetText>,
    ) -> Response {
        let about = about.into();
        let label = self.this_ui().label(label).on_hover_text(about.clone());
        self.this_ui().add(field).labelled_by(label.id).on_hover_text(about)
    }

    /// Draws a button that copies a table to the clipboard.
    fn copies(&mut self, what: &str, text: impl FnOnce() -> String) {
        let about = format!("Copies the {what} as tab-separated text");
        if self.press(format!("Copy {what}"), about) {
            self.this_ui().copy_text(text());
        }
    }

    /// Returns true if the user pressed Enter in this text field.
    fn entered(&mut self, field: &Response) -> bool {
        let ui = self.this_ui();
        field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter))
    }

    fn warn(&mut self, text: impl Into<RichText>) -> Response {
        let ui = self.this_ui();
        ui.colored_label(ui.visuals().warn_fg_color, text)
    }

    fn fail(&mut self, text: impl Into<RichText>) -> Response {
        let ui = self.this_ui();
        ui.colored_label(ui.visuals().error_fg_color, text)
    }

    /// Says why a result is not there yet: no recordings are loaded, or the result is still being computed.
    fn awaited(&mut self, what: &str, engine: &Engine) {
        self.this_ui().weak(if engine.project().recordings.entries().is_empty() {
            format!("{what} appears here as soon as recordings are loaded.")
        } else {
            format!("{what} is being computed.")
        });
    }

    /// Draws contents in the free area of the pane, with scroll bars if they do not fit.
    fn scrolled(&mut self, contents: impl FnOnce(&mut Ui)) {
        let area = ScrollArea::both().auto_shrink([false, false]);
        area.show(self.this_ui(), contents);
    }

    /// Draws a button that opens a menu of input fields. The menu stays open while the fields are used.
    fn menu_of_fields(&mut self, button: Button<'_>, contents: impl FnOnce(&mut Ui)) -> Response {
        let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
        let menu = MenuButton::from_button(button).config(stays);
        menu.ui(self.this_ui(), contents).0
    }
}

/// Gives a widget a name for screen readers.
pub fn named(widget: &Response, role: Role, name: &str) {
    widget.widget_info(|| WidgetInfo::labeled(role, widget.enabled(), name));
}

/// Gives a widget that can be selected a name for screen readers.
pub fn named_selected(widget: &Response, role: Role, is_selected: bool, name: &str) {
    widget.widget_info(|| WidgetInfo::selected(role, widget.enabled(), is_selected, name));
}

/// Divides a row from left to right into places of these widths (points), with gaps between them. The place of infinite width
/// takes the rest.
pub fn cells<const N: usize>(row: Rect, gap: f32, widths: [f32; N]) -> [Rect; N] {
    let fixed: f32 = widths.iter().filter(|width| width.is_finite()).sum();
    let rest = row.width() - fixed - gap * (N - 1) as f32;
    let mut left = row.left();
    widths.map(|width| {
        let width = if width.is_finite() { width } else { rest };
        let place = row.with_min_x(left).with_max_x(left + width);
        left += width + gap;
        place
    })
}

/// Draws contents in a fixed place, from left to right and centred vertically.
pub fn place<R>(ui: &mut Ui, rect: Rect, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let layout = Layout::left_to_right(Align::Center);
    ui.scope_builder(UiBuilder::new().max_rect(rect).layout(layout), contents).inner
}

/// Draws contents in a fixed place, from top to bottom. `id` distinguishes it from the other places of the pane.
pub fn place_down<R>(ui: &mut Ui, rect: Rect, id: &str, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let layout = Layout::top_down(Align::Min);
    let place = UiBuilder::new().max_rect(rect).layout(layout).id_salt(id);
    ui.scope_builder(place, contents).inner
}

/// Draws contents at the right end of a fixed place.
pub fn place_right<R>(ui: &mut Ui, rect: Rect, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let layout = Layout::right_to_left(Align::Center);
    ui.scope_builder(UiBuilder::new().max_rect(rect).layout(layout), contents).inner
}

impl Controls for Ui {
    fn this_ui(&mut self) -> &mut Ui {
        self
    }
}
