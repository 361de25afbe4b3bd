//! How far a reading may be from the load that is really there: U, with what it is made of.
//!
//! **Source** JCGM 100 (GUM): standard uncertainties, added in squares, times a coverage factor. What a calibration leaves over of
//! recordings that its fit has not seen holds whatever differed between them: noise, repeatability, hysteresis, creep, what
//! the model cannot follow. That sum is known as a whole, so its parts, some of them worst cases, are told *within* it and never added
//! once more; only what no recording shows, such as the error of the reference itself, is added.
//!
//! Guarantees: what the recordings do not allow is a reason, not a number.

mod source;
mod steps;

use serde::{Serialize, Serializer};

pub use self::source::{Source, Texts};
pub use self::steps::{StepFigure, StepFigures, StepQuantity, step_figures};
use crate::recording::Axis;

/// What a standard uncertainty is multiplied with: 95.45 % of a normal distribution.
pub const COVERAGE_FACTOR: f64 = 2.0;
/// What it would be for so many degrees of freedom (Student's t for 95.45 %; GUM, table G.2).
const STUDENT: [(f64, f64); 15] = [
    (1.0, 13.968),
    (2.0, 4.527),
    (3.0, 3.307),
    (4.0, 2.869),
    (5.0, 2.649),
    (6.0, 2.517),
    (7.0, 2.429),
    (8.0, 2.366),
    (9.0, 2.320),
    (10.0, 2.284),
    (15.0, 2.181),
    (20.0, 2.133),
    (30.0, 2.087),
    (50.0, 2.051),
    (100.0, 2.025),
];
/// With fewer groups none can be judged by the others.
const FEWEST_GROUPS: usize = 3;

/// The coverage factor that a result of so many degrees of freedom would need for 95.45 %; between the rows of the table linear in
/// their reciprocal.
pub fn student(degrees: f64) -> f64 {
    let points = || {
        let infinite = std::iter::once((0.0, COVERAGE_FACTOR));
        infinite.chain(
            STUDENT
                .iter()
                .rev()
                .map(|(degrees, factor)| (1.0 / degrees, *factor)),
        )
    };
    let at = (1.0 / degrees.max(1.0)).clamp(0.0, 1.0);
    let pairs = points().zip(points().skip(1));
    let mut around = pairs.filter(|((low, _), (high, _))| (*low..=*high).contains(&at));
    around
        .next()
        .map_or(STUDENT[0].1, |((low, below), (high, above))| {
            below + (above - below) * (at - low) / (high - low)
        })
}

/// The errors of one group of recordings that a fit has not seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupErrors {
    /// What it is called.
    pub name: String,
    /// How many samples it has.
    pub n_samples: u64,
    /// The mean error of each axis.
    pub means: Vec<f64>,
    /// The mean square of the errors of each axis.
    pub squares: Vec<f64>,
    /// The sizes of evenly spread samples of the errors, by axis.
    pub sizes: Vec<Vec<f32>>,
}

impl GroupErrors {
    /// Of these errors, `n × n_axes` row-major; of more than `kept` samples every so many-th is kept.
    pub fn of(name: impl Into<String>, errors: &[f64], n_axes: usize, kept: usize) -> Self {
        let n = errors.len() / n_axes;
        let step = n.div_ceil(kept.max(1)).max(1);
        let axis = |axis: usize| errors.iter().skip(axis).step_by(n_axes);
        let mean = |of: fn(f64) -> f64| {
            let of_axis = |at| axis(at).map(|error| of(*error)).sum::<f64>() / n.max(1) as f64;
            (0..n_axes).map(of_axis).collect()
        };
        Self {
            name: name.into(),
            n_samples: n as u64,
            means: mean(|error| error),
            squares: mean(|error| error * error),
            sizes: (0..n_axes)
                .map(|at| {
                    axis(at)
                        .step_by(step)
                        .map(|error| error.abs() as f32)
                        .collect()
                })
                .collect(),
        }
    }

    /// Both as one.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        let n = self.n_samples + other.n_samples;
        for (own, others) in [
            (&mut self.means, &other.means),
            (&mut self.squares, &other.squares),
        ] {
            for (own, more) in own.iter_mut().zip(others) {
                *own = (*own * self.n_samples as f64 + more * other.n_samples as f64)
                    / n.max(1) as f64;
            }
        }
        for (own, more) in self.sizes.iter_mut().zip(other.sizes) {
            own.extend(more);
        }
        self.n_samples = n;
        self
    }

    /// The share of the errors of an axis within a size.
    fn within(&self, axis: usize, size: f64) -> f64 {
        let sizes = &self.sizes[axis];
        let inside = sizes.iter().filter(|own| f64::from(**own) <= size).count();
        inside as f64 / sizes.len().max(1) as f64
    }
}

