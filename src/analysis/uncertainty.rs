//! How far readings may be off: what the recordings tell of it, gathered for [`Evidence`].

use crate::analysis::cautions::STANDS_STILL;
use crate::analysis::dataset::{Dataset, Key};
use crate::analysis::{AnalysisError, Request};
use crate::calibration::{AppliedLoads, Calibration};
use crate::evaluation::coverage::largest;
use crate::evaluation::metrology::{
    Dwell, Figure, Metrology, Quantity, Rules, Run, dwells, extents_of_set, table_by,
};
use crate::evaluation::numbers::significant;
use crate::evaluation::uncertainty::{
    AxisUncertainty, Evidence, GroupErrors, Part, Source, StepFigures, Uncertainty, step_figures,
};
use crate::progress::Progress;
use crate::recording::{Entry, Identity, Item, Recording, Role};

/// What groups are of which each is a mounting of its own; what somebody set may be.
const MOUNTINGS: [&str; 6] = [
    "mounting", "mount", "setup", "rotation", "position", "group",
];
/// A load that stays below this share of full scale does not reach it.
const REACHED: f64 = 0.8;
/// The sizes of so many errors of a recording are kept.
const KEPT: usize = 200_000;

/// Loads that a fit has not seen, of one recording of the dataset.
struct Unseen {
    at: usize,
    group: String,
    loads: AppliedLoads,
}

