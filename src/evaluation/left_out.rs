//! Leave-one-out fits, eight at a time: each part that is left out has a lane of its own.
//!
//! Guarantees: the squared errors are those of [`fit`] to the sums of the other parts, up to rounding; a fit whose columns
//! nearly explain each other, or of which hardly anything remains without the part, goes to [`fit`] itself and to sums
//! that are added up anew, which finds the rank.
//!
//! How: the part's sums are taken off the total; Cholesky without pivoting, the targets as further rows of the matrix, so
//! that forward substitution comes with the factor. All fits have the same shape, so every step does one operation on
//! eight of them.

#![expect(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays, as the compiler vectorises it"
)]
#![expect(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "a pivot or a share that is no number counts as too small"
)]

use rayon::prelude::*;

use crate::calibration::{NormalEquations, Ridge, RidgeChoice, Terms, fit};
use crate::evaluation::cross_validation::{RIDGE_STRENGTHS, strongest_good};
use crate::evaluation::metrics::root_mean;
use crate::features::ColumnKind;

/// Fits worked on at once.
const LANES: usize = 8;

/// One number per lane.
type Lanes = [f64; LANES];

/// What must be left of each column's squared length, as a share, after the columns before it have explained theirs.
///
/// Far above the share at which [`fit`] drops a column: whoever is anywhere near that takes the careful way.
const SURELY_INDEPENDENT: f64 = 1e-6;

/// What must remain of each column's squared length, as a share, when a part is taken off the total.
///
/// The difference carries the total's rounding errors, near 1e-15: with this much left they stay far below
/// [`SURELY_INDEPENDENT`].
const SURELY_REMAINS: f64 = 1e-2;

/// From so many columns on groups of fits are worked on side by side; below, whoever calls has many of them to share out.
const MANY_COLUMNS: usize = 48;

/// The fits that leave each part out of the total, on some of the columns.
#[derive(Clone, Copy, Debug)]
pub struct LeftOut<'a> {
    /// The sums over all parts.
    pub total: &'a NormalEquations,
    /// What is left out in turn; parts without samples say nothing and do not belong here.
    pub parts: &'a [NormalEquations],
    /// What is fitted.
    pub terms: Terms<'a>,
}