/// What is known of one part of the uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contribution {
    /// Which part.
    #[serde(serialize_with = "id")]
    pub source: Source,
    /// Its standard uncertainty, in the unit of the axis, or why it is not known.
    #[serde(serialize_with = "number")]
    pub standard: Result<f64, String>,
    /// Whether it is added, or is a part of the errors that were left out and only told.
    pub added: bool,
}

fn id<S: Serializer>(source: &Source, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(source.texts().id)
}

/// The number, or the reason under `reason`.
fn number<S: Serializer>(number: &Result<f64, String>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Reason<'a> {
        reason: &'a str,
    }
    match number {
        Ok(number) => serializer.serialize_f64(*number),
        Err(reason) => Reason { reason }.serialize(serializer),
    }
}

/// How often errors stay within U.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// The share of all samples.
    pub share: f64,
    /// That of the group with the least.
    pub least: f64,
    /// Which that is.
    pub least_of: String,
}

/// How far readings of one axis may be off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisUncertainty {
    /// The axis.
    pub axis: Axis,
    /// Its unit.
    pub unit: &'static str,
    /// Its full scale, 0 where there is none.
    pub full_scale: f64,
    /// From which load to which its errors are known.
    pub range: (f64, f64),
    /// The combined standard uncertainty.
    pub standard: f64,
    /// U = k u, in the unit of the axis.
    pub expanded: f64,
    /// U in % of full scale.
    pub percent_fs: Option<f64>,
    /// The effective degrees of freedom (Welch-Satterthwaite); `None` where they have no end.
    pub degrees: Option<f64>,
    /// What k would be with so few of them.
    pub factor_by_degrees: f64,
    /// What it is made of.
    pub budget: Vec<Contribution>,
    /// On the groups that were left out, each judged by the U of the others.
    #[serde(serialize_with = "coverage")]
    pub coverage: Result<Coverage, String>,
    /// On the recordings in the test role, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test_coverage: Option<Coverage>,
}

fn coverage<S: Serializer>(
    own: &Result<Coverage, String>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Reason<'a> {
        reason: &'a str,
    }
    match own {
        Ok(coverage) => coverage.serialize(serializer),
        Err(reason) => Reason { reason }.serialize(serializer),
    }
}

/// How far readings of a calibration may be off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// What the errors are of, in words.
    pub of: String,
    /// What is left out in turn, or each of the recordings.
    pub n_groups: usize,
    /// Each axis of which something can be said.
    pub axes: Vec<AxisUncertainty>,
    /// Of the others why not.
    pub not_stated: Vec<(Axis, String)>,
    /// What its load steps show.
    pub steps: Vec<StepFigures>,
    /// What is to be known beside it.
    pub notes: Vec<String>,
}

impl Uncertainty {
    /// That of an axis, or why there is none.
    pub fn of_axis(&self, axis: Axis) -> Result<&AxisUncertainty, String> {
        let reason = || {
            let own = self.not_stated.iter().find(|(own, _)| *own == axis);
            own.map_or_else(|| "not known".to_owned(), |(_, reason)| reason.clone())
        };
        self.axes
            .iter()
            .find(|own| own.axis == axis)
            .ok_or_else(reason)
    }
}

/// A source with its standard uncertainty, or why that is not known.
pub type Part = (Source, Result<f64, String>);

/// What the uncertainty of one axis is made of.
#[derive(Clone, Debug)]
pub struct Evidence<'a> {
    /// Which axis, of those that the errors are of.
    pub at: usize,
    /// It.
    pub axis: Axis,
    /// Its full scale, 0 where there is none.
    pub full_scale: f64,
    /// From which load to which these errors are.
    pub range: (f64, f64),
    /// The errors of groups that a fit has not seen.
    pub groups: &'a [GroupErrors],
    /// Those of recordings in the test role.
    pub tests: &'a [GroupErrors],
    /// Standard uncertainties that no error shows.
    pub added: Vec<Part>,
    /// Those that the errors hold already.
    pub within: Vec<Part>,
}

