//! The figures that ISO 376 and ASTM E74 ask of load steps: b, b′, f0, fc, v and LLF, where recordings hold loads of one axis alone.
//!
//! **What stands for what** the calibration is the interpolation equation, so a reading is the load that it gives and its deviation
//! is output − load. Errors, not readings, are compared, so that steps whose loads differ a little can be. A mounting is a group
//! of recordings.

use serde::Serialize;

use crate::calibration::{NormalEquations, Ridge, Terms, fit};
use crate::evaluation::metrology::{MetrologyError, Rules, Run, dwells};
use crate::features::ColumnKind;
use crate::recording::Axis;

/// Steps below this share of full scale say nothing of an error that is referred to the reading.
const LEAST_SHARE: f64 = 0.1;
/// Loads closer than this share of full scale are the same step.
const SAME_SHARE: f64 = 0.02;
/// Mountings that a spread between them takes.
const MOUNTINGS: usize = 3;
/// Readings that a lower limit factor takes.
const READINGS: usize = 10;
/// Degree of the curve that ASTM E74 fits, beyond the line that the calibration is.
const DEGREE: usize = 2;

/// One figure of load steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StepQuantity {
    /// b.
    Reproducibility,
    /// b′.
    Repeatability,
    /// fc.
    Interpolation,
    /// f0.
    Zero,
    /// v.
    Reversibility,
    /// LLF.
    LowerLimitFactor,
}

impl StepQuantity {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Reproducibility,
        Self::Repeatability,
        Self::Interpolation,
        Self::Zero,
        Self::Reversibility,
        Self::LowerLimitFactor,
    ];

    /// Symbol, name, and how it is made.
    pub fn texts(self) -> [&'static str; 3] {
        match self {
            Self::Reproducibility => [
                "b",
                "Reproducibility, rotated mounting",
                "(X_max − X_min) / X̄ · 100, rising, over the mountings (groups); the largest of the steps. ISO 376 takes three mountings",
            ],
            Self::Repeatability => [
                "b′",
                "Repeatability, same mounting",
                "|X₂ − X₁| / X̄ · 100, rising, in one mounting; the largest of the steps. ISO 376",
            ],
            Self::Interpolation => [
                "fc",
                "Interpolation",
                "(X̄ − X_a) / X_a · 100, rising, mean over the mountings, with the applied load X_a; the largest of the steps. ISO 376, the calibration being the interpolation equation",
            ],
            Self::Zero => [
                "f0",
                "Zero",
                "(i_f − i_0) / X_N · 100, zero after loading less zero before, over full scale. ISO 376",
            ],
            Self::Reversibility => [
                "v",
                "Reversibility",
                "|X_falling − X_rising| / X_rising · 100, mean over the mountings; the largest of the steps. ISO 376",
            ],
            Self::LowerLimitFactor => [
                "LLF",
                "Lower limit factor",
                "2.4 √(Σd² / (n − m − 1)), with deviations d of n rising readings from a curve of degree m = 2. ASTM E74",
            ],
        }
    }

    /// Its unit on an axis.
    pub fn unit(self, axis: Axis) -> &'static str {
        match self {
            Self::LowerLimitFactor => axis.unit(),
            Self::Zero => "% FS",
            _ => "% of reading",
        }
    }
}

/// A figure, or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepFigure {
    /// Which.
    pub quantity: StepQuantity,
    /// In its unit.
    #[serde(serialize_with = "super::number")]
    pub value: Result<f64, String>,
}

/// The figures of one axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepFigures {
    /// The axis.
    pub axis: Axis,
    /// The steps, as mean loads.
    pub levels: Vec<f64>,
    /// All figures.
    pub figures: Vec<StepFigure>,
}

/// What one held load shows.
#[derive(Clone, Copy, Debug)]
struct Reading {
    group: usize,
    run: usize,
    load: f64,
    error: f64,
    /// Whether it was reached from below, where somebody can tell.
    rising: Option<bool>,
    step: usize,
}

