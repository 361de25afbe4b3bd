//! Sums of a look-back's columns for the normal equations, separated by the age of the earlier sample that the look-back
//! finds. One pass over a recording gives the sums for every time threshold t_th.
//!
//! For one force threshold F_th, the search with the longest t_th also finds the earlier samples for every shorter t_th. If
//! an earlier sample is older than the shorter t_th, the columns of the look-back are zero. So t_th only decides which
//! samples contribute to the products *of these columns*. The products are summed by class of age. Each class is added to
//! sums in which the look-back's columns are zero for its samples. This gives the sums for the next longer t_th.

use crate::{
    calibration::{
        linear_map::PresentLoads,
        normal_equations::{NormalEquations, TILE, add_tiles, tile_rows},
        sums::{Pass, Piece, TakesRows},
    },
    features::Design,
    progress::Progress,
    vectorised::vectorised,
};

/// Sums of the products of the look-back columns with all columns of the design, separated by the age of the earlier sample.
#[derive(Clone, Debug, PartialEq)]
pub struct AgedSums {
    first: usize,
    n_columns: usize,
    stride: usize,
    /// For each class of the earlier sample's age, one row-major `rows × stride` matrix of sums. Rows from `n_columns` on
    /// fill it up and are not valid.
    products: Vec<f64>,
}

impl AgedSums {
    /// Creates empty sums for the columns of the first `n_look_backs` look-backs of `design`. The age of a look-back's earlier
    /// sample belongs to one of `n_classes` classes.
    pub fn new(design: &Design, n_axes: usize, n_look_backs: usize, n_classes: usize) -> Self {
        let (first, n_columns) = (design.n_gauges(), design.n_gauges() * n_look_backs);
        let stride = NormalEquations::stride_of(design.n_columns() + n_axes);
        let rows = n_columns.next_multiple_of(TILE);
        Self { first, n_columns, stride, products: vec![0.0; n_classes * rows * stride] }
    }

    pub fn size_bytes(design: &Design, n_axes: usize, n_classes: usize) -> usize {
        let stride = NormalEquations::stride_of(design.n_columns() + n_axes);
        n_classes * design.n_gauges().next_multiple_of(TILE) * stride * size_of::<f64>()
    }

    fn class_len(&self) -> usize {
        self.n_columns.next_multiple_of(TILE) * self.stride
    }

    /// Adds the sums of one class of age to `sums`. In `sums`, the look-back columns of the samples of this class must still
    /// be zero. Panics if the class does not exist or the columns differ.
    pub fn add_class_to(&self, class: usize, sums: &mut NormalEquations) {
        assert_eq!(sums.stride(), self.stride, "both sums must have the same columns");
        let products = &self.products[class * self.class_len()..];
        sums.add_products(self.first, &products[..self.n_columns * self.stride]);
    }
}

impl TakesRows for AgedSums {
    /// Adds the products of feature rows to the sums of their classes of age. Consecutive rows of one class are multiplied
    /// together.
    fn add_rows(&mut self, rows: &[f64], classes: &[usize]) {
        let (class_len, stride) = (self.class_len(), self.stride);
        vectorised(
            #[inline(always)]
            move || {
                let mut rows = rows;
                for run in classes.chunk_by(|a, b| a == b) {
                    let (of_run, rest) = rows.split_at(run.len() * stride);
                    rows = rest;
                    let products = &mut self.products[run[0] * class_len..][..class_len];
                    for (row, products) in tile_rows(products, stride) {
                        add_tiles(products, of_run, self.first + row, 0..stride);
                    }
                }
            },
        );
    }

    fn add(&mut self, other: &Self) {
        for (sum, product) in self.products.iter_mut().zip(&other.products) {
            *sum += product;
        }
    }
}

/// Earlier samples that the look-backs find in one recording with one force threshold F_th, and the time thresholds t_th to
/// compare.
#[derive(Clone, Copy, Debug)]
pub struct ThresholdAges<'a> {
    /// For each sample, the index of the earlier sample that the first look-back finds with the longest t_th; its own index
    /// if none.
    pub past: &'a [u32],
    /// For each further look-back, whose thresholds do not change, the index of the earlier sample of each sample.
    pub further: &'a [Vec<u32>],
    /// Time thresholds t_th to compare, in rising order (s). Age class i has the ages above threshold i − 1 and up to
    /// threshold i.
    pub t_ths_secs: &'a [f64],
}

