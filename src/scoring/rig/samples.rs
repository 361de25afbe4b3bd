//! Finds faults of the measuring rig that sums of products do not show: hum, a clipped reference, and more noise in one
//! recording.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::{
    finding::{Finding, Id, Verdict},
    recording::{Recording, median},
    scoring::{
        faults::are_of_one_table,
        numbers::{percent, significant},
        rig::{
            Rig,
            fits::{self, Forward, Shape},
            units,
        },
        straight_lines::bend,
    },
    shown::{counted, first},
};

use Verdict::Doubtful;

/// Maximum number of gauges that a finding names.
const NAMED: usize = 6;
/// Maximum number of samples of a recording from which its spectrum is computed.
const SPECTRUM: usize = 1024;
/// Minimum number of samples of a recording for a spectrum.
const FEWEST_SAMPLES: usize = 128;
/// Maximum number of samples of a recording from which its noise is computed. Of a longer recording, evenly spread samples
/// are used.
const MAX_BENDS: usize = 1 << 17;
/// Maximum number of recordings of which spectra are computed, to save time.
const SPECTRA: usize = 4;
/// Minimum share of a gauge's squared residual that is explained by a reported hum. Removing this share makes
/// the residual a tenth smaller (√0.8).
const SHARE: f64 = 0.2;
/// The highest frequency of a load is taken as the frequency below which this share of its spectral power lies. A hum has a
/// higher frequency.
const OF_LOAD: f64 = 0.99;
/// Minimum rise of the load that the gauges predict while the reference stays at its maximum, for a report that it is
/// clipped. The mean rise is multiplied by the root of the number of such stays and divided by the error of the fit. Without
/// clipping, this number has the mean −0.8 and the standard deviation 1.2, so it exceeds 3 once in a thousand cases.
const RISES: f64 = 3.0;
/// Minimum number of other peaks (reversals) of a load, for a judgement on whether its peaks differ.
const FEWEST_PEAKS: usize = 5;
/// Minimum mean excess of the predicted over the recorded load where the recorded load is at its maximum, for a report that
/// it is clipped. It is divided by the RMS error of the other samples. An error that is a cubic of the load is √7 = 2.65
/// times its RMS at the end of the range. Hysteresis causes up to 0.9.
const BEYOND: f64 = 2.65;
/// Maximum probability that an unclipped load returns to exactly its maximum as often as observed. Below it, the load is
/// reported as clipped.
const RECURS_BY_CHANCE: f64 = 1e-4;
/// Highest harmonic of the load's frequencies that does not count as hum. Hysteresis causes such harmonics.
const HARMONIC: usize = 3;

/// Fit of the gauges to the loads of all recordings, applied to the samples of one recording. All values are divided by the
/// gauge's scale.
struct Rest<'a> {
    rig: &'a Rig,
    of: &'a Recording,
    fit: &'a Forward,
    /// Index of each axis of the fit among the axes of the recording.
    columns: Vec<usize>,
}

impl Rest<'_> {
    fn fitted(&self, gauge: usize, k: usize) -> f64 {
        let loads = &self.of.loads()[k * self.of.axes().len()..];
        let scaled = self.columns.iter().zip(&self.rig.shape.full_scale).enumerate();
        let along = scaled.map(|(axis, (column, full_scale))| {
            self.fit.map[(gauge, 1 + axis)] * loads[*column] / full_scale
        });
        self.fit.map[(gauge, 0)] + along.sum::<f64>()
    }

    /// Returns the residual of a gauge in sample `k`.
    fn left(&self, gauge: usize, k: usize) -> f64 {
        let (mean, scale) = self.rig.scales[gauge];
        (self.of.gauges_at(k)[gauge] - mean) / scale - self.fitted(gauge, k)
    }
}

