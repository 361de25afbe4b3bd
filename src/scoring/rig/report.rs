//! Findings about the test rig in the training recordings, with the zeros and sensitivities of the gauges.

use std::collections::HashMap;
use std::path::Path;

use serde::Serialize;

use crate::{
    calibration::Calibration,
    finding::{Finding, Id, Verdict},
    progress::{Cancelled, Progress},
    recording::Recording,
    scoring::{
        faults::are_of_one_table,
        lag::{Lag, LagRun, UNRESOLVED, lag_by_run, lags},
        numbers::{percent, significant},
        rig::{
            Rig, Run,
            cause::{Cause, Contradiction, Where, matters},
        },
    },
    shown::{first, joined},
};

/// Pairs of units that are often confused: the factor between the two units, and a text that names the confusion.
const UNITS: [(f64, &str); 6] = [
    (4.448_221_6, "pounds-force taken for newtons"),
    (9.806_65, "kilograms-force taken for newtons"),
    (1000.0, "a unit that is a thousand times as large or as small"),
    (8.850_746, "pound-inches taken for newton metres"),
    (1.355_818, "pound-feet taken for newton metres"),
    (100.0, "centimetres taken for metres"),
];
/// Maximum relative deviation of a found factor from the factor between two units, or from −1, for which the report names the
/// confused units or the reversed sign.
const NEAR: f64 = 0.03;
const NAMED: usize = 6;
/// Maximum number of samples in which time lags are measured. If the recordings have more samples, only the first recordings
/// are used.
const LAG_LONGEST: usize = 200_000;

/// Zeros and sensitivities of the gauges in each training recording, with the findings about the test rig.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RigReport {
    /// Rows of the table of zeros and sensitivities, in order of time. A row is one recording, or several consecutive
    /// recordings together.
    pub runs: Vec<Run>,
    /// Name of each row of the table: the name of its recording, or of the first and the last one.
    pub names: Vec<String>,
    /// Names of the gauges.
    pub gauges: Vec<String>,
    /// Findings about faults of the test rig, and about columns that are not gauges.
    #[serde(skip)]
    pub findings: Vec<Finding>,
    /// Fault that would explain why recordings disagree.
    #[serde(skip)]
    pub suspicion: Option<Suspicion>,
    /// True if the zeros of the recordings differ as if those of the reference did.
    #[serde(skip)]
    pub are_zeros_of_reference: bool,
}

/// Fault of recordings that is not found if another cause explains more.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspicion {
    /// Finding that names the fault.
    pub finding: Finding,
    /// Share of the mean squared held-out error that is left after correction of the fault.
    pub left: f64,
}

impl RigReport {
    /// Creates the report for training recordings. The full scale of each axis is given. Returns `None` if no load moves.
    pub fn of(
        training: &[&Recording],
        full_scale: &[f64],
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let Some(rig) = Rig::of(training, full_scale) else { return Ok(None) };
        progress.check()?;
        let gauges = training[0].gauge_names().to_vec();
        let n_sources = training.chunk_by(|a, b| a.source() == b.source()).count();
        let name = |run: usize| match rig.recordings(run) {
            [only] => training[*only].name().to_owned(),
            [first, .., last] => {
                let [first, last] = [first, last].map(|at| training[*at]);
                let stem = first.source().path().and_then(Path::file_stem);
                match stem.filter(|_| n_sources > 1 && first.source() == last.source()) {
                    Some(stem) => stem.to_string_lossy().into_owned(),
                    None => format!("{} … {}", first.name(), last.name()),
                }
            }
            [] => String::new(),
        };
        let names: Vec<String> = (0..rig.n_runs()).map(name).collect();
        let mut findings = Vec::from_iter(rig.no_gauges(&gauges, &names));
        // If recordings contain the same samples, held-out samples would be predicted from their own copies, so faults are
        // not searched.
        let has_copies = same_samples(training).is_some();
        let is_searched = !has_copies && !are_sorted_by_load(training);
        let is_table = training[0].is_load_case();
        let one_disagrees = || rig.one_disagrees(training, &names);
        if findings.is_empty() && !has_copies && is_table {
            findings.extend(one_disagrees().map(|own| own.0));
        }
        if findings.is_empty() && is_searched {
            findings = rig.mountings(training);
        }
        let changes = rig.changes_within(training, progress)?;
        let suspicion = if findings.is_empty() && is_searched {
            let found = rig.contradiction();
            // A zero that changes within recordings says more than other zeros or gains from one recording to the next.
            let is_of_gauges = |cause: &Cause| {
                matches!(cause, Cause::Tare | Cause::Drift | Cause::Gauge(_) | Cause::AllGauges)
            };
            let found = found.filter(|own| changes.is_empty() || !is_of_gauges(&own.cause));
            found.map(|own| own.suspicion(&rig, &names, &gauges))
        } else {
            None
        };
        findings.extend(changes);
        findings.extend(rig.clipped_reference(training));
        progress.check()?;
        if findings.is_empty() && suspicion.is_none() && is_searched && !is_table {
            let found = one_disagrees();
            let own: Vec<&Recording> =
                found.iter().flat_map(|own| &own.1).map(|at| training[*at]).collect();
            let late = lag(&own, progress)?;
            findings.extend(found.map(|(found, _)| match late {
                Some(late) => found.with(late.seen),
                None => found,
            }));
        }
        let (runs, are_zeros_of_reference) = (rig.table(), rig.are_zeros_of_reference());
        Ok(Some(Self { runs, names, gauges, findings, suspicion, are_zeros_of_reference }))
    }
}

