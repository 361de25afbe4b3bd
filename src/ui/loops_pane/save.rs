//! Pictures of a plot: SVG from the lines themselves, PNG from the screen.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::app::{Command, FileContent, Level, Notice};
use crate::export::{Drawing, PICTURE_SIZE, write_drawing_svg};
use crate::ui::Reply;

/// Draws the field for the path with its button; `picture` is where the plot stands on screen.
pub(super) fn row(
    ui: &mut egui::Ui,
    path: &mut String,
    print: &Drawing<'_>,
    picture: egui::Rect,
    reply: &dyn Fn() -> Reply,
    out: &mut Vec<Command>,
) {
    ui.horizontal(|ui| {
        let label = ui.label("Picture");
        let field = egui::TextEdit::singleline(path).desired_width(150.0);
        ui.add(field).labelled_by(label.id);
        let save = ui.button("Save").on_hover_text(
            "A path ending in .svg gets the lines themselves, in .png the plot as it is on screen",
        );
        let path = path.trim();
        if !save.clicked() || path.is_empty() {
            return;
        }
        match ending(Path::new(path)).as_deref() {
            Some("svg") => out.push(svg(print, path.into())),
            Some("png") => png(ui, path.into(), picture, reply()),
            _ => out.push(error(format!(
                "{path}: the ending says no format; use .svg or .png"
            ))),
        }
    });
}

fn ending(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_lowercase())
}

fn error(text: String) -> Command {
    Command::Tell(Notice::new(Level::Error, text))
}

fn svg(print: &Drawing<'_>, path: PathBuf) -> Command {
    let mut bytes = Vec::new();
    match write_drawing_svg(print, PICTURE_SIZE, &mut bytes) {
        Ok(()) => Command::SaveFile(FileContent::Bytes(bytes.into()), path),
        Err(failed) => error(format!("{}: {failed}", path.display())),
    }
}

/// Asks for what is on screen; the answer comes after this frame was painted.
fn png(ui: &egui::Ui, path: PathBuf, picture: egui::Rect, reply: Reply) {
    let scale = ui.ctx().pixels_per_point();
    ui.ctx().request_screenshot(move |screen| {
        reply.send(match encoded(&screen, picture, scale) {
            Ok(bytes) => Command::SaveFile(FileContent::Bytes(bytes), path),
            Err(failed) => error(format!("{}: {failed}", path.display())),
        });
    });
}

/// The part of the screen as a PNG file.
fn encoded(
    screen: &egui::ColorImage,
    part: egui::Rect,
    scale: f32,
) -> Result<Arc<[u8]>, image::ImageError> {
    let [width, height] = screen.size;
    let inside = |value: f32, most: usize| (value.max(0.0) as usize).min(most);
    let (left, right) = (
        inside(part.min.x * scale, width),
        inside(part.max.x * scale, width),
    );
    let (top, bottom) = (
        inside(part.min.y * scale, height),
        inside(part.max.y * scale, height),
    );
    let rows = screen.pixels.chunks(width.max(1)).take(bottom).skip(top);
    let pixels: Vec<u8> = rows
        .flat_map(|row| &row[left..right])
        .flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()])
        .collect();
    let size = (
        right.saturating_sub(left) as u32,
        bottom.saturating_sub(top) as u32,
    );
    let mut file = Cursor::new(Vec::new());
    image::write_buffer_with_format(
        &mut file,
        &pixels,
        size.0,
        size.1,
        image::ExtendedColorType::Rgb8,
        image::ImageFormat::Png,
    )?;
    Ok(file.into_inner().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A screen of 4 × 3 pixels at two pixels a point: the part from (0.5, 0.5) to (2, 1.5) is 3 × 2 pixels.
    #[test]
    fn a_png_holds_the_part_of_the_screen_and_no_more() {
        let pixels = (0..12).map(|k| egui::Color32::from_gray(20 * k)).collect();
        let screen = egui::ColorImage::new([4, 3], pixels);
        let part = egui::Rect::from_min_max(egui::pos2(0.5, 0.5), egui::pos2(2.0, 9.0));
        let bytes = encoded(&screen, part, 2.0).unwrap();
        let image = image::load_from_memory(&bytes).unwrap().to_rgb8();
        assert_eq!(image.dimensions(), (3, 2));
        assert_eq!(image.get_pixel(0, 0).0, [100; 3]);
        assert_eq!(image.get_pixel(2, 1).0, [220; 3]);
    }
}