impl Rig {
    fn rest<'a>(&'a self, of: &'a Recording, fit: &'a Forward) -> Rest<'a> {
        Rest { rig: self, of, fit, columns: self.shape.axes_in(of) }
    }

    /// Returns the noise of each gauge in each run, divided by the gauge's scale. It follows from the deviation of three
    /// successive residuals from a straight line. For static load cases, it follows from the residuals themselves.
    pub(super) fn noise(&self, recordings: &[&Recording]) -> Vec<Vec<f64>> {
        let fit = Forward::of(&self.total(|_| true), &self.shape);
        let of_run = |run: &Vec<usize>| {
            let all: Vec<Rest> = run.iter().map(|at| self.rest(recordings[*at], &fit)).collect();
            let of_gauge = |gauge: usize| {
                let sizes = all.iter().flat_map(|rest| {
                    let left = move |k: usize| rest.left(gauge, k);
                    let is_static = rest.of.is_static();
                    let size = move |k: usize| {
                        if is_static {
                            left(k).abs()
                        } else {
                            bend([left(k), left(k + 1), left(k + 2)])
                        }
                    };
                    let n = rest.of.n_samples();
                    let last = n.saturating_sub(if is_static { 0 } else { 2 });
                    (0..last).step_by(n.div_ceil(MAX_BENDS).max(1)).map(size)
                });
                deviation(sizes)
            };
            (0..self.shape.n_gauges).map(of_gauge).collect()
        };
        self.runs.iter().map(of_run).collect()
    }

    /// Returns findings about single gauges or load axes in these recordings.
    pub fn channel_faults(&self, recordings: &[&Recording]) -> Vec<Finding> {
        let hum = self.hum(recordings);
        hum.into_iter().chain(self.clipped_reference(recordings)).collect()
    }

    /// Returns the finding that gauges hum: the spectrum of their residuals has a line at a frequency that the loads do not
    /// have.
    fn hum(&self, recordings: &[&Recording]) -> Option<Finding> {
        let n_gauges = self.shape.n_gauges;
        let fit = Forward::of(&self.total(|_| true), &self.shape);
        let mut lines: Vec<Vec<(f64, f64, f64)>> = vec![Vec::new(); n_gauges];
        let long = recordings.iter();
        let long = long.filter(|own| !own.is_static() && own.n_samples() >= FEWEST_SAMPLES);
        for own in long.take(SPECTRA) {
            let rest = self.rest(own, &fit);
            let n = own.n_samples().min(SPECTRUM);
            let rate = (n - 1) as f64 / (own.times()[n - 1] - own.times()[0]);
            let n_axes = own.axes().len();
            let highest = (0..n_axes)
                .map(|axis| highest(&powers(n, 0..n / 2, |k| own.loads()[k * n_axes + axis])))
                .max()
                .unwrap_or(0);
            for (gauge, lines) in lines.iter_mut().enumerate() {
                let left = |k: usize| rest.left(gauge, k);
                let fitted = |k: usize| rest.fitted(gauge, k);
                let power = powers(n, 0..n / 2, left);
                let all: f64 = power.iter().sum();
                let Some(peak) = (HARMONIC * highest + 4..power.len())
                    .max_by(|a, b| power[*a].total_cmp(&power[*b]))
                else {
                    continue;
                };
                let near = peak - 2..power.len().min(peak + 3);
                let share = power[near.clone()].iter().sum::<f64>() / all;
                let squares = (0..n).map(|k| left(k).powi(2)).sum::<f64>() / n as f64;
                let amplitude = (2.0 * share * squares).sqrt();
                let value = |k: usize| fitted(k) + left(k);
                let line =
                    |of: &dyn Fn(usize) -> f64| -> f64 { powers(n, near.clone(), of).iter().sum() };
                let steps =
                    (1..n).map(|k| (value(k) - value(k - 1)).abs()).filter(|own| *own > 1e-9);
                // If the reference is held or rounded, its own spectrum has the same line. If a gauge is rounded, a steady
                // ramp gives its spectrum a line with an amplitude of about one step of the converter.
                let is_hum = line(&value) > line(&fitted)
                    && amplitude > 2.0 * steps.fold(f64::INFINITY, f64::min);
                let share = if is_hum { share } else { 0.0 };
                let amplitude = amplitude / self.spans[gauge];
                lines.push((share, peak as f64 * rate / n as f64, amplitude));
            }
        }
        let is_hum = |gauge: &usize| {
            let own = &lines[*gauge];
            own.iter().filter(|own| own.0 > SHARE).count() * 2 > own.len()
        };
        let gauges: Vec<usize> = (0..n_gauges).filter(is_hum).collect();
        let lines: Vec<_> =
            gauges.iter().flat_map(|at| &lines[*at]).filter(|own| own.0 > SHARE).collect();
        let amplitude = lines.iter().map(|own| own.2).fold(0.0, f64::max);
        let hz = median(lines.iter().map(|own| own.1))?;
        let names = gauges.iter().map(|gauge| &recordings[0].gauge_names()[*gauge]);
        let (names, hz) = (first(NAMED, names), significant(hz, 3));
        let seen = format!(
            "the signals of {names} hum at {hz} Hz, a frequency that the load does not have"
        );
        let figures =
            format!("the amplitude of the hum is {} of the gauge's range", percent(amplitude));
        Some(Finding::new(Id::Hum, Doubtful, seen).with(figures).costing(amplitude))
    }

    /// Returns findings of axes whose reference load is clipped. It stays at its maximum while the gauges rise and fall
    /// again, or it returns to exactly its maximum although all its other peaks differ.
    fn clipped_reference(&self, recordings: &[&Recording]) -> Vec<Finding> {
        let shape = &self.shape;
        let back = fits::backward(&self.total(|_| true), shape);
        let mut found = Vec::new();
        for (at, axis) in shape.axes.iter().enumerate() {
            // Recorded and predicted loads as shares of full scale.
            let traces = recordings.chunk_by(|a, b| are_of_one_table(a, b)).map(|table| Trace {
                is_static: table[0].is_static(),
                samples: (table.iter().flat_map(|own| self.shown(own, at, back.row(at)))).collect(),
            });
            let traces: Vec<Trace> = traces.collect();
            let all = || traces.iter().flat_map(|own| &own.samples);
            let n = all().count().max(1) as f64;
            let mean = all().map(|(load, shown)| shown - load).sum::<f64>() / n;
            let squares = all().map(|(load, shown)| (shown - load - mean).powi(2)).sum::<f64>();
            let error = (squares / n).sqrt();
            let mut loads: Vec<f64> = all().map(|own| own.0).collect();
            loads.sort_unstable_by(f64::total_cmp);
            let steps = loads.windows(2).map(|own| own[1] - own[0]).filter(|step| *step > 0.0);
            let resolution = steps.fold(f64::INFINITY, f64::min);
            for outward in [-1.0, 1.0] {
                let end = all().map(|own| outward * own.0).fold(f64::NEG_INFINITY, f64::max);
                let peaks: Vec<Vec<Peak>> = traces.iter().map(|own| own.peaks(outward)).collect();
                let visits = || peaks.iter().flatten().filter(|own| own.load == end);
                let rises: Vec<f64> = visits().filter_map(|own| own.rise).collect();
                let rise = rises.iter().sum::<f64>() / rises.len().max(1) as f64;
                let is_risen =
                    rise * (rises.len() as f64).sqrt() > RISES * error && rise > resolution;
                if !is_risen && !recurs(&peaks, end, resolution) {
                    continue;
                }
                let (excess, error) = self.excess(recordings, at, outward * end);
                if outward * excess > BEYOND * error {
                    let load = significant(outward * end * shape.full_scale[at], 4);
                    let seen = format!(
                        "the reference of {} seems clipped: it stays at {load} {} while the gauges rise further",
                        axis.symbol(),
                        axis.unit()
                    );
                    let figures = format!(
                        "this happens {}, and the gauges rise further by {} of full scale on average",
                        counted(visits().count(), "time"),
                        percent(excess.abs())
                    );
                    let found_here = Finding::new(Id::ReferenceClipped, Doubtful, seen);
                    found.push(found_here.with(figures).costing(excess.abs()));
                }
            }
        }
        found
    }

    /// Returns the mean excess of the predicted over the recorded load where the recorded load is `end`, and the RMS error
    /// of the other samples. The prediction from the gauges, their squares and cubes is fitted to the other samples.
    fn excess(&self, recordings: &[&Recording], axis: usize, end: f64) -> (f64, f64) {
        let shape = Shape { n_gauges: 3 * self.shape.n_gauges, ..self.shape.clone() };
        let column = shape.axes_in(recordings[0])[axis];
        let sums_of = |wanted: bool| {
            let is_used = |own: usize, k: usize| {
                let own = recordings[own];
                let load = own.loads()[k * own.axes().len() + column];
                (load / shape.full_scale[axis] == end) == wanted
            };
            let powers = |gauges: &[f64], row: &mut Vec<f64>| {
                let all =
                    (1..=3).flat_map(|power| self.standard(gauges).map(move |own| own.powi(power)));
                row.extend(all);
            };
            fits::sum(units(recordings, &self.runs, &shape, powers, is_used).iter(), &shape)
        };
        fits::excess(&sums_of(false), &sums_of(true), axis, &shape)
    }

    /// Returns for each sample the load of an axis and its prediction from the gauges, as shares of full scale.
    fn shown(
        &self,
        of: &Recording,
        axis: usize,
        back: faer::RowRef<'_, f64>,
    ) -> impl Iterator<Item = (f64, f64)> {
        let at = self.shape.axes_in(of)[axis];
        let rows = of.gauges().chunks_exact(self.shape.n_gauges);
        let loads = of.loads()[at..].iter().step_by(of.axes().len());
        loads.zip(rows).map(move |(load, row)| {
            let shown = self.standard(row).enumerate().map(|(at, own)| back[at] * own);
            (load / self.shape.full_scale[axis], shown.sum())
        })
    }
}

