//! Rules of the expected error: when the recordings suffice for it, its value per axis, and the conditions that the
//! recordings do not cover.

use crate::{
    calibration::{AxisExpectedError, ExpectedError, HeldOut, NoCrossValidation},
    min_max::MinMax,
    recording::{Axis, Entry, GroupedBy, Recording, Role, in_role, load_ranges},
    scoring::quantile::quantile,
};

/// Share of the held-out errors that lie within the expected error.
const SHARE: f64 = 0.95;

/// Minimum number of left-out groups for an expected error. Without them, the same number of test recordings is enough.
pub(crate) const MIN_GROUPS: usize = 3;

/// Minimum load range that gives an axis an expected error, as a share of the largest load range among the axes with the same
/// unit.
pub(crate) const STANDS_STILL: f64 = 0.02;

/// Minimum load from which an axis counts as loaded in a sample, as a share of the axis' largest load.
const LOADED: f64 = 0.1;

/// Minimum share of samples with several loaded axes among all samples with a loaded axis. Below this share, the recordings
/// count as loaded one axis at a time.
const COMBINED: f64 = 0.05;

/// Absolute values of held-out errors, from which the expected error is computed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeldOutErrors {
    /// Number of left-out groups or of test recordings that the errors come from.
    pub n_groups: usize,
    /// Number of held-out samples, which may be larger than the number of stored errors.
    pub n_samples: u64,
    /// Absolute errors of evenly spread samples, one list per axis, in the axis' unit.
    pub sizes: Vec<Vec<f64>>,
}

impl HeldOutErrors {
    pub fn new(n_axes: usize) -> Self {
        Self { sizes: vec![Vec::new(); n_axes], ..Self::default() }
    }

    /// Adds the absolute value of every `step`-th sample's errors; `errors` is `n × n_axes` row-major.
    pub fn add(&mut self, errors: impl ExactSizeIterator<Item = f64>, step: usize) {
        let n_axes = self.sizes.len();
        self.n_samples += (errors.len() / n_axes.max(1)) as u64;
        for (at, error) in errors.enumerate() {
            if (at / n_axes).is_multiple_of(step) {
                self.sizes[at % n_axes].push(error.abs());
            }
        }
    }

    /// Adds the absolute errors of every `step`-th sample: loads minus reference loads, both `n × n_axes` row-major.
    pub fn add_loads(&mut self, loads: &[f64], reference: &[f64], step: usize) {
        self.add(loads.iter().zip(reference).map(|(load, reference)| load - reference), step);
    }

    /// Returns the value within which 95 % of the errors lie, per axis; `None` without errors.
    fn values(&mut self) -> Option<Vec<f64>> {
        let values = self.sizes.iter_mut();
        values.map(|sizes| quantile(sizes, SHARE)).collect()
    }
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
    mut tested: HeldOutErrors,
) -> Result<ExpectedError, String> {
    let mut left_out = match left_out {
        Ok(errors) if errors.n_groups < MIN_GROUPS => {
            Err(NoCrossValidation::FewGroups { found: errors.n_groups, needed: MIN_GROUPS })
        }
        errors => errors,
    };
    if let Err(reason) = &left_out
        && tested.n_groups < MIN_GROUPS
    {
        return Err(format!(
            "{reason}. In place of such groups, {MIN_GROUPS} test recordings are enough, too (there are {})",
            tested.n_groups
        ));
    }
    let by_cross_validation = left_out.as_mut().ok().and_then(HeldOutErrors::values);
    let by_test = tested.values().filter(|_| tested.n_groups > 0);
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
        |errors: &HeldOutErrors| HeldOut { groups: errors.n_groups, samples: errors.n_samples };
    Ok(ExpectedError {
        axes: axes.iter().enumerate().map(of_axis).collect(),
        cross_validation: left_out.as_ref().ok().map(held_out),
        test: (tested.n_groups > 0).then(|| held_out(&tested)),
        not_covered: not_covered(entries, axes.len(), grouped_by),
    })
}

pub(crate) fn used(entries: &[Entry]) -> impl Iterator<Item = &Recording> {
    let used = entries.iter().filter(|entry| entry.role != Role::Off);
    used.map(|entry| &*entry.recording)
}

/// Returns a sentence that lists the conditions that the recordings do not cover.
pub(crate) fn not_covered(entries: &[Entry], n_axes: usize, grouped_by: GroupedBy) -> String {
    let mut missing = vec!["loads beyond the range of the recorded loads".to_owned()];
    if n_axes > 1 && is_one_axis_at_a_time(entries, n_axes) {
        missing.push("combined loads (the recordings load one axis at a time)".to_owned());
    }
    if is_one_programme(&in_role(entries, Role::Train)) {
        missing
            .push("other load programmes (all training recordings repeat the same one)".to_owned());
    }
    if !matches!(grouped_by, GroupedBy::Mounting | GroupedBy::Mount | GroupedBy::Setup) {
        missing.push("another mounting".to_owned());
    }
    if grouped_by != GroupedBy::Day {
        missing.push("another day".to_owned());
    }
    let last = missing.pop().expect("loads beyond the recorded range are always in the list");
    if missing.is_empty() {
        format!("The expected error does not cover {last}.")
    } else {
        format!("The expected error does not cover {}, or {last}.", missing.join(", "))
    }
}

/// Returns true if only few of the samples with a load have more than one loaded axis.
pub(crate) fn is_one_axis_at_a_time(entries: &[Entry], n_axes: usize) -> bool {
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
pub(crate) fn is_one_programme(recordings: &[&Recording]) -> bool {
    match recordings {
        [first, others @ ..] => {
            !others.is_empty() && others.iter().all(|other| other.repeats(first))
        }
        [] => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        errors.add(rows.into_iter(), 1);
        errors.n_groups = n_groups;
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

    /// The errors on each axis are 0.01, 0.02 … 1.00: 95 % lie within 0.95. The test errors are half as large.
    #[test]
    fn the_larger_of_cross_validation_and_test_counts() {
        let entries: Vec<Entry> = (0..3).map(|at| entry("r", path(f64::from(at)))).collect();
        let sizes = (1..=100).map(|k| f64::from(k) / 100.0);
        let left_out = errors(3, sizes.clone());
        let tested = errors(1, sizes.map(|size| size / 2.0));
        let found = weighed(&entries, left_out, tested).unwrap();
        let fx = &found.axes[0];
        assert_eq!((fx.cross_validation, fx.test, fx.value), (Some(0.95), Some(0.475), Some(0.95)));
        assert_eq!(fx.percent_fs, Some(9.5));
        assert_eq!(found.of_axis(Axis::Fy), Ok(1.9));
        let held_out = found.cross_validation.as_ref().unwrap();
        assert_eq!((held_out.groups, held_out.samples), (3, 100));
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
        assert_eq!((found.axes[0].cross_validation, found.axes[0].value), (None, Some(1.0)));
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
