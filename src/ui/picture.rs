//! Images of parts of the window, copied to the clipboard or saved as PNG.

use std::io;
use std::sync::Arc;

use egui::{Color32, ColorImage, Rect};

use crate::{
    engine::{FileContent, Level},
    report::figure::{Figure, STANDS_ALONE, png},
    ui::{
        appearance::focus_ring,
        command::{Command, ImageTo, Out, PathFor},
        context_menu::context_menu,
        controls::Controls as _,
        dialogs::Reply,
    },
};

/// Number of frames to wait before an image is taken. After a press on a menu item, the menu stays on screen for one more
/// frame and would be in the image.
const FRAMES_TO_WAIT: u32 = 2;

#[derive(Debug, Default)]
pub struct Images(Vec<(u32, Rect, ImageTo)>);

/// Adds a context menu that copies or saves a plot, and draws a ring around the plot while it has the keyboard focus. `print`
/// returns the figure of the SVG file.
pub fn menu<'a>(
    response: &egui::Response,
    part: Rect,
    print: Option<&dyn Fn() -> Figure<'a>>,
    out: &mut Out,
) {
    if response.has_focus() {
        let painter = response.ctx.layer_painter(response.layer_id);
        focus_ring(&painter, response.rect);
    }
    context_menu(response, |ui| {
        let ways = [
            ("Copy plot", "Copies the plot to the clipboard, as on screen", ImageTo::Clipboard),
            ("Save as PNG…", "Saves the plot as on screen", ImageTo::File),
        ];
        let [first, _] = ways.map(|(label, explanation, to)| {
            let button = ui.button(label).on_hover_text(explanation);
            if button.clicked() {
                out.send(Command::Image(part, to));
                ui.close(); // a press by a key does not close the menu
            }
            button
        });
        if let Some(print) = print
            && ui.press(
                "Save as SVG…",
                "Saves the lines as vectors on a white background, for print",
            )
        {
            ui.close();
            out.send(Command::Choose(PathFor::Save(svg(&print()))));
        }
        first
    });
}

pub fn svg(print: &Figure<'_>) -> FileContent {
    FileContent::Bytes(print.svg(STANDS_ALONE).into_bytes().into())
}

impl Images {
    pub fn ask(&mut self, part: Rect, to: ImageTo) {
        self.0.push((FRAMES_TO_WAIT, part, to));
    }

    /// Requests screenshots for the images whose wait is over, and handles the screenshots that have arrived.
    pub fn take(&mut self, context: &egui::Context, reply: &Reply) {
        if self.0.is_empty() {
            return;
        }
        context.request_repaint();
        self.0.retain_mut(|(wait, part, to)| {
            *wait -= 1;
            if *wait > 0 {
                return true;
            }
            let (part, to, reply) = (*part, *to, reply.clone());
            let (clipboard, scale) = (context.clone(), context.pixels_per_point());
            context.request_screenshot(move |screen| {
                let picture = cut(&screen, part, scale);
                reply.send(match to {
                    ImageTo::Clipboard => {
                        clipboard.copy_image(picture);
                        Command::tell(Level::Info, "The plot was copied to the clipboard")
                    }
                    ImageTo::File => match encoded(&picture) {
                        Ok(png) => Command::Choose(PathFor::Save(FileContent::Bytes(png))),
                        Err(error) => Command::tell(Level::Error, error.to_string()),
                    },
                });
            });
            false
        });
    }
}

fn cut(screen: &ColorImage, part: Rect, scale: f32) -> ColorImage {
    let [width, height] = screen.size;
    let inside = |value: f32, most: usize| ((value * scale).max(0.0) as usize).min(most);
    let (left, right) = (inside(part.min.x, width), inside(part.max.x, width));
    let (top, bottom) = (inside(part.min.y, height), inside(part.max.y, height));
    let rows = screen.pixels.chunks(width.max(1)).take(bottom).skip(top);
    let pixels = rows.flat_map(|row| row[left..right].to_vec()).collect();
    let size = [right.saturating_sub(left), bottom.saturating_sub(top)];
    ColorImage::new(size, pixels)
}

fn encoded(picture: &ColorImage) -> io::Result<Arc<[u8]>> {
    let opaque = |color: &Color32| [color.r(), color.g(), color.b(), u8::MAX];
    let rgba: Vec<u8> = picture.pixels.iter().flat_map(opaque).collect();
    Ok(png(picture.size, &rgba)?.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A screen of 4 × 3 pixels at two pixels a point: the part from (0.5, 0.5) to (2, 1.5) is 3 × 2 pixels.
    #[test]
    fn a_png_holds_the_part_of_the_screen_and_no_more() {
        let pixels = (0..12).map(|k| egui::Color32::from_gray(20 * k)).collect();
        let screen = ColorImage::new([4, 3], pixels);
        let part = Rect::from_min_max(egui::pos2(0.5, 0.5), egui::pos2(2.0, 9.0));
        let bytes = encoded(&cut(&screen, part, 2.0)).unwrap();
        let image = image::load_from_memory(&bytes).unwrap().to_rgb8();
        assert_eq!(image.dimensions(), (3, 2));
        assert_eq!(image.get_pixel(0, 0).0, [100; 3]);
        assert_eq!(image.get_pixel(2, 1).0, [220; 3]);
    }
}