impl LeftOut<'_> {
    /// Whether a fit has as many samples as coefficients that nothing shrinks, whichever part is left out; without that
    /// an error says more about the solution that was picked among many than about the data.
    #[must_use]
    pub fn is_determined(&self, strengths: &[f64]) -> bool {
        let is_shrunk = strengths.iter().all(|strength| *strength > 0.0);
        let kinds = self
            .terms
            .used
            .iter()
            .map(|&column| self.terms.kinds[column]);
        let free = kinds.filter(|kind| !(is_shrunk && *kind == ColumnKind::Appended));
        let samples = fewest_samples_without_a_part(self.parts.iter().map(|part| part.n_samples()));
        samples.is_some_and(|samples| samples >= free.count() as u64)
    }

    /// Root mean squared error per target over all parts, each predicted by the fit to the others with these strengths;
    /// `None` where the others do not determine a fit.
    #[must_use]
    pub fn rmse(&self, strengths: &[f64]) -> Option<Vec<f64>> {
        if !self.is_determined(strengths) {
            return None;
        }
        let q = self.total.n_targets();
        let squares = self.squares_by_target(strengths);
        root_mean(&summed_by_target(&squares, q), self.total.n_samples())
    }

    /// The strength of the ridge for each target, and [`Self::squares_by_target`] with it; none with fewer than two parts.
    ///
    /// An automatic ridge is the strongest one that does no worse than the best within one standard error over the parts:
    /// the error of the difference to the best, part by part, of the sums of squares. So where the parts disagree about
    /// what the blocks bring, the answer stays near the conventional calibration. With fewer than two parts nothing can
    /// be compared, and all strengths are zero. Scores with strengths chosen by them are slightly too good: one number
    /// per axis was fitted to all parts.
    #[must_use]
    pub fn with_ridge(&self, ridge: RidgeChoice) -> (Vec<f64>, Option<Vec<f64>>) {
        let q = self.total.n_targets();
        let enough = self.parts.len() > 1;
        match ridge {
            RidgeChoice::Strength(strength) => {
                let squares = enough.then(|| self.squares(strength));
                (vec![strength; q], squares)
            }
            RidgeChoice::Auto if !enough => (vec![0.0; q], None),
            RidgeChoice::Auto => {
                let tried: Vec<Vec<f64>> = RIDGE_STRENGTHS
                    .iter()
                    .map(|strength| self.squares(*strength))
                    .collect();
                let n_parts = self.parts.len();
                let chosen: Vec<usize> = (0..q)
                    .map(|axis| strongest_good(n_parts, |at, part| tried[at][part * q + axis]))
                    .collect();
                let squares = (0..n_parts * q)
                    .map(|at| tried[chosen[at % q]][at])
                    .collect();
                let strengths = chosen.iter().map(|at| RIDGE_STRENGTHS[*at]).collect();
                (strengths, Some(squares))
            }
        }
    }

    /// [`Self::squares`] with a strength of its own for each target.
    #[must_use]
    pub fn squares_by_target(&self, strengths: &[f64]) -> Vec<f64> {
        let q = self.total.n_targets();
        let mut squares = vec![0.0; self.parts.len() * q];
        for target in 0..q {
            if strengths[..target].contains(&strengths[target]) {
                continue; // filled in with the first target of this strength
            }
            let with_it = self.squares(strengths[target]);
            for at in 0..squares.len() {
                if strengths[at % q] == strengths[target] {
                    squares[at] = with_it[at];
                }
            }
        }
        squares
    }

    /// Sums of squared errors of each part, predicted by the fit to the others with a ridge relative to the columns'
    /// lengths.
    ///
    /// **Shapes** `n_parts × n_targets`, row-major.
    ///
    /// # Panics
    /// If the sums differ in their columns, or the terms do not fit them.
    #[must_use]
    pub fn squares(&self, strength: f64) -> Vec<f64> {
        let q = self.total.n_targets();
        // A column that is zero in every part would send each of them the careful way.
        let used = self.total.present_among(self.terms.used);
        let left_out = LeftOut {
            terms: Terms {
                used: &used,
                ..self.terms
            },
            ..*self
        };
        let mut squares = vec![0.0; self.parts.len() * q];
        let mut is_sure = vec![false; self.parts.len()];
        let at_least = if used.len() < MANY_COLUMNS {
            usize::MAX
        } else {
            1
        };
        (self.parts.par_chunks(LANES).with_min_len(at_least))
            .zip(squares.par_chunks_mut(LANES * q))
            .zip(is_sure.par_chunks_mut(LANES))
            .for_each_init(
                || Work::new(used.len(), q),
                |work, ((parts, squares), is_sure)| {
                    pulp::Arch::new().dispatch(Group {
                        left_out: &left_out,
                        parts,
                        strength,
                        work: &mut *work,
                    });
                    for (lane, squares) in squares.chunks_mut(q).enumerate() {
                        for (square, lanes) in squares.iter_mut().zip(&work.squares) {
                            *square = lanes[lane].max(0.0);
                        }
                        is_sure[lane] = work.least_pivot[lane] >= SURELY_INDEPENDENT
                            && work.least_remains[lane] >= SURELY_REMAINS;
                    }
                },
            );
        let careful = NormalEquations::each_without(
            self.parts,
            |at| !is_sure[at],
            |at, rest| {
                let found = fit(rest, left_out.terms, Ridge::Relative(strength));
                self.parts[at].squared_residuals(&found.coefficients)
            },
        );
        for (at, careful) in careful {
            squares[at * q..][..q].copy_from_slice(&careful);
        }
        squares
    }
}

/// Sums over the parts of `n_parts × n_targets` squares.
pub(crate) fn summed_by_target(squares: &[f64], n_targets: usize) -> Vec<f64> {
    (0..n_targets)
        .map(|target| squares.iter().skip(target).step_by(n_targets).sum())
        .collect()
}