/// Returns true if these are the load cases of one table, in the order of their loads on all axes. A curve of the gauges then
/// looks like a change from one row on.
fn are_sorted_by_load(training: &[&Recording]) -> bool {
    let is_one_table = training.windows(2).all(|pair| are_of_one_table(pair[0], pair[1]));
    let is_sorted = |axis: usize| {
        let loads = || training.iter().map(|case| case.loads()[axis]);
        loads().is_sorted() || loads().rev().is_sorted()
    };
    is_one_table && training.len() > 1 && (0..training[0].axes().len()).all(is_sorted)
}

impl Contradiction {
    fn suspicion(&self, rig: &Rig, names: &[String], gauges: &[String]) -> Suspicion {
        let value = self.value;
        let is_only_gauge = matches!(self.cause, Cause::Gauge(_)) && gauges.len() == 1;
        let is_load = is_only_gauge || matches!(self.cause, Cause::AllGauges | Cause::Axes(_));
        let near = |factor: f64| (value / factor - 1.0).abs() < NEAR;
        let unit = UNITS.iter().find(|(own, _)| is_load && (near(*own) || near(1.0 / own)));
        let times = if (-1.25..-0.8).contains(&value) {
            "has the opposite sign".to_owned()
        } else {
            format!("is {} times as large", significant(value, 3))
        };
        let symbols =
            |axes: &[usize]| joined(", ", axes.iter().map(|axis| rig.axes()[*axis].symbol()));
        let of_load = |axes: &[usize]| {
            let symbols = symbols(axes);
            (Id::ReferenceScale, format!("the load on {symbols} that the gauges show {times}"))
        };
        let swapped = |a: &str, b: &str| {
            (Id::ColumnsSwapped, format!("the columns of {a} and {b} are exchanged"))
        };
        let (id, what) = match &self.cause {
            Cause::Tare => {
                let can_tell = gauges.len() > rig.axes().len();
                let or = if can_tell { "" } else { " or of the reference" };
                (Id::TareChanged, format!("the zeros of the gauges{or} are different"))
            }
            Cause::ReferenceZero => {
                (Id::ReferenceZero, "the zero of the reference is different".to_owned())
            }
            Cause::Drift => (Id::ZerosDrift, "the zeros of the gauges drift with time".to_owned()),
            Cause::Gauge(gauge) => {
                (Id::GaugeChanged, format!("the sensitivity of {} {times}", gauges[*gauge]))
            }
            // Gauges do not all change their sign, so it is the sign of the only load.
            Cause::AllGauges if value < 0.0 && rig.axes().len() == 1 => of_load(&[0]),
            Cause::AllGauges => {
                (Id::AllGaugesChanged, format!("the sensitivity of all gauges {times}"))
            }
            Cause::Axes(axes) => of_load(axes),
            Cause::Rotation => {
                let degrees = significant(value.to_degrees(), 2);
                (Id::FrameTurned, format!("the frame of the reference is turned by {degrees}°"))
            }
            Cause::Moved => {
                let distance = significant(value, 2);
                (
                    Id::FrameTurned,
                    format!("the reference point of the moments is moved by {distance} m"),
                )
            }
            Cause::SwappedGauges(a, b) => swapped(&gauges[*a], &gauges[*b]),
            Cause::SwappedAxes(a, b) => swapped(&symbols(&[*a]), &symbols(&[*b])),
        };
        let place = match self.place {
            Where::From(first) if names.len() == 2 => {
                format!("in {}, compared with {}, ", names[first], names[0])
            }
            Where::From(first) => {
                format!("from {} on, compared with the recordings before, ", names[first])
            }
            Where::One(run) => format!("in {}, compared with the other recordings, ", names[run]),
            Where::All => String::new(),
        };
        let [with, without] = [self.with, self.without].map(|own| significant(100.0 * own, 2));
        let unit = unit.map_or_else(String::new, |(_, unit)| format!("{unit} would explain it; "));
        let figures = format!(
            "{unit}the held-out error is {with} % of full scale, and {without} % after correction of this fault"
        );
        let found = Finding::new(id, Verdict::Doubtful, format!("{place}{what}"));
        let finding = found.with(figures).costing(self.with - self.without);
        Suspicion { finding, left: (self.without / self.with).powi(2) }
    }
}

