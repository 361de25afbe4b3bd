//! Design row of a sample: gauges, columns of each block, offset.
//!
//! Guarantees: whole recordings and live estimators compute rows with the same code. Every block is causal and starts anew with
//! each [`FeatureStream`].

use std::ops::Range;

use crate::dot::dot;
use crate::features::block::{Appends, Block, Stream};
use crate::features::column::{Column, ColumnKind, History};
use crate::features::gauge_scale::GaugeScale;
use crate::features::look_back::Thresholds;
use crate::features::settings::{Blocks, FeatureSettings};

/// One block of features in a design.
pub struct OfBlock {
    /// `None` for the look-backs.
    pub block: Option<&'static dyn Block>,
    /// Settings in words.
    pub description: String,
    pub columns: Vec<usize>,
}

/// Columns of a design row, in this order: gauges; one set of past gauges for each look-back; the columns of each block,
/// histories before monomials and auxiliary channels last; offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Settings of the features.
    pub features: FeatureSettings,
    /// Shift and scale of each gauge.
    pub scale: GaugeScale,
    /// True if there is an offset column.
    pub offset: bool,
    /// Minimum time between kept samples (s); see [`HISTORY_RATE`](crate::features::HISTORY_RATE).
    pub history_step_secs: f64,
}

impl Design {
    /// Returns the number of gauges.
    pub fn n_gauges(&self) -> usize {
        self.scale.shift.len()
    }

    /// Returns the number of columns.
    pub fn n_columns(&self) -> usize {
        self.features.n_columns(self.n_gauges()) + usize::from(self.offset)
    }

    fn n_histories_end(&self) -> usize {
        self.n_gauges() * (1 + self.features.n_histories())
    }

