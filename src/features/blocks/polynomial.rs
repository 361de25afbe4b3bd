//! Feature block that appends squares, products and cubes of the present gauge values to the columns of the fit. They
//! describe nonlinearity without hysteresis.
//!
//! For six gauges, the calibration matrix then has 6 × 27 (degree 2) or 6 × 33 (degree 3) coefficients, as is usual for
//! wind-tunnel balances. The appended terms are `zᵢ zⱼ` for i ≤ j, then `zᵢ³`. zᵢ is the standardised value of gauge i, so
//! that the powers have similar size.

use crate::features::{
    block::{Appends, Block, Inputs, Stream},
    gauge_scale::GaugeScale,
    monomial::Monomial,
    setting::{Choice, Range, Setting, Unit},
    source::{Code, Rows, Source},
};

/// Feature block that appends powers and products of the gauges. Its setting is the degree of the polynomial: 1 (nothing
/// appended), 2 or 3.
#[derive(Clone, Copy, Debug)]
pub struct Polynomial;

const DEGREE: Setting = Setting {
    key: "polynomial",
    option: "polynomial",
    label: "Polynomial",
    what: "the degree of the polynomial",
    unit: Unit::new("", "", ["DEGREE"; 2]),
    default: &[1.0],
    range: Range::OneOf(&[
        Choice {
            value: 1,
            label: "none",
            explanation: "Appends nothing: the load is linear in the gauges",
        },
        Choice {
            value: 2,
            label: "degree 2",
            explanation: "Appends the squares of the gauges and the products of two gauges",
        },
        Choice {
            value: 3,
            label: "degree 3",
            explanation: "Appends the squares and cubes of the gauges and the products of two gauges",
        },
    ]),
    step: 1.0,
    explanation: "Appends squares and products of the standardised gauges as columns of the fit, with degree 3 also cubes. These \
                  columns describe nonlinearity, not hysteresis",
    source: "as in balance calibrations with 6 × 27 or 6 × 33 coefficients for six gauges",
};

impl Block for Polynomial {
    fn name(&self) -> &'static str {
        "Polynomial"
    }

    fn setting(&self) -> &'static Setting {
        &DEGREE
    }

    fn formula(&self) -> &'static str {
        "z_i z_j, z_i^3"
    }

    fn appends(&self) -> Appends {
        Appends::Monomials(monomials)
    }

    fn n_columns(&self, degree: &[f64], n_gauges: usize) -> usize {
        let products = n_gauges * (n_gauges + 1) / 2;
        match degree {
            [] | [1.0] => 0,
            [2.0] => products,
            _ => products + n_gauges,
        }
    }

    fn memory(&self) -> Option<&'static str> {
        None
    }

    fn stream(&self, degree: &[f64], inputs: &Inputs<'_>) -> Box<dyn Stream> {
        Box::new(Powers {
            scale: inputs.scale.clone(),
            with_cubes: has_cubes(degree),
            z: vec![0.0; inputs.scale.shift.len()],
        })
    }

    fn source(&self, degree: &[f64], rows: &Rows<'_>) -> Source {
        let code = |squares: &str, cubes: &str| {
            let cubes = if has_cubes(degree) { cubes.trim_start_matches('\n') } else { "" };
            Code::update([squares, cubes].concat())
        };
        Source {
            constants: rows.standard(["standard_factor", "standard_constant"]).to_vec(),
            memory: Vec::new(),
            c: code(C_SQUARES, C_CUBES),
            rust: code(RUST_SQUARES, RUST_CUBES),
            python: Code { functions: PYTHON_CONSTANTS, ..code(PYTHON_SQUARES, PYTHON_CUBES) },
            matlab: code(MATLAB_SQUARES, MATLAB_CUBES),
        }
    }
}

const C_SQUARES: &str = "
        {{ prefix }}_real z[{{ n_gauges }}];
        int other;
        for (g = 0; g < {{ n_gauges }}; g++)
            z[g] = row[g] * c->standard_factor[g] + c->standard_constant[g];
        for (g = 0; g < {{ n_gauges }}; g++)
            for (other = g; other < {{ n_gauges }}; other++)
                *next++ = z[g] * z[other];
";