/// The figures of every axis; `groups` says which mounting each run is of, `compensated` of the runs is what is judged.
///
/// # Errors
/// As [`dwells`].
pub fn step_figures(
    runs: &[Run<'_>],
    groups: &[usize],
    rules: &Rules<'_>,
) -> Result<Vec<StepFigures>, MetrologyError> {
    let held = held(runs, rules)?;
    let axes = 0..rules.axes.len();
    Ok(axes.map(|at| of_axis(at, &held, groups, rules)).collect())
}

/// A run, the mean load of each axis, and the mean error of each, of every hold in the order of time.
type Held = (usize, bool, Vec<Option<f64>>, Vec<f64>);

fn held(runs: &[Run<'_>], rules: &Rules<'_>) -> Result<Vec<Held>, MetrologyError> {
    let n_axes = rules.axes.len();
    let mean_errors = |run: &Run<'_>, samples: std::ops::Range<usize>| -> Vec<f64> {
        let error = |at: usize, axis: &Axis| {
            let own = run.reference_axes.iter().position(|own| own == axis)?;
            let errors = samples.clone().map(|k| {
                run.compensated[k * n_axes + at] - run.reference[k * run.reference_axes.len() + own]
            });
            Some(errors.sum::<f64>() / samples.len() as f64)
        };
        rules
            .axes
            .iter()
            .enumerate()
            .map(|(at, axis)| error(at, axis).unwrap_or(f64::NAN))
            .collect()
    };
    let mut held: Vec<Held> = Vec::new();
    for (at, run) in runs.iter().enumerate().filter(|(_, run)| run.is_static) {
        for k in 0..run.times.len() {
            let level = |axis: &Axis| {
                let own = run.reference_axes.iter().position(|own| own == axis)?;
                Some(run.reference[k * run.reference_axes.len() + own])
            };
            held.push((
                at,
                true,
                rules.axes.iter().map(level).collect(),
                mean_errors(run, k..k + 1),
            ));
        }
    }
    for dwell in dwells(runs, rules)? {
        let (at, samples) = (dwell.place.recording, dwell.place.samples.clone());
        held.push((at, false, dwell.level, mean_errors(&runs[at], samples)));
    }
    Ok(held)
}

fn of_axis(at: usize, held: &[Held], groups: &[usize], rules: &Rules<'_>) -> StepFigures {
    let (axis, full_scale) = (rules.axes[at], rules.full_scale[at]);
    let is_alone = |level: &[Option<f64>]| {
        let others = level
            .iter()
            .zip(rules.full_scale)
            .enumerate()
            .filter(|(other, _)| *other != at);
        others.into_iter().all(|(_, (load, full))| {
            load.is_none_or(|load| load.abs() <= rules.settings.alone_share * full)
        })
    };
    let mut before: Option<(usize, f64, Option<bool>)> = None;
    let (mut readings, mut zeros): (Vec<Reading>, Vec<(usize, bool, f64)>) =
        (Vec::new(), Vec::new());
    for (run, is_static, level, errors) in held {
        let Some(load) = level[at].filter(|_| is_alone(level)) else {
            continue;
        };
        let is_zero = load.abs() <= rules.settings.zero_share * full_scale;
        // A recording that begins under load does not say where it came from; a load that stays comes from where it came before.
        let rising = before
            .filter(|(own, ..)| own == run && !is_static)
            .and_then(|(_, last, rising)| {
                match (load.abs() - last.abs()).abs() <= rules.settings.zero_share * full_scale {
                    true => rising,
                    false => Some(load.abs() > last.abs()),
                }
            });
        before = Some((*run, load, rising));
        if is_zero {
            zeros.push((*run, *is_static, errors[at]));
        } else if load.abs() >= LEAST_SHARE * full_scale {
            readings.push(Reading {
                group: groups[*run],
                run: *run,
                load,
                error: errors[at],
                rising,
                step: 0,
            });
        }
    }
    let levels = number_steps(&mut readings, SAME_SHARE * full_scale);
    let told = |quantity| StepFigure {
        quantity,
        value: figure(quantity, axis, &readings, &zeros, levels.len(), full_scale),
    };
    StepFigures {
        axis,
        figures: StepQuantity::ALL.into_iter().map(told).collect(),
        levels,
    }
}

/// Says which step each reading is of, by its load; the mean loads of the steps.
fn number_steps(readings: &mut [Reading], same: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..readings.len()).collect();
    order.sort_by(|a, b| readings[*a].load.total_cmp(&readings[*b].load));
    let mut steps: Vec<(f64, usize)> = Vec::new();
    for at in order {
        let load = readings[at].load;
        match steps.last_mut() {
            Some((sum, n)) if load - *sum / *n as f64 <= same => {
                *sum += load;
                *n += 1;
            }
            _ => steps.push((load, 1)),
        }
        readings[at].step = steps.len() - 1;
    }
    steps.into_iter().map(|(sum, n)| sum / n as f64).collect()
}