    /// Splits a row into present gauges, look-backs, and the rest.
    #[inline]
    fn split<'r>(&self, row: &'r mut [f64]) -> (&'r mut [f64], &'r mut [f64], &'r mut [f64]) {
        let (present, rest) = row.split_at_mut(self.n_gauges());
        let n_look_backs = self.features.look_backs.len();
        let (look_backs, rest) = rest.split_at_mut(n_look_backs * present.len());
        (present, look_backs, rest)
    }

    /// Returns all columns in order.
    pub fn columns(&self) -> Vec<Column> {
        self.features.columns(self.n_gauges(), self.offset)
    }

    /// Returns the columns of the conventional calibration: gauges and offset.
    pub fn present(&self) -> Vec<usize> {
        self.where_column(|column| matches!(column, Column::Gauge(_) | Column::Offset))
    }

    /// Returns the indices of the columns that satisfy a condition.
    pub fn where_column(&self, condition: impl Fn(Column) -> bool) -> Vec<usize> {
        let columns = self.columns().into_iter().enumerate();
        let meant = columns.filter(|(_, column)| condition(*column));
        meant.map(|(position, _)| position).collect()
    }

    /// Returns the columns of a block, one list for each value in the block's setting.
    pub fn sets_of(&self, block: &'static dyn Block) -> Vec<Vec<usize>> {
        let values = self.features.blocks.of(block).iter();
        let sets = values.map(|value| {
            let wanted = History::Block(block, *value);
            self.where_column(
                |column| matches!(column, Column::Past { history, .. } if history == wanted),
            )
        });
        sets.collect()
    }

    /// Returns the blocks in the settings. All look-backs count as one block.
    pub fn blocks(&self) -> Vec<OfBlock> {
        let only = |features: FeatureSettings| features.describe();
        let look_backs = FeatureSettings { blocks: Blocks::default(), ..self.features.clone() };
        let is_look_back = |column| {
            let is_past = |history| matches!(history, History::LookBack(_));
            matches!(column, Column::Past { history, .. } if is_past(history))
        };
        let mut blocks = vec![OfBlock {
            block: None,
            description: only(look_backs),
            columns: self.where_column(is_look_back),
        }];
        for (block, values) in self.features.blocks.used() {
            let own = FeatureSettings {
                look_backs: Vec::new(),
                blocks: Blocks::default().with(block, values),
                ..self.features.clone()
            };
            let columns = match block.appends() {
                Appends::Past(_) => self.sets_of(block).concat(),
                Appends::Monomials(_) => {
                    self.where_column(|column| matches!(column, Column::Monomial(_)))
                }
                Appends::Auxiliary => {
                    self.where_column(|column| matches!(column, Column::Auxiliary { .. }))
                }
            };
            blocks.push(OfBlock { block: Some(block), description: only(own), columns });
        }
        blocks.retain(|own| !own.columns.is_empty());
        blocks
    }

    /// Returns the groups of columns that share one automatic ridge: auxiliary channels, and all other appended columns.
    pub fn ridge_groups(&self) -> Vec<Vec<usize>> {
        let is_auxiliary = |column: Column| matches!(column, Column::Auxiliary { .. });
        let is_other =
            |column: Column| column.kind() == ColumnKind::Appended && !is_auxiliary(column);
        let mut groups = vec![self.where_column(is_other), self.where_column(is_auxiliary)];
        groups.retain(|columns| !columns.is_empty());
        groups
    }

    /// Returns the columns of all look-backs.
    pub fn look_backs(&self) -> Range<usize> {
        let g = self.n_gauges();
        g..g * (1 + self.features.look_backs.len())
    }

    /// Returns the design with default thresholds, to compare designs that differ only in thresholds.
    pub fn with_any_thresholds(&self) -> Self {
        let mut own = self.clone();
        own.features.look_backs.fill(Thresholds::default());
        own
    }

    /// Returns all column indices.
    pub fn all(&self) -> Vec<usize> {
        (0..self.n_columns()).collect()
    }

    /// Returns the role of each column in a fit.
    pub fn kinds(&self) -> Vec<ColumnKind> {
        let columns = self.columns().into_iter();
        columns.map(Column::kind).collect()
    }

    /// Standardises a raw row for the fit: histories relative to the present, every column scaled. Columns of a past that
    /// equals the present become zero, so that the result is the conventional calibration.
    #[inline]
    pub fn standardise(&self, row: &mut [f64]) {
        let g = self.n_gauges();
        let (gauges, rest) = row.split_at_mut(g);
        for history in rest[..self.n_histories_end() - g].chunks_exact_mut(g) {
            self.scale.make_relative(history, gauges);
        }
        self.scale.make_relative(gauges, &self.scale.shift);
    }

    /// Converts coefficients of the conventional calibration to standardised columns; columns of blocks get zero. This is the
    /// inverse of [`Self::raw_coefficients`].
    pub fn standardised_coefficients(&self, raw: &[f64]) -> Vec<f64> {
        let mut coefficients = vec![0.0; self.n_columns()];
        let scale = &self.scale;
        for (at, factor) in scale.inverse_scale.iter().enumerate() {
            if *factor > 0.0 {
                coefficients[at] = raw[at] / factor;
            }
        }
        if self.offset
            && let (Some(last), Some(offset)) = (coefficients.last_mut(), raw.last())
        {
            *last = offset + at_shift(raw, scale);
        }
        coefficients
    }

    /// Converts one row of coefficients from standardised to raw columns. Those of monomials do not change, because monomials
    /// are always products of standardised gauges.
    pub fn raw_coefficients(&self, coefficients: &[f64]) -> Vec<f64> {
        let g = self.n_gauges();
        let mut raw = coefficients.to_vec();
        let (gauges, rest) = raw.split_at_mut(g);
        for (gauge, factor) in gauges.iter_mut().zip(&self.scale.inverse_scale) {
            *gauge *= factor;
        }
        if self.offset {
            let moved = at_shift(gauges, &self.scale);
            *rest.last_mut().expect("the design has an offset column") -= moved;
        }
        for history in rest[..self.n_histories_end() - g].chunks_exact_mut(g) {
            for ((value, gauge), factor) in
                history.iter_mut().zip(&mut *gauges).zip(&self.scale.inverse_scale)
            {
                *value *= factor;
                *gauge -= *value;
            }
        }
        raw
    }
}

/// Returns the contribution of these gauge coefficients at the shift of the gauges.
fn at_shift(coefficients: &[f64], scale: &GaugeScale) -> f64 {
    dot(coefficients, &scale.shift)
}

