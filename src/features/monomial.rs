/// Product of two or three standardised gauges, each given by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Monomial {
    /// Product of two gauges, or the square of one.
    Product(usize, usize),
    Cube(usize),
}

impl Monomial {
    /// Returns the name of the product, such as `S1^2`, `S1*S2` or `S1^3`. Panics if a gauge has no name.
    pub fn name(self, gauges: &[String]) -> String {
        match self {
            Self::Product(left, right) if left == right => format!("{}^2", gauges[left]),
            Self::Product(left, right) => format!("{}*{}", gauges[left], gauges[right]),
            Self::Cube(gauge) => format!("{}^3", gauges[gauge]),
        }
    }
}
