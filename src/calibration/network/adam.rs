//! Adam optimiser.
//!
//! Guarantees: the results are the same with every instruction set, because each parameter is updated on its own. Means
//! of gradients and of their squares that have decayed nearly to zero become exactly zero, because calculations with
//! subnormal numbers are slow.

const FIRST_DECAY: f64 = 0.9;
const SECOND_DECAY: f64 = 0.999;
/// Term that keeps the step finite if the second moment is zero.
const EPSILON: f32 = 1e-8;
/// Minimum magnitude of a moment. Smaller moments have no effect beside [`EPSILON`], and become zero.
const FLUSH_BELOW: f32 = 1e-30;

/// Adam optimiser: first and second moment of the gradient of each parameter (Kingma and Ba 2015, algorithm 1, with its
/// defaults).
#[derive(Clone, Debug)]
pub(super) struct Adam {
    first: Vec<f32>,
    second: Vec<f32>,
    n_steps: i32,
}

impl Adam {
    pub fn new(n_parameters: usize) -> Self {
        Self { first: vec![0.0; n_parameters], second: vec![0.0; n_parameters], n_steps: 0 }
    }

    /// Changes the parameters by one Adam step against the gradient of the loss.
    pub fn step(&mut self, parameters: &mut [f32], gradient: &[f32], learning_rate: f64) {
        self.n_steps = self.n_steps.saturating_add(1);
        let unbiased = |decay: f64| 1.0 - decay.powi(self.n_steps);
        // `rate` corrects the bias of the first moment, and `second_factor` that of the second moment.
        let rate = (learning_rate / unbiased(FIRST_DECAY)) as f32;
        let second_factor = (1.0 / unbiased(SECOND_DECAY)).sqrt() as f32;
        let moments = self.first.iter_mut().zip(&mut self.second);
        let parameters = parameters.iter_mut().zip(gradient);
        let all = parameters.zip(moments);
        pulp::Arch::new().dispatch(
            #[inline(always)]
            move || {
                const B1: f32 = FIRST_DECAY as f32;
                const B2: f32 = SECOND_DECAY as f32;
                // The differences are computed in double precision. In single precision, `1 − B2` would have only four
                // correct digits.
                const NEW1: f32 = (1.0 - FIRST_DECAY) as f32;
                const NEW2: f32 = (1.0 - SECOND_DECAY) as f32;
                for ((parameter, &slope), (first, second)) in all {
                    let m = flushed(B1 * *first + NEW1 * slope);
                    let v = flushed(B2 * *second + NEW2 * slope * slope);
                    *first = m;
                    *second = v;
                    *parameter -= rate * m / (v.sqrt() * second_factor + EPSILON);
                }
            },
        );
    }
}

#[inline(always)]
fn flushed(moment: f32) -> f32 {
    // The comparison is false for a NaN moment, so it stays NaN and makes the loss NaN, which ends the training.
    if moment.abs() < FLUSH_BELOW { 0.0 } else { moment }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the published algorithm in double precision, for the gradient `p − 1` of `(p − 1)² / 2`.
    #[test]
    fn steps_equal_the_printed_algorithm() {
        let mut adam = Adam::new(1);
        let mut fast = [0.0_f32];
        let (mut slow, mut m, mut v) = (0.0_f64, 0.0, 0.0);
        for t in 1..=50 {
            let gradient = [fast[0] - 1.0];
            adam.step(&mut fast, &gradient, 0.01);
            let g = slow - 1.0;
            m = 0.9 * m + 0.1 * g;
            v = 0.999 * v + 0.001 * g * g;
            let (m_hat, v_hat): (f64, f64) =
                (m / (1.0 - 0.9_f64.powi(t)), v / (1.0 - 0.999_f64.powi(t)));
            slow -= 0.01 * m_hat / (v_hat.sqrt() + 1e-8);
            assert!((f64::from(fast[0]) - slow).abs() < 1e-6);
        }
        assert!(slow > 0.3);
    }

    #[test]
    fn moments_of_a_dead_parameter_end_at_zero_and_are_never_subnormal() {
        let mut adam = Adam::new(1);
        let mut parameter = [0.0_f32];
        adam.step(&mut parameter, &[1e-10], 0.01);
        for _ in 0..3000 {
            adam.step(&mut parameter, &[0.0], 0.01);
            assert!(adam.first[0] == 0.0 || adam.first[0].is_normal());
            assert!(adam.second[0] == 0.0 || adam.second[0].is_normal());
        }
        assert_eq!(adam.first[0], 0.0);
    }

    #[test]
    fn a_nan_gradient_makes_its_parameter_nan() {
        let mut adam = Adam::new(2);
        let mut parameters = [0.0_f32; 2];
        adam.step(&mut parameters, &[f32::NAN, 1.0], 0.01);
        assert!(parameters[0].is_nan() && parameters[1] < 0.0);
    }
}