/// What `calibration` may be off by: by the parts of the training recordings, each predicted by a fit to the others, where that can be
/// had from sums; else by the test recordings, or, of a calibration that was not fitted to them, by all.
///
/// # Errors
/// [`AnalysisError`] where no recording says anything, or somebody asked to stop.
pub fn uncertainty(
    request: &Request,
    calibration: &Calibration,
    fitted: bool,
    identity: &Identity,
    progress: &Progress,
) -> Result<Uncertainty, AnalysisError> {
    let key = Key {
        calibration: request.calibration.clone().filter(|_| !fitted),
        offset: calibration.offset,
        decimation: calibration.decimation,
        ..Key::of(request)
    };
    let data = request.datasets.get(&key, progress)?;
    let past = data.past(calibration, progress)?;
    let applied = |at: usize| AppliedLoads {
        conventional: data.conventional_loads(at),
        compensated: calibration.compensated_loads(&data.entries[at].recording, &past[at]),
        past: Vec::new(),
    };
    let is_known = |entry: &Entry| {
        *entry.recording.axes() == calibration.axes && entry.recording.n_samples() > 0
    };
    let of_role = |role: Role| {
        let entries = data.entries.iter().enumerate();
        entries
            .filter(move |(_, entry)| entry.role == role && is_known(entry))
            .map(|(at, _)| at)
    };
    let mut unseen: Vec<Unseen> = Vec::new();
    let mut of = String::new();
    let mut notes = Vec::new();
    if fitted {
        let sums = data.sums(
            &calibration.design(),
            &past,
            calibration.axes.len(),
            progress,
        );
        progress.check()?;
        match data.fits_left_out(calibration, &sums) {
            Ok(fits) => {
                let pieces = data.pieces();
                for at in of_role(Role::Train) {
                    progress.check()?;
                    let compensated = fits.loads(
                        &data.entries[at].recording,
                        &pieces[at],
                        calibration,
                        &past[at],
                    );
                    let conventional = data.conventional_loads(at);
                    let loads = AppliedLoads {
                        conventional,
                        compensated,
                        past: Vec::new(),
                    };
                    let recording = &data.entries[at].recording;
                    let named = data
                        .groups
                        .name_of(at)
                        .unwrap_or(recording.name())
                        .to_owned();
                    let group = match pieces[at].len() {
                        1 => named,
                        _ => String::new(),
                    };
                    unseen.push(Unseen { at, group, loads });
                }
                of = format!(
                    "the training recordings, each part predicted by a fit to the others ({})",
                    data.cross_validation()
                );
            }
            Err(why) => notes.push(format!(
                "No part of the training recordings is left out: {why}"
            )),
        }
    }
    let tested: Vec<Unseen> = of_role(Role::Test)
        .map(|at| Unseen {
            at,
            group: data.entries[at].recording.name().to_owned(),
            loads: applied(at),
        })
        .collect();
    progress.check()?;
    let mut tests = Vec::new();
    if unseen.is_empty() && fitted {
        (unseen, of) = (tested, "the test recordings".to_owned());
    } else if unseen.is_empty() {
        let all = (0..data.entries.len())
            .filter(|at| data.entries[*at].role != Role::Off && is_known(&data.entries[*at]));
        let all = all.map(|at| Unseen {
            at,
            group: data
                .groups
                .name_of(at)
                .unwrap_or(data.entries[at].recording.name())
                .to_owned(),
            loads: applied(at),
        });
        (unseen, of) = (
            all.collect(),
            "the recordings, to which it was not fitted".to_owned(),
        );
    } else {
        tests = tested
            .iter()
            .map(|own| errors_of(&data, own, 0..data.entries[own.at].recording.n_samples()))
            .collect();
    }
    if unseen.is_empty() {
        return Err(AnalysisError::NothingUnseen);
    }
    let groups = groups(&data, &unseen, fitted);
    let measured = Measured::of(request, &data, &unseen, calibration)?;
    progress.check()?;
    let reference = identity
        .reference_uncertainty(&calibration.axes, &calibration.full_scale)
        .map_err(AnalysisError::Measuring)?;
    let temperature = temperature(&data, identity);
    let ranges = ranges(&data, &unseen, calibration.axes.len());
    let spans: Vec<f64> = ranges
        .iter()
        .map(|(low, high)| (high - low).max(0.0))
        .collect();
    let (mut axes, mut not_stated) = (Vec::<AxisUncertainty>::new(), Vec::new());
    for (at, axis) in calibration.axes.iter().enumerate() {
        let most = largest(&calibration.axes, &spans, *axis).max(2.0 * calibration.full_scale[at]);
        if spans[at] <= STANDS_STILL * most {
            let reason = format!(
                "{} hardly moves in the recordings: they say nothing of readings of it",
                axis.symbol()
            );
            notes.push(reason.clone());
            not_stated.push((*axis, reason));
            continue;
        }
        let evidence = Evidence {
            at,
            axis: *axis,
            full_scale: calibration.full_scale[at],
            range: ranges[at],
            groups: &groups,
            tests: &tests,
            added: vec![
                (
                    Source::Reference,
                    reference[at]
                        .map(|expanded| expanded / 2.0)
                        .ok_or_else(|| "not entered".to_owned()),
                ),
                (Source::Temperature, Err(temperature.clone())),
            ],
            within: measured.parts(at, &data, calibration),
        };
        axes.extend(evidence.combined());
    }
    if reference.contains(&None) {
        notes.push(
            "The uncertainty of the reference is not entered for every axis: U does not hold it"
                .to_owned(),
        );
    }
    notes.extend(short_of_full_scale(&axes));
    notes.extend(few_groups(&axes, groups.len()));
    Ok(Uncertainty {
        of,
        n_groups: groups.len(),
        axes,
        not_stated,
        steps: measured.steps,
        notes,
    })
}

/// What is known of the temperature: within what the recordings span its effects are in their errors.
fn temperature(data: &Dataset, identity: &Identity) -> String {
    let used = data.entries.iter().filter(|entry| entry.role != Role::Off);
    let values = used.flat_map(|entry| {
        let channels = entry.recording.auxiliary();
        let at = channels.units().iter().position(|unit| unit == "°C");
        at.into_iter()
            .flat_map(move |at| channels.values().iter().skip(at).step_by(channels.len()))
    });
    let span = values
        .map(|own| (*own, *own))
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    match span {
        None => match identity.get(Item::Temperature).trim() {
            "" => "no temperature is known".to_owned(),
            entered => format!("at {entered}, as entered; what other temperatures do is not known"),
        },
        Some((low, high)) => format!(
            "the recordings span {} to {} °C; what other temperatures do is not known",
            significant(low, 3),
            significant(high, 3)
        ),
    }
}

