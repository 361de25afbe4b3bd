//! A calibration with something on top of its output: another offset, or a matrix over the axes, folded into its maps.

use crate::calibration::{Calibration, LinearMap, Quality};
use crate::features::Column;

/// `load' = matrix · load + offset`.
///
/// **Shapes** `n_axes × n_axes`, and one number per axis.
///
/// **Units** those of the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputChange {
    /// One row per axis.
    pub matrix: Vec<Vec<f64>>,
    /// What is added.
    pub offset: Vec<f64>,
}

/// Why a change has no place in a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CannotFold {
    /// A network or a kernel makes the load alone.
    #[error(
        "a network or kernel makes the load alone, so there is no linear part to fold the change into; refit all of it"
    )]
    Alone,
    /// A network or a kernel makes a part of the load.
    #[error(
        "a part of the load comes from a network or kernel, into which a matrix over the axes cannot be folded; refit the offset, \
         or all of it"
    )]
    Hybrid,
}

impl OutputChange {
    /// Another offset alone.
    pub fn of_offset(offset: Vec<f64>) -> Self {
        let row = |axis: usize| {
            (0..offset.len())
                .map(|at| f64::from(u8::from(at == axis)))
                .collect()
        };
        Self {
            matrix: (0..offset.len()).map(row).collect(),
            offset,
        }
    }

    /// Whether axes are mixed or scaled.
    fn mixes(&self) -> bool {
        *self != Self::of_offset(self.offset.clone())
    }

    fn of(&self, map: &LinearMap) -> LinearMap {
        let mut columns = map.columns.clone();
        let combined = |row: &Vec<f64>, column: usize| {
            let parts = row.iter().zip(&map.matrix);
            parts.map(|(factor, own)| factor * own[column]).sum::<f64>()
        };
        let rows = self.matrix.iter();
        let rows = rows.map(|row| {
            (0..columns.len())
                .map(|column| combined(row, column))
                .collect()
        });
        let mut matrix: Vec<Vec<f64>> = rows.collect();
        if columns.last() != Some(&Column::Offset) {
            columns.push(Column::Offset);
            matrix.iter_mut().for_each(|row| row.push(0.0));
        }
        for (row, offset) in matrix.iter_mut().zip(&self.offset) {
            if let Some(last) = row.last_mut() {
                *last += offset;
            }
        }
        LinearMap { columns, matrix }
    }
}

impl Calibration {
    /// This calibration with these changes of its conventional and of its compensated load. A look-back goes on finding its past
    /// sample by the conventional load, so where there is one a matrix changes the compensated load alone.
    ///
    /// # Errors
    /// [`CannotFold`] where the change is no part of a linear map.
    pub(crate) fn with_output(
        &self,
        conventional: &OutputChange,
        compensated: &OutputChange,
    ) -> Result<Self, CannotFold> {
        let linear = self.compensated.as_ref().ok_or(CannotFold::Alone)?;
        if self.learned.is_some() && compensated.mixes() {
            return Err(CannotFold::Hybrid);
        }
        let keeps = !self.features.look_backs.is_empty() && conventional.mixes();
        let none = OutputChange::of_offset(vec![0.0; self.axes.len()]);
        let quality = Quality {
            // They were those of the matrix as it was.
            coefficients: None,
            ..self.quality.clone()
        };
        Ok(Self {
            quality,
            conventional: if keeps { &none } else { conventional }.of(&self.conventional),
            compensated: Some(compensated.of(linear)),
            offset: true,
            ..self.clone()
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::analysis::{Request, analyse};
    use crate::calibration::{FitSettings, Learned, Network, Regressor};
    use crate::features::{Blocks, FeatureSettings, Play, Polynomial};
    use crate::progress::Progress;
    use crate::recording::simulated;

    fn calibration(features: FeatureSettings, offset: bool) -> Calibration {
        let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
        let settings = FitSettings {
            features,
            offset,
            decimation: 50,
            ..FitSettings::default()
        };
        let request = Request::fit(recordings, settings);
        Calibration::clone(&analyse(&request, &Progress::default()).unwrap().calibration)
    }

    fn change() -> OutputChange {
        let row = |i: usize| {
            (0..6)
                .map(|j| {
                    if i == j {
                        1.1
                    } else {
                        0.02 * (i as f64 - j as f64)
                    }
                })
                .collect()
        };
        OutputChange {
            matrix: (0..6).map(row).collect(),
            offset: vec![1.0, -2.0, 0.5, 0.1, -0.1, 0.3],
        }
    }

    #[test]
    fn a_folded_change_is_the_change_of_every_load() {
        let recordings = simulated::recordings(simulated::DEFAULT_SEED);
        let recording = &recordings.entries()[0].recording;
        let blocks = Blocks::default()
            .with(&Polynomial, &[2.0])
            .with(&Play, &[0.5]);
        let memory = FeatureSettings {
            blocks,
            ..FeatureSettings::present()
        };
        for (features, offset) in [
            (FeatureSettings::default(), true),
            (memory.clone(), true),
            (memory, false),
        ] {
            let old = calibration(features, offset);
            for change in [change(), OutputChange::of_offset(change().offset)] {
                let new = old.with_output(&change, &change).unwrap();
                assert!(new.offset && new.columns() == new.compensated.as_ref().unwrap().columns);
                let [before, after] = [&old, &new].map(|own| own.apply(recording).unwrap());
                let keeps = !old.features.look_backs.is_empty() && change.mixes();
                for (k, (load, changed)) in (before
                    .compensated
                    .chunks(6)
                    .zip(after.compensated.chunks(6)))
                .enumerate()
                {
                    for axis in 0..6 {
                        let mixed = |load: &[f64]| -> f64 {
                            change.offset[axis]
                                + change.matrix[axis]
                                    .iter()
                                    .zip(load)
                                    .map(|(a, b)| a * b)
                                    .sum::<f64>()
                        };
                        assert!((changed[axis] - mixed(load)).abs() < 1e-9);
                        let conventional = &before.conventional[6 * k..6 * k + 6];
                        let expected = if keeps {
                            conventional[axis]
                        } else {
                            mixed(conventional)
                        };
                        assert!((after.conventional[6 * k + axis] - expected).abs() < 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn what_was_learned_takes_an_offset_beside_a_linear_part_and_no_matrix() {
        let mut own = calibration(FeatureSettings::present(), true);
        let network = Network {
            input_shift: Vec::new(),
            input_inverse_scale: Vec::new(),
            layers: Vec::new(),
            target_shift: Vec::new(),
            target_scale: Vec::new(),
        };
        let learned = Learned::Network(network);
        (own.learned, own.regressor) = (Some(learned), Regressor::HybridNetwork);
        assert_eq!(
            own.with_output(&change(), &change()),
            Err(CannotFold::Hybrid)
        );
        let offset = OutputChange::of_offset(vec![1.0; 6]);
        assert!(own.with_output(&offset, &offset).is_ok());
        own.compensated = None;
        assert_eq!(own.with_output(&offset, &offset), Err(CannotFold::Alone));
    }
}