impl Evidence<'_> {
    /// Adds it up; `None` without an error.
    pub fn combined(mut self) -> Option<AxisUncertainty> {
        let reproducibility = match self.groups.len() {
            0 | 1 => Err("there is one group only".to_owned()),
            n => Ok((self
                .groups
                .iter()
                .map(|own| own.means[self.at].powi(2))
                .sum::<f64>()
                / n as f64)
                .sqrt()),
        };
        self.within
            .push((Source::Reproducibility, reproducibility.clone()));
        let left_out = self.left_out(|_| true)?;
        let within = squares(&self.within);
        self.within
            .push((Source::Residual, Ok((left_out - within).max(0.0).sqrt())));
        let standard = self.standard(left_out);
        let expanded = COVERAGE_FACTOR * standard;
        // The scatter between groups is known by as many groups; that within them by many samples.
        let between = reproducibility.unwrap_or(0.0);
        let by_means =
            (between > 0.0).then(|| (self.groups.len() - 1) as f64 * (standard / between).powi(4));
        // Groups that differ in sensitivity have the same mean errors, and other mean squares: ν = 2 u⁴ / s²(u²) (GUM G.4.1).
        let n = self.groups.len() as f64;
        let own: Vec<f64> = self.groups.iter().map(|own| own.squares[self.at]).collect();
        let mean = own.iter().sum::<f64>() / n;
        let scatter = own.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
        let by_squares =
            (own.len() >= FEWEST_GROUPS && scatter > 0.0).then(|| 2.0 * standard.powi(4) / scatter);
        let degrees = by_means
            .into_iter()
            .chain(by_squares)
            .min_by(f64::total_cmp)
            .filter(|degrees| *degrees < 1000.0);
        let told = |(list, added): (&Vec<Part>, bool)| {
            let list = list.iter().cloned();
            let told = list.map(|(source, standard)| Contribution {
                source,
                standard,
                added,
            });
            told.collect::<Vec<_>>()
        };
        let mut budget: Vec<Contribution> = [(&self.added, true), (&self.within, false)]
            .into_iter()
            .flat_map(told)
            .collect();
        budget.sort_by_key(|own| own.source);
        Some(AxisUncertainty {
            axis: self.axis,
            unit: self.axis.unit(),
            full_scale: self.full_scale,
            range: self.range,
            standard,
            expanded,
            percent_fs: (self.full_scale > 0.0).then(|| 100.0 * expanded / self.full_scale),
            degrees,
            factor_by_degrees: degrees.map_or(COVERAGE_FACTOR, student),
            coverage: self.coverage(),
            test_coverage: covered(self.tests, |_, group| group.within(self.at, expanded)),
            budget,
        })
    }

    /// The mean square over the samples of those groups.
    fn left_out(&self, wanted: impl Fn(usize) -> bool) -> Option<f64> {
        let groups = self.groups.iter().enumerate().filter(|(at, _)| wanted(*at));
        let (sum, n) = groups.fold((0.0, 0), |(sum, n), (_, group)| {
            (
                sum + group.squares[self.at] * group.n_samples as f64,
                n + group.n_samples,
            )
        });
        (n > 0).then(|| sum / n as f64)
    }

    fn standard(&self, left_out: f64) -> f64 {
        (squares(&self.added) + left_out).sqrt()
    }

    fn coverage(&self) -> Result<Coverage, String> {
        if self.groups.len() < FEWEST_GROUPS {
            return Err(format!(
                "with fewer than {FEWEST_GROUPS} groups none can be judged by the others"
            ));
        }
        let share = |at: usize, group: &GroupErrors| {
            let others = self.left_out(|other| other != at).unwrap_or(0.0);
            group.within(self.at, COVERAGE_FACTOR * self.standard(others))
        };
        covered(self.groups, share).ok_or_else(|| "nothing was left out".to_owned())
    }
}

/// The sum of the squares of what is known.
fn squares(list: &[Part]) -> f64 {
    list.iter()
        .filter_map(|(_, own)| own.as_ref().ok())
        .map(|own| own * own)
        .sum()
}

