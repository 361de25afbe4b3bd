//! Small plots without axes: lines over the number of the sample, each column of pixels from its lowest to its highest value.

use egui::{Color32, Rect, Shape, Stroke, Ui, pos2};

use crate::scoring::Series;

/// Share of the height between the lowest and the highest value.
const FILLED: f32 = 0.92;

/// Draws lines of equal length in a dark field, between these values.
pub fn small_plot(ui: &Ui, place: Rect, (low, high): (f64, f64), lines: &[(Color32, &Series)]) {
    let painter = ui.painter_at(place);
    painter.rect_filled(place, 0.0, ui.visuals().extreme_bg_color);
    if high <= low {
        return;
    }
    let y_of = |value: f64| {
        let share = ((value - low) / (high - low) - 0.5) as f32;
        place.center().y - FILLED * share * place.height()
    };
    for (color, series) in lines {
        let n = series.len();
        let columns = (place.width() as usize).min(n);
        let points = (0..columns).flat_map(|column| {
            let start = column * n / columns;
            let samples = start..((column + 1) * n / columns).max(start + 1);
            let x = place.left() + (column as f32 + 0.5) * place.width() / columns as f32;
            let ends = series.min_max(samples);
            ends.into_iter().flat_map(move |(low, high)| [(x, low), (x, high)])
        });
        let points = points.map(|(x, value)| pos2(x, y_of(value))).collect();
        painter.add(Shape::line(points, Stroke::new(1.0, *color)));
    }
}

/// Returns the lowest and the highest value of these lines.
pub fn range<'a>(lines: impl IntoIterator<Item = &'a Series>) -> (f64, f64) {
    let ends = lines.into_iter().filter_map(|series| series.min_max(0..series.len()));
    ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), (low, high)| {
        (least.min(low), most.max(high))
    })
}
