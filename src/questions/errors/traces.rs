//! Traces over time that the trace panes draw: loads and errors of the recordings on screen, one recording after another.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::{
    calibration::{Calibration, Past},
    column::column,
    features::{Distance, Thresholds},
    progress::{Cancelled, Progress},
    questions::{
        dataset::Dataset,
        errors::{
            factory::Factory,
            trace_values::{Columns, Made, MadeAxis, Segment, Table},
        },
        request::View,
    },
    recording::{Axis, Entry},
    report::trace::Trace,
    scoring::{Series, numbers::significant, series::Values},
};

#[derive(Clone, Debug)]
pub struct AxisTraces {
    pub axis: Axis,
    /// Reference load; `None` if a recording on screen has no reference for this axis.
    pub calculated: Option<Arc<Series>>,
    pub conventional: Arc<Series>,
    pub compensated: Arc<Series>,
    pub conventional_error: Option<Arc<Series>>,
    pub compensated_error: Option<Arc<Series>>,
    /// Load by the factory calibration; `None` without a factory calibration of this axis.
    pub factory: Option<Arc<Series>>,
    pub factory_error: Option<Arc<Series>>,
    /// Compensated load minus and plus two standard deviations of its prediction; `None` if the regressor computes no
    /// standard deviation.
    pub band: Option<[Arc<Series>; 2]>,
}

impl AxisTraces {
    /// Returns traces with the conventional load alone, also in place of the compensated load.
    fn conventional(axis: Axis, conventional: Arc<Series>) -> Self {
        Self {
            axis,
            compensated: Arc::clone(&conventional),
            conventional,
            calculated: None,
            factory: None,
            conventional_error: None,
            factory_error: None,
            compensated_error: None,
            band: None,
        }
    }

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

#[derive(Debug)]
pub struct TraceSet {
    /// Recordings on screen, in their order on the time axis.
    pub segments: Arc<[Segment]>,
    /// Time of each sample on the time axis (s). The first recording starts at zero. Each further recording starts one time step
    /// after the previous recording.
    pub times: Arc<Vec<f64>>,
    /// True if the samples are load cases without times; the time axis then shows row numbers.
    pub is_static: bool,
    /// Earlier samples that the look-backs found, by recording; see [`Self::past_of`].
    past: Arc<Vec<Past>>,
    /// Decimation of the samples in `past`: 1, or more in a preview.
    each: usize,
    pub axes: Vec<AxisTraces>,
    /// Thresholds of the look-back, by which the earlier samples were chosen; `None` without a look-back.
    pub thresholds: Option<Thresholds>,
    /// Kind of distance between two loads that is compared with the force threshold F_th.
    pub distance: Distance,
    /// Weight of each axis in the distance between two loads that is compared with the force threshold F_th.
    pub weights: Vec<f64>,
}

impl TraceSet {
    pub fn across(&self) -> &'static str {
        if self.is_static { "row" } else { "time [s]" }
    }

    /// Returns the time of sample `k` (for load cases, its row number) as text with this number of digits.
    pub fn when(&self, k: usize, digits: usize) -> String {
        let time = significant(self.times[k], digits);
        if self.is_static { format!("row {time}") } else { format!("{time} s") }
    }

    pub fn segment_of(&self, k: usize) -> Option<&Segment> {
        let at = self.segments.partition_point(|segment| segment.samples.end <= k);
        self.segments.get(at)
    }