fn covered(groups: &[GroupErrors], share: impl Fn(usize, &GroupErrors) -> f64) -> Option<Coverage> {
    let shares: Vec<(f64, &GroupErrors)> = groups
        .iter()
        .enumerate()
        .filter(|(_, own)| own.n_samples > 0)
        .map(|(at, own)| (share(at, own), own))
        .collect();
    let n: u64 = shares.iter().map(|(_, own)| own.n_samples).sum();
    let (least, of) = shares.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Coverage {
        share: shares
            .iter()
            .map(|(share, own)| share * own.n_samples as f64)
            .sum::<f64>()
            / n as f64,
        least: *least,
        least_of: of.name.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn groups(
        n_groups: usize,
        n: usize,
        error: impl Fn(usize, &mut Random) -> f64,
    ) -> Vec<GroupErrors> {
        let group = |at: usize| {
            let mut random = Random::new(3, &[at as u64]);
            let errors: Vec<f64> = (0..n).map(|_| error(at, &mut random)).collect();
            GroupErrors::of(format!("g{at}"), &errors, 1, 1000)
        };
        (0..n_groups).map(group).collect()
    }

    fn of(groups: &[GroupErrors], added: Vec<Part>) -> AxisUncertainty {
        let evidence = Evidence {
            at: 0,
            axis: Axis::Fz,
            full_scale: 100.0,
            range: (-1.0, 1.0),
            groups,
            tests: &[],
            added,
            within: vec![(Source::Creep, Err("no hold".to_owned()))],
        };
        evidence.combined().unwrap()
    }

    /// Four groups of two errors each, by hand: mean squares 1, 1, 4, 2, so u² = 2; group means 0, 1, 2, 0, so their mean square is 5/4.
    #[test]
    fn what_is_added_up_by_hand() {
        let errors: [[f64; 2]; 4] = [
            [1.0, -1.0],
            [1.0, 1.0],
            [2.0, 2.0],
            [2.0_f64.sqrt(), -(2.0_f64.sqrt())],
        ];
        let groups: Vec<GroupErrors> = errors
            .iter()
            .map(|own| GroupErrors::of("g", own, 1, 10))
            .collect();
        let found = of(&groups, vec![(Source::Reference, Ok(0.5))]);
        assert!((found.standard - 2.25_f64.sqrt()).abs() < 1e-12);
        assert!((found.expanded - 3.0).abs() < 1e-12);
        assert_eq!(found.percent_fs, Some(found.expanded));
        let part = |source| {
            found
                .budget
                .iter()
                .find(|own| own.source == source)
                .unwrap()
                .standard
                .clone()
        };
        assert!((part(Source::Reproducibility).unwrap() - 1.25_f64.sqrt()).abs() < 1e-12);
        assert!((part(Source::Residual).unwrap() - 0.75_f64.sqrt()).abs() < 1e-12);
        assert_eq!(part(Source::Creep), Err("no hold".to_owned()));
        // Welch-Satterthwaite: 2.25² / (1.25² / 3).
        assert!((found.degrees.unwrap() - 3.0 * (2.25_f64 / 1.25).powi(2)).abs() < 1e-9);
    }

    /// 95.45 % of normal errors are within two standard deviations, with an offset of each group's own as well.
    #[test]
    fn normal_errors_are_covered_as_often_as_they_should_be() {
        for between in [0.0, 0.5, 1.0] {
            let groups = groups(40, 5000, |at, random| {
                let mut own = Random::new(8, &[at as u64]);
                between * own.normal() + random.normal()
            });
            let coverage = of(&groups, Vec::new()).coverage.unwrap();
            assert!(
                (0.93..0.97).contains(&coverage.share),
                "{between}: {coverage:?}"
            );
            assert!(coverage.least <= coverage.share);
        }
    }

    /// Four groups without a mean error, of mean squares 1, 1, 4, 2: s² of their mean is (1 + 1 + 4) / 3 / 4, so ν = 2 · 2² / 0.5.
    #[test]
    fn groups_that_differ_in_size_alone_are_few_too() {
        let errors = [1.0_f64, 1.0, 4.0, 2.0].map(|square| [square.sqrt(), -square.sqrt()]);
        let groups = errors.map(|own| GroupErrors::of("g", &own, 1, 10));
        let found = of(&groups, Vec::new());
        assert!((found.degrees.unwrap() - 16.0).abs() < 1e-9);
        assert!(found.factor_by_degrees > 2.1);
    }

    #[test]
    fn two_groups_cannot_judge_each_other() {
        let found = of(&groups(2, 100, |_, random| random.normal()), Vec::new());
        assert!(found.coverage.unwrap_err().contains("fewer than 3"));
    }

    /// Between the rows of the table to a hundredth, as SciPy's t.ppf(0.97725, n) says.
    #[test]
    fn factors_of_few_degrees_of_freedom_are_those_of_student() {
        for (degrees, factor) in [
            (1.0, 13.968),
            (4.0, 2.869),
            (12.0, 2.231),
            (40.0, 2.064),
            (70.0, 2.036),
            (1e9, 2.0),
        ] {
            assert!(
                (student(degrees) - factor).abs() < 0.01,
                "{degrees}: {}",
                student(degrees)
            );
        }
    }

    #[test]
    fn groups_that_are_one_are_weighed_by_their_samples() {
        let whole = GroupErrors::of("a", &[1.0, -2.0, 3.0], 1, 10);
        let parts =
            GroupErrors::of("a", &[1.0], 1, 10).and(GroupErrors::of("b", &[-2.0, 3.0], 1, 10));
        assert_eq!(parts, whole);
    }
}