fn figure(
    quantity: StepQuantity,
    axis: Axis,
    readings: &[Reading],
    zeros: &[(usize, bool, f64)],
    n_steps: usize,
    full_scale: f64,
) -> Result<f64, String> {
    let symbol = axis.symbol();
    if full_scale <= 0.0 {
        return Err(format!("{symbol} has no full scale"));
    }
    if quantity == StepQuantity::Zero {
        let pairs = zeros
            .windows(2)
            .filter(|pair| pair[0].0 == pair[1].0 && !pair[0].1);
        let largest = pairs
            .map(|pair| (pair[1].2 - pair[0].2).abs())
            .reduce(f64::max);
        return largest
            .map(|change| 100.0 * change / full_scale)
            .ok_or_else(|| {
                format!("no recording dwells at zero before and after a load of {symbol} alone")
            });
    }
    if readings.is_empty() {
        return Err(format!("no recording holds a load of {symbol} alone"));
    }
    // Load cases do not say where they came from; they count as rising.
    let rising = |own: &&Reading| own.rising != Some(false);
    let of_step = |step: usize| readings.iter().filter(move |own| own.step == step);
    let largest = |of: &dyn Fn(usize) -> Option<f64>| {
        (0..n_steps)
            .filter_map(of)
            .reduce(|a, b| if b.abs() > a.abs() { b } else { a })
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let load_of = |step: usize| mean(&of_step(step).map(|own| own.load).collect::<Vec<_>>());
    // By mounting, the mean error of the step.
    let by_group = |step: usize| -> Vec<f64> {
        let mut seen: Vec<(usize, Vec<f64>)> = Vec::new();
        for own in of_step(step).filter(rising) {
            match seen.iter_mut().find(|(group, _)| *group == own.group) {
                Some((_, errors)) => errors.push(own.error),
                None => seen.push((own.group, vec![own.error])),
            }
        }
        seen.iter().map(|(_, errors)| mean(errors)).collect()
    };
    let percent = |error: f64, reading: f64| 100.0 * error / reading;
    match quantity {
        StepQuantity::Reproducibility => {
            let spread = |step: usize| {
                let errors = by_group(step);
                let high = errors.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let low = errors.iter().copied().fold(f64::INFINITY, f64::min);
                let reading = (load_of(step) + mean(&errors)).abs();
                (errors.len() >= MOUNTINGS).then(|| percent(high - low, reading))
            };
            largest(&spread)
                .ok_or_else(|| format!("no step of {symbol} alone is held in {MOUNTINGS} groups"))
        }
        StepQuantity::Repeatability => {
            let spread = |step: usize| {
                let own: Vec<&Reading> = of_step(step).filter(rising).collect();
                let pairs = own.iter().enumerate().flat_map(|(at, first)| {
                    own[at + 1..].iter().map(move |second| (first, second))
                });
                let pairs = pairs.filter(|(first, second)| first.group == second.group);
                let spread = pairs.map(|(first, second)| {
                    let reading =
                        (first.load + second.load + first.error + second.error).abs() / 2.0;
                    percent((first.error - second.error).abs(), reading)
                });
                spread.reduce(f64::max)
            };
            largest(&spread)
                .ok_or_else(|| format!("no step of {symbol} alone is held twice in one group"))
        }
        StepQuantity::Interpolation => {
            let off = |step: usize| {
                let errors = by_group(step);
                (!errors.is_empty()).then(|| percent(mean(&errors), load_of(step).abs()))
            };
            largest(&off).ok_or_else(|| format!("no rising step of {symbol} alone is held"))
        }
        StepQuantity::Reversibility => {
            let off = |step: usize| {
                let pair = |up: &Reading| {
                    let mut same = of_step(step);
                    let down = same.find(|own| own.run == up.run && own.rising == Some(false))?;
                    Some(percent(
                        (down.error - up.error).abs(),
                        (up.load + up.error).abs(),
                    ))
                };
                let ups = of_step(step).filter(|own| own.rising == Some(true));
                let all: Vec<f64> = ups.filter_map(pair).collect();
                (!all.is_empty()).then(|| mean(&all))
            };
            largest(&off).ok_or_else(|| {
                format!(
                    "no step of {symbol} alone is held both rising and falling in one recording"
                )
            })
        }
        StepQuantity::LowerLimitFactor => {
            let own: Vec<&Reading> = readings.iter().filter(rising).collect();
            if own.len() < READINGS || n_steps <= DEGREE + 1 {
                return Err(format!(
                    "{} rising readings of {n_steps} steps of {symbol} alone, where {READINGS} of more than {} are needed",
                    own.len(),
                    DEGREE + 1
                ));
            }
            Ok(2.4 * deviation(&own, full_scale))
        }
        StepQuantity::Zero => unreachable!("it was answered above"),
    }
}

/// The standard deviation of readings from a curve through them: what is off from the applied load is fitted, which is the same.
fn deviation(readings: &[&Reading], full_scale: f64) -> f64 {
    const COLUMNS: usize = DEGREE + 1;
    let mut sums = NormalEquations::new(COLUMNS, 1);
    let mut row = vec![0.0; sums.stride()];
    for own in readings {
        let x = own.load / full_scale;
        for (power, value) in row[..COLUMNS].iter_mut().enumerate() {
            *value = x.powi(power as i32);
        }
        row[COLUMNS] = own.error;
        sums.add_rows(&row);
    }
    let used: Vec<usize> = (0..COLUMNS).collect();
    let terms = Terms {
        used: &used,
        kinds: &[ColumnKind::Gauge; COLUMNS],
        known: &[],
    };
    let found = fit(&sums, terms, Ridge::None);
    (sums.squared_residuals(&found.coefficients)[0] / (readings.len() - COLUMNS) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::loops::LoadExtent;
    use crate::evaluation::metrology::MetrologySettings;

    /// Holds these loads of Fz for ten seconds each, with these errors.
    fn run(steps: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let (mut times, mut loads, mut outputs) = (Vec::new(), Vec::new(), Vec::new());
        for (at, (load, error)) in steps.iter().enumerate() {
            for k in 0..20 {
                times.push(at as f64 * 10.0 + k as f64 * 0.5);
                loads.push(*load);
                outputs.push(load + error);
            }
        }
        (times, loads, outputs)
    }

    fn figures(runs: &[&[(f64, f64)]], is_static: bool) -> StepFigures {
        let made: Vec<_> = runs.iter().map(|steps| run(steps)).collect();
        let runs: Vec<Run<'_>> = made
            .iter()
            .map(|(times, loads, outputs)| Run {
                name: "r",
                times,
                reference_axes: &[Axis::Fz],
                reference: loads,
                conventional: outputs,
                compensated: outputs,
                is_static,
            })
            .collect();
        let rules = Rules {
            axes: &[Axis::Fz],
            full_scale: &[100.0],
            settings: &MetrologySettings::default(),
            extents: &[LoadExtent::default()],
        };
        let groups: Vec<usize> = (0..runs.len()).collect();
        step_figures(&runs, &groups, &rules).unwrap().remove(0)
    }

    fn value(of: &StepFigures, quantity: StepQuantity) -> f64 {
        let found = of
            .figures
            .iter()
            .find(|own| own.quantity == quantity)
            .unwrap();
        found
            .value
            .clone()
            .unwrap_or_else(|reason| panic!("{quantity:?}: {reason}"))
    }

    /// Three mountings of 0, 50, 100, 50, 0 N, by hand: at 50 N the rising errors are 0.1, 0.2, 0.3.
    #[test]
    fn three_mountings_by_hand() {
        use StepQuantity::*;
        let series = |up: f64| {
            [
                (0.0, 0.0),
                (50.0, up),
                (100.0, 0.0),
                (50.0, up + 0.5),
                (0.0, 0.25),
            ]
        };
        let own = [series(0.1), series(0.2), series(0.3)];
        let found = figures(&[&own[0], &own[1], &own[2]], false);
        assert_eq!(found.levels, [50.0, 100.0]);
        assert!((value(&found, Reproducibility) - 100.0 * 0.2 / 50.2).abs() < 1e-9);
        assert!((value(&found, Interpolation) - 100.0 * 0.2 / 50.0).abs() < 1e-9);
        let v: f64 = [50.1, 50.2, 50.3]
            .iter()
            .map(|up| 100.0 * 0.5 / up / 3.0)
            .sum();
        assert!((value(&found, Reversibility) - v).abs() < 1e-9);
        assert!((value(&found, Zero) - 0.25).abs() < 1e-9);
        let reason = |quantity| {
            found
                .figures
                .iter()
                .find(|own| own.quantity == quantity)
                .unwrap()
                .value
                .clone()
                .unwrap_err()
        };
        assert!(reason(Repeatability).contains("twice in one group"));
        assert!(reason(LowerLimitFactor).contains("6 rising readings of 2 steps"));
    }

    /// A parabola of errors leaves nothing over; ±0.1 N on top of it, twelve readings: s² = 12 · 0.01 / (12 − 3) less what the curve takes.
    #[test]
    fn the_lower_limit_factor_is_what_a_parabola_leaves() {
        let steps: Vec<(f64, f64)> = (1..=6)
            .map(|k| (k as f64 * 16.0, 0.001 * (k * k) as f64))
            .collect();
        let found = figures(&[&steps, &steps], false);
        assert!(value(&found, StepQuantity::LowerLimitFactor) < 1e-6);
        let off = |by: f64| -> Vec<(f64, f64)> {
            steps
                .iter()
                .map(|(load, error)| (*load, error + by))
                .collect()
        };
        let found = figures(&[&off(0.1), &off(-0.1)], false);
        let expected = 2.4 * (12.0_f64 * 0.01 / 9.0).sqrt();
        assert!((value(&found, StepQuantity::LowerLimitFactor) - expected).abs() < 1e-6);
    }

    #[test]
    fn nothing_is_said_of_loads_that_are_not_held() {
        let found = figures(&[&[(0.0, 0.0)]], false);
        assert!(found.figures.iter().all(|own| own.value.is_err()));
    }
}
