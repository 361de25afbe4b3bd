//! Squares and products of the present gauges, and their cubes: no past in them, so they tell hysteresis from mere
//! nonlinearity.
//!
//! The terms are those of a balance calibration with 6 × 27 (degree 2) and 6 × 33 coefficients (degree 3): `zᵢ zⱼ` for
//! i ≤ j, then `zᵢ³`. Gauges are standardised first, else the powers would drown each other.

use crate::features::Column;

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

/// What the monomials are, in the order of [`monomials`].
pub fn monomial_columns(n_gauges: usize, degree: u8) -> impl Iterator<Item = Column> {
    let gauges = |from_degree| 0..if degree >= from_degree { n_gauges } else { 0 };
    let products = gauges(2)
        .flat_map(move |left| (left..n_gauges).map(move |right| Column::Product(left, right)));
    products.chain(gauges(3).map(Column::Cube))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monomials_stand_in_the_order_of_their_columns() {
        let mut out = [0.0; 5];
        monomials(&[2.0, 5.0], 3, &mut out);
        assert_eq!(out, [4.0, 10.0, 25.0, 8.0, 125.0]);
        let z = [2.0_f64, 5.0];
        let values = monomial_columns(2, 3).map(|column| match column {
            Column::Product(left, right) => z[left] * z[right],
            Column::Cube(gauge) => z[gauge].powi(3),
            other => panic!("{other:?} is no monomial"),
        });
        assert_eq!(values.collect::<Vec<_>>(), out);
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
