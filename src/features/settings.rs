//! Which blocks describe a sample, and with which thresholds, lags, time constants and radii.

use serde::{Deserialize, Serialize};

use crate::features::polynomial::monomial_columns;
use crate::features::{Column, Distance, History, Thresholds};

/// A design with more columns than this is refused: its sums alone would fill the memory.
pub const MOST_COLUMNS: usize = 640;

/// The blocks that are appended to the present gauges.
///
/// | field | default | range | what it stands for |
/// |---|---|---|---|
/// | `look_backs` | one: 3 N, 15 s | ≥ 0 | the gauges when the load last differed by F_th (Eq. 9-12); one set per entry |
/// | `distance` | force | force, full scale | what F_th is measured in |
/// | `fixed_lags_secs` | none | > 0 | the gauges so many seconds ago |
/// | `creep_secs` | none | > 0 | first-order low-passes of the gauges with these time constants |
/// | `play_radii` | none | > 0 | play operators, radii in standard deviations of the gauge |
/// | `polynomial` | 1 | 1, 2, 3 | 2: squares and products of the gauges; 3: also their cubes. No past in it |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FeatureSettings {
    /// Thresholds of each look-back.
    pub look_backs: Vec<Thresholds>,
    /// What F_th is measured in, for all look-backs.
    pub distance: Distance,
    /// Lags (s).
    pub fixed_lags_secs: Vec<f64>,
    /// Time constants (s).
    pub creep_secs: Vec<f64>,
    /// Radii (standard deviations of the gauge).
    pub play_radii: Vec<f64>,
    /// Degree of the polynomial.
    pub polynomial: u8,
}

impl Default for FeatureSettings {
    fn default() -> Self {
        Self {
            look_backs: vec![Thresholds::default()],
            ..Self::present()
        }
    }
}

/// A choice of blocks that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum FeatureError {
    #[error("{what} is {value}; it must be a number from zero up")]
    Threshold { what: &'static str, value: f64 },
    #[error("a {what} is {value}; it must be a number above zero")]
    NotPositive { what: &'static str, value: f64 },
    #[error("the degree of the polynomial is {0}; it must be 1 (none), 2 or 3")]
    Degree(u8),
    #[error(
        "these blocks make {columns} columns of {gauges} gauges, which is more than {MOST_COLUMNS}; take fewer blocks, \
         thresholds or radii"
    )]
    Columns { columns: usize, gauges: usize },
}

impl FeatureSettings {
    /// Time constants for a sensor of which nothing is known (s).
    pub const DEFAULT_CREEP_SECS: [f64; 3] = [1.0, 6.0, 40.0];
    /// Radii for a sensor of which nothing is known (standard deviations).
    pub const DEFAULT_PLAY_RADII: [f64; 6] = [0.1, 0.2, 0.4, 0.7, 1.1, 1.6];
    /// Lag for a sensor of which nothing is known (s).
    pub const DEFAULT_LAG_SECS: f64 = 0.5;

    /// No block: the present gauges alone.
    #[must_use]
    pub fn present() -> Self {
        Self {
            look_backs: Vec::new(),
            distance: Distance::Force,
            fixed_lags_secs: Vec::new(),
            creep_secs: Vec::new(),
            play_radii: Vec::new(),
            polynomial: 1,
        }
    }

    /// These settings without what needs the past.
    #[must_use]
    pub fn without_history(&self) -> Self {
        Self {
            polynomial: self.polynomial,
            distance: self.distance,
            ..Self::present()
        }
    }

    /// Whether any block needs the past.
    #[must_use]
    pub fn has_history(&self) -> bool {
        self.n_histories() > 0
    }

    /// How many sets of gauges the history blocks append.
    #[must_use]
    pub fn n_histories(&self) -> usize {
        self.look_backs.len()
            + self.fixed_lags_secs.len()
            + self.creep_secs.len()
            + self.play_radii.len()
    }