/// From which load to which each axis goes where its errors are known.
fn ranges(data: &Dataset, unseen: &[Unseen], n_axes: usize) -> Vec<(f64, f64)> {
    let mut all = vec![(f64::INFINITY, f64::NEG_INFINITY); n_axes];
    for own in unseen {
        let loads = data.entries[own.at].recording.load_ranges();
        for (all, own) in all.iter_mut().zip(loads) {
            *all = (all.0.min(own.0), all.1.max(own.1));
        }
    }
    all
}

/// The axes whose loads do not reach what they are rated for.
fn short_of_full_scale(axes: &[AxisUncertainty]) -> Option<String> {
    let short = axes.iter().filter_map(|own| {
        let (low, high) = own.range;
        let share = low.abs().max(high.abs()) / own.full_scale;
        (share < REACHED).then(|| {
            format!(
                "{} from {} to {} {}, {} % of full scale",
                own.axis.symbol(),
                significant(low, 3),
                significant(high, 3),
                own.unit,
                significant(100.0 * share, 2)
            )
        })
    });
    let short: Vec<String> = short.collect();
    (!short.is_empty()).then(|| {
        format!(
            "The recordings do not reach full scale ({}): U says nothing of larger loads",
            short.join("; ")
        )
    })
}

/// What few groups leave open.
fn few_groups(axes: &[AxisUncertainty], n_groups: usize) -> Option<String> {
    let wide = axes.iter().filter(|own| own.factor_by_degrees > 2.2);
    let wide: Vec<String> = wide
        .map(|own| {
            let factor = significant(own.factor_by_degrees, 3);
            format!("{} k = {factor}", own.axis.symbol())
        })
        .collect();
    (!wide.is_empty()).then(|| {
        format!(
            "The scatter between {n_groups} groups is known by as few: for 95 % it would take {} in place of 2",
            wide.join(", ")
        )
    })
}

/// The errors of some samples of a recording.
fn errors_of(data: &Dataset, of: &Unseen, samples: std::ops::Range<usize>) -> GroupErrors {
    let recording = &data.entries[of.at].recording;
    let n_axes = recording.axes().len();
    let range = samples.start * n_axes..samples.end * n_axes;
    let both = of.loads.compensated[range.clone()]
        .iter()
        .zip(&recording.loads()[range]);
    let errors: Vec<f64> = both.map(|(load, known)| load - known).collect();
    GroupErrors::of(of.group.clone(), &errors, n_axes, KEPT)
}

/// The errors, put together by what is left out together.
fn groups(data: &Dataset, unseen: &[Unseen], fitted: bool) -> Vec<GroupErrors> {
    let pieces = data.pieces();
    let mut found: Vec<(String, GroupErrors)> = Vec::new();
    for own in unseen {
        let is_trained = fitted && data.entries[own.at].role == Role::Train;
        let whole = 0..data.entries[own.at].recording.n_samples();
        let pieces: Vec<(String, std::ops::Range<usize>)> = match is_trained {
            false => vec![(own.group.clone(), whole)],
            true => pieces[own.at]
                .iter()
                .map(|piece| (format!("part {}", piece.fold + 1), piece.samples.clone()))
                .collect(),
        };
        for (key, samples) in pieces {
            let mut errors = errors_of(data, own, samples);
            if errors.name.is_empty() {
                errors.name.clone_from(&key);
            }
            match found.iter_mut().find(|(other, _)| *other == key) {
                Some((_, group)) => *group = std::mem::take(group).and(errors),
                None => found.push((key, errors)),
            }
        }
    }
    found.into_iter().map(|(_, group)| group).collect()
}

/// What loops, dwells and steps show of the errors.
struct Measured {
    table: Metrology,
    zeros: Vec<Option<f64>>,
    steps: Vec<StepFigures>,
}

