//! Visible range of a plot.

use crate::min_max::MinMax;
use crate::scoring::loops::Frame;

/// Maximum number of points of rising or falling branches; with more, their density is drawn. Both outputs then have about as
/// many points as the traces of six axes, so a frame takes no longer.
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
