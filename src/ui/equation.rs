//! Lays out equations with subscripts such as `S_{past}` and superscripts such as `C^{-1}`.

use egui::text::{LayoutJob, TextFormat};
use egui::{Align, Color32, FontId, Ui};

const INDEX_SIZE: f32 = 0.7;

/// Lays out an equation. `_` lowers and `^` raises the next character, or the text in braces.
pub fn laid_out(ui: &Ui, text: &str, color: Color32) -> LayoutJob {
    let size = 1.1 * egui::TextStyle::Body.resolve(ui.style()).size;
    let mut job = LayoutJob::default();
    for (place, piece) in pieces(text) {
        let (size, valign) = match place {
            Place::Line => (size, Align::Center),
            Place::Low => (INDEX_SIZE * size, Align::BOTTOM),
            Place::High => (INDEX_SIZE * size, Align::TOP),
        };
        let format = TextFormat {
            font_id: FontId::proportional(size),
            color,
            valign,
            ..TextFormat::default()
        };
        job.append(&piece, 0.0, format);
    }
    job
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Line,
    Low,
    High,
}

fn pieces(text: &str) -> Vec<(Place, String)> {
    let mut pieces: Vec<(Place, String)> = Vec::new();
    let mut signs = text.chars();
    while let Some(sign) = signs.next() {
        let place = match sign {
            '_' => Place::Low,
            '^' => Place::High,
            _ => Place::Line,
        };
        let piece: String = match (place, signs.as_str().chars().next()) {
            (Place::Line, _) => sign.to_string(),
            (_, Some('{')) => {
                signs.next();
                signs.by_ref().take_while(|sign| *sign != '}').collect()
            }
            _ => signs.by_ref().take(1).collect(),
        };
        match pieces.last_mut() {
            Some((last, before)) if *last == place => before.push_str(&piece),
            _ => pieces.push((place, piece)),
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_take_one_sign_or_a_group() {
        let piece = |place, text: &str| (place, text.to_owned());
        assert_eq!(
            pieces("L = C^{-1}S_i + c"),
            [
                piece(Place::Line, "L = C"),
                piece(Place::High, "-1"),
                piece(Place::Line, "S"),
                piece(Place::Low, "i"),
                piece(Place::Line, " + c"),
            ]
        );
        assert_eq!(pieces("a_{open"), [piece(Place::Line, "a"), piece(Place::Low, "open")]);
        assert_eq!(pieces("^"), [piece(Place::High, "")]);
    }
}