/// The fewest samples that are left to fit when a part is left out; `None` with fewer than two parts.
#[must_use]
pub fn fewest_samples_without_a_part(
    part_samples: impl Iterator<Item = u64> + Clone,
) -> Option<u64> {
    let total: u64 = part_samples.clone().sum();
    let largest = part_samples.clone().max()?;
    (part_samples.count() > 1).then(|| total - largest)
}

/// Room for one group of fits of `m` columns and `q` targets.
struct Work {
    m: usize,
    q: usize,
    /// The part's products: the lower triangle of `XᵀX` row by row, then a row of `XᵀY` for each target.
    part: Vec<Lanes>,
    /// Likewise those of the rest, each column scaled to length one; becomes the factor.
    factor: Vec<Lanes>,
    inverse_length: Vec<Lanes>,
    inverse_root: Vec<Lanes>,
    coefficients: Vec<Lanes>,
    least_pivot: Lanes,
    /// The least share of a column's squared length that remains without the part.
    least_remains: Lanes,
    squares: Vec<Lanes>,
}

impl Work {
    fn new(m: usize, q: usize) -> Self {
        let room = |len| vec![[0.0; LANES]; len];
        let products = row_start(m) + q * m;
        Self {
            m,
            q,
            part: room(products),
            factor: room(products),
            inverse_length: room(m),
            inverse_root: room(m),
            coefficients: room(m),
            least_pivot: [0.0; LANES],
            least_remains: [0.0; LANES],
            squares: room(q),
        }
    }
}

/// Where row `i` of a lower triangle begins, diagonal included.
const fn row_start(i: usize) -> usize {
    i * (i + 1) / 2
}

/// Compiled for each instruction set; which one is decided when the program runs.
struct Group<'a> {
    left_out: &'a LeftOut<'a>,
    parts: &'a [NormalEquations],
    strength: f64,
    work: &'a mut Work,
}

impl pulp::WithSimd for Group<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        self.gather();
        self.work.factorise();
        for target in 0..self.work.q {
            self.work.substitute_back(target);
            let own = |part: &NormalEquations| part.target_square(target);
            let square = gathered(self.parts, own);
            self.work.squares[target] = self.work.squares_on_part(target, square);
        }
    }
}

/// One number of each part; lanes without a part repeat the last one.
#[inline(always)]
fn gathered(parts: &[NormalEquations], number: impl Fn(&NormalEquations) -> f64) -> Lanes {
    std::array::from_fn(|lane| number(&parts[lane.min(parts.len() - 1)]))
}

impl Group<'_> {
    /// Fills in the products of the parts and of what is left without them.
    #[inline(always)]
    fn gather(&mut self) {
        let LeftOut { total, terms, .. } = *self.left_out;
        let Terms { used, kinds, .. } = terms;
        let work = &mut *self.work;
        work.least_remains = [f64::INFINITY; LANES];
        for (i, &column) in used.iter().enumerate() {
            let is_shrunk = kinds[column] == ColumnKind::Appended;
            let penalty = if is_shrunk { self.strength } else { 0.0 };
            let all = total.feature_product(column, column);
            let part = gathered(self.parts, |part| part.feature_product(column, column));
            work.part[row_start(i) + i] = part;
            let mut present = [0.0; LANES];
            for lane in 0..LANES {
                let remains = (all - part[lane]) / all;
                if !(remains >= work.least_remains[lane]) {
                    work.least_remains[lane] = remains;
                }
                let square = (all - part[lane]) * (1.0 + penalty);
                let is_there = square > 0.0;
                work.inverse_length[i][lane] = if is_there { 1.0 / square.sqrt() } else { 0.0 };
                present[lane] = f64::from(u8::from(is_there));
            }
            work.factor[row_start(i) + i] = present;
            for (j, &other) in used[..i].iter().enumerate() {
                let all = total.feature_product(column, other);
                let part = gathered(self.parts, |part| part.feature_product(column, other));
                let at = row_start(i) + j;
                work.part[at] = part;
                for lane in 0..LANES {
                    let scale = work.inverse_length[i][lane] * work.inverse_length[j][lane];
                    work.factor[at][lane] = (all - part[lane]) * scale;
                }
            }
        }
        for target in 0..work.q {
            for (j, &column) in used.iter().enumerate() {
                let all = total.target_product(column, target);
                let part = gathered(self.parts, |part| part.target_product(column, target));
                let at = row_start(work.m) + target * work.m + j;
                work.part[at] = part;
                for lane in 0..LANES {
                    work.factor[at][lane] = (all - part[lane]) * work.inverse_length[j][lane];
                }
            }
        }
    }
}

