//! A figure as plain data: two scales, and the lines or the cells that stand on them.

mod cloud;
pub mod color;
mod svg;

use std::borrow::Cow;

pub use cloud::{Cloud, CloudPicture};

/// Width and height of a figure that stands alone, in its own units.
pub const STANDS_ALONE: (f64, f64) = (800.0, 600.0);
/// What tells a line from a solid one: the length of its dashes and of the gaps between them, in points of the screen.
pub const DASHED: [f32; 2] = [7.0, 4.0];
/// What tells a line from both.
pub const DOTTED: [f32; 2] = [2.0, 4.0];

/// Lines or a heat map over two scales.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure<'a> {
    /// What it shows.
    pub title: String,
    /// What goes across.
    pub across: Scale,
    /// What goes up.
    pub up: Scale,
    /// Colours under the lines.
    pub heat_map: Option<HeatMap>,
    /// Densities under the lines.
    pub clouds: Vec<Cloud>,
    /// In the order of drawing.
    pub lines: Vec<Line<'a>>,
    /// A interval of the scale across that is shaded.
    pub shaded: Option<(f64, f64)>,
    /// A place on the scale across that is marked by an upright line.
    pub marked: Option<f64>,
}

/// One of the two scales, or that of the colours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scale {
    /// What is measured, with its unit.
    pub label: String,
    /// Least and greatest value on the figure.
    pub range: (f64, f64),
    /// Where cells of width one stand side by side from 0 on: the value that each is for. Else empty.
    pub cells: Vec<f64>,
}

/// A line in one or more pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Line<'a> {
    /// What it is; lines with an empty name are not in the legend.
    pub name: String,
    /// Red, green, blue.
    pub color: [u8; 3],
    /// From 0, invisible, to 1.
    pub opacity: f32,
    /// In points of the screen.
    pub width: f32,
    /// Dashes and gaps, such as [`DASHED`].
    pub dash: Option<[f32; 2]>,
    /// Points `[across, up]`; pieces are not joined.
    pub pieces: Vec<Cow<'a, [[f64; 2]]>>,
}

/// A number for every pair of cells of the two scales.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMap {
    /// What the colours stand for.
    pub shades: Scale,
    /// `n_across × n_up`, row-major: all up of the first across come first. What is not known is grey.
    pub values: Vec<Option<f64>>,
    /// The pair that is marked, by its positions across and up.
    pub marked: Option<(usize, usize)>,
}

impl Scale {
    /// Of this range.
    pub fn new(label: impl Into<String>, range: (f64, f64)) -> Self {
        Self {
            label: label.into(),
            range,
            cells: Vec::new(),
        }
    }

    /// Spans the finite numbers with this share of their range as room on both sides; a single number has some about it too.
    pub fn spanning(
        label: impl Into<String>,
        numbers: impl IntoIterator<Item = f64>,
        room: f64,
    ) -> Self {
        let finite = numbers.into_iter().filter(|number| number.is_finite());
        let ends = finite.map(|number| (number, number));
        let ends = ends.reduce(|all, one| (all.0.min(one.0), all.1.max(one.1)));
        let range = match ends.map(|(low, high)| (low, high, high - low)) {
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

    /// A cell of the same size for every value, however these are spaced.
    pub fn of_cells(label: impl Into<String>, values: &[f64]) -> Self {
        Self {
            cells: values.to_vec(),
            ..Self::new(label, (0.0, values.len().max(1) as f64))
        }
    }
}

impl<'a> Line<'a> {
    /// A solid line.
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
