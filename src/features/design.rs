//! Rows of the design matrix: each sample has one row of gauges, columns of feature blocks, and the constant of the offset.
//!
//! Guarantees: the same code computes the rows for recordings and for a running sensor. Every feature block is causal (it
//! uses no later samples), and its memory is empty at the start of each [`FeatureStream`].

use std::ops::Range;

use crate::{
    dot::dot,
    features::{
        block::{Appends, Block, Inputs, MOST_RISE, Stream},
        column::{Column, ColumnKind, History},
        gauge_scale::GaugeScale,
        look_back::Thresholds,
        settings::{Blocks, FeatureSettings},
    },
};

/// Feature block in use, with the indices of the columns that it appends to the design matrix.
pub struct OfBlock {
    /// Feature block; `None` for all look-backs together.
    pub block: Option<&'static dyn Block>,
    /// Settings of the block in words, for reports.
    pub description: String,
    pub columns: Vec<usize>,
}

/// Description of the columns of a design matrix. Their order is: present gauges, past gauges of each look-back, past gauges
/// of other feature blocks, monomials (products of gauges), auxiliary channels, offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Features whose columns are appended to the gauges.
    pub features: FeatureSettings,
    /// Shift and scale of each gauge.
    pub scale: GaugeScale,
    /// True if the last column is a constant offset.
    pub offset: bool,
    /// Minimum time between samples that are kept for look-backs and lags (s); see
    /// [`HISTORY_RATE`](crate::features::HISTORY_RATE).
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

    /// Returns all columns in order.
    pub fn columns(&self) -> Vec<Column> {
        self.features.columns(self.n_gauges(), self.offset)
    }

    /// Returns the indices of the columns that a conventional calibration uses: present gauges and offset.
    pub fn present(&self) -> Vec<usize> {
        self.where_column(|column| matches!(column, Column::Gauge(_) | Column::Offset))
    }

    /// Returns the indices of the columns that satisfy a condition.
    pub fn where_column(&self, condition: impl Fn(Column) -> bool) -> Vec<usize> {
        let columns = self.columns().into_iter().enumerate();
        let meant = columns.filter(|(_, column)| condition(*column));
        meant.map(|(position, _)| position).collect()
    }

    /// Returns the column indices of a feature block of past gauges, such as creep: one list of indices for each value of the
    /// block's setting.
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

    /// Returns the feature blocks in use. All look-backs count as one block.
    pub fn blocks(&self) -> Vec<OfBlock> {
        let look_backs = FeatureSettings { blocks: Blocks::default(), ..self.features.clone() };
        let mut blocks = vec![OfBlock {
            block: None,
            description: look_backs.describe(),
            columns: self.look_backs().collect(),
        }];
        for (block, values) in self.features.blocks.used() {
            let of_block = FeatureSettings {
                look_backs: Vec::new(),
                blocks: Blocks::default().with(block, values),
                ..self.features.clone()
            };
            let columns = match block.appends() {
                Appends::Past(_) => self.sets_of(block).concat(),
                Appends::Monomials(_) => {
                    self.where_column(|column| matches!(column, Column::Monomial(_)))
                }
                Appends::Auxiliary => self.where_column(is_auxiliary),
            };
            blocks.push(OfBlock { block: Some(block), description: of_block.describe(), columns });
        }
        blocks.retain(|block| !block.columns.is_empty());
        blocks
    }

    /// Returns the groups of columns for each of which cross-validation chooses one ridge: auxiliary channels, and all other
    /// appended columns.
    pub fn ridge_groups(&self) -> Vec<Vec<usize>> {
        let is_other =
            |column: Column| column.kind() == ColumnKind::Appended && !is_auxiliary(column);
        let mut groups = vec![self.where_column(is_other), self.where_column(is_auxiliary)];
        groups.retain(|columns| !columns.is_empty());
        groups
    }

    /// Returns the feature blocks with columns: each block with its values and its number of columns.
    fn blocks_with_columns(&self) -> impl Iterator<Item = (&'static dyn Block, &[f64], usize)> {
        let blocks = self.features.blocks.used().map(|(block, values)| {
            (block, values, self.features.n_columns_of(block, values, self.n_gauges()))
        });
        blocks.filter(|(.., n_columns)| *n_columns > 0)
    }

    /// Returns the setting's key of each feature block with columns.
    pub fn keys_with_columns(&self) -> Vec<&'static str> {
        self.blocks_with_columns().map(|(block, ..)| block.setting().key).collect()
    }

    fn inputs(&self) -> Inputs<'_> {
        let Self { features, scale, history_step_secs, .. } = self;
        Inputs { scale, channels: &features.auxiliary, history_step_secs: *history_step_secs }
    }

    /// Returns the indices of the columns that belong to look-backs.
    pub fn look_backs(&self) -> Range<usize> {
        let g = self.n_gauges();
        g..g * (1 + self.features.look_backs.len())
    }

    /// Returns this design with default thresholds in all look-backs. Two designs that differ only in thresholds give equal
    /// results.
    pub fn with_any_thresholds(&self) -> Self {
        let mut design = self.clone();
        design.features.look_backs.fill(Thresholds::default());
        design
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

    /// Standardises a row of the design matrix for the fit: gauges are shifted and scaled, and past gauges become differences
    /// from the present ones. If past and present gauges are equal, the differences are zero, and the row is that of the
    /// conventional calibration.
    #[inline]
    pub fn standardise(&self, row: &mut [f64]) {
        let g = self.n_gauges();
        let (gauges, rest) = row.split_at_mut(g);
        for history in rest[..self.n_histories_end() - g].chunks_exact_mut(g) {
            self.scale.make_relative(history, gauges);
        }
        self.scale.make_relative(gauges, &self.scale.shift);
    }

    /// Converts the coefficients of one load axis of a conventional calibration from raw to standardised columns. Columns of
    /// feature blocks get the coefficient zero. This is the inverse of [`Self::raw_coefficients`].
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
            *last = offset + dot(raw, &scale.shift);
        }
        coefficients
    }

    /// Converts the coefficients of one load axis from standardised to raw columns. Coefficients of monomials do not change,
    /// because monomials are always products of standardised gauges.
    pub fn raw_coefficients(&self, coefficients: &[f64]) -> Vec<f64> {
        let g = self.n_gauges();
        let mut raw = coefficients.to_vec();
        let (gauges, rest) = raw.split_at_mut(g);
        for (gauge, factor) in gauges.iter_mut().zip(&self.scale.inverse_scale) {
            *gauge *= factor;
        }
        if self.offset {
            let offset = rest.last_mut().expect("the design has an offset column");
            *offset -= dot(gauges, &self.scale.shift);
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

fn is_auxiliary(column: Column) -> bool {
    matches!(column, Column::Auxiliary { .. })
}

/// Memory of all feature blocks while they process the samples of one recording.
#[derive(Debug)]
pub struct FeatureStream<'a> {
    design: &'a Design,
    /// Number of columns and state of each feature block in use.
    blocks: Vec<(usize, Box<dyn Stream>)>,
    /// Factors of the unknown states with which standardised rows fade in; empty without a fade. See [`Self::share`].
    fade: &'a [Vec<f64>],
    /// Share of the newest sample in the fade.
    share: f64,
}

impl<'a> FeatureStream<'a> {
    /// Creates the memory of all feature blocks as it is before the first sample.
    pub fn new(design: &'a Design) -> Self {
        let blocks = design.blocks_with_columns();
        let blocks = blocks
            .map(|(block, values, n_columns)| (n_columns, block.stream(values, &design.inputs())));
        Self { design, blocks: blocks.collect(), fade: &[], share: 1.0 }
    }

    /// Lets standardised rows fade in with these factors, see [`Self::share`].
    pub fn fading(self, fade: &'a [Vec<f64>]) -> Self {
        Self { fade, ..self }
    }

    /// Ends a pause with the next sample, at this time (s). Feature blocks whose memory is not kept start anew.
    pub fn resume(&mut self, time: f64, is_kept: impl Fn(&dyn Block) -> bool) {
        let blocks = self.design.blocks_with_columns();
        for ((_, stream), (block, values, _)) in self.blocks.iter_mut().zip(blocks) {
            if is_kept(block) {
                stream.resume(time);
            } else {
                *stream = block.stream(values, &self.design.inputs());
            }
        }
    }

    /// Returns the squared error of the load by what the samples so far do not tell of the blocks' states. `effects` has one
    /// entry for each block with columns, see [`Block::effects`](crate::features::Block::effects).
    pub fn missing(&self, effects: &[Vec<f64>]) -> f64 {
        self.blocks.iter().zip(effects).map(|((_, stream), effects)| stream.missing(effects)).sum()
    }

    /// Returns the share of the difference between compensated and conventional load that counts at the newest sample: small
    /// while the states are unknown, then 1. Must be called once for each sample. `fade` has one entry for each block with
    /// columns, see [`Calibration::fade`](crate::calibration::Calibration::fade).
    pub fn share(&mut self, fade: &[Vec<f64>]) -> f64 {
        self.share = next_share(self.share, self.missing(fade));
        self.share
    }

    /// Processes the next sample and writes its raw (not standardised) row of the design matrix, one entry per column.
    /// `auxiliary` holds the auxiliary channels in the order of the settings, and `past(i)` returns the past gauges of
    /// look-back i.
    #[inline]
    pub fn raw_row<'g>(
        &mut self,
        time: f64,
        gauges: &[f64],
        auxiliary: &[f64],
        past: impl Fn(usize) -> &'g [f64],
        row: &mut [f64],
    ) {
        let mut rest = row;
        next(&mut rest, gauges.len()).copy_from_slice(gauges);
        for at in 0..self.design.features.look_backs.len() {
            next(&mut rest, gauges.len()).copy_from_slice(past(at));
        }
        self.rest_of_row(time, gauges, auxiliary, rest);
    }

    /// Processes the next samples and writes their [standardised](Design::standardise) rows of the design matrix, each
    /// `stride` numbers after the previous one. With [`Self::fading`], each row is multiplied by its share. Sample k has
    /// the time `times[k]`, the gauges `gauges(k)`, the auxiliary channels `auxiliary(k)`, and the past gauges `past(i, k)`
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
            let mut lags = &mut row[rest.clone()];
            self.rest_of_row(times[*k], gauges(*k), auxiliary(*k), lags);
            for _ in 0..n_lags {
                scale.make_relative(next(&mut lags, g), gauges(*k));
            }
            if !self.fade.is_empty() {
                let share = self.share(self.fade);
                row[..rest.end].iter_mut().for_each(|entry| *entry *= share);
            }
        }
    }

    #[inline]
    fn rest_of_row(&mut self, time: f64, gauges: &[f64], auxiliary: &[f64], mut rest: &mut [f64]) {
        for (n_columns, stream) in &mut self.blocks {
            stream.step(time, gauges, auxiliary, next(&mut rest, *n_columns));
        }
        rest.fill(1.0); // the offset, if there is one
    }
}

/// Splits the first `n` numbers off `row` and returns them. This is faster than an iterator over chunks, which needs a
/// division for each sample.
#[inline]
fn next<'r>(row: &mut &'r mut [f64], n: usize) -> &'r mut [f64] {
    let (next, rest) = std::mem::take(row).split_at_mut(n);
    *row = rest;
    next
}

/// Returns the share of the difference between compensated and conventional load that counts if this much of the states is
/// unknown, in units of the fade. `before` is the share of the sample before; 1 at the first sample.
pub(crate) fn next_share(before: f64, unknown: f64) -> f64 {
    (1.0 / (1.0 + unknown * unknown)).min(before + MOST_RISE)
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
                ..GaugeScale::default()
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

    /// At the first sample, the past gauges equal the present ones, so their columns are zero.
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
