//! Controls of numeric and on/off settings, and the search for the control of a setting.

use egui::{Align, DragValue, Id, Response};
use egui::{Ui, emath::Numeric};

use crate::{features::Setting, ui::controls::Controls as _};

pub fn number<N: Numeric>(ui: &mut Ui, setting: &Setting, value: &mut N) {
    let (min, max) = setting.range.ends();
    let mut field = DragValue::new(value).range(min..=max).speed(setting.step);
    if !N::INTEGRAL {
        field = field.max_decimals(6);
    }
    found(setting, &ui.field(setting.label, field, setting.help()));
}

pub fn switch(ui: &mut Ui, setting: &Setting, on: &mut bool) {
    let switch = ui.checkbox(on, setting.label);
    found(setting, &switch.on_hover_text(setting.help()));
}

/// Switches a feature off or on. Removes the values of the feature if there are any; otherwise restores the removed values,
/// or inserts the defaults.
pub fn switched<V>(ui: &Ui, id: Id, values: &mut Vec<V>, default: &[V])
where
    V: Clone + Send + Sync + 'static,
{
    if values.is_empty() {
        let kept = ui.data(|data| data.get_temp::<Vec<V>>(id));
        *values = kept.unwrap_or_else(|| default.to_vec());
    } else {
        ui.data_mut(|data| data.insert_temp(id, std::mem::take(values)));
    }
}

/// Maximum number of frames in which a control is searched. The control may not be on screen at all.
const FRAMES_TO_FIND: u32 = 8;

/// Setting whose control is searched, and number of frames before the search ends.
type Sought = (Setting, u32);

fn sought_id() -> Id {
    Id::unique("setting to scroll to")
}

/// Scrolls to the control of this setting and gives it the focus, as soon as the control is drawn.
pub fn seek(context: &egui::Context, setting: Setting) {
    context.data_mut(|data| data.insert_temp::<Sought>(sought_id(), (setting, FRAMES_TO_FIND)));
    context.request_repaint();
}

/// Marks a control as the control of a setting, and focuses the control if the setting is searched.
pub fn found(setting: &Setting, control: &Response) {
    let id = sought_id();
    let sought: Option<Sought> = control.ctx.data(|data| data.get_temp(id));
    let Some((_, frames)) = sought.filter(|(known, _)| known == setting) else {
        return;
    };
    if frames == 0 || control.has_focus() {
        control.ctx.data_mut(|data| data.remove::<Sought>(id));
        return;
    }
    // The focus is requested again in each frame, because the command palette keeps the keyboard focus for one frame after it
    // closes.
    control.request_focus();
    control.scroll_to_me(Some(Align::Center));
    control.ctx.data_mut(|data| data.insert_temp::<Sought>(id, (*setting, frames - 1)));
    control.ctx.request_repaint();
}
