//! A figure as plain data: two scales, with lines or a heat map.

use std::borrow::Cow;

use crate::{min_max::MinMax, report::figure::cloud::Cloud};

/// Width and height of a figure that is saved as a separate file (SVG units).
pub const STANDS_ALONE: (f64, f64) = (800.0, 600.0);
/// Lengths of the dashes and gaps of a dashed line (points).
pub const DASHED: [f32; 2] = [7.0, 4.0];
/// Lengths of the dots and gaps of a dotted line (points).
pub const DOTTED: [f32; 2] = [2.0, 4.0];

/// Shape of an arrowhead (points): distances from the marked point forward to the tip, back to the other two corners, and
/// sideways to these corners. The triangle is slim, because an equilateral triangle shows no direction.
const ARROW: [f64; 3] = [10.0, 5.0, 4.0];

/// Lines or a heat map in a plot with two scales.
#[derive(Clone, Debug, Default)]
pub struct Figure<'a> {
    /// Title of the figure.
    pub title: String,
    /// Horizontal scale.
    pub across: Scale,
    /// Vertical scale.
    pub up: Scale,
    /// Heat map of the figure, drawn under the lines.
    pub heat_map: Option<HeatMap>,
    /// Densities of samples along curves, drawn under the lines.
    pub clouds: Vec<Cloud>,
    /// Lines of the figure, in the order of drawing.
    pub lines: Vec<Line<'a>>,
    /// Arrowheads of the figure, drawn on top of the lines.
    pub arrows: Vec<Arrow>,
    /// Interval of the horizontal scale that is shaded over the whole height.
    pub shaded: Option<(f64, f64)>,
    /// Value on the horizontal scale that a vertical line marks.
    pub marked: Option<f64>,
}

/// A horizontal, vertical or colour scale.
#[derive(Clone, Debug, Default)]
pub struct Scale {
    /// Name of the quantity that the scale shows, with its unit.
    pub label: String,
    /// Minimum and maximum of the scale.
    pub range: (f64, f64),
    /// Values of the cells of a heat map along this scale; empty for a continuous scale. Cell n covers the range from n to n
    /// + 1 of the scale.
    pub cells: Vec<f64>,
}

/// A line that consists of one or more pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Line<'a> {
    /// Name in the legend; lines with an empty name are not in the legend.
    pub name: String,
    /// Colour as red, green, blue.
    pub color: [u8; 3],
    /// Opacity of the line from 0 (invisible) to 1.
    pub opacity: f32,
    /// Width of the line (points).
    pub width: f32,
    /// Lengths of the dashes and gaps (points), such as [`DASHED`]; `None` for a solid line.
    pub dash: Option<[f32; 2]>,
    /// Points `[across, up]` of each piece of the line. The pieces are not joined to each other.
    pub pieces: Vec<Cow<'a, [[f64; 2]]>>,
}

/// Arrowhead that shows the direction of a line.
#[derive(Clone, Copy, Debug)]
pub struct Arrow {
    /// Point on the line where the arrow is drawn.
    pub at: [f64; 2],
    /// Two points that give the direction: the arrow points from the first to the second.
    pub way: [[f64; 2]; 2],
    /// Colour as red, green, blue.
    pub color: [u8; 3],
}

/// Heat map: one number for each pair of a cell of the horizontal scale and a cell of the vertical scale.
#[derive(Clone, Debug, Default)]
pub struct HeatMap {
    /// Label and range of the colour scale.
    pub shades: Scale,
    /// Numbers of the cells, column by column: first the `n_up` cells of the first column. Cells without a number are grey.
    pub values: Vec<Option<f64>>,
    /// Marked cell, by its horizontal and vertical index.
    pub marked: Option<(usize, usize)>,
}

impl Scale {
    /// Returns a continuous scale with this label and range.
    pub fn new(label: impl Into<String>, range: (f64, f64)) -> Self {
        Self { label: label.into(), range, cells: Vec::new() }
    }

    /// Returns a scale that spans the finite numbers and a margin. `room` is the margin at each end as a share of the range.
    pub fn spanning(
        label: impl Into<String>,
        numbers: impl IntoIterator<Item = f64>,
        room: f64,
    ) -> Self {
        let finite: MinMax = numbers.into_iter().filter(|number| number.is_finite()).collect();
        let range = match finite.ends().map(|(low, high)| (low, high, high - low)) {
            Some((low, high, span)) if span > 0.0 && span.is_finite() => {
                (low - room * span, high + room * span)
            }
            Some((only, _, 0.0)) => {
                let half = 0.5_f64.max(0.01 * only.abs());
                (only - half, only + half)
            }
            _ => (0.0, 1.0),
        };
        Self::new(label, range)
    }

