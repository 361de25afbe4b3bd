//! Products of present gauges.

/// Product of two or three standardised gauges, given by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Monomial {
    /// Product of two gauges, or the square of one.
    Product(usize, usize),
    /// Cube of one gauge.
    Cube(usize),
}

impl Monomial {
    /// Returns the name for these gauge names: `<gauge>^2`, `<gauge>*<gauge>`, `<gauge>^3`.
    ///
    /// # Panics
    /// If a gauge has no name.
    pub fn name(self, gauges: &[String]) -> String {
        match self {
            Self::Product(left, right) if left == right => format!("{}^2", gauges[left]),
            Self::Product(left, right) => format!("{}*{}", gauges[left], gauges[right]),
            Self::Cube(gauge) => format!("{}^3", gauges[gauge]),
        }
    }
}