    /// The histories in the order of their columns.
    pub fn histories(&self) -> impl Iterator<Item = History> + '_ {
        let look_backs = (0..self.look_backs.len()).map(History::LookBack);
        let lags = self.fixed_lags_secs.iter().copied().map(History::FixedLag);
        let creep = self.creep_secs.iter().copied().map(History::Creep);
        let play = self.play_radii.iter().copied().map(History::Play);
        look_backs.chain(lags).chain(creep).chain(play)
    }

    /// The columns of so many gauges with these blocks: gauges, one set of them for each history, monomials, offset.
    #[must_use]
    pub fn columns(&self, n_gauges: usize, offset: bool) -> Vec<Column> {
        let histories = self
            .histories()
            .flat_map(|history| (0..n_gauges).map(move |gauge| Column::Past { history, gauge }));
        (0..n_gauges)
            .map(Column::Gauge)
            .chain(histories)
            .chain(monomial_columns(n_gauges, self.polynomial))
            .chain(offset.then_some(Column::Offset))
            .collect()
    }

    /// How long a sample may be looked back at (s); zero where no block keeps samples.
    #[must_use]
    pub fn window_secs(&self) -> f64 {
        let t_th_secs = self.look_backs.iter().map(|look_back| &look_back.t_th_secs);
        t_th_secs
            .chain(&self.fixed_lags_secs)
            .fold(0.0, |a, b| a.max(*b))
    }

    /// Checks every range of the table above.
    ///
    /// # Errors
    /// [`FeatureError`] with the first choice that is out of range.
    pub fn validate(&self) -> Result<(), FeatureError> {
        for Thresholds { f_th, t_th_secs } in &self.look_backs {
            for (what, value) in [("F_th", *f_th), ("t_th", *t_th_secs)] {
                if !(value >= 0.0 && value.is_finite()) {
                    return Err(FeatureError::Threshold { what, value });
                }
            }
        }
        for (what, values) in [
            ("fixed lag", &self.fixed_lags_secs),
            ("creep time constant", &self.creep_secs),
            ("play radius", &self.play_radii),
        ] {
            if let Some(&value) = values.iter().find(|v| !(**v > 0.0 && v.is_finite())) {
                return Err(FeatureError::NotPositive { what, value });
            }
        }
        match self.polynomial {
            1..=3 => Ok(()),
            degree => Err(FeatureError::Degree(degree)),
        }
    }

    /// Checks that a sensor with so many gauges does not get too many columns.
    ///
    /// # Errors
    /// [`FeatureError::Columns`] if it does.
    pub fn check_columns(&self, n_gauges: usize) -> Result<(), FeatureError> {
        let columns = n_gauges * (1 + self.n_histories())
            + super::polynomial::n_monomials(n_gauges, self.polynomial);
        if columns > MOST_COLUMNS {
            return Err(FeatureError::Columns {
                columns,
                gauges: n_gauges,
            });
        }
        Ok(())
    }

    /// The blocks in words, as tables show them; empty without any.
    #[must_use]
    pub fn describe(&self) -> String {
        let list = |values: &[f64]| {
            let texts: Vec<String> = values.iter().map(f64::to_string).collect();
            texts.join(", ")
        };
        let mut parts = Vec::new();
        for (at, Thresholds { f_th, t_th_secs }) in self.look_backs.iter().enumerate() {
            let repeated = at > 0 && self.look_backs[0].t_th_secs == *t_th_secs;
            let t_th = match repeated {
                true => String::new(),
                false => format!(", t_th {t_th_secs} s"),
            };
            parts.push(match self.distance {
                Distance::Force => format!("F_th {f_th} N{t_th}"),
                Distance::FullScale => format!("F_th {} % of full scale{t_th}", 100.0 * f_th),
            });
        }
        for (name, values, unit) in [
            ("lag", &self.fixed_lags_secs, " s"),
            ("creep", &self.creep_secs, " s"),
            ("play", &self.play_radii, " SD"),
        ] {
            if !values.is_empty() {
                parts.push(format!("{name} {}{unit}", list(values)));
            }
        }
        match self.polynomial {
            2 => parts.push("squares and products".to_owned()),
            3 => parts.push("squares, products and cubes".to_owned()),
            _ => {}
        }
        parts.join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_out_of_range_are_named() {
        let refused = |change: fn(&mut FeatureSettings)| {
            let mut settings = FeatureSettings::default();
            change(&mut settings);
            settings.validate().unwrap_err().to_string()
        };
        assert_eq!(FeatureSettings::default().validate(), Ok(()));
        assert!(refused(|s| s.look_backs[0].f_th = -1.0).contains("F_th is -1"));
        assert!(refused(|s| s.look_backs[0].t_th_secs = f64::INFINITY).contains("t_th"));
        assert!(refused(|s| s.play_radii = vec![0.1, 0.0]).contains("play radius is 0"));
        assert!(refused(|s| s.creep_secs = vec![f64::NAN]).contains("NaN"));
        assert!(refused(|s| s.fixed_lags_secs = vec![-2.0]).contains("fixed lag"));
        assert!(refused(|s| s.polynomial = 4).contains("polynomial is 4"));
    }

    #[test]
    fn too_many_columns_are_refused_before_they_are_made() {
        let squares = FeatureSettings {
            polynomial: 2,
            ..FeatureSettings::present()
        };
        assert_eq!(squares.check_columns(6), Ok(()));
        assert!(squares.check_columns(64).is_err());
    }

    #[test]
    fn blocks_are_described_in_words() {
        let settings = FeatureSettings {
            look_backs: [3.0, 8.0]
                .map(|f_th| Thresholds {
                    f_th,
                    t_th_secs: 15.0,
                })
                .to_vec(),
            play_radii: vec![0.1, 0.2],
            polynomial: 2,
            ..FeatureSettings::present()
        };
        assert_eq!(
            settings.describe(),
            "F_th 3 N, t_th 15 s; F_th 8 N; play 0.1, 0.2 SD; squares and products"
        );
        assert_eq!(FeatureSettings::present().describe(), "");
    }
}