/// Returns the finding that recordings contain the same samples of gauges and loads.
pub fn same_samples(recordings: &[&Recording]) -> Option<Finding> {
    let mut known: HashMap<Vec<u64>, &Recording> = HashMap::new();
    let mut pairs = Vec::new();
    for own in recordings.iter().filter(|own| own.n_samples() > 1) {
        let middle = own.n_samples() / 2;
        let key = own.gauges_at(0).iter().chain(own.gauges_at(middle)).map(|value| value.to_bits());
        if let Some(earlier) = known.insert(key.collect(), own)
            && earlier.gauges() == own.gauges()
            && earlier.loads() == own.loads()
        {
            pairs.push(format!("{} and {}", earlier.name(), own.name()));
        }
    }
    let seen = format!("the same samples are in the recordings {}", first(NAMED, pairs.iter()));
    let found = Finding::new(Id::SameSamples, Verdict::Doubtful, seen);
    (!pairs.is_empty()).then_some(found)
}

/// Returns the finding of [`lag`] with its cost converted from a share of the error to a share of full scale, by the errors
/// of a calibration.
pub fn lag_of_fit(found: &Finding, calibration: &Calibration) -> Finding {
    let errors = calibration.quality.compensated.train_rmse.iter().flatten();
    let of_scale = errors.zip(&calibration.full_scale).filter(|(_, full_scale)| **full_scale > 0.0);
    let error = of_scale.map(|(error, full_scale)| error / full_scale).fold(0.0, f64::max);
    found.clone().costing(found.cost * error)
}

/// Returns the finding that gauges lag behind the reference or are ahead of it. The cost of the finding is the share of the
/// error that the lag explains.
pub fn lag(training: &[&Recording], progress: &Progress) -> Result<Option<Finding>, Cancelled> {
    let mut n = 0;
    let moving = training.iter().filter(|own| !own.is_static()).take_while(|own| {
        n += own.n_samples();
        n <= LAG_LONGEST
    });
    let moving: Vec<&&Recording> = moving.collect();
    let runs: Vec<LagRun<'_>> =
        (moving.iter()).map(|recording| LagRun::of(recording, recording.gauges())).collect();
    if runs.is_empty() {
        return Ok(None);
    }
    let error_without = |own: &Lag| (1.0 - own.explained_error_share).max(0.0).sqrt();
    let is_late = |own: &&Lag| own.is_significant() && matters(1.0, error_without(own));
    let found = lags(&runs, progress)?;
    let known: Vec<&Lag> = found.iter().flatten().collect();
    let late: Vec<&Lag> = known.iter().copied().filter(is_late).collect();
    let worst =
        late.iter().max_by(|a, b| a.explained_error_share.total_cmp(&b.explained_error_share));
    // On single gauges, hysteresis alone can look like a lag.
    let Some(worst) = worst.filter(|_| 2 * late.len() > known.len()) else { return Ok(None) };
    let is_worst = |own: &Result<Lag, _>| own.as_ref().is_ok_and(|own| std::ptr::eq(own, *worst));
    let by_run = lag_by_run(&runs, found.iter().position(is_worst).unwrap_or_default());
    let differs = |own: &Lag| {
        let error = own.standard_error_secs.hypot(worst.standard_error_secs);
        let apart = (own.seconds - worst.seconds).abs();
        apart > 4.0 * error && apart * worst.samples.abs() > UNRESOLVED * worst.seconds.abs()
    };
    let by_run = moving.iter().map(|own| own.name()).zip(by_run);
    let by_gauge = training[0].gauge_names().iter().map(String::as_str).zip(found.iter().cloned());
    let others: Vec<String> = (by_run.chain(by_gauge))
        .filter_map(|(name, own)| Some((name, own.ok().filter(differs)?)))
        .map(|(name, own)| format!("{name} {} s", significant(own.seconds, 2)))
        .collect();
    let way = if worst.seconds > 0.0 { "behind" } else { "ahead of" };
    let seen = format!(
        "the gauges are {way} the reference by {} s, which is {} samples",
        significant(worst.seconds.abs(), 2),
        significant(worst.samples.abs(), 2)
    );
    let mut figures = format!(
        "the lag explains {} of the squared error of a conventional calibration",
        percent(worst.explained_error_share)
    );
    if !others.is_empty() {
        let others = first(NAMED, &others);
        figures += &format!("; other recordings or gauges have other lags: {others}");
    }
    let cost = 1.0 - error_without(worst);
    Ok(Some(Finding::new(Id::Lag, Verdict::Doubtful, seen).with(figures).costing(cost)))
}