    /// Returns the index of the earlier sample that the first look-back finds for sample `k`, or `k` if it finds none. Both
    /// indices count all samples on screen.
    pub fn past_of(&self, k: usize) -> usize {
        let past = self.segment_of(k).and_then(|segment| {
            let first = segment.samples.start;
            let past = self.past[segment.recording].first()?;
            let at = (k - first) / self.each;
            let earlier = *past.get(at)? as usize;
            (earlier != at).then_some(first + earlier * self.each)
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

    /// Returns the index of each recording on screen, with its samples in the interval `visible` of the time axis (s); `None`
    /// means all samples.
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

    /// Returns d(k, j), the weighted distance between the conventional loads of samples `k` and `j`, in the unit of the force
    /// threshold F_th.
    pub fn distance_between(&self, k: usize, j: usize) -> f64 {
        self.distances(k, j..j + 1)[0]
    }

    /// Returns d(k, j), the distance between the conventional loads of samples `k` and `j`, for each `j` in `samples`.
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

/// Part of the traces that does not depend on the look-back thresholds.
#[derive(Debug)]
pub struct FixedTraces {
    pub view: View,
    is_static: bool,
    segments: Arc<[Segment]>,
    times: Arc<Vec<f64>>,
    /// Traces of each axis. The compensated load is not computed yet, and equals the conventional load.
    axes: Vec<AxisTraces>,
}

/// Makes all traces in one pass, so that loads that are computed on reading are read only once.
fn series_of<const N: usize>(
    values: Vec<[Option<Arc<dyn Values>>; N]>,
    progress: &Progress,
) -> Result<Vec<[Option<Arc<Series>>; N]>, Cancelled> {
    let all = values.iter().flatten().flatten().cloned().collect();
    let mut series = Series::all_of(all, progress).into_iter().map(Arc::new);
    progress.check()?;
    let of_axis = |traces: [Option<_>; N]| traces.map(|traces| traces.and_then(|_| series.next()));
    Ok(values.into_iter().map(of_axis).collect())
}

fn difference(
    load: Option<&Arc<dyn Values>>,
    truth: Option<&Arc<dyn Values>>,
) -> Option<Arc<dyn Values>> {
    Some(Series::difference(Arc::clone(load?), Arc::clone(truth?)))
}

impl FixedTraces {
    pub fn new(
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
        let values = axes.iter().zip(conventional).map(|(axis, load)| {
            let columns = shown.clone().map(|at| {
                let recording = &entries[at].recording;
                let column = recording.axes().iter().position(|known| known == axis)?;
                let table = Table::Reference(Arc::clone(recording));
                Some((table, column, recording.axes().len()))
            });
            let truth = columns.collect::<Option<_>>().map(|columns| -> Arc<dyn Values> {
                Arc::new(Columns { segments: Arc::clone(&segments), columns })
            });
            let loads = shown.clone().map(|at| factory?.load(at, *axis));
            let factory = loads.collect::<Option<Vec<_>>>().map(|loads| -> Arc<dyn Values> {
                let values: Arc<[f64]> = loads.into_iter().flatten().collect();
                Arc::new(values)
            });
            let errors =
                [Some(&load), factory.as_ref()].map(|load| difference(load, truth.as_ref()));
            let [conventional_error, factory_error] = errors;
            [Some(load), truth, factory, conventional_error, factory_error]
        });
        let series = series_of(values.collect(), progress)?;
        let axes = axes.iter().zip(series).map(|(&axis, series)| {
            let [conventional, calculated, factory, conventional_error, factory_error] = series;
            let conventional = conventional.expect("each axis has a conventional trace");
            AxisTraces {
                calculated,
                factory,
                conventional_error,
                factory_error,
                ..AxisTraces::conventional(axis, conventional)
            }
        });
        let axes = axes.collect();
        Ok(Self {
            view,
            is_static: shown.clone().any(|at| entries[at].recording.is_static()),
            segments,
            times,
            axes,
        })
    }

    /// Adds the traces that depend on the earlier samples of the look-backs, such as the compensated load.
    pub fn with_past(
        &self,
        data: &Dataset,
        calibration: &Calibration,
        past: &Arc<Vec<Past>>,
        progress: &Progress,
    ) -> Result<TraceSet, Cancelled> {
        let entries = &data.entries;
        let n_axes = self.axes.len();
        let is_made = data.kept_loads().is_none() && calibration.is_quick_anywhere();
        let loads = if is_made {
            made(&self.segments, data, calibration, Some(past))
        } else {
            let loads = self.segments.par_iter().map(|segment| {
                let at = segment.recording;
                Arc::new(calibration.compensated_loads(&entries[at].recording, &past[at]))
            });
            tables(&self.segments, n_axes, loads.collect())
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
                deviations.iter().flat_map(|table| self::column(table, n_axes, column));
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
        let values = loads.into_iter().zip(&self.axes).map(|(load, fixed)| {
            let truth = fixed.calculated.as_ref().map(|truth| &truth.values);
            let error = difference(Some(&load), truth);
            [Some(load), error]
        });
        let series = series_of(values.collect(), progress)?;
        let moving = series.into_iter().zip(bands).map(|([compensated, error], band)| Moving {
            compensated: compensated.expect("each axis has a compensated trace"),
            error,
            band,
        });
        Ok(self.with_moving(moving, calibration, past, 1))
    }

    /// Adds the traces of a preview, computed from every `each`-th sample of each recording. Each value is held until the
    /// next computed value.
    pub fn preview(
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
        let moving = self.axes.iter().enumerate().map(|(column, fixed)| {
            let load = |at: usize, sample: usize| loads[at][sample * n_axes + column];
            let truth = fixed.calculated.as_ref();
            let error = |at: usize, sample: usize| {
                load(at, sample) - self.reference(thinned, fixed.axis, at, sample)
            };
            Moving {
                compensated: self.held_series(each, load),
                error: truth.map(|_| self.held_series(each, error)),
                band: None,
            }
        });
        self.with_moving(moving, calibration, past, each)
    }

    /// Returns the traces of a preview before the first analysis, computed from every `each`-th sample of each recording.
    /// `entries` contains all samples.
    pub fn held(
        view: View,
        entries: &[Entry],
        thinned: &Dataset,
        calibration: &Calibration,
        each: usize,
    ) -> Self {
        let shown = view.recordings(entries.len());
        let (segments, times) = end_to_end(shown.clone(), entries);
        let mut fixed = Self {
            view,
            is_static: shown.clone().any(|at| entries[at].recording.is_static()),
            segments: segments.into(),
            times,
            axes: Vec::new(),
        };
        let axes = calibration.axes.iter().enumerate().map(|(column, &axis)| {
            let load = |at: usize, sample: usize| {
                thinned.present_loads(fixed.segments[at].recording).at(sample, column)
            };
            let truth = |at, sample| fixed.reference(thinned, axis, at, sample);
            let error = |at, sample| load(at, sample) - truth(at, sample);
            let has_reference =
                shown.clone().all(|at| entries[at].recording.axes().contains(&axis));
            AxisTraces {
                calculated: has_reference.then(|| fixed.held_series(each, truth)),
                conventional_error: has_reference.then(|| fixed.held_series(each, error)),
                ..AxisTraces::conventional(axis, fixed.held_series(each, load))
            }
        });
        let axes: Vec<AxisTraces> = axes.collect();
        fixed.axes = axes;
        fixed
    }

    /// Returns the reference load of a sample of the thinned recording in segment `at`; NaN without a reference.
    fn reference(&self, thinned: &Dataset, axis: Axis, at: usize, sample: usize) -> f64 {
        let loads = thinned.entries[self.segments[at].recording].recording.load(axis);
        loads.and_then(|mut loads| loads.nth(sample)).unwrap_or(f64::NAN)
    }

    /// Returns a trace whose value changes every `each` samples. `value` returns the value of a thinned sample, given the
    /// index of its segment and the thinned sample in it.
    fn held_series(&self, each: usize, value: impl Fn(usize, usize) -> f64) -> Arc<Series> {
        let n = self.times.len();
        let values = (0..n).step_by(each).map(|k| {
            let at = self.segments.partition_point(|segment| segment.samples.end <= k);
            value(at, (k - self.segments[at].samples.start) / each)
        });
        Arc::new(Series::held(values.collect(), each, n))
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
            ..fixed.clone()
        });
        let thresholds = calibration.features.look_backs.first().copied();
        TraceSet {
            segments: Arc::clone(&self.segments),
            times: Arc::clone(&self.times),
            is_static: self.is_static,
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

/// Returns the loads of each axis as one column. `loads` are row-major tables, one for each segment (recording on screen).
fn tables(
    segments: &Arc<[Segment]>,
    n_axes: usize,
    loads: Vec<Arc<Vec<f64>>>,
) -> Vec<Arc<dyn Values>> {
    let axes = (0..n_axes).map(|column| {
        let columns = loads.iter().map(|table| (Table::Loads(Arc::clone(table)), column, n_axes));
        let (segments, columns) = (Arc::clone(segments), columns.collect());
        Arc::new(Columns { segments, columns }) as Arc<dyn Values>
    });
    axes.collect()
}

/// Returns the loads of each axis as one column, whose values are computed when they are read.
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

/// Places recordings on one time axis. Each recording starts one time step after the previous recording.
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
            let shifted = recording.times().iter().map(|time| time - clock_offset_secs);
            Arc::make_mut(&mut times).extend(shifted);
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
