//! Products of present gauges.

/// The product of two or three standardised gauges, by their positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Monomial {
    /// The product of two, or the square of one.
    Product(usize, usize),
    /// The cube of one.
    Cube(usize),
}

impl Monomial {
    /// What it is called where the gauges have these names: `<gauge>^2`, `<gauge>*<gauge>`, `<gauge>^3`.
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