/// State of all blocks in one recording.
#[derive(Debug)]
pub struct FeatureStream<'a> {
    design: &'a Design,
    /// State of each block in use, with its number of columns.
    blocks: Vec<(usize, Box<dyn Stream>)>,
}

impl<'a> FeatureStream<'a> {
    /// Creates the state before the first sample.
    pub fn new(design: &'a Design) -> Self {
        let (features, scale) = (&design.features, &design.scale);
        let blocks = features.blocks.used().filter_map(|(block, values)| {
            let n_columns = features.n_columns_of(block, values, design.n_gauges());
            let step_secs = design.history_step_secs;
            let stream = || block.stream(values, scale, &features.auxiliary, step_secs);
            (n_columns > 0).then(|| (n_columns, stream()))
        });
        Self { design, blocks: blocks.collect() }
    }

    pub fn design(&self) -> &'a Design {
        self.design
    }

    /// Returns true if the samples so far determine the state of every block.
    pub fn is_determined(&self) -> bool {
        self.blocks.iter().all(|(_, stream)| stream.is_determined())
    }

    fn blocks_row(&mut self, time: f64, gauges: &[f64], auxiliary: &[f64], mut row: &mut [f64]) {
        for (n_columns, stream) in &mut self.blocks {
            let (own, others) = std::mem::take(&mut row).split_at_mut(*n_columns);
            stream.step(time, gauges, auxiliary, own);
            row = others;
        }
    }

    /// Processes the next sample and writes its raw row, one entry per column. `auxiliary` has the channels of the settings,
    /// `past(i)` the past gauges of look-back i.
    #[inline]
    pub fn raw_row<'g>(
        &mut self,
        time: f64,
        gauges: &[f64],
        auxiliary: &[f64],
        past: impl Fn(usize) -> &'g [f64],
        row: &mut [f64],
    ) {
        let (present, mut look_backs, rest) = self.design.split(row);
        present.copy_from_slice(gauges);
        for at in 0..self.design.features.look_backs.len() {
            next(&mut look_backs, gauges.len()).copy_from_slice(past(at));
        }
        self.rest_of_row(time, gauges, auxiliary, rest);
    }

    /// Processes the next samples and writes their [standardised](Design::standardise) rows, `stride` numbers each. Sample k
    /// has the time `times[k]`, the gauges `gauges(k)`, the auxiliary channels `auxiliary(k)`, and the past gauges `past(i, k)`
    /// of look-back i.
    #[inline(always)]
    pub fn standardised_rows<'g>(
        &mut self,
        samples: &[usize],
        times: &[f64],
        gauges: impl Fn(usize) -> &'g [f64] + Copy,
        auxiliary: impl Fn(usize) -> &'g [f64],
        past: impl Fn(usize, usize) -> &'g [f64],
        (rows, stride): (&mut [f64], usize),
    ) {
        let design = self.design;
        let (scale, g) = (&design.scale, design.n_gauges());
        let n_look_backs = design.features.look_backs.len();
        for (row, k) in rows.chunks_exact_mut(stride).zip(samples) {
            let (now, (present, mut look_backs)) = (gauges(*k), row.split_at_mut(g));
            scale.apply(now, present);
            for at in 0..n_look_backs {
                scale.relative(past(at, *k), now, next(&mut look_backs, g));
            }
        }
        let rest = design.look_backs().end..design.n_columns();
        if self.blocks.is_empty() {
            let offsets = rows.iter_mut().skip(rest.start).step_by(stride);
            offsets.take(samples.len() * rest.len()).for_each(|one| *one = 1.0);
            return;
        }
        let n_lags = design.features.n_histories() - n_look_backs;
        for (row, k) in rows.chunks_exact_mut(stride).zip(samples) {
            let rest = &mut row[rest.clone()];
            self.rest_of_row(times[*k], gauges(*k), auxiliary(*k), rest);
            let mut lags = rest;
            for _ in 0..n_lags {
                scale.make_relative(next(&mut lags, g), gauges(*k));
            }
        }
    }

    #[inline]
    fn rest_of_row(&mut self, time: f64, gauges: &[f64], auxiliary: &[f64], rest: &mut [f64]) {
        self.blocks_row(time, gauges, auxiliary, rest);
        if self.design.offset {
            *rest.last_mut().expect("the design has an offset column") = 1.0;
        }
    }
}

