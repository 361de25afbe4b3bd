//! Bars of an error, divided into its causes.

use egui::{Align2, Color32, FontId, Painter, Rect, Stroke, Visuals};

use crate::{
    questions::budget::Row,
    scoring::budget::{Budget, Shares},
};

/// Opacity of a cause that is not the largest.
const OTHERS: f32 = 0.42;
const TEXT_SIZE: f32 = 12.0;
/// Distance of the lines that mark the unexplained part (points).
const HATCH: f32 = 6.0;

/// A part of a bar.
pub struct Part {
    pub name: &'static str,
    /// Share of the mean squared error.
    pub share: f64,
    is_unexplained: bool,
}

/// Returns the parts of an error, in the same order for every bar.
pub fn parts(shares: &Shares, budget: &Budget) -> Vec<Part> {
    let all = Row::all().filter(|row| *row != Row::Total);
    let all = all.map(|row| (row, row.square(shares))).filter(|(_, square)| *square > 0.0);
    all.map(|(row, square)| Part {
        name: row.name(budget),
        share: square / shares.total,
        is_unexplained: row == Row::Unexplained,
    })
    .collect()
}

/// Returns the name of the largest part that has a known cause.
pub fn largest(parts: &[Part]) -> Option<&'static str> {
    let known = parts.iter().filter(|part| !part.is_unexplained);
    known.max_by(|a, b| a.share.total_cmp(&b.share)).map(|part| part.name)
}

/// Draws a bar of this length; `bright` is the name of the part in full colour. Without parts the bar has one colour.
pub fn bar(
    painter: &Painter,
    rect: Rect,
    parts: &[Part],
    bright: Option<&str>,
    color: Color32,
    visuals: &Visuals,
) {
    let weak = color.gamma_multiply(OTHERS);
    if parts.is_empty() {
        painter.rect_filled(rect, 2.0, weak);
        return;
    }
    let mut left = rect.left();
    for part in parts {
        let width = part.share as f32 * rect.width();
        let place = Rect::from_x_y_ranges(left..=left + width, rect.y_range());
        left += width;
        let is_bright = bright == Some(part.name);
        let inside = place.with_max_x((place.right() - 1.0).max(place.left()));
        if part.is_unexplained {
            hatch(&painter.with_clip_rect(inside.intersect(painter.clip_rect())), inside, weak);
        } else {
            painter.rect_filled(inside, 1.0, if is_bright { color } else { weak });
        }
        let text = format!("{} {:.0} %", part.name, 100.0 * part.share);
        let ink = if is_bright { visuals.extreme_bg_color } else { visuals.strong_text_color() };
        let galley = painter.layout_no_wrap(text, FontId::proportional(TEXT_SIZE), ink);
        if galley.size().x + 10.0 < place.width() && !part.is_unexplained {
            let at = Align2::LEFT_CENTER
                .anchor_size(place.left_center() + egui::vec2(6.0, 0.0), galley.size());
            painter.galley(at.min, galley, ink);
        }
    }
}

fn hatch(painter: &Painter, rect: Rect, color: Color32) {
    let stroke = Stroke::new(1.0, color);
    painter.rect_stroke(rect, 1.0, stroke, egui::StrokeKind::Inside);
    let mut left = rect.left() - rect.height();
    while left < rect.right() {
        let ends = [egui::pos2(left, rect.bottom()), egui::pos2(left + rect.height(), rect.top())];
        painter.line_segment(ends, stroke);
        left += HATCH;
    }
}
