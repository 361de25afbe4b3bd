//! Held-out errors of the calibration with the columns of every set of causes.
//!
//! All fits and errors follow from the sums of the blocks.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};
use rayon::prelude::*;

use crate::{
    progress::{Cancelled, Progress},
    scoring::budget::{
        cause::{Cause, Causes},
        columns::Columns,
        freedoms::{BlockScores, Gains, gains},
        run::Unit,
        sums::Sums,
    },
};

/// Ridge on offset and gauges, per sample.
const GAUGE_RIDGE: f64 = 1e-9;
/// Ridges on the columns of the causes, per sample. Each set of causes uses the one with the smallest held-out error.
const RIDGES: [f64; 4] = [1e-6, 1e-4, 1e-2, 1.0];
/// Maximum number of fits that each leave out some units.
const MOST_FOLDS: usize = 10;
/// Mean ratio of the squared loads of a fold to those of the others, above which the others hardly have its loads.
const MOST_NEW_LOADS: f64 = 30.0;

/// Solves a symmetric, positive definite system; zero if it is not positive definite.
pub fn solve(products: &Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    match products.llt(Side::Lower) {
        Ok(factor) => factor.solve(right),
        Err(_) => Mat::zeros(right.nrows(), right.ncols()),
    }
}

/// Held-out errors on one axis with one set of causes, in full scales.
#[derive(Clone, Debug)]
pub struct AxisErrors {
    /// Squared errors, summed over each block.
    pub squares: Vec<f64>,
    /// Variance of the noise that the calibration passes on.
    pub noise: f64,
    /// For each cause of units, the reduction of the squared errors and its variance by chance.
    pub gains: [(f64, f64); Cause::OF_UNITS.len()],
}

/// Errors on each axis with each set of causes that is tested, by the index of the set.
pub type AllErrors = Vec<Option<Vec<AxisErrors>>>;

/// Computes the held-out errors of one base from its sums.
pub struct HeldOut<'a> {
    pub columns: &'a Columns,
    pub units: &'a [Unit],
    pub sums: &'a Sums,
    /// Columns of the calibration whose error is explained: offset, gauges, and columns of the compensation.
    pub base: Vec<usize>,
    pub model_ridge: f64,
    /// Causes of units that are tested.
    pub of_units: Vec<Cause>,
    pub full_scale: &'a [f64],
}

/// What a fit takes out of each training unit before it is fitted: its own offset, its own slope in time.
type Projection = [bool; 2];

/// Errors with one projection and one set of causes with columns. The columns are those of the weights: ridge, then axis.
#[derive(Default)]
struct Tried {
    /// Sums over each block and column.
    blocks: Vec<Vec<ErrorSums>>,
    /// Noise of each column.
    noise: Vec<f64>,
}

