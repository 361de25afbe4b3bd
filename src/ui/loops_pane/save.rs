//! Saves a plot to a path that the user types: SVG with the lines as vectors, or PNG as on screen.

use super::InInks;
use crate::{
    engine::{Action, Existing, Level},
    questions::loops::Inks,
    ui::{
        command::{Command, ImageTo, Out},
        controls::Controls as _,
        picture::svg,
    },
};

/// Draws the field for the path and the button Save. `picture` is the area of the plot on screen.
pub fn row(
    ui: &mut egui::Ui,
    path: &mut String,
    figure: InInks<'_, '_>,
    picture: egui::Rect,
    out: &mut Out,
) {
    let about = [
        "Path of the figure; ends in .svg or .png",
        "Save",
        ".svg saves the lines as vectors, .png saves the plot as on screen",
    ];
    let path = ui.horizontal(|ui| ui.path_field("Figure", path, (150.0, ""), about)).inner;
    let Some(path) = path else { return };
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
    out.send(match ending.as_ref().and_then(|ending| ending.to_str()) {
        Some("svg") => Action::Save(svg(&figure(&Inks::PRINT)), path, Existing::Ask).into(),
        Some("png") => Command::Image(picture, ImageTo::Path(path)),
        _ => {
            let path = path.display();
            let text =
                format!("{path}: figures are saved as .svg or .png; choose one of these endings");
            Command::tell(Level::Error, text)
        }
    });
}
