//! Small plots without axes.

use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, Ui, Vec2};

use crate::scoring::Series;

/// A dark field with the ranges of values that its width and its height show.
pub struct SmallPlot {
    pub painter: Painter,
    place: Rect,
    across: (f64, f64),
    up: (f64, f64),
}

impl SmallPlot {
    pub fn new(ui: &Ui, place: Rect, across: (f64, f64), up: (f64, f64)) -> Self {
        let painter = ui.painter_at(place);
        painter.rect_filled(place, 2.0, ui.visuals().extreme_bg_color);
        // The lines keep a distance from the edges of the field.
        Self { painter, place: place.shrink2(Vec2::new(0.0, 3.0)), across, up }
    }

    pub fn at(&self, [x, y]: [f64; 2]) -> Pos2 {
        let share = |value: f64, (low, high): (f64, f64)| {
            if low < high { ((value - low) / (high - low)) as f32 } else { 0.5 }
        };
        let shares = Vec2::new(share(x, self.across), 1.0 - share(y, self.up));
        self.place.lerp_inside(shares)
    }

    /// Draws a line. Points that are not finite are left out.
    pub fn line(&self, points: impl IntoIterator<Item = [f64; 2]>, stroke: Stroke) {
        let points = points.into_iter().map(|point| self.at(point)).filter(|at| at.is_finite());
        self.painter.add(Shape::line(points.collect(), stroke));
    }
}

/// Draws lines of equal length over the number of the sample, each column of pixels from its lowest to its highest value.
pub fn over_samples(ui: &Ui, place: Rect, up: (f64, f64), lines: &[(Color32, &Series)]) {
    let n = lines.first().map_or(0, |(_, series)| series.len());
    let columns = (place.width() as usize).min(n);
    let plot = SmallPlot::new(ui, place, (0.0, columns as f64), up);
    for (color, series) in lines.iter().filter(|_| up.0 < up.1) {
        let points = (0..columns).flat_map(|column| {
            let start = column * n / columns;
            let samples = start..((column + 1) * n / columns).max(start + 1);
            let ends = series.min_max(samples);
            let x = column as f64 + 0.5;
            ends.into_iter().flat_map(move |(low, high)| [[x, low], [x, high]])
        });
        plot.line(points, Stroke::new(1.0, *color));
    }
}

/// Returns the lowest and the highest value of these lines.
pub fn range<'a>(lines: impl IntoIterator<Item = &'a Series>) -> (f64, f64) {
    let ends = lines.into_iter().filter_map(|series| series.min_max(0..series.len()));
    ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), (low, high)| {
        (least.min(low), most.max(high))
    })
}