/// Recorded and predicted loads of one axis, in a recording or a table of load cases.
struct Trace {
    is_static: bool,
    samples: Vec<(f64, f64)>,
}

/// Peak of a load: load at which an axis reverses its direction, or a static load case.
struct Peak {
    load: f64,
    /// Rise of the load that the gauges predict, while the recorded load stays at the peak. `None` if it stays for less than
    /// three samples.
    rise: Option<f64>,
}

impl Trace {
    /// Returns the upper peaks of the load (`outward` = 1) or the lower ones (−1).
    fn peaks(&self, outward: f64) -> Vec<Peak> {
        let stays: Vec<&[(f64, f64)]> = match self.is_static {
            true => self.samples.chunks(1).collect(),
            false => self.samples.chunk_by(|a, b| a.0 == b.0).collect(),
        };
        let load = |at: usize| stays.get(at).map(|own| outward * own[0].0);
        let is_peak = |at: &usize| {
            let beside = [load(at + 1), at.checked_sub(1).and_then(load)];
            self.is_static || beside.into_iter().flatten().all(|own| Some(own) < load(*at))
        };
        let peak = |at: usize| Peak {
            load: outward * stays[at][0].0,
            rise: (stays[at].len() > 2)
                .then(|| rise(stays[at].iter().map(|own| outward * own.1).collect())),
        };
        (0..stays.len()).filter(is_peak).map(peak).collect()
    }
}

