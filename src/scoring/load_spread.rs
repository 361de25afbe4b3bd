//! How loads spread over their axes: which move together, in how many directions, and how much of a rectangle they enclose.

/// Loads that move along a direction with a smaller share than this of an axis' variance do not move along it.
const DIRECTION: f64 = 1e-3;

/// Mean and spread of loads, and how they go together.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadSpread {
    /// The standard deviation of each axis.
    pub deviations: Vec<f64>,
    /// `n_axes × n_axes`; `None` where one does not move.
    pub correlations: Vec<Option<f64>>,
    /// How much smaller the variance is of what an axis does beside the others; 1 where it goes alone.
    pub inflations: Vec<Option<f64>>,
    /// The combination of axes that moves least, each in its standard deviations, and the standard deviation of it; `None`
    /// with fewer than two that move.
    pub stiffest: Option<(Vec<f64>, f64)>,
    /// In how many independent directions the loads move.
    pub n_directions: usize,
}

impl LoadSpread {
    /// Of these loads.
    pub fn of<'a>(loads: impl Iterator<Item = &'a [f64]> + Clone, ranges: &[(f64, f64)]) -> Self {
        let n_axes = ranges.len();
        let n = loads.clone().count().max(1) as f64;
        let mut mean = vec![0.0; n_axes];
        for load in loads.clone() {
            mean.iter_mut().zip(load).for_each(|(sum, load)| *sum += load / n);
        }
        let mut products = vec![0.0; n_axes * n_axes];
        for load in loads {
            for i in 0..n_axes {
                for j in 0..=i {
                    products[i * n_axes + j] += (load[i] - mean[i]) * (load[j] - mean[j]) / n;
                }
            }
        }
        let moves = |axis: usize| ranges[axis].1 > ranges[axis].0;
        let deviations: Vec<f64> = (0..n_axes)
            .map(|axis| if moves(axis) { products[axis * n_axes + axis].sqrt() } else { 0.0 })
            .collect();
        let correlation = |i: usize, j: usize| {
            let both = deviations[i] * deviations[j];
            let product = products[i.max(j) * n_axes + i.min(j)];
            (both > 0.0).then(|| if i == j { 1.0 } else { (product / both).clamp(-1.0, 1.0) })
        };
        let correlations: Vec<Option<f64>> =
            (0..n_axes * n_axes).map(|at| correlation(at / n_axes, at % n_axes)).collect();
        let moving: Vec<usize> = (0..n_axes).filter(|axis| deviations[*axis] > 0.0).collect();
        let (mut inflations, mut stiffest, mut n_directions) = (vec![None; n_axes], None, 0);
        let n_moving = moving.len();
        let among = faer::Mat::from_fn(n_moving, n_moving, |i, j| {
            correlations[moving[i] * n_axes + moving[j]].unwrap_or(0.0)
        });
        let parts = (n_moving > 0).then(|| among.self_adjoint_eigen(faer::Side::Lower));
        if let Some(Ok(parts)) = parts {
            let (squares, directions) = (parts.S().column_vector(), parts.U());
            n_directions = (0..n_moving).filter(|at| squares[*at] > DIRECTION).count();
            let least = (0..n_moving).min_by(|a, b| squares[*a].total_cmp(&squares[*b]));
            for (at, axis) in moving.iter().enumerate() {
                let parts =
                    (0..n_moving).map(|k| directions[(at, k)].powi(2) / squares[k].max(1e-12));
                inflations[*axis] = Some(parts.sum());
            }
            if let Some(least) = least.filter(|_| n_moving > 1) {
                let mut direction = vec![0.0; n_axes];
                for (at, axis) in moving.iter().enumerate() {
                    direction[*axis] = directions[(at, least)];
                }
                stiffest = Some((direction, squares[least].max(0.0).sqrt()));
            }
        }
        Self { deviations, correlations, inflations, stiffest, n_directions }
    }

    /// How many axes move.
    pub fn n_moving(&self) -> usize {
        self.deviations.iter().filter(|own| **own > 0.0).count()
    }
}