impl Work {
    /// Cholesky, column by column; a pivot that is not surely positive is noted and counts as infinite.
    #[inline(always)]
    fn factorise(&mut self) {
        let m = self.m;
        self.least_pivot = [f64::INFINITY; LANES];
        for j in 0..m {
            let (before, from_row) = self.factor.split_at_mut(row_start(j));
            debug_assert_eq!(before.len(), row_start(j));
            let (row, below) = from_row.split_at_mut(j + 1);
            let (own, pivot) = row.split_at_mut(j);
            let pivot = reduced(pivot[0], own, own);
            for lane in 0..LANES {
                // Not `min`, which would take NaN for the larger one.
                if !(pivot[lane] >= self.least_pivot[lane]) {
                    self.least_pivot[lane] = pivot[lane];
                }
                let sure = pivot[lane] >= SURELY_INDEPENDENT;
                self.inverse_root[j][lane] = if sure { 1.0 / pivot[lane].sqrt() } else { 0.0 };
            }
            let inverse_root = self.inverse_root[j];
            let mut start = 0;
            for i in j + 1..m + self.q {
                let len = if i < m { i + 1 } else { m };
                let row = &mut below[start..start + len];
                let (done, entry) = row.split_at_mut(j);
                let value = reduced(entry[0], done, own);
                for lane in 0..LANES {
                    entry[0][lane] = value[lane] * inverse_root[lane];
                }
                start += len;
            }
        }
    }

    /// The coefficients of one target, on columns of length one.
    #[inline(always)]
    fn substitute_back(&mut self, target: usize) {
        let m = self.m;
        let right = row_start(m) + target * m;
        for j in (0..m).rev() {
            let mut value = self.factor[right + j];
            for i in j + 1..m {
                let factor = &self.factor[row_start(i) + j];
                for lane in 0..LANES {
                    value[lane] -= factor[lane] * self.coefficients[i][lane];
                }
            }
            for lane in 0..LANES {
                self.coefficients[j][lane] = value[lane] * self.inverse_root[j][lane];
            }
        }
    }

    /// `yᵀy − 2bᵀXᵀy + bᵀXᵀXb` on the part; see [`NormalEquations::squared_residuals`].
    #[inline(always)]
    fn squares_on_part(&mut self, target: usize, mut square: Lanes) -> Lanes {
        let m = self.m;
        for (coefficient, scale) in self.coefficients.iter_mut().zip(&self.inverse_length) {
            for lane in 0..LANES {
                coefficient[lane] *= scale[lane];
            }
        }
        let right = &self.part[row_start(m) + target * m..][..m];
        for (i, right) in right.iter().enumerate() {
            let row = &self.part[row_start(i)..][..=i];
            let mut earlier = [0.0; LANES];
            for (product, coefficient) in row[..i].iter().zip(&self.coefficients) {
                for lane in 0..LANES {
                    earlier[lane] += product[lane] * coefficient[lane];
                }
            }
            let own = self.coefficients[i];
            for lane in 0..LANES {
                let explained = row[i][lane] * own[lane] + 2.0 * (earlier[lane] - right[lane]);
                square[lane] += own[lane] * explained;
            }
        }
        square
    }
}