/// Returns true if a load returns to exactly its maximum more often than chance explains, although its other peaks all
/// differ. Loads that are set to nominal values are excluded, because they also repeat their smaller values.
fn recurs(peaks: &[Vec<Peak>], end: f64, resolution: f64) -> bool {
    let again =
        |own: &Vec<Peak>| own.iter().filter(|own| own.load == end).count().saturating_sub(1);
    let again: usize = peaks.iter().map(again).sum();
    let others = peaks.iter().flatten().map(|own| own.load);
    let mut others: Vec<f64> = others.filter(|load| *load < end).collect();
    let n = others.len();
    others.sort_by(f64::total_cmp);
    let least = others.first().copied().unwrap_or(end);
    others.dedup();
    let expected = n as f64 * resolution / (end - least);
    again > 0
        && n >= FEWEST_PEAKS
        && 10 * others.len() > 9 * n
        && expected.powi(again as i32) < RECURS_BY_CHANCE
}

/// Returns the mean of the middle half of these values in time, minus the larger of the first and the last value. For noise
/// alone, this is negative.
fn rise(values: Vec<f64>) -> f64 {
    let n = values.len();
    let skipped = (n / 4).max(1);
    let inner = &values[skipped..n - skipped];
    inner.iter().sum::<f64>() / inner.len() as f64 - values[0].max(values[n - 1])
}

/// Returns the standard deviation of normally distributed values, estimated from the median of their magnitudes.
fn deviation(sizes: impl Iterator<Item = f64>) -> f64 {
    median(sizes).unwrap_or(0.0) / 0.6745
}

/// Returns the power spectrum of `n` samples under a Hann window, for these numbers of periods in all samples.
fn powers(n: usize, periods: Range<usize>, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let mean = (0..n).map(&value).sum::<f64>() / n as f64;
    let windowed: Vec<f64> = (0..n)
        .map(|k| (value(k) - mean) * (0.5 - 0.5 * (TAU * k as f64 / n as f64).cos()))
        .collect();
    let waves: Vec<(f64, f64)> = (0..n).map(|k| (TAU * k as f64 / n as f64).sin_cos()).collect();
    let power = |periods: usize| {
        let (sin, cos) = windowed.iter().enumerate().fold((0.0, 0.0), |(sin, cos), (k, own)| {
            let wave = waves[periods * k % n];
            (sin + own * wave.0, cos + own * wave.1)
        });
        sin * sin + cos * cos
    };
    periods.map(power).collect()
}

/// Returns the index in a spectrum below which nearly all power lies ([`OF_LOAD`]).
fn highest(powers: &[f64]) -> usize {
    let all: f64 = powers.iter().sum();
    let mut below = 0.0;
    let is_above = |power: &f64| {
        below += power;
        below >= OF_LOAD * all
    };
    powers.iter().position(is_above).unwrap_or(0)
}
