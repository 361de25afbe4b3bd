//! Traces that the panes draw: reference, uncompensated and compensated loads of the recordings on screen, end to end.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::calibration::{Calibration, Past};
use crate::features::{Distance, Thresholds};
use crate::progress::{Cancelled, Progress};
use crate::questions::dataset::Dataset;
use crate::questions::errors::factory::Factory;
use crate::questions::errors::trace_values::{Columns, Made, MadeAxis, Segment, Table};
use crate::questions::errors::view::View;
use crate::recording::{Axis, Entry};
use crate::report::trace::Trace;
use crate::scoring::Series;
use crate::scoring::numbers::significant;
use crate::scoring::series::Values;

#[derive(Clone, Debug)]
pub struct AxisTraces {
    pub axis: Axis,
    /// Reference load; `None` if one of the recordings has none for this axis.
    pub calculated: Option<Arc<Series>>,
    pub conventional: Arc<Series>,
    pub compensated: Arc<Series>,
    pub conventional_error: Option<Arc<Series>>,
    pub compensated_error: Option<Arc<Series>>,
    /// Load by the factory calibration, if there is one with this axis.
    pub factory: Option<Arc<Series>>,
    pub factory_error: Option<Arc<Series>>,
    /// Compensated load minus and plus two standard deviations, for regressors that know them.
    pub band: Option<[Arc<Series>; 2]>,
}

impl AxisTraces {
    pub fn load(&self, trace: Trace) -> Option<&Arc<Series>> {
        match trace {
            Trace::Calculated => self.calculated.as_ref(),
            Trace::Conventional => Some(&self.conventional),
            Trace::Compensated => Some(&self.compensated),
            Trace::Factory => self.factory.as_ref(),
        }
    }

    pub fn error(&self, trace: Trace) -> Option<&Arc<Series>> {
        match trace {
            Trace::Calculated => None,
            Trace::Conventional => self.conventional_error.as_ref(),
            Trace::Compensated => self.compensated_error.as_ref(),
            Trace::Factory => self.factory_error.as_ref(),
        }
    }
}

#[derive(Clone, Debug)]
pub struct TraceSet {
    pub view: View,
    /// Recordings in the order of time.
    pub segments: Arc<[Segment]>,
    /// Time of each sample on the axis (s). The first recording starts at zero; each next one follows after one step.
    pub times: Arc<Vec<f64>>,
    /// True for load cases, whose times are row numbers.
    pub is_static: bool,
    /// Past samples by recording; see [`Self::past_of`].
    past: Arc<Vec<Past>>,
    /// Number of samples that each past sample represents; more than one in a preview.
    each: usize,
    /// Intervals without a past sample, if there is a look-back.
    pub without_past: Arc<[Range<usize>]>,
    pub axes: Vec<AxisTraces>,
    /// Thresholds that chose the past samples; `None` without a look-back.
    pub thresholds: Option<Thresholds>,
    /// Quantity in which F_th is measured.
    pub distance: Distance,
    /// Factor of the difference on each axis, before the norm is compared with F_th.
    pub weights: Vec<f64>,
}