/// Returns the sums of each piece of the recording, separated by the age of the earlier sample. If `is_cold`, nothing before
/// a piece is remembered in it. Panics as [`recording_sums`](crate::calibration::recording_sums) does, or if the design has
/// no look-back.
pub fn aged_sums(
    design: &Design,
    conventional: PresentLoads<'_>,
    ages: ThresholdAges<'_>,
    pieces: &[Piece],
    is_cold: bool,
    progress: &Progress,
) -> Vec<AgedSums> {
    assert!(!design.features.look_backs.is_empty(), "a look-back");
    let recording = conventional.recording;
    let (times, n_axes) = (recording.times(), recording.axes().len());
    let further = ages.further.iter().map(Vec::as_slice);
    let past = std::iter::once(ages.past).chain(further).collect();
    let pass = Pass { design, conventional, past, is_cold, fade: &[], progress };
    let empty = || AgedSums::new(design, n_axes, 1, ages.t_ths_secs.len());
    pass.sums(pieces, empty, |k, past| {
        let nearest = past[0][k] as usize;
        let age = times[k] - times[nearest];
        (nearest != k).then(|| ages.t_ths_secs.partition_point(|t_th| *t_th < age))
    })
}

/// Returns, for each piece of the recording, the sums of the products that contain a look-back column. Added to the sums
/// without look-back, they give exactly the result of [`recording_sums`](crate::calibration::recording_sums). Panics as that
/// function does.
pub fn look_back_sums(
    design: &Design,
    conventional: PresentLoads<'_>,
    past: &[Vec<u32>],
    pieces: &[Piece],
    progress: &Progress,
) -> Vec<AgedSums> {
    let n_axes = conventional.recording.axes().len();
    let past = past.iter().map(Vec::as_slice).collect();
    let pass = Pass { design, conventional, past, is_cold: false, fade: &[], progress };
    let empty = || AgedSums::new(design, n_axes, design.features.look_backs.len(), 1);
    pass.sums(pieces, empty, |k, past| past.iter().any(|past| past[k] as usize != k).then_some(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::conventional::Conventional;
    use crate::calibration::linear_map::loads_from_gauges;
    use crate::calibration::sums::recording_sums;
    use crate::features::{Blocks, Creep, FeatureSettings, LoadPath, Thresholds};
    use crate::recording::simulated;

    /// Compares sums without look-back plus age classes with one pass for each t_th.
    #[test]
    fn classes_of_age_add_up_to_the_sums_of_each_t_th() {
        let set = simulated::recordings(3);
        let recording = set.entries()[1].recording.decimated(2);
        let conventional = Conventional::fit(&[&recording], true, &Progress::default());
        let loads = loads_from_gauges(&conventional.map, &recording);
        let conventional_loads = PresentLoads {
            map: &conventional.map.clone(),
            recording: &recording,
            kept: Some(&loads),
        };
        let path = LoadPath::new(&loads, &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let past =
            |f_th, t_th_secs| path.past_samples(recording.times(), Thresholds { f_th, t_th_secs });
        let further = vec![past(1.0, 4.0)];
        let design = Design {
            features: FeatureSettings {
                look_backs: vec![Thresholds::default(); 2],
                blocks: Blocks::default().with(&Creep, &[3.0]),
                ..FeatureSettings::present()
            },
            scale: conventional.scale,
            offset: true,
            history_step_secs: 0.0,
        };
        let n = recording.n_samples();
        let pieces = [(0..n / 3, 0), (n / 3..n, 1)].map(|(samples, fold)| Piece { samples, fold });
        let t_ths_secs = [0.5, 2.0, 2.5, 9.0];
        let ages =
            ThresholdAges { past: &past(2.0, 9.0), further: &further, t_ths_secs: &t_ths_secs };
        let aged =
            aged_sums(&design, conventional_loads, ages, &pieces, false, &Progress::default());
        let direct = |nearest: Vec<u32>| {
            let past = [nearest, further[0].clone()];
            recording_sums(
                &design,
                conventional_loads,
                &past,
                &pieces,
                false,
                &[],
                &Progress::default(),
            )
        };
        let mut running = direct((0..n as u32).collect());
        for (class, t_th_secs) in t_ths_secs.into_iter().enumerate() {
            let expected = direct(past(2.0, t_th_secs));
            for ((running, aged), expected) in running.iter_mut().zip(&aged).zip(&expected) {
                aged.add_class_to(class, running);
                let p = design.n_columns();
                for i in 0..p {
                    for j in 0..p {
                        let error = running.feature_product(i, j) - expected.feature_product(i, j);
                        assert!(error.abs() < 1e-8, "{t_th_secs} s, {i} {j}: {error}");
                    }
                    for target in 0..6 {
                        let error =
                            running.target_product(i, target) - expected.target_product(i, target);
                        assert!(error.abs() < 1e-8, "{t_th_secs} s, {i}, target {target}");
                    }
                }
            }
        }
    }
}
