//! How much of a unit's error an offset, a slope in time and a factor of its own would take away.
//!
//! Chance would make such a fit better, too. So the gain counts only products of scores of different blocks, whose chance parts
//! are independent.

use crate::scoring::budget::cause::Cause;

/// Smallest share of the pairs of blocks that determine a gain, by weight.
const LEAST_PAIRS: f64 = 0.2;
const TINY: f64 = 1e-300;

/// Sums over one block: products of `[1, t, y]` with each other and with the error; t is the time, y the corrected load.
#[derive(Clone, Copy, Debug, Default)]
pub struct BlockScores {
    pub products: [[f64; 3]; 3],
    pub scores: [f64; 3],
}

/// Gains of one unit, in the order of [`Cause::OF_UNITS`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Gains {
    /// Reduction of the sum of squared errors by all freedoms together.
    pub reduction: f64,
    /// Reduction by each freedom, and the variance of this reduction by chance.
    pub of_each: [(f64, f64); 3],
    /// Score and weight of the factor.
    pub factor: (f64, f64),
}

/// One freedom of a unit: its direction in `[1, t, y]`, and how its scores become a reduction.
struct Freedom {
    at: usize,
    direction: [f64; 3],
    scale: f64,
    /// Smallest distance of the two blocks of a pair.
    distance: usize,
}

/// Returns the gains by the freedoms for which `wanted` is true. With fewer than two blocks there are none.
pub fn gains(blocks: &mut [BlockScores], wanted: [bool; Cause::OF_UNITS.len()]) -> Gains {
    let mut gains = Gains::default();
    let n = blocks.len();
    if n < 2 {
        return gains;
    }
    let mut total = [[0.0; 3]; 3];
    for block in blocks.iter() {
        for (total, own) in total.iter_mut().flatten().zip(block.products.iter().flatten()) {
            *total += own;
        }
    }
    let mut freedoms: Vec<Freedom> = Vec::with_capacity(3);
    let mut weights = [0.0; 64];
    let mut scores = [0.0; 64];
    for at in (0..wanted.len()).filter(|at| wanted[*at]) {
        let mut direction = [0.0; 3];
        direction[at] = 1.0;
        for Freedom { direction: before, .. } in &freedoms {
            let share =
                product(&direction, &total, before) / product(before, &total, before).max(1e-30);
            direction.iter_mut().zip(before).for_each(|(own, before)| *own -= share * before);
        }
        for ((block, weight), score) in blocks.iter().zip(&mut weights).zip(&mut scores) {
            *weight = product(&direction, &block.products, &direction);
            *score = dot(&direction, &block.scores);
        }
        let (weights, scores) = (&weights[..n], &scores[..n]);
        let weight = weights.iter().sum::<f64>().max(TINY);
        let score: f64 = scores.iter().sum();
        let square = weight * weight;
        let distances = [2.min(n - 1), 1];
        let enough = distances
            .map(|distance| (distance, pairs(weights, distance)))
            .into_iter()
            .find(|(_, pairs)| *pairs > LEAST_PAIRS * square);
        let (distance, scale) =
            enough.map_or((1, 0.0), |(distance, pairs)| (distance, weight / pairs));
        let reduction = scale * pairs(scores, distance);
        gains.reduction += reduction;
        gains.of_each[at].0 = reduction;
        if Cause::OF_UNITS[at] == Cause::Sensitivity {
            gains.factor = (score, weight);
        }
        // The next freedoms get what this one leaves.
        for block in blocks.iter_mut() {
            for (score_of, row) in block.scores.iter_mut().zip(&block.products) {
                *score_of -= dot(row, &direction) * score / weight.max(1e-30);
            }
        }
        freedoms.push(Freedom { at, direction, scale, distance });
    }
    let freedom = n as f64 / n.saturating_sub(freedoms.len()).max(1) as f64;
    for own in &freedoms {
        for (block, score) in blocks.iter().zip(&mut scores) {
            *score = dot(&own.direction, &block.scores).powi(2) * freedom;
        }
        gains.of_each[own.at].1 = 2.0 * own.scale.powi(2) * pairs(&scores[..n], own.distance);
    }
    gains
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn product(a: &[f64; 3], matrix: &[[f64; 3]; 3], b: &[f64; 3]) -> f64 {
    dot(a, &[dot(&matrix[0], b), dot(&matrix[1], b), dot(&matrix[2], b)])
}

/// Returns the sum of the products of all ordered pairs of values that are at least `distance` apart.
fn pairs(values: &[f64], distance: usize) -> f64 {
    let (mut before, mut sum) = (0.0, 0.0);
    for (earlier, value) in values.iter().zip(&values[distance.min(values.len())..]) {
        before += earlier;
        sum += before * value;
    }
    2.0 * sum
}
