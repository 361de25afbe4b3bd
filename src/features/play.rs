//! Play operators: a gauge dragged through a clearance of ± r (generalised Prandtl-Ishlinskii model, whose inverse is
//! of the same class and is fitted directly).
//!
//! `p ← max(s − r, min(s + r, p))`, relaxed at the first sample: p = s. Radii are given in standard deviations of the
//! gauge, so that one list fits gauges of any unit.

/// The operators of one recording.
#[derive(Clone, Debug)]
pub struct Play {
    /// One set of radii per entry of the list, in the unit of each gauge.
    radii: Vec<f64>,
    /// Likewise; empty before the first sample.
    positions: Vec<f64>,
}

impl Play {
    /// Before the first sample; `deviations` are the gauges' standard deviations.
    #[must_use]
    pub fn new(radii: &[f64], deviations: &[f64]) -> Self {
        Self {
            radii: radii
                .iter()
                .flat_map(|&radius| deviations.iter().map(move |deviation| radius * deviation))
                .collect(),
            positions: Vec::new(),
        }
    }

    /// Takes the next sample and writes the positions, one set of gauges per radius.
    #[inline]
    pub fn step(&mut self, gauges: &[f64], out: &mut [f64]) {
        if self.positions.is_empty() {
            self.positions = gauges.repeat(self.radii.len() / gauges.len());
        }
        let sets = self.positions.chunks_exact_mut(gauges.len());
        for (positions, radii) in sets.zip(self.radii.chunks_exact(gauges.len())) {
            for ((position, gauge), radius) in positions.iter_mut().zip(gauges).zip(radii) {
                *position = position.min(gauge + radius).max(gauge - radius);
            }
        }
        out.copy_from_slice(&self.positions);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn positions(radius: f64, gauges: &[f64]) -> Vec<f64> {
        let mut play = Play::new(&[radius], &[2.0]);
        let mut out = [0.0];
        gauges
            .iter()
            .map(|gauge| {
                play.step(&[*gauge], &mut out);
                out[0]
            })
            .collect()
    }

    /// Radius 0.5 SD of 2 is 1: up to 4 it follows one below, then waits until the gauge is one below it.
    #[test]
    fn the_position_is_dragged_and_waits_after_a_reversal() {
        assert_eq!(
            positions(0.5, &[0.0, 0.5, 2.0, 4.0, 3.5, 2.0, 1.0, 0.0]),
            [0.0, 0.0, 1.0, 3.0, 3.0, 3.0, 2.0, 1.0]
        );
    }

    #[test]
    fn a_constant_gauge_keeps_its_value() {
        let mut out = [0.0];
        let mut play = Play::new(&[0.5], &[0.0]);
        play.step(&[7.0], &mut out);
        play.step(&[7.0], &mut out);
        assert_eq!(out, [7.0]);
    }
}