impl TraceSet {
    pub fn across(&self) -> &'static str {
        match self.is_static {
            true => "row",
            false => "time [s]",
        }
    }

    /// Returns the time of sample `k` as text with this number of digits.
    pub fn when(&self, k: usize, digits: usize) -> String {
        let time = significant(self.times[k], digits);
        match self.is_static {
            true => format!("row {time}"),
            false => format!("{time} s"),
        }
    }

    pub fn segment_of(&self, k: usize) -> Option<&Segment> {
        let at = self.segments.partition_point(|segment| segment.samples.end <= k);
        self.segments.get(at)
    }

    /// Returns the past sample of sample `k` by the first look-back, counted over the traces; `k` if there is none.
    pub fn past_of(&self, k: usize) -> usize {
        let past = self.segment_of(k).and_then(|segment| {
            let first = segment.samples.start;
            let past = self.past[segment.recording].first()?;
            let at = (k - first) / self.each;
            let own = *past.get(at)? as usize;
            (own != at).then_some(first + own * self.each)
        });
        past.unwrap_or(k)
    }

    pub fn sample_at(&self, time: f64) -> Option<usize> {
        let after = self.times.partition_point(|t| *t < time);
        let nearest = match after {
            0 => 0,
            _ if after == self.times.len() => after - 1,
            _ if time - self.times[after - 1] < self.times[after] - time => after - 1,
            _ => after,
        };
        (nearest < self.times.len()).then_some(nearest)
    }

    /// Returns the recordings on screen, each with its samples in an interval of time; `None` for all samples.
    pub fn on_screen(&self, visible: Option<(f64, f64)>) -> Vec<(usize, Range<usize>)> {
        let visible = match visible {
            None => 0..self.times.len(),
            Some((from, to)) => {
                let start = self.times.partition_point(|time| *time < from);
                start..self.times.partition_point(|time| *time <= to)
            }
        };
        let segments = self.segments.iter().map(|segment| {
            let first = segment.samples.start;
            let start = visible.start.max(first);
            let end = visible.end.min(segment.samples.end).max(start);
            (segment.recording, start - first..end - first)
        });
        segments.collect()
    }

    /// Returns d(k, j), the distance of the conventional loads of two samples, in the unit of F_th.
    pub fn distance_between(&self, k: usize, j: usize) -> f64 {
        self.distances(k, j..j + 1)[0]
    }

    /// Returns d(k, j) for each sample `j` in `samples`.
    pub fn distances(&self, k: usize, samples: Range<usize>) -> Vec<f64> {
        let mut sums = vec![0.0; samples.len()];
        for (axis, weight) in self.axes.iter().zip(&self.weights) {
            if *weight == 0.0 {
                continue;
            }
            let (now, mut sums) = (axis.conventional.value(k), sums.iter_mut());
            axis.conventional.each(samples.clone(), |load| {
                if let Some(sum) = sums.next() {
                    *sum += ((now - load) * weight).powi(2);
                }
            });
        }
        sums.into_iter().map(f64::sqrt).collect()
    }
}

/// Part of the traces that does not depend on thresholds.
#[derive(Debug)]
pub(crate) struct FixedTraces {
    pub(crate) view: View,
    is_static: bool,
    segments: Arc<[Segment]>,
    times: Arc<Vec<f64>>,
    axes: Vec<FixedAxis>,
}

#[derive(Debug)]
struct FixedAxis {
    truth: Option<Arc<dyn Values>>,
    /// Traces of the axis. The compensated load is still the conventional one.
    traces: AxisTraces,
}

fn next(series: &mut impl Iterator<Item = Series>, is_there: bool) -> Option<Arc<Series>> {
    series.by_ref().take(usize::from(is_there)).next().map(Arc::new)
}

impl FixedTraces {
    pub(crate) fn new(
        view: View,
        data: &Dataset,
        calibration: &Calibration,
        factory: Option<&Factory>,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let (entries, axes) = (&data.entries, &calibration.axes);
        let shown = view.recordings(entries.len());
        let (segments, times) = end_to_end(shown.clone(), entries);
        let segments: Arc<[Segment]> = segments.into();
        let conventional = match data.kept_loads() {
            Some(loads) => tables(&segments, axes.len(), loads[shown.clone()].to_vec()),
            None => made(&segments, data, calibration, None),
        };
        let truths: Vec<Option<Arc<dyn Values>>> = (axes.iter())
            .map(|axis| {
                let columns = shown.clone().map(|at| {
                    let recording = &entries[at].recording;
                    let column = recording.axes().iter().position(|own| own == axis)?;
                    let table = Table::Reference(Arc::clone(recording));
                    Some((table, column, recording.axes().len()))
                });
                let columns = columns.collect::<Option<_>>()?;
                let segments = Arc::clone(&segments);
                Some(Arc::new(Columns { segments, columns }) as Arc<dyn Values>)
            })
            .collect();
        let factories: Vec<Option<Arc<dyn Values>>> = (axes.iter())
            .map(|axis| {
                let loads = shown.clone().map(|at| factory?.load(at, *axis));
                let loads: Option<Vec<_>> = loads.collect();
                let values: Arc<[f64]> = loads?.into_iter().flatten().collect();
                Some(Arc::new(values) as Arc<dyn Values>)
            })
            .collect();
        let mut all = Vec::new();
        for ((load, truth), factory) in conventional.iter().zip(&truths).zip(&factories) {
            let loads = [Some(load), truth.as_ref(), factory.as_ref()];
            all.extend(loads.into_iter().flatten().map(Arc::clone));
            for load in [Some(load), factory.as_ref()].into_iter().flatten() {
                let error = |truth| Series::difference(Arc::clone(load), Arc::clone(truth));
                all.extend(truth.as_ref().map(error));
            }
        }
        let mut series = Series::all_of(all, progress).into_iter();
        progress.check()?;
        let axes = axes.iter().zip(truths).zip(factories);
        let axes = axes
            .map(|((&axis, truth), factory)| {
                let (has_truth, has_factory) = (truth.is_some(), factory.is_some());
                let conventional = next(&mut series, true).expect("one trace per axis");
                let traces = AxisTraces {
                    axis,
                    compensated: Arc::clone(&conventional),
                    conventional,
                    calculated: next(&mut series, has_truth),
                    factory: next(&mut series, has_factory),
                    conventional_error: next(&mut series, has_truth),
                    factory_error: next(&mut series, has_truth && has_factory),
                    compensated_error: None,
                    band: None,
                };
                FixedAxis { truth, traces }
            })
            .collect();
        Ok(Self {
            view,
            is_static: shown.clone().any(|at| entries[at].recording.is_static()),
            segments,
            times,
            axes,
        })
    }