/// Returns the next `n` numbers of `row`. Iterating over chunks would need a division per sample.
#[inline]
fn next<'r>(row: &mut &'r mut [f64], n: usize) -> &'r mut [f64] {
    let (next, rest) = std::mem::take(row).split_at_mut(n);
    *row = rest;
    next
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::blocks::{Creep, FixedLag, Play, Polynomial};
    use crate::features::settings::Blocks;

    fn every_block() -> Design {
        Design {
            features: FeatureSettings {
                look_backs: vec![Thresholds::default(); 2],
                blocks: Blocks::default()
                    .with(&FixedLag, &[0.5])
                    .with(&Creep, &[1.0, 6.0])
                    .with(&Play, &[0.2])
                    .with(&Polynomial, &[3.0]),
                ..FeatureSettings::present()
            },
            scale: GaugeScale {
                shift: vec![10.0, -1.0],
                inverse_scale: vec![0.5, 4.0],
                deviation: vec![2.0, 0.25],
            },
            offset: true,
            history_step_secs: 0.0,
        }
    }

    fn row(design: &Design, samples: &[(f64, [f64; 2])]) -> Vec<f64> {
        let mut stream = FeatureStream::new(design);
        let mut row = vec![0.0; design.n_columns()];
        let first = samples[0].1;
        for (time, gauges) in samples {
            stream.raw_row(*time, gauges, &[], |_| &first, &mut row);
        }
        row
    }

    #[test]
    fn columns_are_named_one_by_one() {
        let design = every_block();
        let names = Column::names(&design.columns(), &["a".into(), "b".into()]);
        assert_eq!(names.len(), design.n_columns());
        assert_eq!(
            names.join(" "),
            "a b a_past b_past a_past2 b_past2 a_lag_0.5s b_lag_0.5s a_creep_1s b_creep_1s a_creep_6s b_creep_6s \
             a_play_0.2 b_play_0.2 a^2 a*b b^2 a^3 b^3 offset"
        );
        assert_eq!(design.present(), [0, 1, 19]);
        let kinds = design.kinds();
        let appended = kinds.iter().filter(|kind| **kind == ColumnKind::Appended);
        assert_eq!(appended.count(), 17);
        assert_eq!(kinds[1..3], [ColumnKind::Gauge, ColumnKind::Appended]);
        assert_eq!(kinds[18..], [ColumnKind::Appended, ColumnKind::Offset]);
        assert_eq!(design.sets_of(&Creep), [[8, 9], [10, 11]]);
    }

    /// Before the first sample the sensor counts as relaxed, so every history is zero.
    #[test]
    fn the_first_sample_has_no_history() {
        let design = every_block();
        let mut row = row(&design, &[(3.0, [12.0, 0.0])]);
        design.standardise(&mut row);
        assert_eq!(row[..2], [1.0, 4.0]);
        assert!(row[2..14].iter().all(|value| *value == 0.0));
        assert_eq!(row[14..], [1.0, 4.0, 16.0, 1.0, 64.0, 1.0]);
    }

    #[test]
    fn raw_and_standardised_coefficients_give_the_same_load() {
        let design = every_block();
        let raw = row(&design, &[(0.0, [9.0, 1.0]), (0.4, [12.0, 0.0]), (0.8, [11.0, -2.0])]);
        let mut standardised = raw.clone();
        design.standardise(&mut standardised);
        let coefficients: Vec<f64> = (0..raw.len()).map(|at| 1.0 - 0.3 * at as f64).collect();
        let expected = dot(&coefficients, &standardised);
        let actual = dot(&design.raw_coefficients(&coefficients), &raw);
        assert!((actual - expected).abs() < 1e-10 * expected.abs());
    }

    #[test]
    fn standardised_coefficients_undo_raw_ones() {
        let design = Design { features: FeatureSettings::present(), ..every_block() };
        let coefficients = [0.7, -1.3, 2.0];
        let back = design.standardised_coefficients(&design.raw_coefficients(&coefficients));
        for (back, coefficient) in back.iter().zip(coefficients) {
            assert!((back - coefficient).abs() < 1e-12);
        }
    }
}
