//! Squares and products of the present gauges, and their cubes: no past in them, so they tell hysteresis from mere
//! nonlinearity.
//!
//! The terms are those of a balance calibration with 6 × 27 (degree 2) and 6 × 33 coefficients (degree 3): `zᵢ zⱼ` for
//! i ≤ j, then `zᵢ³`. Gauges are standardised first, else the powers would drown each other.

/// How many monomials of these degrees `n_gauges` have.
#[must_use]
pub fn n_monomials(n_gauges: usize, degree: u8) -> usize {
    let products = n_gauges * (n_gauges + 1) / 2;
    match degree {
        0 | 1 => 0,
        2 => products,
        _ => products + n_gauges,
    }
}

/// Writes the monomials of the standardised gauges `z`.
#[inline]
pub fn monomials(z: &[f64], degree: u8, out: &mut [f64]) {
    if degree < 2 {
        return;
    }
    let mut at = 0;
    for (i, left) in z.iter().enumerate() {
        for (out, right) in out[at..].iter_mut().zip(&z[i..]) {
            *out = left * right;
        }
        at += z.len() - i;
    }
    if degree > 2 {
        for (out, z) in out[at..].iter_mut().zip(z) {
            *out = z * z * z;
        }
    }
}

/// The names of the monomials, in the order of [`monomials`].
#[must_use]
pub fn monomial_names(gauges: &[String], degree: u8) -> Vec<String> {
    let mut names = Vec::new();
    if degree > 1 {
        for (i, left) in gauges.iter().enumerate() {
            names.push(format!("{left}^2"));
            names.extend(
                gauges[i + 1..]
                    .iter()
                    .map(|right| format!("{left}*{right}")),
            );
        }
    }
    if degree > 2 {
        names.extend(gauges.iter().map(|gauge| format!("{gauge}^3")));
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monomials_stand_in_the_order_of_their_names() {
        let mut out = [0.0; 5];
        monomials(&[2.0, 5.0], 3, &mut out);
        assert_eq!(out, [4.0, 10.0, 25.0, 8.0, 125.0]);
        let names = monomial_names(&["a".into(), "b".into()], 3);
        assert_eq!(names, ["a^2", "a*b", "b^2", "a^3", "b^3"]);
        assert_eq!(n_monomials(2, 3), 5);
    }

    /// 6 + 21 = 27, 27 + 6 = 33: the coefficients per load of the usual six-component balance matrices.
    #[test]
    fn six_gauges_have_the_terms_of_a_balance_calibration() {
        assert_eq!(6 + n_monomials(6, 2), 27);
        assert_eq!(6 + n_monomials(6, 3), 33);
        assert_eq!(n_monomials(6, 1), 0);
    }
}