    /// Adds the traces that depend on past samples.
    pub(crate) fn with_past(
        &self,
        data: &Dataset,
        calibration: &Calibration,
        past: &Arc<Vec<Past>>,
        progress: &Progress,
    ) -> Result<TraceSet, Cancelled> {
        let entries = &data.entries;
        let n_axes = self.axes.len();
        let is_made = data.kept_loads().is_none() && calibration.is_quick_anywhere();
        let loads = match is_made {
            true => made(&self.segments, data, calibration, Some(past)),
            false => {
                let loads = self.segments.par_iter().map(|segment| {
                    let at = segment.recording;
                    Arc::new(calibration.compensated_loads(&entries[at].recording, &past[at]))
                });
                tables(&self.segments, n_axes, loads.collect())
            }
        };
        progress.check()?;
        let deviations: Option<Vec<Vec<f64>>> = (self.segments.par_iter())
            .map(|segment| {
                let at = segment.recording;
                calibration.deviations(&entries[at].recording, &past[at])
            })
            .collect();
        let band = |column: usize, load: &Arc<dyn Values>| {
            let deviations = deviations.as_ref()?;
            let deviations =
                (deviations.iter()).flat_map(|table| table.iter().skip(column).step_by(n_axes));
            let mut loads = vec![0.0; load.n_samples()];
            load.read(0..loads.len(), &mut loads);
            let edge = |factor: f64| {
                let values = loads.iter().zip(deviations.clone());
                let values = values.map(|(load, deviation)| load + factor * deviation);
                Arc::new(Series::new(values.collect()))
            };
            Some([edge(-2.0), edge(2.0)])
        };
        let bands: Vec<_> = loads.iter().enumerate().map(|(at, load)| band(at, load)).collect();
        let mut all = Vec::new();
        for (load, fixed) in loads.into_iter().zip(&self.axes) {
            all.push(Arc::clone(&load));
            let truth = fixed.truth.as_ref();
            all.extend(truth.map(|truth| Series::difference(load, Arc::clone(truth))));
        }
        let mut series = Series::all_of(all, progress).into_iter();
        progress.check()?;
        let moving = self.axes.iter().zip(bands).map(|(fixed, band)| Moving {
            compensated: next(&mut series, true).expect("one trace per axis"),
            error: next(&mut series, fixed.truth.is_some()),
            band,
        });
        Ok(self.with_moving(moving, calibration, past, 1))
    }

    /// Adds the traces from every `each`-th sample of each recording, which represents the samples after it.
    pub(crate) fn preview(
        &self,
        thinned: &Dataset,
        calibration: &Calibration,
        past: &Arc<Vec<Past>>,
        each: usize,
    ) -> TraceSet {
        let n_axes = self.axes.len();
        let loads: Vec<Vec<f64>> = (self.segments.par_iter())
            .map(|segment| {
                let at = segment.recording;
                calibration.compensated_loads(&thinned.entries[at].recording, &past[at])
            })
            .collect();
        let n = self.times.len();
        // For each run of samples with the same value: the recording's index on screen, and the sample within it.
        let runs: Vec<(usize, usize)> = (0..n)
            .step_by(each)
            .map(|k| {
                let at = self.segments.partition_point(|segment| segment.samples.end <= k);
                (at, (k - self.segments[at].samples.start) / each)
            })
            .collect();
        let held = |value: &dyn Fn(usize, usize) -> f64| {
            let values = runs.iter().map(|(at, sample)| value(*at, *sample));
            Arc::new(Series::held(values.collect(), each, n))
        };
        let moving = self.axes.iter().enumerate().map(|(column, fixed)| {
            let load = |at: usize, sample: usize| loads[at][sample * n_axes + column];
            let truth = fixed.truth.as_ref();
            Moving {
                compensated: held(&load),
                error: truth.map(|_| {
                    held(&|at, sample| {
                        let recording = &thinned.entries[self.segments[at].recording].recording;
                        let axes = recording.axes();
                        let own = axes.iter().position(|axis| *axis == fixed.traces.axis);
                        let truth = own.map(|own| recording.loads()[sample * axes.len() + own]);
                        load(at, sample) - truth.unwrap_or(f64::NAN)
                    })
                }),
                band: None,
            }
        });
        self.with_moving(moving, calibration, past, each)
    }