impl HeldOut<'_> {
    pub fn errors(&self, progress: &Progress) -> Result<AllErrors, Cancelled> {
        let with_columns: Vec<Cause> = self.sums.of_causes.iter().map(|own| own.0).collect();
        let (sets, unit_sets) = (Causes::subsets(&with_columns), Causes::subsets(&self.of_units));
        let mut projections: Vec<Projection> =
            unit_sets.iter().map(|own| projection(*own)).collect();
        projections.sort_unstable();
        projections.dedup();
        let folds = self.folds();
        let totals: Vec<Vec<Mat<f64>>> =
            folds.par_iter().map(|own| self.totals(own, &projections)).collect();
        let place =
            |set: Causes| projections.iter().position(|own| *own == projection(set)).unwrap_or(0);
        // For each fold: the errors with each projection, and then with each set of causes with columns.
        let of_fold = |at: usize| {
            let others = |which: usize| {
                let width = self.columns.width;
                let parts = totals.iter().enumerate().filter(|(fold, _)| *fold != at);
                let parts = parts.map(|(_, own)| &own[which]);
                parts.fold(Mat::zeros(width, width), |sum: Mat<f64>, own| sum + own)
            };
            let plain = others(place(Causes::default()));
            let mut tried = Vec::new();
            for (number, projection) in projections.iter().enumerate() {
                progress.check()?;
                let weights = self.weights(&others(number), &plain, *projection, &sets);
                let sets = sets.iter().zip(&weights);
                tried.extend(sets.map(|(set, weights)| self.tried(&folds[at], *set, weights)));
            }
            Ok(tried)
        };
        let found: Result<Vec<Vec<Tried>>, Cancelled> =
            (0..folds.len()).into_par_iter().map(of_fold).collect();
        let mut all: Vec<Tried> = Vec::new();
        all.resize_with(projections.len() * sets.len(), Tried::default);
        for (tried, units) in found?.into_iter().zip(&folds) {
            for (all, own) in all.iter_mut().zip(tried) {
                all.blocks.resize(self.sums.blocks.len(), Vec::new());
                all.noise.resize(own.noise.len(), 0.0);
                all.noise.iter_mut().zip(own.noise).for_each(|(all, own)| *all += own);
                let blocks = units.iter().flat_map(|unit| self.units[*unit].block_numbers());
                blocks.zip(own.blocks).for_each(|(block, own)| all.blocks[block] = own);
            }
        }
        let pairs: Vec<(usize, Causes)> =
            unit_sets.iter().flat_map(|own| (0..sets.len()).map(|set| (set, *own))).collect();
        let errors = pairs.par_iter().map(|(set, unit_set)| {
            progress.check()?;
            let tried = &all[place(*unit_set) * sets.len() + set];
            let of_axis = |axis: usize| {
                let columns = (0..RIDGES.len()).map(|ridge| ridge * self.columns.n_axes() + axis);
                let errors = columns.map(|column| self.errors_with(tried, *unit_set, column));
                let total = |own: &AxisErrors| own.squares.iter().sum::<f64>();
                errors.min_by(|a, b| total(a).total_cmp(&total(b))).expect("there are ridges")
            };
            let errors: Vec<AxisErrors> = (0..self.columns.n_axes()).map(of_axis).collect();
            Ok((sets[*set].union(*unit_set).index(), errors))
        });
        let errors: Result<Vec<_>, Cancelled> = errors.collect();
        let mut by_set: AllErrors = vec![None; Causes::N_SETS];
        errors?.into_iter().for_each(|(index, errors)| by_set[index] = Some(errors));
        Ok(by_set)
    }

    /// Returns the errors of the units of a fold with one set of causes with columns.
    fn tried(&self, units: &[usize], set: Causes, weights: &Mat<f64>) -> Tried {
        let used = self.used(set);
        let rows = self.rows(&used);
        let n_samples = &self.sums.n_samples;
        let numbers = || units.iter().flat_map(|unit| self.units[*unit].block_numbers());
        let n = numbers().map(|block| n_samples[block]).sum::<f64>();
        let share = n / n_samples.iter().sum::<f64>();
        let noise = self.passed_on(weights, &rows, &used).into_iter().map(|own| own * share);
        let blocks =
            numbers().map(|block| self.error_sums(&self.sums.blocks[block], weights, &rows, &used));
        Tried { noise: noise.collect(), blocks: blocks.collect() }
    }

    /// Returns the errors of one column of weights if each unit has the freedoms of a set of causes of units.
    fn errors_with(&self, tried: &Tried, unit_set: Causes, column: usize) -> AxisErrors {
        let axis = column % self.columns.n_axes();
        let wanted = Cause::OF_UNITS.map(|cause| unit_set.contains(cause));
        let of_unit = |unit: &Unit| {
            let blocks = unit.block_numbers();
            let scores = blocks.map(|block| {
                self.scores(&tried.blocks[block][column], &self.sums.blocks[block], axis)
            });
            gains(&mut scores.collect::<Vec<BlockScores>>(), wanted)
        };
        let mut of_units: Vec<Gains> = if unit_set.len() > 0 {
            self.units.iter().map(of_unit).collect()
        } else {
            vec![Gains::default(); self.units.len()]
        };
        // The factor that all units share is no difference between units.
        let (score, weight) = (of_units.iter().map(|own| own.factor))
            .fold((0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
        let common = score / weight.max(1e-300);
        let scale = self.full_scale[axis].powi(2);
        let noise = tried.noise[column] / scale;
        let mut errors = AxisErrors { squares: Vec::new(), noise, gains: [(0.0, 0.0); 3] };
        for (unit, gain) in self.units.iter().zip(&mut of_units) {
            let change = common * (common * gain.factor.1 - 2.0 * gain.factor.0);
            gain.reduction += change;
            gain.of_each[Cause::OF_UNITS.len() - 1].0 += change;
            let squares = unit.block_numbers().map(|block| tried.blocks[block][column].square);
            let kept = 1.0 - gain.reduction / squares.clone().sum::<f64>().max(1e-300);
            errors.squares.extend(squares.map(|square| square * kept / scale));
            for (sum, (gain, variance)) in errors.gains.iter_mut().zip(gain.of_each) {
                *sum = (sum.0 + gain / scale, sum.1 + variance / (scale * scale));
            }
        }
        errors
    }

    /// Returns for each axis the mean squared residual of the base when it is fitted to all samples, and the noise that it
    /// passes on.
    pub fn in_sample(&self) -> Vec<(f64, f64)> {
        let total = self.sums.total();
        let all = self.weights(&total, &total, [false; 2], &[Causes::default()]);
        let weights = all[0].subcols(0, self.columns.n_axes()).to_owned();
        let rows = self.rows(&self.base);
        let errors = self.error_sums(&total, &weights, &rows, &self.base);
        let noise = self.passed_on(&weights, &rows, &self.base);
        errors.iter().map(|own| own.square / total[(0, 0)]).zip(noise).collect()
    }

    /// Returns true if a fold leaves out loads of which the others have hardly any, on any combination of axes.
    pub fn leaves_out_new_loads(&self) -> bool {
        let loads: Vec<usize> =
            [0].into_iter().chain(self.columns.loads..self.columns.width).collect();
        let n_loads = loads.len();
        let of_units = |units: &[usize]| {
            let blocks = units.iter().flat_map(|unit| self.units[*unit].block_numbers());
            blocks.fold(Mat::zeros(n_loads, n_loads), |sum: Mat<f64>, block| {
                sum + picked(&self.sums.blocks[block], &loads, &loads)
            })
        };
        let folds: Vec<Mat<f64>> = self.folds().iter().map(|units| of_units(units)).collect();
        let total = folds.iter().fold(Mat::zeros(n_loads, n_loads), |sum: Mat<f64>, own| sum + own);
        folds.iter().any(|own| {
            let mut others = &total - own;
            let weight = own[(0, 0)] / others[(0, 0)].max(1.0);
            (0..n_loads).for_each(|at| others[(at, at)] += 1e-9 * total[(at, at)]);
            let ratios = solve(&others, own);
            let sum: f64 = (0..n_loads).map(|at| ratios[(at, at)]).sum();
            sum > MOST_NEW_LOADS * weight * n_loads as f64
        })
    }

    /// Returns the numbers of the units that each fold leaves out.
    fn folds(&self) -> Vec<Vec<usize>> {
        let n_parts = self.units.iter().map(|unit| unit.part + 1).max().unwrap_or(0);
        let n_folds = n_parts.min(MOST_FOLDS);
        let mut folds = vec![Vec::new(); n_folds];
        // As many parts in each fold, or one more in the first folds.
        let (even, longer) = (n_parts / n_folds.max(1), n_parts % n_folds.max(1));
        let start = |fold: usize| fold * even + fold.min(longer);
        for (number, unit) in self.units.iter().enumerate() {
            let fold = (0..n_folds).rfind(|fold| start(*fold) <= unit.part).unwrap_or(0);
            folds[fold].push(number);
        }
        folds.retain(|units| !units.is_empty());
        folds
    }

    /// Returns the sums of some units for each projection.
    fn totals(&self, units: &[usize], projections: &[Projection]) -> Vec<Mat<f64>> {
        let width = self.columns.width;
        let mut totals = vec![Mat::zeros(width, width); projections.len()];
        for unit in units {
            let mut sums = Mat::<f64>::zeros(width, width);
            self.units[*unit].block_numbers().for_each(|block| sums += &self.sums.blocks[block]);
            for (total, [offset, slope]) in totals.iter_mut().zip(projections) {
                let freedoms = [(*offset, 0), (*slope, self.columns.time)];
                let freedoms: Vec<usize> =
                    freedoms.iter().filter(|own| own.0).map(|own| own.1).collect();
                *total += projected(&sums, &freedoms);
            }
        }
        totals
    }

    /// Returns the coefficients of base and causes for each set of causes; columns: ridge, then axis. The rows are those of
    /// [`Self::used`].
    fn weights(
        &self,
        sums: &Mat<f64>,
        plain: &Mat<f64>,
        [offset, _]: Projection,
        sets: &[Causes],
    ) -> Vec<Mat<f64>> {
        let (columns, n_axes) = (self.columns, self.columns.n_axes());
        // If each unit has an offset of its own, the fit has no common offset.
        let base = if offset { &self.base[1..] } else { &self.base[..] };
        let causes: Vec<usize> =
            self.sums.of_causes.iter().flat_map(|own| own.1.iter().copied()).collect();
        let loads: Vec<usize> = (columns.loads..columns.width).collect();
        let n = plain[(0, 0)];
        let mut among_base = picked(sums, base, base);
        for (at, column) in base.iter().enumerate() {
            let is_model = columns.model().contains(column);
            among_base[(at, at)] += n * if is_model { self.model_ridge } else { GAUGE_RIDGE };
        }
        let (with_causes, with_loads) = (picked(sums, base, &causes), picked(sums, base, &loads));
        let (causes_by_base, loads_by_base) =
            (solve(&among_base, &with_causes), solve(&among_base, &with_loads));
        let among_causes =
            picked(sums, &causes, &causes) - with_causes.transpose() * &causes_by_base;
        let causes_with_loads =
            picked(sums, &causes, &loads) - with_causes.transpose() * &loads_by_base;
        let of_set = |set: &Causes| {
            let own = self.positions(*set);
            let rows: Vec<usize> = (0..n_axes).collect();
            let right = picked(&causes_with_loads, &own, &rows);
            let mut all = Mat::zeros(self.base.len() + own.len(), RIDGES.len() * n_axes);
            for (at, ridge) in RIDGES.iter().enumerate() {
                let mut products = picked(&among_causes, &own, &own);
                (0..own.len()).for_each(|i| products[(i, i)] += ridge * n);
                let of_causes = solve(&products, &right);
                let base_rows: Vec<usize> = (0..base.len()).collect();
                let of_base =
                    &loads_by_base - picked(&causes_by_base, &base_rows, &own) * &of_causes;
                let mut part = all.subcols_mut(at * n_axes, n_axes);
                let first = usize::from(offset);
                part.as_mut().subrows_mut(first, base.len()).copy_from(&of_base);
                part.as_mut().subrows_mut(first + base.len(), own.len()).copy_from(&of_causes);
            }
            if offset {
                let used = self.used(*set);
                for column in 0..all.ncols() {
                    let explained = used.iter().enumerate().skip(1);
                    let explained: f64 =
                        explained.map(|(row, own)| plain[(0, *own)] * all[(row, column)]).sum();
                    all[(0, column)] =
                        (plain[(0, columns.loads + column % n_axes)] - explained) / n;
                }
            }
            all
        };
        sets.iter().map(of_set).collect()
    }

    /// Returns these columns, and those of the time and the loads.
    fn rows(&self, used: &[usize]) -> Vec<usize> {
        used.iter().copied().chain(self.columns.time..self.columns.width).collect()
    }

    /// Returns the columns of the base and of a set of causes.
    fn used(&self, set: Causes) -> Vec<usize> {
        let causes = self.sums.of_causes.iter().filter(|(cause, _)| set.contains(*cause));
        self.base.iter().chain(causes.flat_map(|own| &own.1)).copied().collect()
    }

    /// Returns the positions of a set's columns among the columns of all causes.
    fn positions(&self, set: Causes) -> Vec<usize> {
        let all =
            self.sums.of_causes.iter().flat_map(|(cause, own)| own.iter().map(move |_| *cause));
        all.enumerate().filter(|(_, cause)| set.contains(*cause)).map(|(at, _)| at).collect()
    }

    /// Returns sums of the errors of each column of weights over one block.
    fn error_sums(
        &self,
        block: &Mat<f64>,
        weights: &Mat<f64>,
        rows: &[usize],
        used: &[usize],
    ) -> Vec<ErrorSums> {
        let (columns, n_axes) = (self.columns, self.columns.n_axes());
        let products = picked(block, rows, used) * weights;
        let of_column = |column: usize| {
            let load = columns.loads + column % n_axes;
            let explained = products.col(column);
            let (row_of_time, row_of_load) = (used.len(), used.len() + 1 + column % n_axes);
            let both = weights.col(column).iter().zip(explained.iter());
            let quadratic: f64 = both.map(|(weight, product)| weight * product).sum();
            let with_load = block[(load, load)] - explained[row_of_load];
            ErrorSums {
                square: (with_load - explained[row_of_load] + quadratic).max(0.0),
                sum: block[(0, load)] - explained[0],
                with_time: block[(columns.time, load)] - explained[row_of_time],
                with_load,
            }
        };
        (0..weights.ncols()).map(of_column).collect()
    }

    fn scores(&self, error: &ErrorSums, block: &Mat<f64>, axis: usize) -> BlockScores {
        let (time, load) = (self.columns.time, self.columns.loads + axis);
        let mean = self.columns.inputs.load_means[axis];
        let n = block[(0, 0)];
        // The corrected load is the load minus the error.
        let y_1 = block[(0, load)] + mean * n - error.sum;
        let y_t = block[(time, load)] + mean * block[(0, time)] - error.with_time;
        let y_e = error.with_load + mean * error.sum - error.square;
        let load_square = block[(load, load)] + 2.0 * mean * block[(0, load)] + mean * mean * n;
        let y_y = load_square - 2.0 * (error.with_load + mean * error.sum) + error.square;
        BlockScores {
            products: [
                [n, block[(0, time)], y_1],
                [block[(0, time)], block[(time, time)], y_t],
                [y_1, y_t, y_y],
            ],
            scores: [error.sum, error.with_time, y_e],
        }
    }

    /// Returns the variance of the noise that each column of weights passes on; zero if the noise is unknown.
    fn passed_on(&self, weights: &Mat<f64>, rows: &[usize], used: &[usize]) -> Vec<f64> {
        let Some(noise) = &self.sums.noise else { return vec![0.0; weights.ncols()] };
        let squares = self.error_sums(&noise.differences, weights, rows, used);
        let axes = (0..weights.ncols()).map(|column| column % self.columns.n_axes());
        squares.iter().zip(axes).map(|(own, axis)| own.square * noise.scales[axis]).collect()
    }
}

/// Sums over one block: the squared error, the error, and its products with time and load.
#[derive(Clone, Copy, Debug, Default)]
struct ErrorSums {
    square: f64,
    sum: f64,
    with_time: f64,
    with_load: f64,
}

/// Returns which freedoms of the units a fit with these causes takes out of the training units.
fn projection(set: Causes) -> Projection {
    [set.contains(Cause::Zeros), set.contains(Cause::Drift)]
}

/// Returns the sums of a unit after its own multiples of these columns are taken out of all columns.
fn projected(sums: &Mat<f64>, freedoms: &[usize]) -> Mat<f64> {
    if freedoms.is_empty() {
        return sums.clone();
    }
    let mut among = picked(sums, freedoms, freedoms);
    let trace: f64 = (0..freedoms.len()).map(|at| among[(at, at)]).sum();
    (0..freedoms.len()).for_each(|at| among[(at, at)] += 1e-12 * trace);
    let all: Vec<usize> = (0..sums.ncols()).collect();
    let with = picked(sums, freedoms, &all);
    sums - with.transpose() * solve(&among, &with)
}

/// Returns these rows and columns of a matrix.
pub fn picked(of: &Mat<f64>, rows: &[usize], columns: &[usize]) -> Mat<f64> {
    let mut out = Mat::zeros(rows.len(), columns.len());
    for (to, from) in columns.iter().enumerate() {
        let (from, to) = (of.col_as_slice(*from), out.col_as_slice_mut(to));
        rows.iter().zip(to).for_each(|(row, to)| *to = from[*row]);
    }
    out
}
