//! Load programmes: compares the loads that two recordings go through.

use crate::recording::recording::Recording;

/// Minimum number of samples of a recording that is compared.
const FEWEST_SAMPLES: usize = 16;
/// Number of loads at which two programmes are compared, evenly spread over their samples.
const COMPARED: usize = 64;
/// Maximum RMS difference of the loads of one programme, as a share of their range.
const SAME_PROGRAMME: f64 = 0.05;

impl Recording {
    /// Returns true if both recordings go through the same loads at the same shares of their length.
    pub(crate) fn repeats(&self, other: &Self) -> bool {
        let is_comparable = |own: &Self| own.n_samples() >= FEWEST_SAMPLES && own.has_reference();
        if self.axes() != other.axes() || ![self, other].into_iter().all(is_comparable) {
            return false;
        }
        let n_axes = self.axes().len();
        let load = |of: &Self, at: usize, axis: usize| {
            let sample = at * (of.n_samples() - 1) / (COMPARED - 1);
            of.loads()[sample * n_axes + axis]
        };
        let range: f64 = other.load_ranges().iter().map(|own| own.span().powi(2)).sum();
        let most = SAME_PROGRAMME.powi(2) * range * COMPARED as f64;
        let mut squares = 0.0;
        // Most programmes differ within a few loads.
        (0..COMPARED).all(|at| {
            let difference = |axis| load(self, at, axis) - load(other, at, axis);
            squares += (0..n_axes).map(|axis| difference(axis).powi(2)).sum::<f64>();
            squares <= most
        })
    }
}