    fn with_moving(
        &self,
        moving: impl Iterator<Item = Moving>,
        calibration: &Calibration,
        past: &Arc<Vec<Past>>,
        each: usize,
    ) -> TraceSet {
        let axes = self.axes.iter().zip(moving).map(|(fixed, moving)| AxisTraces {
            compensated: moving.compensated,
            compensated_error: moving.error,
            band: moving.band,
            ..fixed.traces.clone()
        });
        let thresholds = calibration.features.look_backs.first().copied();
        TraceSet {
            view: self.view,
            segments: Arc::clone(&self.segments),
            times: Arc::clone(&self.times),
            is_static: self.is_static,
            without_past: match thresholds {
                Some(_) => intervals_without_past(past, each, &self.segments),
                None => Arc::new([]),
            },
            past: Arc::clone(past),
            each,
            axes: axes.collect(),
            thresholds,
            distance: calibration.features.distance,
            weights: calibration.distance_weights(),
        }
    }
}

struct Moving {
    compensated: Arc<Series>,
    error: Option<Arc<Series>>,
    band: Option<[Arc<Series>; 2]>,
}

/// Returns the axes of row-major loads, one table for each segment.
fn tables(
    segments: &Arc<[Segment]>,
    n_axes: usize,
    loads: Vec<Arc<Vec<f64>>>,
) -> Vec<Arc<dyn Values>> {
    let axes = (0..n_axes).map(|column| {
        let columns = loads.iter().map(|own| (Table::Loads(Arc::clone(own)), column, n_axes));
        let (segments, columns) = (Arc::clone(segments), columns.collect());
        Arc::new(Columns { segments, columns }) as Arc<dyn Values>
    });
    axes.collect()
}

/// Returns the axes of loads that are computed when needed.
fn made(
    segments: &Arc<[Segment]>,
    data: &Dataset,
    calibration: &Calibration,
    past: Option<&Arc<Vec<Past>>>,
) -> Vec<Arc<dyn Values>> {
    let recordings = segments.iter().map(|segment| &data.entries[segment.recording].recording);
    let recordings = recordings.map(Arc::clone).collect();
    let made = Arc::new(Made::new(segments, recordings, calibration, past.map(Arc::clone)));
    let axes = (0..calibration.axes.len()).map(|axis| {
        let made = Arc::clone(&made);
        Arc::new(MadeAxis { made, axis }) as Arc<dyn Values>
    });
    axes.collect()
}

/// Places recordings on one axis of time, each one step after the last.
fn end_to_end(shown: Range<usize>, entries: &[Entry]) -> (Vec<Segment>, Arc<Vec<f64>>) {
    let mut segments = Vec::new();
    let mut times = Arc::<Vec<f64>>::default();
    let n_shown = shown.len();
    for at in shown {
        let recording = &entries[at].recording;
        let step = recording.rate_hz().map_or(0.0, |rate| 1.0 / rate);
        let start = times.last().map_or(0.0, |last| last + step);
        let clock_offset_secs = recording.times()[0] - start;
        let first = times.len();
        if n_shown == 1 && clock_offset_secs == 0.0 {
            times = recording.shared_times();
        } else {
            let own = recording.times().iter().map(|time| time - clock_offset_secs);
            Arc::make_mut(&mut times).extend(own);
        }
        segments.push(Segment {
            recording: at,
            name: recording.name().to_owned(),
            samples: first..times.len(),
            clock_offset_secs,
        });
    }
    (segments, times)
}

/// Returns the runs of samples without a past sample; no run crosses two recordings.
fn intervals_without_past(past: &[Past], each: usize, segments: &[Segment]) -> Arc<[Range<usize>]> {
    let mut intervals: Vec<Range<usize>> = Vec::new();
    for segment in segments {
        let over = |at: usize| (segment.samples.start + at * each).min(segment.samples.end);
        let own = &past[segment.recording][0];
        let mut from = 0;
        let is_own = |at: &usize| own[*at] as usize == *at;
        while let Some(start) = (from..own.len()).find(is_own) {
            let end = (start..own.len()).find(|at| !is_own(at)).unwrap_or(own.len());
            intervals.push(over(start)..over(end));
            from = end;
        }
    }
    intervals.into()
}
