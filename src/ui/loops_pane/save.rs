//! Saves a plot to a typed path: SVG with the lines as vectors, PNG as on screen.

use std::path::Path;

use crate::engine::{Action, Existing, Level};
use crate::report::figure::Figure;
use crate::ui::command::{Command, ImageTo};
use crate::ui::controls::Controls as _;
use crate::ui::picture::svg;

/// Draws the field for the path and its button. `picture` is the plot's rectangle on screen.
pub(super) fn row(
    ui: &mut egui::Ui,
    path: &mut String,
    print: &Figure<'_>,
    picture: egui::Rect,
    out: &mut Vec<Command>,
) {
    ui.horizontal(|ui| {
        let field = egui::TextEdit::singleline(path).desired_width(150.0);
        ui.field("Figure", field, "Path of the figure; ends in .svg or .png");
        let save =
            ui.press("Save", ".svg saves the lines as vectors, .png saves the plot as on screen");
        let path = path.trim();
        if !save || path.is_empty() {
            return;
        }
        match ending(Path::new(path)).as_deref() {
            Some("svg") => out.push(Action::Save(svg(print), path.into(), Existing::Ask).into()),
            Some("png") => {
                let to = ImageTo::Path(path.into());
                out.push(Command::Image(picture, to));
            }
            _ => {
                let told = format!(
                    "{path}: figures are saved as .svg or .png; choose one of these endings"
                );
                out.push(Command::tell(Level::Error, told));
            }
        }
    });
}

fn ending(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_lowercase())
}
