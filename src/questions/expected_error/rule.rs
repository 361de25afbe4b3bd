//! Rules of the expected error: when the recordings suffice for it, its value per axis, and the conditions that the
//! recordings do not cover.

use std::collections::BTreeMap;

use crate::{
    calibration::{AxisExpectedError, ExpectedError, HeldOut, NoCrossValidation, t_beyond},
    min_max::MinMax,
    recording::{Axis, Entry, GroupedBy, Recording, Role, in_role, load_cases, load_ranges},
    scoring::quantile::quantile,
    shown::joined,
};

/// Share of the held-out errors that lie within the expected error.
const SHARE: f64 = 0.95;

/// Share of normally distributed errors that lie within the widened value. It is larger than [`SHARE`], so that at most one axis
/// in ten has less than 90 % of its fresh errors within the expected error. See the table in the guide.
const WIDENED_SHARE: f64 = 0.953;

/// Magnitude that 95 % of normally distributed numbers do not exceed, in standard deviations.
const NORMAL: f64 = 1.959_963_984_540_054;

/// Minimum number of left-out groups for an expected error. Without them, the same number of test recordings is enough.
pub const MIN_GROUPS: usize = 3;

/// Minimum number of load cases of a table with an expected error. Of fewer cases, even the largest error is exceeded by more
/// than 5 % of further errors on average (conformal prediction).
pub const MIN_CASES: usize = 20;

/// Minimum load range that gives an axis an expected error, as a share of the largest load range among the axes with the same
/// unit.
pub const STANDS_STILL: f64 = 0.02;

/// Minimum load from which an axis counts as loaded in a sample, as a share of the axis' largest load.
const LOADED: f64 = 0.1;

/// Minimum share of samples with several loaded axes among all samples with a loaded axis. Below this share, the recordings
/// count as loaded one axis at a time.
const COMBINED: f64 = 0.05;

/// Held-out errors, from which the expected error is computed.
#[derive(Debug, Default)]
pub struct HeldOutErrors {
    /// Number of held-out samples, which may be larger than the number of stored errors.
    pub n_samples: u64,
    n_axes: usize,
    /// Errors of evenly spread samples of each left-out group or test recording, one list per axis, in the axis' unit.
    groups: BTreeMap<usize, Vec<Vec<f64>>>,
}

impl HeldOutErrors {
    pub fn new(n_axes: usize) -> Self {
        Self { n_axes, ..Self::default() }
    }

    /// Returns the number of groups: left-out groups, or test recordings.
    pub fn n_groups(&self) -> usize {
        self.groups.len()
    }

    /// Adds every `step`-th sample's errors of a group; `errors` is `n × n_axes` row-major.
    pub fn add(&mut self, group: usize, errors: impl ExactSizeIterator<Item = f64>, step: usize) {
        let n_axes = self.n_axes;
        self.n_samples += (errors.len() / n_axes.max(1)) as u64;
        let stored = self.groups.entry(group).or_insert_with(|| vec![Vec::new(); n_axes]);
        for (at, error) in errors.enumerate() {
            if (at / n_axes).is_multiple_of(step) {
                stored[at % n_axes].push(error);
            }
        }
    }

    /// Adds the errors of every `step`-th sample: loads minus reference loads, both `n × n_axes` row-major.
    pub fn add_loads(&mut self, group: usize, loads: &[f64], reference: &[f64], step: usize) {
        let errors = loads.iter().zip(reference).map(|(load, reference)| load - reference);
        self.add(group, errors, step);
    }

    /// Returns the value within which 95 % of these errors lie, per axis; `None` without errors.
    fn values(&self) -> Option<Vec<f64>> {
        let of_axis = |axis: usize| {
            let errors = self.groups.values().flat_map(|group| &group[axis]);
            quantile(&mut errors.map(|error| error.abs()).collect::<Vec<f64>>(), SHARE)
        };
        (0..self.n_axes).map(of_axis).collect()
    }

