//! Straight lines through points, and the deviation of samples from a straight line in time.

/// Straight line.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Point on the line; of a least-squares line, the mean of its points.
    middle: (f64, f64),
    pub slope: f64,
    /// Sum of the squared distances of the points from their mean, along the first axis; 0 if the line is no fit.
    pub spread: f64,
}

impl Line {
    pub fn through_ends(points: &[(f64, f64)]) -> Option<Self> {
        let [(x0, y0), .., (x1, y1)] = *points else { return None };
        Some(Self { middle: (x0, y0), slope: (y1 - y0) / (x1 - x0), spread: 0.0 })
    }

    /// Returns the least-squares line; `None` if all points lie above each other.
    pub fn best_fit(points: &[(f64, f64)]) -> Option<Self> {
        let n = points.len() as f64;
        let x_mean = points.iter().map(|(x, _)| x).sum::<f64>() / n;
        let y_mean = points.iter().map(|(_, y)| y).sum::<f64>() / n;
        let spread: f64 = points.iter().map(|(x, _)| (x - x_mean).powi(2)).sum();
        let product: f64 = points.iter().map(|(x, y)| (x - x_mean) * (y - y_mean)).sum();
        let middle = (x_mean, y_mean);
        (spread > 0.0).then(|| Self { middle, slope: product / spread, spread })
    }

    pub fn at(&self, x: f64) -> f64 {
        self.middle.1 + self.slope * (x - self.middle.0)
    }

    pub fn deviation(&self, (x, y): &(f64, f64)) -> f64 {
        y - self.at(*x)
    }

    pub fn largest_deviation<'a>(&self, points: impl Iterator<Item = &'a (f64, f64)>) -> f64 {
        points.map(|point| self.deviation(point).abs()).fold(0.0, f64::max)
    }

    /// Returns the correlation coefficient of the points to which this least-squares line was fitted; NaN if all are level.
    pub fn correlation(&self, points: &[(f64, f64)]) -> f64 {
        let explained = self.slope * self.slope * self.spread;
        self.slope.signum() * (explained / (explained + self.squares(points))).sqrt()
    }

    /// Returns the sum of the squared deviations.
    pub fn squares(&self, points: &[(f64, f64)]) -> f64 {
        points.iter().map(|point| self.deviation(point).powi(2)).sum()
    }
}

/// Returns the deviation of three successive samples from a straight line. It is divided by √6, so that it has the noise of
/// one sample.
pub fn bend([a, b, c]: [f64; 3]) -> f64 {
    (a - 2.0 * b + c).abs() / 6_f64.sqrt()
}
