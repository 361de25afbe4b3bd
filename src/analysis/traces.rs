//! What the trace panes draw: Calc., Conv. and Comp. of the recordings on screen, end to end.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::analysis::factory::Factory;
use crate::calibration::{Calibration, Past};
use crate::evaluation::Series;
use crate::features::{Distance, Thresholds};
use crate::recording::{Axis, Entry, Recording};
use crate::report::Trace;

/// Which recordings are on screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// This one.
    One(usize),
    /// All of them, end to end.
    #[default]
    All,
}

impl View {
    /// This view, or the last recording where it names one that is not there.
    pub fn within(self, n_recordings: usize) -> Self {
        match self {
            Self::One(at) => Self::One(at.min(n_recordings.saturating_sub(1))),
            Self::All => Self::All,
        }
    }

    fn recordings(self, n_recordings: usize) -> Range<usize> {
        match self {
            Self::One(at) => at..(at + 1).min(n_recordings),
            Self::All => 0..n_recordings,
        }
    }
}

/// One recording's place in the traces.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Its index in the set.
    pub recording: usize,
    /// Its name.
    pub name: String,
    /// Its samples, counted over the traces.
    pub samples: Range<usize>,
    /// Added to a time on the axis, this gives the time on the recording's own clock (s).
    pub clock_offset_secs: f64,
}

/// The traces of one axis.
#[derive(Clone, Debug)]
pub struct AxisTraces {
    /// The axis.
    pub axis: Axis,
    /// Calc.: the true load; `None` where one of the recordings has no reference for it.
    pub calculated: Option<Arc<Series>>,
    /// Conv.: from the present gauges.
    pub conventional: Arc<Series>,
    /// Comp.: with what the past adds.
    pub compensated: Arc<Series>,
    /// Conv. − Calc.
    pub conventional_error: Option<Arc<Series>>,
    /// Comp. − Calc.
    pub compensated_error: Option<Arc<Series>>,
    /// From the present gauges by the factory's matrix, where there is one with this axis.
    pub factory: Option<Arc<Series>>,
    /// That less Calc.
    pub factory_error: Option<Arc<Series>>,
    /// Comp. less and plus two standard deviations, where the regressor knows them.
    pub band: Option<[Arc<Series>; 2]>,
}

impl AxisTraces {
    /// One of the loads, where it is there.
    pub fn load(&self, trace: Trace) -> Option<&Arc<Series>> {
        match trace {
            Trace::Calculated => self.calculated.as_ref(),
            Trace::Conventional => Some(&self.conventional),
            Trace::Compensated => Some(&self.compensated),
            Trace::Factory => self.factory.as_ref(),
        }
    }

    /// How far it is from the true one.
    pub fn error(&self, trace: Trace) -> Option<&Arc<Series>> {
        match trace {
            Trace::Calculated => None,
            Trace::Conventional => self.conventional_error.as_ref(),
            Trace::Compensated => self.compensated_error.as_ref(),
            Trace::Factory => self.factory_error.as_ref(),
        }
    }
}

/// Everything that is drawn over time.
#[derive(Clone, Debug)]
pub struct TraceSet {
    /// Which recordings it shows.
    pub view: View,
    /// The recordings in order of time.
    pub segments: Arc<[Segment]>,
    /// Time on the axis of each sample (s): the first recording starts at zero, each next follows after one step.
    pub times: Arc<[f64]>,
    /// The past sample of each sample by the first look-back, counted over the traces; without a look-back its own.
    pub past: Arc<[u32]>,
    /// Stretches of samples that are their own past, where there is a look-back.
    pub without_past: Arc<[Range<usize>]>,
    /// One entry per axis of the calibration.
    pub axes: Vec<AxisTraces>,
    /// The thresholds that picked the past; `None` without a look-back.
    pub thresholds: Option<Thresholds>,
    /// What F_th is measured in.
    pub distance: Distance,
    /// What the difference on each axis is multiplied by before its norm is compared with F_th.
    pub weights: Vec<f64>,
}