impl Measured {
    fn of(
        request: &Request,
        data: &Dataset,
        unseen: &[Unseen],
        calibration: &Calibration,
    ) -> Result<Self, AnalysisError> {
        let runs: Vec<Run<'_>> = unseen
            .iter()
            .map(|own| Run::new(&data.entries[own.at].recording, &own.loads))
            .collect();
        let extents = extents_of_set(&request.recordings, &calibration.axes);
        let rules = Rules {
            axes: &calibration.axes,
            full_scale: &calibration.full_scale,
            settings: &request.measuring,
            extents: &extents,
        };
        let told = |error: crate::evaluation::metrology::MetrologyError| {
            AnalysisError::Measuring(error.to_string())
        };
        // Other programmes or days in one mounting are no reproducibility after mounting anew.
        let is_mounted_anew = MOUNTINGS.contains(&data.groups.by);
        let group = |own: &Unseen| {
            if is_mounted_anew {
                data.groups.of[own.at]
            } else {
                0
            }
        };
        let groups: Vec<usize> = unseen.iter().map(group).collect();
        let held = dwells(&runs, &rules).map_err(told)?;
        Ok(Self {
            table: table_by(&runs, &rules).map_err(told)?,
            zeros: zeros(&held, &runs, calibration.axes.len()),
            steps: step_figures(&runs, &groups, &rules).map_err(told)?,
        })
    }

    /// Standard uncertainties of an axis that its errors hold already.
    fn parts(&self, at: usize, data: &Dataset, calibration: &Calibration) -> Vec<Part> {
        let figure = |quantity: Quantity| -> Result<f64, String> {
            let row = self.table.rows.iter().find(|row| row.quantity == quantity);
            let found: Option<&Figure> = row.map(|row| &row.cells[at].compensated);
            match found {
                Some(Ok(value)) => Ok(value.value.abs()),
                Some(Err(reason)) => Err(reason.to_string()),
                None => Err("not measured".to_owned()),
            }
        };
        let rectangular = |full: f64| full / (2.0 * 3.0_f64.sqrt());
        let zero = self.zeros[at].ok_or_else(|| "no recording dwells at zero".to_owned());
        vec![
            (Source::Resolution, resolution(at, data, calibration)),
            (Source::Zero, zero),
            (
                Source::Repeatability,
                figure(Quantity::Repeatability).map(rectangular),
            ),
            (
                Source::Reversibility,
                figure(Quantity::MeanWidth).map(|width| width / 2.0),
            ),
            (Source::Creep, figure(Quantity::Creep).map(rectangular)),
        ]
    }
}

/// For each axis the root mean square of the mean errors of the dwells at zero.
fn zeros(held: &[Dwell], runs: &[Run<'_>], n_axes: usize) -> Vec<Option<f64>> {
    let at_zero: Vec<&Dwell> = held.iter().filter(|dwell| dwell.at_zero).collect();
    let of_axis = |at: usize| {
        let squares = at_zero.iter().map(|dwell| {
            let run = &runs[dwell.place.recording];
            let errors = dwell
                .place
                .samples
                .clone()
                .map(|k| run.compensated[k * n_axes + at] - run.reference[k * n_axes + at]);
            (errors.sum::<f64>() / dwell.place.samples.len() as f64).powi(2)
        });
        (!at_zero.is_empty()).then(|| (squares.sum::<f64>() / at_zero.len() as f64).sqrt())
    };
    (0..n_axes).map(of_axis).collect()
}

/// What the steps of the gauges make of a load.
fn resolution(at: usize, data: &Dataset, calibration: &Calibration) -> Result<f64, String> {
    let recordings: Vec<&Recording> = data
        .entries
        .iter()
        .filter(|entry| entry.role != Role::Off)
        .map(|entry| &*entry.recording)
        .collect();
    let least = |gauge: usize| {
        let steps = recordings.iter().filter_map(|own| own.resolution(gauge));
        steps.reduce(f64::min)
    };
    let row = &calibration.conventional.matrix[at];
    let squares = (0..calibration.gauges.len())
        .filter_map(|gauge| Some((row[gauge] * least(gauge)?).powi(2) / 12.0));
    let sum: f64 = squares.sum();
    match sum > 0.0 {
        true => Ok(sum.sqrt()),
        false => Err("the gauges move by no steps of one size".to_owned()),
    }
}
