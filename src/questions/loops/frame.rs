//! Visible range of a plot.

use crate::{min_max::MinMax, scoring::loops::Frame};

/// Maximum number of points of all rising branches, and of all falling branches, that are drawn as lines. If a plot has more
/// points, the density of the branches is drawn. Two outputs then take no longer to draw than the traces of six axes.
pub const MAX_POINTS: usize = 8000;

/// Margin around the points of a plot, as a share of its width and height.
pub const MARGIN: f64 = 0.04;

/// Returns a visible range with a margin around these loads and outputs. Even a single point gets a margin.
pub fn frame_around(loads: MinMax, outputs: MinMax) -> Frame {
    let wider = |range: MinMax| {
        let (low, high) = range.ends().unwrap_or_default();
        let margin =
            if high > low { MARGIN * (high - low) } else { 0.1 * f64::max(high.abs(), 1e-3) };
        (low - margin, high + margin)
    };
    Frame { loads: wider(loads), outputs: wider(outputs) }
}