impl TraceSet {
    /// The segment that sample `k` belongs to.
    pub fn segment_of(&self, k: usize) -> Option<&Segment> {
        let at = self
            .segments
            .partition_point(|segment| segment.samples.end <= k);
        self.segments.get(at)
    }

    /// The sample nearest in time.
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

    /// The recordings on screen, each with its own samples in a interval of time; `None` for all.
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

    /// d(k, j): how different the conventional load of two samples is, in the unit of F_th.
    pub fn distance_between(&self, k: usize, j: usize) -> f64 {
        self.axes
            .iter()
            .zip(&self.weights)
            .map(|(axis, weight)| {
                let difference = axis.conventional.value(k) - axis.conventional.value(j);
                (difference * weight).powi(2)
            })
            .sum::<f64>()
            .sqrt()
    }
}

/// The part of the traces that a moved threshold leaves as it is.
#[derive(Debug)]
pub(super) struct FixedTraces {
    view: View,
    segments: Arc<[Segment]>,
    times: Arc<[f64]>,
    axes: Vec<FixedAxis>,
}

#[derive(Debug)]
struct FixedAxis {
    axis: Axis,
    truth: Option<Arc<[f64]>>,
    calculated: Option<Arc<Series>>,
    conventional: Arc<Series>,
    conventional_error: Option<Arc<Series>>,
    factory: Option<Arc<Series>>,
    factory_error: Option<Arc<Series>>,
}

impl FixedTraces {
    pub(super) fn view(&self) -> View {
        self.view
    }

    pub(super) fn new(
        view: View,
        entries: &[Entry],
        loads: &[Vec<f64>],
        axes: &[Axis],
        factory: Option<&Factory>,
    ) -> Self {
        let shown = view.recordings(entries.len());
        let (segments, times) = end_to_end(shown.clone(), entries);
        let axes = axes
            .iter()
            .enumerate()
            .map(|(column, &axis)| {
                let column_in =
                    |recording: &Recording| recording.axes().iter().position(|own| *own == axis);
                let has_truth = shown
                    .clone()
                    .all(|at| column_in(&entries[at].recording).is_some());
                let conventional = gathered(shown.clone(), |at| (&loads[at], column, axes.len()));
                let truth = has_truth.then(|| {
                    gathered(shown.clone(), |at| {
                        let recording = &entries[at].recording;
                        let column = column_in(recording).expect("every recording has the axis");
                        (recording.loads(), column, recording.axes().len())
                    })
                });
                let factory = factory.and_then(|factory| {
                    let loads = shown.clone().map(|at| factory.load(at, axis));
                    let loads: Option<Vec<_>> = loads.collect();
                    Some(loads?.into_iter().flatten().collect::<Arc<[f64]>>())
                });
                let factory_error = factory.clone().zip(truth.clone());
                FixedAxis {
                    axis,
                    factory: factory.map(|factory| Arc::new(Series::new(factory))),
                    factory_error: factory_error
                        .map(|(load, truth)| Arc::new(Series::difference(load, truth))),
                    calculated: truth.clone().map(|truth| Arc::new(Series::new(truth))),
                    conventional_error: truth.clone().map(|truth| {
                        Arc::new(Series::difference(Arc::clone(&conventional), truth))
                    }),
                    truth,
                    conventional: Arc::new(Series::new(conventional)),
                }
            })
            .collect();
        Self {
            view,
            segments: segments.into(),
            times: times.into(),
            axes,
        }
    }

