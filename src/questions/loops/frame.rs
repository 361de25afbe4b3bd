//! Visible range of a plot.

use crate::min_max::MinMax;
use crate::scoring::loops::Frame;

/// More points than this of rising or of falling branches are drawn as their density, even where a larger picture could show them
/// as lines: those of both outputs are about as many as the traces of six axes have, and a frame costs no more than theirs.
pub(crate) const MAX_POINTS: usize = 8000;

/// Margin around the points, as a share of the width and height.
pub(crate) const MARGIN: f64 = 0.04;

/// Returns a range around these ranges with a margin; never empty.
pub(crate) fn frame_around(loads: MinMax, outputs: MinMax) -> Frame {
    let wider = |range: MinMax| {
        let (low, high) = range.ends().unwrap_or_default();
        let margin =
            if high > low { MARGIN * (high - low) } else { 0.1 * f64::max(high.abs(), 1e-3) };
        (low - margin, high + margin)
    };
    Frame { loads: wider(loads), outputs: wider(outputs) }
}