const C_CUBES: &str = "
        for (g = 0; g < {{ n_gauges }}; g++)
            *next++ = z[g] * z[g] * z[g];
";

const RUST_SQUARES: &str = "
        let mut z = [0.0; GAUGES];
        for g in 0..GAUGES {
            z[g] = row[g] * STANDARD_FACTOR[g] + STANDARD_CONSTANT[g];
        }
        for g in 0..GAUGES {
            for other in g..GAUGES {
                row[next] = z[g] * z[other];
                next += 1;
            }
        }
";

const RUST_CUBES: &str = "
        for z in z {
            row[next] = z * z * z;
            next += 1;
        }
";

const PYTHON_CONSTANTS: &str = "
    FIRST, SECOND = np.triu_indices(GAUGES)
";

const PYTHON_SQUARES: &str = "
        z = present * STANDARD_FACTOR + STANDARD_CONSTANT
        row.append(z[self.FIRST] * z[self.SECOND])
";

const PYTHON_CUBES: &str = "
        row.append(z**3)
";

const MATLAB_SQUARES: &str = "
z = present .* c.standard_factor + c.standard_constant;
for g = 1:{{ n_gauges }}
    for other = g:{{ n_gauges }}
        next = next + 1;
        row(next) = z(g) * z(other);
    end
end
";

const MATLAB_CUBES: &str = "
row(next + (1:{{ n_gauges }})) = z .^ 3;
next = next + {{ n_gauges }};
";

fn has_cubes(degree: &[f64]) -> bool {
    degree.iter().any(|degree| *degree > 2.0)
}

/// Returns the powers and products of gauges that this degree appends, in the order in which [`Powers`] writes them.
fn monomials(degree: f64, n_gauges: usize) -> Vec<Monomial> {
    let gauges = |from_degree| 0..if degree >= from_degree { n_gauges } else { 0 };
    let products = gauges(2.0)
        .flat_map(|left| (left..n_gauges).map(move |right| Monomial::Product(left, right)));
    products.chain(gauges(3.0).map(Monomial::Cube)).collect()
}

/// Computes powers and products of the gauges from the present sample alone. Earlier samples have no effect.
#[derive(Clone, Debug)]
struct Powers {
    scale: GaugeScale,
    with_cubes: bool,
    z: Vec<f64>,
}

impl Stream for Powers {
    fn step(&mut self, _time: f64, gauges: &[f64], _: &[f64], out: &mut [f64]) {
        self.scale.apply(gauges, &mut self.z);
        let z = &self.z[..];
        let mut at = 0;
        for (i, left) in z.iter().enumerate() {
            for (out, right) in out[at..].iter_mut().zip(&z[i..]) {
                *out = left * right;
            }
            at += z.len() - i;
        }
        if self.with_cubes {
            for (out, z) in out[at..].iter_mut().zip(z) {
                *out = z * z * z;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monomials_have_the_order_of_their_columns() {
        let z = [2.0_f64, 5.0];
        let mut out = [0.0; 5];
        let scale = &GaugeScale::identity(2);
        let inputs = Inputs { scale, channels: &[], history_step_secs: 0.0 };
        let mut stream = Polynomial.stream(&[3.0], &inputs);
        stream.step(0.0, &z, &[], &mut out);
        assert_eq!(out, [4.0, 10.0, 25.0, 8.0, 125.0]);
        let values = monomials(3.0, 2).into_iter().map(|monomial| match monomial {
            Monomial::Product(left, right) => z[left] * z[right],
            Monomial::Cube(gauge) => z[gauge].powi(3),
        });
        assert_eq!(values.collect::<Vec<_>>(), out);
        assert_eq!(Polynomial.n_columns(&[3.0], 2), 5);
    }

    /// 6 + 21 = 27 and 27 + 6 = 33 are the coefficients per load axis of the usual six-component balance matrices.
    #[test]
    fn six_gauges_have_the_terms_of_a_balance_calibration() {
        assert_eq!(6 + Polynomial.n_columns(&[2.0], 6), 27);
        assert_eq!(6 + Polynomial.n_columns(&[3.0], 6), 33);
        assert_eq!(Polynomial.n_columns(&[], 6), 0);
    }
}