    /// Adds what the past decides.
    pub(super) fn with_past(
        &self,
        entries: &[Entry],
        calibration: &Calibration,
        past: &[Past],
    ) -> TraceSet {
        let n_axes = self.axes.len();
        let loads: Vec<Vec<f64>> = self
            .segments
            .par_iter()
            .map(|segment| {
                let at = segment.recording;
                calibration.compensated_loads(&entries[at].recording, &past[at])
            })
            .collect();
        let deviations: Option<Vec<Vec<f64>>> = self
            .segments
            .par_iter()
            .map(|segment| {
                let at = segment.recording;
                calibration.deviations(&entries[at].recording, &past[at])
            })
            .collect();
        let column_of = |tables: &[Vec<f64>], column: usize| -> Arc<[f64]> {
            let values = tables
                .iter()
                .flat_map(|table| table.iter().skip(column).step_by(n_axes));
            values.copied().collect()
        };
        let axes =
            self.axes
                .par_iter()
                .enumerate()
                .map(|(column, fixed)| {
                    let compensated = column_of(&loads, column);
                    let band = deviations.as_ref().map(|deviations| {
                        let deviations = column_of(deviations, column);
                        [-2.0, 2.0].map(|factor| {
                            let values = compensated.iter().zip(&*deviations);
                            let edge = values.map(|(load, deviation)| load + factor * deviation);
                            Arc::new(Series::new(edge.collect()))
                        })
                    });
                    AxisTraces {
                        axis: fixed.axis,
                        calculated: fixed.calculated.clone(),
                        conventional: Arc::clone(&fixed.conventional),
                        compensated_error: fixed.truth.clone().map(|truth| {
                            Arc::new(Series::difference(Arc::clone(&compensated), truth))
                        }),
                        compensated: Arc::new(Series::new(compensated)),
                        conventional_error: fixed.conventional_error.clone(),
                        factory: fixed.factory.clone(),
                        factory_error: fixed.factory_error.clone(),
                        band,
                    }
                })
                .collect();
        let thresholds = calibration.features.look_backs.first().copied();
        let past: Arc<[u32]> = match thresholds {
            None => (0..self.times.len() as u32).collect(),
            Some(_) => self
                .segments
                .iter()
                .flat_map(|segment| {
                    let first = segment.samples.start as u32;
                    past[segment.recording][0].iter().map(move |j| first + j)
                })
                .collect(),
        };
        TraceSet {
            view: self.view,
            segments: Arc::clone(&self.segments),
            times: Arc::clone(&self.times),
            without_past: match thresholds {
                Some(_) => stretches_without_past(&past, &self.segments),
                None => Arc::new([]),
            },
            past,
            axes,
            thresholds,
            distance: calibration.features.distance,
            weights: calibration.distance_weights(),
        }
    }
}

/// One column of row-major tables `(values, column, width)`, table after table.
fn gathered<'a>(
    tables: Range<usize>,
    table: impl Fn(usize) -> (&'a [f64], usize, usize),
) -> Arc<[f64]> {
    let mut gathered = Vec::new();
    for at in tables {
        let (values, column, width) = table(at);
        gathered.extend(values.iter().skip(column).step_by(width));
    }
    gathered.into()
}

/// Lays recordings on one axis of time, each one step after the last.
fn end_to_end(shown: Range<usize>, entries: &[Entry]) -> (Vec<Segment>, Vec<f64>) {
    let mut segments = Vec::new();
    let mut times = Vec::new();
    for at in shown {
        let recording = &entries[at].recording;
        let step = recording.rate_hz().map_or(0.0, |rate| 1.0 / rate);
        let start = times.last().map_or(0.0, |last: &f64| last + step);
        let clock_offset_secs = recording.times()[0] - start;
        let first = times.len();
        times.extend(recording.times().iter().map(|t| t - clock_offset_secs));
        segments.push(Segment {
            recording: at,
            name: recording.name().to_owned(),
            samples: first..times.len(),
            clock_offset_secs,
        });
    }
    (segments, times)
}

/// The runs of samples that are their own past, none of them across two recordings.
fn stretches_without_past(past: &[u32], segments: &[Segment]) -> Arc<[Range<usize>]> {
    let mut intervals: Vec<Range<usize>> = Vec::new();
    for segment in segments {
        let mut open: Option<usize> = None;
        for k in segment.samples.clone() {
            match (past[k] as usize == k, open) {
                (true, None) => open = Some(k),
                (false, Some(start)) => {
                    intervals.push(start..k);
                    open = None;
                }
                _ => {}
            }
        }
        intervals.extend(open.map(|start| start..segment.samples.end));
    }
    intervals.into()
}