    /// Returns the scale of a heat map, with a cell of equal size for each value.
    pub fn of_cells(label: impl Into<String>, values: &[f64]) -> Self {
        Self { cells: values.to_vec(), ..Self::new(label, (0.0, values.len().max(1) as f64)) }
    }
}

impl Figure<'_> {
    /// Returns a description of the figure in words, for screen readers.
    pub fn described(&self) -> String {
        let mut names: Vec<&str> =
            self.lines.iter().map(|line| &*line.name).filter(|name| !name.is_empty()).collect();
        names.dedup();
        let of = if names.is_empty() { String::new() } else { format!(": {}", names.join(", ")) };
        format!("{}, {} against {}{of}", self.title, self.up.label, self.across.label)
    }
}

impl Arrow {
    /// Returns the three corners of the arrowhead in the image, the tip first. `place` converts points of the figure to
    /// points of the image. Returns `None` for an arrow without direction.
    pub fn corners(&self, place: impl Fn([f64; 2]) -> [f64; 2]) -> Option<[[f64; 2]; 3]> {
        let [from, to] = self.way.map(&place);
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = way[0].hypot(way[1]);
        let way = way.map(|part| part / length);
        let at = place(self.at);
        let corner = |along: f64, beside: f64| {
            [at[0] + along * way[0] - beside * way[1], at[1] + along * way[1] + beside * way[0]]
        };
        let [ahead, behind, beside] = ARROW;
        let corners = [(ahead, 0.0), (-behind, beside), (-behind, -beside)];
        let corners = corners.map(|(along, beside)| corner(along, beside));
        let is_there = corners.iter().flatten().all(|part| part.is_finite());
        is_there.then_some(corners)
    }
}

impl<'a> Line<'a> {
    /// Returns the diagonal on which both scales have the same value; `None` if the ranges of the scales do not overlap.
    pub fn one_to_one(across: (f64, f64), up: (f64, f64), color: [u8; 3]) -> Option<Self> {
        let (low, high) = (across.0.max(up.0), across.1.min(up.1));
        (low < high).then(|| Self {
            width: 1.0,
            dash: Some(DOTTED),
            ..Line::new("", color, [vec![[low; 2], [high; 2]]])
        })
    }

    /// Returns a solid line.
    pub fn new(
        name: impl Into<String>,
        color: [u8; 3],
        pieces: impl IntoIterator<Item: Into<Cow<'a, [[f64; 2]]>>>,
    ) -> Self {
        Self {
            name: name.into(),
            color,
            opacity: 1.0,
            width: 2.0,
            dash: None,
            pieces: pieces.into_iter().map(Into::into).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In an image whose y axis points down, an arrow along a rising line must point up.
    #[test]
    fn an_arrow_points_in_the_direction_of_its_line() {
        let arrow = |way| Arrow { at: [1.0, 2.0], way, color: [0; 3] };
        let place = |[x, y]: [f64; 2]| [10.0 * x, 100.0 - 10.0 * y];
        let up = arrow([[0.0, 0.0], [0.0, 3.0]]).corners(place).unwrap();
        assert_eq!(up, [[10.0, 70.0], [14.0, 85.0], [6.0, 85.0]]);
        let left = arrow([[3.0, 1.0], [0.0, 1.0]]).corners(place).unwrap();
        assert_eq!(left[0], [0.0, 80.0]);
        for way in [[[1.0; 2]; 2], [[0.0, f64::NAN], [1.0, 1.0]]] {
            assert_eq!(arrow(way).corners(place), None, "{way:?}");
        }
    }

    #[test]
    fn the_one_to_one_line_stays_on_the_figure() {
        let line = Line::one_to_one((-5.0, 5.0), (-1.0, 9.0), [0; 3]).unwrap();
        assert_eq!(*line.pieces[0], [[-1.0; 2], [5.0; 2]]);
        assert_eq!(Line::one_to_one((0.0, 1.0), (2.0, 3.0), [0; 3]), None);
    }
}