/// The share of a rectangle that points enclose: their convex hull within it. `None` where the rectangle has no area.
pub fn enclosed(
    points: impl Iterator<Item = [f64; 2]>,
    across: (f64, f64),
    up: (f64, f64),
) -> Option<f64> {
    let (width, height) = (across.1 - across.0, up.1 - up.0);
    if width <= 0.0 || height <= 0.0 {
        return None;
    }
    let scaled = |[x, y]: [f64; 2]| {
        [((x - across.0) / width).clamp(0.0, 1.0), ((y - up.0) / height).clamp(0.0, 1.0)]
    };
    let mut points: Vec<[f64; 2]> = points.map(scaled).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    // Lower hull from left to right, upper hull back: each turns left only (Andrew 1979).
    let cross = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let mut hull: Vec<[f64; 2]> = Vec::new();
    let mut half = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let start = hull.len();
        for point in points {
            while hull.len() >= start + 2
                && cross(hull[hull.len() - 2], hull[hull.len() - 1], *point) <= 0.0
            {
                hull.pop();
            }
            hull.push(*point);
        }
        hull.pop();
    };
    half(&mut points.iter());
    half(&mut points.iter().rev());
    let twice: f64 = (0..hull.len())
        .map(|at| {
            let ([x, y], [u, v]) = (hull[at], hull[(at + 1) % hull.len()]);
            x * v - u * y
        })
        .sum();
    Some(0.5 * twice)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NumPy 2: `std`, `corrcoef`, the diagonal of the inverse of the correlations, `eigh`; SciPy: `ConvexHull`.
    #[test]
    fn spread_and_hull_are_those_of_numpy_and_scipy() {
        let load = |k: usize| {
            let k = k as f64;
            let (a, b, c) = ((0.1 * k).sin(), (0.23 * k).cos(), (0.71 * k).sin());
            [a, b + 0.5 * a, a - 0.8 * b + 0.1 * c]
        };
        let loads: Vec<[f64; 3]> = (0..200).map(load).collect();
        let range = |axis: usize| {
            let of = loads.iter().map(|load| load[axis]);
            (of.clone().fold(f64::INFINITY, f64::min), of.fold(f64::NEG_INFINITY, f64::max))
        };
        let ranges = [0, 1, 2].map(range);
        let spread = LoadSpread::of(loads.iter().map(|load| &load[..]), &ranges);
        let close = |own: f64, expected: f64| {
            assert!((own / expected - 1.0).abs() < 1e-6, "{own} for {expected}")
        };
        close(spread.deviations[2], 0.89315314);
        close(spread.correlations[1].unwrap(), 0.45625773);
        close(spread.correlations[5].unwrap(), -0.20904261);
        close(spread.inflations[0].unwrap(), 193.67488842);
        close(spread.inflations[1].unwrap(), 81.83309821);
        let (direction, deviation) = spread.stiffest.unwrap();
        close((direction[1] / direction[0]).abs(), 0.43221072 / 0.66712353);
        assert!((deviation.powi(2) - 0.00230162).abs() < 1e-7);
        assert_eq!(spread.n_directions, 3);
        let points = loads.iter().map(|load| [load[0], load[1]]);
        close(enclosed(points, ranges[0], ranges[1]).unwrap(), 0.6822455183690698);
    }

    #[test]
    fn a_line_encloses_nothing_a_cross_half_and_corners_all() {
        let square = |points: &[[f64; 2]]| {
            enclosed(points.iter().copied(), (-1.0, 1.0), (-1.0, 1.0)).unwrap()
        };
        assert_eq!(square(&[[-1.0, -1.0], [0.0, 0.0], [1.0, 1.0]]), 0.0);
        assert_eq!(square(&[[-1.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [0.0, 0.0]]), 0.5);
        assert_eq!(square(&[[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [9.0, 0.0]]), 1.0);
        assert_eq!(square(&[]), 0.0);
        assert_eq!(square(&[[0.3, 0.3]]), 0.0);
        assert_eq!(enclosed([].into_iter(), (1.0, 1.0), (0.0, 1.0)), None);
    }
}
