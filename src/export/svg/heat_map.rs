//! One number over two others, as colours.

use std::io;

use super::Labels;
use super::frame::{Anchor, BOTTOM, LEFT, Page, RIGHT, Scale, TOP};

/// Colours from the least to the greatest number; even steps of them look even (after viridis).
const COLOURS: [[f64; 3]; 5] = [
    [68.0, 1.0, 84.0],
    [59.0, 82.0, 139.0],
    [33.0, 145.0, 140.0],
    [94.0, 201.0, 98.0],
    [253.0, 231.0, 37.0],
];
/// At most so many values are named along an edge.
const MOST_NAMES: usize = 12;
/// Steps of the colour bar.
const BAR_STEPS: usize = 64;

/// A number for every pair of values; every pair has a cell of the same size, however the values are spaced.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMap {
    /// Title and axes.
    pub labels: Labels,
    /// What the colours stand for, with the unit.
    pub value_label: String,
    /// The values along x.
    pub xs: Vec<f64>,
    /// The values along y, from below.
    pub ys: Vec<f64>,
    /// `n_x × n_y`, row-major: all y of the first x come first. What is not known is grey.
    pub values: Vec<Option<f64>>,
    /// The cell that is marked, by the positions of its x and y.
    pub marked: Option<(usize, usize)>,
}

/// Draws the map.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write_heat_map_svg(map: &HeatMap, out: &mut dyn io::Write) -> io::Result<()> {
    let mut page = Page::new(&map.labels);
    let (n_x, n_y) = (map.xs.len().max(1), map.ys.len().max(1));
    let (width, height) = ((RIGHT - LEFT) / n_x as f64, (BOTTOM - TOP) / n_y as f64);
    let finite = |value: &Option<f64>| value.filter(|value| value.is_finite());
    // From 0 to 1, for the colours.
    let shade = Scale::spanning(map.values.iter().filter_map(finite), 0.0, 0.0, 1.0);
    let corner =
        |(x, y): (usize, usize)| (LEFT + x as f64 * width, BOTTOM - (y + 1) as f64 * height);
    page.element(format_args!("<g shape-rendering=\"crispEdges\">"));
    for (at, value) in map.values.iter().enumerate().take(n_x * n_y) {
        let (x, y) = corner((at / n_y, at % n_y));
        let fill =
            finite(value).map_or_else(|| "#d0d0d0".to_owned(), |value| colour(shade.place(value)));
        page.element(format_args!(
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{fill}\"/>"
        ));
    }
    page.element(format_args!("</g>"));
    if let Some(marked) = map.marked {
        let (x, y) = corner(marked);
        page.element(format_args!(
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"none\" \
             stroke=\"white\" stroke-width=\"4\"/><rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" \
             height=\"{height:.2}\" fill=\"none\" stroke=\"black\" stroke-width=\"2\"/>"
        ));
    }
    for (at, value) in named(&map.xs) {
        page.tick_x(LEFT + (at as f64 + 0.5) * width, &value.to_string());
    }
    for (at, value) in named(&map.ys) {
        page.tick_y(BOTTOM - (at as f64 + 0.5) * height, &value.to_string());
    }
    colour_bar(&mut page, &map.value_label, shade);
    out.write_all(page.finish().as_bytes())
}

/// Some of the values, evenly spread, with their positions.
fn named(values: &[f64]) -> impl Iterator<Item = (usize, f64)> {
    let step = values.len().div_ceil(MOST_NAMES).max(1);
    values.iter().copied().enumerate().step_by(step)
}

fn colour_bar(page: &mut Page, label: &str, shade: Scale) {
    let (left, right) = (RIGHT + 34.0, RIGHT + 52.0);
    let step = (BOTTOM - TOP) / BAR_STEPS as f64;
    for at in 0..BAR_STEPS {
        let y = BOTTOM - (at + 1) as f64 * step;
        let fill = colour((at as f64 + 0.5) / BAR_STEPS as f64);
        page.element(format_args!(
            "<rect x=\"{left}\" y=\"{y:.2}\" width=\"{}\" height=\"{:.2}\" fill=\"{fill}\"/>",
            right - left,
            step + 0.5
        ));
    }
    for (tick, text) in shade.ticks() {
        let y = BOTTOM + shade.place(tick) * (TOP - BOTTOM);
        page.text(right + 6.0, y + 4.0, Anchor::Start, &text);
    }
    page.text((left + right) / 2.0, TOP - 8.0, Anchor::Middle, label);
}

/// The colour of a share of the range.
fn colour(share: f64) -> String {
    let position = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let below = (position as usize).min(COLOURS.len() - 2);
    let part = position - below as f64;
    let mixed: [u8; 3] = std::array::from_fn(|at| {
        let (a, b) = (COLOURS[below][at], COLOURS[below + 1][at]);
        (a + part * (b - a)).round() as u8
    });
    format!("#{:02x}{:02x}{:02x}", mixed[0], mixed[1], mixed[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_and_greatest_have_the_ends_of_the_colours_and_gaps_are_grey() {
        let map = HeatMap {
            xs: vec![0.0, 1.5],
            ys: vec![1.0, 2.0],
            values: vec![Some(1.0), Some(3.0), None, Some(f64::NAN)],
            marked: Some((0, 0)),
            value_label: "N & <m>".to_owned(),
            ..HeatMap::default()
        };
        let mut out = Vec::new();
        write_heat_map_svg(&map, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        // The first pair stands below on the left, the second above it.
        let cell = "width=\"247.00\" height=\"170.00\"";
        assert!(text.contains(&format!("x=\"76.00\" y=\"214.00\" {cell} fill=\"#440154\"")));
        assert!(text.contains(&format!("x=\"76.00\" y=\"44.00\" {cell} fill=\"#fde725\"")));
        assert_eq!(text.matches("fill=\"#d0d0d0\"").count(), 2);
        assert!(text.contains("N &amp; &lt;m&gt;") && !text.contains("NaN"));
    }

    #[test]
    fn an_empty_map_is_a_picture_too() {
        let mut out = Vec::new();
        write_heat_map_svg(&HeatMap::default(), &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.ends_with("</svg>\n") && !text.contains("NaN"));
    }
}