    /// Returns the value within which 95 % of the errors of **another** group are expected, per axis; `None` with fewer than
    /// two groups.
    ///
    /// The largest of few errors on one axis says little. So the errors of each axis, divided by their root mean square, are
    /// taken together for the quantile, which is multiplied by the root mean square of the axis.
    ///
    /// The errors of a group are alike, so few groups determine the value only roughly. Therefore it is widened twice. The rank
    /// of the quantile is that of a conformal prediction from `G / s⁴` independent values, where `G` is the number of groups and
    /// `s` is the share of the mean square that the groups' mean errors have: `s` is 1 for a table of load cases. The value is
    /// multiplied by the ratio of two quantiles: Student's t and normal. The degrees of freedom follow from the differences
    /// between the mean squares of the groups.
    fn widened(&self) -> Option<Vec<f64>> {
        let of_axis = |axis: usize| {
            let errors = self.groups.values().map(move |group| &group[axis]);
            errors.filter(|errors| !errors.is_empty())
        };
        let square = |errors: &[f64]| errors.iter().map(|error| error * error).sum::<f64>();
        let n_groups = of_axis(0).count() as f64;
        let rms = (0..self.n_axes).map(|axis| {
            let sums = of_axis(axis).map(|errors| (square(errors), errors.len() as f64));
            let (squares, n) = sums.fold((0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
            (squares / n).sqrt()
        });
        let rms: Vec<f64> = rms.collect();
        let scaled = (0..self.n_axes).filter(|axis| rms[*axis] > 0.0);
        let scaled =
            scaled.flat_map(|axis| of_axis(axis).flatten().map(move |error| (error, axis)));
        let mut scaled: Vec<f64> = scaled.map(|(error, axis)| error.abs() / rms[axis]).collect();
        // For each axis: relative variance of the groups' mean squares, and share of the groups' mean errors.
        let spread = |axis: usize| {
            let (mut relative, mut share, mut n) = (0.0, 0.0, 0.0);
            for errors in of_axis(axis) {
                let of_group = errors.len() as f64;
                let mean_square = square(errors) / of_group;
                relative += (mean_square / rms[axis].powi(2) - 1.0).powi(2) / (n_groups - 1.0);
                share += errors.iter().sum::<f64>().powi(2) / of_group;
                n += of_group;
            }
            let is_known = rms[axis] > 0.0;
            if is_known { (relative, share / n / rms[axis].powi(2)) } else { (0.0, 0.0) }
        };
        let spreads: Vec<(f64, f64)> = (0..self.n_axes).map(spread).collect();
        let relative = spreads.iter().map(|own| own.0).sum::<f64>() / self.n_axes as f64;
        let relative = relative_variance(relative, n_groups);
        let widened = spreads.into_iter().zip(rms).map(|((_, share), rms)| {
            // One normally distributed mean error for each group gives mean squares with a relative variance of 2.
            let freedom = 2.0 * n_groups / relative.max(2.0 * share * share);
            let factor = t_beyond(freedom, 0.5 * (1.0 - WIDENED_SHARE)) / NORMAL;
            let rank = SHARE * (1.0 + share.powi(4) / n_groups);
            if rms > 0.0 {
                quantile(&mut scaled, rank.min(1.0)).unwrap_or(0.0) * rms * factor
            } else {
                0.0
            }
        });
        (n_groups > 1.0).then(|| widened.collect())
    }
}

/// Returns the relative variance of the mean squares of independent groups, from the value found in `n_groups` groups.
///
/// The found value is too small for few groups: on average `r G / (G + r)` for a true value `r`, if the mean squares have a gamma
/// distribution. It is combined with one more group of a relative variance of one, because two or three groups may be equal by
/// chance.
fn relative_variance(found: f64, n_groups: f64) -> f64 {
    let found = found.min(0.9 * n_groups);
    let unbiased = found * n_groups / (n_groups - found);
    ((n_groups - 1.0) * unbiased + 1.0) / n_groups
}

/// Returns the expected error from the errors on left-out groups and on test recordings.
///
/// `axes` contains each axis of the calibration with its full scale, which is 0 if unknown.
///
/// # Errors
/// A clause with the reason why there is no expected error.
pub fn expected_from(
    entries: &[Entry],
    axes: &[(Axis, f64)],
    grouped_by: GroupedBy,
    left_out: Result<HeldOutErrors, NoCrossValidation>,
    tested: HeldOutErrors,
) -> Result<ExpectedError, String> {
    let left_out = match left_out {
        Ok(errors) if errors.n_groups() < MIN_GROUPS => {
            Err(NoCrossValidation::FewGroups { found: errors.n_groups(), needed: MIN_GROUPS })
        }
        errors => errors,
    };
    let n_cases = n_cases(entries, axes);
    if let Some(found) = n_cases.filter(|found| *found < MIN_CASES) {
        return Err(format!(
            "there are {found} load cases, but an expected error needs {MIN_CASES}; add rows with other loads"
        ));
    }
    let n_tests = tested.n_groups();
    if let Err(reason) = &left_out
        && n_tests < MIN_GROUPS
    {
        return Err(format!(
            "{reason}. In place of such groups, {MIN_GROUPS} test recordings are enough, too (there are {n_tests})"
        ));
    }
    let by_cross_validation = left_out.as_ref().ok().and_then(HeldOutErrors::widened);
    // Beside a cross-validation, the test recordings only confirm its value.
    let by_test = match &by_cross_validation {
        Some(_) => tested.values().filter(|_| n_tests > 0),
        None => tested.widened(),
    };
    let ranges = load_ranges(used(entries), axes.len());
    let of_axis = |(at, (axis, full_scale)): (usize, &(Axis, f64))| {
        let same_unit = axes.iter().zip(&ranges);
        let same_unit = same_unit.filter(|((other, _), _)| other.is_force() == axis.is_force());
        let largest = same_unit.map(|(_, range)| range.span()).fold(2.0 * full_scale, f64::max);
        let moves = ranges[at].span() > STANDS_STILL * largest;
        let figure = |values: &Option<Vec<f64>>| Some(values.as_ref()?[at]).filter(|_| moves);
        let (cross_validation, test) = (figure(&by_cross_validation), figure(&by_test));
        let value = cross_validation.into_iter().chain(test).reduce(f64::max);
        AxisExpectedError {
            axis: *axis,
            unit: axis.unit().to_owned(),
            range: ranges[at].ends().unwrap_or_default(),
            value,
            percent_fs: value.filter(|_| *full_scale > 0.0).map(|error| 100.0 * error / full_scale),
            cross_validation,
            test,
        }
    };
    let held_out =
        |errors: &HeldOutErrors| HeldOut { groups: errors.n_groups(), samples: errors.n_samples };
    Ok(ExpectedError {
        axes: axes.iter().enumerate().map(of_axis).collect(),
        cross_validation: left_out.as_ref().ok().map(held_out),
        test: (n_tests > 0).then(|| held_out(&tested)),
        not_covered: not_covered(entries, axes.len(), grouped_by),
    })
}

/// Returns the number of load cases of the training recordings, if they are tables of load cases. If there are no training
/// recordings, the test recordings count.
fn n_cases(entries: &[Entry], axes: &[(Axis, f64)]) -> Option<usize> {
    let recordings = [Role::Train, Role::Test].map(|role| in_role(entries, role));
    let held_out = recordings.into_iter().find(|recordings| !recordings.is_empty())?;
    let are_cases = held_out.iter().all(|recording| recording.is_load_case());
    are_cases.then(|| {
        let loads = held_out.iter().flat_map(|recording| recording.loads());
        let axes: Vec<Axis> = axes.iter().map(|(axis, _)| *axis).collect();
        let cases = load_cases(&loads.copied().collect::<Vec<_>>(), &axes);
        cases.into_iter().max().map_or(0, |last| last + 1)
    })
}

pub fn used(entries: &[Entry]) -> impl Iterator<Item = &Recording> {
    let used = entries.iter().filter(|entry| entry.role != Role::Off);
    used.map(|entry| &*entry.recording)
}

/// Returns a sentence that lists the conditions that the recordings do not cover.
pub fn not_covered(entries: &[Entry], n_axes: usize, grouped_by: GroupedBy) -> String {
    let is_mounted_anew =
        matches!(grouped_by, GroupedBy::Mounting | GroupedBy::Mount | GroupedBy::Setup);
    let missing = [
        (true, "loads beyond the range of the recorded loads"),
        (
            n_axes > 1 && is_one_axis_at_a_time(entries, n_axes),
            "combined loads (the recordings load one axis at a time)",
        ),
        (
            is_one_programme(&in_role(entries, Role::Train)),
            "other load programmes (all training recordings repeat the same one)",
        ),
        (!is_mounted_anew, "another mounting"),
        (grouped_by != GroupedBy::Day, "another day"),
    ];
    let missing = missing.into_iter().filter(|(is_missing, _)| *is_missing);
    format!("The expected error does not cover {}.", joined(", or ", missing.map(|own| own.1)))
}

/// Returns true if only few of the samples with a load have more than one loaded axis.
pub fn is_one_axis_at_a_time(entries: &[Entry], n_axes: usize) -> bool {
    let largest: Vec<f64> =
        load_ranges(used(entries), n_axes).into_iter().map(MinMax::magnitude).collect();
    let (mut loaded, mut combined) = (0_u64, 0_u64);
    for recording in used(entries) {
        for load in recording.loads().chunks_exact(n_axes) {
            let n = load.iter().zip(&largest);
            let n = n.filter(|(load, largest)| load.abs() > LOADED * **largest).count();
            loaded += u64::from(n > 0);
            combined += u64::from(n > 1);
        }
    }
    loaded > 0 && (combined as f64) < COMBINED * loaded as f64
}

/// Returns true if there are several recordings and all repeat one load programme: equal loads at equal shares of their
/// duration.
pub fn is_one_programme(recordings: &[&Recording]) -> bool {
    recordings.len() > 1 && recordings[1..].iter().all(|other| other.repeats(recordings[0]))
}

#[cfg(test)]
mod tests {
    use statrs::function::erf::erf;

    use super::*;
    use crate::random::Random;
    use crate::recording::Source;

    /// Returns a training recording of Fx and Fy. Its loads are functions of the share of its length, 0 to 1.
    fn entry(name: &str, loads: impl Fn(f64) -> [f64; 2]) -> Entry {
        let n = 200;
        let times: Vec<f64> = (0..n).map(f64::from).collect();
        let loads = (0..n).flat_map(|k| loads(f64::from(k) / f64::from(n - 1)));
        let recording = Recording::new(
            name,
            Source::Simulated,
            times,
            vec!["S1".to_owned()],
            vec![0.0; n as usize],
            vec![Axis::Fx, Axis::Fy],
            loads.collect(),
        );
        Entry::new(recording.unwrap(), Role::Train)
    }

    fn errors(n_groups: usize, sizes: impl Iterator<Item = f64> + Clone) -> HeldOutErrors {
        let rows: Vec<f64> = sizes.flat_map(|size| [size, -2.0 * size]).collect();
        let mut errors = HeldOutErrors::new(2);
        (0..n_groups).for_each(|group| errors.add(group, rows.clone().into_iter(), 1));
        errors
    }

    fn weighed(
        entries: &[Entry],
        left_out: HeldOutErrors,
        tested: HeldOutErrors,
    ) -> Result<ExpectedError, String> {
        let axes = [(Axis::Fx, 10.0), (Axis::Fy, 10.0)];
        expected_from(entries, &axes, GroupedBy::Recording, Ok(left_out), tested)
    }

    fn path(at: f64) -> impl Fn(f64) -> [f64; 2] {
        move |share| [10.0 * (7.0 * share + at).sin(), 10.0 * (5.0 * share + 2.0 * at).cos()]
    }

    /// Quantile of Student's t with 18 degrees of freedom that 2.35 % exceed, divided by the normal quantile that 2.5 % exceed
    /// (SciPy). Three groups with equal mean squares have 18 degrees of freedom.
    const T_18: f64 = 1.0879859425179732;

    /// The errors on each axis are ±0.01, ±0.02 … ±1.00: 95 % lie within 0.95. The test errors are half as large.
    #[test]
    fn the_larger_of_cross_validation_and_test_counts() {
        let entries: Vec<Entry> = (0..3).map(|at| entry("r", path(f64::from(at)))).collect();
        let sizes = (1..=100).flat_map(|k| [f64::from(k) / 100.0, f64::from(-k) / 100.0]);
        let left_out = errors(3, sizes.clone());
        let tested = errors(1, sizes.map(|size| size / 2.0));
        let found = weighed(&entries, left_out, tested).unwrap();
        let fx = &found.axes[0];
        let value = fx.value.unwrap();
        assert_eq!((fx.cross_validation, fx.test), (Some(value), Some(0.475)));
        assert!((value - 0.95 * T_18).abs() < 1e-5, "{value}");
        assert!((fx.percent_fs.unwrap() - 10.0 * value).abs() < 1e-9);
        assert!((found.of_axis(Axis::Fy).unwrap() - 2.0 * value).abs() < 1e-9);
        let held_out = found.cross_validation.as_ref().unwrap();
        assert_eq!((held_out.groups, held_out.samples), (3, 600));
        assert!(
            found.notes()[0].contains("3 groups") && found.notes()[0].contains("1 test recording")
        );
    }

    #[test]
    fn two_groups_have_no_expected_error_but_three_test_recordings_do() {
        let entries = [entry("r", path(0.0))];
        let of = |n_tests: usize| {
            let tested = match n_tests {
                0 => HeldOutErrors::new(2),
                n => errors(n, std::iter::once(1.0)),
            };
            weighed(&entries, errors(2, std::iter::once(9.0)), tested)
        };
        assert!(of(2).unwrap_err().contains("2 groups, but cross-validation needs 3"));
        let found = of(3).unwrap();
        let fx = &found.axes[0];
        assert_eq!((fx.cross_validation, fx.value), (None, fx.test));
        assert!(fx.value > Some(1.0), "three test recordings alone are widened");
    }

    /// Returns the mean share of further normally distributed errors within the expected error, over 300 sets of groups. The
    /// errors of one group share a part of their variance.
    fn coverage(n_groups: usize, n_samples: usize, shared: f64) -> f64 {
        let mut random = Random::new(5, &[n_groups as u64]);
        let inside = |value: f64| erf(value / 2.0_f64.sqrt());
        let sets = (0..300).map(|_| {
            let mut errors = HeldOutErrors::new(1);
            for group in 0..n_groups {
                let mean = shared.sqrt() * random.normal();
                let sample = |_| mean + (1.0 - shared).sqrt() * random.normal();
                let rows: Vec<f64> = (0..n_samples).map(sample).collect();
                errors.add(group, rows.into_iter(), 1);
            }
            inside(errors.widened().unwrap()[0])
        });
        sets.sum::<f64>() / 300.0
    }

    /// The 95 % of the same errors cover 90 % for 20 independent cases, and 85 % for three groups whose errors are mostly shared.
    #[test]
    fn fresh_errors_are_covered_on_average() {
        for (n_groups, n_samples, shared) in [
            (20, 1, 1.0),
            (40, 1, 1.0),
            (60, 10, 1.0),
            (3, 100, 0.9),
            (6, 100, 0.5),
            (10, 100, 0.0),
        ] {
            let covered = coverage(n_groups, n_samples, shared);
            assert!((covered - 0.958).abs() < 0.0135, "{n_groups} groups: {covered}");
        }
    }

    /// Mean squares of a gamma distribution with shape 1/2 and 1 have relative variances of 2 and 1.
    #[test]
    fn few_groups_give_the_relative_variance_without_bias() {
        for (truth, found) in [(2.0, 2.0 * 50.0 / 52.0), (1.0, 50.0 / 51.0)] {
            let without_prior = relative_variance(found, 50.0) * 50.0 - 1.0;
            assert!((without_prior / 49.0 - truth).abs() < 1e-12);
        }
    }

    #[test]
    fn a_table_of_fewer_than_twenty_cases_has_no_expected_error() {
        for (n, is_known) in [(19, false), (20, true)] {
            let mut errors = HeldOutErrors::new(2);
            let entries: Vec<Entry> = (0..n)
                .map(|case| {
                    errors.add(case, [0.1, -0.1].into_iter(), 1);
                    let load = vec![case as f64, 0.0];
                    let axes = vec![Axis::Fx, Axis::Fy];
                    let names = vec!["S1".to_owned()];
                    let source = Source::Simulated;
                    let row = Recording::new("r", source, vec![0.0], names, vec![0.0], axes, load);
                    Entry::new(row.unwrap().without_times(), Role::Train)
                })
                .collect();
            let found = weighed(&entries, errors, HeldOutErrors::new(2));
            assert_eq!(found.is_ok(), is_known, "{n} cases");
        }
    }

    #[test]
    fn an_axis_that_hardly_moves_has_no_expected_error() {
        let still = |share: f64| [10.0 * (7.0 * share).sin(), 0.01 * share];
        let entries = [entry("r", still)];
        let found = weighed(&entries, errors(3, std::iter::once(0.1)), HeldOutErrors::new(2));
        let found = found.unwrap();
        assert!(found.axes[0].value.is_some() && found.axes[1].value.is_none());
        assert!(found.of_axis(Axis::Fy).unwrap_err().contains("Fy hardly changes"));
    }

    #[test]
    fn conditions_that_are_not_covered_are_listed() {
        let one_at_a_time = |share: f64| {
            if share < 0.5 {
                [10.0 * (12.0 * share).sin(), 0.0]
            } else {
                [0.0, 10.0 * (12.0 * share).sin()]
            }
        };
        let free: Vec<Entry> = (0..3).map(|at| entry("r", path(f64::from(at)))).collect();
        let repeated: Vec<Entry> =
            (0..3).map(|at| entry("r", path(0.001 * f64::from(at)))).collect();
        let separate: Vec<Entry> = vec![entry("r", one_at_a_time), entry("r", path(0.0))];
        let alone = [entry("r", one_at_a_time)];
        let missing = |entries: &[Entry], grouped_by| not_covered(entries, 2, grouped_by);
        for (entries, single, programme) in [
            (&free[..], false, false),
            (&repeated, false, true),
            (&separate, false, false),
            (&alone, true, false),
        ] {
            let text = missing(entries, GroupedBy::Recording);
            assert_eq!(text.contains("one axis at a time"), single, "{text}");
            assert_eq!(text.contains("repeat the same one"), programme, "{text}");
            assert!(text.contains("another mounting") && text.contains("another day"));
        }
        assert!(!missing(&free, GroupedBy::Mount).contains("another mounting"));
        assert!(!missing(&free, GroupedBy::Day).contains("another day"));
    }
}
