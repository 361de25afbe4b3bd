//! Load programmes: finds recordings in which the load takes the same course over time.

use crate::recording::recording::Recording;

/// Minimum number of samples of a recording whose load programme is compared with others.
const FEWEST_SAMPLES: usize = 16;
/// Number of samples at which two load programmes are compared, evenly spread over each recording.
const COMPARED: usize = 64;
/// Maximum RMS difference between the loads of two recordings with the same programme, as a share of the load range.
const SAME_PROGRAMME: f64 = 0.05;

impl Recording {
    /// Returns true if the load takes the same course in both recordings, at the same or another speed.
    pub(crate) fn repeats(&self, other: &Self) -> bool {
        let is_comparable =
            |recording: &Self| recording.n_samples() >= FEWEST_SAMPLES && recording.has_reference();
        if self.axes() != other.axes() || ![self, other].into_iter().all(is_comparable) {
            return false;
        }
        let n_axes = self.axes().len();
        let load = |of: &Self, at: usize, axis: usize| {
            let sample = at * (of.n_samples() - 1) / (COMPARED - 1);
            of.loads()[sample * n_axes + axis]
        };
        let range: f64 = other.load_ranges().iter().map(|range| range.span().powi(2)).sum();
        let most = SAME_PROGRAMME.powi(2) * range * COMPARED as f64;
        let mut squares = 0.0;
        // The sum stops as soon as it exceeds the limit: for most different programmes, a few samples suffice.
        (0..COMPARED).all(|at| {
            let difference = |axis| load(self, at, axis) - load(other, at, axis);
            squares += (0..n_axes).map(|axis| difference(axis).powi(2)).sum::<f64>();
            squares <= most
        })
    }
}