/// `value − Σ aₖ bₖ`, over the length of `b`.
#[inline(always)]
fn reduced(mut value: Lanes, a: &[Lanes], b: &[Lanes]) -> Lanes {
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            value[lane] = (-a[lane]).mul_add(b[lane], value[lane]);
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// `n` parts of `p` columns and two targets without a simple relation; column 1 is `explained` times column 0 plus
    /// something small of its own.
    fn parts(n: usize, p: usize, small: f64) -> (NormalEquations, Vec<NormalEquations>) {
        let parts: Vec<_> = (0..n)
            .map(|part| {
                let mut sums = NormalEquations::new(p, 2);
                for k in 0..40 + part {
                    let t = (k * 7 + part * 131) as f64;
                    let mut row = vec![0.0; sums.stride()];
                    for (column, value) in row[..p + 2].iter_mut().enumerate() {
                        *value = (t * (0.11 + 0.07 * column as f64)).sin() + 0.1 * column as f64;
                    }
                    if p > 1 {
                        row[1] = 3.0 * row[0] + small * row[1];
                    }
                    sums.add_rows(&row);
                }
                sums
            })
            .collect();
        let mut total = NormalEquations::new(p, 2);
        parts.iter().for_each(|part| total.add(part));
        (total, parts)
    }

    #[track_caller]
    fn assert_as_one_by_one(n: usize, p: usize, small: f64, used: &[usize], strength: f64) {
        let (total, parts) = parts(n, p, small);
        let shrunk = |column: usize| match column % 3 {
            0 => ColumnKind::Gauge,
            _ => ColumnKind::Appended,
        };
        let terms = Terms {
            used,
            kinds: &(0..p).map(shrunk).collect::<Vec<_>>(),
            known: &[],
        };
        let left_out = LeftOut {
            total: &total,
            parts: &parts,
            terms,
        };
        let one_by_one = NormalEquations::each_without(
            &parts,
            |_| true,
            |at, rest| {
                let found = fit(rest, terms, Ridge::Relative(strength));
                parts[at].squared_residuals(&found.coefficients)
            },
        );
        let expected = one_by_one.into_iter().flat_map(|(_, squares)| squares);
        for (actual, expected) in left_out.squares(strength).iter().zip(expected) {
            let error = (actual / expected - 1.0).abs();
            assert!(error < 1e-10, "{n} parts, {p} columns, {small}: {error}");
        }
    }

    #[test]
    fn eight_at_once_equal_one_by_one() {
        for n in [2, 7, 8, 9, 20] {
            for p in [1, 2, 5, 14] {
                let all: Vec<usize> = (0..p).collect();
                for strength in [0.0, 0.01, 3.0] {
                    assert_as_one_by_one(n, p, 1.0, &all, strength);
                }
            }
        }
        assert_as_one_by_one(10, 9, 1.0, &[7, 2, 4], 0.1);
    }

    /// Column 1 is column 0 again, up to nothing at all or to less than a thousandth.
    #[test]
    fn columns_that_explain_each_other_take_the_careful_way() {
        for small in [0.0, 1e-4] {
            assert_as_one_by_one(9, 6, small, &[0, 1, 2, 3, 4, 5], 0.0);
        }
    }

    /// What only one part has cannot be learned from the others.
    #[test]
    fn a_column_that_only_the_left_out_part_has_gets_no_coefficient() {
        let part = |has: f64| {
            let mut sums = NormalEquations::new(2, 1);
            for k in 0..5 {
                let mut row = vec![0.0; sums.stride()];
                let x = f64::from(k) - 1.7;
                row[..3].copy_from_slice(&[x, has * x * x, 2.0 * x + 5.0 * has]);
                sums.add_rows(&row);
            }
            sums
        };
        let parts = [part(1.0), part(0.0), part(0.0)];
        let mut total = NormalEquations::new(2, 1);
        parts.iter().for_each(|part| total.add(part));
        let left_out = LeftOut {
            total: &total,
            parts: &parts,
            terms: Terms {
                used: &[0, 1],
                kinds: &[ColumnKind::Gauge; 2],
                known: &[],
            },
        };
        assert!(
            (left_out.squares(0.0)[0] - 125.0).abs() < 1e-9,
            "five errors of 5"
        );
    }

    /// A mean fitted without the part: parts {0, 0} and {3} are scored by 3 and by 0, so every error is 3.
    #[test]
    fn a_left_out_part_takes_no_part_in_its_fit() {
        let parts = [&[0.0, 0.0][..], &[3.0]].map(|values| {
            let mut sums = NormalEquations::new(1, 1);
            for value in values {
                let mut row = vec![0.0; sums.stride()];
                row[..2].copy_from_slice(&[1.0, *value]);
                sums.add_rows(&row);
            }
            sums
        });
        let mut total = parts[0].clone();
        total.add(&parts[1]);
        let terms = Terms {
            used: &[0],
            kinds: &[ColumnKind::Offset],
            known: &[],
        };
        let left_out = |parts| LeftOut {
            total: &total,
            parts,
            terms,
        };
        let rmse = left_out(&parts).rmse(&[0.0]).unwrap();
        assert!((rmse[0] - 3.0).abs() < 1e-12);
        assert_eq!(left_out(&parts[..1]).rmse(&[0.0]), None);
    }

    /// Six parts whose target is the first column; the second is noise with another sign in every part.
    #[test]
    fn the_ridge_is_strong_where_the_columns_only_memorise() {
        let part = |sign: f64, useful: f64| {
            let mut sums = NormalEquations::new(1, 1);
            for k in 0..20 {
                let x = (f64::from(k) * 0.7).sin();
                let mut row = vec![0.0; sums.stride()];
                row[..2].copy_from_slice(&[x, (useful + sign) * x]);
                sums.add_rows(&row);
            }
            sums
        };
        let strength = |useful: f64| {
            let signs = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
            let parts = signs.map(|sign| part(0.1 * sign, useful));
            let mut total = NormalEquations::new(1, 1);
            parts.iter().for_each(|part| total.add(part));
            let terms = Terms {
                used: &[0],
                kinds: &[ColumnKind::Appended],
                known: &[],
            };
            let left_out = LeftOut {
                total: &total,
                parts: &parts,
                terms,
            };
            left_out.with_ridge(RidgeChoice::Auto).0[0]
        };
        assert_eq!(strength(0.0), 1e9);
        assert!(strength(10.0) < 0.1);
    }

    /// One part of a random design: rows `[x | load]`.
    type Samples = Vec<Vec<f64>>;

    /// Coefficients on the loads by Gram and Schmidt on the samples, a column that those before it explain left at zero.
    fn explicit_fit(rows: &[&Vec<f64>], in_order: &[usize]) -> Vec<(usize, f64)> {
        let column = |at: usize| -> Vec<f64> { rows.iter().map(|row| row[at]).collect() };
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        type MadeOf = Vec<(usize, f64)>;
        let mut basis: Vec<(Vec<f64>, MadeOf)> = Vec::new(); // orthogonal, each with what it is made of
        for &at in in_order {
            let mut left = column(at);
            let length = dot(&left, &left).sqrt();
            let mut made_of = vec![(at, 1.0)];
            for _ in 0..2 {
                for (other, its) in &basis {
                    let share = dot(&left, other) / dot(other, other);
                    left.iter_mut()
                        .zip(other)
                        .for_each(|(x, o)| *x -= share * o);
                    made_of.extend(its.iter().map(|(column, b)| (*column, -share * b)));
                }
            }
            if dot(&left, &left).sqrt() > 1e-8 * length {
                basis.push((left, made_of));
            }
        }
        let loads = column(rows[0].len() - 1);
        let shares = basis.iter().flat_map(|(own, made_of)| {
            let share = dot(&loads, own) / dot(own, own);
            made_of.iter().map(move |(column, b)| (*column, share * b))
        });
        shares.collect()
    }

    /// Thin ones among them, and gauges that move in one part alone, stand still at some value or at zero elsewhere, by
    /// sizes that differ by up to a million.
    #[test]
    fn errors_are_those_of_explicit_refits_on_random_designs() {
        for seed in 0..400 {
            let mut random = Random::new(seed, &[]);
            let mut whole =
                |low: usize, high: usize| random.between(low as f64, high as f64) as usize;
            let (n_parts, n_gauges, n_appended) = (whole(2, 8), whole(1, 7), whole(0, 5));
            let p = n_gauges + n_appended + 1;
            let lengths: Vec<usize> = (0..n_parts).map(|_| whole(p + 1, 3 * p + 4)).collect();
            let lives_in: Vec<usize> = (0..n_gauges).map(|_| whole(0, 3 * n_parts)).collect();
            let stands_at: Vec<f64> = (0..n_gauges)
                .map(|_| {
                    if random.between(0.0, 1.0) < 0.5 {
                        0.0
                    } else {
                        random.normal()
                    }
                })
                .collect();
            let size: Vec<f64> = (0..n_gauges)
                .map(|_| 10f64.powf(random.between(-3.0, 3.0)))
                .collect();
            let known: Vec<f64> = (0..p)
                .map(|at| match at {
                    _ if at < n_gauges => random.normal() / size[at],
                    _ if at + 1 < p => 0.0,
                    _ => random.normal(),
                })
                .collect();
            let samples: Vec<Samples> = lengths
                .iter()
                .enumerate()
                .map(|(part, &n)| {
                    let sample = |_| {
                        let mut row: Vec<f64> = (0..n_gauges)
                            .map(|gauge| {
                                let moves = lives_in[gauge] >= n_parts || lives_in[gauge] == part;
                                let value = if moves {
                                    random.normal()
                                } else {
                                    stands_at[gauge]
                                };
                                size[gauge] * value
                            })
                            .collect();
                        row.extend((0..n_appended).map(|_| random.normal()));
                        row.push(1.0);
                        row.push(3.0 * random.normal() + row[0] / size[0]);
                        row
                    };
                    (0..n).map(sample).collect()
                })
                .collect();
            let parts: Vec<NormalEquations> = samples
                .iter()
                .map(|samples| {
                    let mut sums = NormalEquations::new(p, 1);
                    for row in samples {
                        let mut padded = row.clone();
                        padded[p] -= row.iter().zip(&known).map(|(x, b)| x * b).sum::<f64>();
                        padded.resize(sums.stride(), 0.0);
                        sums.add_rows(&padded);
                    }
                    sums
                })
                .collect();
            let mut total = NormalEquations::new(p, 1);
            parts.iter().for_each(|part| total.add(part));
            let mut kinds = vec![ColumnKind::Gauge; n_gauges];
            kinds.resize(p - 1, ColumnKind::Appended);
            kinds.push(ColumnKind::Offset);
            let used: Vec<usize> = (0..p).collect();
            let terms = Terms {
                used: &used,
                kinds: &kinds,
                known: &known,
            };
            let left_out = LeftOut {
                total: &total,
                parts: &parts,
                terms,
            };
            let in_order: Vec<usize> = std::iter::once(p - 1).chain(0..p - 1).collect();
            for (at, square) in left_out.squares(0.0).into_iter().enumerate() {
                let others = samples.iter().enumerate().filter(|(other, _)| *other != at);
                let rows: Vec<&Vec<f64>> = others.flat_map(|(_, samples)| samples).collect();
                let fitted = explicit_fit(&rows, &in_order);
                let explicit: f64 = samples[at]
                    .iter()
                    .map(|row| row[p] - fitted.iter().map(|(at, b)| row[*at] * b).sum::<f64>())
                    .map(|error| error * error)
                    .sum();
                let error = (square / explicit - 1.0).abs();
                assert!(
                    error < 1e-6,
                    "seed {seed}, part {at}: {square} instead of {explicit}"
                );
            }
        }
    }

    /// Fewer samples than coefficients without a part: many solutions, so no figure, unless a ridge picks one.
    #[test]
    fn where_the_others_do_not_determine_a_fit_there_is_no_figure() {
        let (total, parts) = parts(2, 60, 1.0);
        let used: Vec<usize> = (0..60).collect();
        let figure = |kinds: &[ColumnKind], strength: f64| {
            let terms = Terms {
                used: &used,
                kinds,
                known: &[],
            };
            let left_out = LeftOut {
                total: &total,
                parts: &parts,
                terms,
            };
            left_out.rmse(&[strength; 2])
        };
        let appended = [&[ColumnKind::Gauge; 5][..], &[ColumnKind::Appended; 55]].concat();
        assert_eq!(figure(&[ColumnKind::Gauge; 60], 0.1), None);
        assert_eq!(figure(&appended, 0.0), None);
        assert!(figure(&appended, 0.1).is_some());
    }
}
